//! Does a calibration make robots drive straight, and does it know how well?

use beeline_tests::judge::{Eye, Verdict, judge_all, quartiles};

/// Drawn for the bench too, where there are 200.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=60;

fn verdicts(eye: Eye) -> Vec<Verdict> {
    let seeds: Vec<u64> = SEEDS.collect();
    let results = judge_all(&seeds, eye);
    let named = seeds.iter().zip(results);
    named.map(|(seed, v)| v.unwrap_or_else(|why| panic!("seed {seed}: {why}"))).collect()
}

#[test]
fn with_the_camera_the_lateral_error_falls_twentyfold_in_the_median() {
    let verdicts = verdicts(Eye::Camera);
    let factors: Vec<f64> = verdicts.iter().map(Verdict::factor).collect();
    let [_, median, _] = quartiles(&factors);
    println!("median factor {median:.1}");
    // Too good fails too: a millimetre of camera noise leaves half a millimetre of some 30 mm.
    assert!((20.0..400.0).contains(&median), "{median}");
    let errors: Vec<f64> = verdicts.iter().map(Verdict::error_sigmas).collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    // The printed sigma is the error's: 1 within 4 standard deviations of an rms of 60, 0.09 each.
    assert!((0.64..1.36).contains(&rms), "errors of {rms} sigma");
}

#[test]
fn with_the_ruler_the_95_percent_interval_covers_the_truth_as_often_as_it_says() {
    let verdicts = verdicts(Eye::Ruler);
    let covered = verdicts.iter().filter(|v| v.covered).count();
    println!("covered {covered} of {}", verdicts.len());
    // 90 to 98 % of 60, and the binomial spread of 60 draws at 95 %: 1.7, two of them either way
    // below, all of them above (with p = 0.95, 60 of 60 has a chance of 5 %).
    assert!((51..=60).contains(&covered), "{covered}");
}
