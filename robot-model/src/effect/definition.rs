//! What is an effect? The trait, what it can change, and the facts about it.
//!
//! The effects themselves are in `catalogue/` and in [`super::custom`].

use serde::{Deserialize, Serialize};

use std::borrow::Cow;

use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;

/// What an effect does: one formula per method. A method that is left out changes nothing.
pub trait Effect: Sync + core::fmt::Debug {
    /// The facts about it.
    fn facts(&self) -> Facts<'_>;

    /// What it changes in a step of the motion, equations (1) to (3).
    fn act(&self, _p: &[Jet; PARAMETERS_MAX], _step: &Step, _memory: &mut Memory) -> Change {
        Change::NONE
    }

    /// What it changes in the measured pose, equation (4).
    fn observe(&self, _p: &[Jet; PARAMETERS_MAX]) -> View {
        View::NONE
    }

    /// What it adds to the yaw rate sensor when the robot turns at this rate \[rad/s\], equation (5).
    fn sense_rate(&self, _p: &[Jet; PARAMETERS_MAX], _turn_rate_rad_s: f64) -> Jet {
        Jet::ZERO
    }

    /// Parameter values about which the screening of candidates linearises: shapes to try, with amplitudes zero.
    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        vec![vec![0.0; self.facts().parameters.len()]]
    }

    /// Whether it is linear in its parameters; an effect with a shape is not.
    fn is_linear(&self) -> bool {
        self.facts().parameters.iter().all(|parameter| parameter.role == Role::Amplitude)
    }

    /// The range of a parameter in which these runs can show the effect: the plausible range or a part of it.
    fn range(&self, parameter: usize, _excitation: &Excitation) -> (f64, f64) {
        let parameter = &self.facts().parameters[parameter];
        (parameter.low, parameter.high)
    }
}

/// What an effect changes in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Added to the angle that each wheel turned \[rad\].
    pub angle_rad: WheelPair<Jet>,
    /// Relative change of each wheel's travel.
    pub travel: WheelPair<Jet>,
    /// Relative change of the turn.
    pub turning: Jet,
    /// Added to the turn \[rad\].
    pub turn_rad: Jet,
    /// The derivative of that turn by the heading, of an effect of the world: how fast a fit finds it depends on it.
    pub turn_by_heading: f64,
    /// Moved to the left \[m\].
    pub sideways_m: Jet,
    /// Moved in the fixed frame \[m\].
    pub drift_m: [Jet; 2],
}

impl Change {
    /// No change.
    pub const NONE: Self = Self {
        angle_rad: WheelPair::new(Jet::ZERO, Jet::ZERO),
        travel: WheelPair::new(Jet::ZERO, Jet::ZERO),
        turning: Jet::ZERO,
        turn_rad: Jet::ZERO,
        turn_by_heading: 0.0,
        sideways_m: Jet::ZERO,
        drift_m: [Jet::ZERO; 2],
    };
}

/// What an effect changes in the measured pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct View {
    /// The measured point on the body: ahead of the midpoint between the wheels, and to its left \[m\].
    pub offset_m: [Jet; 2],
    /// How late the measurement is \[s\].
    pub delay_s: Jet,
    /// By how much the measured heading drifts in each second of a run \[rad/s\].
    pub heading_drift_rad_s: Jet,
}

impl View {
    /// No change.
    pub const NONE: Self =
        Self { offset_m: [Jet::ZERO; 2], delay_s: Jet::ZERO, heading_drift_rad_s: Jet::ZERO };
}

/// What an effect remembers from step to step of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Memory {
    /// A state of each wheel; `None` before its first motion.
    pub wheel: WheelPair<Option<Jet>>,
    /// A speed of each wheel \[m/s\].
    pub speed_mps: WheelPair<Jet>,
}

/// The role of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// At zero the effect is gone.
    Amplitude,
    /// A length, speed or width that says where the effect acts; never zero.
    Shape,
}

/// One parameter of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, as in `model.toml`.
    pub name: Cow<'static, str>,
    /// Unit; `1` for a ratio.
    pub unit: Cow<'static, str>,
    /// Least plausible value.
    pub low: f64,
    /// Greatest plausible value.
    pub high: f64,
    /// Outside these limits, and at them, a value has no meaning.
    pub possible: (f64, f64),
    /// Amplitude or shape.
    pub role: Role,
    /// The spread of usual values, where it is less than half the plausible range.
    pub usual: Option<f64>,
}

