use super::readings::REVERSAL_SIGMA_RAD;
use super::*;
use crate::calibration::wheel_weight::{Deviation, Experiment};
use crate::kinematics::pose::Pose;
use crate::kinematics::{Geometry, WheelPair};
use crate::numeric::distributions::SIGMAS_95;
use crate::numeric::random::Random;
use core::f64::consts::TAU;

const OUT: WheelPair<f64> = WheelPair::both(8.0 * TAU);
const BACK: WheelPair<f64> = WheelPair::both(-8.0 * TAU);

/// alpha of the paper's robot by (1), s taken from the wheels.
fn leg(wheel_weight: f64, pull_rad_per_m: f64, turns: WheelPair<f64>, sigma: f64) -> Leg {
    leg_of(&Geometry::PAPER, wheel_weight, pull_rad_per_m, turns, sigma)
}

fn leg_of(
    geometry: &Geometry,
    wheel_weight: f64,
    pull_rad_per_m: f64,
    turns: WheelPair<f64>,
    sigma: f64,
) -> Leg {
    let Geometry { wheel_radius_m: r, track_width_m: b, .. } = *geometry;
    let (left_m, right_m) = (r * turns.left, r * turns.right * wheel_weight);
    let wheels = (left_m - right_m) / b;
    // s = R_L phi_L - b alpha / 2 contains alpha: solved for alpha.
    let sign = turns.left.signum();
    let alpha_rad =
        (wheels + pull_rad_per_m * left_m.abs()) / (1.0 + pull_rad_per_m * sign * b / 2.0);
    Leg { alpha_rad, alpha_sigma_rad: sigma, turns }
}

fn separate(wheel_weight: f64, pull_rad_per_m: f64, sigma: f64) -> OutAndBack {
    let [out, back] = [OUT, BACK].map(|turns| leg(wheel_weight, pull_rad_per_m, turns, sigma));
    OutAndBack::new(out, back, Shared::TRACKS, &Geometry::PAPER).unwrap()
}

#[test]
fn a_pull_is_not_mistaken_for_a_radius() {
    let found = separate(1.0, 0.02, 0.002);
    assert_eq!(found.verdict, CurvatureCause::Pull);
    assert!((found.wheel_weight - 1.0).abs() < 1e-12, "{found:?}");
    assert!((found.pull_rad_per_m - 0.02).abs() < 1e-12, "{found:?}");
}

#[test]
fn a_radius_is_not_mistaken_for_a_pull() {
    let found = separate(0.9919, 0.0, 0.002);
    assert_eq!(found.verdict, CurvatureCause::Radius);
    assert!((found.wheel_weight - 0.9919).abs() < 1e-12, "{found:?}");
    assert!(found.pull_rad_per_m.abs() < 1e-12, "{found:?}");
}

#[test]
fn both_and_neither_are_told_apart() {
    let both = separate(0.9919, -0.01, 0.002);
    assert_eq!(both.verdict, CurvatureCause::Both);
    assert!((both.wheel_weight - 0.9919).abs() < 1e-12);
    assert!((both.pull_rad_per_m + 0.01).abs() < 1e-12);
    assert_eq!(separate(0.9999, 0.0002, 0.01).verdict, CurvatureCause::Neither);
}

#[test]
fn legs_of_different_length_and_an_already_weighted_robot_are_allowed_for() {
    let out = WheelPair { left: 50.0, right: 50.5 };
    let back = WheelPair { left: -30.0, right: -30.3 };
    let found = OutAndBack::new(
        leg(0.985, 0.007, out, 0.001),
        leg(0.985, 0.007, back, 0.001),
        Shared::TRACKS,
        &Geometry::PAPER,
    )
    .unwrap();
    assert!((found.wheel_weight - 0.985).abs() < 1e-12, "{found:?}");
    assert!((found.pull_rad_per_m - 0.007).abs() < 1e-12, "{found:?}");
}

/// A robot that drives out and back, and what a person reads after each leg.
#[derive(Clone, Copy)]
struct Trial {
    wheel_weight: f64,
    pull_rad_per_m: f64,
    /// The robot as it is.
    real: Geometry,
    /// The nominal robot, with its tolerances.
    nominal: Geometry,
    start_heading_rad: f64,
    start_heading_sigma_rad: f64,
    /// By how much the robot turns on reversing.
    reversal_rad: f64,
}

impl Trial {
    const PAPER: Self = Self {
        wheel_weight: 0.9919,
        pull_rad_per_m: 0.0,
        real: Geometry::PAPER,
        nominal: Geometry::PAPER,
        start_heading_rad: 0.0,
        start_heading_sigma_rad: 0.0,
        reversal_rad: 0.0,
    };

    /// The poses after each leg, relative to the line that the robot should have been put on.
    fn poses(&self) -> [Pose; 2] {
        let mut pose = Pose::new(0.0, 0.0, self.start_heading_rad);
        [OUT, BACK].map(|turns| {
            let alpha =
                leg_of(&self.real, self.wheel_weight, self.pull_rad_per_m, turns, 0.0).alpha_rad;
            let left_m = self.real.wheel_radius_m * turns.left;
            let b = self.real.track_width_m;
            if turns == BACK {
                pose.heading_rad += self.reversal_rad;
            }
            pose = pose.advance(left_m, left_m - b * alpha, b);
            pose
        })
    }

