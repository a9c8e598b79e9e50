//! A piece of a run as a line of `plan.toml`.
//!
//! What is read has the digits of what is written, so that a plan that is written and read again is the same.

use robot_model::recording::Piece;
use serde::Deserialize;

use crate::range;

/// A piece as it stands in the file.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPiece {
    straight_m: Option<f64>,
    spin_deg: Option<f64>,
    arc_deg: Option<f64>,
    radius_m: Option<f64>,
    speed_mps: Option<f64>,
    rest_s: Option<f64>,
}

/// A piece, or what is wrong with it.
pub(super) fn parse(raw: &RawPiece) -> Result<Piece, String> {
    let RawPiece { straight_m, spin_deg, arc_deg, radius_m, speed_mps, rest_s } = *raw;
    let speed = || match speed_mps {
        Some(speed_mps) => number("speed_mps", speed_mps),
        None => Err("speed_mps is missing".to_owned()),
    };
    match (straight_m, spin_deg, arc_deg, radius_m, rest_s) {
        (Some(travel_m), None, None, None, None) => {
            Ok(Piece::Straight { travel_m: far("straight_m", travel_m)?, speed_mps: speed()? })
        }
        (None, Some(deg), None, None, None) => {
            Ok(Piece::Spin { turn_rad: far("spin_deg", deg)?.to_radians(), speed_mps: speed()? })
        }
        (None, None, Some(deg), Some(radius_m), None) => Ok(Piece::Arc {
            radius_m: number("radius_m", radius_m)?,
            turn_rad: far("arc_deg", deg)?.to_radians(),
            speed_mps: speed()?,
        }),
        (None, None, None, None, Some(duration_s)) => {
            if speed_mps.is_some() {
                return Err("a rest has no speed".into());
            }
            Ok(Piece::Rest { duration_s: number("rest_s", duration_s)? })
        }
        (None, None, Some(_), None, None) => Err("an arc needs radius_m".into()),
        _ => Err("a piece is one of straight, spin, arc and rest".into()),
    }
}

/// A number of this key, to the digits that are written.
fn number(key: &str, value: f64) -> Result<f64, String> {
    match range::of_plan_key(key).filter(|range| !range.contains(value)) {
        None => Ok(short(value)),
        Some(range) => Err(format!("{key} = {} must be {range}", range::short(value))),
    }
}

/// A distance or a turn, which has either sign and is not zero.
fn far(key: &str, value: f64) -> Result<f64, String> {
    number(key, value.abs()).map(|size| size.copysign(value)).map_err(|_| {
        let range = range::of_plan_key(key).map(|range| range.to_string()).unwrap_or_default();
        format!(
            "{key} = {} must be a number, and not zero: {range}, either way",
            range::short(value)
        )
    })
}

/// A piece as a line of the file.
pub(super) fn line(piece: &Piece) -> String {
    match *piece {
        Piece::Straight { travel_m, speed_mps } => {
            let (travel_m, speed_mps) = (short(travel_m), short(speed_mps));
            format!("{{ straight_m = {travel_m}, speed_mps = {speed_mps} }}")
        }
        Piece::Spin { turn_rad, speed_mps } => {
            format!("{{ spin_deg = {}, speed_mps = {} }}", degrees(turn_rad), short(speed_mps))
        }
        Piece::Arc { radius_m, turn_rad, speed_mps } => {
            let deg = degrees(turn_rad);
            let (radius_m, speed_mps) = (short(radius_m), short(speed_mps));
            format!("{{ arc_deg = {deg}, radius_m = {radius_m}, speed_mps = {speed_mps} }}")
        }
        Piece::Rest { duration_s } => format!("{{ rest_s = {} }}", short(duration_s)),
    }
}

/// Rounded to micrometres, so that nobody has to read 0.24499999999999997.
fn short(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// Degrees without the last digits, which are rounding errors.
pub(super) fn degrees(rad: f64) -> f64 {
    (rad.to_degrees() * 1e9).round() / 1e9
}
