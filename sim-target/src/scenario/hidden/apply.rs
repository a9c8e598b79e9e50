//! What each hidden effect does to a scenario.

use core::f64::consts::PI;

use rand::{Rng, RngExt};
use shared_proto::WheelPair;

use super::HiddenEffect;
use crate::instruments::GyroParameters;
use crate::plant::{Bump, EncoderParameters, PlantParameters, WetPatch};
use crate::scenario::Scenario;

/// What an effect draws: signs, sides, phases.
struct Draw<'a, R>(&'a mut R);

impl<R: Rng> Draw<'_, R> {
    fn sign(&mut self) -> f64 {
        if self.0.random() { 1.0 } else { -1.0 }
    }

    fn angle_rad(&mut self) -> f64 {
        self.0.random_range(-PI..PI)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    /// One of the two, at random.
    fn one<'p, T>(&mut self, pair: &'p mut WheelPair<T>) -> &'p mut T {
        if self.0.random() { &mut pair.left } else { &mut pair.right }
    }
}

/// Robots brake less than this \[m/s^2\].
const BRAKING_MPS2: f64 = 0.5;

/// Slip stiffness of one driven wheel along its way, k_x sigma \[N\].
fn slip_stiffness_n(plant: &PlantParameters) -> f64 {
    plant.tyre.longitudinal_stiffness_n_per_m * plant.tyre.relaxation_length_m
}

impl HiddenEffect {
    /// Hides the effect in a robot: strength 1 is a typical magnitude, 0 changes nothing.
    ///
    /// The random numbers decide on signs, sides and phases, and are used up alike at every strength.
    pub fn apply(self, scenario: &mut Scenario, strength: f64, rng: &mut impl Rng) {
        let mut draw = Draw(rng);
        if self.apply_to_instruments(scenario, strength, &mut draw) {
            return;
        }
        let plant = &mut scenario.plant;
        let s = strength;
        match self {
            Self::WheelRadiusRatio => {
                let half = 0.5 * 0.008 * s * draw.sign();
                plant.geometry.wheel_radius_m.left *= 1.0 - half;
                plant.geometry.wheel_radius_m.right *= 1.0 + half;
            }
            Self::WheelRadiusScale => {
                let scale = 1.0 + 0.005 * s * draw.sign();
                plant.geometry.wheel_radius_m = plant.geometry.wheel_radius_m.map(|r| r * scale);
            }
            Self::TrackWidth => plant.geometry.track_width_m *= 1.0 + 0.02 * s * draw.sign(),
            Self::Scrub => {
                // Keep the track that gentle arcs show: there all ribs hold, which adds w^2/(2 b^2).
                let share = 0.06 * s / plant.geometry.track_width_m;
                plant.tyre.contact_width_m = 0.06 * s;
                plant.geometry.track_width_m /= 1.0 + 0.5 * share * share;
                plant.caster.rolling_resistance += 0.03 * s;
            }
            Self::SideSlip => {
                // Each of two wheels carries half of m v omega: creep = 2 k/m, k = 20 ms.
                plant.tyre.lateral_creep_mps_per_n = 2.0 * 0.02 * s / plant.body.mass_kg;
            }
            // From 0.8 % per m/s^2, m/(2 k sigma), to 2.5 %.
            Self::TractionSlip => plant.tyre.longitudinal_stiffness_n_per_m /= 1.0 + 2.0 * s,
            Self::TurnLoadTransfer => {
                plant.body.center_of_mass_height_m += 0.24 * s.min(1.0);
                for wheel in both(&mut plant.wheel) {
                    wheel.radial_compliance_m_per_n = 7e-5 * s;
                }
            }
            Self::SpeedGrowth => {
                for wheel in both(&mut plant.wheel) {
                    wheel.centrifugal_growth_s2 = 3.6e-5 * s;
                }
            }
            Self::WheelEccentricity => {
                for wheel in both(&mut plant.wheel) {
                    wheel.eccentricity = draw.between(0.004, 0.008) * s;
                    wheel.eccentricity_phase_rad = draw.angle_rad();
                }
            }
            other => other.apply_to_drive_or_floor(plant, s, &mut draw),
        }
    }

