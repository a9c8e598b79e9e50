//! `beeline apply` and `beeline calibrate --method umbmark` on the simulator.

use crate::recorded::{SPINS_AND_ARCS, only_unequal_wheels, unequal_wheels};
use crate::temp_folder::TempFolder;

/// Before the runs of [`SPINS_AND_ARCS`]: with them, enough to tell a radius from a pull, and scale from track.
const OUT_AND_BACKS: &str = "\
acceleration_mps2 = 0.3
[[run]]
name = \"out_and_back\"
pieces = [{ straight_m = 1.2, speed_mps = 0.2 }, { straight_m = -1.2, speed_mps = 0.2 }]
[[run]]
name = \"north\"
heading_deg = 90
pieces = [{ straight_m = 1.2, speed_mps = 0.2 }, { straight_m = -1.2, speed_mps = 0.2 }]
";

/// After them.
const ARC_AND_SQUARE: &str = "\
[[run]]
name = \"arc_wide\"
pieces = [{ arc_deg = 300, radius_m = 0.9, speed_mps = 0.15 }]
[[run]]
name = \"square\"
pieces = [
  { straight_m = 0.8, speed_mps = 0.2 }, { spin_deg = 90, speed_mps = 0.1 },
  { straight_m = 0.8, speed_mps = 0.2 }, { spin_deg = 90, speed_mps = 0.1 },
]
";

/// Wheels that differ by 1 %, and a track 1 % too wide.
fn crooked_scenario() -> String {
    unequal_wheels("crooked", "geometry.track_width_m = 0.37572")
}

fn crooked() -> TempFolder {
    let temp = TempFolder::new();
    temp.write("crooked.toml", &crooked_scenario());
    temp.write("plan.toml", &[OUT_AND_BACKS, SPINS_AND_ARCS, ARC_AND_SQUARE].concat());
    temp
}

fn geometry(temp: &TempFolder, field: &str) -> f64 {
    let arguments = format!("config get geometry.{field} --json --flash flash");
    temp.run(&arguments).ok().json().as_f64().unwrap()
}

/// How sure the robot is of W_T and of its track width \[m\].
fn deviations(temp: &TempFolder) -> [f64; 2] {
    let odometry = temp.run("config get odometry --json --flash flash").ok().json();
    ["wheel_weight_sd", "track_width_sd_m"].map(|field| odometry[field].as_f64().unwrap())
}

#[test]
fn what_a_campaign_says_about_wheels_and_track_is_shown_asked_written_and_undone() {
    let temp = crooked();
    temp.run("campaign record robot --plan plan.toml --port sim:crooked.toml").ok();
    temp.run("config save --flash flash").ok();
    let before = temp.read("flash");
    let apply = ["apply", "robot", "--flash", "flash"];
    let refused = temp.run_with(&apply, "n\n");
    assert_eq!(refused.code, Some(130), "{refused:#?}");
    assert!(refused.stderr.contains("W_T") && refused.stderr.contains("track width"));
    assert_eq!(temp.read("flash"), before);

    temp.run_with(&apply, "y\n").ok();
    // To a tenth of what is wrong: a campaign of eight runs is good to some 1e-4.
    assert!((geometry(&temp, "wheel_weight") - 0.03582 / 0.03618).abs() < 1e-3);
    assert!((geometry(&temp, "track_width_m") / 0.37572 - 1.0).abs() < 1e-3);
    let [weight, track_m] = deviations(&temp);
    assert!(
        (1e-6..1e-3).contains(&weight) && (1e-6..1e-3).contains(&track_m),
        "{weight} {track_m}"
    );
    // Once is enough.
    let again = temp.run("apply robot --yes --flash flash --json").ok().json();
    assert_eq!(again["written"], false, "{again}");

    temp.run("apply --undo --flash flash").ok();
    assert_eq!(geometry(&temp, "wheel_weight"), 1.0);
    assert_eq!(deviations(&temp), [0.005, 0.004], "as before");
    // If there is a model, it is used as it is: the track is not in it.
    temp.run("model add wheel_radius_ratio robot").ok();
    temp.run("apply robot --yes --flash flash").ok();
    assert!((geometry(&temp, "wheel_weight") - 0.03582 / 0.03618).abs() < 2e-3);
    assert_eq!(geometry(&temp, "track_width_m"), 0.372);
    temp.run("apply --undo --flash flash").ok();
    let message = temp.run("apply --undo --flash flash").refused();
    assert!(message.contains("nothing that this computer applied"), "{message}");
}

