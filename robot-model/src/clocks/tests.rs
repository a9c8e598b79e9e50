//! Clocks that are made wrong are found, and clocks that agree are left alone.

use crate::clocks::common_rate::CommonRate;
use crate::clocks::line::{Line, line};
use crate::clocks::{ClockFound, drift, prepare};
use crate::estimation::fit::fit_afresh;
use crate::numeric::random::Random;
use crate::recording::campaign::Campaign;
use crate::recording::nominal_run::Piece;
use crate::recording::run::PoseMeasurement;
use crate::tests::synthetic::{campaign, full_plan, term};

fn found(campaign: &Campaign) -> Vec<ClockFound> {
    prepare(campaign).unwrap().1
}

#[test]
fn a_constant_offset_is_found_from_a_third_of_a_second_to_half_a_minute() {
    let offsets_s = [0.5, -0.5, 3.72, -8.0, 25.0, -1.335, 0.762, 2.26];
    for (seed, late_s) in (1..).zip(offsets_s) {
        let mut runs = campaign(&full_plan(), &[], seed);
        for pose in runs.runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
            pose.t_s += late_s;
        }
        let clocks = found(&runs);
        assert_eq!(clocks.len(), runs.runs.len(), "{late_s} s: {clocks:?}");
        for clock in &clocks {
            // Also of a run that alone would hardly tell.
            assert!((clock.offset_s - late_s).abs() < 0.01, "{late_s} s: {clock:?}");
        }
    }
}

#[test]
fn clocks_that_drift_from_run_to_run_are_told_by_how_much_and_others_are_not() {
    let runs = campaign(&full_plan(), &[term("measurement_delay", &[0.08])], 31);
    assert_eq!(drift(&runs).unwrap(), None);
    for rate in [1e-5, -3e-4, 2e-3] {
        let mut drifting = runs.clone();
        for run in &mut drifting.runs {
            let started_s = run.started_s.expect("the plan says when");
            run.measured_poses
                .iter_mut()
                .for_each(|pose| pose.t_s += rate * (started_s + pose.t_s));
        }
        // One run has an offset of its own, which is no drift.
        drifting.runs[1].measured_poses.iter_mut().for_each(|pose| pose.t_s += 0.2);
        let found = drift(&drifting).unwrap().expect("it shows");
        let off = (found.rate - rate).abs();
        assert!(off < (4.0 * found.sigma).max(0.01 * rate.abs()), "{rate}: {found:?}");
        assert!(found.sigma < 4e-6, "{rate}: {found:?}");
    }
}

/// Drives of half a minute with turns of both signs and speeds that change, as by hand.
fn free_drives(runs: usize, random: &mut Random) -> Vec<(String, f64, Vec<Piece>)> {
    let mut drive = || {
        let (mut pieces, mut left_s) = (Vec::new(), 28.0);
        while left_s > 0.0 {
            let (kind, speed_mps) = (random.uniform(), 0.1 + 0.25 * random.uniform());
            let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
            let duration_s = 1.0 + 2.0 * random.uniform();
            left_s -= duration_s + 0.7;
            let travel_m = speed_mps * duration_s;
            pieces.push(match kind {
                kind if kind < 0.2 => Piece::Spin { turn_rad: sign * travel_m / 0.15, speed_mps },
                kind if kind < 0.4 => Piece::Straight { travel_m: sign * travel_m, speed_mps },
                kind => {
                    let radius_m = 0.2 + kind;
                    Piece::Arc { radius_m, turn_rad: sign * travel_m / radius_m, speed_mps }
                }
            });
        }
        pieces
    };
    (0..runs).map(|k| (format!("free_{k}"), k as f64, drive())).collect()
}

/// These drives before a camera with a noise of millimetres that nobody gave.
fn before_a_camera(runs: usize, seed: u64) -> Campaign {
    let mut random = Random::new(seed);
    let mut campaign = campaign(&free_drives(runs, &mut random), &[], seed);
    for pose in campaign.runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
        pose.position_m.iter_mut().flatten().for_each(|x_m| *x_m += 4.3e-3 * random.normal());
        pose.heading_rad = pose.heading_rad.map(|turn_rad| turn_rad + 8e-3 * random.normal());
    }
    campaign
}

