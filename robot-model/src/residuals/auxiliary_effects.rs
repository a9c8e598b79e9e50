//! Auxiliary effects: small made-up effects, each a few functions of one regressor.
//!
//! Whether residuals contain one is tested in `unexplained.rs`.

use super::regressor::Regressor;
use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Up to four functions of the same quantities, each with an amplitude of its own.
pub(super) struct AuxiliaryEffect {
    /// What they are functions of.
    pub regressor: Regressor,
    pub act: fn(&[Jet; PARAMETERS_MAX], &Step, &mut Memory) -> Change,
}

impl core::fmt::Debug for AuxiliaryEffect {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.regressor.name())
    }
}

/// Limits far beyond any real value: an auxiliary effect is tested for being there, not for being plausible. In SI units all
/// quantities are of the order of one, and so are amplitudes.
static FACTS: Facts<'static> = Facts {
    id: "auxiliary",
    name: "auxiliary",
    equation: "a sum of functions of one regressor",
    parameters: &[
        Parameter::amplitude("a", "1", 1.0),
        Parameter::amplitude("b", "1", 1.0),
        Parameter::amplitude("c", "1", 1.0),
        Parameter::amplitude("d", "1", 1.0),
    ],
    ..Facts::DEFAULT
};

impl Effect for AuxiliaryEffect {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, memory: &mut Memory) -> Change {
        (self.act)(p, step, memory)
    }
}

/// Turns \[rad\] by these four functions.
pub(super) fn turns(p: &[Jet; PARAMETERS_MAX], by: [f64; 4]) -> Change {
    Change { turn_rad: sum(p, by), ..Change::NONE }
}

pub(super) fn sum(p: &[Jet; PARAMETERS_MAX], by: [f64; 4]) -> Jet {
    p[0] * by[0] + p[1] * by[1] + p[2] * by[2] + p[3] * by[3]
}

fn wheel_harmonic(p: &[Jet; PARAMETERS_MAX], step: &Step, harmonic: f64) -> Change {
    let wave = |c: Jet, s: Jet, phi: f64| {
        let (sin, cos) = (harmonic * phi).sin_cos();
        c * cos + s * sin
    };
    let middle = step.phi_rad.zip(step.dphi_rad).map(|(phi, dphi)| phi + dphi / 2.0);
    let travel = WheelPair::new(wave(p[0], p[1], middle.left), wave(p[2], p[3], middle.right));
    Change { travel, ..Change::NONE }
}

/// Turn and scale along the path, as a function of x.
fn path_and_turn(p: &[Jet; PARAMETERS_MAX], step: &Step, x: f64) -> Change {
    let path_m = step.travel_m().abs();
    Change {
        travel: WheelPair::both(p[0] * x + p[1] * (x * x)),
        turn_rad: (p[2] * x + p[3] * (x * x)) * path_m,
        ..Change::NONE
    }
}

/// Travel of either wheel as a function of its own x, so that spins count too.
fn wheels(p: &[Jet; PARAMETERS_MAX], x: WheelPair<f64>) -> Change {
    let travel = WheelPair::new(
        p[0] * x.left + p[1] * (x.left * x.left.abs()),
        p[2] * x.right + p[3] * (x.right * x.right.abs()),
    );
    Change { travel, ..Change::NONE }
}

/// Either wheel's radius, a pull and the track width, in proportion to x.
fn radii_and_track(p: &[Jet; PARAMETERS_MAX], step: &Step, x: f64) -> Change {
    Change {
        travel: WheelPair::new(p[0] * x, p[1] * x),
        turn_rad: p[2] * (x * step.travel_m().abs()),
        turning: p[3] * x,
        ..Change::NONE
    }
}

/// Slower than this the robot stands \[m/s\].
const STANDS_MPS: f64 = 2e-3;

/// How far the rims have rolled since the robot last stood \[m\].
fn since_stop_m(step: &Step, memory: &mut Memory) -> f64 {
    let speeds = step.wheel_speed_mps.map(f64::abs);
    let before_m = memory.wheel.left.map_or(0.0, |jet| jet.value);
    let stands = speeds.left.max(speeds.right) < STANDS_MPS;
    let after_m = if stands { 0.0 } else { before_m + step.rolled_m() };
    memory.wheel.left = Some(Jet::constant(after_m));
    (before_m + after_m) / 2.0
}

/// What the last turn left behind that was faster than either of these \[rad/s\]: turns on the way since, in proportion to
/// the path and to the travel.
fn after_a_turn(
    p: &[Jet; PARAMETERS_MAX],
    step: &Step,
    memory: &mut Memory,
    faster_rad_s: WheelPair<f64>,
) -> Change {
    let omega = step.turn_rate_rad_s();
    // 1 after a turn to the left, -1 after one to the right, 0 before the first.
    let sides = memory.wheel.zip(faster_rad_s).map(|(before, least)| {
        if omega.abs() > least { omega.signum() } else { before.map_or(0.0, |jet| jet.value) }
    });
    memory.wheel = sides.map(|side| Some(Jet::constant(side)));
    let (travel_m, path_m) = (step.travel_m(), step.travel_m().abs());
    let WheelPair { left: one, right: other } = sides;
    turns(p, [one * path_m, one * travel_m, other * path_m, other * travel_m])
}

