use core::f64::consts::{FRAC_PI_2, PI, TAU};
use std::collections::BTreeSet;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use shared_proto::WheelPair;

use super::{HiddenEffect, ShownBy};
use crate::Scenario;
use crate::instruments::{CameraSample, GyroSample};

/// A robot with nothing wrong but the standard plant's own tyres and caster, and no noise.
fn sound() -> Scenario {
    let mut scenario = Scenario::parse("sound", "name = 'sound'").expect("valid");
    scenario.placement.heading_sigma_rad = 0.0;
    scenario.camera.position_sigma_m = 0.0;
    scenario.camera.heading_sigma_rad = 0.0;
    scenario.plant.caster.start_angle_rad = 0.05;
    scenario.gyro =
        Some(crate::instruments::GyroParameters { sigma_rad_s: 0.0, ..Default::default() });
    scenario
}

fn hide(effect: HiddenEffect, strength: f64) -> Scenario {
    let mut scenario = sound();
    effect.apply(&mut scenario, strength, &mut ChaCha8Rng::seed_from_u64(11));
    scenario
}

/// What the instruments see of a motion.
#[derive(Clone, Debug, PartialEq)]
struct Sight {
    camera: Vec<CameraSample>,
    gyro: Vec<GyroSample>,
}

/// Rim travel of each leg \[m\], at 0.3 m/s and 0.3 m/s^2.
fn legs(motion: ShownBy) -> Vec<(f64, f64)> {
    let half_m = 0.186;
    let turn = |rad: f64| (-half_m * rad, half_m * rad);
    match motion {
        ShownBy::OutAndBack => vec![(1.2, 1.2), (-1.2, -1.2)],
        ShownBy::Spin => vec![turn(TAU), turn(-TAU)],
        ShownBy::Arc => {
            let radius_m = 0.5;
            vec![((radius_m - half_m) * PI, (radius_m + half_m) * PI)]
        }
        ShownBy::Square => (0..4).flat_map(|_| [(0.6, 0.6), turn(FRAC_PI_2)]).collect(),
    }
}

/// Drives by the encoders' counts alone, as a robot does: a trapezoid with feedforward and feedback.
fn watch(scenario: &Scenario, motion: ShownBy, payload_kg: f64) -> Sight {
    let setup = scenario.set_up();
    let (mut plant, mut camera) = (setup.plant, setup.camera);
    let mut gyro = setup.gyro.expect("there is one");
    if payload_kg > 0.0 {
        plant.set_payload(payload_kg);
    }
    let mut sight = Sight { camera: Vec::new(), gyro: Vec::new() };
    let (cruise_mps, a_mps2, radius_m) = (0.3_f64, 0.3, 0.036);
    let mut begin = WheelPair::both(0.0);
    let mut t_us = 0;
    plant.set_enabled(true);
    for (left_m, right_m) in legs(motion) {
        let longest_m = left_m.abs().max(right_m.abs());
        let peak_mps = cruise_mps.min((a_mps2 * longest_m).sqrt());
        let (ramp_s, end_s) = (peak_mps / a_mps2, longest_m / peak_mps + peak_mps / a_mps2);
        let share = WheelPair::new(left_m / longest_m, right_m / longest_m);
        for ms in 0..((end_s + 0.4) * 1000.0) as u64 {
            let t_s = ms as f64 * 1e-3;
            let (way_m, speed_mps, a) = if t_s < ramp_s {
                (0.5 * a_mps2 * t_s * t_s, a_mps2 * t_s, a_mps2)
            } else if t_s < end_s - ramp_s {
                (peak_mps * (t_s - 0.5 * ramp_s), peak_mps, 0.0)
            } else if t_s < end_s {
                let left_s = end_s - t_s;
                (longest_m - 0.5 * a_mps2 * left_s * left_s, a_mps2 * left_s, -a_mps2)
            } else {
                (longest_m, 0.0, 0.0)
            };
            let counted = plant.counts().map(|counts| counts as f64 * TAU / 900.0);
            let angle = counted.zip(begin).map(|(now, begin)| now - begin);
            let duty = angle.zip(share).map(|(angle_rad, share)| {
                let friction = if speed_mps > 0.0 { 0.04 } else { 0.0 };
                let feedforward = friction * share.signum()
                    + share * (0.0712 * speed_mps + 0.0023 * a) / radius_m;
                let hold = if t_s < end_s + 0.2 { 1.5 } else { 0.0 };
                feedforward + hold * (share * way_m / radius_m - angle_rad)
            });
            plant.set_duty(duty);
            t_us += 1000;
            plant.advance_to(t_us);
            if camera.next_t_us() <= t_us {
                sight.camera.push(camera.expose(t_us, plant.pose()));
            }
            sight.gyro.extend(gyro.observe(&plant));
        }
        let way = share.map(|share| share * longest_m / radius_m);
        begin = begin.zip(way).map(|(begin, way)| begin + way);
    }
    sight
}

