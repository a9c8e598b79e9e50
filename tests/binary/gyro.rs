//! A yaw rate sensor, from the scenario to the answer of `explain`.

use campaign::Campaign;

use crate::temp_folder::TempFolder;

const ROBOT: &str = "name = \"gyro\"\nseed = 3\n[gyro]\nbias_rad_s = 0.01\nscale = 0.02\n";

/// Stands, turns both ways on the spot and in arcs, and stands again.
const PLAN: &str = "\
acceleration_mps2 = 0.3
[[run]]
name = \"rest\"
pieces = [{ rest_s = 5 }]
[[run]]
name = \"left\"
pieces = [{ spin_deg = 360, speed_mps = 0.2 }]
[[run]]
name = \"right\"
pieces = [{ spin_deg = -360, speed_mps = 0.2 }]
[[run]]
name = \"arc_left\"
pieces = [{ arc_deg = 180, radius_m = 0.4, speed_mps = 0.15 }]
[[run]]
name = \"arc_right\"
pieces = [{ arc_deg = -180, radius_m = 0.4, speed_mps = 0.15 }]
[[run]]
name = \"rest_again\"
pieces = [{ rest_s = 5 }]
";

#[test]
fn what_is_wrong_with_a_gyro_is_found_in_a_campaign_that_was_recorded_with_it() {
    let temp = TempFolder::new();
    temp.write("gyro.toml", ROBOT);
    temp.write("plan.toml", PLAN);
    temp.run("campaign record robot --plan plan.toml --port sim:gyro.toml").ok();
    let answer = temp.run("explain robot --json").ok().json();
    for (effect, truth) in [("gyro_bias", 0.01), ("gyro_scale", 0.02)] {
        let steps = answer["steps"].as_array().unwrap();
        let step = steps.iter().find(|step| step["effect"] == effect);
        let step = step.unwrap_or_else(|| panic!("{effect}: {answer:#}"));
        assert_eq!(step["class"], serde_json::json!([effect]));
        let value = |name: &str| step["parameters"][0][name].as_f64().unwrap();
        // Within four sigma, and the sigma is below a fiftieth of the value.
        assert!((value("value") - truth).abs() < 4.0 * value("sigma"), "{effect}: {step:#}");
        assert!(value("sigma") < 0.02 * truth, "{effect}: {step:#}");
    }
}

#[test]
fn a_single_run_has_the_gyros_column_too_and_a_robot_without_one_has_none() {
    let temp = TempFolder::new();
    temp.write("gyro.toml", ROBOT);
    temp.run("record with spin 90deg --port sim:gyro.toml").ok();
    temp.run("record without spin 90deg").ok();
    let readings = |folder: &str| {
        let campaign = Campaign::read(&temp.path(folder)).unwrap();
        campaign.runs[0].rows.iter().filter_map(|row| row.gyro_z_rad_s).count()
    };
    // 100 a second, for more than five.
    assert!(readings("with") > 500);
    let text = String::from_utf8(temp.read("without/runs/01_spin.csv")).unwrap();
    assert!(!text.contains("gyro"), "{}", text.lines().next().unwrap_or_default());
    let message = temp.run("campaign record robot --gyro log.csv --port sim:gyro.toml").refused();
    assert!(message.contains("[gyro]"), "{message}");
}
