//! All parameters of a robot and its floor.

use serde::{Deserialize, Deserializer, Serialize};
use shared_proto::WheelPair;

use super::body::BodyParameters;
use super::bridge::BridgeParameters;
use super::caster::CasterParameters;
use super::disturbances::{DragParameters, TetherParameters, WarmingParameters};
use super::encoder::EncoderParameters;
use super::floor::FloorParameters;
use super::gear::GearParameters;
use super::motor::MotorParameters;
use super::motor_defects::MotorDefectParameters;
use super::range_check::{ParameterError, RangeCheck};
use super::supply::SupplyParameters;
use super::tyre::TyreParameters;
use super::wheel::GeometryParameters;
use super::wheel_defects::WheelParameters;

/// The physical robot and its floor. [`Default`] is the standard robot: the paper's geometry with
/// two equal wheels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlantParameters {
    /// Longest integration step \[us\].
    pub substep_us: u32,
    /// Wheels and track, as they truly are.
    pub geometry: GeometryParameters,
    /// Mass.
    pub body: BodyParameters,
    /// Gear motors.
    #[serde(deserialize_with = "pair_of_overrides")]
    pub motor: WheelPair<MotorParameters>,
    /// Defects of motors and gears.
    #[serde(deserialize_with = "pair_of_overrides")]
    pub motor_defects: WheelPair<MotorDefectParameters>,
    /// The motor driver.
    pub bridge: BridgeParameters,
    /// Encoders.
    #[serde(deserialize_with = "pair_of_overrides")]
    pub encoder: WheelPair<EncoderParameters>,
    /// The joints between motors and wheels.
    #[serde(deserialize_with = "pair_of_overrides")]
    pub gear: WheelPair<GearParameters>,
    /// Defects of the driven wheels.
    #[serde(deserialize_with = "pair_of_overrides")]
    pub wheel: WheelPair<WheelParameters>,
    /// Tyres of the driven wheels.
    pub tyre: TyreParameters,
    /// Cold wheels in a warm room.
    pub warming: WarmingParameters,
    /// The trailing caster.
    pub caster: CasterParameters,
    /// The battery.
    pub supply: SupplyParameters,
    /// A cable that holds the robot.
    pub tether: TetherParameters,
    /// Something that drags over the floor.
    pub drag: DragParameters,
    /// The floor.
    pub floor: FloorParameters,
}

impl Default for PlantParameters {
    fn default() -> Self {
        Self {
            substep_us: 500,
            geometry: GeometryParameters::default(),
            body: BodyParameters::default(),
            motor: WheelPair::both(MotorParameters::default()),
            motor_defects: WheelPair::both(MotorDefectParameters::default()),
            bridge: BridgeParameters::default(),
            encoder: WheelPair::both(EncoderParameters::default()),
            gear: WheelPair::both(GearParameters::default()),
            wheel: WheelPair::both(WheelParameters::default()),
            tyre: TyreParameters::default(),
            warming: WarmingParameters::default(),
            caster: CasterParameters::default(),
            supply: SupplyParameters::default(),
            tether: TetherParameters::default(),
            drag: DragParameters::default(),
            floor: FloorParameters::default(),
        }
    }
}

