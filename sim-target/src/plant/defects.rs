//! The additional state of a robot with defects, or on an uneven floor.
//!
//! An ideal robot has none of this state and takes the short step in `step`; any other takes the one in
//! `defects_step`. Both use the same tyres, body and caster, and give the same bits where every defect is
//! zero.

use shared_proto::WheelPair;

use super::body::Wrench;
use super::gear::{Joint, JointLoad};
use super::load::LoadModel;
use super::motor::{MotorParameters, Terminals};
use super::parameters::PlantParameters;
use super::wheel::DrivenWheel;
use super::wheel_defects::WheelParameters;
use super::wide_tyre::Ribs;

/// How often the wheels' warming is updated \[us\].
pub(super) const WARMTH_EVERY_US: u64 = 100_000;

/// The state of a robot's defects.
#[derive(Clone, Debug)]
pub(super) struct Defects {
    pub wheel: WheelPair<DefectiveWheel>,
    pub radius_share: f64,
    pub next_warmth_us: u64,
    /// Forces on the body besides those of its wheels, for the next kick.
    pub extra: Wrench,
}

/// The state of one wheel's defects.
#[derive(Clone, Debug)]
pub(super) struct DefectiveWheel {
    pub parameters: WheelParameters,
    pub cold_radius_m: f64,
    pub left_m: f64,
    pub rest_load_n: f64,
    /// Where the wheel is on its axle, within its end float, to the left \[m\].
    pub float_m: f64,
    pub ribs: Option<Ribs>,
    pub joint: Option<Joint>,
}

impl Defects {
    /// None for an ideal robot.
    pub fn new(parameters: &PlantParameters) -> Option<Box<Self>> {
        if parameters.is_ideal() {
            return None;
        }
        let rest = LoadModel::unladen(parameters).loads((0.0, 0.0)).driven_n;
        let half_m = 0.5 * parameters.geometry.track_width_m;
        let radius_m = parameters.geometry.wheel_radius_m;
        let wheel_of =
            |wheel, gear, motor: &MotorParameters, radius_m, left_m, rest| DefectiveWheel {
                parameters: wheel,
                cold_radius_m: radius_m,
                left_m,
                rest_load_n: rest,
                float_m: 0.0,
                ribs: Ribs::new(&parameters.tyre),
                joint: Joint::new(
                    gear,
                    motor.rotor_at_wheel_kgm2(),
                    parameters.geometry.wheel_inertia_kgm2,
                ),
            };
        let (wheel, gear, motor) = (&parameters.wheel, &parameters.gear, &parameters.motor);
        Some(Box::new(Self {
            wheel: WheelPair {
                left: wheel_of(
                    wheel.left,
                    &gear.left,
                    &motor.left,
                    radius_m.left,
                    half_m,
                    rest.left,
                ),
                right: wheel_of(
                    wheel.right,
                    &gear.right,
                    &motor.right,
                    radius_m.right,
                    -half_m,
                    rest.right,
                ),
            },
            radius_share: parameters.warming.radius_share(0.0),
            next_warmth_us: WARMTH_EVERY_US,
            extra: Wrench::default(),
        }))
    }

    /// Resets contact and motion.
    pub fn lift(&mut self) {
        self.extra = Wrench::default();
        let WheelPair { left, right } = self.wheel.as_mut();
        for wheel in [left, right] {
            if let Some(ribs) = &mut wheel.ribs {
                ribs.lift();
            }
            if let Some(joint) = &mut wheel.joint {
                joint.lift();
            }
        }
    }

    /// How far each motor's side is ahead of its wheel \[rad\].
    pub fn ahead_rad(&self) -> WheelPair<f64> {
        self.wheel.as_ref().map(|wheel| wheel.joint.as_ref().map_or(0.0, Joint::ahead_rad))
    }

    /// Forces on the body that no rigid wheel on an even floor makes.
    #[inline]
    pub fn extra(&self) -> Wrench {
        self.extra
    }

    /// Both wheels' defects.
    #[inline]
    pub fn wheels(&mut self) -> WheelPair<&mut DefectiveWheel> {
        self.wheel.as_mut()
    }

    /// Energy in bent ribs \[J\].
    pub fn energy_j(&self) -> f64 {
        let ribs =
            self.wheel.as_ref().map(|defects| defects.ribs.as_ref().map_or(0.0, Ribs::energy_j));
        ribs.left + ribs.right
    }
}

impl DefectiveWheel {
    /// Spins one wheel and its motor for h.
    #[inline]
    pub fn kick(
        &mut self,
        wheel: &mut DrivenWheel,
        terminals: Terminals,
        bus_v: f64,
        clamp_nm: f64,
        h_s: f64,
    ) {
        let clamp_nm = clamp_nm + self.parameters.hub_friction_nm;
        let Some(joint) = &mut self.joint else {
            wheel.kick(terminals, bus_v, clamp_nm, h_s);
            return;
        };
        let load = JointLoad {
            motor: wheel.motor,
            terminals,
            bus_v,
            viscous: wheel.viscous,
            push_nm: wheel.push_nm,
            motor_friction_nm: wheel.coulomb_nm,
            wheel_friction_nm: wheel.rolling_nm + clamp_nm,
            floor_nm: -wheel.radius_m * wheel.contact.force_n.0,
        };
        wheel.current_a = joint.kick(&load, &mut wheel.spin_rad_s, h_s);
    }
}
