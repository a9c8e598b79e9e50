//! What `beeline` says about itself is true.

use clap::{CommandFactory, Parser};
use host_cli::cli::Cli;

use crate::desk::Desk;

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

/// Every example in any help: the command without what is said about it.
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
        let words = std::iter::once("beeline").chain(example.split_whitespace());
        if let Err(error) = Cli::try_parse_from(words) {
            panic!("beeline {example}: {error}");
        }
    }
}

#[test]
fn every_example_that_needs_no_hardware_runs() {
    let desk = Desk::new();
    let elsewhere = ["/dev/", "tcp:", "--listen", "sim:"];
    let here: Vec<_> = examples()
        .into_iter()
        .filter(|example| !elsewhere.iter().any(|port| example.contains(port)))
        .collect();
    assert!(here.len() >= 10, "{here:#?}");
    for example in here {
        let outcome = desk.run(&example);
        assert_eq!(outcome.code, Some(0), "beeline {example}: {outcome:#?}");
    }
}

#[test]
fn every_command_has_help_and_those_with_arguments_an_example() {
    let desk = Desk::new();
    for (name, command) in commands() {
        let outcome = desk.run(&format!("{name} --help")).ok();
        assert!(outcome.stdout.contains("Usage: beeline"), "{name}: {outcome:#?}");
        let required = command.get_arguments().any(clap::Arg::is_required_set);
        if required && !command.has_subcommands() {
            assert!(outcome.stdout.contains("Example"), "{name} --help has no example");
        }
    }
}

#[test]
fn completions_know_the_commands() {
    let desk = Desk::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = desk.run(&format!("completions {shell}")).ok().stdout;
        for word in ["calibrate", "wheel-weight", "completions"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}