/// How far two sights are apart at most: \[m\], \[rad\], \[rad/s\].
fn apart(seen: &Sight, plain: &Sight) -> (f64, f64, f64) {
    let mut apart = (0.0_f64, 0.0_f64, 0.0_f64);
    for sample in &seen.camera {
        let next = plain.camera.partition_point(|other| other.t_s < sample.t_s);
        let Some(b) = plain.camera.get(next) else { continue };
        let a = plain.camera[next.saturating_sub(1)];
        let share = if b.t_s > a.t_s { (sample.t_s - a.t_s) / (b.t_s - a.t_s) } else { 0.0 };
        let at = |from: f64, to: f64| from + share * (to - from);
        let (dx, dy) = (sample.x_m - at(a.x_m, b.x_m), sample.y_m - at(a.y_m, b.y_m));
        apart.0 = apart.0.max(dx.hypot(dy));
        apart.1 = apart.1.max((sample.heading_rad - at(a.heading_rad, b.heading_rad)).abs());
    }
    for (a, b) in seen.gyro.iter().zip(&plain.gyro) {
        apart.2 = apart.2.max((a.yaw_rate_rad_s - b.yaw_rate_rad_s).abs());
    }
    apart
}

#[test]
fn every_hidden_effect_at_typical_strength_is_seen_in_the_run_that_shows_it() {
    let later = |scenario: &Scenario| {
        let mut later = scenario.clone();
        later.plant.warming.age_s = 3600.0;
        later
    };
    let mut misses = Vec::new();
    for &effect in HiddenEffect::ALL {
        let (hidden, motion) = (hide(effect, 1.0), effect.shown_by());
        assert_eq!(hidden.validate(), Ok(()), "{effect}");
        let payload_kg = if effect == HiddenEffect::Payload { 5.0 } else { 0.0 };
        let seen = watch(&later(&hidden), motion, payload_kg);
        let plain = watch(&later(&sound()), motion, 0.0);
        let (m, rad, rad_s) = apart(&seen, &plain);
        println!(
            "{effect:<22} {motion:<12} {:6.2} mm {:6.2} mrad {:6.1} mrad/s",
            m * 1e3,
            rad * 1e3,
            rad_s * 1e3,
            motion = format!("{motion:?}")
        );
        let is_gyro = matches!(effect, HiddenEffect::GyroBias | HiddenEffect::GyroScale);
        // The camera's noise in one picture is 1 mm and 2 mrad, the gyro's in one reading 2 mrad/s.
        let is_seen = if is_gyro { rad_s > 0.004 } else { m > 0.001 || rad > 0.002 };
        if !is_seen {
            misses.push(effect.id());
        }
    }
    assert!(misses.is_empty(), "not seen: {misses:?}");
}

#[test]
fn a_hidden_effect_of_no_strength_changes_no_bit() {
    let motions = [ShownBy::OutAndBack, ShownBy::Spin, ShownBy::Arc, ShownBy::Square];
    let plain = motions.map(|motion| watch(&sound(), motion, 0.0));
    for &effect in HiddenEffect::ALL {
        let i =
            motions.iter().position(|&motion| motion == effect.shown_by()).expect("one of them");
        assert_eq!(watch(&hide(effect, 0.0), motions[i], 0.0), plain[i], "{effect}");
    }
}

