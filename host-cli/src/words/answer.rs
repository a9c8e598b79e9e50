//! What `explain` answers, in words.

use robot_model::effect::{Need, NetChange, Ways};
use robot_model::explain::{Promise, Reason, StepFound};
use robot_model::residuals::{Regressor, Unexplained};

use super::p_text;

/// Why an effect is believed; no full stop.
pub fn why(step: &StepFound) -> String {
    let why = &step.why;
    let gain = if why.one_run_alone {
        format!(
            "only one run shows it, and that is explained better by {:.0} in -2 log likelihood",
            why.gain
        )
    } else {
        format!(
            "with it, runs held out are predicted better by {:.0} in -2 log likelihood",
            why.gain
        )
    };
    let (left, rivals) = match &step.class[..] {
        [] | [_] => (
            format!("Without it there is left: {}", why.signature),
            "nothing else that was asked about explains it as well".to_owned(),
        ),
        [_, rivals @ ..] => (
            format!("Without one of these there is left what looks like this: {}", why.signature),
            format!("these data cannot tell it from {}", rivals.join(", ")),
        ),
    };
    format!("{left}; {gain}; {rivals}")
}

/// Why an effect is not believed.
pub fn reason(reason: &Reason) -> String {
    match reason {
        Reason::Lacking(need) => lacking(*need).to_owned(),
        Reason::NotShown { shown_by } => format!("these runs do not show it; {shown_by} would"),
        Reason::Implausible { value } => {
            format!("its value would be {value:.2e}, which no robot has")
        }
        Reason::WorseKind { kind, loss } => format!(
            "fitted to other kinds of runs it makes {} runs worse, by {loss:.1}",
            kind.name()
        ),
        Reason::InModel => "what it does is nearly all in what the model has already".to_owned(),
        Reason::OneRunByChance { gain } => {
            format!("only one run shows it, and that by no more than chance ({gain:+.1})")
        }
        Reason::PredictsWorse { loss } => {
            format!("runs held out are predicted worse with it, by {loss:.1}")
        }
        Reason::FewGetBetter { touched, better } => {
            format!("of the {touched} runs that it touches {better} get better")
        }
        Reason::RunsDisagree { times, p_value } => format!(
            "runs disagree about it {times:.0} times more than their noise ({})",
            p_text(*p_value)
        ),
        Reason::Chance { tested, p_value } => format!(
            "no more than chance gives where {tested} effects are asked about ({})",
            p_text(*p_value)
        ),
        Reason::TracksNoBetter { p_value } => format!(
            "beside the model it makes tracks of runs held out no better ({} by their likelihood)",
            p_text(*p_value)
        ),
        Reason::DoesNotHold { p_value } => {
            format!("beside the model that was found it does not hold ({})", p_text(*p_value))
        }
    }
}

/// What the runs lack in order to show an effect.
pub const fn lacking(need: Need) -> &'static str {
    match need {
        Need::YawRate => "no yaw rate was recorded (gyro_z_rad_s)",
        Need::StartTimes => "not every run says when it began (started_s in robot.toml)",
        Need::ContinuousCounts => {
            "counts begin anew in every run, so that an angle of a wheel is another one in each"
        }
        Need::Load => "no run carries a load (payload_kg in robot.toml)",
    }
}

/// What the next run would show.
pub fn promise(promise: &Promise) -> String {
    let sigmas = if promise.sigmas >= 5.0 { "five" } else { "three" };
    let mut text = if promise.pairs_apart == promise.pairs() {
        format!(
            "there they predict tracks at least {sigmas} sigma apart, whichever of them is true"
        )
    } else {
        format!(
            "of the {} pairs that {} make, {} predict tracks {sigmas} sigma apart there",
            promise.pairs(),
            promise.class.join(", "),
            promise.pairs_apart
        )
    };
    if promise.needs_poses_along_the_way {
        text.push_str(", if poses are measured along the way, as a camera does");
    }
    text
}

/// What the residuals depend on, in a line.
pub fn depends_on(unexplained: &Unexplained) -> String {
    let word = |regressor: &Regressor| match unexplained.place_m {
        Some([x_m, y_m]) if *regressor == Regressor::Place => format!(
            "{} (where a wheel comes near x = {x_m:.2} m, y = {y_m:.2} m)",
            regressor.name()
        ),
        _ => regressor.name().to_owned(),
    };
    unexplained.depends_on.iter().map(word).collect::<Vec<_>>().join(", ")
}

/// What an effect comes to, in one number.
pub fn net_change(change: &NetChange) -> String {
    let side = |left: f64| if left > 0.0 { "left" } else { "right" };
    let share = |share: f64, what: &str| {
        let more = if share > 0.0 { "more" } else { "less" };
        format!("{:.2} % {more} {what} than the wheels tell", 100.0 * share.abs())
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
            (NetChange::TurnShare(-0.0196), "1.96 % less turn than the wheels tell"),
            (NetChange::TravelShare(0.005), "0.50 % more travel than the wheels tell"),
            (NetChange::SidewaysPerMetre(-0.002), "2.0 mm to the right per metre"),
        ] {
            assert_eq!(net_change(&change), text);
        }
    }

    #[test]
    fn a_place_is_said_with_where_it_is() {
        let found = Unexplained {
            depends_on: vec![Regressor::Speed, Regressor::Place],
            place_m: Some([0.5, -0.25]),
            ..Unexplained::default()
        };
        let text = "speed, place (where a wheel comes near x = 0.50 m, y = -0.25 m)";
        assert_eq!(depends_on(&found), text);
    }
}