#[test]
fn a_rate_that_all_runs_share_is_found_where_each_alone_is_too_short() {
    for (seed, (rate, late_s)) in
        (70..).zip([(-0.02, 0.0), (-0.005, 0.1), (0.003, 0.0), (0.01, 0.3), (0.02, 4.0)])
    {
        let mut runs = before_a_camera(8, seed);
        let sound = found(&runs);
        assert!(sound.is_empty(), "{sound:?}");
        for pose in runs.runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
            pose.t_s += rate * pose.t_s + late_s;
        }
        let (prepared, clocks) = prepare(&runs).unwrap();
        assert_eq!(clocks.len(), runs.runs.len(), "{rate}: {clocks:?}");
        for clock in &clocks {
            let off = (clock.rate - rate).abs();
            assert!(off < (4.0 * clock.rate_sigma).max(0.01 * rate.abs()), "{rate}: {clock:?}");
            assert!(clock.rate_sigma < 3e-4, "{rate}: {clock:?}");
        }
        // What is left is at most an offset that all runs share.
        let ends_s = |poses: &[PoseMeasurement]| [poses[0].t_s, poses[poses.len() - 1].t_s];
        let sound = before_a_camera(8, seed);
        let left_s: Vec<f64> = prepared
            .runs
            .iter()
            .zip(&sound.runs)
            .flat_map(|(a, b)| {
                let (a, b) = (ends_s(&a.recording.measured_poses), ends_s(&b.measured_poses));
                [a[0] - b[0], a[1] - b[1]]
            })
            .collect();
        let least_s = left_s.iter().copied().fold(f64::INFINITY, f64::min);
        let most_s = left_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!(most_s - least_s < 0.02, "{rate}: {left_s:?}");
        assert!(most_s < 0.25, "{rate}: {left_s:?}");
    }
}

/// Each run was brought to the clock of the wheels at its beginning and at its end, with an error of tens of milliseconds: in
/// runs of seconds that is a percent, and turns look slower in motion than they were from rest to rest.
#[test]
fn clocks_that_were_synchronised_at_both_ends_of_short_runs_bend_neither_track_width_nor_radius() {
    const TRUE: [f64; 2] = [0.01, -0.004];
    let rest = Piece::Rest { duration_s: 0.3 };
    let plan: Vec<(String, f64, Vec<Piece>)> = (0..14_u8)
        .map(|k| {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let piece = match k % 3 {
                0 => Piece::Straight { travel_m: 0.8, speed_mps: 0.25 },
                _ => Piece::Spin { turn_rad: 3.1 * sign, speed_mps: 0.15 },
            };
            (format!("run_{k}"), f64::from(k), vec![piece, rest])
        })
        .collect();
    let truth = [term("track_width", &[TRUE[0]]), term("wheel_radius_scale", &[TRUE[1]])];
    for seed in 1..=6 {
        let mut runs = campaign(&plan, &truth, seed);
        let mut random = Random::new(90 + seed);
        for run in &mut runs.runs {
            let (first_s, last_s) =
                (run.measured_poses[0].t_s, run.measured_poses[run.measured_poses.len() - 1].t_s);
            // In most runs the tracker lags more at the end than at the beginning.
            let (begin_s, end_s) = (0.015 * random.normal(), 0.025 + 0.015 * random.normal());
            for pose in &mut run.measured_poses {
                let share = (pose.t_s - first_s) / (last_s - first_s);
                // At rest times do not matter: the last poses are where they were.
                pose.t_s += begin_s + (end_s - begin_s) * share;
            }
        }
        let (prepared, _) = prepare(&runs).unwrap();
        let ids = ["track_width", "wheel_radius_scale"];
        let fitted = fit_afresh(&prepared, ids.map(|id| term(id, &[0.0])).into());
        for (i, (term, truth)) in fitted.terms.iter().zip(TRUE).enumerate() {
            let (off, sigma) = (term.values[0] - truth, fitted.covariance[(i, i)].sqrt());
            println!("{seed} {}: off by {off:.5}, sigma {sigma:.5}", ids[i]);
            assert!(off.abs() < (3.5 * sigma).max(5e-4) && sigma < 2e-3, "{}", ids[i]);
        }
    }
}

#[test]
fn a_run_that_is_late_is_told_apart_from_the_others() {
    let mut runs = campaign(&full_plan(), &[], 6);
    runs.runs[3].measured_poses.iter_mut().for_each(|pose| pose.t_s += 0.29);
    let clocks = found(&runs);
    let name = runs.runs[3].name.clone();
    let late = clocks.iter().find(|clock| clock.run == name).expect("the late run is found");
    assert!((late.offset_s - 0.29).abs() < 0.01, "{late:?}");
    let others = clocks.iter().filter(|clock| clock.run != name);
    assert!(others.clone().all(|clock| clock.offset_s.abs() < 0.015), "{clocks:?}");
}

