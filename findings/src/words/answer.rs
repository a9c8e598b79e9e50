//! What `explain` answers, in words.

use robot_model::effect::{Need, NetChange, Ways};
use robot_model::explain::{PredictedSeparation, Reason, StepFound};
use robot_model::residuals::{DrivenAgain, Expression, Regressor, Unexplained};

use crate::quantity::{p_value as p_words, value_with_sigma};

/// The evidence for an effect: how it shows, how much it explains, and what else would; no full stop.
pub fn evidence(step: &StepFound) -> String {
    let found = &step.evidence;
    let gain = if found.one_run_alone {
        format!("only one run shows it; there the -2 log likelihood falls by {:.0}", found.gain)
    } else {
        format!("the cross-validated -2 log likelihood falls by {:.0}", found.gain)
    };
    let rivals = match &step.class[..] {
        [] | [_] => "no other effect explains it as well".to_owned(),
        [_, rivals @ ..] => format!("these runs cannot tell it from {}", rivals.join(", ")),
    };
    format!("{}; {gain}; {rivals}", found.signature)
}

/// Where less than this share of an effect's size is certain, that is said.
const SURE: f64 = 0.8;

/// How far an effect moves the robot, and whether that matters; no full stop.
pub fn worth(step: &StepFound) -> String {
    let mm = 1e3 * step.effect_size_m;
    match (step.moves_no_track, step.matters) {
        (true, true) => "it concerns a sensor, and moves no track".to_owned(),
        (true, false) => {
            "it concerns a sensor, and turns its heading by too little to matter".to_owned()
        }
        (false, true) if !step.used_to_predict => format!(
            "it moves the robot by {mm:.2} mm (rms) in these runs, less than is left unexplained: it may be something else, so a saved \
             model goes without it"
        ),
        (false, true) => format!("it moves the robot by {mm:.2} mm (rms) in these runs"),
        (false, false) if mm < 0.005 => {
            "it does not move the robot in these runs: too little to matter".to_owned()
        }
        (false, false) if !step.nears_runs => {
            format!(
                "it moves the robot by {mm:.2} mm (rms) in these runs, no more than chance may: not worth correcting"
            )
        }
        (false, false) => {
            let size = format!("it moves the robot by {mm:.2} mm (rms) in these runs");
            let least_mm = 1e3 * step.least_size_m;
            match least_mm < SURE * mm {
                true => {
                    format!("{size}, of which {least_mm:.2} mm are certain: too little to matter")
                }
                false => format!("{size}: too little to matter"),
            }
        }
    }
}

/// What predicts runs better than the choice of effects.
pub const fn second_opinion(geometry_only: bool) -> &'static str {
    if geometry_only {
        "Second opinion: radii and track width alone predict these runs better than a model with more effects, so only they are used."
    } else {
        "Second opinion: a least-squares fit to whole tracks predicts these runs better than the Kalman filter's fit, so it is used instead."
    }
}

/// The equation that a flexible model suggests, and the command that tries it.
pub fn expression(found: &Expression) -> String {
    let values = found.parameters.iter().map(|(name, unit, value, sigma)| {
        format!("{name} = {}", value_with_sigma(*value, *sigma, unit))
    });
    format!(
        "A simple equation explains nearly all of it: {}, {}; the position error falls to {:.1} mm. Try `beeline model add \
         --custom \"{}\"`",
        found.equation,
        values.collect::<Vec<_>>().join(", "),
        1e3 * found.position_rms_m,
        found.equation
    )
}

/// Why an effect was rejected.
pub fn reason(reason: &Reason) -> String {
    match reason {
        Reason::Lacking(need) => lacking(*need).to_owned(),
        Reason::NotShown { shown_by } => format!("these runs do not excite it; {shown_by} would"),
        Reason::Implausible { value } => {
            format!("its fitted value, {}, is outside the plausible range", three_digits(*value))
        }
        Reason::WorseKind { kind, loss } => format!(
            "fitted to the other kinds of runs, it raises the -2 log likelihood of {} runs by {loss:.1}",
            kind.name()
        ),
        Reason::InModel => "the model already explains nearly all of it".to_owned(),
        Reason::BlursGeometry { times } => format!(
            "these runs do not tell it from radii and track width: beside it, those are {times:.0} times as uncertain"
        ),
        Reason::OneRunByChance { gain } => {
            format!("only one run shows it, and not significantly (gain {gain:.1})")
        }
        Reason::PredictsWorse { loss } => {
            format!("raises the cross-validated -2 log likelihood by {loss:.1}")
        }
        Reason::FewGetBetter { touched, better } => {
            format!("only {better} of the {touched} runs that it affects are predicted better")
        }
        Reason::RunsDisagree { times, p_value } => format!(
            "the runs disagree about it {times:.0} times more than noise allows ({})",
            p_words(*p_value)
        ),
        Reason::Chance { tested, p_value } => {
            format!("not significant among {tested} candidates ({})", p_words(*p_value))
        }
        Reason::TracksNoBetter { p_value } => format!(
            "added to the model, it does not improve the cross-validated tracks (likelihood: {})",
            p_words(*p_value)
        ),
        Reason::SimplerPredictsBetter => {
            "radii and track width alone predict runs better than with it".to_owned()
        }
        Reason::DoesNotHold { p_value } => {
            format!(
                "beside the effects found, it or one of these fails its test ({})",
                p_words(*p_value)
            )
        }
    }
}