#[test]
fn a_robot_that_was_corrected_by_its_campaign_goes_on_with_it() {
    let temp = crooked();
    temp.run("campaign record robot --plan plan.toml --port sim:crooked.toml --flash flash").ok();
    let nominal = temp.read("robot/robot.toml");
    temp.run("apply robot --yes --flash flash").ok();
    assert_ne!(geometry(&temp, "track_width_m"), 0.372);
    let spins =
        "campaign record robot --run \"spins both ways\" --port sim:crooked.toml --flash flash";
    temp.run_with(&crate::temp_folder::words(spins), "").ok();
    let toml = temp.read("robot/robot.toml");
    assert!(
        toml.starts_with(&nominal),
        "what is nominal stays: the runs before were explained by it"
    );
    // The same effects explain the raw counts of a robot whose configuration has changed.
    let value = |json: &serde_json::Value, id: &str| {
        let effects = json["effects"].as_array().unwrap();
        let effect = effects.iter().find(|effect| effect["effect"] == id).unwrap();
        effect["parameters"][0]["value"].as_f64().unwrap()
    };
    let fitted = "model add wheel_radius_ratio track_width robot --json";
    let json = temp.run(fitted).ok().json();
    assert!((value(&json, "track_width") - 0.01).abs() < 1e-3, "{json}");
    assert!((value(&json, "wheel_radius_ratio") + 0.01).abs() < 1e-3, "{json}");
    let again = temp.run("apply robot --yes --flash flash --json").ok().json();
    let (before, after) = (&again["before"], &again["after"]);
    for name in ["wheel_weight", "track_width_m"] {
        let of = |set: &serde_json::Value| set[name].as_f64().unwrap();
        assert!((of(before) / of(after) - 1.0).abs() < 1e-3, "{name}: {again}");
    }
}

/// A campaign of this scenario in this folder, recorded with what the flash has.
fn recorded(temp: &TempFolder, folder: &str, scenario: &str) {
    temp.run(&format!(
        "campaign record {folder} --plan plan.toml --port sim:{scenario} --flash flash"
    ))
    .ok();
}

#[test]
fn a_campaign_recorded_after_apply_knows_what_the_robot_compensates() {
    let temp = crooked();
    temp.write("unequal.toml", &only_unequal_wheels());
    recorded(&temp, "before", "unequal.toml");
    assert!(!temp.path("before/model.toml").exists(), "nothing is compensated yet");
    let missing = temp.run("explain before --exit-code --json");
    assert_eq!(missing.code, Some(1));
    assert!(missing.stdout.contains("wheel_radius_ratio"), "{missing:#?}");
    let nominal = temp.run("compare before --json").ok().json();
    temp.run("apply before --yes --flash flash").ok();

    recorded(&temp, "after", "unequal.toml");
    let model = String::from_utf8(temp.read("after/model.toml")).unwrap();
    assert!(model.contains("in_use = true") && model.contains("robot's configuration"), "{model}");
    let json = temp.run("explain after --exit-code --json").ok().json();
    assert_eq!(json["steps"].as_array().unwrap().len(), 0, "{json}");
    assert_eq!(json["unexplained"]["structure"], false, "{json}");
    let text = temp.run("explain after").ok().stdout;
    assert!(text.contains("Nothing is missing from the model"), "{text}");
    assert!(text.contains("wheel_radius_ratio  confirmed"), "{text}");
    assert!(text.contains("in use"), "{text}");
    // 10 mrad a metre are 17 mm after the 1.2 m there and back; what is left is the camera's noise.
    let position = |json: &serde_json::Value| json["comparison"]["position_m"]["rms"].as_f64();
    let compensated = temp.run("compare after --json").ok().json();
    let (before_m, after_m) = (position(&nominal).unwrap(), position(&compensated).unwrap());
    assert!(after_m < before_m / 5.0 && after_m > 0.0, "{before_m} {after_m}");
    let report = temp.run("report after -o report.html").ok();
    let page = String::from_utf8(temp.read("report.html")).unwrap();
    assert!(page.contains("Already compensated on the robot: unequal wheel radii"), "{report:#?}");
    assert!(page.contains("<h1>Nothing is missing</h1>"));

    // By the new runs alone: the same robot.
    temp.run("apply after --yes --flash flash").ok();
    assert!((geometry(&temp, "wheel_weight") - 0.03582 / 0.03618).abs() < 1e-3);
    assert!((geometry(&temp, "wheel_radius_m") / 0.03618 - 1.0).abs() < 1e-3);
    let again = temp.run("apply after --yes --flash flash --json").ok().json();
    assert_eq!(again["written"], false, "{again}");

    // A fit makes it a model like any other, which is then what is applied.
    temp.run("model fit after").ok();
    assert!(!String::from_utf8(temp.read("after/model.toml")).unwrap().contains("in_use"));
    temp.run("apply after --yes --flash flash").ok();
    assert!((geometry(&temp, "wheel_weight") - 0.03582 / 0.03618).abs() < 1e-3);
}

