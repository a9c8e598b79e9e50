//! Telemetry: follows where the robot is, hands the frames that are due to the link, and drops what the line cannot take.

use core::sync::atomic::Ordering;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Duration, Timer};

use crate::dead_reckoning::DeadReckoning;
use crate::shared::{OdometryOrder, Shared};

/// Dead reckoning takes a step at least this often.
const STEP: Duration = Duration::from_millis(10);

/// Passes telemetry frames to the link, for ever. On a busy line they are dropped first: nothing waits for
/// them. Frames that were sent are kept for a while, in case the host asks again.
pub async fn run<M: RawMutex>(shared: &Shared<M>) -> ! {
    let mut reckoning = DeadReckoning::new();
    loop {
        let next = select(shared.telemetry_due.wait(), Timer::after(STEP)).await;
        step(shared, &mut reckoning, matches!(next, Either::First(())));
    }
}

/// Follows the present tick, and sends it if telemetry is due.
#[inline(never)]
fn step<M: RawMutex>(shared: &Shared<M>, reckoning: &mut DeadReckoning, is_due: bool) {
    let tick = shared.snapshot.copy();
    let travel = tick.measured.travel;
    match shared.follow_wheels.try_take() {
        Some(OdometryOrder::Pause) => reckoning.pause(),
        Some(OdometryOrder::With(geometry)) => reckoning.adopt(geometry, travel),
        None => reckoning.step(travel),
    }
    let Some(number) =
        tick.measured.tick.checked_div(shared.telemetry_period.load(Ordering::Relaxed))
    else {
        return;
    };
    if !is_due {
        return;
    }
    let telemetry = tick.telemetry(number, shared.state.get(), reckoning.pose());
    if shared.telemetry.try_send(telemetry).is_ok() {
        shared.history.keep(telemetry);
    } else {
        shared.link.update(|link| link.telemetry_dropped = link.telemetry_dropped.wrapping_add(1));
    }
}
