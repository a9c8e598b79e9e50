//! `beeline fleet`: five robots of one data sheet on four dates. All have a right wheel that is larger, one wears, one is unlike the
//! others; each is named, and nobody else is.

use campaign::{CampaignWriter, RobotFile, RunFacts};
use robot_model::kinematics::{Geometry, Pose, dead_reckon};
use robot_model::recording::{Piece, Recording, Robot, Sampling, nominal_run};

use crate::temp_folder::TempFolder;

const DATES: [&str; 4] = ["2025-01-10", "2025-02-10", "2025-03-10", "2025-04-10"];
const ROBOTS: [&str; 5] = ["ada", "bob", "cyd", "dan", "eve"];

/// Writes the campaign of a robot on a date: its right wheel is larger by `ratio`, both are by `scale`.
fn record(temp: &TempFolder, robot: usize, date: usize, ratio: f64, scale: f64) {
    let nominal = Geometry::PAPER;
    let model = Robot { gear_reduction: 1.0, ..Robot::PAPER };
    let straight = |travel_m| Piece::Straight { travel_m, speed_mps: 0.2 };
    let spin = |turn_rad| Piece::Spin { turn_rad, speed_mps: 0.1 };
    let arc = |turn_rad| Piece::Arc { radius_m: 0.5, turn_rad, speed_mps: 0.2 };
    let pieces = [straight(2.0), straight(-2.0), spin(12.0), spin(-12.0), arc(6.0), arc(-6.0)];
    let file = RobotFile {
        name: ROBOTS[robot].to_owned(),
        wheel_radius_m: nominal.wheel_radius_m,
        track_width_m: nominal.track_width_m,
        counts_per_rev: 900.0,
        gear_reduction: 1.0,
        ..RobotFile::default()
    };
    let folder = temp.path(&format!("fleet/{}/{}", ROBOTS[robot], DATES[date]));
    let writer = CampaignWriter::open(&folder, &file).unwrap();
    // The weight is on the right wheel alone: their mean stays.
    let mean = (1.0 + scale) / (1.0 + ratio / 2.0);
    let actual = Geometry { wheel_radius_m: nominal.wheel_radius_m * mean, ..nominal };
    let mut seed = (robot * DATES.len() + date) as u64 + 1;
    for (number, piece) in pieces.iter().enumerate() {
        let mut run = nominal_run(&model, "run", &[*piece], &Sampling::USUAL);
        measure(&mut run, &actual, 1.0 + ratio, &mut seed);
        let mut rows = writer
            .start_run(
                "run",
                &[campaign::Column::X, campaign::Column::Y, campaign::Column::Heading],
            )
            .unwrap();
        for row in ::import::write::rows(&run, &[], model.rad_per_count) {
            rows.push(&row).unwrap();
        }
        let started_s = Some(60.0 * number as f64);
        rows.finish(RunFacts { started_s, ..RunFacts::default() }).unwrap();
    }
}

/// Puts what a camera sees of a robot like this into its run, with noise of 1 mm and 2 mrad.
fn measure(run: &mut Recording, actual: &Geometry, weight: f64, seed: &mut u64) {
    let turns = run.wheels.iter().map(|sample| sample.phi_rad);
    let poses = dead_reckon(Pose::ORIGIN, actual, weight, turns);
    let mut noise = || {
        // Twelve uniform numbers make a normal one.
        (0..12).fold(-6.0, |sum, _| {
            *seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            sum + (*seed >> 11) as f64 / (1_u64 << 53) as f64
        })
    };
    for (k, measured) in run.measured_poses.iter_mut().enumerate() {
        let pose = poses[k * Sampling::USUAL.samples_per_pose];
        measured.position_m = Some([pose.x_m + 1e-3 * noise(), pose.y_m + 1e-3 * noise()]);
        measured.heading_rad = Some(pose.heading_rad + 2e-3 * noise());
    }
}

/// The whole fleet. `cyd` loses 0.1 % of its radius a month, `eve` has a right wheel that is larger by 4 %.
fn fleet() -> TempFolder {
    let temp = TempFolder::new();
    for robot in 0..ROBOTS.len() {
        for date in 0..DATES.len() {
            let own = [0.008, 0.0082, 0.0079, 0.0081, 0.04][robot];
            let scale = if robot == 2 { -1e-3 * date as f64 } else { 0.0 };
            record(&temp, robot, date, own, scale);
        }
    }
    temp
}

