//! The encoder sits before a gear with play: the wheel follows a flank behind it, or runs ahead to the other one.
//!
//! ```text
//! phi_ground = phi - lag,  -beta/2 <= lag <= beta/2                       (1)
//! between the flanks:  v_ground falls by d dt,  lag' = (v - v_ground)/R   (2)
//! at a flank:          v_ground = v
//! ```
//!
//! beta \[rad\] is the whole play, at the wheel; each wheel has its own. d \[m/s^2\] is how fast the wheel slows down by
//! itself. A wheel that drags more than its motor brakes stays behind until the direction is reversed; one that rolls
//! easily runs ahead as soon as the motor brakes by more than d, and a reversal finds it there already. The lag is
//! engaged in the direction of the first motion.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
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
        let (speed, before) = (step.wheel_speed_mps, memory.wheel.zip(memory.speed_mps));
        let moved = step.dphi_rad.zip(speed).zip(before);
        let side = |beta: Jet, ((dphi_rad, v_mps), (share, ground_mps))| {
            let Some(share) = share else {
                // Not yet moved: engaged by the first motion.
                let engaged = (dphi_rad != 0.0).then(|| Jet::constant(0.5 * f64::signum(dphi_rad)));
                return (engaged, Jet::constant(v_mps), Jet::ZERO);
            };
            let (after, ground_mps) = engage(beta, p[2], step, v_mps, Flank { share, ground_mps });
            (Some(after), ground_mps, beta * (share - after))
        };
        let (left, right) = (side(p[0], moved.left), side(p[1], moved.right));
        (memory.wheel.left, memory.speed_mps.left) = (left.0, left.1);
        (memory.wheel.right, memory.speed_mps.right) = (right.0, right.1);
        let mut change = Change::NONE;
        (change.angle_rad.left, change.angle_rad.right) = (left.2, right.2);
        change
    }

    /// A wheel that always drags, and two that run ahead of an ordinary braking motor.
    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        [DRAGS_MPS2, 0.25, 0.12].map(|coast_mps2| vec![0.0, 0.0, coast_mps2]).into()
    }
}

static FACTS: Facts<'static> = Facts {
    id: "backlash",
    name: "gear backlash",
    equation: "phi_ground lags phi by beta_i/2 after a reversal, leads it while braked by more than d",
    parameters: &[
        Parameter::positive("beta_left", "rad", 0.35).usually(0.12),
        Parameter::positive("beta_right", "rad", 0.35).usually(0.12),
        Parameter::shape("d", "m/s^2", 0.02, DRAGS_MPS2),
    ],
    signature: "a step at each reversal of a wheel's direction, or each time it is braked and driven again",
    shown_by: "an out-and-back run with several reversals",
    compensation: "track each gear's play in the odometry",
    ..Facts::DEFAULT
};

/// No robot on wheels brakes by more \[m/s^2\].
const DRAGS_MPS2: f64 = 10.0;

/// Play below which backlash cannot be told from an encoder's dither at rest \[rad\]: a quarter degree.
/// Its only use: while beta is near zero, dither back and forth counts as one reversal.
const DITHER_RAD: f64 = 0.0044;

/// Where a wheel is in its play.
struct Flank {
    /// The lag as a share of the play, -1/2 to 1/2.
    share: Jet,
    /// Speed of the wheel itself \[m/s\].
    ground_mps: Jet,
}

/// The share, and the speed of the wheel itself, after a step (2).
fn engage(beta: Jet, coast_mps2: Jet, step: &Step, v_mps: f64, before: Flank) -> (Jet, Jet) {
    let Flank { share, ground_mps } = before;
    let width = if beta.value > DITHER_RAD { beta } else { Jet::constant(DITHER_RAD) };
    let slower = coast_mps2 * (step.dt_s * -ground_mps.value.signum());
    let coasting = ground_mps + slower;
    // A model of before there was a d has none: its wheels drag.
    let stands = coast_mps2.value <= 0.0 || coasting.value * ground_mps.value <= 0.0;
    let coasting = if stands { Jet::ZERO } else { coasting };
    let apart_rad = (-coasting + v_mps) * (step.dt_s / step.wheel_radius_m);
    let free = share + width.recip() * apart_rad;
    if free.value.abs() > 0.5 {
        (Jet::constant(0.5 * free.value.signum()), Jet::constant(v_mps))
    } else {
        (free, coasting)
    }
}
