//! Functions for a flexible model: small made-up effects that together can take nearly any shape over speed, turn rate,
//! acceleration, curvature, heading, load and time.
//!
//! With [`super::auxiliary_effects::AUXILIARY_EFFECTS`] and the effects of the catalogue they are what [`super::flexible_model`] chooses from.

use super::auxiliary_effects::{AuxiliaryEffect, sum, turns};
use super::regressor::Regressor;
use crate::effect::definition::{Change, Memory};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Where the robot is in the world \[m\], and its nominal move.
struct Moved {
    r: [f64; 2],
    dr: [f64; 2],
}

impl Moved {
    fn by(step: &Step) -> Self {
        let ((sin, cos), ds_m) = (step.heading_rad.sin_cos(), step.travel_m());
        Self { r: step.place_m, dr: [cos * ds_m, sin * ds_m] }
    }
}

/// Drifts in the world \[m\] by these four functions.
fn drifts(p: &[Jet; PARAMETERS_MAX], by: [[f64; 2]; 4]) -> Change {
    let along = |axis: usize| sum(p, by.map(|drift| drift[axis]));
    Change { drift_m: [along(0), along(1)], ..Change::NONE }
}

/// Time constants of what answers late \[s\].
const LATE_S: [f64; 2] = [0.15, 0.6];

/// A quantity as it was, with two delays of first order; their states are the memory's.
fn late(step: &Step, memory: &mut Memory, now: f64) -> [f64; 2] {
    let follow = |state: &mut Option<Jet>, time_s: f64| {
        let before = state.map_or(now, |jet| jet.value);
        let after = now + (before - now) * (-step.dt_s / time_s).exp();
        *state = Some(Jet::constant(after));
        (before + after) / 2.0
    };
    [follow(&mut memory.wheel.left, LATE_S[0]), follow(&mut memory.wheel.right, LATE_S[1])]
}

/// Lengths over which a tyre answers \[m\].
const LATE_M: [f64; 2] = [0.04, 0.15];

/// A quantity as it was, with two delays in time and two in the distance rolled; their states are the memory's.
fn late_by_time_and_distance(step: &Step, memory: &mut Memory, now: f64) -> [f64; 4] {
    let [soon, later] = late(step, memory, now);
    let follow = |state: &mut Jet, length_m: f64| {
        let after = now + (state.value - now) * (-step.rolled_m() / length_m).exp();
        let middle = (state.value + after) / 2.0;
        *state = Jet::constant(after);
        middle
    };
    let near = follow(&mut memory.speed_mps.left, LATE_M[0]);
    let far = follow(&mut memory.speed_mps.right, LATE_M[1]);
    [soon, later, near, far]
}

/// The share of a turn in the motion: 0 on a straight, 1 in a spin.
fn sharpness(step: &Step) -> f64 {
    let rim_mps = step.turn_rate_rad_s().abs() * step.track_width_m;
    let both_mps = 2.0 * step.speed_mps().abs() + rim_mps;
    if both_mps > 0.0 { rim_mps / both_mps } else { 0.0 }
}

