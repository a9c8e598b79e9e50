//! Is the help of `beeline` true? Its examples, defaults and completions.

use std::path::Path;

use clap::{CommandFactory, Parser};
use host_cli::cli::Cli;

use crate::temp_folder::{TempFolder, copy, words};

/// Every command with its help, subcommands too.
fn commands() -> Vec<(String, clap::Command)> {
    fn collect(name: String, command: &clap::Command, into: &mut Vec<(String, clap::Command)>) {
        for inner in command.get_subcommands() {
            collect(format!("{name} {}", inner.get_name()), inner, into);
        }
        into.push((name, command.clone()));
    }
    let mut all = Vec::new();
    collect(String::new(), &Cli::command(), &mut all);
    all
}

/// Every example in any help, without its explanation.
fn examples() -> Vec<String> {
    let examples = |text: String| {
        let lines = text.lines().filter_map(|line| line.trim().strip_prefix("beeline"));
        let commands = lines.filter(|line| line.is_empty() || line.starts_with(' '));
        let commands = commands.map(|line| line.split("  ").next().unwrap_or_default());
        commands.map(|line| line.split(" > ").next().unwrap_or_default().trim().into()).collect()
    };
    commands()
        .iter()
        .filter_map(|(_, command)| command.get_after_help())
        .flat_map(|help| -> Vec<String> { examples(help.to_string()) })
        .collect()
}

#[test]
fn every_example_in_the_help_is_a_command() {
    let examples = examples();
    assert!(examples.len() >= 20, "{examples:#?}");
    for example in examples {
        let words = std::iter::once("beeline").chain(words(&example));
        if let Err(error) = Cli::try_parse_from(words) {
            panic!("beeline {example}: {error}");
        }
    }
}

#[test]
fn every_example_that_needs_no_hardware_runs() {
    let temp = TempFolder::new();
    // Ports, logs with names that only their own robot has, a page that is served until somebody ends it, what a shell
    // expands, and the page as one file, which takes half a minute and which tests of its own make.
    let elsewhere = [
        "/dev/",
        "tcp:",
        "--listen",
        "serve",
        "sim:",
        "/tf:",
        "encoders.csv",
        "/*/",
        "--interactive",
    ];
    let mystery = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/mystery-robot");
    temp.run_with(&["export", mystery, "--to", "mcap", "-o", "drive.mcap"], "").ok();
    temp.run("tune --record my-motors").ok();
    copy(Path::new(mystery), &temp.path("robots/one"));
    let here: Vec<_> = examples()
        .into_iter()
        .filter(|example| !elsewhere.iter().any(|port| example.contains(port)))
        .collect();
    assert!(here.len() >= 10, "{here:#?}");
    for example in here {
        let outcome = temp.run(&example);
        assert_eq!(outcome.code, Some(0), "beeline {example}: {outcome:#?}");
        // A line break within what should be one line is printed as its code.
        let texts = [&outcome.stdout, &outcome.stderr];
        assert!(
            !texts.iter().any(|text| text.contains("\\u000a")),
            "beeline {example}: {outcome:#?}"
        );
    }
}

#[test]
fn every_command_has_help_and_those_with_arguments_an_example() {
    let temp = TempFolder::new();
    for (name, command) in commands() {
        let outcome = temp.run(&format!("{name} --help")).ok();
        assert!(outcome.stdout.contains("Usage: beeline"), "{name}: {outcome:#?}");
        let required = command.get_arguments().any(clap::Arg::is_required_set);
        if required && !command.has_subcommands() {
            assert!(outcome.stdout.contains("Example"), "{name} --help has no example");
        }
    }
}

#[test]
fn completions_know_the_commands() {
    let temp = TempFolder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = temp.run(&format!("completions {shell}")).ok().stdout;
        for word in ["calibrate", "wheel-weight", "completions"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

#[test]
fn every_scenario_that_an_example_names_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let examples = examples();
    let words = examples.iter().flat_map(|example| example.split_whitespace());
    let scenarios: Vec<_> = words.filter_map(|word| word.strip_prefix("sim:")).collect();
    assert!(!scenarios.is_empty());
    for scenario in scenarios {
        assert!(root.join(scenario).is_file(), "{scenario} does not exist in the repository");
    }
}

#[test]
fn the_defaults_of_the_command_line_are_those_of_the_procedure() {
    use host_cli::calibrate::Settings;
    use host_link::motion::Motion;
    let Some(host_cli::cli::Command::Calibrate(args)) =
        Cli::try_parse_from(["beeline", "calibrate"]).unwrap().command
    else {
        panic!("`beeline calibrate` is a calibration");
    };
    let settings = Settings::default();
    // Any wheel radius will do: the comparison is in turns.
    let radius_m = 0.036;
    assert_eq!(args.distance.rev(radius_m), Motion::PAPER.distance.left);
    assert_eq!(args.distance.rev(radius_m), Motion::PAPER.distance.right);
    assert_eq!(args.profile.cruise.rev_per_s(radius_m), Motion::PAPER.cruise);
    assert_eq!(args.profile.acceleration.rev_per_s2(radius_m), Motion::PAPER.acceleration);
    assert_eq!(settings.motion, Motion::PAPER);
    assert_eq!(args.tolerance_percent / 100.0, settings.tolerance_share);
    assert_eq!(args.start_heading.rad, settings.start_heading_sigma_rad);
    assert_eq!((args.out_and_back, args.runs.unwrap_or(1)), (settings.out_and_back, settings.runs));
}
