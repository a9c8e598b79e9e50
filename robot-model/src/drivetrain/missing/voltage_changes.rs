//! Does a motor's voltage lag where it changes, as behind a driver that changes its duty only so fast?
//!
//! ```text
//! dV = x (V_T - V)  and  x |V_T - V| (V_T - V) / V_max      V_T: mean voltage of the last T
//! ```
//!
//! The first lags by the same time whatever the step, as a delay, an input filter or an inductance does; the second by a time that
//! grows with it, as a limit on the slope does.

use nalgebra::DMatrix;

use super::experiment::Experiment;
use super::least_squares::{Fitted, Problem};
use crate::drivetrain::recording::{Sample, VoltageRecording};
use crate::kinematics::WheelPair;
use crate::numeric::parallel;

/// T \[s\].
const WINDOWS_S: [f64; 2] = [0.02, 0.06];
/// So many functions there are.
pub(super) const FUNCTIONS: usize = 2 * WINDOWS_S.len();
/// Columns are differences over this share.
const STEP: f64 = 0.2;

/// How the travel of each experiment changes with the share of each function.
pub(super) fn columns(problem: &Problem<'_>, fitted: &Fitted) -> Vec<DMatrix<f64>> {
    let model = &fitted.model;
    let indices: Vec<usize> = (0..problem.experiments.len()).collect();
    parallel::map(&indices, |&index| {
        let (base, experiment) = (&fitted.residuals[index], problem.experiments[index]);
        let mut columns = DMatrix::zeros(base.len(), FUNCTIONS);
        for (i, window_s) in WINDOWS_S.into_iter().enumerate() {
            for (j, by_size) in [false, true].into_iter().enumerate() {
                let lag = |late_v: f64| {
                    STEP * late_v * if by_size { late_v.abs() / problem.full_v } else { 1.0 }
                };
                let Some(recording) = lagging(&experiment.recording, window_s, lag) else {
                    continue;
                };
                let late = Experiment { recording, ..experiment.clone() };
                let moved = problem.residuals(model, &model.at, &late);
                columns.set_column(2 * i + j, &((base - moved) / STEP));
            }
        }
        columns
    })
}

/// The recording with voltages that lag: `lag` of the mean over the last `window_s` less the voltage is added to each.
fn lagging(
    recording: &VoltageRecording,
    window_s: f64,
    lag: impl Fn(f64) -> f64,
) -> Option<VoltageRecording> {
    let samples = recording.samples();
    let mut cursor = 0;
    let mut added_vs = WheelPair::both(0.0);
    let mut late: Vec<Sample> = samples[..1].to_vec();
    for pair in samples.windows(2) {
        let dt_s = pair[1].t_s - pair[0].t_s;
        let volts = pair[1].applied_vs.since(pair[0].applied_vs).map(|vs| vs / dt_s);
        let before_vs = recording.applied_vs_at(pair[1].t_s - window_s, &mut cursor);
        let mean = pair[1].applied_vs.since(before_vs).map(|vs| vs / window_s.max(dt_s));
        added_vs = added_vs.zip(mean.since(volts)).map(|(sum, late_v)| sum + dt_s * lag(late_v));
        let applied_vs = pair[1].applied_vs.zip(added_vs).map(|(vs, added)| vs + added);
        late.push(Sample { applied_vs, ..pair[1] });
    }
    Some(VoltageRecording::new(late)?.with_counts_of(recording.count_m()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 6 V from 0.1 s on: while the mean over 20 ms climbs, half of what it is behind is missing; then nothing.
    #[test]
    fn a_step_lags_as_long_as_the_window() {
        let at = |i: u32| {
            let t_s = f64::from(i) * 5e-3;
            let applied_vs = WheelPair::both(6.0 * (t_s - 0.1).max(0.0));
            Sample { t_s, travel_m: WheelPair::both(0.0), applied_vs }
        };
        let recording = VoltageRecording::new((0..60).map(at)).unwrap();
        let late = lagging(&recording, 0.02, |late_v| 0.5 * late_v).unwrap();
        let missing =
            |i: usize| recording.samples()[i].applied_vs.left - late.samples()[i].applied_vs.left;
        assert_eq!(missing(20), 0.0);
        // Behind by 4.5, 3, 1.5 and 0 V, each for 5 ms.
        assert!((missing(24) - 0.5 * 9.0 * 5e-3).abs() < 1e-9, "{}", missing(24));
        assert!((missing(59) - missing(24)).abs() < 1e-9);
    }
}
