//! Does a calibration make robots drive straight, and is its uncertainty right?

use beeline_tests::calibration::{
    CalibrationOutcome, Instrument, quartiles, verdict_on_scenario, verdicts_on,
};
use beeline_tests::robot::on_robot;
use host_cli::calibrate::{CalibrateStep, Settings, calibrate};
use host_cli::pose_source::camera::Camera;
use host_link::address::BAUD_MIN;
use sim_target::Scenario;

/// The first 60 of the 200 robots of the benchmark.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=60;

fn verdicts(instrument: Instrument) -> Vec<CalibrationOutcome> {
    let seeds: Vec<u64> = SEEDS.collect();
    let results = verdicts_on(&seeds, instrument);
    let named = seeds.iter().zip(results);
    named.map(|(seed, v)| v.unwrap_or_else(|why| panic!("seed {seed}: {why}"))).collect()
}

#[test]
fn with_the_camera_the_lateral_error_falls_twentyfold_in_the_median() {
    let verdicts = verdicts(Instrument::Camera);
    let factors: Vec<f64> = verdicts.iter().map(CalibrationOutcome::factor).collect();
    let [_, median, _] = quartiles(&factors);
    println!("median factor {median:.1}");
    // Too good fails too: a millimetre of camera noise leaves half a millimetre of some 30 mm.
    assert!((20.0..400.0).contains(&median), "{median}");
    the_printed_sigma_is_the_errors(&verdicts);
}

/// An rms of 1, within 4 standard deviations of that of 60 draws, 0.09 each.
fn the_printed_sigma_is_the_errors(verdicts: &[CalibrationOutcome]) {
    let errors: Vec<f64> = verdicts.iter().map(CalibrationOutcome::error_sigmas).collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    println!("errors of {rms:.2} sigma");
    assert!((0.64..1.36).contains(&rms), "errors of {rms} sigma");
}

#[test]
fn with_the_ruler_the_95_percent_interval_covers_the_truth_as_often_as_it_says() {
    let verdicts = verdicts(Instrument::Ruler);
    let covered = verdicts.iter().filter(|v| v.covered).count();
    println!("covered {covered} of {}", verdicts.len());
    // 90 to 98 % of 60, and the binomial spread of 60 draws at 95 %: 1.7, two of them either way
    // below. 60 of 60 has a chance of 5 % at 95 %, so that too wide is found by the rms.
    assert!(covered >= 51, "{covered}");
    the_printed_sigma_is_the_errors(&verdicts);
}

#[test]
fn the_slowest_line_that_is_accepted_carries_a_calibration() {
    for seed in 1..=4 {
        let mut scenario = Scenario::draw(seed);
        scenario.link.baud = BAUD_MIN;
        let verdict = verdict_on_scenario(&scenario, Instrument::Camera);
        let verdict = verdict.unwrap_or_else(|why| panic!("seed {seed}: {why}"));
        assert_eq!(verdict.decision, "corrected", "seed {seed}");
    }
}

#[test]
fn a_robot_that_cannot_save_keeps_its_wheel_weight_and_the_host_remembers_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let settings =
        Settings { undo_folder: Some(folder.path().join("state")), ..Settings::default() };
    on_robot(&Scenario::draw(1), async |robot| {
        let testbed = robot.testbed.clone();
        let mut instrument = Camera::new(testbed.clone());
        let mut tell = |step: CalibrateStep<'_>| {
            if let CalibrateStep::Written(_) = step {
                testbed.write_protect_flash(true);
            }
        };
        let before = robot.session.read_config().await.unwrap();
        let outcome = calibrate(&mut robot.session, &mut instrument, &settings, &mut tell).await;
        let error = outcome.unwrap_err().to_string();
        assert!(error.contains("flash could not be written"), "{error}");
        assert_eq!(robot.session.read_config().await.unwrap(), before);
    });
    let remembered = std::fs::read_dir(folder.path().join("state")).unwrap().count();
    assert_eq!(remembered, 0, "a calibration that did not happen");
}
