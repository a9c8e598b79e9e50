//! The catalogue: every effect that is built in. To add one: a file beside this one, and a line here.

use super::Effect;

/// All effects, in the order in which they are listed and, where the data cannot tell, named.
pub static CATALOGUE: [&dyn Effect; 23] = [
    &super::wheel_radius_ratio::WheelRadiusRatio,
    &super::wheel_radius_scale::WheelRadiusScale,
    &super::track_width::TrackWidth,
    &super::scrub::Scrub,
    &super::side_slip::SideSlip,
    &super::traction_slip::TractionSlip,
    &super::turn_load_transfer::TurnLoadTransfer,
    &super::speed_growth::SpeedGrowth,
    &super::wheel_eccentricity::WheelEccentricity,
    &super::encoder_eccentricity::EncoderEccentricity,
    &super::lost_counts::LostCounts,
    &super::backlash::Backlash,
    &super::caster_kick::CasterKick,
    &super::heading_pull::HeadingPull,
    &super::turn_asymmetry::TurnAsymmetry,
    &super::slope::Slope,
    &super::carpet_drift::CarpetDrift,
    &super::thermal_drift::ThermalDrift,
    &super::payload::Payload,
    &super::measurement_delay::MeasurementDelay,
    &super::marker_offset::MarkerOffset,
    &super::gyro_bias::GyroBias,
    &super::gyro_scale::GyroScale,
];

/// The effect of this id.
pub fn find(id: &str) -> Option<&'static dyn Effect> {
    CATALOGUE.into_iter().find(|effect| effect.facts().id == id)
}
