//! Heartbeat: shows the guard that every safety task lives, and with them their executor.

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Duration, Ticker};

use crate::shared::Shared;

/// How often the heartbeat looks. A task checks in every 10 ms, so the guard hears of all every 15 ms.
const PERIOD: Duration = Duration::from_millis(5);

/// Calls `beat` whenever all safety tasks have checked in, for ever.
pub async fn run<M: RawMutex>(shared: &Shared<M>, beat: impl Fn()) -> ! {
    let mut ticker = Ticker::every(PERIOD);
    loop {
        if shared.liveness.take_all() {
            beat();
        }
        ticker.next().await;
    }
}
