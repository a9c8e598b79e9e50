//! The encoder sits before a gear with play: after a reversal it turns while the wheel does not.
//!
//! ```text
//! phi_ground = phi - lag,  lag follows phi within -beta/2 .. beta/2
//! ```
//!
//! beta \[rad\] is the whole play, at the wheel; each wheel has its own. The lag is engaged in the direction of the first motion.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Play between the encoder and the ground.
#[derive(Debug)]
pub struct Backlash;

impl Effect for Backlash {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    /// How long the play takes to close depends on its width.
    fn is_linear(&self) -> bool {
        false
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, memory: &mut Memory) -> Change {
        let state = step.dphi_rad.zip(memory.wheel);
        let play = state
            .zip(WheelPair::new(p[0], p[1]))
            .map(|((dphi, share), beta)| engage(beta, dphi, share));
        memory.wheel = play.map(|(share, _)| share);
        Change { angle_rad: play.map(|(_, angle)| angle), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "backlash",
    name: "gear backlash",
    equation: "phi_ground lags phi by beta_i/2 after a reversal",
    parameters: &[
        Parameter::positive("beta_left", "rad", 0.12),
        Parameter::positive("beta_right", "rad", 0.12),
    ],
    signature: "a step at each reversal of a wheel's direction",
    shown_by: "an out-and-back run with several reversals",
    compensation: "track each gear's play in the odometry",
    ..Facts::DEFAULT
};

/// Play below which backlash cannot be told from an encoder's dither at rest \[rad\]: a quarter degree.
/// Its only use: while beta is near zero, dither back and forth counts as one reversal.
const DITHER_RAD: f64 = 0.0044;

/// Position of the lag within the play, -1/2 to 1/2, after the encoder turned; and by how much more than the encoder
/// the wheel turned.
fn engage(beta: Jet, dphi_rad: f64, before: Option<Jet>) -> (Option<Jet>, Jet) {
    if dphi_rad == 0.0 {
        return (before, Jet::ZERO);
    }
    let Some(before) = before else {
        return (Some(Jet::constant(0.5 * dphi_rad.signum())), Jet::ZERO);
    };
    let width = if beta.value > DITHER_RAD { beta } else { Jet::constant(DITHER_RAD) };
    let free = before + width.recip() * dphi_rad;
    let after =
        if free.value.abs() > 0.5 { Jet::constant(0.5 * free.value.signum()) } else { free };
    (Some(after), beta * (before - after))
}
