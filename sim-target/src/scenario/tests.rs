use std::collections::BTreeSet;
use std::path::Path;

use shared_proto::Wheel;

use super::{FaultClock, Scenario};
use crate::plant::{PlantFault, PlantParameters, Pose};

fn shipped() -> Vec<Scenario> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut paths: Vec<_> = std::fs::read_dir(&folder)
        .expect("the scenarios' folder")
        .map(|entry| entry.expect("readable").path())
        .collect();
    paths.sort();
    paths
        .iter()
        .map(|path| Scenario::load(path).unwrap_or_else(|error| panic!("{error}")))
        .collect()
}

fn complaint(text: &str) -> String {
    Scenario::parse("robot.toml", text).expect_err("this should be refused").to_string()
}

#[test]
fn every_scenario_that_is_shipped_is_valid_and_has_a_name_of_its_own() {
    let scenarios = shipped();
    let names: BTreeSet<_> = scenarios.iter().map(|s| s.name.clone()).collect();
    assert_eq!(names.len(), scenarios.len());
    assert!(names.contains("paper") && names.contains("lossy link") && names.len() >= 8);
}

#[test]
fn the_default_is_the_papers_robot() {
    let scenario = Scenario::default();
    let geometry = scenario.plant.geometry;
    assert_eq!(scenario.name, "paper");
    assert_eq!(geometry.wheel_radius_m.left, 0.036);
    assert_eq!(geometry.track_width_m, 0.372);
    let ratio = geometry.wheel_radius_m.right / geometry.wheel_radius_m.left;
    assert!((ratio - 0.9919).abs() < 1e-12, "{ratio}");
}

#[test]
fn what_is_left_out_is_standard() {
    let scenario = Scenario::parse("robot.toml", "name = 'bare'").expect("valid");
    assert_eq!(scenario.plant, PlantParameters::default());
    assert!(scenario.faults.is_empty());
}

#[test]
fn a_scenario_survives_being_written_and_read() {
    for scenario in shipped().into_iter().chain((0..5).map(Scenario::draw)) {
        let text = scenario.to_toml();
        assert_eq!(Scenario::parse("written", &text).as_ref(), Ok(&scenario), "{text}");
    }
}

#[test]
fn an_error_names_file_line_column_and_cure() {
    let misspelt = complaint("name = 'x'\n[plant]\nbody.mass = 4.0\n");
    assert!(
        misspelt.starts_with("robot.toml, line 3, column 6: unknown field `mass`"),
        "{misspelt}"
    );
    assert!(misspelt.ends_with("correct the name, or leave the line out"), "{misspelt}");

    let value = complaint("name = 'x'\n\n[plant]\nbody.mass_kg = -4.0\n");
    assert!(
        value.starts_with("robot.toml, line 4, column 16: plant.body.mass_kg = -4 is out of"),
        "{value}"
    );
    assert!(value.ends_with("plant.body.mass_kg must be from 0.05 to 500"), "{value}");

    let text = complaint("name = 'x'\nseed = 'seven'\n");
    assert!(text.starts_with("robot.toml, line 2, column 8: invalid type: string"), "{text}");

    let syntax = complaint("name = 'x'\nseed = \n");
    assert!(syntax.starts_with("robot.toml, line 2, column "), "{syntax}");

    assert!(complaint("seed = 1").contains("missing field `name`"));
}

#[test]
fn a_conflict_of_defaults_points_at_the_section_that_caused_it() {
    let text = "name = 'x'\n[plant.tyre]\nlongitudinal_stiffness_n_per_m = 2e6\n";
    let complaint = complaint(text);
    assert!(complaint.starts_with("robot.toml, line 2, column "), "{complaint}");
    assert!(complaint.contains("substep_us must be at most"), "{complaint}");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = Scenario::load(Path::new("no/such/robot.toml")).expect_err("there is none");
    assert!(error.to_string().starts_with("no/such/robot.toml: cannot be read"), "{error}");
}

