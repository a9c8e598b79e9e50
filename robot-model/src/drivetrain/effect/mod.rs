//! Which effects of motors are known? One a file. To add one: a file in this folder, and a line here.
//!
//! Everything is in volts at the motor, since a robot without a current sensor knows no torque. The baseline has kS, kV, kA
//! and kC alike for both wheels and directions; each effect is the identity at amplitudes of zero.

pub mod custom;
mod definition;
mod known_effect;

pub use custom::{CustomMotorEffect, MotorCustom};
pub(crate) use definition::moments;
pub use definition::{
    Acting, Excitation, Moment, MotorEffect, MotorFacts, MotorParameter, MotorRole, Play,
};
pub use known_effect::KnownMotorEffect;

/// Declares the effects' modules, and lists them.
macro_rules! catalogue {
    ($($file:ident::$effect:ident,)*) => {
        $(mod $file;)*

        const ALL: &[&dyn MotorEffect] = &[$(&$file::$effect),*];

        /// All effects, in the order in which they are listed and, where the data cannot tell, named.
        pub static MOTOR_CATALOGUE: [&dyn MotorEffect; ALL.len()] = [$(&$file::$effect),*];
    };
}

catalogue! {
    side_asymmetry::SideAsymmetry,
    direction_asymmetry::DirectionAsymmetry,
    load_torque::LoadTorque,
    stribeck::Stribeck,
    static_friction::StaticFriction,
    dead_band::DeadBand,
    quadratic_drag::QuadraticDrag,
    cogging::Cogging,
    supply_sag::SupplySag,
    transport_delay::TransportDelay,
    backlash::Backlash,
    heating::Heating,
    bridge_curve::BridgeCurve,
}

/// The effect of this id.
pub fn find(id: &str) -> Option<&'static dyn MotorEffect> {
    MOTOR_CATALOGUE.into_iter().find(|effect| effect.facts().id == id)
}

#[cfg(test)]
mod tests;
