//! What does a choice predict where the runs cannot tell effects apart?
//!
//! To predict with the first member of a class is to bet on it. Each member in its place gives a model that fits these
//! runs as well, so the prediction is the mean of these models, by how likely each is. Effects are linear in their
//! amplitudes, so the mean of predictions is the prediction of mean amplitudes:
//!
//! ```text
//! w_r ~ exp(-(-2 log L_r + 2 log L) / (2 phi)),  p = p_chosen + sum over classes of sum over r of w_r (p_r - p_chosen)  (1)
//! ```
//!
//! with phi the variance among runs over what their noise explains, and the weights of a class, that of the chosen one included,
//! adding up to one.
//!
//! The weights are those of the estimated noise, whatever alternative fit there is: what predicts like runs better may count too
//! much on them.
//!
//! The two numbers that UMBmark measures, the ratio of the radii and the track width, stay as they were found: they are off
//! on every robot, and a ruler does not measure them. (The mean radius it does, and `robot.toml` may be right about it.)
//! So no member takes their place, nor moves them by half and more than three standard errors. What belongs to the floor is not
//! averaged either: other runs may be on another floor.
//!
//! At other speeds members go apart that agree in these runs: `1 + s` and `1 + k v^2`. Which is right there nothing shows, so
//! above the mean speed of these runs, at which they agree, each does what it does at that speed.

use crate::effect::composition::Term;
use crate::effect::definition::{FirmwareTerm, Group, Role};
use crate::estimation::fit::{Fitted, fit_parameters};
use crate::explain::answer::{Averaged, ParameterFound, StepFound};
use crate::explain::model_choice::Choice;
use crate::numeric::distributions::SIGMAS_95;
use crate::recording::campaign::Prepared;
use crate::selection::candidates::penalty;

/// The members of a class that count besides the chosen one: the most likely ones.
const MEMBERS_MAX: usize = 5;

/// The model of equation (1).
pub(super) struct Mean<'a> {
    /// The effects of the choice that it has, by their place there.
    used: Vec<usize>,
    /// Its terms, those of the choice first and in its order.
    pub terms: Vec<Term<'a>>,
    /// Each other member as it is alone in the place of its class.
    alone: Vec<Term<'a>>,
}

impl<'a> Mean<'a> {
    /// Its terms that are of the choice.
    pub fn of_choice(&self) -> &[Term<'a>] {
        &self.terms[..self.used.len()]
    }
}

/// The mean of the models that these runs cannot tell apart, without some effects of the choice.
pub(super) fn mean<'a>(choice: &Choice<'a>, left_out: &[usize]) -> Mean<'a> {
    let Choice { prepared, selection, selected, .. } = choice;
    let weights = selected.noise;
    let all = 0..selection.fitted.terms.len();
    let used: Vec<usize> = all.filter(|index| !left_out.contains(index)).collect();
    let terms = used.iter().map(|index| selection.fitted.terms[*index].clone()).collect();
    let own = fit_parameters(prepared, terms, weights);
    let chosen = &own.terms;
    let (mut mean, mut alone) = (chosen.clone(), Vec::new());
    let classes: Vec<_> = used.iter().map(|index| &choice.classes[*index]).collect();
    for (index, class) in classes.iter().enumerate() {
        let test = &selection.kept[used[index]];
        if is_of_umbmark(&chosen[index]) {
            continue;
        }
        let own_cost = own.chi_squared + penalty(&chosen[index]);
        let models: Vec<(f64, Vec<Term<'a>>)> = class
            .rivals
            .iter()
            .filter(|rival| rival.term.effect.facts().group != Group::Floor)
            .take(MEMBERS_MAX)
            .map(|rival| {
                let mut terms = chosen.clone();
                terms[index] = rival.term.fixed();
                let fitted = fit_parameters(prepared, terms, weights);
                let cost = fitted.chi_squared + penalty(&fitted.terms[index]);
                let log_weight = -(cost - own_cost) / (2.0 * test.dispersion.max(1.0));
                (log_weight, fitted.terms)
            })
            .filter(|(_, terms)| keeps_what_umbmark_measures(&own, terms))
            .collect();
        // Relative to the likeliest: a likelihood may be any power of e.
        let most = models.iter().map(|(log_weight, _)| *log_weight).fold(0.0, f64::max);
        let weight = |log_weight: f64| (log_weight - most).exp();
        let total =
            weight(0.0) + models.iter().map(|(log_weight, _)| weight(*log_weight)).sum::<f64>();
        for (log_weight, terms) in &models {
            let share = weight(*log_weight) / total;
            alone.push(terms[index].clone());
            add(&mut mean, terms, share);
            add(&mut mean, chosen, -share);
        }
    }
    let usual_mps = usual_speed_mps(prepared);
    for (index, term) in mean.iter_mut().enumerate() {
        let in_class = classes.get(index).is_none_or(|class| !class.rivals.is_empty());
        if in_class && !is_of_umbmark(term) && term.depends_on_speed(usual_mps) {
            term.up_to_mps = Some(usual_mps);
        }
    }
    Mean { used, terms: mean, alone }
}

