//! Refuses numbers of a `model.toml` that make no sense. What is merely implausible is left to be judged by
//! the data.

use std::path::Path;

use robot_model::effect::{Parameter, Role, find};
use robot_model::estimation::OdometryNoise;
use robot_model::estimation::{ErrorPair, Errors};
use robot_model::explain::ParameterFound;
use toml::Spanned;

use super::raw::{RawError, RawErrors, RawNoise, RawParameter};
use crate::{CampaignError, Place};

/// So many times the greatest plausible value is no value.
const FAR_OUT: f64 = 1000.0;

/// A number that makes no sense: where, what, and what to do.
pub(super) struct Invalid {
    byte: usize,
    problem: String,
    hint: String,
}

impl Invalid {
    fn new<T>(it: &Spanned<T>, problem: String, hint: impl Into<String>) -> Self {
        Self { byte: it.span().start, problem, hint: hint.into() }
    }

    /// The same with its place in a file of this text.
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
    let unit = raw.unit.as_ref().filter(|it| *it.get_ref() != known.unit);
    if let Some(it) = unit {
        let problem = format!("{name} of {id} has the unit {}, not {}", known.unit, it.get_ref());
        return Err(Invalid::new(it, problem, format!("give the value in {}", known.unit)));
    }
    for it in [Some(&raw.value), raw.sigma.as_ref(), raw.low95.as_ref(), raw.high95.as_ref()] {
        if let Some(it) = it.filter(|it| !it.get_ref().is_finite()) {
            let problem = format!("{name} has a number that is not finite");
            return Err(Invalid::new(it, problem, fit_again()));
        }
    }
    let value = *raw.value.get_ref();
    if let Some(must) = impossible(id, known, value) {
        let problem = format!("{name} = {value} is impossible for {id}");
        return Err(Invalid::new(&raw.value, problem, format!("it must be {must}")));
    }
    let sigma = raw.sigma.as_ref().map_or(0.0, |it| *it.get_ref());
    if let Some(it) = raw.sigma.as_ref().filter(|_| sigma < 0.0) {
        let problem = format!("sigma = {sigma} is negative");
        return Err(Invalid::new(it, problem, "a standard error must not be negative"));
    }
    let end = |it: Option<&Spanned<f64>>, sigmas: f64| {
        it.map_or(value + sigmas * sigma, |it| *it.get_ref())
    };
    let (low95, high95) = (end(raw.low95.as_ref(), -1.96), end(raw.high95.as_ref(), 1.96));
    if low95 > high95 {
        let problem = format!("low95 = {low95} lies above high95 = {high95}");
        let place = raw.low95.as_ref().or(raw.high95.as_ref());
        let byte = place.map_or(whole.span().start, |it| it.span().start);
        return Err(Invalid { byte, problem, hint: "swap them, or leave them out".into() });
    }
    let (name, unit) = (name.to_string(), known.unit.to_string());
    Ok(ParameterFound { name, unit, value, sigma, low95, high95 })
}

fn fit_again() -> String {
    "remove it, and `beeline model fit CAMPAIGN` fits it again".into()
}

/// What a value of the catalogue's has to be, where it makes no sense as it is: a wheel or a track of no
/// width at all, a turn the other way round, a length that is none.
fn impossible(id: &str, known: &Parameter, value: f64) -> Option<String> {
    find(id)?;
    let (low, high) = known.possible;
    // A place that has a sign, as a lever, may be anywhere.
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

/// A number that is finite and not negative.
fn size(it: &Spanned<f64>, name: &str) -> Result<f64, Invalid> {
    let value = *it.get_ref();
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    let problem = format!("{name} = {value} is invalid");
    let hint = "it must be a finite number, and not negative; remove [error] and [noise], and \
                `beeline model fit CAMPAIGN` computes both again";
    Err(Invalid::new(it, problem, hint))
}

/// How many runs, and the errors of the nominal robot and of the model.
pub(super) fn errors(raw: &RawErrors) -> Result<(usize, ErrorPair, ErrorPair), Invalid> {
    let errors = |it: &RawError| {
        Ok(Errors {
            position_rms_m: size(&it.position_rms_m, "position_rms_m")?,
            heading_rms_rad: size(&it.heading_rms_rad, "heading_rms_rad")?,
            chi: size(&it.chi, "chi")?,
        })
    };
    let nominal =
        ErrorPair { train: errors(&raw.nominal)?, cross_validated: errors(&raw.nominal_heldout)? };
    let model = ErrorPair { train: errors(&raw.train)?, cross_validated: errors(&raw.heldout)? };
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
