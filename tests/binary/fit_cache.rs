//! A campaign is fitted once by all commands, every figure is the same as without that, and nothing is reused that should not be.

use std::path::PathBuf;

use crate::example::{change_column, runs_of};
use crate::outcome::{Outcome, collect};
use crate::temp_folder::TempFolder;

/// What a user reads when a fit is reused.
const WORD: &str = "nothing has changed since the last fit";

/// Few and short: what is kept and what is made again does not depend on how long a fit takes.
const RUNS: [&str; 3] = ["out_and_back_east", "spin_slow", "arc_large_slow"];

fn robot() -> TempFolder {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &RUNS, "robot");
    temp
}

fn reuses(outcome: &Outcome) -> bool {
    outcome.stderr.contains(WORD)
}

fn kept(temp: &TempFolder) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(temp.cache("beeline")) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// The result of a command, and the page if it writes one.
fn result(temp: &TempFolder, command: &str) -> (Outcome, Vec<u8>) {
    let outcome = temp.run(command).ok();
    let page = temp.path("report.html");
    let bytes = std::fs::read(&page).unwrap_or_default();
    let _ = std::fs::remove_file(page);
    (outcome, bytes)
}

#[test]
fn explain_report_apply_and_compare_fit_once_and_every_figure_is_that_of_a_fresh_fit() {
    let temp = robot();
    for (number, command) in [
        "explain robot",
        "explain robot --format json",
        "explain robot --tolerance 5mm --json",
        "report robot -o report.html",
        "report robot -o report.html --interactive",
        "apply robot --yes",
        "apply robot --yes --json",
        "compare robot",
        "compare robot --format json",
    ]
    .into_iter()
    .enumerate()
    {
        let (fresh, fresh_page) = result(&temp, &format!("{command} --no-cache"));
        assert!(!reuses(&fresh) && fresh.stdout.len() + fresh_page.len() > 40, "{fresh:#?}");
        let (outcome, page) = result(&temp, command);
        assert_eq!(outcome.stdout, fresh.stdout, "{command}");
        assert!(page == fresh_page, "{command}");
        // The first one has to fit. With --json, nothing is said.
        let says = usize::from(number > 0 && !command.contains("--json"));
        assert_eq!(outcome.stderr.matches(WORD).count(), says, "{command}: {outcome:#?}");
        assert_eq!(kept(&temp).len(), 2, "{command}");
    }
    assert_eq!(temp.listing(), ["robot"]);
}

#[test]
fn a_comparison_keeps_its_noise_and_explain_that_of_a_comparison() {
    let temp = robot();
    assert!(!reuses(&temp.run("compare robot").ok()));
    assert!(reuses(&temp.run("compare robot").ok()));
    assert!(!reuses(&temp.run("explain robot").ok()));
    assert_eq!(kept(&temp).len(), 2);
}