    /// Effects of encoders, gears, caster, floor and load.
    fn apply_to_drive_or_floor<R: Rng>(
        self,
        plant: &mut PlantParameters,
        s: f64,
        draw: &mut Draw<'_, R>,
    ) {
        match self {
            Self::EncoderEccentricity => {
                for encoder in both(&mut plant.encoder) {
                    encoder.error.eccentricity = draw.between(0.01, 0.02) * s;
                    encoder.error.eccentricity_phase_rad = draw.angle_rad();
                }
            }
            Self::LostCounts => {
                for encoder in both(&mut plant.encoder) {
                    // From 2.8 rad/s on, 0.1 m/s of the standard wheel.
                    encoder.filter_s = shortest_level_s(encoder, 2.8);
                    encoder.thin_line_share = (draw.between(0.03, 0.1) * s).min(1.0);
                }
            }
            Self::Backlash => {
                for gear in both(&mut plant.gear) {
                    gear.backlash_rad = draw.between(0.02, 0.05) * s;
                }
                // A wheel whose bearing drags stays on its flank when the motor brakes; one that runs
                // freely would run ahead.
                let inertia_nm = 0.5 * plant.body.mass_kg * BRAKING_MPS2;
                for (wheel, radius_m) in both(&mut plant.wheel)
                    .into_iter()
                    .zip([plant.geometry.wheel_radius_m.left, plant.geometry.wheel_radius_m.right])
                {
                    wheel.hub_friction_nm += inertia_nm * radius_m * s.min(1.0);
                }
            }
            Self::CasterKick => kick(plant, s),
            Self::HeadingPull => {
                // Carried by the slip of two wheels: 2 M/(b^2 k sigma) rad/m.
                let track_m = plant.geometry.track_width_m;
                let per_m = 0.005 * s * draw.sign();
                plant.tether.twist_nm += 0.5 * per_m * track_m * track_m * slip_stiffness_n(plant);
            }
            Self::TurnAsymmetry => {
                let float_m = 2.0 * 0.006 * s * plant.geometry.track_width_m;
                let wheel = draw.one(&mut plant.wheel);
                wheel.end_float_m = float_m;
                wheel.contact_ahead_m = 0.01 * s.min(1.0);
            }
            Self::Slope => {
                plant.floor.slope_rad = 0.03 * s;
                plant.floor.downhill_rad = draw.angle_rad();
            }
            Self::CarpetDrift => {
                plant.floor.pile_drift = 0.01 * s;
                plant.floor.pile_direction_rad = draw.angle_rad();
            }
            Self::ThermalDrift => {
                plant.warming.expansion_per_k = 2e-4;
                plant.warming.difference_k = 30.0 * s * draw.sign();
            }
            Self::Payload => {
                // 0.5 % of 36 mm for the 37 N that 10 kg put on each driven wheel.
                for wheel in both(&mut plant.wheel) {
                    wheel.radial_compliance_m_per_n = 5e-6 * s;
                }
            }
            other => other.apply_from_outside(plant, s, draw),
        }
    }

    /// Effects of the measurement; false for any other.
    fn apply_to_instruments<R: Rng>(
        self,
        scenario: &mut Scenario,
        s: f64,
        draw: &mut Draw<'_, R>,
    ) -> bool {
        let camera = &mut scenario.camera;
        match self {
            Self::MeasurementDelay => {
                camera.delay_known = false;
                camera.delay_s = 0.05 * s;
            }
            Self::MarkerOffset => {
                camera.marker.forward_m += 0.01 * s * draw.sign();
                camera.marker.left_m += 0.01 * s * draw.sign();
            }
            Self::LensDistortion => {
                camera.lens.distortion_per_m2 += 0.01 * s * draw.sign();
                camera.lens.center_x_m = draw.between(-0.5, 0.5);
                camera.lens.center_y_m = draw.between(-0.5, 0.5);
            }
            Self::StaleFrames => {
                camera.stale.share = 0.03 * s;
                camera.stale.pictures = 4;
            }
            Self::GyroBias => {
                let gyro = scenario.gyro.get_or_insert_with(GyroParameters::default);
                gyro.bias_rad_s += 0.01 * s * draw.sign();
            }
            Self::GyroScale => {
                let gyro = scenario.gyro.get_or_insert_with(GyroParameters::default);
                gyro.scale += 0.02 * s * draw.sign();
            }
            _ => return false,
        }
        true
    }

