//! A caster's pivot has dry friction: it resists the fork's turning, and holds part of the twist when that ends.
//!
//! ```text
//! dtheta = A m ds_r,   dm = dpsi / w,  -1 <= m <= 1        (1)
//! dpsi = (-atan(b omega / v) - psi) |dc| / (b/10)           (2)
//! ```
//!
//! psi is the angle of a fork that trails freely a track width behind the axle, and turns over a tenth of that; c is its
//! own way, ds_r how far the rims rolled; a run begins with psi = m = 0. A \[rad/m\] > 0: the robot turns less while the
//! fork swings out, and goes on turning when it drives straight again, for the fork stays a little askew. w \[rad\]: how
//! far the fork turns before the friction acts fully.

use core::f64::consts::PI;

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;

/// Dry friction in the caster's pivot.
#[derive(Debug)]
pub struct CasterFriction;

impl Effect for CasterFriction {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, memory: &mut Memory) -> Change {
        let (ds_m, rim_m) = (step.travel_m(), step.track_width_m * step.turn_rad());
        let went_m = ds_m.hypot(rim_m);
        if went_m == 0.0 {
            return Change::NONE;
        }
        let before = memory.wheel.left.unwrap_or(Jet::ZERO);
        // A line has no direction: the fork turns the shorter way.
        let off = trailing_rad(step) - before.value;
        let off = off - PI * (off / PI).round();
        let turned = off * -f64::exp_m1(-went_m / (TRAIL * step.track_width_m));
        let held = memory.wheel.right.unwrap_or(Jet::ZERO);
        let free = held + p[1].recip() * turned;
        let held = if free.value.abs() > 1.0 { Jet::constant(free.value.signum()) } else { free };
        memory.wheel.left = Some(Jet::constant(before.value + turned));
        memory.wheel.right = Some(held);
        Change { turn_rad: p[0] * held * step.rolled_m(), ..Change::NONE }
    }

    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        [0.05, 0.2, 0.6].map(|width_rad| vec![0.0, width_rad]).into()
    }
}

/// Where the fork of (2) comes to stand; in a spin, where v is next to nothing, as driving forwards.
fn trailing_rad(step: &Step) -> f64 {
    let (v, rim_mps) = (step.speed_mps(), step.track_width_m * step.turn_rate_rad_s());
    if v < -NEXT_TO_NOTHING * rim_mps.abs() {
        -(rim_mps / v).atan()
    } else {
        -rim_mps.atan2(v.abs())
    }
}

/// A caster trails its pivot by this share of the track width: over it the fork turns into the new direction.
const TRAIL: f64 = 0.1;
/// A spin's share of speed to that of the rims: less is a matter of noise.
const NEXT_TO_NOTHING: f64 = 0.1;

static FACTS: Facts<'static> = Facts {
    id: "caster_friction",
    name: "friction in the caster's pivot",
    equation: "dtheta = A m ds_r, dm = dpsi / w, |m| <= 1, psi = -atan(b omega / v)",
    parameters: &[Parameter::positive("A", "rad/m", 0.5), Parameter::shape("w", "rad", 0.01, 0.8)],
    signature: "less turn than commanded at the start of each arc, and a turn on the straight after it",
    shown_by: "straights after arcs and spins",
    compensation: "grease the caster's pivot, or use a ball caster",
    ..Facts::DEFAULT
};
