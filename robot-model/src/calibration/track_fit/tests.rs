use core::f64::consts::TAU;

use super::*;
use crate::kinematics::{Geometry, Pose, WheelPair};
use crate::numeric::angle::wrap;
use crate::numeric::random::Random;

/// A synthetic robot and its camera.
#[derive(Clone, Copy)]
struct World {
    wheel_weight: f64,
    /// Random walk of the heading \[rad/sqrt(m)\].
    wander: f64,
    position_sigma_m: f64,
    heading_sigma_rad: f64,
    delay_s: f64,
    radius_scale: f64,
    with_heading: bool,
    backwards: bool,
}

const CAMERA: World = World {
    wheel_weight: 0.99,
    wander: 0.0,
    position_sigma_m: 0.001,
    heading_sigma_rad: 0.002,
    delay_s: 0.0,
    radius_scale: 1.0,
    with_heading: true,
    backwards: false,
};

/// Eight turns of the wheels at a smooth speed, with a little wobble and whole counts; a camera at 25 Hz in any
/// place.
fn drive(world: World, seed: u64) -> (Track, Vec<WheelAngles>) {
    let mut noise = Random::new(seed);
    let geometry = Geometry::PAPER;
    let radius_m = geometry.wheel_radius_m * world.radius_scale;
    let camera = Pose::new(0.3 * noise.normal(), 0.2 * noise.normal(), noise.normal());
    let phase = (noise.uniform(), noise.uniform());
    let direction = if world.backwards { -1.0 } else { 1.0 };
    let mut pose = Pose::ORIGIN;
    let mut before = WheelPair::default();
    let (mut samples, mut angles) = (Vec::new(), Vec::new());
    let steps = 2000_u32;
    for step in 0..=steps {
        let t_s = f64::from(step) * 0.01;
        let share = f64::from(step) / f64::from(steps);
        // Smoothly from 0 to 8 turns.
        let phi = direction * 8.0 * TAU * (share - (TAU * share).sin() / TAU);
        let wobble = 0.02 * (t_s * 3.0).sin() * share * (1.0 - share);
        let turns = WheelPair { left: phi + wobble, right: phi - wobble };
        let by = turns.since(before);
        before = turns;
        let (left_m, right_m) = (radius_m * by.left, radius_m * world.wheel_weight * by.right);
        pose = pose.advance(left_m, right_m, geometry.track_width_m);
        pose.heading_rad += world.wander * ((left_m + right_m).abs() / 2.0).sqrt() * noise.normal();

        // Each wheel begins somewhere within a count.
        let whole = |rad: f64, phase: f64| {
            (rad / geometry.rad_per_count() + phase).floor() * geometry.rad_per_count()
        };
        let counted =
            WheelPair { left: whole(turns.left, phase.0), right: whole(turns.right, phase.1) };
        angles.push(WheelAngles { t_s, turns: counted });
        if step % 4 == 0 {
            let seen = camera.compose(pose);
            let heading_rad = wrap(seen.heading_rad + world.heading_sigma_rad * noise.normal());
            samples.push(TrackSample {
                t_s: t_s + world.delay_s,
                x_m: seen.x_m + world.position_sigma_m * noise.normal(),
                y_m: seen.y_m + world.position_sigma_m * noise.normal(),
                heading_rad: world.with_heading.then_some(heading_rad),
            });
        }
    }
    let track = Track {
        samples,
        position_sigma_m: world.position_sigma_m,
        heading_sigma_rad: world.heading_sigma_rad,
    };
    (track, angles)
}

fn fit(world: World, seed: u64, options: FitOptions) -> TrackFit {
    let (track, angles) = drive(world, seed);
    fit_track(&track, &angles, &Geometry::PAPER, options).unwrap()
}

struct Campaign {
    /// Mean error in units of its own sigma.
    bias: f64,
    /// Share of the 95 % intervals that hold the truth.
    coverage: f64,
    /// Root mean square error.
    rms: f64,
    /// Root mean square of the sigmas.
    sigma: f64,
}