/// Whether a term is the ratio of the radii or the track width.
fn is_of_umbmark(term: &Term<'_>) -> bool {
    let compensated = term.effect.facts().compensated_by;
    [Some(FirmwareTerm::WheelWeight), Some(FirmwareTerm::TrackWidth)].contains(&compensated)
}

/// Whether these terms have that ratio and width within three standard errors of the fitted ones.
fn keeps_what_umbmark_measures(fitted: &Fitted<'_>, terms: &[Term<'_>]) -> bool {
    let mut first = 0;
    fitted.terms.iter().zip(terms).all(|(was, is)| {
        let sigma = fitted.covariance[(first, first)].sqrt();
        first += was.values.len();
        let (was_it, is_it) = (was.values[0], is.values[0]);
        !is_of_umbmark(was) || (is_it - was_it).abs() < (3.0 * sigma).max(0.5 * was_it.abs())
    })
}

/// The mean speed of the faster wheel, by its path \[m/s\].
fn usual_speed_mps(prepared: &Prepared) -> f64 {
    let steps = prepared.runs.iter().flat_map(|run| &run.motion.steps);
    let (mut path_m, mut sum) = (0.0, 0.0);
    for step in steps {
        let speeds_mps = step.wheel_speed_mps.map(f64::abs);
        let faster_mps = speeds_mps.left.max(speeds_mps.right);
        path_m += faster_mps * step.dt_s;
        sum += faster_mps * faster_mps * step.dt_s;
    }
    sum / path_m
}

/// Adds a share of the amplitudes of these terms. A term that is not there yet comes with its shapes.
fn add<'a>(mean: &mut Vec<Term<'a>>, terms: &[Term<'a>], share: f64) {
    for term in terms {
        let facts = term.effect.facts();
        let at = mean.iter().position(|other| other.effect.facts().id == facts.id);
        let at = at.unwrap_or_else(|| {
            let amplitudes = facts.parameters.iter().map(|one| one.role == Role::Amplitude);
            let values = amplitudes.zip(&term.values);
            let values = values.map(|(scales, value)| if scales { 0.0 } else { *value }).collect();
            mean.push(Term::new(term.effect, values));
            mean.len() - 1
        });
        let parameters = facts.parameters.iter().zip(&term.values).enumerate();
        for (i, (_, value)) in parameters.filter(|(_, (one, _))| one.role == Role::Amplitude) {
            mean[at].values[i] += share * value;
        }
    }
}

/// The interval of a parameter, and the same around another value of it: where other members take the place of one, the rest of
/// the model moves.
fn around(found: &ParameterFound, value: f64) -> (f64, f64) {
    let moved = value - found.value;
    (found.low95 + moved.min(0.0), found.high95 + moved.max(0.0))
}

