//! A comparison in words.

use robot_model::compare::{
    Axis, Comparison, Component, Drift, ErrorLevel, Label, Regime, RegimeError, WorstGroup,
};

/// The name of a regime.
pub const fn regime(regime: Regime) -> &'static str {
    match regime {
        Regime::RunKind => "run kind",
        Regime::Path => "path",
        Regime::RampOrCruise => "ramp or cruise",
        Regime::TravelDirection => "direction of travel",
        Regime::TurnDirection => "turn direction",
        Regime::Speed => "speed",
        Regime::Heading => "heading",
        Regime::LeftWheelAngle => "left wheel's angle",
        Regime::RightWheelAngle => "right wheel's angle",
    }
}

/// The name of a kind of stretches.
pub fn label(label: Label) -> String {
    match label {
        Label::Kind(kind) => kind.name().to_owned(),
        Label::Straight => "straight".to_owned(),
        Label::Arc => "arc".to_owned(),
        Label::OnTheSpot => "on the spot".to_owned(),
        Label::Ramp => "ramp".to_owned(),
        Label::Cruise => "cruise".to_owned(),
        Label::Forward => "forward".to_owned(),
        Label::Backward => "backward".to_owned(),
        Label::Left => "left".to_owned(),
        Label::Right => "right".to_owned(),
        Label::Speed { above: None, to: None } => "all".to_owned(),
        Label::Speed { above: None, to: Some(high) } => format!("below {high:.2} m/s"),
        Label::Speed { above: Some(low), to: Some(high) } => format!("{low:.2} to {high:.2} m/s"),
        Label::Speed { above: Some(low), to: None } => format!("above {low:.2} m/s"),
        Label::Facing(deg) => format!("about {deg} deg"),
        Label::Quadrant(from_deg) => format!("{from_deg} to {} deg", from_deg + 90),
    }
}

/// The label of an axis.
pub const fn axis(axis: Axis) -> &'static str {
    match axis {
        Axis::Speed => "speed in m/s",
        Axis::TurnRate => "turn rate in rad/s",
        Axis::Acceleration => "acceleration of the robot's centre in m/s\u{b2}",
        Axis::RimSpeed => "speed of the faster wheel in m/s",
        Axis::Heading => "heading in degrees",
        Axis::LeftWheelAngle => "angle of the left wheel in degrees",
        Axis::RightWheelAngle => "angle of the right wheel in degrees",
        Axis::SinceReversal => "distance since the last reversal in m",
        Axis::TimeInRun => "time in the run in s",
        Axis::TimeInCampaign => "time in the campaign in s",
    }
}

/// The main finding, in one or two sentences.
pub fn finding(comparison: &Comparison) -> String {
    let finding = &comparison.finding;
    let who = if finding.nominal { "The nominal robot" } else { "The model" };
    let (position_m, heading_rad) = (comparison.position_m.rms, comparison.heading_rad.rms);
    let (mm, mrad) = (position_m * 1e3, heading_rad * 1e3);
    let size = if heading_rad > 0.0 {
        format!("{mm:.1} mm and {mrad:.1} mrad")
    } else {
        format!("{mm:.1} mm")
    };
    let worst = finding.worst.as_ref().map(|worst| worst_group(comparison, worst));
    match (finding.error_level, worst) {
        (ErrorLevel::NotFinite, _) => {
            format!("{who} predicts no finite track: one of its values makes no sense.")
        }
        (ErrorLevel::NoPositions, _) => {
            "No positions were measured, so there is nothing to compare with.".to_owned()
        }
        (ErrorLevel::WithinNoise, None) => {
            format!("{who} is off by {size}, which noise alone explains.")
        }
        (ErrorLevel::WithinNoise, Some(worst)) => format!(
            "{who} is off by {size}, which noise alone explains over whole runs; but {worst}."
        ),
        (ErrorLevel::TimesNoise(times), worst) => {
            let start = format!("{who} is off by {size}, {times:.1} times what noise explains");
            match worst {
                Some(worst) => format!("{start}: {worst}."),
                None => format!("{start}; no single regime stands out."),
            }
        }
    }
}

fn worst_group(comparison: &Comparison, worst: &WorstGroup) -> String {
    let grouping = &comparison.regimes[worst.grouping];
    let group = &grouping.groups[worst.group];
    let place = place(grouping.regime, group);
    let Some(drift) = worst.drift else {
        let (mm, mrad) = (group.position_m.rms * 1e3, group.heading_rad.rms * 1e3);
        return format!(
            "it is worst {place}, {mm:.1} mm and {mrad:.1} mrad over {:.2} m of wheel travel, {:.1} times the noise",
            group.rolled_m, group.chi
        );
    };
    let flips = match grouping.regime {
        Regime::TravelDirection | Regime::TurnDirection if worst.flips => {
            ", and the opposite in the other direction"
        }
        _ if worst.flips => ", and the opposite elsewhere",
        _ => "",
    };
    format!(
        "it is worst {place}, where {} per metre of wheel travel{flips}",
        drift_in_words(&drift)
    )
}

/// Where a group's stretches are.
fn place(of: Regime, group: &RegimeError) -> String {
    let name = label(group.label);
    match (of, group.label) {
        (_, Label::Kind(_)) => format!("in {name} runs"),
        (_, Label::Straight) => "on straights".to_owned(),
        (_, Label::Arc) => "in arcs".to_owned(),
        (_, Label::OnTheSpot) => "on the spot".to_owned(),
        (_, Label::Ramp) => "on ramps".to_owned(),
        (_, Label::Cruise) => "at cruise".to_owned(),
        (_, Label::Forward | Label::Backward) => name,
        (_, Label::Left | Label::Right) => format!("in turns to the {name}"),
        (_, Label::Speed { .. }) => format!("at speeds {name}"),
        (_, Label::Facing(_)) => format!("at headings {name}"),
        (of, Label::Quadrant(_)) => format!("at {} {name}", regime(of)),
    }
}

/// A systematic error in words.
fn drift_in_words(drift: &Drift) -> String {
    let size = drift.per_m.abs() * 1e3;
    match (drift.component, drift.per_m > 0.0) {
        (Component::Turn, true) => {
            format!("the robot turns {size:.1} mrad further left than predicted")
        }
        (Component::Turn, false) => {
            format!("the robot turns {size:.1} mrad further right than predicted")
        }
        (Component::Ahead, true) => {
            format!("the robot gets {size:.1} mm further ahead than predicted")
        }
        (Component::Ahead, false) => format!("the robot stays {size:.1} mm behind the prediction"),
        (Component::Left, true) => format!("the robot drifts {size:.1} mm to the left"),
        (Component::Left, false) => format!("the robot drifts {size:.1} mm to the right"),
    }
}