#[test]
fn faults_need_exactly_what_their_kind_has() {
    let fault = |fields: &str| format!("name = 'x'\n[[fault]]\n{fields}\n");
    for (fields, expected) in [
        (
            "kind = 'wheel_blocked'\nat_s = 1",
            "missing field `wheel`, which kind = \"wheel_blocked\" needs",
        ),
        (
            "kind = 'driver_fault'\nwheel = 'left'\nat_s = 1",
            "unknown field `wheel`: kind = \"driver_fault\" has none",
        ),
        ("kind = 'encoder_noise'\nwheel = 'left'\nat_s = 1", "missing field `counts_per_s`"),
        ("kind = 'supply_dip'\nat_s = 1", "missing field `volts`"),
        ("kind = 'emergency_stop'", "missing field `at_s` or `at_motion_s`"),
        ("kind = 'emergency_stop'\nat_s = 1\nat_motion_s = 2", "keep one"),
        ("kind = 'gremlins'\nat_s = 1", "unknown variant `gremlins`"),
        ("kind = 'emergency_stop'\nat_s = 5\nuntil_s = 4", "fault.until_s = 4 is out of range"),
        ("kind = 'emergency_stop'\nat_s = -5", "fault.at_s = -5 is out of range"),
    ] {
        let complaint = complaint(&fault(fields));
        assert!(complaint.contains(expected), "{fields}: {complaint}");
        assert!(complaint.starts_with("robot.toml, line "), "{complaint}");
    }
}

#[test]
fn faults_come_on_the_clock_they_ask_for() {
    let text = "name = 'x'
        [[fault]]
        kind = 'encoder_noise'
        wheel = 'right'
        counts_per_s = 500
        at_s = 1.5
        until_s = 2.25
        [[fault]]
        kind = 'wheel_jammed'
        wheel = 'left'
        at_motion_s = 9";
    let setup = Scenario::parse("robot.toml", text).expect("valid").set_up();
    let [noise] = setup.faults[..] else { panic!("{:?}", setup.faults) };
    assert_eq!(noise.fault, PlantFault::EncoderNoise(Wheel::Right, 500.0));
    assert_eq!((noise.at_us, noise.until_us), (1_500_000, Some(2_250_000)));
    let [jam] = setup.motion_faults[..] else { panic!("{:?}", setup.motion_faults) };
    assert_eq!(jam.fault, PlantFault::WheelJammed(Wheel::Left));
    assert_eq!((jam.at_us, jam.until_us), (9_000_000, None));
    let cut = shipped().into_iter().find(|s| s.name == "encoder cut at cruise").expect("shipped");
    assert_eq!(cut.faults[0].clock, FaultClock::Motion);
}

#[test]
fn losses_belong_to_a_direction() {
    let text = "name = 'x'\n[link]\nframe_loss_to_robot = 0.1\nframe_loss_to_host = 0.2";
    let setup = Scenario::parse("robot.toml", text).expect("valid").set_up();
    assert_eq!((setup.to_robot.frame_loss, setup.to_host.frame_loss), (0.1, 0.2));
    assert_eq!(setup.to_robot.baud, 921_600);
}

#[test]
fn each_placement_is_crooked_in_its_own_way_and_the_same_every_time() {
    let scenario = Scenario::draw(4);
    let line = Pose { x_m: 1.0, y_m: 2.0, heading_rad: 3.0 };
    let n = 400;
    let crooked: Vec<f64> =
        (0..n).map(|run| scenario.placement(line, run).heading_rad - 3.0).collect();
    let rms = (crooked.iter().map(|c| c * c).sum::<f64>() / n as f64).sqrt();
    // sigma 2 mrad; 3.5 % of sampling error at n = 400, 4 of these.
    assert!((rms / 0.002 - 1.0).abs() < 0.14, "{rms}");
    assert_eq!(scenario.placement(line, 7), scenario.placement(line, 7));
    let setup = scenario.set_up();
    assert_eq!(setup.start, scenario.placement(Pose::default(), 0));
    assert_eq!(setup.plant.pose().heading_rad, setup.start.heading_rad);
}

