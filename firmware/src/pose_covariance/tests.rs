//! The covariance against closed forms, differences of dead reckoning itself, and noisy drives.

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::OdometryConfig;

use super::*;
use crate::dead_reckoning::{DeadReckoning, Geometry};

/// A leg: how far the left wheel goes and how far the right one \[m\].
type Leg = (f64, f64);

/// The left wheel's and the right one's way in ten ticks at 0.4 m/s \[m\].
const STEP_M: f64 = 0.004;

/// Arcs to both sides, turns on the spot, and a way back.
const PATH: [Leg; 7] =
    [(1.0, 1.2), (-0.29, 0.29), (0.8, 0.5), (-0.4, -0.6), (0.9, 0.9), (0.5, -0.1), (0.3, 0.4)];

fn config(noise_m_per_sqrt_m: f64, wheel_weight_sd: f64, track_width_sd_m: f64) -> Config {
    let odometry = OdometryConfig { noise_m_per_sqrt_m, wheel_weight_sd, track_width_sd_m };
    let mut config = Config { odometry, ..Config::default() };
    config.geometry.wheel_weight = 0.9;
    config
}

/// A robot and what it knows of itself.
struct Robot {
    travel_m: WheelPair<f64>,
    reckoning: DeadReckoning,
    covariance: PoseCovariance,
}

impl Robot {
    fn new(config: &Config) -> Self {
        let mut robot = Self {
            travel_m: WheelPair::new(5.0, -3.0),
            reckoning: DeadReckoning::new(),
            covariance: PoseCovariance::new(),
        };
        robot.adopt(config);
        robot
    }

    fn adopt(&mut self, config: &Config) {
        let (travel, pose) = (self.travel(), self.reckoning.pose());
        self.reckoning.adopt(Geometry::new(config), travel);
        self.covariance.adopt(Uncertainty::new(config), travel, pose);
    }

    fn travel(&self) -> WheelPair<Travel> {
        self.travel_m.map(|m| Travel(I32F32::from_num(m)))
    }

    /// Goes on by this.
    fn roll(&mut self, left_m: f64, right_m: f64) {
        self.travel_m.left += left_m;
        self.travel_m.right += right_m;
        let travel = self.travel();
        self.reckoning.step(travel);
        self.covariance.step(travel, self.reckoning.pose());
    }

    /// Drives, while `each` changes what a wheel goes in a step.
    fn drive_with(&mut self, legs: &[Leg], mut each: impl FnMut(f64) -> f64) {
        for &(left_m, right_m) in legs {
            let steps = (left_m.abs().max(right_m.abs()) / STEP_M).ceil();
            for _ in 0..steps as u32 {
                self.roll(each(left_m / steps), each(right_m / steps));
            }
        }
    }

    fn drive(&mut self, legs: &[Leg]) {
        self.drive_with(legs, |m| m);
    }

    fn pose(&self) -> [f64; 3] {
        let Pose { x_um, y_um, heading_urad } = self.reckoning.pose();
        [x_um, y_um, heading_urad].map(|micro| micro as f64 * 1e-6)
    }

    /// Standard deviations of x, y and heading, and their correlations xy, x heading and y heading.
    fn deviation(&self) -> [f64; 6] {
        let d = self.covariance.deviation();
        let [x, y, heading] = [d.x_um, d.y_um, d.heading_urad].map(|sd| f64::from(sd) * 1e-6);
        let [xy, xh, yh] = [d.x_y, d.x_heading, d.y_heading].map(|c| f64::from(c) / 8191.0);
        [x, y, heading, xy, xh, yh]
    }
}

/// Drives these legs.
fn driven(config: &Config, legs: &[Leg]) -> Robot {
    let mut robot = Robot::new(config);
    robot.drive(legs);
    robot
}

/// What a step of a centimetre and a microradian leave of a standard deviation, as a share.
fn close(found: f64, expected: f64, share: f64) {
    let off = (found - expected).abs();
    assert!(off <= share * expected.abs() + 2e-6, "{found}, and not {expected}");
}

#[test]
fn on_a_straight_line_noise_grows_as_on_paper() {
    const N: f64 = 0.001;
    let s: f64 = 4.0;
    let [x, y, heading, xy, xh, yh] = driven(&config(N, 0.0, 0.0), &[(s, s)]).deviation();
    let turned = N * (2.0 * s).sqrt() / 0.372;
    close(heading, turned, 2e-3);
    close(x, N * (s / 2.0).sqrt(), 2e-3);
    close(y, turned * s / 3.0_f64.sqrt(), 4e-3);
    close(yh, 0.75_f64.sqrt(), 1e-3);
    assert!(xy.abs() < 1e-3 && xh.abs() < 1e-3, "{xy} {xh}");
}