/// A number with three significant digits, with an exponent only where that is shorter to read.
fn three_digits(value: f64) -> String {
    let size = value.abs();
    if !(1e-4..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    let decimals = (2 - size.log10().floor() as i32).max(0);
    format!("{value:.*}", decimals.unsigned_abs() as usize)
}

/// What the runs lack in order to show an effect.
pub const fn lacking(need: Need) -> &'static str {
    match need {
        Need::YawRate => "no yaw rate was recorded (gyro_z_rad_s)",
        Need::StartTimes => "not every run has a start time (started_s in robot.toml)",
        Need::ContinuousCounts => {
            "counts restart at zero in every run, so wheel angles cannot be compared between runs"
        }
        Need::Load => "no run carries a load (payload_kg in robot.toml)",
    }
}

/// What the next run would show.
pub fn predicted(predicted: &PredictedSeparation) -> String {
    let sigmas = if predicted.sigmas >= 5.0 { "five" } else { "three" };
    let mut text = if predicted.pairs_apart == predicted.pairs() {
        format!(
            "their predicted tracks differ by at least {sigmas} sigma, whichever of them is real"
        )
    } else {
        format!(
            "of the {} pairs among {}, {} have predicted tracks that differ by {sigmas} sigma",
            predicted.pairs(),
            super::listed(&predicted.class),
            predicted.pairs_apart
        )
    };
    if predicted.needs_poses_along_the_way {
        text.push_str(", if poses are measured along the way, as by a camera");
    }
    text
}

/// What the residuals depend on, in a line.
pub fn depends_on(unexplained: &Unexplained) -> String {
    let word = |regressor: &Regressor| match unexplained.place_m {
        Some([x_m, y_m]) if *regressor == Regressor::Place => {
            format!("{} (where a wheel passes x = {x_m:.2} m, y = {y_m:.2} m)", regressor.name())
        }
        _ if *regressor == Regressor::Run && unexplained.runs_off.is_empty() => {
            "which run it is (it differs from run to run)".to_owned()
        }
        _ if *regressor == Regressor::Run => "which run it is".to_owned(),
        _ if unexplained.only_outliers() => {
            format!("{} (outliers of the measured poses)", regressor.name())
        }
        _ => regressor.name().to_owned(),
    };
    match unexplained.depends_on.as_slice() {
        [] if matches!(unexplained.driven_again, DrivenAgain::ComesBack(_)) => {
            "the motion: they come back when a run is driven again".to_owned()
        }
        [] => "no single variable".to_owned(),
        all => all.iter().map(word).collect::<Vec<_>>().join(", "),
    }
}

/// What the residuals may depend on, by too little to matter.
pub fn slight(unexplained: &Unexplained) -> Option<String> {
    let names: Vec<String> =
        unexplained.slight.iter().map(|regressor| regressor.name().to_owned()).collect();
    (!names.is_empty()).then(|| {
        format!("They may depend on {}, but by too little to matter.", super::listed(&names))
    })
}

/// What runs that were driven again say of the residuals, or would say.
pub fn driven_again(unexplained: &Unexplained) -> Option<String> {
    match (unexplained.driven_again, unexplained.random_turn_rad) {
        (DrivenAgain::ComesBack(m), _) => Some(format!(
            "{:.1} mm of the position error come back when a run is driven again: that is no noise.",
            1e3 * m
        )),
        // Some runs are off, or poses err as no robot does: that may well differ.
        (DrivenAgain::Differ, _) if unexplained.structure => None,
        (DrivenAgain::Differ, _) => {
            Some("Runs that were driven again differ by as much: that is noise.".to_owned())
        }
        (DrivenAgain::TooFew, Some(_)) if unexplained.structure => {
            Some("Drive one of these runs twice more: what comes back is no noise.".to_owned())
        }
        (DrivenAgain::TooFew, Some(turn_rad)) => Some(format!(
            "The robot turns at random by {:.0} mrad in a metre, which is much for noise: drive one of these runs twice more. What \
             comes back is no noise.",
            1e3 * turn_rad
        )),
        (DrivenAgain::TooFew, None) => None,
    }
}