#[test]
fn what_is_compensated_and_no_longer_there_is_taken_back() {
    let temp = crooked();
    let unequal = only_unequal_wheels();
    temp.write("equal.toml", &unequal.replace("0.03618", "0.036").replace("0.03582", "0.036"));
    for set in ["wheel_weight 0.99", "wheel_radius_m 0.03618"] {
        temp.run(&format!("config set geometry.{set} --save --flash flash")).ok();
    }
    recorded(&temp, "robot", "equal.toml");
    let text = temp.run("explain robot").ok().stdout;
    assert!(text.contains("not confirmed by these runs"), "{text}");
    let robot = temp.read("robot/robot.toml");
    temp.run("apply robot --yes --flash flash").ok();
    assert!((geometry(&temp, "wheel_weight") - 1.0).abs() < 1e-3);
    // Going on with the campaign gives a warning, and leaves both files as they are.
    let spins =
        "campaign record robot --run \"spins both ways\" --port sim:equal.toml --flash flash";
    let model = temp.read("robot/model.toml");
    let more = temp.run_with(&crate::temp_folder::words(spins), "").ok();
    assert!(
        more.stderr.contains("the robot's wheel_radius_ratio differs from model.toml"),
        "{more:#?}"
    );
    assert!(temp.read("robot/robot.toml").starts_with(&robot));
    assert_eq!(temp.read("robot/model.toml"), model);
}

/// A twisted cable turns it to the left, 12 mrad a metre, forwards and backwards.
const PULLED: &str = "\
name = \"pulled\"
[plant]
substep_us = 200
tether.twist_nm = 0.2
tyre.rolling_resistance = 0.003
caster.rolling_resistance = 0.0
";

/// How far a run's heading is from where it was at the start, in the end \[rad\].
fn turned_rad(temp: &TempFolder, run: &str) -> f64 {
    let text = String::from_utf8(temp.read(run)).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = head.iter().position(|name| *name == "heading_rad").unwrap();
    let headings: Vec<f64> =
        lines.filter_map(|line| line.split(',').nth(column)?.parse().ok()).collect();
    // The robot stands at both ends: the mean of ten pictures.
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    mean(&headings[headings.len() - 10..]) - mean(&headings[..10])
}

