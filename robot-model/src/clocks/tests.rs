//! Clocks that are made wrong are found, and clocks that agree are left alone.

use crate::clocks::{ClockFound, drift, prepare};
use crate::numeric::random::Random;
use crate::recording::campaign::Campaign;
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
