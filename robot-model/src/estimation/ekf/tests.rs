//! The derivatives of the whitened rows, which a fit uses, against differences of high order.
//!
//! The measured poses are exactly those that the effect gives, so every innovation is zero, to rounding. How the
//! filter's gains depend on the parameters then plays no part, and a row's derivative is that of the prediction.
//! Wheel angles are not rounded to whole counts, as speeds are smoothed.

use super::*;
use crate::effect::composition::{PlacedTerm, Term};
use crate::estimation::gyro::whiten_gyro;
use crate::estimation::predict::open_loop_from;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::random::Random;
use crate::recording::campaign::{Campaign, Prepared};
use crate::recording::nominal_run::{Sampling, nominal_run};
use crate::recording::run::{GyroSample, Recording, Robot, WheelSample};
use crate::tests::synthetic::{ALONE, NOISE, ROBOT, part_of_plan, term};

const SAMPLING: Sampling = Sampling { sample_s: 0.02, samples_per_pose: 5, ..Sampling::USUAL };

/// One of each kind of run: straight both ways, on the spot, in arcs both ways, in a square.
const KINDS: [&str; 6] = [
    "out_and_back_1",
    "out_and_back_2",
    "spin_0.2",
    "arc_0.4_0.12_6",
    "arc_0.9_0.35_-6",
    "square_2",
];

/// The wheels of these runs.
fn driven() -> Vec<Recording> {
    let plan = part_of_plan(&KINDS);
    plan.iter().map(|(name, _, pieces)| nominal_run(&ROBOT, name, pieces, &SAMPLING)).collect()
}

/// Runs at constant acceleration, ahead, back and on the spot. A smoothed speed is exact there,
/// except in the first and the last tenth of a second, in which no pose is measured.
fn faster_and_faster() -> Vec<Recording> {
    let run = |accel: WheelPair<f64>| {
        let mut run = Recording { name: "faster".to_owned(), ..Recording::default() };
        for k in 0..=120 {
            let t_s = 0.02 * f64::from(k);
            let travel_m = |accel: f64| accel * (0.3 * t_s + t_s * t_s / 2.0);
            let phi_rad = accel.map(|accel| travel_m(accel) / ROBOT.wheel_radius_m);
            run.wheels.push(WheelSample { t_s, phi_rad });
            if (15..=105).contains(&k) && k % 5 == 0 {
                run.measured_poses.push(PoseMeasurement {
                    t_s,
                    position_m: None,
                    heading_rad: None,
                });
            }
        }
        run
    };
    let accels = [(0.15, 0.2), (-0.2, -0.12), (-0.15, 0.15)];
    accels.map(|(left, right)| run(WheelPair::new(left, right))).into()
}

