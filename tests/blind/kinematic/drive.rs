//! Where does the robot go? Equations (1) and (2) of [`super`], and the noise of rolling.
//!
//! ```text
//! along, aside: white, k_s sqrt(d);  turn: white, k_h sqrt(d), and a curvature c d that walks by k_c sqrt(d)    (3)
//! ```
//!
//! d is how far the rims rolled.

use rand_chacha::ChaCha8Rng;

use super::mechanism::Hidden;
use super::mechanism_step::{Change, Memory, Step, act};
use super::normal;
use super::planned_run::{DT_S, PlannedRun, Wheels};

/// The robot, as its owner knows it; noise as it is.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Wheel radius \[m\].
    pub radius_m: f64,
    /// Track width \[m\].
    pub track_m: f64,
    /// Encoder revolutions per wheel revolution.
    pub gear: f64,
    /// Fastest wheel of the campaign \[m/s\].
    pub fastest_mps: f64,
    /// k_s \[m/sqrt(m)\].
    pub travel_walk: f64,
    /// k_h \[rad/sqrt(m)\].
    pub heading_walk: f64,
    /// k_c \[rad/m/sqrt(m)\].
    pub curvature_walk: f64,
}

/// How a run begins.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// x, y, heading \[m, m, rad\].
    pub pose: [f64; 3],
    /// Angle of each wheel since the campaign began \[rad\].
    pub phi_rad: [f64; 2],
    /// Time since the campaign began \[s\].
    pub time_s: f64,
}

/// The true pose at each millisecond; without noise if `rng` is `None`.
pub fn drive(
    body: &Body,
    (run, wheels): (&PlannedRun, &[Wheels]),
    start: Start,
    hidden: &[Hidden],
    mut rng: Option<ChaCha8Rng>,
) -> Vec<[f64; 3]> {
    let mut memories = vec![Memory::default(); hidden.len()];
    let mut history = History::default();
    let (mut pose, mut curvature) = (start.pose, 0.0);
    let mut poses = vec![pose];
    for (k, pair) in wheels.windows(2).enumerate() {
        let (before, after) = (pair[0], pair[1]);
        let mean = |of: fn(&Wheels) -> [f64; 2]| {
            let (a, b) = (of(&before), of(&after));
            [0, 1].map(|i| (a[i] + b[i]) / 2.0)
        };
        let t_s = (k as f64 + 0.5) * DT_S;
        let step = history.note(Step {
            wheel_m: [0, 1].map(|i| after.rolled_m[i] - before.rolled_m[i]),
            wheel_mps: mean(|wheels| wheels.speed_mps),
            wheel_mps2: mean(|wheels| wheels.accel_mps2),
            phi_rad: [0, 1].map(|i| start.phi_rad[i] + before.rolled_m[i] / body.radius_m),
            gear: body.gear,
            radius_m: body.radius_m,
            track_m: body.track_m,
            fastest_mps: body.fastest_mps,
            heading_rad: pose[2],
            place_m: [pose[0], pose[1]],
            time_s: [t_s, start.time_s + t_s],
            payload_kg: run.payload_kg,
            ..Step::default()
        });
        let changes =
            hidden.iter().zip(&mut memories).map(|(hidden, memory)| act(hidden, &step, memory));
        let mut moved = moved(body, &step, changes);
        let rolled_m = step.rolled_m();
        if let (Some(rng), true) = (&mut rng, rolled_m > 0.0) {
            let root = rolled_m.sqrt();
            curvature += body.curvature_walk * root * normal(rng);
            moved.along_m += body.travel_walk * root * normal(rng);
            moved.left_m += body.travel_walk * root * normal(rng);
            moved.turn_rad += curvature * rolled_m + body.heading_walk * root * normal(rng);
        }
        let (sin, cos) = (pose[2] + moved.turn_rad / 2.0).sin_cos();
        pose[0] += moved.along_m * cos - moved.left_m * sin + moved.world_m[0];
        pose[1] += moved.along_m * sin + moved.left_m * cos + moved.world_m[1];
        pose[2] += moved.turn_rad;
        poses.push(pose);
    }
    poses
}

/// What happened in the run so far.
#[derive(Default)]
struct History {
    /// Forwards, backwards, or not yet moved.
    direction: f64,
    since_reversal_m: Option<f64>,
    since_stop_m: f64,
}

