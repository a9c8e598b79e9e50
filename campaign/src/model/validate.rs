//! Which numbers of a `model.toml` make no sense. A value that is merely implausible is accepted:
//! the data will show whether it is wrong.

use std::path::Path;

use robot_model::effect::{Parameter, Role, find};
use robot_model::estimation::{ErrorPair, Errors, SIGMAS_95};
use robot_model::explain::ParameterFound;
use robot_model::recording::OdometryNoise;
use toml::Spanned;

use super::unchecked::{RawError, RawErrors, RawNoise, RawParameter};
use crate::{CampaignError, Place};

/// A value beyond this many times the greatest plausible one makes no sense.
const FAR_OUT: f64 = 1000.0;

/// A number that makes no sense: its place, the problem and what to try.
pub(super) struct Invalid {
    byte: usize,
    problem: String,
    hint: String,
}

impl Invalid {
    fn new<T>(at: &Spanned<T>, problem: String, hint: impl Into<String>) -> Self {
        Self { byte: at.span().start, problem, hint: hint.into() }
    }

    /// The error with its place in a file of this text.
    pub(super) fn at(self, file: &Path, text: &str) -> CampaignError {
        CampaignError::new(Place::of_byte(file, text, self.byte), self.problem, self.hint)
    }
}

/// A parameter of the effect of this id.
pub(super) fn parameter(
    id: &str,
    known: &Parameter,
    raw: &Spanned<RawParameter>,
) -> Result<ParameterFound, Invalid> {
    let (whole, raw, name) = (raw, raw.get_ref(), &known.name);
    let wrong_unit = raw.unit.as_ref().filter(|unit| *unit.get_ref() != known.unit);
    if let Some(unit) = wrong_unit {
        let problem = format!("{name} of {id} has the unit {}, not {}", known.unit, unit.get_ref());
        return Err(Invalid::new(unit, problem, format!("give the value in {}", known.unit)));
    }
    for number in [Some(&raw.value), raw.sigma.as_ref(), raw.low95.as_ref(), raw.high95.as_ref()] {
        if let Some(number) = number.filter(|number| !number.get_ref().is_finite()) {
            let problem = format!("{name} has a number that is not finite");
            return Err(Invalid::new(number, problem, fit_again()));
        }
    }
    let value = *raw.value.get_ref();
    if let Some(must) = impossible(id, known, value) {
        let problem = format!("{name} = {value} is impossible for {id}");
        return Err(Invalid::new(&raw.value, problem, format!("it must be {must}")));
    }
    let sigma = raw.sigma.as_ref().map_or(0.0, |sigma| *sigma.get_ref());
    if let Some(negative) = raw.sigma.as_ref().filter(|_| sigma < 0.0) {
        let problem = format!("sigma = {sigma} is negative");
        return Err(Invalid::new(negative, problem, "a standard error must not be negative"));
    }
    let end = |given: Option<&Spanned<f64>>, sigmas: f64| {
        given.map_or(value + sigmas * sigma, |end| *end.get_ref())
    };
    let (low95, high95) =
        (end(raw.low95.as_ref(), -SIGMAS_95), end(raw.high95.as_ref(), SIGMAS_95));
    if low95 > high95 {
        let problem = format!("low95 = {low95} lies above high95 = {high95}");
        let place = raw.low95.as_ref().or(raw.high95.as_ref());
        let byte = place.map_or(whole.span().start, |end| end.span().start);
        return Err(Invalid { byte, problem, hint: "swap them, or leave them out".into() });
    }
    let (name, unit) = (name.to_string(), known.unit.to_string());
    Ok(ParameterFound { name, unit, value, sigma, low95, high95 })
}

fn fit_again() -> String {
    "remove it, and `beeline model fit CAMPAIGN` fits it again".into()
}

/// What a parameter of the catalogue must be, if this value of it makes no sense: a wheel or a
/// track without width, a turn in the opposite direction, a length that is not positive.
fn impossible(id: &str, known: &Parameter, value: f64) -> Option<String> {
    find(id)?;
    let (low, high) = known.possible;
    // A shape that may be negative, such as a lever, has no such bound.
    if known.role == Role::Shape && value <= 0.0 && known.low >= 0.0 {
        Some("above zero".to_owned())
    } else if value <= low || value >= high {
        Some(if high.is_finite() {
            format!("between {low} and {high}")
        } else {
            format!("above {low}")
        })
    } else if value.abs() > FAR_OUT * known.low.abs().max(known.high.abs()) {
        Some("a plausible number; check its unit".to_owned())
    } else {
        None
    }
}

/// The speed up to which an effect is known.
pub(super) fn speed_limit(limit: &Spanned<f64>) -> Result<f64, Invalid> {
    let value = *limit.get_ref();
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    let problem = format!("up_to_mps = {value} is invalid");
    Err(Invalid::new(limit, problem, "it must be a speed above zero, in m/s; or remove this line"))
}

/// A number that is finite and not negative.
fn size(number: &Spanned<f64>, name: &str) -> Result<f64, Invalid> {
    let value = *number.get_ref();
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    let problem = format!("{name} = {value} is invalid");
    let hint = "it must be a finite number, and not negative; remove [error] and [noise], and \
                `beeline model fit CAMPAIGN` computes both again";
    Err(Invalid::new(number, problem, hint))
}

/// The number of runs, and the errors of the nominal robot and of the model.
pub(super) fn errors(raw: &RawErrors) -> Result<(usize, ErrorPair, ErrorPair), Invalid> {
    let errors = |raw: &RawError| {
        Ok(Errors {
            position_rms_m: size(&raw.position_rms_m, "position_rms_m")?,
            heading_rms_rad: size(&raw.heading_rms_rad, "heading_rms_rad")?,
            chi: size(&raw.chi, "chi")?,
        })
    };
    let nominal = ErrorPair {
        fitted: errors(&raw.nominal)?,
        cross_validated: errors(&raw.nominal_cross_validated)?,
    };
    let model =
        ErrorPair { fitted: errors(&raw.train)?, cross_validated: errors(&raw.cross_validated)? };
    Ok((raw.runs, nominal, model))
}

/// The noise.
pub(super) fn noise(raw: &RawNoise) -> Result<OdometryNoise, Invalid> {
    Ok(OdometryNoise {
        position_sigma_m: size(&raw.position_sigma_m, "position_sigma_m")?,
        heading_sigma_rad: size(&raw.heading_sigma_rad, "heading_sigma_rad")?,
        travel_walk: size(&raw.travel_walk, "travel_walk")?,
        heading_walk: size(&raw.heading_walk, "heading_walk")?,
        position_wobble_m: size(&raw.position_wobble_m, "position_wobble_m")?,
        heading_wobble_rad: size(&raw.heading_wobble_rad, "heading_wobble_rad")?,
        wobble_s: size(&raw.wobble_s, "wobble_s")?,
        gyro_walk: size(&raw.gyro_walk, "gyro_walk")?,
        heading_offset_rad: size(&raw.heading_offset_rad, "heading_offset_rad")?,
        clock_offset_s: size(&raw.clock_offset_s, "clock_offset_s")?,
    })
}