#[test]
fn a_robot_that_is_pulled_aside_drives_straight_after_apply() {
    let temp = crooked();
    temp.write("pulled.toml", PULLED);
    recorded(&temp, "before", "pulled.toml");
    let json = temp.run("explain before --json").ok().json();
    assert_eq!(json["steps"][0]["effect"], "heading_pull", "{json}");
    let before = turned_rad(&temp, "before/runs/01_out_and_back.csv");
    assert!((0.02..0.05).contains(&before), "2.4 m turn it by {before}");

    let shown = temp.run("apply before --yes --flash flash").ok();
    assert!(shown.stderr.contains("heading pull"), "{shown:#?}");
    let pull = geometry(&temp, "heading_pull_rad_per_m");
    assert!((pull - before / 2.4).abs() < 0.2 * pull, "{pull} {before}");

    recorded(&temp, "after", "pulled.toml");
    let after = turned_rad(&temp, "after/runs/01_out_and_back.csv");
    assert!(after.abs() < before / 5.0, "{before} {after}");
    // The value is in the configuration, and the new runs give the same one: counts show the steering.
    let model = String::from_utf8(temp.read("after/model.toml")).unwrap();
    assert!(model.contains("id = \"heading_pull\"\n"), "{model}");
    let json = temp.run("explain after --json").ok().json();
    let steps = json["steps"].as_array().unwrap();
    assert!(steps.iter().all(|step| step["effect"] != "heading_pull"), "{json}");
    temp.run("apply after --yes --flash flash").ok();
    let again = geometry(&temp, "heading_pull_rad_per_m");
    assert!((again / pull - 1.0).abs() < 0.2, "{pull} {again}");

    temp.run("apply --undo --flash flash").ok();
    assert_eq!(geometry(&temp, "heading_pull_rad_per_m"), pull);
}

#[test]
fn a_calibration_does_not_take_a_pull_that_is_steered_against_for_a_radius() {
    let temp = crooked();
    temp.write("pulled.toml", PULLED);
    let calibrate = |temp: &TempFolder| {
        let json = temp.run("calibrate --port sim:pulled.toml --flash flash --json");
        json.json()["before"]["wheel_weight"]["value"].as_f64().unwrap()
    };
    // 12 mrad a metre over a track of 0.372 m pass for 0.4 %.
    let fooled = calibrate(&temp);
    assert!((fooled - 1.0).abs() > 3e-3, "{fooled}");
    let temp = crooked();
    temp.write("pulled.toml", PULLED);
    temp.run("config set geometry.heading_pull_rad_per_m 0.012 --save --flash flash").ok();
    let told = calibrate(&temp);
    assert!((told - 1.0).abs() < 1.5e-3, "{told}");
}

#[test]
fn a_campaign_of_another_robot_or_none_is_not_applied() {
    let temp = crooked();
    temp.run("campaign record robot --plan plan.toml --port sim:crooked.toml").ok();
    let toml = String::from_utf8(temp.read("robot/robot.toml")).unwrap();
    temp.write("robot/robot.toml", &toml.replace("counts_per_rev = 900", "counts_per_rev = 1024"));
    let message = temp.run("apply robot --yes").refused();
    assert!(message.contains("of another robot"), "{message}");
    let message = temp.run("apply nowhere --yes").refused();
    assert!(message.contains("nowhere"), "{message}");
    let message = temp.run("apply --undo").refused();
    assert!(message.contains("forgets"), "{message}");
}

#[test]
fn umbmark_corrects_wheels_and_track_and_its_squares_close() {
    umbmark_closes_squares(&crooked());
}

#[test]
fn umbmark_of_a_slow_camera_begins_where_the_robot_was_put() {
    let temp = crooked();
    // Half a second has five pictures: half of the last ten are from before the robot was put there.
    temp.write("crooked.toml", &format!("{}[camera]\nrate_hz = 10\n", crooked_scenario()));
    umbmark_closes_squares(&temp);
}

