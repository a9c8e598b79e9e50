//! Bad input: exit code 2, one error with a hint, no file half written, and no motion of the robot.

use shared_proto::{Config, EncoderConfig, WheelPair};

use crate::temp_folder::TempFolder;

/// Values just and far outside the range of each field.
fn out_of_range() -> impl Iterator<Item = (&'static str, String)> {
    Config::FIELDS.iter().flat_map(|field| {
        let span = field.max - field.min;
        [field.min - span * 1e-3, field.max + span * 1e-3, -1e300, f64::NAN, f64::INFINITY]
            .map(|value| (field.path, value.to_string()))
    })
}

#[test]
fn every_field_out_of_range_is_refused_by_name() {
    let temp = TempFolder::new();
    temp.run("config save --flash flash").ok();
    let flash = temp.read("flash");
    for (path, value) in out_of_range() {
        let arguments = ["config", "set", path, &value, "--save", "--flash", "flash"];
        let message = temp.run_with(&arguments, "").refused();
        assert!(message.contains(&format!("{path} = ")), "{path} = {value}: {message}");
        assert!(message.contains("must be from"), "{path} = {value}: {message}");
    }
    assert_eq!(temp.read("flash"), flash);
}

#[test]
fn every_field_out_of_range_in_a_file_is_refused_by_name() {
    let temp = TempFolder::new();
    temp.run("config save --flash flash").ok();
    let flash = temp.read("flash");
    for (path, value) in out_of_range() {
        let mut config = toml::Value::try_from(Config::default()).unwrap();
        let place = path.split('.').fold(&mut config, |place, name| place.get_mut(name).unwrap());
        *place = toml::Value::Float(value.parse().unwrap());
        temp.write("bad.toml", &toml::to_string(&config).unwrap());
        let message = temp.run("config import bad.toml --save --flash flash").refused();
        assert!(
            message.contains("bad.toml, line ") && message.contains(&format!("{path} = ")),
            "{message}"
        );
    }
    assert_eq!(temp.read("flash"), flash);
}

#[test]
fn a_supply_that_could_never_be_right_is_refused_and_may_be_mended() {
    let temp = TempFolder::new();
    let message = temp.run("config set protection.supply_v_min 19").refused();
    assert!(
        message.contains("(19 V) would not be below protection.supply_v_max (18.5 V)"),
        "{message}"
    );
    temp.run("config export mine.toml").ok();
    let mine = String::from_utf8(temp.read("mine.toml")).unwrap();
    let lower = mine.replace("supply_v_max = 18.5", "supply_v_max = 8.0");
    temp.write("lower.toml", &lower);
    let message = temp.run("config import lower.toml --save --flash flash").refused();
    assert!(message.contains("never be armed"), "{message}");
    temp.run("config set protection.supply_v_min 7").ok();
}

