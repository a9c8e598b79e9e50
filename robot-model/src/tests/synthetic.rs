//! Simulated recordings of a robot of known truth, for tests.

use core::f64::consts::{FRAC_PI_2, TAU};
use std::sync::OnceLock;

use crate::effect::catalogue::find;
use crate::effect::composition::{Composer, Term, Terms};
use crate::effect::definition::{Change, Effect, Facts, Memory};
use crate::estimation::transition::Transition;
use crate::kinematics::pose::Pose;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::numeric::random::Random;
use crate::recording::campaign::Campaign;
use crate::recording::motion::{Motion, Step};
use crate::recording::nominal_run::{Piece, Sampling, nominal_run};
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::{GyroSample, Recording, Robot, WheelSample};

pub(crate) const ROBOT: Robot = Robot::PAPER;

/// A good camera over a good floor.
pub(crate) const NOISE: OdometryNoise = OdometryNoise {
    position_sigma_m: 1e-3,
    heading_sigma_rad: 2e-3,
    travel_walk: 5e-4,
    heading_walk: 1e-3,
    position_wobble_m: 0.0,
    heading_wobble_rad: 0.0,
    wobble_s: 1.0,
    gyro_walk: 1e-3,
    heading_offset_rad: 0.0,
    clock_offset_s: 0.0,
};

/// 50 samples and 10 poses a second.
const SAMPLING: Sampling = Sampling { sample_s: 0.02, samples_per_pose: 5, ..Sampling::USUAL };

/// An effect with these values.
pub(crate) fn term(id: &str, values: &[f64]) -> Term<'static> {
    Term::new(find(id).expect("an id of the catalogue"), values.into())
}

/// Turns the robot by so much in a metre \[rad/m\], as no effect of the catalogue does.
pub(crate) struct TurnsPerMetre(pub fn(&Step) -> f64);

impl core::fmt::Debug for TurnsPerMetre {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("TurnsPerMetre")
    }
}

impl Effect for TurnsPerMetre {
    fn facts(&self) -> Facts<'_> {
        Facts { id: "turns_per_metre", name: "turns per metre", ..Facts::DEFAULT }
    }

    fn act(&self, _: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let turn_rad = Jet::constant((self.0)(step) * step.travel_m().abs());
        Change { turn_rad, ..Change::NONE }
    }
}

/// Every effect at a size of thirty sigmas or more on the full plan.
pub(crate) const ALONE: [(&str, &[f64]); 24] = [
    ("wheel_radius_ratio", &[0.005]),
    ("wheel_radius_scale", &[0.005]),
    ("track_width", &[0.01]),
    ("scrub", &[0.01]),
    ("side_slip", &[0.015]),
    ("traction_slip", &[0.04]),
    ("turn_load_transfer", &[0.06]),
    ("speed_growth", &[0.06]),
    ("wheel_eccentricity", &[0.008, 0.005, -0.01, 0.004]),
    ("encoder_eccentricity", &[0.012, 0.01, -0.015, 0.008]),
    ("lost_counts", &[0.02, 5.0]),
    ("backlash", &[0.06, 0.07, 0.12]),
    ("caster_kick", &[0.03, 0.06]),
    ("heading_pull", &[0.006]),
    ("turn_asymmetry", &[0.004]),
    ("slope", &[0.004, 0.003, 0.5]),
    ("carpet_drift", &[0.004, -0.003]),
    ("thermal_drift", &[2e-6]),
    ("payload", &[0.001]),
    ("measurement_delay", &[0.03]),
    ("marker_offset", &[0.004, 0.003]),
    ("heading_drift", &[0.001]),
    ("gyro_bias", &[0.004]),
    ("gyro_scale", &[0.01]),
];

