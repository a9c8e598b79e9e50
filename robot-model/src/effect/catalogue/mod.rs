//! Which effects are built in? To add one: a file in this folder, and a line here.
//!
//! An effect's file holds its equation, its sign convention, its facts and its formula. How the effects of a model
//! act together is in `composition.rs`.

use super::definition::Effect;

/// Declares the effects' modules, and lists them.
macro_rules! catalogue {
    ($($file:ident::$effect:ident,)*) => {
        $(mod $file;)*

        const ALL: &[&dyn Effect] = &[$(&$file::$effect),*];

        /// All effects, in the order in which they are listed and, where the data cannot tell, named.
        pub static CATALOGUE: [&dyn Effect; ALL.len()] = [$(&$file::$effect),*];
    };
}

catalogue! {
    wheel_radius_ratio::WheelRadiusRatio,
    wheel_radius_scale::WheelRadiusScale,
    track_width::TrackWidth,
    scrub::Scrub,
    side_slip::SideSlip,
    traction_slip::TractionSlip,
    turn_load_transfer::TurnLoadTransfer,
    speed_growth::SpeedGrowth,
    wheel_eccentricity::WheelEccentricity,
    encoder_eccentricity::EncoderEccentricity,
    lost_counts::LostCounts,
    backlash::Backlash,
    caster_kick::CasterKick,
    heading_pull::HeadingPull,
    turn_asymmetry::TurnAsymmetry,
    slope::Slope,
    carpet_drift::CarpetDrift,
    thermal_drift::ThermalDrift,
    payload::Payload,
    measurement_delay::MeasurementDelay,
    marker_offset::MarkerOffset,
    heading_drift::HeadingDrift,
    gyro_bias::GyroBias,
    gyro_scale::GyroScale,
}

/// The effect of this id.
pub fn find(id: &str) -> Option<&'static dyn Effect> {
    CATALOGUE.into_iter().find(|effect| effect.facts().id == id)
}