#[test]
fn single_precision_holds_for_ten_kilometres() {
    let (s, step_m) = (10_000.0, 0.010_1);
    let mut robot = Robot::new(&config(0.0001, 0.0001, 0.0));
    for _ in 0..(s / step_m) as u32 {
        robot.roll(step_m, step_m);
    }
    let [_, y, heading, ..] = robot.deviation();
    let (noise, weight) = (0.0001 * 2.0_f64.sqrt() / 0.372, 0.0001 / 0.9 / 0.372);
    let expected_rad = (noise * noise * s + weight * weight * s * s).sqrt();
    let expected_m = (noise * noise * s * s * s / 3.0 + weight * weight * s.powi(4) / 4.0).sqrt();
    println!("{heading} {expected_rad}, {y} {expected_m}");
    close(heading, expected_rad, 0.02);
    // A deviation is sent up to 4.3 km.
    close(y, expected_m.min(4_294.967_295), 0.02);
}

#[test]
fn noise_does_not_cancel_on_the_way_back() {
    let config = config(0.001, 0.0, 0.0);
    let [.., out, _, _, _] = driven(&config, &[(4.0, 4.0)]).deviation();
    let [_, y, back, ..] = driven(&config, &[(4.0, 4.0), (-4.0, -4.0)]).deviation();
    close(back, out * 2.0_f64.sqrt(), 4e-3);
    // A turn at a place turns what comes after it, and that is the way from there to the end: at most 4 m, twice.
    close(y, 0.001 * 2.0_f64.sqrt() / 0.372 * (2.0 * 64.0 / 3.0_f64).sqrt(), 4e-3);
}

#[test]
fn a_wrong_wheel_bends_a_straight_line_and_unbends_it_on_the_way_back() {
    let (s, b) = (3.0, 0.372);
    let weight = config(0.0, 0.002, 0.0);
    let share = 0.002 / 0.9;
    let [x, y, heading, xy, xh, yh] = driven(&weight, &[(s, s)]).deviation();
    close(heading, share * s / b, 4e-3);
    close(y, share * s * s / (2.0 * b), 8e-3);
    close(x, share * s / 2.0, 4e-3);
    // One number moves all three.
    for correlation in [xy, xh, yh] {
        // Four steps of 1/8191 smaller, and rounded down.
        close(correlation, 1.0, 7e-4);
    }
    let [x, y, heading, ..] = driven(&weight, &[(s, s), (-s, -s)]).deviation();
    // A centimetre on either side has not been followed yet.
    let rest = share * 0.01 / b;
    assert!(heading <= rest && x <= rest * s && y <= rest * s, "{x} {y} {heading}");
}

#[test]
fn a_wrong_track_width_turns_turns_and_nothing_else() {
    let track = config(0.0, 0.0, 0.004);
    let straight = driven(&track, &[(3.0, 3.0)]);
    assert_eq!(straight.covariance.deviation(), PoseDeviation::default());
    let turn_m = 0.5 * 0.372 * core::f64::consts::FRAC_PI_2;
    let [x, y, heading, ..] = driven(&track, &[(-turn_m, turn_m), (2.0, 2.0)]).deviation();
    let share = 0.004 / 0.372;
    close(heading, core::f64::consts::FRAC_PI_2 * share, 0.02);
    close(x, 2.0 * heading, 0.01);
    assert!(y < 1e-3 * x, "{x} {y}");
}

/// Where a robot ends whose geometry is this much off.
fn end(weight: f64, track_m: f64) -> [f64; 3] {
    let mut config = config(0.0, 0.0, 0.0);
    config.geometry.wheel_weight += weight;
    config.geometry.track_width_m += track_m;
    let share = config.geometry.wheel_weight / 0.9;
    let mut robot = Robot::new(&config);
    let scaled = PATH.map(|(left_m, right_m)| (left_m, share * right_m));
    robot.drive(&scaled);
    robot.pose()
}

#[test]
fn the_systematic_part_is_how_dead_reckoning_itself_answers_to_another_geometry() {
    let robot = driven(&config(0.0, 0.005, 0.004), &PATH);
    let [weight, track] = robot.covariance.systematic;
    let difference = |more: [f64; 3], less: [f64; 3], by: f64| {
        [0, 1, 2].map(|i| (more[i] - less[i]) / (2.0 * by))
    };
    for (name, column, sd, slope) in [
        ("W_T", weight, 0.005, difference(end(0.004, 0.0), end(-0.004, 0.0), 0.004)),
        ("b", track, 0.004, difference(end(0.0, 0.002), end(0.0, -0.002), 0.002)),
    ] {
        let size = slope.iter().map(|s| s * s).sum::<f64>().sqrt();
        for (found, slope) in column.into_iter().zip(slope) {
            let found = f64::from(found) / sd;
            println!("{name}: {found:.5}, by differences {slope:.5}");
            // A centimetre of 4 m is not followed yet, and the differences have a second order.
            assert!((found - slope).abs() < 4e-3 * size, "{name}: {found} {slope}");
        }
    }
}