    /// Effects that are in no catalogue.
    fn apply_from_outside<R: Rng>(
        self,
        plant: &mut PlantParameters,
        s: f64,
        draw: &mut Draw<'_, R>,
    ) {
        let half_track_m = 0.5 * plant.geometry.track_width_m;
        match self {
            Self::RelaxationLength => soften_tyres(plant, s),
            Self::SetScrewSlip => {
                // A cruise takes 10 mN m of the standard robot, 0.3 m/s^2 another 22.
                let gear = draw.one(&mut plant.gear);
                gear.set_screw_nm = (s > 0.0).then(|| 0.031 / s.sqrt());
            }
            Self::WetPatch => {
                let side = draw.sign();
                plant.floor.wet = (s > 0.0).then(|| WetPatch {
                    x_m: 0.1,
                    y_m: side * (half_track_m + 0.1),
                    radius_m: 0.25,
                    friction: plant.floor.friction.min(0.038 / s),
                });
            }
            Self::BentAxle => {
                for wheel in both(&mut plant.wheel) {
                    wheel.bend_rad = draw.between(0.05, 0.1) * s;
                    wheel.bend_phase_rad = draw.angle_rad();
                }
            }
            Self::DraggingBrush => {
                plant.drag.force_n = 1.0 * s;
                plant.drag.left_m = 0.15 * draw.sign();
                plant.drag.behind_m = 0.05;
            }
            Self::MagneticEncoder => {
                for encoder in both(&mut plant.encoder) {
                    let gear = encoder.gear_reduction;
                    encoder.error.two_per_turn_rad = draw.between(0.015, 0.03) * s * gear;
                    encoder.error.two_per_turn_phase_rad = draw.angle_rad();
                }
            }
            Self::GearRipple => {
                let encoder = draw.one(&mut plant.encoder);
                encoder.error.mesh_rad = 0.02 * s;
                encoder.error.mesh_teeth = 17.0;
            }
            Self::FloorBump => {
                let (x_m, side) = (draw.between(0.5, 0.7), draw.sign());
                plant.floor.bump = Some(Bump {
                    x_m,
                    y_m: side * half_track_m,
                    radius_m: 0.05,
                    height_m: (0.008 * s).min(0.015),
                });
            }
            Self::StickyCaster => {
                plant.caster.swivel_friction_nm += 0.02 * s;
                plant.caster.trail_m *= 1.0 - 0.3 * s.min(1.0);
            }
            Self::FlatSpot => draw.one(&mut plant.wheel).flat_half_angle_rad = (0.3 * s).min(0.5),
            Self::SoftSidewalls => plant.tyre.lateral_stiffness_n_per_m /= 1.0 + 9.0 * s,
            Self::TetherPull => plant.tether.left_n += 0.5 * s * draw.sign(),
            other => unreachable!("{other} is in the catalogue"),
        }
    }
}

/// Tyres that take a long distance to build up a force.
fn soften_tyres(plant: &mut PlantParameters, s: f64) {
    // Soft as balloons: they deflect by a millimetre when the robot accelerates, and recover over
    // most of a metre. The product k sigma stays near 400 N, so that they slip little.
    const GIVES_N_PER_M: f64 = 500.0;
    const LATER_M: f64 = 0.7;
    let tyre = &mut plant.tyre;
    for stiffness in [&mut tyre.longitudinal_stiffness_n_per_m, &mut tyre.lateral_stiffness_n_per_m]
    {
        *stiffness /= 1.0 + s * *stiffness / GIVES_N_PER_M;
    }
    tyre.relaxation_length_m = (tyre.relaxation_length_m + LATER_M * s).min(1.0);
}

/// A caster with a long fork, close to the axle, on a stiff pivot.
///
/// The wheel leans a little, so the caster swings at once after a reversal. Meanwhile the bush turns the body
/// with the fork, by the torque T_b over a few trails e of travel. The tyres take up this torque by slip,
/// 2 T_b/(b^2 k sigma) rad/m. So the bush is as stiff as the caster's grip on the floor can still turn (a share
/// of mu N e), and stiff tyres are made softer here. The fork is as long as the distance from pivot to axle:
/// then the side force that turns a stiff fork acts with twice that lever over one half of the swing, and
/// with none over the other half. Otherwise this force would turn the robot there and back.
///
/// At a third of the typical strength the swing is complete; above that only the torque grows.
fn kick(plant: &mut PlantParameters, s: f64) {
    /// Share of what the caster's grip can turn: typical, and before wheels slide.
    const TORQUE: f64 = 0.4;
    const TORQUE_MOST: f64 = 0.48;
    /// Slip stiffness of tyres that a caster can make slip, while ramps hardly do \[N\].
    const SLIP_STIFFNESS_N: f64 = 1200.0;
    let whole = (3.0 * s).min(1.0);
    let caster = &mut plant.caster;
    caster.pivot_behind_m *= 1.0 - 0.4 * whole;
    caster.trail_m *= 1.0 + 4.0 * whole;
    caster.swivel_inertia_kgm2 *= 1.0 + 9.0 * whole;
    caster.conicity_rad += 0.1 * whole;
    let body = &plant.body;
    let weight_n = body.mass_kg * plant.floor.gravity_mps2;
    let load_n = -weight_n * body.center_of_mass_forward_m / caster.pivot_behind_m;
    let grip_nm = plant.floor.friction * load_n * caster.trail_m;
    caster.bush.torque_nm += (TORQUE * s).min(TORQUE_MOST) * grip_nm;
    let excess = (slip_stiffness_n(plant) / SLIP_STIFFNESS_N - 1.0).max(0.0);
    plant.tyre.longitudinal_stiffness_n_per_m /= 1.0 + whole * excess;
}

fn both<T>(pair: &mut WheelPair<T>) -> [&mut T; 2] {
    [&mut pair.left, &mut pair.right]
}

/// The filter that swallows the thinnest lines from this wheel speed on: a fifth of a count's time.
fn shortest_level_s(encoder: &EncoderParameters, wheel_rad_s: f64) -> f64 {
    0.2 * core::f64::consts::TAU / (wheel_rad_s * encoder.counts_per_rev * encoder.gear_reduction)
}
