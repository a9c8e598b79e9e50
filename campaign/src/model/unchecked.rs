//! `model.toml` as it is written, before anything is checked.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawModel {
    #[serde(default)]
    pub(super) effect: Vec<RawEffect>,
    #[serde(default)]
    pub(super) custom: Vec<RawCustom>,
    pub(super) error: Option<RawErrors>,
    pub(super) noise: Option<RawNoise>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEffect {
    pub(super) id: Spanned<String>,
    #[serde(default)]
    pub(super) in_use: bool,
    pub(super) up_to_mps: Option<Spanned<f64>>,
    #[serde(default)]
    pub(super) parameters: BTreeMap<String, Spanned<RawParameter>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawParameter {
    pub(super) value: Spanned<f64>,
    pub(super) sigma: Option<Spanned<f64>>,
    pub(super) low95: Option<Spanned<f64>>,
    pub(super) high95: Option<Spanned<f64>>,
    pub(super) unit: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCustom {
    pub(super) id: Spanned<String>,
    pub(super) target: Spanned<String>,
    pub(super) per: Spanned<String>,
    pub(super) expression: Spanned<String>,
    #[serde(default)]
    pub(super) unit: BTreeMap<String, Spanned<String>>,
    #[serde(default)]
    pub(super) range: BTreeMap<String, Spanned<[f64; 2]>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawErrors {
    pub(super) runs: usize,
    pub(super) nominal: RawError,
    // Version 0.1.0 wrote `heldout` for what is cross-validated.
    #[serde(alias = "nominal_heldout")]
    pub(super) nominal_cross_validated: RawError,
    pub(super) train: RawError,
    #[serde(alias = "heldout")]
    pub(super) cross_validated: RawError,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawError {
    pub(super) position_rms_m: Spanned<f64>,
    pub(super) heading_rms_rad: Spanned<f64>,
    pub(super) chi: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawNoise {
    pub(super) position_sigma_m: Spanned<f64>,
    pub(super) heading_sigma_rad: Spanned<f64>,
    pub(super) travel_walk: Spanned<f64>,
    pub(super) heading_walk: Spanned<f64>,
    pub(super) position_wobble_m: Spanned<f64>,
    pub(super) heading_wobble_rad: Spanned<f64>,
    pub(super) wobble_s: Spanned<f64>,
    pub(super) gyro_walk: Spanned<f64>,
    pub(super) heading_offset_rad: Spanned<f64>,
    pub(super) clock_offset_s: Spanned<f64>,
}
