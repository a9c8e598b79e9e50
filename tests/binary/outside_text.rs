//! Text from outside, wherever it comes from and wherever it goes: shown, never obeyed.

use std::path::Path;
use std::process::Command;

use ::import::log::Pose3;
use ::import::mcap::BagWriter;
use ::import::message::{encode_joints, encode_pose};

use crate::outcome::{Outcome, collect};
use crate::temp_folder::{TempFolder, words};

/// What a terminal, a page or a shell would obey: a title, an erased screen, reversed text, a line of its own, markup, commands.
const EVIL: &str =
    "\u{1b}]0;x\u{7}\u{9b}2J\u{202e}\r\nerror: <b>'\"$(touch owned)`touch owned`;touch owned;";

/// How its beginning is shown.
const SHOWN: &str = r"\u001b]0;x\u0007\u009b2J\u202e\u000d\u000aerror: ";

/// How the name of a robot is shown: the link has made question marks of the control characters.
const SHOWN_NAME: &str = r"?]0;x\u202e?2J";

/// As a TOML string, without its quotes.
fn in_toml() -> String {
    EVIL.chars()
        .map(|c| match c {
            '"' => "\\\"".into(),
            c if c.is_control() || c == '\u{202e}' => format!("\\u{:04x}", c as u32),
            c => c.to_string(),
        })
        .collect()
}