fn repeat(world: World, trials: u32) -> Campaign {
    let fits: Vec<_> =
        (0..trials).map(|seed| fit(world, u64::from(seed), FitOptions::default())).collect();
    let errors: Vec<_> =
        fits.iter().map(|fit| fit.wheel_weight.value - world.wheel_weight).collect();
    let n = f64::from(trials);
    let mean = errors.iter().sum::<f64>() / n;
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
    let sigma = (fits.iter().map(|fit| fit.wheel_weight.sigma.powi(2)).sum::<f64>() / n).sqrt();
    let held = fits
        .iter()
        .filter(|fit| {
            (fit.wheel_weight.low95..=fit.wheel_weight.high95).contains(&world.wheel_weight)
        })
        .count();
    let figures = Campaign { bias: mean / (rms / n.sqrt()), coverage: held as f64 / n, rms, sigma };
    println!(
        "wander {}: coverage {:.3}, rms error {:.2e}, sigma {:.2e}, bias {:.1}",
        world.wander, figures.coverage, figures.rms, figures.sigma, figures.bias
    );
    figures
}

#[test]
fn the_estimate_is_unbiased_and_covers_the_truth_when_the_robot_wanders() {
    // rad per root metre: hidden by the noise of the camera, just visible, and clearly visible.
    for wander in [0.0005, 0.001, 0.002, 0.01] {
        let found = repeat(World { wander, ..CAMERA }, 300);
        // 90 to 98 %, and half a percent for the chance of 300 trials (sigma 0.8 % at 98 %).
        assert!((0.90..=0.985).contains(&found.coverage), "{wander}: {}", found.coverage);
        // A mean of 300 lies within three of its sigmas in 99.7 % of all cases.
        assert!(found.bias.abs() < 3.0, "{wander}: {}", found.bias);
        assert!((0.9..1.6).contains(&(found.sigma / found.rms)), "{wander}");
    }
}

#[test]
fn without_wandering_the_white_sigma_is_right_and_the_reported_one_cautious() {
    let fits: Vec<_> = (0..400).map(|seed| fit(CAMERA, seed, FitOptions::default())).collect();
    let held = |sigma: &dyn Fn(&TrackFit) -> f64| {
        let held = fits
            .iter()
            .filter(|fit| (fit.wheel_weight.value - 0.99).abs() <= 1.96 * sigma(fit))
            .count();
        held as f64 / 400.0
    };
    let white = held(&|fit| fit.white_sigma);
    assert!((0.90..=0.98).contains(&white), "{white}");
    assert!(held(&|fit| fit.wheel_weight.sigma) >= 0.95);
    // Not knowing that it does not wander costs a factor between two and five on average.
    let price =
        fits.iter().map(|fit| fit.wheel_weight.sigma / fit.white_sigma).sum::<f64>() / 400.0;
    assert!((2.0..5.0).contains(&price), "{price}");
}

#[test]
fn a_track_without_headings_is_enough() {
    let found = repeat(World { with_heading: false, wander: 0.002, ..CAMERA }, 200);
    assert!((0.90..=0.985).contains(&found.coverage), "{}", found.coverage);
    // Positions only, 500 of them on 1.8 m with 1 mm each, and wandering of 2.7 mrad.
    assert!(found.rms < 1.5e-3, "{}", found.rms);
}

#[test]
fn the_same_robot_is_found_driving_backwards() {
    let found = fit(World { backwards: true, ..CAMERA }, 1, FitOptions::default());
    let weight = found.wheel_weight;
    assert!((weight.value - 0.99).abs() < 4.0 * weight.sigma, "{weight:?}");
    assert!(weight.alpha_rad < 0.0, "backwards it turns the other way: {weight:?}");
}

#[test]
fn the_start_pose_is_no_evidence() {
    let world = CAMERA;
    let (mut track, angles) = drive(world, 7);
    let here = fit_track(&track, &angles, &Geometry::PAPER, FitOptions::default()).unwrap();
    for sample in &mut track.samples {
        let moved = Pose::new(-3.0, 8.0, 2.0).compose(Pose::new(
            sample.x_m,
            sample.y_m,
            sample.heading_rad.unwrap(),
        ));
        (sample.x_m, sample.y_m) = (moved.x_m, moved.y_m);
        sample.heading_rad = Some(wrap(moved.heading_rad));
    }
    let there = fit_track(&track, &angles, &Geometry::PAPER, FitOptions::default()).unwrap();
    let difference = (here.wheel_weight.value - there.wheel_weight.value).abs();
    // Gauss-Newton stops within a hundredth of a sigma.
    assert!(difference < 0.02 * here.wheel_weight.sigma, "{difference}");
    assert!((here.end.y_m - there.end.y_m).abs() < 2e-5);
}