/// What a camera measures of a planned run, driven by a robot with these effects.
pub(crate) fn measure(
    robot: &Robot,
    plan: &Recording,
    start: Pose,
    truth: &[Term<'_>],
    noise: &OdometryNoise,
    random: &mut Random,
) -> Recording {
    let mut recording = plan.clone();
    let motion = Motion::new(robot, plan, plan.started_s);
    let mut composer = Composer::new(Terms::Fixed(truth));
    let (view, _) = composer.view();
    let [ahead_m, left_m] = view.offset_m.map(|jet| jet.value);
    let mut pose = start;
    let mut poses = vec![(plan.wheels[0].t_s, start)];
    for (step, after) in motion.steps.iter().zip(&plan.wheels[1..]) {
        let mut step = *step;
        step.heading_rad = pose.heading_rad + step.turn_rad() / 2.0;
        step.place_m = [pose.x_m, pose.y_m];
        let increment = composer.step(&step);
        let rolled_m = step.wheel_travel_m().map(f64::abs).mean();
        pose = Transition::new(pose, &increment, 1.0).pose;
        pose.x_m += random.normal() * noise.travel_variance_m2(rolled_m).sqrt();
        pose.y_m += random.normal() * noise.travel_variance_m2(rolled_m).sqrt();
        pose.heading_rad += random.normal() * noise.heading_variance_rad2(rolled_m).sqrt();
        poses.push((after.t_s, pose));
    }
    for measurement in &mut recording.measured_poses {
        let seen_s = measurement.t_s - view.delay_s.value;
        let after = poses.partition_point(|(t_s, _)| *t_s <= seen_s).clamp(1, poses.len() - 1);
        let ((t0, a), (t1, b)) = (poses[after - 1], poses[after]);
        let share = ((seen_s - t0) / (t1 - t0)).clamp(0.0, 1.0);
        let at = |a: f64, b: f64| a + share * (b - a);
        let middle =
            Pose::new(at(a.x_m, b.x_m), at(a.y_m, b.y_m), at(a.heading_rad, b.heading_rad));
        let point = middle.compose(Pose::new(ahead_m, left_m, 0.0));
        measurement.position_m = Some([
            point.x_m + noise.position_sigma_m * random.normal(),
            point.y_m + noise.position_sigma_m * random.normal(),
        ]);
        let drifted_rad = view.heading_drift_rad_s.value * (measurement.t_s - plan.wheels[0].t_s);
        measurement.heading_rad =
            Some(point.heading_rad + drifted_rad + noise.heading_sigma_rad * random.normal());
    }
    for pair in poses.windows(2) {
        let ((t0, before), (t1, after)) = (pair[0], pair[1]);
        let omega = (after.heading_rad - before.heading_rad) / (t1 - t0);
        let parameters = |term: &Term<'_>| Jet::parameters(&term.values);
        let added = truth.iter().map(|term| term.effect.sense_rate(&parameters(term), omega).value);
        // 0.003 rad/s of white noise at 50 readings a second: 0.4 mrad after a second.
        let rate_rad_s = omega + added.sum::<f64>() + 3e-3 * random.normal();
        recording.gyro.push(GyroSample { t_s: (t0 + t1) / 2.0, rate_rad_s });
    }
    for WheelSample { phi_rad, .. } in &mut recording.wheels {
        *phi_rad = phi_rad.map(|phi| (phi / robot.rad_per_count).floor() * robot.rad_per_count);
    }
    recording
}

/// The runs of a full campaign: name, heading at the start, pieces.
pub(crate) fn full_plan() -> Vec<(String, f64, Vec<Piece>)> {
    let mut runs = Vec::new();
    let there_and_back = |speed_mps: f64| {
        vec![
            Piece::Straight { travel_m: 1.8, speed_mps },
            Piece::Rest { duration_s: 0.5 },
            Piece::Straight { travel_m: -1.8, speed_mps },
        ]
    };
    for (k, speed_mps) in [0.12, 0.3, 0.12, 0.3].into_iter().enumerate() {
        let heading_rad = k as f64 * FRAC_PI_2;
        runs.push((format!("out_and_back_{k}"), heading_rad, there_and_back(speed_mps)));
    }
    for speed_mps in [0.06, 0.2] {
        for turn_rad in [2.0 * TAU, -2.0 * TAU] {
            let pieces = vec![Piece::Spin { turn_rad, speed_mps }];
            runs.push((format!("spin_{speed_mps}_{turn_rad:.0}"), 0.0, pieces));
        }
    }
    for radius_m in [0.4, 0.9] {
        for speed_mps in [0.12, 0.35] {
            for turn_rad in [0.9 * TAU, -0.9 * TAU] {
                let pieces = vec![Piece::Arc { radius_m, turn_rad, speed_mps }];
                runs.push((format!("arc_{radius_m}_{speed_mps}_{turn_rad:.0}"), 0.0, pieces));
            }
        }
    }
    for turn_rad in [FRAC_PI_2, -FRAC_PI_2] {
        let side = [
            Piece::Straight { travel_m: 1.0, speed_mps: 0.25 },
            Piece::Spin { turn_rad, speed_mps: 0.12 },
        ];
        runs.push((format!("square_{turn_rad:.0}"), 0.0, side.repeat(4)));
    }
    runs.push(("repeat".to_owned(), 0.0, there_and_back(0.12)));
    runs
}

/// A campaign over such runs, one every two minutes, the later half with a load of 3 kg, from imprecise
/// starts; the encoders count on from run to run.
pub(crate) fn campaign(
    plan: &[(String, f64, Vec<Piece>)],
    truth: &[Term<'_>],
    seed: u64,
) -> Campaign {
    let mut random = Random::new(seed);
    let mut runs = Vec::new();
    let mut phi = WheelPair::both(0.0);
    for (k, (name, heading_rad, pieces)) in plan.iter().enumerate() {
        let mut planned = nominal_run(&ROBOT, name, pieces, &SAMPLING);
        planned.started_s = Some(120.0 * k as f64);
        planned.payload_kg = if 2 * k > plan.len() { 3.0 } else { 0.0 };
        for sample in &mut planned.wheels {
            sample.phi_rad = sample.phi_rad.zip(phi).map(|(a, b)| a + b);
        }
        phi = planned.wheels.last().expect("a run has samples").phi_rad;
        let start = Pose::new(
            0.1 * random.normal(),
            0.1 * random.normal(),
            heading_rad + 0.03 * random.normal(),
        );
        runs.push(measure(&ROBOT, &planned, start, truth, &NOISE, &mut random));
    }
    Campaign { robot: ROBOT, runs }
}

/// The runs of the full plan whose names begin with one of these.
pub(crate) fn part_of_plan(beginnings: &[&str]) -> Vec<(String, f64, Vec<Piece>)> {
    let wanted = |name: &str| beginnings.iter().any(|beginning| name.starts_with(beginning));
    full_plan().into_iter().filter(|(name, ..)| wanted(name)).collect()
}

/// Twelve runs of the full plan: straight in four headings, spins, large arcs, squares.
fn short_plan() -> Vec<(String, f64, Vec<Piece>)> {
    part_of_plan(&["out_and_back", "spin_0.2", "arc_0.9", "square"])
}

/// A sound robot over the full plan.
pub(crate) fn sound() -> &'static Campaign {
    static SOUND: OnceLock<Campaign> = OnceLock::new();
    SOUND.get_or_init(|| campaign(&full_plan(), &[], 3))
}

/// A robot with each effect of [`ALONE`], by the effect's id.
pub(crate) fn each_alone() -> &'static [(&'static str, Campaign)] {
    static EACH: OnceLock<Vec<(&'static str, Campaign)>> = OnceLock::new();
    let with = |(id, values): (&'static str, &[f64])| {
        (id, campaign(&short_plan(), &[term(id, values)], 3))
    };
    EACH.get_or_init(|| ALONE.into_iter().map(with).collect())
}

/// The same campaign with only the first and the last pose of each run measured.
pub(crate) fn end_poses_only(mut campaign: Campaign) -> Campaign {
    for run in &mut campaign.runs {
        let last = run.measured_poses.len() - 1;
        run.measured_poses = vec![run.measured_poses[0], run.measured_poses[last]];
    }
    campaign
}

/// A sound robot's campaign of which only the ends of runs were measured.
pub(crate) fn ends(seed: u64) -> Campaign {
    let mut campaign = campaign(&full_plan(), &[], seed);
    for run in &mut campaign.runs {
        let poses = &mut run.measured_poses;
        poses.drain(1..poses.len() - 1);
    }
    campaign
}

/// Moves the end of each fifth run by four centimetres, which no effect does.
pub(crate) fn push_some_aside(campaign: &mut Campaign) {
    for (index, run) in campaign.runs.iter_mut().enumerate().filter(|(i, _)| i % 5 == 2) {
        let Some(last) = run.measured_poses.last_mut() else { continue };
        let aside_m = if index % 2 == 0 { 0.03 } else { -0.03 };
        last.position_m = last.position_m.map(|[x_m, y_m]| [x_m + aside_m, y_m - aside_m]);
    }
}
