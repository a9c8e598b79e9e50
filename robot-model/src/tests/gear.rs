//! A gear between encoder and wheel: only the encoder's own ripple may depend on it.

use crate::effect::catalogue::find;
use crate::explain::explanation::explain;
use crate::explain::model::fit;
use crate::kinematics::pose::Pose;
use crate::numeric::random::Random;
use crate::recording::campaign::Campaign;
use crate::recording::nominal_run::{Piece, Sampling, nominal_run};
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::Robot;
use crate::tests::synthetic::{NOISE, ROBOT, campaign, full_plan, measure, term};

/// As the paper's robot, behind a gear.
const GEAR: f64 = 43.7;

/// The same recordings of a robot whose encoders sit before a gear.
fn geared(campaign: &Campaign) -> Campaign {
    let mut geared = campaign.clone();
    geared.robot.gear_reduction = GEAR;
    geared
}

#[test]
fn the_same_motion_behind_a_gear_is_explained_by_the_same_effects_of_the_same_sizes() {
    let truths = [
        vec![term("wheel_radius_ratio", &[0.008]), term("side_slip", &[0.02])],
        vec![term("backlash", &[0.06, 0.07, 10.0])],
        vec![term("lost_counts", &[0.02, 5.0])],
        vec![term("wheel_eccentricity", &[0.015, 0.01, -0.02, 0.0])],
    ];
    for truth in truths {
        let plain = campaign(&full_plan(), &truth, 5);
        let (one, other) = (explain(&plain).unwrap(), explain(&geared(&plain)).unwrap());
        let id = truth[0].effect.facts().id;
        assert_eq!(one.steps.len(), truth.len(), "{id}");
        for (a, b) in one.steps.iter().zip(&other.steps) {
            assert_eq!(a.parameters, b.parameters, "{id}");
            // At a gear of one an eccentric encoder is but another name for an eccentric wheel.
            assert!(a.class.contains(&b.effect), "{id}: {:?} {}", a.class, b.effect);
        }
        assert_eq!(one.steps.len(), other.steps.len());
        // At a gear of one the encoder's ripple is that of the wheel; behind a gear it is not.
        let class = &other.steps[0].class;
        assert!(!class.iter().any(|member| member == "encoder_eccentricity"), "{id}: {class:?}");
    }
}

/// A tracker with a sigma of a fiftieth of a millimetre: behind a gear of 43.7, a ripple of four per cent is a
/// thirtieth of a millimetre.
const TRACKER: OdometryNoise = OdometryNoise {
    position_sigma_m: 2e-5,
    heading_sigma_rad: 1e-4,
    travel_walk: 2e-5,
    heading_walk: 1e-4,
    ..NOISE
};

/// Slow runs: two poses and more for each turn of the encoder, 5 mm of travel.
fn slow_runs(robot: &Robot, values: &[f64]) -> Campaign {
    let fine = Sampling { sample_s: 0.02, samples_per_pose: 5, accel_mps2: 0.05 };
    let truth = [term("encoder_eccentricity", values)];
    let mut random = Random::new(3);
    let pieces = [
        vec![Piece::Straight { travel_m: 0.4, speed_mps: 0.018 }],
        vec![Piece::Straight { travel_m: -0.4, speed_mps: 0.021 }],
        vec![Piece::Spin { turn_rad: 1.5, speed_mps: 0.017 }],
        vec![Piece::Arc { radius_m: 0.5, turn_rad: -0.6, speed_mps: 0.015 }],
    ];
    let runs = pieces.iter().enumerate().map(|(k, pieces)| {
        let planned = nominal_run(robot, &format!("slow_{k}"), pieces, &fine);
        measure(robot, &planned, Pose::new(0.0, 0.0, 0.1), &truth, &TRACKER, &mut random)
    });
    Campaign { robot: *robot, runs: runs.collect() }
}

#[test]
fn an_eccentric_encoder_behind_a_gear_is_named_and_its_ripple_is_that_of_the_encoders_turn() {
    let robot = Robot { gear_reduction: GEAR, rad_per_count: ROBOT.rad_per_count / GEAR, ..ROBOT };
    let values = [0.04, 0.02, -0.03, 0.035];
    let campaign = slow_runs(&robot, &values);
    let answer = explain(&campaign).unwrap();
    let step = answer.steps.first().expect("the effect is found");
    assert_eq!(step.class, ["encoder_eccentricity"]);
    for (found, truth) in step.parameters.iter().zip(values) {
        // Four sigma: one in 16,000, for each of four; and the ripple is seen.
        assert!((found.value - truth).abs() < 4.0 * found.sigma, "{found:?}, {truth}");
        assert!(found.sigma < 0.2 * truth.abs(), "{found:?}");
    }

    // The same motion of a smaller wheel that turns with its encoder has the same answer.
    let mut direct = campaign.clone();
    direct.robot.gear_reduction = 1.0;
    direct.robot.wheel_radius_m /= GEAR;
    for sample in direct.runs.iter_mut().flat_map(|run| &mut run.wheels) {
        sample.phi_rad = sample.phi_rad.map(|phi_rad| phi_rad * GEAR);
    }
    let effect = find("encoder_eccentricity").unwrap();
    let sizes =
        |campaign: &Campaign| fit(campaign, &[effect]).unwrap().effects[0].parameters.clone();
    for (a, b) in sizes(&campaign).iter().zip(&sizes(&direct)) {
        // Rounding of the angles, and the fit's own last step, both far below a sigma.
        assert!((a.value - b.value).abs() < 1e-3 * a.sigma, "{a:?} {b:?}");
        assert!((a.sigma / b.sigma - 1.0).abs() < 1e-3, "{a:?} {b:?}");
    }
}
