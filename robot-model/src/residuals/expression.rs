//! Which simple equation would do nearly all that a flexible model does? A starting point for an effect of one's own.
//!
//! The equations are products of what drives a robot, each with one amplitude or with a sine and a cosine, as a user would
//! write them; their units are right by construction. Each is judged by the rule of the flexible model: what it gains on
//! runs that it was not fitted to. An equation is offered only if it alone comes near the reachable error.

use serde::{Deserialize, Serialize};

use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::custom::{Custom, CustomEffect};
use crate::effect::definition::Effect;
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::errors::{cross_validated, displacement_m};
use crate::estimation::fit::{Fitted, fit_parameters};
use crate::numeric::parallel;
use crate::recording::campaign::Prepared;
use crate::residuals::flexible_model::Flexible;
use crate::residuals::group_search::left_out;

/// An equation that does nearly all that a flexible model does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expression {
    /// The equation, as `beeline model add --custom` takes it.
    pub equation: String,
    /// Its parameters: name, unit, value, standard error.
    pub parameters: Vec<(String, String, f64, f64)>,
    /// Cross-validated position error of the model with it \[m\].
    pub position_rms_m: f64,
}

/// What is offered leaves at most this many times the reachable error.
const NEAR_REACHABLE: f64 = 1.15;
/// Of equations that gain nearly as much, the first is taken: those of few factors come first.
const NEAR_BEST: f64 = 0.97;
/// Of the others, those that gain this share may still be the ones that come near the reachable error.
const WORTH_TRYING: f64 = 0.8;
/// How many are tried.
const TRIED_MAX: usize = 6;

/// What turns the robot, each as `dtheta = k * ...` per second.
const TURNS: &[&str] = &[
    "abs(v)",
    "v",
    "omega",
    "abs(omega)",
    "v * abs(v)",
    "v^2",
    "v * omega",
    "abs(v) * omega",
    "omega * abs(omega)",
    "omega^2",
    "a",
    "v^3",
    "v^2 * omega",
    "v * abs(v) * omega",
    "v * omega^2",
    "v * t_run",
    "abs(v) * t_run",
    "omega * t_run",
    "payload * omega",
    "payload * v",
    "payload * abs(v)",
];
/// What moves it sideways, each as `dn = k * ...` per second.
const SIDEWAYS: &[&str] = &[
    "v",
    "abs(v)",
    "v * omega",
    "abs(v) * omega",
    "v^2 * omega",
    "v * abs(v)",
    "payload * v * omega",
];
/// What changes a wheel's travel, each as `ds_i/ds = k * ...`, with `@` for the wheel.
const WHEELS: &[&str] = &[
    "sign(v_@)",
    "v_@",
    "abs(v_@)",
    "v_@^2",
    "a_@",
    "a_@ * sign(v_@)",
    "payload",
    "t_run",
    "t",
    "abs(omega)",
    "omega",
];
/// What comes back with an angle, with an amplitude for the sine and one for the cosine.
const ANGLES: &[(&str, &str)] = &[
    ("dtheta/ds", "theta"),
    ("dtheta/ds", "2 * theta"),
    ("ds_left/ds", "phi_left"),
    ("ds_right/ds", "phi_right"),
    ("ds_left/ds", "2 * phi_left"),
    ("ds_right/ds", "2 * phi_right"),
    ("ds_left/ds", "3 * phi_left"),
    ("ds_right/ds", "3 * phi_right"),
    ("dn/ds", "theta"),
    ("dn/ds", "2 * theta"),
];

/// All equations, those of few factors first.
fn equations() -> Vec<String> {
    let wheel = |side: &'static str| {
        WHEELS.iter().map(move |by| format!("ds_{side}/ds = k * {}", by.replace('@', side)))
    };
    let mut all: Vec<String> = TURNS
        .iter()
        .map(|by| format!("dtheta = k * {by}"))
        .chain(SIDEWAYS.iter().map(|by| format!("dn = k * {by}")))
        .chain(wheel("left"))
        .chain(wheel("right"))
        .collect();
    all.sort_by_key(|equation| equation.matches(['*', '^']).count());
    all.extend(
        ANGLES.iter().map(|(target, by)| format!("{target} = k * sin({by}) + q * cos({by})")),
    );
    all
}

