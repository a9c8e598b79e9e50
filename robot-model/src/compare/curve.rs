//! How does the residual of a model depend on speed, heading and other regressors? Its systematic error, in bins.

use core::f64::consts::TAU;

use super::regime::{moving, rim_mps};
use super::stretch::{Component, Drift, Stretch, drift, stretches, tracks};
use crate::effect::composition::Term;
use crate::recording::campaign::Prepared;
use crate::recording::motion::Step;
use crate::recording::odometry_noise::OdometryNoise;
use crate::residuals::regressor::Regressor;

/// Bins of a regressor that is an angle.
const BINS_ROUND: usize = 8;
/// Bins of any other, each with the same number of steps.
const BINS: usize = 9;

/// What is left of one component, against one regressor.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What stands on the axis.
    pub axis: Axis,
    /// Of what the error is shown.
    pub component: Component,
    /// From low to high.
    pub bins: Vec<Bin>,
    /// Root mean square of the bins in units of their standard errors: 1 is noise.
    pub chi: f64,
}

/// One bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Mean of the regressor in it.
    pub at: f64,
    /// The systematic error.
    pub drift: Drift,
}

/// What a curve is drawn against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Speed of the middle \[m/s\].
    Speed,
    /// Turn rate \[rad/s\].
    TurnRate,
    /// Speeding up of the middle, whichever way it drives \[m/s^2\].
    Acceleration,
    /// Speed of the faster rim \[m/s\].
    RimSpeed,
    /// Heading \[rad\].
    Heading,
    /// Angle of the left wheel \[rad\].
    LeftWheelAngle,
    /// Angle of the right wheel \[rad\].
    RightWheelAngle,
    /// Way since the last reversal \[m\].
    SinceReversal,
    /// Time in the run \[s\].
    TimeInRun,
    /// Time in the campaign \[s\].
    TimeInCampaign,
}

impl Axis {
    const ALL: [Self; 10] = [
        Self::Speed,
        Self::TurnRate,
        Self::Acceleration,
        Self::RimSpeed,
        Self::Heading,
        Self::LeftWheelAngle,
        Self::RightWheelAngle,
        Self::SinceReversal,
        Self::TimeInRun,
        Self::TimeInCampaign,
    ];

    /// What it is called in what stays unexplained.
    pub const fn regressor(self) -> Regressor {
        match self {
            Self::Speed => Regressor::Speed,
            Self::TurnRate => Regressor::TurnRate,
            Self::Acceleration => Regressor::Acceleration,
            Self::RimSpeed => Regressor::WheelSpeed,
            Self::Heading => Regressor::Heading,
            Self::LeftWheelAngle | Self::RightWheelAngle => Regressor::WheelAngle,
            Self::SinceReversal => Regressor::SinceReversal,
            Self::TimeInRun => Regressor::TimeInRun,
            Self::TimeInCampaign => Regressor::TimeInCampaign,
        }
    }

    /// Whether it goes round.
    const fn is_round(self) -> bool {
        matches!(self, Self::Heading | Self::LeftWheelAngle | Self::RightWheelAngle)
    }

    fn of(self, step: &Step) -> Option<f64> {
        match self {
            Self::Speed => Some(step.speed_mps()),
            Self::TurnRate => Some(step.turn_rate_rad_s()),
            Self::Acceleration => Some(step.wheel_accel_mps2.mean() * step.speed_mps().signum()),
            Self::RimSpeed => Some(rim_mps(step)),
            Self::Heading => Some(step.heading_rad),
            Self::LeftWheelAngle => Some(step.phi_rad.left + step.dphi_rad.left / 2.0),
            Self::RightWheelAngle => Some(step.phi_rad.right + step.dphi_rad.right / 2.0),
            Self::SinceReversal => step.since_reversal_m,
            Self::TimeInRun => Some(step.t_s),
            Self::TimeInCampaign => Some(step.clock_s),
        }
    }
}

pub(super) fn curves(prepared: &Prepared, terms: &[Term<'_>], noise: &OdometryNoise) -> Vec<Curve> {
    let tracks = tracks(prepared, terms);
    let mut curves = Vec::new();
    for axis in Axis::ALL {
        let value = |step: &Step| {
            let it = axis.of(step).filter(|_| moving(step))?;
            Some(if axis.is_round() { it.rem_euclid(TAU) } else { it })
        };
        let edges = if axis.is_round() {
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
        let scale = if axis.is_round() { 360.0 / TAU } else { 1.0 };
        let by_component = Component::ALL.map(|component| {
            let bins: Vec<Bin> = found
                .iter()
                .zip(&middles)
                .filter(|(stretches, _)| !stretches.is_empty())
                .map(|(stretches, (sum, count))| Bin {
                    at: scale * sum / count,
                    drift: drift(&stretches.iter().collect::<Vec<_>>(), component),
                })
                .filter(|bin| bin.drift.sigma > 0.0)
                .collect();
            let squares: f64 = bins.iter().map(|bin| bin.drift.sigmas().powi(2)).sum();
            let chi = (squares / (bins.len() as f64).max(1.0)).sqrt();
            Curve { axis, component, bins, chi }
        });
        curves.extend(by_component.into_iter().filter(|curve| curve.bins.len() > 2));
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