impl PlantParameters {
    /// Refuses a value outside its range, or one that the integration cannot follow, and names the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        RangeCheck("").within("substep_us", self.substep_us.into(), 10.0, 1000.0)?;
        self.geometry.check(&RangeCheck("geometry."))?;
        self.body.check(&RangeCheck("body."))?;
        self.motor.left.check(&RangeCheck("motor.left."))?;
        self.motor.right.check(&RangeCheck("motor.right."))?;
        self.motor_defects.left.check(&RangeCheck("motor_defects.left."))?;
        self.motor_defects.right.check(&RangeCheck("motor_defects.right."))?;
        self.bridge.check(&RangeCheck("bridge."))?;
        self.encoder.left.check(&RangeCheck("encoder.left."))?;
        self.encoder.right.check(&RangeCheck("encoder.right."))?;
        self.gear.left.check(&RangeCheck("gear.left."))?;
        self.gear.right.check(&RangeCheck("gear.right."))?;
        self.wheel.left.check(&RangeCheck("wheel.left."))?;
        self.wheel.right.check(&RangeCheck("wheel.right."))?;
        self.tyre.check(&RangeCheck("tyre."))?;
        self.warming.check(&RangeCheck("warming."))?;
        self.caster.check(&RangeCheck("caster."))?;
        self.supply.check(&RangeCheck("supply."))?;
        self.tether.check(&RangeCheck("tether."))?;
        self.drag.check(&RangeCheck("drag."))?;
        self.floor.check(&RangeCheck("floor."))?;
        self.check_stance()?;
        self.check_substep()
    }

    /// True for an ideal robot on an even floor, which takes the short integration step.
    pub(super) fn is_ideal(&self) -> bool {
        self.gear.all(|gear| gear.is_ideal())
            && self.wheel.all(|wheel| wheel.is_ideal())
            && self.body.payload_kg == 0.0
            && self.tyre.is_ideal()
            && self.warming.is_ideal()
            && self.tether.is_ideal()
            && self.drag.is_ideal()
            && self.floor.is_ideal()
    }

    /// The centre of mass must stand between the three wheels.
    fn check_stance(&self) -> Result<(), ParameterError> {
        let to_caster_m = -self.body.center_of_mass_forward_m;
        let reach_m = self.caster.pivot_behind_m;
        RangeCheck("body.").within("center_of_mass_forward_m", -to_caster_m, -reach_m, 0.0)?;
        let half_m = 0.5 * self.geometry.track_width_m * (1.0 - to_caster_m / reach_m);
        RangeCheck("body.").within(
            "center_of_mass_left_m",
            self.body.center_of_mass_left_m,
            -half_m,
            half_m,
        )
    }

    /// The stiffest vibration, at angular frequency w, needs a step h with w h below 0.7: a third of
    /// what keeps the integration stable.
    fn check_substep(&self) -> Result<(), ParameterError> {
        let (tyre, body, caster) = (&self.tyre, &self.body, &self.caster);
        let half_track_m = 0.5 * self.geometry.track_width_m;
        let per_mass = 2.0 / body.mass_kg + half_track_m * half_track_m / body.yaw_inertia_kgm2;
        let rim_per_mass =
            self.motor.zip(self.geometry.wheel_radius_m).zip(self.gear).map(|((m, r), gear)| {
                // Behind a loose joint the wheel vibrates without its rotor.
                let rotor = if gear.is_ideal() { m.rotor_at_wheel_kgm2() } else { 0.0 };
                r * r / (self.geometry.wheel_inertia_kgm2 + rotor)
            });
        let rim = rim_per_mass.left.max(rim_per_mass.right);
        let squares = [
            tyre.longitudinal_stiffness_n_per_m * (rim + per_mass),
            tyre.lateral_stiffness_n_per_m * per_mass,
            caster.vibration_squared() + caster.lateral_stiffness_n_per_m * per_mass,
        ];
        let fastest_rad_s = squares.into_iter().fold(0.0, f64::max).sqrt();
        let longest_us = (0.7e6 / fastest_rad_s).floor();
        let substep_us = f64::from(self.substep_us);
        if substep_us <= longest_us {
            return Ok(());
        }
        Err(ParameterError {
            field: "substep_us".into(),
            value: substep_us,
            expected: format!("at most {longest_us} for tyres this stiff on parts this light"),
        })
    }
}

/// Reads a pair in which either wheel may be left out; a wheel that is left out gets the default.
fn pair_of_overrides<'de, T, D>(deserializer: D) -> Result<WheelPair<T>, D::Error>
where
    T: Deserialize<'de> + Default,
    D: Deserializer<'de>,
{
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields, bound = "T: Deserialize<'de> + Default")]
    struct Overrides<T> {
        #[serde(default)]
        left: T,
        #[serde(default)]
        right: T,
    }
    let Overrides { left, right } = Overrides::deserialize(deserializer)?;
    Ok(WheelPair { left, right })
}