/// The equation that takes a fitted model nearly to the reachable error, if one does.
pub(crate) fn expression(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    flexible: &Flexible,
) -> Option<Expression> {
    let effects: Vec<CustomEffect> = equations()
        .iter()
        .filter_map(|text| Custom::from_equation(text).ok())
        .map(|custom| Custom { id: "found".to_owned(), ..custom })
        .filter_map(|custom| custom.build().ok())
        .collect();
    let mut terms = fitted.terms.clone();
    terms.extend(effects.iter().map(|effect| {
        let count = effect.facts().parameters.len();
        Term::new(effect, vec![0.0; count])
    }));
    let placed = PlacedTerm::place(&terms);
    let equations = CampaignEquations::gather(prepared, &placed, &flexible.noise);
    let model: Vec<usize> =
        placed[..fitted.terms.len()].iter().flat_map(PlacedTerm::amplitudes).collect();
    let without: f64 = left_out(&equations, &model).iter().sum();
    let added = &placed[fitted.terms.len()..];
    let gains = parallel::map(added, |term| {
        let both: Vec<usize> = model.iter().copied().chain(term.amplitudes()).collect();
        without - left_out(&equations, &both).iter().sum::<f64>()
    });
    let most = gains.iter().copied().fold(0.0, f64::max);
    let gains_at_least = |share: f64| {
        let worth = move |gain: &f64| *gain > 0.0 && *gain >= share * most;
        gains.iter().zip(&effects).filter(move |(gain, _)| worth(gain))
    };
    let mut others: Vec<_> = gains_at_least(WORTH_TRYING).collect();
    others.sort_by(|a, b| b.0.total_cmp(a.0));
    gains_at_least(NEAR_BEST)
        .chain(others)
        .take(TRIED_MAX)
        .find_map(|(_, effect)| with(prepared, fitted, flexible, effect))
}

/// The model with this equation, fitted, if it comes near the reachable error.
fn with(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    flexible: &Flexible,
    effect: &CustomEffect,
) -> Option<Expression> {
    let count = effect.facts().parameters.len();
    let mut terms = fitted.terms.clone();
    terms.push(Term::new(effect, vec![0.0; count]));
    let fitted = fit_parameters(prepared, terms, flexible.noise);
    let placed = PlacedTerm::place(&fitted.terms);
    let equations = CampaignEquations::gather(prepared, &placed, &flexible.noise);
    let columns: Vec<usize> = placed.iter().flat_map(PlacedTerm::columns).collect();
    let errors = cross_validated(prepared, (&equations, &placed), &columns, &flexible.noise);
    let track_width_m = prepared.robot.track_width_m;
    let reachable_m = displacement_m(&flexible.reachable, track_width_m);
    if displacement_m(&errors, track_width_m) > NEAR_REACHABLE * reachable_m {
        return None;
    }
    let term = fitted.terms.last()?;
    let first = columns.len() - count;
    let facts = effect.facts();
    let parameters = facts.parameters.iter().zip(&term.values).enumerate();
    let parameters = parameters.map(|(j, (parameter, value))| {
        let sigma = fitted.covariance[(first + j, first + j)].sqrt();
        (parameter.name.to_string(), parameter.unit.to_string(), *value, sigma)
    });
    Some(Expression {
        equation: effect.custom().equation(),
        parameters: parameters.collect(),
        position_rms_m: errors.position_rms_m,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::explain;
    use crate::tests::synthetic::{campaign, full_plan};

    #[test]
    fn every_equation_is_one_that_a_user_could_write() {
        for text in equations() {
            let custom = Custom::from_equation(&text).unwrap_or_else(|error| panic!("{error:?}"));
            let built = Custom { id: "found".to_owned(), ..custom }.build();
            assert!(built.is_ok(), "{text}: {built:?}");
        }
    }

    #[test]
    fn the_equation_of_what_is_hidden_is_offered_with_its_value() {
        for (k, (text, value)) in
            [("dtheta = k * v * abs(v)", 0.15), ("ds_left/ds = k * v_left^2", 0.2)]
                .into_iter()
                .enumerate()
        {
            let own = Custom::from_equation(text).unwrap().build().unwrap();
            let truth = [Term::new(&own, vec![value])];
            let answer = explain(&campaign(&full_plan(), &truth, 40 + k as u64)).unwrap();
            let found = answer.unexplained.expression.unwrap_or_else(|| panic!("{text}"));
            assert!(found.equation.ends_with(text.split("= ").nth(1).unwrap()), "{found:?}");
            let (_, _, fitted, sigma) = found.parameters[0];
            assert!((fitted - value).abs() < 5.0 * sigma + 0.05 * value, "{found:?}");
        }
    }
}
