//! The physical robot: forces and torques on a planar body with two driven wheels and a caster.
//!
//! [`Plant`] advances in time with a duty for each motor. Its outputs are what sensors measure (encoder
//! counts, supply voltage, currents) and what only an observer knows (pose, twist). The plant knows nothing
//! of firmware, messages or instruments.
//!
//! # What acts on what
//!
//! ```text
//! supply --V--> motor --torque--> wheel --slip--> tyre contact --force--> body --motion--> pose
//!    ^--current--'  ^---spin--------'  ^----force----'   ^------velocity----'  ^-- caster
//! ```
//!
//! Every arrow is a force, a torque or a velocity: the path follows the wheels' true radii only as far as
//! the tyres grip. Each file has one part and its equations.
//!
//! Each defect is a mechanism of its own: imperfect wheels (`wheel_defects`), play between motor and wheel
//! (`gear`), motors with more than two frictions (`motor_defects`), a stiff caster (`bush`), tyres with a width (`ribs`), encoders that misread (`angle_error`,
//! `lost_lines`), cables and warming (`disturbances`), the floor. `defects` combines them. A robot without
//! any is ideal: it takes a shorter step, which gives the same bits.
//!
//! # Integration
//!
//! Leapfrog: a *kick* changes all momenta by the forces of the present deflections, then a *drift* moves
//! positions, angles and deflections by the new velocities. It is of second order for what vibrates,
//! exact for steady motion, and costs one evaluation of forces a step. Dry friction acts as an impulse
//! limited to what stops the part exactly (Moreau), so that a robot at rest stays at rest.
//! Steps end on multiples of [`PlantParameters::substep_us`] and at the times that the caller asks for.

mod angle_error;
mod body;
mod bridge;
mod caster;
mod caster_pivot;
mod defects;
mod defects_step;
mod disturbances;
mod encoder;
mod fault;
mod floor;
mod gear;
mod load;
mod lost_lines;
mod motor;
mod motor_defects;
mod parameters;
mod pose;
mod range_check;
mod rotation;
mod step;
mod supply;
#[cfg(test)]
mod tests;
mod tyre;
mod wheel;
mod wheel_defects;
mod wide_tyre;

pub use angle_error::AngleErrorParameters;
pub use body::BodyParameters;
pub use bridge::BridgeParameters;
pub use caster::CasterParameters;
pub use caster_pivot::BushParameters;
pub use disturbances::{DragParameters, TetherParameters, WarmingParameters};
pub use encoder::{EncoderEdge, EncoderParameters, EncoderStep};
pub use fault::{CLAMP_NM, CLAMP_RAMP_US, PlantFault};
pub use floor::{Bump, FloorParameters, WetPatch};
pub use gear::GearParameters;
pub use load::Loads;
pub use motor::MotorParameters;
pub use motor_defects::MotorDefectParameters;
pub use parameters::PlantParameters;
pub use pose::{Pose, Twist};
pub use range_check::ParameterError;
pub(crate) use range_check::RangeCheck;
pub use supply::SupplyParameters;
pub use tyre::TyreParameters;
pub use wheel::GeometryParameters;
pub use wheel_defects::WheelParameters;

use std::collections::VecDeque;

use body::Body;
use caster::Caster;
use defects::Defects;
use encoder::Encoder;
use fault::Faults;
use load::LoadModel;
use motor_defects::DefectiveMotor;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use shared_proto::{Wheel, WheelPair};
use wheel::DrivenWheel;

