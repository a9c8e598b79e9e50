//! `beeline wheel-weight`: the paper's calculation on numbers from the command line.

use robot_model::calibration::{Deviation, Experiment, WheelWeight};
use robot_model::kinematics::{Geometry, WheelPair};
use serde_json::{Value, json};
use shared_proto::{Config, GeometryConfig};

use crate::calibrate::plausibility;
use crate::cli::{Common, WheelWeightArgs};
use crate::error::{Error, Result};
use crate::limits;
use crate::quantity::LengthUnit;
use crate::ui::{BOLD, DIM, paint, say, warn};
use crate::words;

pub(super) fn run(common: &Common, args: &WheelWeightArgs) -> Result<()> {
    let geometry = Geometry {
        wheel_radius_m: args.radius.m,
        track_width_m: args.track_width.m,
        counts_per_wheel_rev: args.counts_per_rev,
        wheel_radius_sigma_m: 0.0,
        track_width_sigma_m: 0.0,
    };
    let turns = match (args.left_counts, args.right_counts) {
        (Some(left), Some(right)) => geometry.turns(left, right),
        _ => WheelPair::both(std::f64::consts::TAU * args.revolutions),
    };
    let sigma_m = args.sigma.m;
    let deviation = match (args.dx, args.dy, args.lateral) {
        (Some(dx), Some(dy), _) => Deviation::Tangent { dx_m: dx.m, dy_m: dy.m, sigma_m },
        (_, _, Some(lateral)) => Deviation::LateralOffset { y_m: lateral.m, sigma_m },
        _ => return Err(Error::new("give --dx and --dy, or --lateral")),
    };
    let start_heading_sigma_rad = args.start_heading.rad;
    let experiment = Experiment { deviation, turns, geometry, start_heading_sigma_rad };
    let weight = experiment.wheel_weight().map_err(|error| {
        Error::new(words::wheel_weight_error(&error)).hint("check the numbers and their units")
    })?;
    // The checks of a calibration on the robot itself.
    plausibility::check(GeometryConfig {
        wheel_radius_m: args.radius.m,
        track_width_m: args.track_width.m,
        wheel_weight: weight.value,
        ..Config::default().geometry
    })?;
    let rolled_m = args.radius.m * turns.left.abs().min(turns.right.abs());
    limits::check_length(rolled_m, args.track_width.m)?;
    let doubt = plausibility::doubt(weight.value).or(plausibility::vague(weight.sigma));
    if common.json {
        let mut value = to_json(&weight, &geometry);
        value["doubt"] = json!(doubt);
        say(value);
    } else {
        show(&weight, &geometry);
        doubt.into_iter().for_each(warn);
    }
    Ok(())
}

/// W_T as JSON.
pub(super) fn to_json(weight: &WheelWeight, geometry: &Geometry) -> Value {
    let parts: Vec<_> = weight
        .contributions
        .iter()
        .map(|part| json!({"source": words::source(part.source), "sigma": part.sigma}))
        .collect();
    json!({
        "wheel_weight": {
            "value": weight.value,
            "sigma": weight.sigma,
            "low95": weight.low95,
            "high95": weight.high95,
        },
        "right_radius_m": weight.right_radius_m(geometry),
        "alpha_rad": weight.alpha_rad,
        "alpha_sigma_rad": weight.alpha_sigma_rad,
        "contributions": parts,
        "advice": words::advice(&weight.advice),
    })
}

/// Prints W_T as text.
pub(super) fn show(weight: &WheelWeight, geometry: &Geometry) {
    let row = |name: &str, value: String| say(format_args!("{name:>8}  {value}"));
    row(
        "alpha",
        format!(
            "{:.4} ± {:.4} rad, to the right positive",
            weight.alpha_rad, weight.alpha_sigma_rad
        ),
    );
    let value = paint(BOLD, format_args!("{:.4}", weight.value));
    row(
        "W_T",
        format!(
            "{value} ± {:.4}, 95 % from {:.4} to {:.4}",
            weight.sigma, weight.low95, weight.high95
        ),
    );
    let radius_m = weight.right_radius_m(geometry);
    row("R_R", LengthUnit::Cm.format(radius_m, 4));
    for part in &weight.contributions {
        let share = (part.sigma / weight.sigma).powi(2) * 100.0;
        let text = format!(
            "{:<24} {:.6}  {share:>3.0} % of the variance",
            words::source(part.source),
            part.sigma
        );
        row("", paint(DIM, text));
    }
    for suggestion in words::advice(&weight.advice).split("; ") {
        row("", suggestion.into());
    }
}
