//! Telemetry: follows where the robot is, hands the frames that are due to the link, and drops what the line cannot take.

use core::sync::atomic::Ordering;

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Instant, Timer};
use shared_proto::Telemetry;

use crate::dead_reckoning::DeadReckoning;
use crate::shared::{OdometryOrder, Shared, Tick};
use crate::units::CONTROL_PERIOD_US;

/// Dead reckoning takes a step at least this often \[us\].
const STEP_US: u64 = 10_000;

/// A tick whose encoders were read this long ago is complete \[us\].
const COMPLETE_US: u64 = CONTROL_PERIOD_US as u64 / 4;

/// Passes telemetry frames to the link, for ever. On a busy line they are dropped first: nothing waits for
/// them. Frames that were sent are kept for a while, in case the host asks again.
///
/// This task wakes by the clock, shortly after a tick that is due: to wake it, the control tick would have to work.
pub async fn run<M: RawMutex>(shared: &Shared<M>) -> ! {
    let mut reckoning = DeadReckoning::new();
    let mut schedule = Schedule { period: 0, number: 0 };
    loop {
        let next = step(shared, &mut reckoning, &mut schedule);
        Timer::at(next).await;
    }
}

/// Follows the present tick, and sends it if telemetry is due. Returns when to look again.
#[inline(never)]
fn step<M: RawMutex>(
    shared: &Shared<M>,
    reckoning: &mut DeadReckoning,
    schedule: &mut Schedule,
) -> Instant {
    let tick = shared.snapshot.copy();
    let travel = tick.measured.travel;
    match shared.follow_wheels.try_take() {
        Some(OdometryOrder::Pause) => reckoning.pause(),
        Some(OdometryOrder::With(geometry)) => reckoning.adopt(geometry, travel),
        None => reckoning.step(travel),
    }
    let period = shared.telemetry_period.load(Ordering::Relaxed);
    if let Some(number) = schedule.due(tick.measured.tick, period) {
        send(shared, tick.telemetry(number, shared.state.get(), reckoning.pose()));
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