/// One physical robot on its floor, at a point in time.
///
/// Deterministic: the same parameters, start, seed, duties and instants give the same bits.
#[derive(Clone, Debug)]
pub struct Plant {
    parameters: PlantParameters,
    t_us: u64,
    /// Commanded, and late by the driver's delay.
    duty: WheelPair<f64>,
    /// What a driver with a slew limit has made of it.
    slewed_duty: WheelPair<f64>,
    /// Duties that were set and have no effect yet.
    late_duty: VecDeque<WheelPair<f64>>,
    enabled: bool,
    first_driven_us: Option<u64>,
    faults: Faults,
    body: Body,
    wheel: WheelPair<DrivenWheel>,
    caster: Caster,
    /// None for an ideal robot on an even floor.
    defects: Option<Box<Defects>>,
    /// None if both motors are perfect.
    defective_motors: Option<Box<WheelPair<DefectiveMotor>>>,
    load_model: LoadModel,
    loads: Loads,
    bus_v: f64,
    encoder: WheelPair<Encoder>,
    /// For the measured supply's noise; separate, so that reading more often changes nothing else.
    supply_rng: ChaCha8Rng,
    encoder_rng: ChaCha8Rng,
}

impl Plant {
    /// A robot at rest, its motors off, at time zero.
    ///
    /// # Panics
    ///
    /// If the parameters do not pass [`PlantParameters::validate`].
    pub fn new(parameters: PlantParameters, start: Pose, seed: u64) -> Plant {
        if let Err(error) = parameters.validate() {
            panic!("a plant needs valid parameters: {error}");
        }
        let mut encoder_rng = ChaCha8Rng::seed_from_u64(seed);
        let mut supply_rng = encoder_rng.clone();
        supply_rng.set_stream(1);
        let load_model = LoadModel::new(&parameters);
        let half_m = 0.5 * parameters.geometry.track_width_m;
        let wheel_of = |motor: &MotorParameters, radius_m, left_m| {
            DrivenWheel::new(motor, radius_m, parameters.geometry.wheel_inertia_kgm2, left_m)
        };
        let radius_m = parameters.geometry.wheel_radius_m;
        Plant {
            t_us: 0,
            duty: WheelPair::both(0.0),
            slewed_duty: WheelPair::both(0.0),
            late_duty: VecDeque::new(),
            enabled: false,
            first_driven_us: None,
            faults: Faults::default(),
            body: Body::new(&parameters.body, start),
            wheel: WheelPair {
                left: wheel_of(&parameters.motor.left, radius_m.left, half_m),
                right: wheel_of(&parameters.motor.right, radius_m.right, -half_m),
            },
            caster: Caster::new(&parameters.caster),
            defects: Defects::new(&parameters),
            defective_motors: DefectiveMotor::pair(parameters.motor_defects, parameters.motor),
            loads: load_model.loads((0.0, 0.0)),
            load_model,
            bus_v: parameters.supply.bus_v(0.0, 0.0, 0.0),
            encoder: WheelPair {
                left: Encoder::new(&parameters.encoder.left, &mut encoder_rng),
                right: Encoder::new(&parameters.encoder.right, &mut encoder_rng),
            },
            supply_rng,
            encoder_rng,
            parameters,
        }
    }

    /// Sets the share of the supply on each motor's terminals, -1 to 1; more is cut off.
    pub fn set_duty(&mut self, duty: WheelPair<f64>) {
        assert!(duty.all(f64::is_finite), "{duty:?}");
        self.late_duty.push_back(duty.map(|d| d.clamp(-1.0, 1.0)));
        if self.late_duty.len() > usize::from(self.parameters.bridge.delay_ms) {
            self.duty = self.late_duty.pop_front().unwrap_or(WheelPair::both(0.0));
        }
        self.note_first_drive();
    }

    /// Switches the motor driver on or off. Off, the terminals are open and no current flows, unless the
    /// driver is one that [shorts them](BridgeParameters::shorts_when_off).
    pub fn set_enabled(&mut self, on: bool) {
        self.enabled = on;
        self.note_first_drive();
    }

    /// When the motors were driven for the first time, if they were \[us\].
    pub fn first_driven_us(&self) -> Option<u64> {
        self.first_driven_us
    }

    fn note_first_drive(&mut self) {
        if self.first_driven_us.is_none() && self.enabled && self.duty.any(|d| d != 0.0) {
            self.first_driven_us = Some(self.t_us);
        }
    }

