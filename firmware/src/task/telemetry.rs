//! Telemetry: hands the snapshots that are due to the link, and gives up what the line cannot take.

use embassy_sync::blocking_mutex::raw::RawMutex;

use crate::shared::Shared;

/// Passes snapshots on, for ever. The first to suffer on a busy line: nothing waits for it. What is sent is also kept for a
/// while, should the host ask for it again.
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
