//! Is a clock in seconds? Only speeds can tell: tracks know nothing of time.

use crate::recording::run::Recording;

/// A clock that can hardly be in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlowClock {
    /// The fastest that a wheel would turn \[rad/s\].
    pub rate_rad_s: f64,
    /// How many of the clock's units make a second, as likely as not: 1e3, 1e6 or 1e9.
    pub per_s: f64,
}

/// A clock in a smaller unit than seconds makes wheels this slow, though they turn by a radian or more and samples
/// are a second or more apart: 20 rad/s, with a second for a millisecond \[rad/s\].
const SLOW_RAD_S: f64 = 0.02;
/// The slowest fastest speed of a robot's wheels \[rad/s\].
const LIKELY_RAD_S: f64 = 0.2;
/// Fewer samples than these may really be minutes apart.
const SAMPLES_MIN: usize = 20;

/// Whether a run's clock can hardly be in seconds; `run` is valid.
pub fn slow_clock(run: &Recording) -> Option<SlowClock> {
    let mut spacings: Vec<f64> =
        run.wheels.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
    spacings.sort_by(f64::total_cmp);
    if run.wheels.len() < SAMPLES_MIN || spacings[spacings.len() / 2] < 1.0 {
        return None;
    }
    let (mut rate_rad_s, mut rolled_rad) = (0.0_f64, 0.0);
    for pair in run.wheels.windows(2) {
        let turned = pair[1].phi_rad.since(pair[0].phi_rad).map(f64::abs);
        let most = turned.left.max(turned.right);
        rate_rad_s = rate_rad_s.max(most / (pair[1].t_s - pair[0].t_s));
        rolled_rad += most;
    }
    let units = [1e3, 1e6, 1e9];
    let per_s = units.into_iter().find(|per_s| rate_rad_s * per_s > LIKELY_RAD_S).unwrap_or(1e9);
    (rolled_rad > 1.0 && rate_rad_s < SLOW_RAD_S).then_some(SlowClock { rate_rad_s, per_s })
}