#[test]
fn delay_and_scale_are_found() {
    let world = World { delay_s: 0.08, radius_scale: 1.01, ..CAMERA };
    let found = fit(world, 11, FitOptions { delay: true });
    let (delay, scale) = (found.delay_s.unwrap(), found.scale);
    assert!((delay.value - 0.08).abs() < 4.0 * delay.sigma && delay.sigma < 0.01, "{delay:?}");
    assert!((scale.value - 1.01).abs() < 4.0 * scale.sigma && scale.sigma < 0.001, "{scale:?}");
    let weight = found.wheel_weight;
    assert!((weight.value - 0.99).abs() < 4.0 * weight.sigma, "{weight:?}");
}

#[test]
fn the_end_is_where_the_robot_stood_within_its_sigma() {
    let held = (0..200)
        .filter(|&seed| {
            let (track, angles) = drive(World { wander: 0.003, ..CAMERA }, seed);
            let found =
                fit_track(&track, &angles, &Geometry::PAPER, FitOptions::default()).unwrap();
            // The same run seen by a camera without noise.
            let quiet =
                World { wander: 0.003, position_sigma_m: 1e-9, heading_sigma_rad: 1e-9, ..CAMERA };
            let truth = drive(quiet, seed).0.samples;
            let pose =
                |i: usize| Pose::new(truth[i].x_m, truth[i].y_m, truth[i].heading_rad.unwrap());
            let end = pose(truth.len() - 1).seen_from(pose(0));
            (found.end.y_m - end.y_m).abs() < 1.96 * found.end_offset_sigma_m
        })
        .count();
    // 95 % of 200 with a sigma of 3.
    assert!((178..=199).contains(&held), "{held} of 200");
}

#[test]
fn noise_that_is_not_stated_is_estimated() {
    let (track, _) = drive(CAMERA, 3);
    let estimated = Track::new(track.samples, None, None);
    // A median of 500 differences is good to 5 %.
    assert!((0.85e-3..1.15e-3).contains(&estimated.position_sigma_m), "{estimated:?}");
    assert!((1.7e-3..2.3e-3).contains(&estimated.heading_sigma_rad));
}

#[test]
fn understated_noise_does_not_make_the_estimate_surer() {
    let (mut track, angles) = drive(CAMERA, 5);
    let honest = fit_track(&track, &angles, &Geometry::PAPER, FitOptions::default()).unwrap();
    track.position_sigma_m /= 5.0;
    track.heading_sigma_rad /= 5.0;
    let boastful = fit_track(&track, &angles, &Geometry::PAPER, FitOptions::default()).unwrap();
    assert!(boastful.chi > 3.0, "{}", boastful.chi);
    assert!(boastful.wheel_weight.sigma > 0.7 * honest.wheel_weight.sigma);
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let (track, angles) = drive(CAMERA, 1);
    let try_fit = |track: &Track, angles: &[WheelAngles]| {
        fit_track(track, angles, &Geometry::PAPER, FitOptions::default()).unwrap_err()
    };
    let few = Track { samples: track.samples[..5].to_vec(), ..track.clone() };
    assert!(matches!(try_fit(&few, &angles), TrackFitError::TooFewSamples { found: 5, .. }));
    let still: Vec<_> =
        angles.iter().map(|angle| WheelAngles { turns: WheelPair::default(), ..*angle }).collect();
    assert_eq!(try_fit(&track, &still), TrackFitError::NoTravel);
    let mut back = track.clone();
    back.samples[7].t_s = 0.0;
    assert!(matches!(try_fit(&back, &angles), TrackFitError::TimeNotIncreasing { .. }));
    let mut bad = track.clone();
    bad.samples[7].x_m = f64::NAN;
    assert!(matches!(try_fit(&bad, &angles), TrackFitError::BadNumber { name: "x", .. }));
}