/// Where the text comes from: puts it into a recorded campaign `robot`.
type Source = (&'static str, fn(&TempFolder));

fn edit(temp: &TempFolder, file: &str, change: impl Fn(&str) -> String) {
    let text = String::from_utf8(temp.read(file)).unwrap();
    temp.write(file, &change(&text));
}

fn add(temp: &TempFolder, file: &str, text: &str) {
    let there = std::fs::read_to_string(temp.path(file)).unwrap_or_default();
    temp.write(file, &(there + text));
}

const RUN: &str = "robot/runs/01_straight.csv";

/// A straight drive as a bag, with names of the sender's own: of the topic with poses, and of the joints.
fn bag([topic, joint]: [&str; 2]) -> Vec<u8> {
    let mut bag = BagWriter::new(Vec::new()).unwrap();
    let joints = bag.channel("/joints", "sensor_msgs/msg/JointState", "");
    let poses = bag.channel(topic, "geometry_msgs/msg/PoseStamped", "");
    let names = ["left", "right"].map(|side| format!("{side}{joint}"));
    for k in 0..400 {
        let t_s = 1.0 + 0.02 * f64::from(k);
        // Two seconds at rest at both ends.
        let turned_rad = 0.16 * f64::from((k - 100).clamp(0, 200));
        let turned = names.each_ref().map(|name| (name.as_str(), turned_rad));
        bag.message(joints, t_s, &encode_joints(t_s, &turned)).unwrap();
        let position_m = [0.036 * turned_rad, 0.0, 0.0];
        let pose = Pose3 { t_s, position_m, orientation: Some([0.0, 0.0, 0.0, 1.0]) };
        bag.message(poses, t_s, &encode_pose("map", &pose)).unwrap();
    }
    bag.finish().unwrap()
}

fn put_bag(temp: &TempFolder, names: [&str; 2]) {
    std::fs::write(temp.path("evil.mcap"), bag(names)).unwrap();
}

const SOURCES: [Source; 16] = [
    ("a topic of a bag", |temp| put_bag(temp, [EVIL, ""])),
    ("a joint of a bag", |temp| put_bag(temp, ["/poses", EVIL])),
    ("a column's name", |temp| {
        let column = format!("\"{}\"", EVIL.replace('"', "\"\""));
        edit(temp, RUN, |text| {
            text.replace('\n', ",0\n").replacen(",0\n", &format!(",{column}\n"), 1)
        });
    }),
    ("a cell", |temp| {
        let cell = format!("\"{}\"", EVIL.replace('"', "\"\""));
        edit(temp, RUN, |text| text.replacen("\n0.000000,", &format!("\n{cell},"), 1));
    }),
    ("a run's file name", |temp| {
        let name = temp.path("robot/runs").join(format!("01_{EVIL}.csv"));
        std::fs::rename(temp.path(RUN), name).unwrap();
    }),
    ("a file that is no run", |temp| {
        std::fs::write(temp.path("robot/runs").join(format!("{EVIL}.CSV")), "").unwrap();
    }),
    ("a run without its file", |temp| {
        add(temp, "robot/robot.toml", &format!("\n[[run]]\nname = \"{}\"\n", in_toml()));
    }),
    ("the robot's name", |temp| {
        edit(temp, "robot/robot.toml", |text| text.replace("unnamed robot", &in_toml()));
    }),
    ("an unknown key", |temp| {
        edit(temp, "robot/robot.toml", |text| format!("\"{}\" = 1\n{text}", in_toml()));
    }),
    ("the scenario", |temp| {
        edit(temp, "robot/robot.toml", |text| {
            text.replace("[simulated]", &format!("[simulated]\nscenario = \"{}\"", in_toml()))
        });
    }),
    ("a model's effect", |temp| {
        temp.write("robot/model.toml", &format!("[[effect]]\nid = \"{}\"\n", in_toml()));
    }),
    ("a custom effect's id", |temp| {
        let custom = format!(
            "[[custom]]\nid = \"{}\"\ntarget = \"dtheta\"\nper = \"metre\"\nexpression = \"k\"\n",
            in_toml()
        );
        temp.write("robot/model.toml", &custom);
    }),
    ("an expression", |temp| {
        let custom = format!(
            "[[custom]]\nid = \"mine\"\ntarget = \"dtheta\"\nper = \"metre\"\nexpression = \"{}\"\n",
            in_toml()
        );
        temp.write("robot/model.toml", &custom);
    }),
    ("what a planned run shows", |temp| {
        temp.run("campaign plan -o plan.toml").ok();
        edit(temp, "plan.toml", |text| {
            let line = text.lines().find(|line| line.starts_with("shows")).unwrap();
            text.replacen(line, &format!("shows = \"{}\"", in_toml()), 1)
        });
    }),
    ("a scenario's key", |temp| {
        temp.write("evil.toml", &format!("name = \"x\"\n\"{}\" = 1\n", in_toml()));
    }),
    ("the name that a robot sends", |temp| {
        temp.run("config set name plain --save --flash flash").ok();
        edit(temp, "flash", |text| text.replace("\"plain\"", "\"\\u001b]0;x\\u202e\\u009b2J\""));
    }),
];

/// Where it goes.
const SINKS: [&str; 20] = [
    "compare robot",
    "compare robot --json",
    "explain robot",
    "explain robot --json",
    "model show robot",
    "report robot -o page.html",
    "campaign plan --plan plan.toml",
    "identify --flash flash",
    "identify --flash flash --json",
    "identify --port sim:evil.toml",
    "export robot --to ros2",
    "export robot --to turtlebot3",
    "export robot --to linorobot2",
    "export robot --to wpilib",
    "export robot --to json",
    "export robot --to csv",
    "fleet robot -o fleet.html",
    "fleet robot --json",
    "import evil.mcap",
    "import evil.mcap -o imported --wheel-radius 36mm --track-width 37.2cm",
];

/// The pages that they write.
const PAGES: [&str; 3] = ["page.html", "fleet.html", "imported/import.html"];

/// The command as on a terminal, where codes are not taken out.
fn on_terminal(temp: &TempFolder, arguments: &str) -> Outcome {
    let mut child = temp.command(&words(arguments));
    collect(child.env("CLICOLOR_FORCE", "1").spawn().unwrap())
}

/// What a terminal would obey, of which none may be left; Beeline's own styles aside.
fn obeyed(text: &str) -> Option<char> {
    let mut text = text.to_owned();
    for code in ["\u{1b}[0m", "\u{1b}[1m", "\u{1b}[2m", "\u{1b}[31m", "\u{1b}[32m", "\u{1b}[33m"] {
        text = text.replace(code, "");
    }
    text.chars().find(|c| (c.is_control() && *c != '\n') || *c == '\u{202e}')
}

/// Two short simulated drives.
fn recorded() -> TempFolder {
    let temp = TempFolder::new();
    temp.run("record robot straight 1m").ok();
    temp.run("record robot straight 1m").ok();
    temp
}

#[test]
fn no_text_from_outside_is_obeyed_wherever_it_comes_from_and_goes() {
    let clean = recorded();
    for (source, put) in SOURCES {
        let temp = TempFolder::new();
        copy(&clean.path("robot"), &temp.path("robot"));
        put(&temp);
        let mut shown = Vec::new();
        for sink in SINKS {
            let is_given =
                |word: &str, file: &str| !sink.contains(word) || temp.path(file).exists();
            if !is_given("plan.toml", "plan.toml")
                || !is_given("flash", "flash")
                || !is_given("evil.toml", "evil.toml")
                || !is_given("evil.mcap", "evil.mcap")
            {
                continue;
            }
            let outcome = on_terminal(&temp, sink);
            for text in [&outcome.stdout, &outcome.stderr] {
                assert_eq!(obeyed(text), None, "{source} -> {sink}: {text:?}");
                assert!(
                    !text.lines().any(|line| line.starts_with("error: <b>")),
                    "{source} -> {sink}: {text}"
                );
            }
            if sink.contains("--json") {
                outcome.json();
            }
            let pages = PAGES.map(|page| std::fs::read_to_string(temp.path(page)));
            let page = pages.into_iter().flatten().collect::<String>();
            assert_eq!(obeyed(&page), None, "{source} -> {sink}");
            assert!(!page.contains("<b>'"), "{source} -> {sink}");
            let all = outcome.stdout + &outcome.stderr + &page;
            if all.contains(&SHOWN[..20]) || all.contains(SHOWN_NAME) {
                shown.push(sink);
            }
        }
        assert!(!shown.is_empty(), "{source} reached no sink: the row says nothing");
        assert!(!temp.path("owned").exists(), "{source}");
    }
}

/// The next command is meant to be copied: a shell that runs it must see one word for each word, and run nothing else.
#[test]
fn a_suggested_command_can_be_pasted_whatever_the_names_in_it() {
    let temp = TempFolder::new();
    let folder = "it's $(touch owned) \"`touch owned`\"";
    copy(&recorded().path("robot"), &temp.path(folder));
    let toml = temp.path(folder).join("robot.toml");
    let text = std::fs::read_to_string(&toml).unwrap();
    let scenario = format!("[simulated]\nscenario = \"{}\"", in_toml());
    std::fs::write(&toml, text.replace("[simulated]", &scenario)).unwrap();
    let outcome = temp.run_with(&["explain", folder], "").ok();
    let suggested = outcome.stdout.lines().map(str::trim).find(|line| line.starts_with("beeline "));
    let suggested = suggested.unwrap_or_else(|| panic!("no command: {outcome:#?}"));
    let script = format!("beeline() {{ printf '[%s]\\n' \"$@\"; }}\n{suggested}\n");
    let output =
        Command::new("sh").args(["-c", &script]).current_dir(temp.path(".")).output().unwrap();
    let read = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{suggested}: {output:?}");
    assert!(read.starts_with(&format!("[campaign]\n[record]\n[{folder}]\n[--run]\n")), "{read}");
    assert!(read.contains("[--port]\n[sim:"), "{read}");
    assert!(!temp.path("owned").exists(), "{suggested}");
}

/// A value that begins like an option is given in one word with its own.
#[test]
fn a_name_that_begins_like_an_option_is_none() {
    let temp = TempFolder::new();
    let mut bag = BagWriter::new(Vec::new()).unwrap();
    let joints = bag.channel("/joints", "sensor_msgs/msg/JointState", "");
    let poses = bag.channel("--flash=owned", "geometry_msgs/msg/PoseStamped", "");
    for second in 0..3 {
        let t_s = f64::from(second);
        let turned = [("-left_wheel", t_s), ("-right_wheel", t_s)];
        bag.message(joints, t_s, &encode_joints(t_s, &turned)).unwrap();
        let pose = Pose3 { t_s, position_m: [0.036 * t_s, 0.0, 0.0], orientation: None };
        bag.message(poses, t_s, &encode_pose("map", &pose)).unwrap();
    }
    std::fs::write(temp.path("drive.mcap"), bag.finish().unwrap()).unwrap();
    let listed = temp.run("import drive.mcap").ok().stdout;
    let proposed = listed.lines().last().unwrap();
    assert!(proposed.contains(" --wheels=-left_wheel,-right_wheel "), "{listed}");
    assert!(proposed.contains(" --pose=--flash=owned "), "{listed}");
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to.join("runs")).unwrap();
    for file in ["robot.toml", "runs/01_straight.csv", "runs/02_straight.csv"] {
        std::fs::copy(from.join(file), to.join(file)).unwrap();
    }
}
