use std::f64::consts::TAU;

use robot_model::calibration::track_fit::Estimate;
use robot_model::calibration::{CurvatureCause, Deviation, Experiment, OutAndBack};
use robot_model::kinematics::dead_reckon;
use robot_model::kinematics::{Geometry, Pose, WheelPair};

use super::*;

fn run(truth: f64, driven_with: f64) -> RunReport {
    let geometry =
        Geometry { track_width_sigma_m: 0.002, wheel_radius_sigma_m: 0.0002, ..Geometry::PAPER };
    let turns = WheelPair { left: 8.0 * TAU, right: 8.0 * TAU / driven_with };
    let steps = (0..=500).map(|i| WheelPair::default().toward(turns, f64::from(i) / 500.0));
    let path = dead_reckon(Pose::ORIGIN, &geometry, truth, steps);
    let end = path[path.len() - 1];
    // A fixed pattern in place of a camera's noise, so that the picture is always the same.
    let jitter = |i: usize| 0.001 * ((i * 7919 % 100) as f64 / 50.0 - 1.0);
    let points_m =
        path.iter().enumerate().map(|(i, pose)| (pose.x_m, pose.y_m + jitter(i))).collect();
    let deviation = Deviation::LateralOffset { y_m: end.y_m, sigma_m: 0.0005 };
    let experiment = Experiment { deviation, turns, geometry, start_heading_sigma_rad: 0.0005 };
    let weight = experiment.wheel_weight().unwrap();
    RunReport {
        driven_with,
        path,
        path_source: PathSource::Measured,
        points_m,
        end: EndReading {
            lateral_offset_m: end.y_m,
            lateral_offset_sigma_m: 0.0005,
            heading_rad: end.heading_rad,
            heading_sigma_rad: 0.0006,
        },
        wheel_weight: weight,
    }
}

fn report(name: &str) -> CalibrationReport {
    CalibrationReport {
        robot_name: name.into(),
        port: "sim".into(),
        geometry: Geometry::PAPER,
        profile: ProfileNumbers {
            acceleration_rev_per_s2: 0.101,
            cruise_rev_per_s: 0.523,
            distance_m: 1.8096,
            duration_s: 20.475,
        },
        before: run(0.9918, 1.0),
        after: run(0.9918, 0.992),
        out_and_back: Some(OutAndBack {
            wheel_weight: 0.9918,
            wheel_weight_sigma: 0.0003,
            radius_alpha_rad: 0.04,
            radius_alpha_sigma_rad: 0.001,
            pull_rad_per_m: 0.0002,
            pull_sigma_rad_per_m: 0.0005,
            back_alpha_rad: -0.04,
            verdict: CurvatureCause::Radius,
        }),
        wheel_weight: Estimate { value: 0.991_823, sigma: 0.0003 },
        basis: Basis::BothWays,
        drives: 3,
    }
}

#[test]
fn the_page_states_the_wheel_weight_that_was_written_and_how_often_the_robot_drove() {
    let both = report("Bee");
    let html = to_html(&both);
    assert!(html.contains("<b>Written: W<sub>T</sub> = 0.99182 \u{b1} 0.00030</b>"), "{html}");
    assert!(
        html.contains("from the part of the curvature that changes sign")
            && html.contains("Driven 3 times:")
    );
    let html = to_html(&CalibrationReport { basis: Basis::Mean(4), drives: 5, ..both.clone() });
    assert!(html.contains("from the mean of 4 runs") && html.contains("Driven 5 times:"));
    let html = to_html(&CalibrationReport { basis: Basis::OneRun, drives: 2, ..both });
    assert!(!html.contains("Written:") && html.contains("Driven twice:"));
}

#[test]
fn straighter_is_half_as_far_or_on_the_line_and_nothing_less() {
    let turned = |alpha_rad: f64| {
        let mut run = run(0.9918, 1.0);
        run.wheel_weight.alpha_rad = alpha_rad;
        run.wheel_weight.alpha_sigma_rad = 0.001;
        run
    };
    let straighter = |before, after| turned(after).is_straighter_than(&turned(before), 0.0);
    assert!(straighter(0.04, 0.019) && straighter(0.04, -0.019) && straighter(-0.04, 0.0));
    assert!(!straighter(0.04, 0.039) && !straighter(0.04, 0.021) && !straighter(0.04, -0.05));
    // Within 1.96 mrad of straight, and still no worse than before.
    assert!(straighter(0.003, 0.0019) && !straighter(0.003, 0.0021) && !straighter(0.001, 0.0015));
    // A pull of 0.02 is in both runs: what the radii cause went from 0.04 down to 0.001.
    assert!(turned(0.021).is_straighter_than(&turned(0.06), 0.02));
    assert!(!turned(0.021).is_straighter_than(&turned(0.04), 0.0));
}

#[test]
fn the_picture_needs_nothing_but_itself() {
    let html = to_html(&report("Bee"));
    for foreign in ["http", "<script", "src=", "@import", "url(", "<link"] {
        assert!(!html.contains(foreign), "{foreign}");
    }
    let svg = to_svg(&report("Bee"));
    assert_eq!(svg.matches("http").count(), 1, "the namespace alone");
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
}

#[test]
fn the_headline_states_both_offsets_and_a_factor_only_beyond_the_noise() {
    let mut report = report("Bee");
    // 0.9 mm remain, more than four times this.
    report.after.end.lateral_offset_sigma_m = 0.0002;
    let html = to_html(&report);
    assert!(html.contains("Drives straight"));
    for run in [&report.before, &report.after] {
        let mm = format!("{:.1} mm", run.end.lateral_offset_m.abs() * 1e3);
        assert!(html.contains(&mm), "{mm}");
    }
    let offset_mm = |run: &RunReport| run.end.lateral_offset_m.abs() * 1e3;
    let factor = offset_mm(&report.before) / offset_mm(&report.after);
    assert!(html.contains(&format!(">{factor:.0} times closer to the line")), "{factor}");
    assert!(html.contains("lateral axis in mm, stretched ×"));
    let mut noisy = report.clone();
    noisy.after.end.lateral_offset_sigma_m = 0.002;
    let html = to_html(&noisy);
    // Less than 1.96 times 2 mm.
    assert!(html.contains("on the line, as far as this measurement can tell (95 %: ± 3.9 mm)"));
    assert!(!html.contains("times closer"));
    let worse = CalibrationReport { after: report.before.clone(), ..report };
    let html = to_html(&worse);
    assert!(html.contains("Not straighter yet") && !html.contains("times closer"));
}

#[test]
fn a_robots_name_cannot_write_markup() {
    let name = "<script>alert('x')</script>&\"";
    for text in [to_html(&report(name)), to_svg(&report(name))] {
        assert!(!text.contains("<script") && text.contains("&lt;script&gt;"));
    }
}

#[test]
fn the_same_report_gives_the_same_bytes() {
    assert_eq!(to_html(&report("Bee")), to_html(&report("Bee")));
    assert_eq!(to_svg(&report("Bee")), to_svg(&report("Bee")));
}

#[test]
fn elements_are_closed_and_no_coordinate_is_nan() {
    let mut broken = report("Bee");
    broken.before.path[3].y_m = f64::NAN;
    broken.after.points_m.push((f64::INFINITY, 0.0));
    broken.after.path.clear();
    for report in [report("Bee"), broken] {
        let html = to_html(&report);
        assert!(!html.contains("NaN") && !html.contains("inf"), "a number is not finite");
        for tag in ["svg", "table", "tr", "td", "div", "g", "text", "p", "h2", "span"] {
            let opened = html.matches(&format!("<{tag}>")).count()
                + html.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }
}
