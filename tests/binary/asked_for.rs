//! What a command is asked for that it does not give: it says so, and makes nothing else of it.

use serde_json::Value;

use crate::example::runs_of;
use crate::outcome::collect;
use crate::temp_folder::{TempFolder, words};

/// So much of what is wrong is repeated at most \[bytes\].
const MESSAGE_MAX: usize = 3000;

#[test]
fn a_dash_is_standard_output_or_refused_and_never_a_file() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    let before = temp.listing();
    let yaml = temp.run("export robot --to ros2").ok().stdout;
    assert_eq!(temp.run("export robot --to ros2 -o -").ok().stdout, yaml);
    for command in [
        "export robot --to mcap -o -",
        "export robot --to tum -o -",
        "report robot -o -",
        "fleet robot -o -",
        "fleet robot --table -",
        "explain robot --save -",
        "calibrate -o -",
        "record new straight 1m --mcap -",
        "tune --record -",
        "key new -",
        "import drive.mcap -o -",
        "identify --flash -",
        "sim --listen tcp:127.0.0.1:0 --camera -",
    ] {
        let outcome = temp.run(command);
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{outcome:#?}");
        let says = ["not to standard output", "no place to write to"];
        assert!(says.iter().any(|words| outcome.stderr.contains(words)), "{outcome:#?}");
    }
    assert_eq!(temp.listing(), before);
}

#[test]
fn no_result_overwrites_a_file_of_another_kind_or_one_that_was_edited() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    let robot = temp.read("robot/robot.toml");
    for (command, says) in [
        ("fleet robot -o robot/robot.toml", "must end in .html"),
        ("fleet robot --table robot/robot.toml", "must end in .csv"),
        ("report robot -o robot/robot.toml", "a report is .html, or .svg"),
        ("campaign plan -o robot/robot.toml", "robot.toml exists"),
        ("export robot --to ros2 -o robot/robot.toml", "robot.toml exists"),
    ] {
        let message = temp.run(command).refused();
        assert!(message.contains(says), "{command}: {message}");
        assert!(temp.read("robot/robot.toml") == robot, "{command}");
    }
    temp.run("campaign plan -o plan.toml").ok();
    let plan = temp.read("plan.toml");
    temp.run("campaign plan -o plan.toml").ok();
    temp.write("plan.toml", "# edited\n");
    let message = temp.run("campaign plan -o plan.toml").refused();
    assert!(message.contains("plan.toml exists") && message.contains("--force"), "{message}");
    assert_eq!(temp.read("plan.toml"), b"# edited\n");
    temp.run("campaign plan -o plan.toml --force").ok();
    assert_eq!(temp.read("plan.toml"), plan);
}

#[test]
fn json_is_json_or_refused() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    let scenario = temp.run("sim --scenario --json").ok().json();
    assert_eq!(
        scenario["name"],
        toml::from_str::<Value>(&temp.run("sim --scenario").ok().stdout).unwrap()["name"]
    );
    for command in [
        "export robot --to ros2",
        "export robot --to csv",
        "export robot --to wpilib -o -",
        "config export -",
        "campaign plan -o -",
        "completions bash",
    ] {
        let outcome = temp.run(&format!("{command} --json"));
        assert_eq!(outcome.code, Some(2), "{outcome:#?}");
        let said = outcome.json();
        assert!(said["error"].as_str().unwrap().contains("JSON"), "{command}: {said}");
    }
    assert!(temp.run("export robot --to json --json").ok().json()["wheel_radius_m"].is_f64());
}

#[test]
fn an_empty_name_of_the_keys_file_is_no_name() {
    let temp = TempFolder::new();
    let mut command = temp.command(&["identify"]);
    let outcome = collect(command.env("BEELINE_KEY_FILE", "").spawn().unwrap());
    assert_eq!(outcome.code, Some(2), "{outcome:#?}");
    assert!(outcome.stderr.contains("unset BEELINE_KEY_FILE"), "{outcome:#?}");
}

#[test]
fn an_empty_name_of_the_port_is_no_name() {
    let temp = TempFolder::new();
    let mut command = temp.command(&["identify"]);
    let outcome = collect(command.env("BEELINE_PORT", "").spawn().unwrap());
    assert_eq!(outcome.code, Some(2), "{outcome:#?}");
    assert!(outcome.stderr.contains("unset BEELINE_PORT"), "{outcome:#?}");
}

#[test]
fn what_is_wrong_is_said_in_a_few_lines_however_long_it_is() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    let long = "x".repeat(100_000);
    let run = std::fs::read_dir(temp.path("robot/runs")).unwrap().next().unwrap().unwrap().path();
    let runs = std::fs::read_to_string(&run).unwrap();
    let (head, rest) = runs.split_once('\n').unwrap();
    let toml = String::from_utf8(temp.read("robot/robot.toml")).unwrap();
    let check = |temp: &TempFolder, line: &str, code: i32| {
        for line in [line.to_owned(), format!("{line} --json")] {
            let outcome = temp.run_with(&words(&line), "");
            assert_eq!(outcome.code, Some(code), "{line:.80}");
            let said = outcome.stderr.len() + if code == 0 { 0 } else { outcome.stdout.len() };
            assert!(said < MESSAGE_MAX, "{line:.80}: {said} bytes");
            assert!(outcome.stderr.contains("100000 characters") || line.ends_with("--json"));
        }
    };
    temp.write("robot/robot.toml", &format!("{long} = 1\n{toml}"));
    check(&temp, "compare robot", 2);
    temp.write("robot/robot.toml", &toml);
    let after_time = &rest[rest.find(',').unwrap()..];
    std::fs::write(&run, format!("{head}\n{long}{after_time}")).unwrap();
    check(&temp, "compare robot", 2);
    // An unknown column is a warning.
    std::fs::write(&run, format!("{head},{long}\n{}", rest.replace('\n', ",\n"))).unwrap();
    check(&temp, "compare robot", 0);
    std::fs::write(&run, &runs).unwrap();
    temp.write("robot/model.toml", &format!("[[effect]]\nid = \"{long}\"\n"));
    check(&temp, "compare robot", 2);
    temp.write("long.toml", &format!("name = \"x\"\n{long} = 1\n"));
    check(&temp, "identify --port sim:long.toml", 2);
    check(&temp, "config import long.toml", 2);
    check(&temp, &format!("config get {long}"), 2);
    check(&temp, &format!("drive straight {long}"), 2);
}
