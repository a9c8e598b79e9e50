//! Telemetry: hands the snapshots that are due to the link, and gives up what the line cannot take.

use embassy_sync::blocking_mutex::raw::RawMutex;

use crate::shared::Shared;

/// Passes snapshots on, for ever. The first to suffer on a busy line: nothing waits for it.
pub async fn run<M: RawMutex>(shared: &Shared<M>) -> ! {
    loop {
        shared.telemetry_due.wait().await;
        let telemetry = shared.snapshot.telemetry(shared.state.get());
        if shared.telemetry.try_send(telemetry).is_err() {
            shared
                .link
                .update(|link| link.telemetry_dropped = link.telemetry_dropped.wrapping_add(1));
        }
    }
}