#[test]
fn whatever_a_fit_depends_on_it_is_made_again_if_that_changes() {
    const OWN: &str = "[[custom]]\nid = \"mine\"\ntarget = \"dtheta\"\nper = \"second\"\nexpression = \"k * v\"\nunit.k = \"1/m\"\n";
    let temp = robot();
    let edit = |name: &str, from: &str, to: &str| {
        let text = String::from_utf8(temp.read(name)).unwrap();
        assert!(text.contains(from), "{text}");
        temp.write(name, &text.replace(from, to));
    };
    let changes: [(&str, &dyn Fn()); 7] = [
        ("one pose of a run", &|| {
            change_column(&temp, "robot", "x_m", |x_m| (x_m + 1e-9).to_string());
        }),
        ("a number of robot.toml", &|| {
            edit("robot/robot.toml", "track_width_m = 0.372", "track_width_m = 0.3720001");
        }),
        ("a noise of robot.toml", &|| {
            edit("robot/robot.toml", "heading_sigma_rad = 0.002", "");
        }),
        ("a run that is held out", &|| {
            let name = "02_out_and_back_east";
            let text = format!("\n[[run]]\nname = \"{name}\"\nheld_out = true\n");
            let robot = String::from_utf8(temp.read("robot/robot.toml")).unwrap();
            temp.write("robot/robot.toml", &(robot + &text));
        }),
        ("an own effect", &|| temp.write("robot/model.toml", OWN)),
        ("its equation", &|| edit("robot/model.toml", "k * v", "2 * k * v")),
        ("its range", &|| {
            edit("robot/model.toml", "unit.k = \"1/m\"", "range.k = [-0.1, 0.1]");
        }),
    ];
    temp.run("explain robot").ok();
    for (what, change) in changes {
        change();
        for command in ["explain robot", "compare robot"] {
            let fresh = temp.run(&format!("{command} --no-cache")).ok();
            let first = temp.run(command).ok();
            // What `explain` finds is what `compare` needs.
            assert_eq!(reuses(&first), command == "compare robot", "{what}: {first:#?}");
            assert_eq!(first.stdout, fresh.stdout, "{what}");
            assert!(reuses(&temp.run(command).ok()), "{what}");
        }
    }
    // What the model has already is asked for: another question of the same runs, with the same noise.
    temp.run("model add track_width robot").ok();
    assert!(!reuses(&temp.run("explain robot").ok()));
    assert!(reuses(&temp.run("compare robot").ok()));
    // The name of the robot is in no number.
    edit("robot/robot.toml", "mystery robot", "other robot");
    assert!(reuses(&temp.run("explain robot").ok()));
}

#[test]
fn a_damaged_file_is_fitted_again_and_replaced() {
    let temp = robot();
    let fresh = temp.run("compare robot").ok();
    let [file] = &kept(&temp)[..] else { panic!("one file") };
    let whole = std::fs::read(file).unwrap();
    let mut flipped = whole.clone();
    *flipped.last_mut().unwrap() ^= 1;
    for damaged in [&flipped[..], &whole[..whole.len() / 2], &[], &[0; 4096]] {
        std::fs::write(file, damaged).unwrap();
        let again = temp.run("compare robot").ok();
        assert!(!reuses(&again), "{again:#?}");
        assert_eq!(again.stdout, fresh.stdout);
        assert_eq!(std::fs::read(file).unwrap(), whole);
    }
}

#[test]
fn without_a_place_to_keep_it_a_campaign_is_fitted_each_time() {
    let temp = robot();
    let compared = |place: Option<PathBuf>| {
        let mut command = temp.command(&["compare", "robot"]);
        command.env_remove("HOME").env_remove("XDG_CACHE_HOME").env_remove("LOCALAPPDATA");
        place.into_iter().for_each(|place| {
            command.env("XDG_CACHE_HOME", place);
        });
        collect(command.spawn().unwrap()).ok()
    };
    temp.write("file", "");
    // Nowhere, in a file, in what nobody can write, and where the command happens to run.
    for place in [None, Some(temp.path("file")), Some("/proc/none".into()), Some("here".into())] {
        for _ in 0..2 {
            assert!(!reuses(&compared(place.clone())), "{place:?}");
        }
    }
    assert_eq!(temp.listing(), ["file", "robot"]);
}

#[test]
fn processes_at_once_find_the_same_and_leave_whole_files() {
    let temp = robot();
    let fresh = temp.run("explain robot --no-cache").ok().stdout;
    for _ in 0..2 {
        let children: Vec<_> = (0..4).map(|_| temp.spawn(&["explain", "robot"])).collect();
        for child in children {
            assert_eq!(collect(child).ok().stdout, fresh);
        }
    }
    let names: Vec<String> =
        kept(&temp).iter().map(|file| file.extension().unwrap().to_string_lossy().into()).collect();
    assert_eq!(names, ["fit", "fit"]);
    assert!(reuses(&temp.run("explain robot").ok()));
}