    fn experiments(&self, read: impl FnMut(Pose) -> Deviation) -> [Experiment; 2] {
        let [out, back] = self.poses().map(read);
        [(OUT, out), (BACK, back)].map(|(turns, deviation)| Experiment {
            deviation,
            turns,
            geometry: self.nominal,
            start_heading_sigma_rad: self.start_heading_sigma_rad,
        })
    }

    fn separate(&self, read: impl FnMut(Pose) -> Deviation) -> OutAndBack {
        let [out, back] = self.experiments(read);
        OutAndBack::by_readings(&out, &back).unwrap()
    }
}

/// A reading with a ruler; `noise` is its error in sigmas.
fn offset(pose: Pose, sigma_m: f64, noise: f64) -> Deviation {
    Deviation::LateralOffset { y_m: pose.y_m + sigma_m * noise, sigma_m }
}

/// The reading of a tangent over 30 cm.
fn tangent(pose: Pose, sigma_m: f64, noise: f64) -> Deviation {
    let dy_m = -0.3 * pose.heading_rad.tan() + sigma_m * noise;
    Deviation::Tangent { dx_m: 0.3, dy_m, sigma_m }
}

#[test]
fn readings_after_both_legs_give_back_radius_and_pull() {
    for (wheel_weight, pull_rad_per_m) in [(0.9919, 0.0), (1.0, 0.02), (1.02, -0.03), (0.95, 0.01)]
    {
        let trial = Trial { wheel_weight, pull_rad_per_m, ..Trial::PAPER };
        let read: [fn(Pose) -> Deviation; 2] =
            [|pose| offset(pose, 0.0005, 0.0), |pose| tangent(pose, 0.0005, 0.0)];
        for read in read {
            let found = trial.separate(read);
            // The arcs are exact; only the tolerance of the solver is left.
            assert!((found.wheel_weight - wheel_weight).abs() < 1e-9, "{found:?}");
            assert!((found.pull_rad_per_m - pull_rad_per_m).abs() < 1e-9, "{found:?}");
        }
    }
}

#[test]
fn a_turn_on_reversing_is_not_mistaken_for_a_pull() {
    // A millimetre and a half beside the line after both ways, with a ruler of half a millimetre.
    let trial = Trial { wheel_weight: 1.0, reversal_rad: -0.0008, ..Trial::PAPER };
    let found = trial.separate(|pose| offset(pose, 0.0005, 0.0));
    assert!(found.pull_rad_per_m.abs() > 4e-4, "{found:?}");
    assert_eq!(found.verdict, CurvatureCause::Neither, "{found:?}");
}

#[test]
fn readings_of_two_kinds_are_refused() {
    let [out, _] = Trial::PAPER.experiments(|pose| offset(pose, 0.0005, 0.0));
    let [_, back] = Trial::PAPER.experiments(|pose| tangent(pose, 0.0005, 0.0));
    assert_eq!(OutAndBack::by_readings(&out, &back), Err(OutAndBackError::Mixed));
    assert_eq!(OutAndBack::by_readings(&back, &out), Err(OutAndBackError::Mixed));
}

#[test]
fn a_ruler_gives_the_sigmas_of_its_equations() {
    let psi = 0.002;
    let trial = Trial { wheel_weight: 1.0, start_heading_sigma_rad: psi, ..Trial::PAPER };
    let found = trial.separate(|pose| offset(pose, 0.0005, 0.0));
    let s_m = 0.036 * OUT.left;
    let per_m = 0.0005 / s_m;
    // The encoders' rounding adds less than 1 % to the first and 2 % to the second, in squares.
    let kappa = REVERSAL_SIGMA_RAD;
    let radius = (5.0 * per_m * per_m + 4.0 * psi * psi + kappa * kappa).sqrt();
    assert!((found.radius_alpha_sigma_rad / radius - 1.0).abs() < 0.01, "{found:?}");
    let pull = per_m.hypot(kappa) / s_m;
    assert!((found.pull_sigma_rad_per_m / pull - 1.0).abs() < 0.05, "{found:?}");
}

#[test]
fn each_tolerance_is_the_change_that_it_makes() {
    let (db_m, dr_m) = (1e-6, 1e-7);
    let exactly: [fn(Pose) -> Deviation; 2] =
        [|pose| offset(pose, 0.0, 0.0), |pose| tangent(pose, 0.0, 0.0)];
    for read in exactly {
        let exact = Trial::PAPER.separate(read);
        let sigma = |track_width_sigma_m, wheel_radius_sigma_m| {
            let nominal = Geometry { track_width_sigma_m, wheel_radius_sigma_m, ..Geometry::PAPER };
            let with = Trial { nominal, ..Trial::PAPER }.separate(read).wheel_weight_sigma;
            (with.powi(2) - exact.wheel_weight_sigma.powi(2)).sqrt()
        };
        // Tolerances so wide that the rounding of the encoders is negligible.
        let (by_track, by_radius) = (sigma(1e4 * db_m, 0.0), sigma(0.0, 1e4 * dr_m));
        let wider = Geometry { track_width_m: 0.372 + db_m, ..Geometry::PAPER };
        let larger = Geometry { wheel_radius_m: 0.036 + dr_m, ..Geometry::PAPER };
        for (nominal, sigma) in [(wider, by_track), (larger, by_radius)] {
            let moved = Trial { nominal, ..Trial::PAPER }.separate(read);
            let change = (moved.wheel_weight - exact.wheel_weight).abs() * 1e4;
            // (2) is of first order in alpha, which is 0.04.
            assert!((change / sigma - 1.0).abs() < 0.05, "{change} {sigma}");
        }
    }
}