pub(super) static AUXILIARY_EFFECTS: &[AuxiliaryEffect] = &[
    AuxiliaryEffect {
        regressor: Regressor::WheelAngle,
        act: |p, step, _| wheel_harmonic(p, step, 1.0),
    },
    AuxiliaryEffect {
        regressor: Regressor::WheelAngle,
        act: |p, step, _| wheel_harmonic(p, step, 2.0),
    },
    AuxiliaryEffect {
        regressor: Regressor::WheelAngle,
        act: |p, step, _| wheel_harmonic(p, step, 3.0),
    },
    AuxiliaryEffect {
        regressor: Regressor::WheelAngle,
        act: |p, step, _| {
            // Each wheel rolls where it points to, also in a spin.
            let middle = step.phi_rad.zip(step.dphi_rad).map(|(phi, dphi)| phi + dphi / 2.0);
            let (left, right) = (middle.left.sin_cos(), middle.right.sin_cos());
            let ds_m = step.wheel_travel_m();
            let sideways_m = (p[0] * left.1 + p[1] * left.0) * ds_m.left
                + (p[2] * right.1 + p[3] * right.0) * ds_m.right;
            Change { sideways_m, ..Change::NONE }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Heading,
        act: |p, step, _| {
            let (path_m, (sin, cos)) = (step.travel_m().abs(), step.heading_rad.sin_cos());
            Change {
                turn_rad: (p[0] * cos + p[1] * sin) * path_m,
                drift_m: [p[2] * path_m, p[3] * path_m],
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Heading,
        act: |p, step, _| {
            let (sin, cos) = (2.0 * step.heading_rad).sin_cos();
            let path_m = step.travel_m().abs();
            Change {
                travel: WheelPair::both(p[0] * cos + p[1] * sin),
                turn_rad: (p[2] * cos + p[3] * sin) * path_m,
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Speed,
        act: |p, step, _| path_and_turn(p, step, step.speed_mps().abs()),
    },
    AuxiliaryEffect {
        regressor: Regressor::WheelSpeed,
        act: |p, step, _| wheels(p, step.wheel_speed_mps),
    },
    AuxiliaryEffect {
        regressor: Regressor::Speed,
        act: |p, step, _| {
            let v = step.speed_mps();
            turns(p, [v * v.abs(), v * v, v * v * v, v * v * v.abs()].map(|x| x * step.dt_s))
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::WheelSpeed,
        // A radius that grows does so whichever way the wheel turns.
        act: |p, step, _| wheels(p, step.wheel_speed_mps.map(f64::abs)),
    },
    AuxiliaryEffect {
        regressor: Regressor::Acceleration,
        act: |p, step, _| wheels(p, step.wheel_accel_mps2),
    },
    AuxiliaryEffect {
        regressor: Regressor::Acceleration,
        act: |p, step, _| {
            let x = step.wheel_accel_mps2.zip(step.wheel_speed_mps).map(|(a, v)| a * v.signum());
            wheels(p, x)
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, _| {
            let omega = step.turn_rate_rad_s();
            Change {
                turning: p[0] * omega.abs() + p[1] * omega,
                sideways_m: p[2] * step.turn_rad() + p[3] * step.turn_rad().abs(),
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, _| {
            let omega = step.turn_rate_rad_s().abs();
            let travel = WheelPair::both(p[0] * omega + p[1] * step.turn_sharpness());
            Change { travel, ..Change::NONE }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TravelDirection,
        act: |p, step, _| {
            // In a spin the middle goes nowhere, whatever the sign of its last bit.
            let ds_m = step.travel_m();
            let forwards = if ds_m.abs() > f64::EPSILON { ds_m.signum() } else { 0.0 };
            Change {
                travel: WheelPair::both(p[0] * forwards),
                turn_rad: p[1] * ds_m.abs(),
                turning: p[2] * forwards,
                sideways_m: p[3] * ds_m,
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TimeInRun,
        act: |p, step, _| radii_and_track(p, step, step.t_s / 60.0),
    },
    AuxiliaryEffect {
        regressor: Regressor::TimeInCampaign,
        act: |p, step, _| radii_and_track(p, step, step.clock_s / 3600.0),
    },
    AuxiliaryEffect {
        regressor: Regressor::SinceReversal,
        act: |p, step, _| {
            let Some(since_m) = step.since_reversal_m else { return Change::NONE };
            let ds_m = step.travel_m();
            let near = |length_m: f64| (-since_m / length_m).exp() * ds_m.abs();
            let sign = ds_m.signum();
            Change {
                turn_rad: (p[0] * sign + p[1]) * near(0.05) + (p[2] * sign + p[3]) * near(0.2),
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::SinceReversal,
        act: |p, step, memory| {
            let since_m = since_stop_m(step, memory);
            let (short, long) = ((-since_m / 0.03).exp(), (-since_m / 0.12).exp());
            let (turn_rad, ds_m) = (step.turn_rad().abs(), step.travel_m());
            turns(p, [short * ds_m.abs(), short * ds_m, long * ds_m.abs(), short * turn_rad])
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Place,
        act: |p, step, _| {
            let [x, y] = step.place_m;
            let path_m = step.travel_m().abs();
            Change {
                turn_rad: (p[0] * x + p[1] * y) * path_m,
                travel: WheelPair::both(p[2] * x + p[3] * y),
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Load,
        act: |p, step, _| radii_and_track(p, step, step.payload_kg),
    },
];

/// What may differ from run to run: the travel of either wheel, a pull, the track width.
pub(super) static OF_A_RUN: AuxiliaryEffect =
    AuxiliaryEffect { regressor: Regressor::Run, act: |p, step, _| radii_and_track(p, step, 1.0) };

/// What the last turn left behind: a caster, a toe, a belt. How slow a turn leaves nothing is not known.
pub(super) static AFTER_A_TURN: [AuxiliaryEffect; 2] = [
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, memory| after_a_turn(p, step, memory, WheelPair::new(0.05, 0.15)),
    },
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, memory| after_a_turn(p, step, memory, WheelPair::new(0.3, 0.6)),
    },
];
