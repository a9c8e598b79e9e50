//! What is an effect of a motor? The trait, what it can change in a step, and the facts about it.

use std::borrow::Cow;

use crate::drivetrain::model::WheelMotor;
use crate::kinematics::WheelPair;

/// What an effect does. A method that is left out changes nothing, and at amplitudes of zero neither does any.
pub trait MotorEffect: Send + Sync + core::fmt::Debug {
    /// The facts about it.
    fn facts(&self) -> MotorFacts<'_>;

    /// What it changes for one wheel in one step.
    fn act(&self, _p: &[f64], _moment: &Moment, _acting: &mut Acting) {}

    /// By how much the voltage acts later \[s\].
    fn delay_s(&self, _p: &[f64]) -> f64 {
        0.0
    }

    /// Play between the motor, whose turn is counted, and its wheel.
    fn play(&self, _p: &[f64]) -> Option<Play> {
        None
    }

    /// How much of it a caster on soft tyres imitates in a robot that does not have it, root mean square of travel; it has to
    /// explain more \[m\].
    fn imitated_m(&self) -> f64 {
        0.0
    }

    /// Where a search begins, with amplitudes zero: shapes to try.
    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        vec![vec![0.0; self.facts().parameters.len()]]
    }
}

/// One wheel at one instant, as the model has it.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// 1 for the left wheel, -1 for the right one: the motors are mounted mirrored.
    pub side: f64,
    /// Speeds: of this wheel, and of the other \[m/s\].
    pub speed_mps: (f64, f64),
    /// Voltages that were applied: to this wheel's motor, and to the other \[V\].
    pub volts: (f64, f64),
    /// The highest voltage of the campaign \[V\].
    pub full_v: f64,
    /// Turns of this wheel since its counter was zero.
    pub turns: f64,
    /// Time since the campaign began \[s\].
    pub t_s: f64,
    /// Time since the longest pause between two experiments \[s\]; infinite before it, or without one.
    pub since_pause_s: f64,
    /// Heading of the robot since the campaign began, left positive \[rad\].
    pub heading_rad: f64,
}

/// What acts on one wheel in a step. Effects change it, one after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acting {
    /// Voltage that drives, pushes of any cause included \[V\].
    pub volts: f64,
    /// The constants of its motor.
    pub motor: WheelMotor,
}

impl Acting {
    /// Adds to the friction of both directions \[V\]. Friction never drives.
    pub fn add_friction_v(&mut self, volts: f64) {
        for ks_v in [&mut self.motor.ks_forward_v, &mut self.motor.ks_backward_v] {
            *ks_v = (*ks_v + volts).max(0.0);
        }
    }

    /// Multiplies the friction of both directions.
    pub fn scale_friction(&mut self, share: f64) {
        self.motor.ks_forward_v *= share;
        self.motor.ks_backward_v *= share;
    }
}

/// Play between motor and wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Play {
    /// From flank to flank, as travel of the wheel \[m\].
    pub travel_m: f64,
    /// Share of the inertia that is on the motor's side.
    pub motor_share: f64,
}

/// What a campaign excites, for shapes to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excitation {
    /// Highest speed of a wheel \[m/s\].
    pub speed_mps_max: f64,
    /// Turns of the encoder per turn of its wheel.
    pub gear_reduction: f64,
    /// Counts of the encoder per turn of its wheel.
    pub counts_per_wheel_turn: f64,
}

/// The role of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotorRole {
    /// At zero the effect is gone.
    Amplitude,
    /// A speed or a number of waves that says where the effect acts.
    Shape,
}

/// One parameter of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorParameter {
    /// Its name.
    pub name: Cow<'static, str>,
    /// Its unit; `1` for a ratio.
    pub unit: Cow<'static, str>,
    /// Least value that a motor can have.
    pub low: f64,
    /// Greatest value that a motor can have.
    pub high: f64,
    /// A usual size: steps of the search are shares of it.
    pub usual: f64,
    /// Amplitude or shape.
    pub role: MotorRole,
}

impl MotorParameter {
    /// An amplitude of either sign.
    pub const fn amplitude(name: &'static str, unit: &'static str, usual: f64, limit: f64) -> Self {
        Self::new((name, unit), (-limit, limit), usual, MotorRole::Amplitude)
    }

    /// An amplitude that is never negative.
    pub const fn positive(name: &'static str, unit: &'static str, usual: f64, limit: f64) -> Self {
        Self::new((name, unit), (0.0, limit), usual, MotorRole::Amplitude)
    }

    /// A shape.
    pub const fn shape(name: &'static str, unit: &'static str, low: f64, high: f64) -> Self {
        Self::new((name, unit), (low, high), low, MotorRole::Shape)
    }

    const fn new(
        (name, unit): (&'static str, &'static str),
        (low, high): (f64, f64),
        usual: f64,
        role: MotorRole,
    ) -> Self {
        Self { name: Cow::Borrowed(name), unit: Cow::Borrowed(unit), low, high, usual, role }
    }
}

/// The facts about an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorFacts<'a> {
    /// Stable name.
    pub id: &'a str,
    /// In a few words.
    pub name: &'a str,
    /// In volts, unless it says otherwise.
    pub equation: &'a str,
    /// Its parameters.
    pub parameters: &'a [MotorParameter],
    /// What a positive value means.
    pub sign: &'a str,
    /// Which experiments show it.
    pub shown_by: &'a str,
    /// What to do about it.
    pub remedy: &'a str,
}

/// Both wheels' moments from what is the same for both.
pub(crate) fn moments(
    speed_mps: WheelPair<f64>,
    (volts, full_v): (WheelPair<f64>, f64),
    turns: WheelPair<f64>,
    (t_s, since_pause_s, heading_rad): (f64, f64, f64),
) -> WheelPair<Moment> {
    WheelPair::new(
        Moment {
            side: 1.0,
            speed_mps: (speed_mps.left, speed_mps.right),
            volts: (volts.left, volts.right),
            full_v,
            turns: turns.left,
            t_s,
            since_pause_s,
            heading_rad,
        },
        Moment {
            side: -1.0,
            speed_mps: (speed_mps.right, speed_mps.left),
            volts: (volts.right, volts.left),
            full_v,
            turns: turns.right,
            t_s,
            since_pause_s,
            heading_rad,
        },
    )
}