    /// Moves the robot to another pose, at rest. Wheels and caster keep their angles.
    pub fn place(&mut self, pose: Pose) {
        self.body = Body::new(&self.parameters.body, pose);
        self.loads = self.load_model.loads((0.0, 0.0));
        self.caster.lift();
        let WheelPair { left, right } = self.wheel.as_mut();
        left.lift();
        right.lift();
        if let Some(defects) = &mut self.defects {
            defects.lift();
        }
    }

    /// Turns the caster to trail forward travel.
    pub fn trail_caster(&mut self) {
        self.caster =
            Caster::new(&CasterParameters { start_angle_rad: 0.0, ..self.parameters.caster });
    }

    /// Puts another load on the robot \[kg\].
    ///
    /// # Panics
    ///
    /// If the load is negative or above 500 kg.
    pub fn set_payload(&mut self, payload_kg: f64) {
        self.parameters.body.payload_kg = payload_kg;
        if let Err(error) = self.parameters.validate() {
            panic!("a plant needs valid parameters: {error}");
        }
        self.body.set_mass(&self.parameters.body);
        self.load_model = LoadModel::new(&self.parameters);
        self.loads = self.load_model.loads((0.0, 0.0));
        if self.defects.is_none() {
            self.defects = Defects::new(&self.parameters);
        }
    }

    /// Advances from the present time to `t_us`. A time in the past changes nothing.
    pub fn advance_to(&mut self, t_us: u64) {
        let start_us = self.t_us;
        if t_us <= start_us {
            return;
        }
        let substep_us = u64::from(self.parameters.substep_us);
        let mut to_grid_us = substep_us - start_us % substep_us;
        while self.t_us < t_us {
            let h_us = to_grid_us.min(t_us - self.t_us);
            self.step(h_us as f64 * 1e-6);
            self.t_us += h_us;
            to_grid_us = substep_us;
        }
        let angle_rad = self.shaft_angles_rad();
        let rng = &mut self.encoder_rng;
        self.encoder.left.advance(angle_rad.left, start_us, t_us, rng);
        self.encoder.right.advance(angle_rad.right, start_us, t_us, rng);
    }

    /// The present time \[us\].
    pub fn t_us(&self) -> u64 {
        self.t_us
    }

    /// The true pose: the midpoint of the driven wheels' axle; heading not wrapped.
    pub fn pose(&self) -> Pose {
        self.body.pose()
    }

    /// The true motion.
    pub fn twist(&self) -> Twist {
        self.body.twist()
    }

    /// The encoders' counts, by the connector that each is plugged into.
    pub fn counts(&self) -> WheelPair<i64> {
        let counts = self.encoder.as_ref().map(Encoder::count);
        if self.faults.encoders_exchanged { counts.swapped() } else { counts }
    }

    /// What an encoder did during the last [`advance_to`](Self::advance_to), edge by edge.
    pub fn encoder_step(&self, wheel: Wheel) -> EncoderStep {
        let wheel = if self.faults.encoders_exchanged { wheel.other() } else { wheel };
        self.encoder.get(wheel).step()
    }

    /// The supply voltage as measured, noise included \[V\].
    pub fn supply_v(&mut self) -> f64 {
        let noise: f64 = StandardNormal.sample(&mut self.supply_rng);
        self.bus_v + self.parameters.supply.noise_sigma_v * noise
    }

    /// The true supply voltage \[V\].
    pub fn bus_v(&self) -> f64 {
        self.bus_v
    }

    /// The motors' currents \[A\].
    pub fn currents_a(&self) -> WheelPair<f64> {
        self.wheel.as_ref().map(|w| w.current_a)
    }

    /// How far each wheel has turned, forward positive \[rad\].
    pub fn wheel_angles_rad(&self) -> WheelPair<f64> {
        self.wheel.as_ref().map(|w| w.angle_rad)
    }