#[test]
fn the_interval_of_two_readings_covers_the_truth_in_95_of_100_trials() {
    let nominal =
        Geometry { track_width_sigma_m: 0.002, wheel_radius_sigma_m: 0.0002, ..Geometry::PAPER };
    let count_rad = nominal.rad_per_count();
    for kind in 0..2 {
        let mut noise = Random::new(0xbac + kind);
        let trials = 2000;
        let (mut covered, mut pull_covered, mut square) = (0, 0, 0.0);
        for _ in 0..trials {
            let real = Geometry {
                wheel_radius_m: nominal.wheel_radius_m + 0.0002 * noise.normal(),
                track_width_m: nominal.track_width_m + 0.002 * noise.normal(),
                ..nominal
            };
            let trial = Trial {
                wheel_weight: 0.985,
                pull_rad_per_m: 0.004,
                real,
                nominal,
                start_heading_rad: 0.002 * noise.normal(),
                start_heading_sigma_rad: 0.002,
                reversal_rad: REVERSAL_SIGMA_RAD * noise.normal(),
            };
            let read: fn(Pose, f64, f64) -> Deviation = [offset, tangent][kind as usize];
            let mut experiments = trial.experiments(|pose| read(pose, 0.0005, noise.normal()));
            // Whole counts, at the start, the turning point and the end.
            let at = [(); 3].map(|()| [noise.uniform() - 0.5, noise.uniform() - 0.5]);
            for (leg, experiment) in experiments.iter_mut().enumerate() {
                experiment.turns.left += count_rad * (at[leg + 1][0] - at[leg][0]);
                experiment.turns.right += count_rad * (at[leg + 1][1] - at[leg][1]);
            }
            let found = OutAndBack::by_readings(&experiments[0], &experiments[1]).unwrap();
            let error = (found.wheel_weight - trial.wheel_weight) / found.wheel_weight_sigma;
            let pull = (found.pull_rad_per_m - trial.pull_rad_per_m) / found.pull_sigma_rad_per_m;
            covered += u32::from(error.abs() < SIGMAS_95);
            pull_covered += u32::from(pull.abs() < SIGMAS_95);
            square += error * error;
        }
        let share = |count: u32| f64::from(count) / f64::from(trials);
        let rms = (square / f64::from(trials)).sqrt();
        println!("kind {kind}: {} {} rms {rms:.3}", share(covered), share(pull_covered));
        // 95 % of 2000 with a sigma of 10: four of them each way.
        assert!((0.93..=0.97).contains(&share(covered)), "{kind}: {covered}");
        assert!((0.93..=0.97).contains(&share(pull_covered)), "{kind}: pull {pull_covered}");
        // 1 / sqrt(2 x 2000) = 0.016: four of them.
        assert!((0.94..=1.06).contains(&rms), "{kind}: {rms}");
    }
}

#[test]
fn two_runs_in_the_same_direction_are_refused() {
    let out = leg(0.99, 0.0, OUT, 0.001);
    let error = OutAndBack::new(out, out, Shared::TRACKS, &Geometry::PAPER).unwrap_err();
    assert_eq!(error, OutAndBackError::SameDirection);
    let nan = Leg { alpha_rad: f64::NAN, ..out };
    let found = OutAndBack::new(nan, out, Shared::TRACKS, &Geometry::PAPER);
    assert_eq!(found, Err(OutAndBackError::BadNumber));
}

#[test]
fn noise_alone_is_called_a_radius_or_a_pull_once_in_twenty() {
    let mut noise = Random::new(5);
    let mut radius = 0;
    let mut pull = 0;
    let trials = 2000;
    for _ in 0..trials {
        let [out, back] = [OUT, BACK].map(|turns| Leg {
            alpha_rad: 0.003 * noise.normal(),
            alpha_sigma_rad: 0.003,
            turns,
        });
        match OutAndBack::new(out, back, Shared::TRACKS, &Geometry::PAPER).unwrap().verdict {
            CurvatureCause::Radius => radius += 1,
            CurvatureCause::Pull => pull += 1,
            CurvatureCause::Both => (radius, pull) = (radius + 1, pull + 1),
            CurvatureCause::Neither => (),
        }
    }
    // 5 % of 2000 with a sigma of 10: four of them each way.
    assert!((60..=140).contains(&radius) && (60..=140).contains(&pull), "{radius} {pull}");
}