impl Parameter {
    /// An amplitude of either sign.
    pub const fn amplitude(name: &'static str, unit: &'static str, limit: f64) -> Self {
        Self::new(name, unit, (-limit, limit), Role::Amplitude)
    }

    /// An amplitude that is never negative.
    pub const fn positive(name: &'static str, unit: &'static str, limit: f64) -> Self {
        Self::new(name, unit, (0.0, limit), Role::Amplitude)
    }

    /// A shape.
    pub const fn shape(name: &'static str, unit: &'static str, low: f64, high: f64) -> Self {
        Self::new(name, unit, (low, high), Role::Shape)
    }

    const fn new(
        name: &'static str,
        unit: &'static str,
        (low, high): (f64, f64),
        role: Role,
    ) -> Self {
        let possible = (f64::NEG_INFINITY, f64::INFINITY);
        let (name, unit) = (Cow::Borrowed(name), Cow::Borrowed(unit));
        Self { name, unit, low, high, possible, role, usual: None }
    }

    /// The same with a spread of usual values: further off is plausible, and needs more evidence.
    pub const fn usually(mut self, spread: f64) -> Self {
        self.usual = Some(spread);
        self
    }

    /// The same with limits beyond which a value has no meaning: a track without width, a turn the other way round.
    pub const fn possible(mut self, low: f64, high: f64) -> Self {
        self.possible = (low, high);
        self
    }

    /// Whether it is an amplitude of one sign.
    pub fn is_never_negative(&self) -> bool {
        self.role == Role::Amplitude && self.low == 0.0
    }

    /// The spread of values before any data: the usual one, or half the plausible range.
    pub fn spread(&self) -> f64 {
        if let Some(spread) = self.usual {
            return spread;
        }
        match self.role {
            Role::Amplitude => self.high.max(-self.low),
            Role::Shape => (self.high - self.low) / 2.0,
        }
    }
}

/// Where an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActsOn {
    /// How the robot moves.
    Motion,
    /// How its pose is measured.
    Measurement,
    /// How its yaw rate is measured.
    Gyro,
}

/// What runs must have to show an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Need {
    /// A yaw rate sensor.
    YawRate,
    /// The time at which each run began.
    StartTimes,
    /// Counts that go on from run to run, so that a wheel's angle is known across runs.
    ContinuousCounts,
    /// A load in some run.
    Load,
}

/// The place of an effect in a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Radii and track width: measured first on every robot; all other effects come on top.
    Geometry,
    /// The floor on which the runs were driven, not the robot: on another floor it is another.
    Floor,
    /// All other effects.
    Other,
}

/// The parameter by which the firmware compensates an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirmwareTerm {
    /// The wheel weight W_T.
    WheelWeight,
    /// The mean radius of both wheels.
    MeanRadius,
    /// The track width.
    TrackWidth,
    /// The heading pull that motions are steered against.
    HeadingPull,
}

/// The facts about an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts<'a> {
    /// Stable name, as in `model.toml` and JSON.
    pub id: &'a str,
    /// Name for people.
    pub name: &'a str,
    /// Its equation.
    pub equation: &'a str,
    /// Its parameters, at most [`PARAMETERS_MAX`].
    pub parameters: &'a [Parameter],
    /// Where it acts.
    pub acts_on: ActsOn,
    /// Its place in a model.
    pub group: Group,
    /// What runs must have to show it.
    pub needs: &'a [Need],
    /// The part of the firmware's configuration that its first parameter goes into.
    pub compensated_by: Option<FirmwareTerm>,
    /// How it shows in the residuals.
    pub signature: &'a str,
    /// The run that shows it.
    pub shown_by: &'a str,
    /// How to compensate it.
    pub compensation: &'a str,
}

impl Facts<'static> {
    /// An effect of the motion without a name, which needs nothing and which no firmware compensates.
    pub const DEFAULT: Self = Self {
        id: "",
        name: "",
        equation: "",
        parameters: &[],
        acts_on: ActsOn::Motion,
        group: Group::Other,
        needs: &[],
        compensated_by: None,
        signature: "",
        shown_by: "",
        compensation: "",
    };
}
