//! How strong an effect must be to stand out by so many sigma in a campaign.
//!
//! The effect is first hidden at a reference strength, far above the noise. A fit of the known effect, with every
//! run's start free and the noise estimated, then gives by how many of its standard errors it stands out:
//!
//! ```text
//! D_ref = sqrt( sum over amplitudes of (value / sigma)^2 ),    strength = reference D / D_ref       (1)
//! ```
//!
//! (1) takes the effect to be linear in its strength; the strength reached is measured again in the campaign itself,
//! and reported.
//!
//! An effect outside the catalogue cannot be fitted. It stands out by the chi^2 that it adds to what a sound robot's
//! geometry and noise leave:
//!
//! ```text
//! D^2 = chi^2(with it) - chi^2(without it)                                                            (2)
//! ```

use robot_model::effect::{Effect, find};
use robot_model::explain::model::{Model, fit};
use robot_model::recording::Campaign;
use robot_model::recording::RecordingError;

/// By how many sigma an effect of a fitted model stands out, with its amplitudes taken as independent.
pub fn sigmas(model: &Model, id: &str) -> f64 {
    let Some(fitted) = model.effects.iter().find(|fitted| fitted.effect == id) else { return 0.0 };
    let facts = robot_model::effect::find(id).map(|effect| effect.facts());
    let is_amplitude = |name: &str| {
        facts.is_some_and(|facts| {
            facts.parameters.iter().any(|parameter| {
                parameter.name == name && parameter.role == robot_model::effect::Role::Amplitude
            })
        })
    };
    let squares = fitted.parameters.iter().filter(|parameter| is_amplitude(&parameter.name)).map(
        |parameter| {
            if parameter.sigma > 0.0 { (parameter.value / parameter.sigma).powi(2) } else { 0.0 }
        },
    );
    squares.sum::<f64>().sqrt()
}

/// By how many sigma the difference of two campaigns stands out, by (2).
///
/// # Errors
/// If a campaign cannot be fitted to.
pub fn visibility(without: &Campaign, with: &Campaign) -> Result<f64, RecordingError> {
    let geometry: Vec<&'static dyn Effect> =
        ["wheel_radius_ratio", "wheel_radius_scale", "track_width"]
            .into_iter()
            .filter_map(find)
            .collect();
    let sound = fit(without, &geometry)?;
    let squares = |campaign: &Campaign| -> Result<f64, RecordingError> {
        // Only of the runs that are explained, not of those held out.
        let runs = campaign.fitted_runs().cloned().collect();
        let seen = Campaign { robot: campaign.robot, runs };
        let numbers: usize = seen.runs.iter().map(|run| 3 * run.measured_poses.len()).sum();
        Ok(sound.errors_on(&seen)?.chi.powi(2) * numbers as f64)
    };
    Ok((squares(with)? - squares(without)?).max(0.0).sqrt())
}

/// The strength at which an effect stands out by `wanted` sigma, given what it does at a reference.
pub fn scaled(reference: f64, wanted: f64, reached: f64) -> f64 {
    /// An effect that hardly shows at its reference is not magnified without bound.
    const MOST: f64 = 10.0;
    reference * (wanted / reached.max(1e-9)).min(MOST)
}

/// An effect that stands out by less than this share of what its strength promises is too strong.
const STILL_LINEAR: f64 = 0.3;
/// What stands out by fewer sigma is not seen at all.
const SEEN: f64 = 0.1;

/// A strength that was tried.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// The strength.
    pub strength: f64,
    /// By how many sigma the effect stands out.
    pub reached: f64,
}

impl Trial {
    /// Whether the effect stands out by much less than its strength promises, by the first trial. An effect that was not
    /// seen at first, and with more strength still is not, cannot be seen in this campaign.
    pub fn is_too_strong(self, first: Self) -> bool {
        let stronger = self.strength / first.strength;
        stronger > 1.0 && self.reached < STILL_LINEAR * first.reached.max(SEEN) * stronger
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(strength: f64, reached: f64) -> Trial {
        Trial { strength, reached }
    }

    #[test]
    fn what_does_not_show_is_not_made_a_thousand_times_as_strong() {
        // A load on a run that ends where it began, of which only the ends are measured.
        assert!(trial(10.0, 0.0).is_too_strong(trial(1.0, 0.0)));
        assert!(trial(10.0, 2e-8).is_too_strong(trial(1.0, 1e-8)));
        // A weak effect grows in proportion.
        assert!(!trial(10.0, 4.0).is_too_strong(trial(1.0, 0.4)));
        assert!(!trial(6.0, 2.9).is_too_strong(trial(1.0, 0.65)));
    }

    #[test]
    fn strength_that_hardly_stands_out_more_is_too_much_by_the_first_trial() {
        // Three times as strong thrice: each time it stands out a little more, and in all no more than at first.
        let first = trial(1.0, 9.1);
        assert!(!trial(3.3, 9.7).is_too_strong(first));
        assert!(trial(10.2, 10.0).is_too_strong(first));
        // Less of it is never too strong.
        assert!(!trial(0.2, 0.1).is_too_strong(first));
    }
}