/// The interval of a parameter that may be none; around the value where that is beyond.
fn or_nothing(found: &ParameterFound, value: f64) -> (f64, f64) {
    let (low, high) = (found.low95.min(0.0), found.high95.max(0.0));
    let (moved_low, moved_high) = around(found, value);
    if low < value && value < high {
        (low, high)
    } else {
        (low.min(moved_low), high.max(moved_high))
    }
}

/// The mean model with intervals: whatever member of its class an effect may turn out to be, its value is between
/// nothing and that of the member alone.
///
/// `parameters` are those of the effects chosen.
pub(super) fn averaged(
    choice: &Choice<'_>,
    parameters: &[Vec<ParameterFound>],
    mean: &Mean<'_>,
) -> Vec<Averaged> {
    let entry = |(index, term): (usize, &Term<'_>)| {
        let facts = term.effect.facts();
        let chosen = mean.used.get(index);
        let found = chosen.map(|place| &parameters[*place]);
        let in_class = chosen
            .is_none_or(|place| !(choice.classes[*place].rivals.is_empty() || is_of_umbmark(term)));
        let member = mean.alone.iter().filter(|other| other.effect.facts().id == facts.id);
        let most = member.max_by(|a, b| a.values[0].abs().total_cmp(&b.values[0].abs()));
        let parameters = facts.parameters.iter().zip(&term.values).enumerate();
        let parameters = parameters.map(|(i, (parameter, value))| {
            let (low95, high95) = match (found, most) {
                (Some(found), _) if in_class => or_nothing(&found[i], *value),
                (Some(found), _) => around(&found[i], *value),
                (None, Some(alone)) => (alone.values[i].min(0.0), alone.values[i].max(0.0)),
                (None, None) => (*value, *value),
            };
            let low95 = if parameter.is_never_negative() { low95.max(0.0) } else { low95 };
            let half = ((high95 - value).max(value - low95)).max(f64::MIN_POSITIVE);
            ParameterFound {
                name: parameter.name.to_string(),
                unit: parameter.unit.to_string(),
                value: *value,
                sigma: half / SIGMAS_95,
                low95: low95.min(*value),
                high95: high95.max(*value),
            }
        });
        let (effect, up_to_mps) = (facts.id.to_owned(), term.up_to_mps);
        Averaged { effect, parameters: parameters.collect(), up_to_mps }
    };
    mean.terms.iter().enumerate().map(entry).collect()
}

/// Gives steps the values that predict other runs, where these are no shares of a class: the steps were fitted beside effects
/// that predict nothing, and may be bent by them.
pub(super) fn tell_values<'s>(
    choice: &Choice<'_>,
    predicts_with: &[Averaged],
    steps: impl Iterator<Item = &'s mut StepFound>,
) {
    for step in steps {
        let is_own = |term: &&Term<'_>| term.effect.facts().id == step.effect;
        let of_umbmark =
            choice.selection.fitted.terms.iter().find(is_own).is_some_and(is_of_umbmark);
        let predicts = predicts_with.iter().find(|one| one.effect == step.effect);
        if let Some(one) = predicts.filter(|_| of_umbmark || step.class.len() == 1) {
            step.parameters.clone_from(&one.parameters);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_holds_the_mean_as_well_as_the_value_found() {
        let found = ParameterFound {
            name: "delta".into(),
            unit: "1".into(),
            value: -0.64,
            sigma: 0.28,
            low95: -1.19,
            high95: -0.09,
        };
        let is = |(low, high): (f64, f64), expected: (f64, f64)| {
            assert!((low - expected.0).hypot(high - expected.1) < 1e-9, "{low} {high}");
        };
        is(around(&found, -0.64), (-1.19, -0.09));
        // With other members in the place of one, the track width is another, and as unsure.
        is(around(&found, -0.07), (-1.19, 0.48));
        is(around(&found, -1.0), (-1.55, -0.09));
        // A member that may be none is between nothing and itself.
        is(or_nothing(&found, -0.3), (-1.19, 0.0));
        is(or_nothing(&found, 0.1), (-1.19, 0.65));
    }
}
