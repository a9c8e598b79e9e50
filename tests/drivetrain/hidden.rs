//! What is hidden in a robot's motors, and what it does to the plant: torques, currents, slots, switches.

use rand::{Rng, RngExt};
use shared_proto::{Config, WheelPair};
use sim_target::plant::PlantParameters;

/// Something that motors, gears, drivers or batteries may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the first thirteen are those of the catalogue")]
pub enum Hidden {
    SideAsymmetry,
    DirectionAsymmetry,
    LoadTorque,
    Stribeck,
    StaticFriction,
    DeadBand,
    QuadraticDrag,
    Cogging,
    SupplySag,
    TransportDelay,
    Backlash,
    Heating,
    BridgeCurve,
    /// The driver chops above a current.
    CurrentLimit,
    /// A tooth that binds once per turn.
    TightTooth,
    /// Friction by the torque that a gear carries.
    GearLoss,
    /// Brushes that lift off at speed.
    BrushLift,
    /// A driver that changes its duty only so fast.
    SoftStart,
    /// Encoder lines that are not evenly spaced round the turn.
    UnevenLines,
}

/// Those that are in the catalogue, with their ids.
pub const INSIDE: [(Hidden, &str); 13] = [
    (Hidden::SideAsymmetry, "side_asymmetry"),
    (Hidden::DirectionAsymmetry, "direction_asymmetry"),
    (Hidden::LoadTorque, "load_torque"),
    (Hidden::Stribeck, "stribeck"),
    (Hidden::StaticFriction, "static_friction"),
    (Hidden::DeadBand, "dead_band"),
    (Hidden::QuadraticDrag, "quadratic_drag"),
    (Hidden::Cogging, "cogging"),
    (Hidden::SupplySag, "supply_sag"),
    (Hidden::TransportDelay, "transport_delay"),
    (Hidden::Backlash, "backlash"),
    (Hidden::Heating, "heating"),
    (Hidden::BridgeCurve, "bridge_curve"),
];

/// Those that are not.
pub const OUTSIDE: [Hidden; 6] = [
    Hidden::CurrentLimit,
    Hidden::TightTooth,
    Hidden::GearLoss,
    Hidden::BrushLift,
    Hidden::SoftStart,
    Hidden::UnevenLines,
];