/// A campaign of these runs, measured exactly as the terms predict; the gyro measures noise alone.
fn seen_by(terms: &[Term<'_>], mut runs: Vec<Recording>) -> Prepared {
    let robot = Robot { gear_reduction: 3.0, ..ROBOT };
    let mut random = Random::new(1);
    for (k, run) in runs.iter_mut().enumerate() {
        let k = k as f64;
        (run.started_s, run.payload_kg) = (Some(100.0 + 300.0 * k), 2.0 * k);
        run.gyro = run.wheels[1..]
            .iter()
            .map(|sample| GyroSample { t_s: sample.t_s - 0.01, rate_rad_s: 0.3 * random.normal() })
            .collect();
        let motion = Motion::new(&robot, run, Some(300.0 * k));
        let start = Pose::new(0.1, -0.2, 0.05 + 1.5 * k);
        let track = open_loop_from(start, &motion, &run.measured_poses, Terms::Fixed(terms));
        assert_eq!(track.predicted.len(), run.measured_poses.len());
        for (measurement, pose) in run.measured_poses.iter_mut().zip(&track.predicted) {
            measurement.position_m = Some([pose.x_m, pose.y_m]);
            measurement.heading_rad = Some(pose.heading_rad);
        }
    }
    Campaign { robot, runs }.prepare().expect("sound runs")
}

/// Whitened innovations and their rows, of all runs.
#[derive(Default)]
struct Rows {
    residuals: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl FilterObserver for Rows {
    fn row(&mut self, innovation: Innovation, row: &[f64]) {
        self.residuals.push(innovation.value / innovation.variance.sqrt());
        self.rows.push(row.to_vec());
    }
}

fn rows(prepared: &Prepared, terms: &[Term<'_>], noise: &OdometryNoise) -> Rows {
    let placed = PlacedTerm::place(terms);
    let terms = Terms::Free(&placed);
    let mut rows = Rows::default();
    for run in &prepared.runs {
        whiten(&run.motion, &run.recording.measured_poses, terms, noise, &mut rows);
        whiten_gyro(run, terms, noise, &mut rows);
    }
    rows
}

/// The largest error of a column of rows, and the largest of its numbers, by central differences of sixth
/// order at two widths, which Richardson's extrapolation combines to the eighth.
fn error_of_column(prepared: &Prepared, term: &Term<'_>, j: usize, width: f64) -> (f64, f64) {
    let noise = OdometryNoise { heading_offset_rad: 1e-3, clock_offset_s: 1e-3, ..NOISE };
    let exact = rows(prepared, core::slice::from_ref(term), &noise);
    let at = |steps: f64| {
        let mut moved = term.clone();
        moved.values[j] += steps * width;
        rows(prepared, &[moved], &noise).residuals
    };
    let sixth = |wide: f64| -> Vec<f64> {
        let [m3, m2, m1, p1, p2, p3] = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0].map(|k| at(k * wide));
        (0..m3.len())
            .map(|k| {
                (45.0 * (p1[k] - m1[k]) - 9.0 * (p2[k] - m2[k]) + (p3[k] - m3[k]))
                    / (60.0 * width * wide)
            })
            .collect()
    };
    let (fine, coarse) = (sixth(1.0), sixth(2.0));
    let (mut error, mut most) = (0.0_f64, 0.0_f64);
    for (row, (fine, coarse)) in exact.rows.iter().zip(fine.iter().zip(coarse)) {
        // Halving the width leaves a 64th of the error.
        let slope = -(fine + (fine - coarse) / 63.0);
        error = error.max((row[j] - slope).abs());
        most = most.max(row[j].abs());
    }
    (error, most)
}

/// Rounding of a whitened residual: a heading of 10 rad in parts of 1e-16, summed over a thousand steps,
/// in units of a milliradian.
const ROUNDING: f64 = 2e-11;

/// Width of a difference; effects with an edge are smooth in a tiny neighbourhood only.
fn width(id: &str, value: f64) -> f64 {
    let share = if matches!(id, "lost_counts" | "backlash") { 1e-5 } else { 1e-3 };
    share * value.abs()
}

/// Checks each column of an effect's rows to this share of its largest number, and rounding.
fn check_rows(id: &str, values: &[f64], width: &[f64], share: f64) {
    let term = term(id, values);
    let runs = if id == "measurement_delay" { faster_and_faster() } else { driven() };
    let prepared = seen_by(core::slice::from_ref(&term), runs);
    for (j, width) in width.iter().enumerate() {
        let (error, most) = error_of_column(&prepared, &term, j, *width);
        let rounding = ROUNDING / width;
        assert!(most > 1e3 * rounding, "{id} {j}: {most:e}");
        assert!(error <= share * most + rounding, "{id} {j}: {error:e} of {most:e}");
    }
}

#[test]
fn rows_of_every_effect_are_the_derivatives_of_the_whitened_residuals() {
    for (id, values) in ALONE {
        // Six steps of these ramps take up a backlash of exactly 0.06: there is no derivative at that edge.
        let values: Vec<f64> = values.iter().map(|value| 1.037 * value).collect();
        let widths: Vec<f64> = values.iter().map(|value| width(id, *value)).collect();
        match id {
            // That the turn of a slope depends on the heading is left out of the covariances: a thousandth.
            "slope" => {
                check_rows(id, &values, &widths, 1e-3);
                check_rows(id, &[0.0, 0.0, values[2]], &widths[..2], 1e-7);
            }
            // Eighth order, of a thousandth of a value.
            _ => check_rows(id, &values, &widths, 1e-7),
        }
    }
}

/// The largest innovation, in standard errors, of a run of two seconds with these travels and measured poses.
fn largest_innovation(
    term: Term<'_>,
    travel_m: impl Fn(f64) -> WheelPair<f64>,
    seen: impl Fn(f64) -> Pose,
) -> f64 {
    let mut run = Recording { name: "two seconds".to_owned(), ..Recording::default() };
    for k in 0..=100 {
        let t_s = 0.02 * f64::from(k);
        let phi_rad = travel_m(t_s).map(|travel_m| travel_m / ROBOT.wheel_radius_m);
        run.wheels.push(WheelSample { t_s, phi_rad });
        if (10..=90).contains(&k) {
            let pose = seen(t_s);
            let position_m = Some([pose.x_m, pose.y_m]);
            run.measured_poses.push(PoseMeasurement {
                t_s,
                position_m,
                heading_rad: Some(pose.heading_rad),
            });
        }
    }
    // All noise is a thousandth of the usual one, and the clocks agree.
    let noise = OdometryNoise { clock_offset_s: 0.0, ..NOISE }.times(1e-3);
    let motion = Motion::new(&ROBOT, &run, None);
    let mut rows = Rows::default();
    whiten(&motion, &run.measured_poses, Terms::Fixed(&[term]), &noise, &mut rows);
    rows.residuals.iter().fold(0.0, |most, residual| most.max(residual.abs()))
}

#[test]
fn late_measurements_are_of_where_the_robot_was_before() {
    // One second at rest, then one at 0.3 m/s: a late measurement is behind, by 0.3 m/s tau.
    let (speed, tau) = (0.3, 0.043);
    let way = |t_s: f64| speed * (t_s - 1.0).max(0.0);
    let late = |t_s: f64| Pose::new(way(t_s - tau), 0.0, 0.0);
    let travel = |t_s: f64| WheelPair::both(way(t_s));
    assert!(largest_innovation(term("measurement_delay", &[tau]), travel, late) < 1e-6);
    assert!(largest_innovation(term("measurement_delay", &[-tau]), travel, late) > 100.0);
    // The same on the spot: it has turned less.
    let late = |t_s: f64| Pose::new(0.0, 0.0, 2.0 * way(t_s - tau) / ROBOT.track_width_m);
    let travel = |t_s: f64| WheelPair::new(-way(t_s), way(t_s));
    assert!(largest_innovation(term("measurement_delay", &[tau]), travel, late) < 1e-6);
    assert!(largest_innovation(term("measurement_delay", &[-tau]), travel, late) > 100.0);
}

#[test]
fn a_marker_ahead_and_to_the_left_turns_with_the_body() {
    let (speed, ahead, left) = (0.2, 0.02, 0.03);
    let omega = 2.0 * speed / ROBOT.track_width_m;
    let seen = |t_s: f64| {
        let (sin, cos) = (omega * t_s).sin_cos();
        Pose::new(ahead * cos - left * sin, ahead * sin + left * cos, omega * t_s)
    };
    let spin = |t_s: f64| WheelPair::new(-speed * t_s, speed * t_s);
    assert!(largest_innovation(term("marker_offset", &[ahead, left]), spin, seen) < 1e-6);
    for wrong in [[-ahead, left], [ahead, -left], [left, ahead]] {
        assert!(largest_innovation(term("marker_offset", &wrong), spin, seen) > 100.0);
    }
}