#[test]
fn drawn_robots_fill_their_ranges_and_stay_inside() {
    let ratios: Vec<f64> = (0..1000)
        .map(|seed| {
            let scenario = Scenario::draw(seed);
            assert_eq!(scenario.validate(), Ok(()), "seed {seed}");
            let geometry = scenario.plant.geometry;
            assert!((geometry.track_width_m / 0.372 - 1.0).abs() <= 0.005 + 1e-12);
            assert!((geometry.wheel_radius_m.left / 0.036 - 1.0).abs() <= 0.003 + 1e-12);
            assert_ne!(scenario.plant.motor.left, scenario.plant.motor.right);
            geometry.wheel_radius_m.right / geometry.wheel_radius_m.left
        })
        .collect();
    let (min, max) = ratios.iter().fold((2.0_f64, 0.0_f64), |(a, b), &r| (a.min(r), b.max(r)));
    // The chance that a thousand draws leave a gap of 0.0003 at an end is e^-10.
    assert!((0.985..0.9853).contains(&min) && (1.0147..=1.015).contains(&max), "{min} {max}");
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    // Uniform: sigma of the mean 0.00027, 4 of these.
    assert!((mean - 1.0).abs() < 0.0011, "{mean}");
    assert_eq!(Scenario::draw(9), Scenario::draw(9));
}

#[test]
fn worn_parts_that_nothing_physical_has_are_refused_where_they_stand() {
    for (text, expected) in [
        (
            "[plant]\nwheel.left.bend_rad = 2.0",
            "robot.toml, line 3, column 23: plant.wheel.left.bend_rad = 2",
        ),
        (
            "[plant]\nwheel.middle.bend_rad = 0.1",
            "robot.toml, line 3, column 7: unknown field `middle`",
        ),
        (
            "[plant]\ngear.left.backlash = 0.1",
            "robot.toml, line 3, column 11: unknown field `backlash`",
        ),
        ("[plant.floor.wet]\nx_m = 1.0", "missing field"),
        (
            "[plant.floor]\nbump = { x_m = 0, y_m = 0, radius_m = 0.1, height_m = 0.1 }",
            "robot.toml, line 3, column 55: plant.floor.bump.height_m = 0.1",
        ),
        (
            "[plant.encoder.left.error]\nmesh_teeth = 0",
            "robot.toml, line 3, column 14: plant.encoder.left.error",
        ),
        (
            "[camera]\nlens.distortion_per_m2 = 5",
            "robot.toml, line 3, column 26: camera.lens.distortion_per_m2",
        ),
        (
            "[camera]\nmarker.forward_m = nan",
            "robot.toml, line 3, column 20: camera.marker.forward_m",
        ),
        ("[camera.stale]\nshare = 0.9", "robot.toml, line 3, column 9: camera.stale.share"),
        ("[gyro]\nscale = 3", "robot.toml, line 3, column 9: gyro.scale = 3"),
        ("[gyro]\nbias = 3", "robot.toml, line 3, column 1: unknown field `bias`"),
    ] {
        let complaint = complaint(&format!("name = 'x'\n{text}\n"));
        assert!(complaint.contains(expected), "{text}: {complaint}");
    }
}

#[test]
fn the_page_on_scenarios_lists_every_key_and_its_example_is_valid() {
    let page = include_str!("../../../docs/scenarios.md");
    let example = page.split("```").nth(1).and_then(|block| block.strip_prefix("toml"));
    let example = Scenario::parse("the page's example", example.expect("an example"));
    assert_eq!(example.map(|scenario| scenario.plant.gear.left.backlash_rad), Ok(0.03));
    let everything = "name = 'x'
        [gyro]
        [plant]
        gear.left.set_screw_nm = 1
        floor.wet = { x_m = 0, y_m = 0, radius_m = 1, friction = 1 }
        floor.bump = { x_m = 0, y_m = 0, radius_m = 1, height_m = 0 }";
    let text = Scenario::parse("everything", everything).expect("valid").to_toml();
    let of_worn_parts = |section: &str| {
        ["wheel", "gear", "tether", "drag", "warming", "error", "floor", "gyro", "stale", "lens"]
            .iter()
            .any(|part| section.contains(part))
    };
    let mut section = String::new();
    for line in text.lines() {
        if line.starts_with('[') {
            section = line.into();
        } else if let Some((key, _)) = line.split_once(" = ")
            && of_worn_parts(&section)
            // What every robot has: gravity is not worn.
            && !["left", "right", "gravity_mps2"].contains(&key)
        {
            assert!(page.contains(key), "{section} {key} is not on the page");
        }
    }
}