#[test]
fn noisy_drives_scatter_as_the_covariance_says() {
    const N: f64 = 0.001;
    const DRIVES: usize = 2000;
    let config = config(N, 0.0, 0.0);
    let exact = driven(&config, &PATH);
    let mean = exact.pose();
    let mut rng = ChaCha8Rng::seed_from_u64(15);
    let mut sums = [[0.0; 3]; 3];
    for _ in 0..DRIVES {
        let mut robot = Robot::new(&config);
        robot.drive_with(&PATH, |way_m| {
            // Twelve numbers from 0 to 1 have a variance of one.
            let normal = (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0;
            way_m + N * way_m.abs().sqrt() * normal
        });
        let pose = robot.pose();
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            sums[i][j] += (pose[i] - mean[i]) * (pose[j] - mean[j]) / DRIVES as f64;
        }
    }
    let [sx, sy, sh, xy, xh, yh] = exact.deviation();
    for (i, sd) in [sx, sy, sh].into_iter().enumerate() {
        let found = sums[i][i].sqrt();
        println!("{i}: {sd:.6}, of {DRIVES} drives {found:.6}");
        // 2000 drives give a standard deviation to 1.6 %.
        close(sd, found, 0.06);
    }
    for ((i, j), correlation) in [(0, 1), (0, 2), (1, 2)].into_iter().zip([xy, xh, yh]) {
        let found = sums[i][j] / (sums[i][i] * sums[j][j]).sqrt();
        println!("{i}{j}: {correlation:.3}, of {DRIVES} drives {found:.3}");
        // And a correlation to 0.02.
        assert!((correlation - found).abs() < 0.07, "{correlation} {found}");
    }
}

#[test]
fn without_noise_and_with_a_sure_geometry_the_pose_is_exactly_sure() {
    let robot = driven(&config(0.0, 0.0, 0.0), &PATH);
    assert_eq!(robot.covariance.deviation(), PoseDeviation::default());
}

#[test]
fn a_robot_that_does_not_move_stays_sure_whatever_its_counts_do() {
    let mut robot = Robot::new(&config(0.01, 0.1, 0.1));
    assert_eq!(robot.covariance.deviation(), PoseDeviation::default());
    for _ in 0..100_000 {
        robot.roll(0.000_25, 0.0);
        robot.roll(-0.000_25, 0.000_25);
        robot.roll(0.0, -0.000_25);
    }
    assert_eq!(robot.covariance.deviation(), PoseDeviation::default());
}

#[test]
fn another_configuration_keeps_what_there_is_and_goes_on_with_its_own_numbers() {
    let (unsure, sure) = (config(0.001, 0.002, 0.004), config(0.0, 0.0, 0.0));
    let mut robot = driven(&unsure, &PATH);
    let before = robot.deviation();
    robot.covariance.pause();
    robot.travel_m.right -= 0.5;
    robot.covariance.step(robot.travel(), robot.reckoning.pose());
    // It does not follow the travel; the pose has gone on by less than a centimetre before that.
    for (now, before) in robot.deviation().into_iter().zip(before) {
        assert!((now - before).abs() < 0.005, "{now} {before}");
    }
    let before = robot.deviation();
    robot.adopt(&sure);
    for (now, before) in robot.deviation().into_iter().zip(before) {
        close(now, before, 1e-4);
    }
    robot.drive(&PATH);
    close(robot.deviation()[2], before[2], 1e-4);

    // What was systematic does not come back under another configuration, which may be wrong in another way.
    let weight = config(0.0, 0.002, 0.0);
    let mut robot = driven(&weight, &[(3.0, 3.0)]);
    let [.., out, _, _, _] = robot.deviation();
    robot.adopt(&weight);
    robot.drive(&[(-3.0, -3.0)]);
    close(robot.deviation()[2], out * 2.0_f64.sqrt(), 8e-3);
}

/// Whether these are the correlations of something: no principal minor is negative.
fn is_possible([_, _, _, a, b, c]: [f64; 6]) -> bool {
    let minors = [a, b, c].map(|correlation| 1.0 - correlation * correlation);
    minors.iter().all(|minor| *minor >= 0.0) && 1.0 + 2.0 * a * b * c - a * a - b * b - c * c >= 0.0
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn what_is_sent_is_always_a_covariance(
        legs in proptest::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64), 1..12),
        straight_m in -100.0..100.0_f64,
        (noise, weight, track_m) in (0.0..0.01_f64, 0.0..0.1_f64, 0.0..0.1_f64),
        present in any::<[bool; 3]>(),
        track_width_m in 0.05..2.0_f64,
    ) {
        let [noise, weight, track_m] =
            [(noise, present[0]), (weight, present[1]), (track_m, present[2])]
                .map(|(number, is_present)| if is_present { number } else { 0.0 });
        let mut config = config(noise, weight, track_m);
        config.geometry.track_width_m = track_width_m;
        let mut robot = Robot::new(&config);
        for leg in legs.into_iter().chain([(straight_m, straight_m), (-straight_m, -straight_m)]) {
            robot.drive(&[leg]);
            let deviation = robot.deviation();
            prop_assert!(is_possible(deviation), "{deviation:?}");
        }
    }

    #[test]
    fn roots_and_numbers_are_those_of_the_library(value in 1e-12..1e12_f32, number in -7.9..7.9_f64) {
        prop_assert!((root(value) / value.sqrt() - 1.0).abs() < 3e-6);
        prop_assert!((f64::from(single(number)) - number).abs() < 3e-7);
    }
}