    /// How far the shaft that each encoder sits on has turned: the wheel's, or the motor's side of a
    /// joint that is not rigid, as wheel angle \[rad\].
    pub fn shaft_angles_rad(&self) -> WheelPair<f64> {
        let angle_rad = self.wheel_angles_rad();
        match &self.defects {
            None => angle_rad,
            Some(defects) => angle_rad.zip(defects.ahead_rad()).map(|(wheel, ahead)| wheel + ahead),
        }
    }

    /// How fast each wheel turns, forward positive \[rad/s\].
    pub fn wheel_speeds_rad_s(&self) -> WheelPair<f64> {
        self.wheel.as_ref().map(|w| w.spin_rad_s)
    }

    /// Swivel angle of the caster, 0 when it trails forward travel, not wrapped \[rad\].
    pub fn caster_angle_rad(&self) -> f64 {
        self.caster.angle_rad()
    }

    /// The load on each wheel.
    pub fn loads(&self) -> Loads {
        self.loads
    }

    /// Kinetic energy and the energy in bent tyres \[J\].
    pub fn energy_j(&self) -> f64 {
        let wheels =
            self.wheel.as_ref().map(|w| w.energy_j() + w.contact.energy_j(&self.parameters.tyre));
        let caster = self.caster.energy_j(&self.parameters.caster, self.body.yaw_rate_rad_s);
        let ribs_j = self.defects.as_ref().map_or(0.0, |defects| defects.energy_j());
        self.body.energy_j() + wheels.left + wheels.right + caster + ribs_j
    }

    /// The robot's parameters.
    pub fn parameters(&self) -> &PlantParameters {
        &self.parameters
    }

    /// True while the motor driver pulls its fault line.
    pub fn driver_fault_line(&self) -> bool {
        self.faults.driver
    }

    /// True while the emergency stop is pressed.
    pub fn estop_line(&self) -> bool {
        self.faults.estop
    }

    /// Injects a fault, from now on.
    pub fn inject(&mut self, fault: PlantFault) {
        self.set_fault(fault, true);
    }

    /// Removes a fault, whatever values it was injected with.
    pub fn remove(&mut self, fault: PlantFault) {
        self.set_fault(fault, false);
    }

    fn set_fault(&mut self, fault: PlantFault, on: bool) {
        let (now_us, rng) = (self.t_us, &mut self.encoder_rng);
        let encoders = self.encoder.as_mut();
        let wheels = self.faults.wheel.as_mut();
        match fault {
            PlantFault::EncoderUnplugged(w) => pick(encoders, w).set_unplugged(on),
            PlantFault::EncoderReversed(w) => pick(encoders, w).set_swapped(on),
            PlantFault::EncoderNoise(w, rate) => {
                pick(encoders, w).set_noise(if on { rate } else { 0.0 }, now_us, rng);
            }
            PlantFault::WheelBlocked(w) => {
                pick(wheels, w).blocked_since_us = on.then_some(now_us);
            }
            PlantFault::WheelJammed(w) => pick(wheels, w).jammed = on,
            PlantFault::MotorUnplugged(w) => pick(wheels, w).motor_unplugged = on,
            PlantFault::MotorReversed(w) => pick(wheels, w).motor_reversed = on,
            PlantFault::EncodersExchanged => self.faults.encoders_exchanged = on,
            PlantFault::MotorsExchanged => self.faults.motors_exchanged = on,
            PlantFault::DriverFault => self.faults.driver = on,
            PlantFault::SupplyDip { volts } => self.faults.dip_v = if on { volts } else { 0.0 },
            PlantFault::EmergencyStop => self.faults.estop = on,
        }
    }
}

/// The chosen one of two references.
fn pick<T>(pair: WheelPair<&mut T>, wheel: Wheel) -> &mut T {
    match wheel {
        Wheel::Left => pair.left,
        Wheel::Right => pair.right,
    }
}