#[test]
fn what_is_drawn_stays_valid_and_the_same_seed_draws_the_same() {
    for &effect in HiddenEffect::ALL {
        for seed in 0..20 {
            for strength in [0.1, 1.0, 3.0] {
                let draw = || {
                    let mut scenario = Scenario::draw(seed);
                    let mut rng = ChaCha8Rng::seed_from_u64(seed);
                    effect.apply(&mut scenario, strength, &mut rng);
                    scenario
                };
                let scenario = draw();
                assert_eq!(scenario.validate(), Ok(()), "{effect} at {strength}, seed {seed}");
                assert_eq!(scenario, draw());
                let text = scenario.to_toml();
                assert_eq!(Scenario::parse("hidden", &text).as_ref(), Ok(&scenario), "{text}");
            }
        }
    }
}

#[test]
fn ids_are_unique_and_name_their_effects() {
    let ids: BTreeSet<_> = HiddenEffect::ALL.iter().map(|effect| effect.id()).collect();
    assert_eq!(ids.len(), HiddenEffect::ALL.len());
    let outside = HiddenEffect::ALL.iter().filter(|effect| !effect.is_in_catalogue()).count();
    assert_eq!(HiddenEffect::ALL.len() - outside, 23, "as many as the catalogue lists");
    assert!(outside >= 10, "{outside}");
    for &effect in HiddenEffect::ALL {
        assert_eq!(effect.id().parse(), Ok(effect));
    }
    let error = "gremlins".parse::<HiddenEffect>().expect_err("there are none");
    assert!(error.starts_with("no hidden effect `gremlins`; there are wheel_radius_ratio, "));
}

/// A robot whose tyres hardly slip, as those of the blind benchmark.
fn gripping() -> Scenario {
    let mut scenario = sound();
    let plant = &mut scenario.plant;
    plant.substep_us = 200;
    plant.tyre.longitudinal_stiffness_n_per_m *= 6.0;
    plant.tyre.lateral_stiffness_n_per_m *= 6.0;
    plant.tyre.relaxation_length_m *= 4.0;
    plant.caster.start_angle_rad = 0.0;
    scenario
}

/// Mean heading in the pictures between two times \[rad\].
fn heading_rad(sight: &Sight, from_s: f64, to_s: f64) -> f64 {
    let seen: Vec<f64> = sight
        .camera
        .iter()
        .filter(|sample| (from_s..to_s).contains(&sample.t_s))
        .map(|sample| sample.heading_rad)
        .collect();
    seen.iter().sum::<f64>() / seen.len() as f64
}

#[test]
fn a_caster_kick_turns_even_a_robot_that_grips_in_the_first_half_of_its_way_back_and_no_more() {
    let back = |strength: f64| {
        let mut scenario = gripping();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        HiddenEffect::CasterKick.apply(&mut scenario, strength, &mut rng);
        assert_eq!(scenario.validate(), Ok(()));
        let sight = watch(&scenario, ShownBy::OutAndBack, 0.0);
        // 5.4 s a leg: the last second and a half out, the middle and the end of the way back.
        let out_rad = heading_rad(&sight, 3.0, 4.4);
        (heading_rad(&sight, 8.0, 8.8) - out_rad, heading_rad(&sight, 9.0, 9.8) - out_rad)
    };
    let (plain, half, whole, more) = (back(0.0), back(0.5), back(1.0), back(3.0));
    println!("{plain:?} {half:?} {whole:?} {more:?}");
    let kick = |seen: (f64, f64)| seen.1 - plain.1;
    // One picture's noise is 2 mrad, and there are hundreds behind each reversal.
    assert!((1e-3..4e-3).contains(&-kick(whole)), "{} rad", kick(whole));
    assert!(
        kick(whole) < 1.5 * kick(half) && kick(half) < 0.0,
        "{} of {}",
        kick(half),
        kick(whole)
    );
    assert!(kick(more) < kick(whole), "{} beyond {}", kick(more), kick(whole));
    let later = (whole.1 - whole.0) - (plain.1 - plain.0);
    assert!(later.abs() < 0.3 * kick(whole).abs(), "{later} of {} rad", kick(whole));
}