#[test]
fn a_value_that_is_no_value_of_its_field_is_refused() {
    let temp = TempFolder::new();
    for (arguments, expected) in [
        ("config set geometry.wheel_weight straight", "must be a number"),
        ("config set geometry.wheel_weight 36mm", "must be a number"),
        ("config set encoder.left.reversed maybe", "true or false"),
        ("config set geometry 1", "group of fields"),
        ("config set wheel_weight 1", "did you mean geometry.wheel_weight?"),
        ("config get geometry.colour", "no field `geometry.colour`"),
        ("config set name a-name-that-is-longer-than-any-robot-can-remember-it", "too long"),
        ("config import nowhere.toml", "nowhere.toml"),
        ("config export /proc/robot.toml", "/proc/robot.toml"),
        ("config export nowhere/robot.toml", "nowhere/robot.toml"),
    ] {
        let message = temp.run(arguments).refused();
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    assert_eq!(temp.listing(), [""; 0]);
}

#[test]
fn a_value_out_of_range_says_what_somebody_may_have_meant() {
    let temp = TempFolder::new();
    for (change, meant) in [
        ("encoder.left.counts_per_rev 0.5", "four times the pulses (PPR)"),
        ("encoder.left.gear_reduction 0", "43.7 for 43.7:1"),
        ("protection.probe_duty_max 25", "0.25 is a quarter"),
        ("geometry.wheel_weight 9", "without a unit"),
        ("geometry.wheel_radius_m 36", "SI units"),
    ] {
        let message = temp.run(&format!("config set {change}")).refused();
        assert!(message.contains(meant), "{change}: {message}");
    }
}

#[test]
fn a_fault_whose_cause_is_still_there_is_named_with_what_to_do() {
    let temp = TempFolder::new();
    temp.write("pressed.toml", "name = 'p'\n[[fault]]\nkind = 'emergency_stop'\nat_s = 0.0\n");
    let message = temp.run("clear --port sim:pressed.toml").refused();
    assert!(message.contains("keeps the fault emergency_stop"), "{message}");
    assert!(message.contains("release the emergency stop"), "{message}");
}

#[test]
fn counts_that_get_so_long_that_little_is_seen_of_them_are_said() {
    let temp = TempFolder::new();
    let warned = |change: &str| {
        temp.run(&format!("config set {change}")).ok().stderr.contains("one count is 14.1 mm")
    };
    assert!(warned("encoder.left.counts_per_rev 16"));
    let never = |change: &str| {
        temp.run(&format!("config set {change}"))
            .ok()
            .stderr
            .contains("drives end with following_error")
    };
    assert!(never("encoder.left.counts_per_rev 22"));
    assert!(!never("encoder.left.counts_per_rev 24"));
    assert!(!warned("geometry.wheel_weight 1.01"));
}

#[test]
fn a_distance_per_count_that_no_robot_has_is_refused() {
    let temp = TempFolder::new();
    let fine = EncoderConfig { counts_per_rev: 1e6, gear_reduction: 1000.0, reversed: false };
    let config = Config { encoder: WheelPair::both(fine), ..Config::default() };
    temp.write("fine.toml", &toml::to_string(&config).unwrap());
    let message = temp.run("config import fine.toml").refused();
    assert!(
        message.contains("left wheel travels") && message.contains("gear_reduction"),
        "{message}"
    );
}

#[test]
fn a_configuration_file_that_is_wrong_is_refused_with_its_line() {
    let temp = TempFolder::new();
    let good = toml::to_string(&Config::default()).unwrap();
    for (text, expected) in [
        (good.replace("wheel_weight", "wheel_wait"), "wheel_wait"),
        (good.replace("wheel_weight = 1.0", "wheel_weight = \"one\""), "bad.toml, line "),
        (good.replace("wheel_weight = 1.0\n", ""), "wheel_weight"),
        ("= nonsense".into(), "bad.toml, line 1, column 1"),
        (String::new(), "bad.toml"),
    ] {
        temp.write("bad.toml", &text);
        let message = temp.run("config import bad.toml").refused();
        assert!(message.contains(expected), "{expected}: {message}");
    }
}

#[test]
fn a_wrong_scenario_is_refused_with_file_line_and_column() {
    let temp = TempFolder::new();
    for (text, expected) in [
        ("name = \"x\"\n[plant.body]\nmas_kg = 4.0\n", "bad.toml, line 3, column 1"),
        ("name = \"x\"\n[plant.body]\nmass_kg = -4.0\n", "bad.toml, line 3, column 11"),
        ("name = \"x\"\n[plant.body]\nmass_kg = \"heavy\"\n", "bad.toml, line 3, column 11"),
        ("name = \"x\"\n[[fault]]\nkind = \"lightning\"\n", "bad.toml, line 3, column 8"),
        ("name = \n", "bad.toml, line 1,"),
    ] {
        temp.write("bad.toml", text);
        for command in ["identify", "calibrate", "sim --listen tcp:127.0.0.1:0"] {
            let message = temp.run(&format!("{command} --port sim:bad.toml")).refused();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
    assert_eq!(temp.listing(), ["bad.toml"]);
}

#[test]
fn a_picture_that_cannot_be_drawn_stops_the_robot_before_it_moves() {
    let temp = TempFolder::new();
    std::fs::create_dir(temp.path("folder.html")).unwrap();
    let message = temp.run("calibrate --flash flash --output picture.png").refused();
    assert!(message.contains("must end in .html or .svg"), "{message}");
    for picture in
        ["nowhere/picture.html", "folder.html", "/proc/picture.html", "/dev/null/picture.html"]
    {
        let message = temp.run(&format!("calibrate --flash flash --output {picture}")).refused();
        assert!(message.contains(&format!("cannot write the picture {picture}")), "{message}");
        assert!(!message.contains("Driving"), "{message}");
        assert!(!message.contains(".beeline-"), "{message}");
    }
    // Not even the flash was made: no robot was started.
    assert_eq!(temp.listing(), ["folder.html"]);
}

#[test]
fn other_bad_arguments_are_refused_before_the_robot_moves() {
    let temp = TempFolder::new();
    std::fs::create_dir(temp.path("folder")).unwrap();
    for (arguments, expected) in [
        ("calibrate --measure telepathy", "camera, ask, track:FILE, ruler (to calibrate)"),
        ("calibrate --measure track:", "camera, ask, track:FILE, ruler (to calibrate)"),
        ("calibrate --measure track:folder --yes", "folder"),
        ("calibrate --distance -8rev", "above zero"),
        ("calibrate --distance 8", "no unit"),
        ("calibrate --ruler 0mm", "above zero"),
        ("calibrate --tolerance NaN", "from 0 to 50"),
        ("calibrate --tolerance -1", "from 0 to 50"),
        ("calibrate --start-heading -1mrad", "must not be negative"),
        ("calibrate --position-sigma 0mm", "above zero"),
        ("identify --flash folder", "folder"),
        ("watch --rate 0", "from 1 to 1000"),
        ("drive velocity - --turn 1rad/s", "--turn is not for velocities from standard input"),
        ("watch --rate 2000", "from 1 to 1000"),
        ("watch --rate 600", "as 500 and 1000 do"),
        ("record robot straight 1rev --rate 300", "as 250 and 500 do"),
        ("watch --for -1s", "above zero"),
        ("sim", "--listen"),
        ("sim --listen somewhere", "tcp:HOST:PORT or pty"),
        ("sim --listen tcp:127.0.0.1:nine", "tcp:HOST:PORT or pty"),
        ("sim --listen tcp:192.0.2.1:0", "--insecure"),
        ("sim --listen tcp:192.0.2.1:0 --insecure", "cannot listen"),
        ("drive velocity 0.1m/s", "--for TIME"),
        ("drive velocity 5m/s --for 1s", "limits.speed_mps_max"),
        ("drive velocity 0.1 --for 1s", "has no unit"),
        ("drive velocity 0.1m/s --turn 3deg --for 1s", "30deg/s"),
        ("sim --listen pty --reset-on-connect", "a pseudo-terminal does not report connections"),
        ("sim --listen tcp:127.0.0.1:0 --port /dev/ttyACM0", "sim:SCENARIO.toml"),
        ("sim --listen tcp:127.0.0.1:0 --camera nowhere/track.csv", "nowhere/track.csv"),
        ("drive straight 30km", "error: not driven: farther than 20 km"),
        ("identify --seed x", "must be a whole number from 0"),
        ("calibrate --runs 101", "must be a whole number from 1 to 100"),
        ("wheel-weight --counts-per-rev x --dx 1mm", "must be a number"),
        ("completions cobol", "bash"),
        ("dance", "dance"),
        ("--colour", "--colour"),
    ] {
        let message = temp.run(arguments).refused();
        assert!(message.contains(expected), "{arguments}: {message}");
        assert!(!message.contains("encoders"), "{arguments} drove: {message}");
    }
    assert_eq!(temp.listing(), ["folder"]);
}

#[test]
fn an_error_under_json_is_one_value_too() {
    let temp = TempFolder::new();
    for arguments in [
        "identify --json --port tcp:127.0.0.1:1",
        "--json calibrate --output nowhere/picture.html",
        "config set geometry.wheel_weight 9 --json",
        "wheel-weight --dx 1 --dy 1mm --json",
        "dance --json",
    ] {
        let outcome = temp.run(arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:#?}");
        assert_eq!(outcome.stderr, "", "{arguments}");
        let value = outcome.json();
        assert_eq!(value["exit_code"], 2, "{arguments}");
        assert!(value["error"].as_str().is_some_and(|text| !text.is_empty()), "{value}");
        assert!(value["hint"].as_str().is_some_and(|text| !text.is_empty()), "{value}");
    }
    for (arguments, field, expected) in [
        ("sim --json", "error", "--listen"),
        ("wheel-weight --json", "error", "--lateral"),
        ("config set --json", "error", "<FIELD> <VALUE>"),
        ("dance --json", "error", "dance"),
        ("calibrate --tolerence 1 --json", "hint", "'--tolerance'"),
    ] {
        let value = temp.run(arguments).json();
        assert!(
            value[field].as_str().is_some_and(|text| text.contains(expected)),
            "{arguments}: {value}"
        );
    }
}

#[test]
fn a_track_that_is_there_is_not_overwritten_by_the_camera() {
    let temp = TempFolder::new();
    temp.write("mine.csv", "precious");
    let arguments = "sim --listen tcp:127.0.0.1:0 --for 50ms --camera mine.csv";
    let message = temp.run(arguments).refused();
    assert!(message.contains("mine.csv exists"), "{message}");
    assert_eq!(temp.read("mine.csv"), b"precious");
}

#[test]
#[cfg(unix)]
fn an_argument_that_is_no_text_is_an_error_and_no_panic() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let bad = OsStr::from_bytes(b"\xff");
    for options in [&[][..], &["--json"][..]] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_beeline"));
        let output = command.arg("drive").arg(bad).args(options).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let text = [output.stdout, output.stderr].concat();
        assert!(!String::from_utf8_lossy(&text).contains("panicked"), "{options:?}");
    }
}

#[test]
fn a_track_that_shows_no_drive_is_refused_and_nothing_is_changed() {
    let temp = TempFolder::new();
    temp.run("config save --flash flash").ok();
    let flash = temp.read("flash");
    temp.write("still.csv", "t_s,x_m,y_m\n0,0,0\n1,0,0\n");
    temp.write("begun.csv", "t_s,x_m,y_m\n0,0,0\n");
    for track in ["still.csv", "begun.csv"] {
        let arguments = format!("calibrate --measure track:{track} --yes --flash flash");
        let message = temp.run(&arguments).refused();
        assert!(message.contains(&format!("{track} got 0 samples during the drive")), "{message}");
        assert!(message.contains("is the tracking system running"), "{message}");
    }
    temp.write("other.csv", "t,x,y\n0,0,0\n1,0,0\n");
    for (track, expected) in
        [("nowhere.csv", "nowhere.csv: cannot read the track"), ("other.csv", "no column t_s")]
    {
        let message = temp.run(&format!("calibrate --measure track:{track} --yes")).refused();
        assert!(message.contains(expected), "{message}");
        assert!(!message.contains("Driving"), "{message}");
    }
    assert_eq!(temp.read("flash"), flash);
    assert_eq!(temp.listing(), ["begun.csv", "flash", "other.csv", "still.csv"]);
}

#[test]
fn a_robot_without_a_divider_is_told_so() {
    let temp = TempFolder::new();
    // As docs/boards.md says, in either order.
    for fields in [["supply_v_min", "supply_v_max"], ["supply_v_max", "supply_v_min"]] {
        for field in fields {
            temp.run(&format!("config set protection.{field} 0 --save --flash {}", fields[0])).ok();
        }
        let robot = format!("--flash {}", fields[0]);
        temp.run(&format!("drive straight 5cm {robot}")).ok();
    }
}