fn umbmark_closes_squares(temp: &TempFolder) {
    let arguments = "calibrate --method umbmark --runs 2 --cruise 0.2m/s --acceleration 0.3m/s^2 \
                     --port sim:crooked.toml --flash flash --json";
    let json = temp.run(arguments).ok().json();
    assert_eq!(json["saved"], true);
    let number = |set: &str, name: &str| json[set][name].as_f64().unwrap();
    let (before, after) = (number("before", "e_max_syst_m"), number("after", "e_max_syst_m"));
    // 2 L (a + beta), with a = 1 % of a quarter turn and beta = 1 % of L/b: 2 x (16 + 27) mm, times 1.4.
    assert!((0.05..0.15).contains(&before), "{before}");
    assert!(after < before / 5.0, "{before} {after}");
    // First order in errors of 1 %, and two squares under a camera of 2 mrad.
    assert!((geometry(temp, "wheel_weight") - 0.03582 / 0.03618).abs() < 2e-3);
    assert!((geometry(temp, "track_width_m") / 0.37572 - 1.0).abs() < 3e-3);
    let [weight, track_m] = deviations(temp);
    println!("sure to {weight}, {track_m} m");
    assert!(
        (1e-5..2e-3).contains(&weight) && (1e-5..2e-3).contains(&track_m),
        "{weight} {track_m}"
    );
    assert!(!json["explained"].as_array().unwrap().is_empty());
    let message = temp.run("calibrate --undo --port sim:crooked.toml --flash flash").refused();
    assert!(message.contains("`beeline apply --undo` undoes UMBmark"), "{message}");
    temp.run("apply --undo --port sim:crooked.toml --flash flash").ok();
    assert_eq!(geometry(temp, "wheel_weight"), 1.0);
}

#[test]
fn what_explain_says_of_umbmarks_squares_has_values_and_intervals_in_lines_that_fit() {
    let temp = crooked();
    let arguments = "calibrate --method umbmark --runs 2 --cruise 0.2m/s --acceleration 0.3m/s^2 \
                     --port sim:crooked.toml --flash flash";
    let said = temp.run(arguments).ok().stdout;
    assert!(said.ends_with("\nbeeline apply --undo puts the old geometry back\n"), "{said}");
    let (_, explained) = said.split_once("What `explain` finds").unwrap();
    assert!(explained.contains("wheel_radius_ratio"), "{said}");
    // Wheels that differ by 1 %: a value, its sigma, its interval, its unit.
    let value = explained.lines().find(|line| line.contains("\u{b1}") && line.contains("95 %: "));
    let value = value.unwrap_or_else(|| panic!("{said}"));
    assert!(value.trim_end().ends_with('%') && value.contains(" to "), "{value}");
    assert!(explained.lines().all(|line| line.chars().count() <= 100), "{said}");
}

#[test]
fn umbmark_that_cannot_be_remembered_is_refused_before_the_robot_moves() {
    let temp = crooked();
    // Where the folder of that name would have to be.
    temp.write("state", "");
    temp.run("config save --flash flash").ok();
    let flash = temp.read("flash");
    let arguments = "calibrate --method umbmark --runs 1 --cruise 0.2m/s --acceleration 0.3m/s^2 \
                     --port sim:crooked.toml --flash flash";
    let message = temp.run(arguments).refused();
    assert!(message.contains("for --undo") && message.contains("XDG_STATE_HOME"), "{message}");
    assert_eq!(temp.read("flash"), flash);
}

#[test]
fn umbmark_with_a_ruler_and_with_a_person_reads_ends_alone() {
    let temp = crooked();
    let common = "calibrate --method umbmark --runs 1 --side 50cm --cruise 0.2m/s \
                  --acceleration 0.3m/s^2 --port sim:crooked.toml";
    let outcome = temp.run(&format!("{common} --measure ruler")).ok();
    assert!(outcome.stdout.contains("E_max,syst"), "{outcome:#?}");
    assert!(!outcome.stdout.contains("explain"), "a ruler sees no tracks");
    let mut arguments: Vec<&str> = common.split_whitespace().collect();
    arguments.extend(["--measure", "ask"]);
    // Left, right; then with the correction: no better.
    let answers = "\n20mm -20mm\n\nwhat\n5mm 5mm\n\n40mm 0mm\n\n0mm 0mm\n";
    let outcome = temp.run_with(&arguments, answers);
    assert_eq!(outcome.code, Some(1), "{outcome:#?}");
    assert!(outcome.stderr.contains("did not reduce the error"), "{outcome:#?}");
}
