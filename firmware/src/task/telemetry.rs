//! Telemetry: hands the frames that are due to the link, and drops what the line cannot take.

use embassy_sync::blocking_mutex::raw::RawMutex;

use crate::shared::Shared;

/// Passes telemetry frames to the link, for ever. On a busy line they are dropped first: nothing waits for
/// them. Frames that were sent are kept for a while, in case the host asks again.
pub async fn run<M: RawMutex>(shared: &Shared<M>) -> ! {
    loop {
        shared.telemetry_due.wait().await;
        let Some(telemetry) =
            shared.snapshot.telemetry(shared.state.get(), shared.telemetry_period.get())
        else {
            continue;
        };
        if shared.telemetry.try_send(telemetry).is_ok() {
            shared.history.keep(telemetry);
        } else {
            shared
                .link
                .update(|link| link.telemetry_dropped = link.telemetry_dropped.wrapping_add(1));
        }
    }
}
