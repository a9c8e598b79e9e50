//! How does the residual of a model depend on speed, heading and other regressors? Its systematic error, in bins.

use core::f64::consts::TAU;

use serde::Serialize;

use super::regime::{moving, rim_mps};
use super::stretch::{Aspect, Drift, Stretch, drift, stretches, tracks};
use crate::effect::composition::Term;
use crate::estimation::odometry_noise::OdometryNoise;
use crate::recording::campaign::Prepared;
use crate::recording::motion::Step;

/// Bins of a regressor that is an angle.
const BINS_ROUND: usize = 8;
/// Bins of any other, each with the same number of steps.
const BINS: usize = 9;

/// The systematic error of one aspect, against one regressor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Name of the regressor, the same as in [`crate::residuals`].
    pub regressor: &'static str,
    /// Label of the axis.
    pub axis: &'static str,
    /// Which error is shown.
    pub aspect: Aspect,
    /// From low to high.
    pub bins: Vec<Bin>,
    /// Root mean square of the bins in units of their standard errors: 1 is noise.
    pub chi: f64,
}

/// One bin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// Mean of the regressor in it.
    pub at: f64,
    /// The systematic error.
    pub drift: Drift,
}

struct Regressor {
    name: &'static str,
    axis: &'static str,
    round: bool,
    of: fn(&Step) -> Option<f64>,
}

static REGRESSORS: [Regressor; 10] = [
    Regressor {
        name: "speed",
        axis: "speed in m/s",
        round: false,
        of: |step| Some(step.speed_mps()),
    },
    Regressor {
        name: "turn rate",
        axis: "turn rate in rad/s",
        round: false,
        of: |step| Some(step.turn_rate_rad_s()),
    },
    Regressor {
        name: "acceleration",
        axis: "speeding up of the middle in m/s\u{b2}",
        round: false,
        of: |step| Some(step.wheel_accel_mps2.mean() * step.speed_mps().signum()),
    },
    Regressor {
        name: "wheel speed",
        axis: "speed of the faster rim in m/s",
        round: false,
        of: |step| Some(rim_mps(step)),
    },
    Regressor {
        name: "heading",
        axis: "heading in degrees",
        round: true,
        of: |step| Some(step.heading_rad),
    },
    Regressor {
        name: "wheel angle",
        axis: "angle of the left wheel in degrees",
        round: true,
        of: |step| Some(step.phi_rad.left + step.dphi_rad.left / 2.0),
    },
    Regressor {
        name: "wheel angle",
        axis: "angle of the right wheel in degrees",
        round: true,
        of: |step| Some(step.phi_rad.right + step.dphi_rad.right / 2.0),
    },
    Regressor {
        name: "distance since reversal",
        axis: "way since the last reversal in m",
        round: false,
        of: |step| step.since_reversal_m,
    },
    Regressor {
        name: "time in the run",
        axis: "time in the run in s",
        round: false,
        of: |step| Some(step.t_s),
    },
    Regressor {
        name: "time in the campaign",
        axis: "time in the campaign in s",
        round: false,
        of: |step| Some(step.clock_s),
    },
];

pub(super) fn curves(prepared: &Prepared, terms: &[Term<'_>], noise: &OdometryNoise) -> Vec<Curve> {
    let tracks = tracks(prepared, terms);
    let mut curves = Vec::new();
    for regressor in &REGRESSORS {
        let value = |step: &Step| {
            let number = (regressor.of)(step).filter(|_| moving(step))?;
            Some(if regressor.round { number.rem_euclid(TAU) } else { number })
        };
        let edges = if regressor.round {
            (1..BINS_ROUND).map(|k| k as f64 * TAU / BINS_ROUND as f64).collect()
        } else {
            quantiles(prepared, &value)
        };
        let mut found: Vec<Vec<Stretch>> = vec![Vec::new(); edges.len() + 1];
        let mut middles = vec![(0.0, 0.0); edges.len() + 1];
        for (index, (run, track)) in prepared.runs.iter().zip(&tracks).enumerate() {
            let steps = &run.motion.steps;
            let bin = |x: f64| edges.iter().filter(|edge| x > **edge).count();
            for x in steps.iter().filter_map(value) {
                let middle: &mut (f64, f64) = &mut middles[bin(x)];
                *middle = (middle.0 + x, middle.1 + 1.0);
            }
            let label = |k: usize| value(&steps[k]).map(bin);
            for (label, stretch) in stretches(index, run, track, noise, label) {
                found[label].push(stretch);
            }
        }
        let scale = if regressor.round { 360.0 / TAU } else { 1.0 };
        let by_aspect = Aspect::ALL.map(|aspect| {
            let bins: Vec<Bin> = found
                .iter()
                .zip(&middles)
                .filter(|(stretches, _)| !stretches.is_empty())
                .map(|(stretches, (sum, count))| Bin {
                    at: scale * sum / count,
                    drift: drift(&stretches.iter().collect::<Vec<_>>(), aspect),
                })
                .filter(|bin| bin.drift.sigma > 0.0)
                .collect();
            let squares: f64 = bins.iter().map(|bin| bin.drift.sigmas().powi(2)).sum();
            let chi = (squares / (bins.len() as f64).max(1.0)).sqrt();
            Curve { regressor: regressor.name, axis: regressor.axis, aspect, bins, chi }
        });
        curves.extend(by_aspect.into_iter().filter(|curve| curve.bins.len() > 2));
    }
    curves
}

/// Edges between bins of equally many steps each.
fn quantiles(prepared: &Prepared, value: &dyn Fn(&Step) -> Option<f64>) -> Vec<f64> {
    let steps = prepared.runs.iter().flat_map(|run| &run.motion.steps);
    let mut all: Vec<f64> = steps.filter_map(value).collect();
    all.sort_by(f64::total_cmp);
    let span = all.last().unwrap_or(&0.0) - all.first().unwrap_or(&0.0);
    let mut edges: Vec<f64> =
        (1..BINS).filter_map(|k| all.get(k * all.len() / BINS)).copied().collect();
    // Where most steps have the same value, some edges are the same.
    edges.dedup_by(|b, a| *b - *a < 0.02 * span);
    edges
}