/// The net change by an effect, in one number.
pub fn net_change(change: &NetChange) -> String {
    let side = |left: f64| if left > 0.0 { "left" } else { "right" };
    let share = |share: f64, what: &str| {
        let more = if share > 0.0 { "more" } else { "less" };
        format!("{:.2} % {more} {what} than the encoders report", 100.0 * share.abs())
    };
    match *change {
        NetChange::TurnPerMetre { rad_per_m, on } => {
            let ways = match on {
                Ways::Forwards => " forwards",
                Ways::Backwards => " backwards",
                Ways::Both => ", forwards and backwards",
                Ways::Opposite => " forwards, the opposite backwards",
            };
            let mrad_per_m = (rad_per_m * 1e3).abs();
            format!("{mrad_per_m:.2} mrad of turn to the {} per metre{ways}", side(rad_per_m))
        }
        NetChange::TurnShare(of) => share(of, "turn"),
        NetChange::TravelShare(of) => share(of, "travel"),
        NetChange::SidewaysPerMetre(left) => {
            format!("{:.1} mm to the {} per metre", 1e3 * left.abs(), side(left))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_little_to_matter_says_how_much_of_it_is_certain() {
        let step = |size_m, least_m| {
            let step = crate::empty_answer::step_of(&["side_slip"]);
            let sizes = StepFound { effect_size_m: size_m, least_size_m: least_m, ..step };
            worth(&StepFound { matters: false, ..sizes })
        };
        assert_eq!(
            step(3e-4, 5e-5),
            "it moves the robot by 0.30 mm (rms) in these runs, of which 0.05 mm are certain: too little to matter"
        );
        assert_eq!(
            step(6e-5, 5.5e-5),
            "it moves the robot by 0.06 mm (rms) in these runs: too little to matter"
        );
    }

    #[test]
    fn an_effect_that_predicts_nothing_says_why() {
        let step = crate::empty_answer::step_of(&["backlash"]);
        let step = StepFound { effect_size_m: 5e-4, matters: true, used_to_predict: false, ..step };
        assert_eq!(
            worth(&step),
            "it moves the robot by 0.50 mm (rms) in these runs, less than is left unexplained: it may be something else, so a saved \
             model goes without it"
        );
        assert_eq!(
            reason(&Reason::BlursGeometry { times: 50.3 }),
            "these runs do not tell it from radii and track width: beside it, those are 50 times as uncertain"
        );
    }

    #[test]
    fn what_an_effect_comes_to_is_one_plain_number() {
        let turn = |rad_per_m, on| NetChange::TurnPerMetre { rad_per_m, on };
        for (change, text) in [
            (
                turn(0.008, Ways::Both),
                "8.00 mrad of turn to the left per metre, forwards and backwards",
            ),
            (
                turn(-0.01, Ways::Opposite),
                "10.00 mrad of turn to the right per metre forwards, the opposite backwards",
            ),
            (turn(0.002, Ways::Forwards), "2.00 mrad of turn to the left per metre forwards"),
            (NetChange::TurnShare(-0.0196), "1.96 % less turn than the encoders report"),
            (NetChange::TravelShare(0.005), "0.50 % more travel than the encoders report"),
            (NetChange::SidewaysPerMetre(-0.002), "2.0 mm to the right per metre"),
        ] {
            assert_eq!(net_change(&change), text);
        }
    }

    #[test]
    fn what_runs_that_were_driven_again_say_is_said() {
        let of = |driven_again, random_turn_rad| Unexplained {
            driven_again,
            random_turn_rad,
            ..Unexplained::default()
        };
        let back = of(DrivenAgain::ComesBack(0.0063), None);
        assert_eq!(
            driven_again(&back).unwrap(),
            "6.3 mm of the position error come back when a run is driven again: that is no noise."
        );
        assert_eq!(depends_on(&back), "the motion: they come back when a run is driven again");
        let differ = driven_again(&of(DrivenAgain::Differ, None)).unwrap();
        assert_eq!(differ, "Runs that were driven again differ by as much: that is noise.");
        let much = driven_again(&of(DrivenAgain::TooFew, Some(0.0172))).unwrap();
        assert!(
            much.starts_with("The robot turns at random by 17 mrad in a metre, which is much"),
            "{much}"
        );
        assert_eq!(driven_again(&of(DrivenAgain::TooFew, None)), None);
    }

    #[test]
    fn what_may_be_there_and_is_too_small_is_said_to_be_that() {
        let found = Unexplained { slight: vec![Regressor::TurnRate], ..Unexplained::default() };
        let text = "They may depend on turn rate, but by too little to matter.";
        assert_eq!(slight(&found).unwrap(), text);
        assert_eq!(slight(&Unexplained::default()), None);
    }

    #[test]
    fn numbers_are_written_as_a_person_would() {
        for (value, text) in [
            (-0.1372, "-0.137"),
            (12.0, "12.0"),
            (1234.6, "1235"),
            (0.000_51, "0.000510"),
            (-2.5e-5, "-2.50e-5"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(three_digits(value), text);
        }
    }

    #[test]
    fn a_place_is_said_with_where_it_is() {
        let found = Unexplained {
            depends_on: vec![Regressor::Speed, Regressor::Place],
            place_m: Some([0.5, -0.25]),
            ..Unexplained::default()
        };
        let text = "speed, place (where a wheel passes x = 0.50 m, y = -0.25 m)";
        assert_eq!(depends_on(&found), text);
    }
}
