//! How large is the noise of a robot whose plant does not know it? The robot drives its campaign twice.
//!
//! What a model could learn is the same in both campaigns; the noise of poses and counts is drawn anew in each. So half of
//! the mean squared difference of both errors is the mean squared noise, whatever model predicts them:
//!
//! ```text
//! e = what is off + noise,   noise^2 = mean |e - e'|^2 / 2                             (1)
//! ```

use robot_model::compare::{Comparer, EffectWithValues, RunPredicted};
use robot_model::effect::find;
use robot_model::explain::model::Model;
use robot_model::recording::{Campaign, OdometryNoise};

/// Poses of both campaigns that are at most so far apart in time belong together \[s\]: half a period of the camera.
const APART_S: f64 = 0.051;

/// (1) of positions, on the runs that are not held out \[m\].
///
/// # Errors
/// What went wrong, for a person to read.
pub fn noise_of_twins(
    twins: [&Campaign; 2],
    model: &Model,
    noise: OdometryNoise,
) -> Result<f64, String> {
    let known = model.effects.iter().filter_map(|one| {
        let values = one.parameters.iter().map(|parameter| parameter.value).collect();
        Some(EffectWithValues { effect: find(&one.effect)?, values, up_to_mps: None })
    });
    let known: Vec<EffectWithValues<'_>> = known.collect();
    let predicted = |campaign: &Campaign| {
        let comparer = Comparer::with_noise(campaign, noise).map_err(|error| error.to_string())?;
        Ok::<_, String>(comparer.predicted(&known))
    };
    let [one, other] = [predicted(twins[0])?, predicted(twins[1])?];
    let (mut sum, mut count) = (0.0, 0);
    for run in one.iter().filter(|run| !run.held_out) {
        let Some(twin) = other.iter().find(|twin| twin.run == run.run) else { continue };
        for difference_m2 in differences_m2(&errors(run), &errors(twin)) {
            sum += difference_m2;
            count += 1;
        }
    }
    if count == 0 {
        Err("both campaigns have nothing in common".into())
    } else {
        Ok((sum / f64::from(count) / 2.0).sqrt())
    }
}

/// Time \[s\], and the error ahead and to the left of the predicted pose \[m\].
fn errors(run: &RunPredicted) -> Vec<(f64, [f64; 2])> {
    let each = run.measured.iter().zip(&run.predicted);
    each.filter_map(|(measurement, pose)| {
        let [x_m, y_m] = measurement.position_m?;
        let (off_x_m, off_y_m) = (x_m - pose.x_m, y_m - pose.y_m);
        let (sin, cos) = pose.heading_rad.sin_cos();
        Some((measurement.t_s, [cos * off_x_m + sin * off_y_m, cos * off_y_m - sin * off_x_m]))
    })
    .collect()
}

/// The squared differences of errors at the same time.
fn differences_m2(one: &[(f64, [f64; 2])], other: &[(f64, [f64; 2])]) -> Vec<f64> {
    let both_ends = one.len() == 2 && other.len() == 2;
    let each = one.iter().enumerate().filter_map(|(index, (t_s, error))| {
        let after = other.partition_point(|(other_s, _)| *other_s < t_s - APART_S);
        let near = other.get(if both_ends { index } else { after })?;
        (both_ends || (near.0 - t_s).abs() <= APART_S)
            .then(|| (error[0] - near.1[0]).powi(2) + (error[1] - near.1[1]).powi(2))
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_the_same_in_both_is_no_noise() {
        let drift = |noise_m: f64| -> Vec<(f64, [f64; 2])> {
            (0..100).map(|k| (0.1 * f64::from(k), [0.01 * f64::from(k), noise_m])).collect()
        };
        let differences = differences_m2(&drift(0.001), &drift(-0.001));
        assert_eq!(differences.len(), 100);
        assert!(differences.iter().all(|square| (square - 4e-6).abs() < 1e-12));
    }

    #[test]
    fn ends_belong_together_whatever_their_times() {
        let ends = |end_s: f64| [(0.0, [0.0; 2]), (end_s, [0.001, 0.0])];
        assert_eq!(differences_m2(&ends(5.0), &ends(5.3)), [0.0, 0.0]);
    }
}
