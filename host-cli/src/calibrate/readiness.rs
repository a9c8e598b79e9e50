//! Whether the robot is ready for the first drive: link, state and supply.

use shared_proto::{Config, ConfigOrigin, Identity, State};

use crate::error::{Error, Result};
use host_link::session::Session;

/// What was found before the first drive.
#[derive(Clone, Debug)]
pub struct Checks {
    /// The robot's identity.
    pub identity: Identity,
    /// Its configuration.
    pub config: Config,
    /// Requests that were sent to check the link.
    pub asked: u32,
    /// How many of them had to be repeated.
    pub repeated: u64,
    /// Supply \[V\].
    pub supply_v: f64,
}

/// Checks link, state and supply before anything moves. The robot itself checks the signs of its
/// encoders before it closes the loop.
pub(super) async fn check(session: &mut Session) -> Result<Checks> {
    const REQUESTS: u32 = 20;
    let before = session.statistics().retries;
    let mut status = session.status().await?;
    for _ in 1..REQUESTS {
        status = session.status().await?;
    }
    if let Some(report) = status.fault {
        return Err(Error::new(format_args!("a fault is latched: {}", report.fault))
            .hint(format_args!("{}; then `beeline clear`", report.fault.remedy())));
    }
    if status.state != State::Idle {
        return Err(Error::new(format_args!("the robot is {}", status.state.name()))
            .hint("`beeline stop` ends a motion"));
    }
    let identity = session.identify().await?;
    if identity.unsaved {
        // A calibration was killed, or a `config set` was not saved.
        session.restore_config(ConfigOrigin::Saved).await?;
    }
    let config = session.read_config().await?;
    let supply_v = f64::from(session.status().await?.supply_mv) * 1e-3;
    if supply_v < config.protection.supply_v_min {
        return Err(Error::new(format_args!("the supply is down to {supply_v:.2} V"))
            .hint("charge the battery; protection.supply_v_min sets this limit"));
    }
    let repeated = session.statistics().retries - before;
    Ok(Checks { identity, config, asked: REQUESTS, repeated, supply_v })
}
