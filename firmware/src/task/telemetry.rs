//! Telemetry: follows where the robot is and how sure that is, hands the frames that are due to the link, and drops what
//! the line cannot take.

use core::sync::atomic::Ordering;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Duration, Timer};
use shared_proto::{Pose, WheelPair};

use crate::dead_reckoning::DeadReckoning;
use crate::pose_covariance::PoseCovariance;
use crate::shared::{OdometryOrder, Shared};
use crate::units::Travel;

/// Dead reckoning takes a step at least this often.
const STEP: Duration = Duration::from_millis(10);

/// Passes telemetry frames to the link, for ever. On a busy line they are dropped first: nothing waits for
/// them. Frames that were sent are kept for a while, in case the host asks again.
pub async fn run<M: RawMutex>(shared: &Shared<M>) -> ! {
    let mut odometry = Odometry::START;
    loop {
        let next = select(shared.telemetry_due.wait(), Timer::after(STEP)).await;
        step(shared, &mut odometry, matches!(next, Either::First(())));
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

/// Follows the present tick, and sends it if telemetry is due.
#[inline(never)]
fn step<M: RawMutex>(shared: &Shared<M>, odometry: &mut Odometry, is_due: bool) {
    let tick = shared.snapshot.copy();
    let pose = odometry.follow(tick.measured.travel, shared.follow_wheels.try_take());
    let Some(number) =
        tick.measured.tick.checked_div(shared.telemetry_period.load(Ordering::Relaxed))
    else {
        return;
    };
    if !is_due {
        return;
    }
    let deviation = odometry.covariance.deviation();
    let telemetry = tick.telemetry(number, shared.state.get(), pose, deviation);
    if shared.telemetry.try_send(telemetry).is_ok() {
        shared.history.keep(telemetry);
    } else {
        shared.link.update(|link| link.telemetry_dropped = link.telemetry_dropped.wrapping_add(1));
    }
}