impl Hidden {
    /// The id in the catalogue, if it is there.
    pub fn id(self) -> Option<&'static str> {
        INSIDE.iter().find(|(hidden, _)| *hidden == self).map(|(_, id)| *id)
    }

    /// Hides it: strength 1 is strong, 0 changes nothing.
    pub fn apply(
        self,
        plant: &mut PlantParameters,
        config: &mut Config,
        s: f64,
        rng: &mut impl Rng,
    ) {
        let sign = if rng.random() { 1.0 } else { -1.0 };
        let draw = rng.random_range(0.8..1.25) * s;
        let friction_nm = plant.motor.left.coulomb_torque_nm;
        // A wheel's speed at full voltage, about.
        let motor = plant.motor.left;
        let fast_rad_s = 12.0 / motor.wheel_torque_constant_nm_per_a();
        let (left, right) = (&mut plant.motor_defects.left, &mut plant.motor_defects.right);
        match self {
            Self::SideAsymmetry => {
                plant.motor.left.coulomb_torque_nm *= 1.0 + 0.15 * sign * draw;
                plant.motor.right.coulomb_torque_nm *= 1.0 - 0.15 * sign * draw;
                plant.motor.left.torque_constant_nm_per_a *= 1.0 + 0.02 * sign * draw;
                plant.motor.right.torque_constant_nm_per_a *= 1.0 - 0.02 * sign * draw;
            }
            Self::DirectionAsymmetry => {
                (left.one_way_nm, right.one_way_nm) =
                    (0.2 * friction_nm * sign * draw, -0.2 * friction_nm * sign * draw);
                (left.brush_lead, right.brush_lead) = (0.015 * sign * draw, -0.015 * sign * draw);
            }
            Self::LoadTorque => {
                plant.floor.slope_rad = 0.015 * draw;
                plant.floor.downhill_rad = if sign > 0.0 { 0.0 } else { core::f64::consts::PI };
            }
            Self::Stribeck => {
                let film_rad_s = rng.random_range(0.08..0.25) * fast_rad_s;
                for defects in [left, right] {
                    defects.boundary_nm = 0.6 * friction_nm * draw;
                    defects.film_rad_s = film_rad_s;
                }
            }
            Self::StaticFriction => {
                for defects in [left, right] {
                    defects.stiction_nm = 0.7 * friction_nm * draw;
                }
            }
            Self::DeadBand => plant.bridge.dead_band_v = 0.5 * draw,
            Self::QuadraticDrag => {
                for defects in [left, right] {
                    defects.drag_nms2 = 0.8 * friction_nm * draw / (fast_rad_s * fast_rad_s);
                }
            }
            other => other.apply_to_drive(plant, config, (draw, sign), rng),
        }
    }

    /// Effects of slots, battery, driver, gear and winding.
    fn apply_to_drive(
        self,
        plant: &mut PlantParameters,
        config: &mut Config,
        (draw, sign): (f64, f64),
        rng: &mut impl Rng,
    ) {
        let motor = plant.motor.left;
        let friction_nm = motor.coulomb_torque_nm;
        let fast_rad_s = 12.0 / motor.wheel_torque_constant_nm_per_a();
        let (left, right) = (&mut plant.motor_defects.left, &mut plant.motor_defects.right);
        match self {
            Self::Cogging => {
                let gear = plant.encoder.left.gear_reduction;
                let slots = if gear > 1.0 { gear } else { f64::from(rng.random_range(3..16)) };
                for defects in [left, right] {
                    defects.cogging_nm = 0.4 * friction_nm * draw;
                    defects.cogging_slots = slots;
                    defects.cogging_phase_rad = rng.random_range(-3.0..3.0);
                }
            }
            Self::SupplySag => {
                config.protection.supply_v_min = 0.0;
                let stall_a = 12.0 / motor.resistance_ohm;
                plant.supply.resistance_ohm = 0.15 * draw * 12.0 / (2.0 * stall_a);
            }
            Self::TransportDelay => plant.bridge.delay_ms = (6.0 * draw).round() as u8,
            Self::Backlash => {
                for gear in [&mut plant.gear.left, &mut plant.gear.right] {
                    gear.backlash_rad = 0.06 * draw;
                }
            }
            Self::Heating => {
                for defects in [left, right] {
                    defects.heat_resistance_k_per_w = 40.0 * draw;
                    defects.heat_capacity_j_per_k = 1.0;
                }
            }
            Self::BridgeCurve => plant.bridge.bend = 0.12 * draw,
            other => other.apply_from_outside(plant, draw, (friction_nm, fast_rad_s), sign),
        }
    }

    /// Effects that are in no catalogue.
    fn apply_from_outside(
        self,
        plant: &mut PlantParameters,
        s: f64,
        (friction_nm, fast_rad_s): (f64, f64),
        sign: f64,
    ) {
        let motor = plant.motor.left;
        let WheelPair { left, right } = plant.motor_defects.as_mut();
        match self {
            Self::CurrentLimit => {
                let stall_a = 12.0 / motor.resistance_ohm;
                plant.bridge.current_limit_a = Some(stall_a * 0.25 / s.max(1e-3));
            }
            Self::TightTooth => {
                let one = if sign > 0.0 { left } else { right };
                (one.tight_tooth_nm, one.tight_tooth_share) = (0.8 * friction_nm * s, 0.08);
            }
            Self::GearLoss => {
                for defects in [left, right] {
                    defects.gear_loss = (0.25 * s).min(0.6);
                }
            }
            Self::BrushLift => {
                for defects in [left, right] {
                    defects.brush_lift_rad_s = 0.25 * fast_rad_s / s.max(1e-3);
                }
            }
            Self::SoftStart => plant.bridge.slew_per_s = Some(12.0 / s.max(1e-3)),
            Self::UnevenLines => {
                for encoder in [&mut plant.encoder.left, &mut plant.encoder.right] {
                    encoder.error.eccentricity = (0.08 * s).min(0.18);
                    encoder.error.eccentricity_phase_rad = sign;
                }
            }
            other => unreachable!("{other:?} is in the catalogue"),
        }
    }
}