#[test]
fn who_wears_and_who_is_unlike_the_others_is_named_and_nobody_else() {
    let temp = fleet();
    let line = ["fleet", "fleet", "-o", "fleet.html", "--table", "values.csv", "--json"];
    let told = temp.run_with(&line, "").ok().json();
    let findings = told["findings"].as_array().unwrap();
    let text =
        |finding: &serde_json::Value, key: &str| finding[key].as_str().unwrap_or("").to_owned();
    let found: Vec<[String; 3]> =
        findings.iter().map(|one| ["what", "robot", "effect"].map(|key| text(one, key))).collect();
    let expected = [
        ["wears", "cyd", "wheel_radius_scale"],
        ["unlike", "eve", "wheel_radius_ratio"],
        ["common", "", "wheel_radius_ratio"],
    ];
    assert_eq!(found, expected, "{findings:#?}");
    // 0.3 % in 90 days.
    let words = text(&findings[0], "words");
    let rate: f64 =
        words.split_once("by ").unwrap().1.split_whitespace().next().unwrap().parse().unwrap();
    assert!((rate - 0.1).abs() < 0.005, "{words}");
    let kind = &told["kinds"][0];
    assert_eq!(kind["robots"].as_array().unwrap().len(), 5);
    assert_eq!(kind["campaigns"].as_array().unwrap().len(), 20);
    assert_eq!(kind["campaigns"][5]["date"], "2025-02-10");
    let csv = String::from_utf8(temp.read("values.csv")).unwrap();
    let parameters = kind["parameters"].as_array().unwrap().len();
    assert_eq!(csv.lines().count(), 1 + 20 * parameters);
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.matches(',').count() + 1 >= columns), "{csv}");
    let page = String::from_utf8(temp.read("fleet.html")).unwrap();
    for part in ["cyd wears", "eve is unlike the others", "2025-01-10", "<svg"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("NaN"));
    let lines = page.matches("<i class=").count();
    assert_eq!(lines, 4, "changes, unlike, neither, where most are");
    let dan = temp.run_with(&["fleet", "fleet/dan", "fleet/bob"], "").ok();
    assert!(dan.stdout.contains("No robot stands out."), "{}", dan.stdout);
    let alone = ["fleet", "fleet/dan/2025-02-10", "-o", "alone.html"];
    let alone = temp.run_with(&alone, "").ok();
    assert!(alone.stdout.contains("Nothing to compare"), "{}", alone.stdout);
    let page = String::from_utf8(temp.read("alone.html")).unwrap();
    assert!(page.contains("Nothing to compare") && !page.contains("Bars"), "{page}");
}

#[test]
fn a_campaign_that_cannot_be_read_is_left_out_and_said() {
    let temp = TempFolder::new();
    record(&temp, 0, 0, 0.008, 0.0);
    record(&temp, 0, 1, 0.008, 0.0);
    std::fs::write(temp.path("fleet/ada/2025-02-10/robot.toml"), "name = 3").unwrap();
    let outcome = temp.run_with(&["fleet", "fleet"], "").ok();
    assert!(outcome.stderr.contains("2025-02-10 is left out: "), "{}", outcome.stderr);
    assert!(outcome.stdout.contains("ada"), "{}", outcome.stdout);
    let none = temp.run_with(&["fleet", "fleet/ada/2025-02-10"], "").refused();
    assert!(none.contains("none of these campaigns"), "{none}");
    std::fs::create_dir(temp.path("empty")).unwrap();
    let empty = temp.run_with(&["fleet", "empty"], "").refused();
    assert!(empty.contains("there is no campaign"), "{empty}");
    let nowhere = temp.run_with(&["fleet", "fleet", "no-fleet"], "").refused();
    assert!(nowhere.contains("no-fleet: "), "{nowhere}");
}

#[test]
fn one_campaign_is_a_table_and_one_robot_has_no_legend() {
    let temp = TempFolder::new();
    record(&temp, 0, 0, 0.04, 0.0);
    temp.run_with(&["fleet", "fleet", "-o", "one.html"], "").ok();
    let page = String::from_utf8(temp.read("one.html")).unwrap();
    assert!(!page.contains("<svg") && !page.contains("class=\"legend\""));
    assert!(page.contains("unequal wheel radii") && page.contains(" %</td>"), "{page}");
    record(&temp, 0, 1, 0.04, 0.0);
    temp.run_with(&["fleet", "fleet", "-o", "two.html"], "").ok();
    let page = String::from_utf8(temp.read("two.html")).unwrap();
    assert!(page.contains("<svg") && !page.contains("class=\"legend\""));
}