impl History {
    /// The step with what happened before it.
    fn note(&mut self, mut step: Step) -> Step {
        let travel_m = (step.wheel_m[0] + step.wheel_m[1]) / 2.0;
        let rolled_m = step.rolled_m();
        if travel_m != 0.0 && travel_m.signum() != self.direction {
            self.since_reversal_m = (self.direction != 0.0).then_some(0.0);
            self.direction = travel_m.signum();
        }
        if rolled_m == 0.0 {
            self.since_stop_m = 0.0;
        }
        (step.since_reversal_m, step.since_stop_m) = (self.since_reversal_m, self.since_stop_m);
        self.since_reversal_m = self.since_reversal_m.map(|since_m| since_m + travel_m.abs());
        self.since_stop_m += rolled_m;
        step
    }
}

/// One step of the body, in its own frame and in the world.
struct Moved {
    along_m: f64,
    left_m: f64,
    turn_rad: f64,
    world_m: [f64; 2],
}

/// Equation (1).
fn moved(body: &Body, step: &Step, changes: impl Iterator<Item = Change>) -> Moved {
    let sum = changes.fold(Change::NONE, |sum, one| Change {
        wheel: [0, 1].map(|i| sum.wheel[i] * one.wheel[i]),
        wheel_m: [0, 1].map(|i| sum.wheel_m[i] + one.wheel_m[i]),
        turning: sum.turning * one.turning,
        turn_rad: sum.turn_rad + one.turn_rad,
        left_m: sum.left_m + one.left_m,
        world_m: [0, 1].map(|i| sum.world_m[i] + one.world_m[i]),
    });
    let ds_m = [0, 1].map(|i| (step.wheel_m[i] + sum.wheel_m[i]) * sum.wheel[i]);
    Moved {
        along_m: (ds_m[0] + ds_m[1]) / 2.0,
        left_m: sum.left_m,
        turn_rad: (ds_m[1] - ds_m[0]) / body.track_m * sum.turning + sum.turn_rad,
        world_m: sum.world_m,
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::super::mechanism::Mechanism;
    use super::super::planned_run::{planned_runs, turn_wheels};
    use super::*;

    const BODY: Body = Body {
        radius_m: 0.04,
        track_m: 0.3,
        gear: 1.0,
        fastest_mps: 0.35,
        travel_walk: 1e-3,
        heading_walk: 1e-3,
        curvature_walk: 1e-4,
    };
    const START: Start = Start { pose: [0.0; 3], phi_rad: [0.0; 2], time_s: 0.0 };

    fn end(name: &str, hidden: &[Hidden]) -> [f64; 3] {
        let all = planned_runs(BODY.track_m, BODY.fastest_mps);
        let run = all.iter().find(|run| run.name == name).unwrap();
        let poses = drive(&BODY, (run, &turn_wheels(run)), START, hidden, None);
        poses[poses.len() - 1]
    }

    #[test]
    fn a_sound_robot_goes_where_its_wheels_say() {
        let back = end("out_and_back_east", &[]);
        assert!(back.iter().all(|one| one.abs() < 1e-9), "{back:?}");
        assert!((end("spin_slow_left", &[])[2] - 2.0 * TAU).abs() < 1e-9);
        // Nine tenths of a circle to the right, of one track width: y = -r (1 - cos).
        let arc = end("arc_small_slow_right", &[]);
        let y_m = -BODY.track_m * (1.0 - (0.9 * TAU).cos());
        assert!((arc[2] + 0.9 * TAU).abs() < 1e-9 && (arc[1] - y_m).abs() < 1e-6, "{arc:?}");
    }

    #[test]
    fn a_larger_right_wheel_turns_the_robot_left_and_a_wider_track_turns_it_less() {
        let hidden = |mechanism, value| Hidden { mechanism, p: [value, 0.0, 0.0, 0.0] };
        // dtheta = rho ds / b on the way out, and undone on the way back.
        let ratio = end("out_and_back_east", &[hidden(Mechanism::WheelRadiusRatio, 0.01)]);
        assert!(ratio[2].abs() < 1e-9, "{ratio:?}");
        let pull = end("out_and_back_east", &[hidden(Mechanism::HeadingPull, 0.01)]);
        assert!((pull[2] - 0.01 * 3.2).abs() < 1e-9, "{pull:?}");
        let wide = end("spin_slow_left", &[hidden(Mechanism::TrackWidth, 0.25)]);
        assert!((wide[2] - 2.0 * TAU / 1.25).abs() < 1e-9, "{wide:?}");
    }
}