pub(super) static FUNCTIONS: &[AuxiliaryEffect] = &[
    // What answers late: sideways to the side force, round to the turn rate.
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, memory| {
            let force = step.speed_mps() * step.turn_rate_rad_s();
            let [soon, later] = late(step, memory, force);
            let now = [force, force * step.speed_mps().signum(), soon, later];
            Change { sideways_m: sum(p, now.map(|x| x * step.dt_s)), ..Change::NONE }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, memory| {
            let ds_m = step.travel_m();
            let angles = late_by_time_and_distance(step, memory, step.turn_rate_rad_s());
            Change { sideways_m: sum(p, angles.map(|omega| omega * ds_m)), ..Change::NONE }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, memory| {
            let omega = step.turn_rate_rad_s();
            let [soon, later] = late(step, memory, omega);
            turns(
                p,
                [omega - soon, omega - later, omega * omega, omega.abs()].map(|x| x * step.dt_s),
            )
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Speed,
        act: |p, step, memory| {
            let v = step.speed_mps();
            let [soon, later] = late(step, memory, v);
            let travel = [v - soon, v - later].map(|x| x * step.dt_s);
            let (share, ds_m) = (p[0] * travel[0] + p[1] * travel[1], step.travel_m());
            // As a share of the travel, which is small only where nothing moves.
            let share = if ds_m.abs() > 1e-9 { share * (1.0 / ds_m) } else { Jet::ZERO };
            let turn = p[2] * (v - soon) + p[3] * (v - later);
            Change { travel: WheelPair::both(share), turn_rad: turn * step.dt_s, ..Change::NONE }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Speed,
        act: |p, step, _| {
            let v = step.speed_mps();
            let wheels = step.wheel_speed_mps.map(|v| v * v);
            Change {
                travel: WheelPair::new(
                    p[0] * wheels.left + p[2] * (v * v * v.abs()),
                    p[1] * wheels.right + p[2] * (v * v * v.abs()),
                ),
                sideways_m: p[3] * (v * v.abs() * step.dt_s),
                ..Change::NONE
            }
        },
    },
    // Speed and turn rate together.
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, _| {
            let (v, omega) = (step.speed_mps(), step.turn_rate_rad_s());
            let turning = sum(p, [v * v, v.abs(), v, omega.abs() * v.abs()]);
            Change { turning, ..Change::NONE }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, _| {
            let (v, omega) = (step.speed_mps(), step.turn_rate_rad_s());
            Change {
                turning: p[0] * (omega * omega),
                turn_rad: (p[1] * (v * omega) + p[2] * (v * omega.abs())) * step.dt_s,
                sideways_m: p[3] * (v * v * omega * step.dt_s),
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, _| {
            let (v, omega) = (step.speed_mps(), step.turn_rate_rad_s());
            let travel = sum(p, [omega, omega.abs(), omega * v, omega * omega]);
            Change { travel: WheelPair::both(travel), ..Change::NONE }
        },
    },
    // Products of speed and turn rate that the groups above lack.
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, _| {
            let (v, omega) = (step.speed_mps(), step.turn_rate_rad_s());
            let square = omega * omega;
            let by = [v * square, v.abs() * square, v * v * omega.abs(), v.abs() * omega.abs()];
            turns(p, by.map(|x| x * step.dt_s))
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TurnRate,
        act: |p, step, _| {
            let chi = sharpness(step);
            Change {
                turning: p[0] * chi + p[1] * (chi * chi),
                travel: WheelPair::both(p[2] * chi + p[3] * (chi * chi)),
                ..Change::NONE
            }
        },
    },
    // Each wheel by its direction.
    AuxiliaryEffect {
        regressor: Regressor::TravelDirection,
        act: |p, step, _| {
            let sign = step.wheel_speed_mps.map(f64::signum);
            let omega = step.turn_rate_rad_s();
            Change {
                travel: WheelPair::new(p[0] * sign.left, p[1] * sign.right),
                turning: p[2] * omega.signum(),
                sideways_m: p[3] * step.travel_m().abs(),
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Acceleration,
        act: |p, step, _| {
            let accel = step.wheel_accel_mps2;
            let (along, round) = (accel.mean(), accel.difference() / step.track_width_m);
            let by = [along, along.abs(), along * step.speed_mps().signum(), round];
            turns(p, by.map(|x| x * step.dt_s))
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Load,
        act: |p, step, _| {
            let (load, chi) = (step.payload_kg, sharpness(step));
            let (v, omega) = (step.speed_mps(), step.turn_rate_rad_s());
            Change {
                turning: p[0] * (load * chi) + p[1] * (load * omega.abs()),
                turn_rad: p[2] * (load * v * v.abs() * step.dt_s),
                sideways_m: p[3] * (load * v * omega * step.dt_s),
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Load,
        act: |p, step, _| {
            let (load, chi) = (step.payload_kg, sharpness(step));
            let travel = sum(p, [load * chi, load * step.speed_mps().abs(), 0.0, 0.0]);
            let turning = p[2] * load + p[3] * (load * step.speed_mps().abs());
            Change { travel: WheelPair::both(travel), turning, ..Change::NONE }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Heading,
        act: |p, step, _| {
            let path_m = step.travel_m().abs();
            let (two, three) =
                ((2.0 * step.heading_rad).sin_cos(), (3.0 * step.heading_rad).sin_cos());
            Change {
                sideways_m: (p[0] * two.0 + p[1] * two.1) * path_m,
                turn_rad: (p[2] * three.0 + p[3] * three.1) * path_m,
                ..Change::NONE
            }
        },
    },
    // What carries the robot as far as its middle goes, not its tyres; and a pile that carries each tyre by itself, the outer
    // one of an arc further, which turns the robot.
    AuxiliaryEffect {
        regressor: Regressor::Heading,
        act: |p, step, _| {
            let rolled_m = step.wheel_travel_m().map(f64::abs);
            let (sin, cos) = step.heading_rad.sin_cos();
            let ahead = p[0] * cos + p[1] * sin;
            let path_m = step.travel_m().abs();
            Change {
                drift_m: [p[2] * path_m, p[3] * path_m],
                turn_rad: ahead * (rolled_m.difference() / step.track_width_m),
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::TimeInRun,
        act: |p, step, _| {
            let minutes = step.t_s / 60.0;
            let square = minutes * minutes;
            Change {
                travel: WheelPair::both(p[0] * square),
                turn_rad: (p[1] * minutes + p[2] * square) * step.dt_s,
                turning: p[3] * square,
                ..Change::NONE
            }
        },
    },
    AuxiliaryEffect {
        regressor: Regressor::Place,
        act: |p, step, _| {
            let [x, y] = step.place_m;
            let path_m = step.travel_m().abs();
            turns(p, [x * x, y * y, x * y, 0.0].map(|shape| shape * path_m))
        },
    },
    // A camera whose lens bends the floor, about a middle of its own: d[(1 + k |r - c|^2) (r - c)] to first order in c.
    AuxiliaryEffect {
        regressor: Regressor::Place,
        act: |p, step, _| {
            let Moved { r: [x, y], dr: [dx, dy] } = Moved::by(step);
            let along = x * dx + y * dy;
            let radial =
                [(x * x + y * y) * dx + 2.0 * x * along, (x * x + y * y) * dy + 2.0 * y * along];
            let of_c_x = [2.0 * x * dx + along, x * dy + y * dx];
            let of_c_y = [y * dx + x * dy, 2.0 * y * dy + along];
            drifts(p, [radial, of_c_x, of_c_y, [0.0; 2]])
        },
    },
    // A camera that looks at the floor aslant: perspective, d[(1 + a . r) r], and axes of unequal scale that are not square.
    AuxiliaryEffect {
        regressor: Regressor::Place,
        act: |p, step, _| {
            let Moved { r: [x, y], dr: [dx, dy] } = Moved::by(step);
            let of_a_x = [2.0 * x * dx, x * dy + y * dx];
            let of_a_y = [y * dx + x * dy, 2.0 * y * dy];
            drifts(p, [of_a_x, of_a_y, [dx, -dy], [dy, dx]])
        },
    },
];