#[test]
fn late_tyres_show_even_on_a_robot_that_grips_the_more_the_stronger() {
    let far = |strength: f64| {
        let mut scenario = gripping();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        HiddenEffect::RelaxationLength.apply(&mut scenario, strength, &mut rng);
        assert_eq!(scenario.validate(), Ok(()));
        let tyre = scenario.plant.tyre;
        let slip_stiffness_n = tyre.longitudinal_stiffness_n_per_m * tyre.relaxation_length_m;
        (watch(&scenario, ShownBy::OutAndBack, 0.0), slip_stiffness_n)
    };
    let (plain, _) = far(0.0);
    let (half, whole, more) = (far(0.5), far(1.0), far(2.0));
    let [half_m, whole_m, more_m] = [&half, &whole, &more].map(|run| apart(&run.0, &plain).0);
    println!("{half_m} {whole_m} {more_m} m; {} N", whole.1);
    // Half of 1.2 N on 500 N/m gives by 1.2 mm; between two pictures there are some tenths more.
    assert!((0.8e-3..4e-3).contains(&whole_m), "{whole_m} m");
    assert!(half_m < whole_m && whole_m < more_m, "{half_m}, {whole_m}, {more_m}");
    // It is late rather than soft: the slip m/(2 k sigma) stays below 0.7 % per m/s^2.
    assert!(whole.1 > 300.0, "{} N", whole.1);
}

/// How far ahead of the point about which a robot spins to the left the middle of its axle lies, and how far to the left
/// \[m\], from the middle of a spin on.
fn off_the_turning_point_m(effect: HiddenEffect, strength: f64) -> [f64; 2] {
    let mut scenario = gripping();
    // As in the blind benchmark.
    scenario.plant.tyre.rolling_resistance *= 0.25;
    scenario.plant.caster.rolling_resistance *= 0.25;
    effect.apply(&mut scenario, strength, &mut ChaCha8Rng::seed_from_u64(1));
    assert_eq!(scenario.validate(), Ok(()));
    let sight = watch(&scenario, ShownBy::Spin, 0.0);
    let turning =
        |sample: &&CameraSample| sample.t_s < 5.0 && (1.5..5.8).contains(&sample.heading_rad);
    let seen: Vec<&CameraSample> = sight.camera.iter().filter(turning).collect();
    let n = seen.len() as f64;
    let mean = |of: &dyn Fn(&CameraSample) -> f64| seen.iter().map(|one| of(one)).sum::<f64>() / n;
    let (x_m, y_m) = (mean(&|one| one.x_m), mean(&|one| one.y_m));
    let (cos, sin) = (mean(&|one| one.heading_rad.cos()), mean(&|one| one.heading_rad.sin()));
    // Places lie on a circle, p = c + l exp(i heading): least squares.
    let (mut ahead, mut left, mut square) = (0.0, 0.0, 0.0);
    for one in seen {
        let (dx_m, dy_m) = (one.x_m - x_m, one.y_m - y_m);
        let (c, s) = (one.heading_rad.cos() - cos, one.heading_rad.sin() - sin);
        ahead += dx_m * c + dy_m * s;
        left += dy_m * c - dx_m * s;
        square += c * c + s * s;
    }
    [ahead / square, left / square]
}

/// The blind benchmark counts a marker offset as there where one of these is hidden, and a track width beside scrub.
#[test]
fn what_yields_sideways_moves_the_point_about_which_a_robot_spins_and_scrub_narrows_the_track() {
    let ahead_m =
        |effect: HiddenEffect, strength: f64| off_the_turning_point_m(effect, strength)[0];
    let sound_m = ahead_m(HiddenEffect::SideSlip, 0.0);
    assert!(sound_m.abs() < 1e-5, "{sound_m} m");
    for effect in [HiddenEffect::SideSlip, HiddenEffect::TurnAsymmetry] {
        let moved_m = [0.5, 1.0, 2.0].map(|strength| ahead_m(effect, strength) - sound_m);
        println!("{effect}: {moved_m:?} m beside {sound_m}");
        // A tenth of the noise of one picture is what matters: 0.1 mm.
        assert!(moved_m[1].abs() > 1e-4, "{effect}: {moved_m:?} m");
        assert!(moved_m[2].abs() > 1e-4, "{effect}: {moved_m:?} m");
    }
    let narrow = hide(HiddenEffect::Scrub, 1.0).plant.geometry.track_width_m;
    assert!(narrow < 0.99 * sound().plant.geometry.track_width_m, "{narrow} m");
}