#[test]
fn clocks_that_agree_are_left_alone_by_trackers_of_centimetres_whose_noise_nobody_gave() {
    for (seed, (position_sigma_m, heading_sigma_rad)) in
        (50..).zip([(0.01, 0.02), (0.03, 0.05), (0.06, 0.07), (0.1, 0.1)])
    {
        let mut runs = campaign(&full_plan(), &[], seed);
        let mut random = Random::new(seed);
        for pose in runs.runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
            for coordinate in pose.position_m.iter_mut().flatten() {
                *coordinate += position_sigma_m * random.normal();
            }
            pose.heading_rad =
                pose.heading_rad.map(|turn| turn + heading_sigma_rad * random.normal());
        }
        let clocks = found(&runs);
        assert!(clocks.is_empty(), "{position_sigma_m} m: {clocks:?}");
        // One that is late by half a second is found all the same, and is no outlier among those that are not.
        runs.runs[16].measured_poses.iter_mut().for_each(|pose| pose.t_s += 0.5);
        let clocks = found(&runs);
        let late = clocks.iter().find(|clock| clock.run == runs.runs[16].name);
        let late = late.unwrap_or_else(|| panic!("{position_sigma_m} m: {clocks:?}"));
        let off_s = (late.offset_s - 0.5).abs();
        assert!(off_s < 4.0 * late.offset_sigma_s, "{position_sigma_m} m: {late:?}");
    }
}

#[test]
fn clocks_that_agree_are_left_alone_whatever_effect_is_there() {
    let effects = [
        term("measurement_delay", &[0.08]),
        term("carpet_drift", &[0.015, 0.01]),
        term("slope", &[0.01, 0.02, 0.1]),
        term("traction_slip", &[0.05]),
        term("side_slip", &[0.04]),
        term("caster_kick", &[0.06, 0.05]),
        term("wheel_radius_scale", &[0.1]),
    ];
    for (k, effect) in effects.iter().enumerate() {
        let runs = campaign(&full_plan(), core::slice::from_ref(effect), 20 + k as u64);
        let clocks = found(&runs);
        assert!(clocks.is_empty(), "{effect:?}: {clocks:?}");
    }
}

#[test]
fn a_clock_that_jumps_by_years_or_more_costs_no_time_and_hides_no_other_runs_offset() {
    for jump_s in [1.7e9, 1e18] {
        let mut runs = campaign(&full_plan(), &[], 7);
        let jumps = &mut runs.runs[3];
        let mut sample = *jumps.wheels.last().expect("it drove");
        sample.t_s += jump_s;
        jumps.wheels.push(sample);
        let mut pose = *jumps.measured_poses.last().expect("it was seen");
        pose.t_s += jump_s;
        jumps.measured_poses.push(pose);
        let jumping = jumps.name.clone();
        runs.runs[16].measured_poses.iter_mut().for_each(|pose| pose.t_s += 0.29);
        let late = runs.runs[16].name.clone();
        // As many windows as the jump is long would not be looked at within a year.
        let clocks = found(&runs);
        let offset_s = |name: &str| {
            clocks.iter().find(|clock| clock.run == name).map_or(0.0, |clock| clock.offset_s)
        };
        assert!((offset_s(&late) - 0.29).abs() < 0.015, "{jump_s} s: {clocks:?}");
        for run in runs.runs.iter().filter(|run| run.name != late && run.name != jumping) {
            assert!(offset_s(&run.name).abs() < 0.02, "{jump_s} s: {clocks:?}");
        }
    }
}

#[test]
fn runs_of_which_one_has_clearly_another_rate_have_none_in_common() {
    let is_told = |rates: [f64; 6]| {
        let jitter_s = |k: i32| if k % 2 == 0 { 1e-4 } else { -1e-4 };
        let points = rates.map(|rate| -> Vec<[f64; 3]> {
            let point = |k| [12.0 * f64::from(k), rate * 12.0 * f64::from(k) + jitter_s(k), 1e6];
            (0..8).map(point).collect()
        });
        let lines: Vec<Option<Line>> = points.iter().map(|points| line(points)).collect();
        CommonRate::of(&points, 1.0).is_some_and(|common| common.is_told_by_all(&lines))
    };
    assert!(is_told([1e-3; 6]));
    assert!(!is_told([1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1.5e-3]));
    assert!(!is_told([0.0; 6]));
}
