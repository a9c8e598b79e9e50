//! Telemetry: follows where the robot is and how sure that is, hands the frames that are due to the link, and drops what
//! the line cannot take.

use core::sync::atomic::Ordering;

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Instant, Timer};
use shared_proto::{Pose, Telemetry, WheelPair};

use crate::dead_reckoning::DeadReckoning;
use crate::pose_covariance::PoseCovariance;
use crate::shared::{OdometryOrder, Shared, Tick};
use crate::units::{CONTROL_PERIOD_US, Travel};

/// Dead reckoning takes a step at least this often \[us\].
const STEP_US: u64 = 10_000;

/// A tick whose encoders were read this long ago is complete \[us\].
const COMPLETE_US: u64 = CONTROL_PERIOD_US as u64 / 4;

/// Passes telemetry frames to the link, for ever. On a busy line they are dropped first: nothing waits for
/// them. Frames that were sent are kept for a while, in case the host asks again.
///
/// This task wakes by the clock, shortly after a tick that is due: to wake it, the control tick would have to work.
pub async fn run<M: RawMutex>(shared: &Shared<M>) -> ! {
    let mut odometry = Odometry::START;
    let mut schedule = Schedule { period: 0, number: 0 };
    loop {
        let next = step(shared, &mut odometry, &mut schedule);
        Timer::at(next).await;
    }
}

/// Where the robot is, and how sure that is.
struct Odometry {
    reckoning: DeadReckoning,
    covariance: PoseCovariance,
}

impl Odometry {
    const START: Self = Self { reckoning: DeadReckoning::new(), covariance: PoseCovariance::new() };

    /// The wheels' travel is now this; returns where the robot is.
    fn follow(&mut self, travel: WheelPair<Travel>, order: Option<OdometryOrder>) -> Pose {
        let Self { reckoning, covariance } = self;
        if order.is_none() {
            reckoning.step(travel);
        }
        let pose = reckoning.pose();
        match order {
            Some(OdometryOrder::Pause) => {
                reckoning.pause();
                covariance.pause();
            }
            Some(OdometryOrder::With(geometry, known)) => {
                reckoning.adopt(geometry, travel);
                covariance.adopt(known, travel, pose);
            }
            None => covariance.step(travel, pose),
        }
        pose
    }
}

/// Follows the present tick, and sends it if telemetry is due. Returns when to look again.
#[inline(never)]
fn step<M: RawMutex>(
    shared: &Shared<M>,
    odometry: &mut Odometry,
    schedule: &mut Schedule,
) -> Instant {
    let tick = shared.snapshot.copy();
    let pose = odometry.follow(tick.measured.travel, shared.follow_wheels.try_take());
    let period = shared.telemetry_period.load(Ordering::Relaxed);
    if let Some(number) = schedule.due(tick.measured.tick, period) {
        let deviation = odometry.covariance.deviation();
        send(shared, tick.telemetry(number, shared.state.get(), pose, deviation));
    }
    schedule.next(&tick)
}

fn send<M: RawMutex>(shared: &Shared<M>, telemetry: Telemetry) {
    if shared.telemetry.try_send(telemetry).is_ok() {
        shared.history.keep(telemetry);
    } else {
        shared.link.update(|link| link.telemetry_dropped = link.telemetry_dropped.wrapping_add(1));
    }
}

/// Which ticks are sent.
struct Schedule {
    /// Ticks between two frames, 0 for none.
    period: u32,
    /// Of the newest frame, or of the one before the first.
    number: u32,
}

impl Schedule {
    /// The number of the frame that is due at this tick: one a period, the first at a whole number of periods.
    fn due(&mut self, tick: u32, period: u32) -> Option<u32> {
        let begins = period != core::mem::replace(&mut self.period, period);
        let number = tick.checked_div(period)?;
        let before = core::mem::replace(&mut self.number, number);
        (if begins { tick.is_multiple_of(period) } else { number != before }).then_some(number)
    }

    /// When the next frame is due, or dead reckoning takes its next step.
    fn next(&self, tick: &Tick) -> Instant {
        let due_us = match tick.measured.tick.checked_rem(self.period) {
            Some(past) => u64::from(self.period - past) * u64::from(CONTROL_PERIOD_US),
            None => STEP_US,
        };
        let at_us = tick.measured.t_us + due_us.min(STEP_US) + COMPLETE_US;
        // Where the control timer does not tick, as while the flash is erased, the present tick is an old one.
        Instant::from_micros(at_us.max(Instant::now().as_micros() + COMPLETE_US))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_frame_a_period_at_whole_periods_and_a_late_one_still_comes() {
        let mut schedule = Schedule { period: 0, number: 0 };
        let mut sent = |ticks: core::ops::Range<u32>, period| -> Vec<u32> {
            ticks.filter(|&tick| schedule.due(tick, period).is_some()).collect()
        };
        assert!(sent(0..100, 0).is_empty());
        assert_eq!(sent(101..140, 10), [110, 120, 130]);
        // The core stood still from 140 to 156.
        assert_eq!(sent(157..175, 10), [157, 160, 170]);
        assert_eq!(sent(175..183, 4), [176, 180]);
        assert!(sent(183..190, 0).is_empty());
        assert_eq!(sent(191..203, 4), [192, 196, 200]);
    }
}
