//! Is what the pages say of `beeline` true? Every `.md` file of the root and of `docs/`.
//!
//! Command lines and flags are checked against the parser, keys of the configuration and of scenarios against the
//! program's own; examples of a campaign's files are read by it. Paths and links are checked by `cargo xtask check`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use host_cli::cli::Cli;
use pulldown_cmark::{Event, Parser as Markdown, Tag, TagEnd};
use shared_proto::Config;
use sim_target::Scenario;

use crate::temp_folder::TempFolder;

/// Code in a page: between backquotes, or a line of a fenced block.
#[derive(Debug)]
struct Code {
    text: String,
    is_block: bool,
}

fn code_in(page: &str) -> Vec<Code> {
    let mut code = Vec::new();
    let mut is_block = false;
    for event in Markdown::new_ext(page, pulldown_cmark::Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::CodeBlock(_)) => is_block = true,
            Event::End(TagEnd::CodeBlock) => is_block = false,
            Event::Code(text) => code.push(Code { text: text.to_string(), is_block: false }),
            Event::Text(text) if is_block => {
                let lines = text.lines().map(|line| Code { text: line.into(), is_block });
                code.extend(lines);
            }
            _ => {}
        }
    }
    code
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// All pages: names and texts.
fn pages() -> Vec<(String, String)> {
    let mut pages = Vec::new();
    for folder in ["", "docs", "docs/boards", "examples/mystery-robot", "examples/optiodom"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let file = entry.unwrap().path();
            if file.extension().is_some_and(|end| end == "md") {
                let name = file.strip_prefix(root()).unwrap().display().to_string();
                pages.push((name, std::fs::read_to_string(&file).unwrap()));
            }
        }
    }
    assert!(pages.len() >= 10, "{}", pages.len());
    pages
}

/// The findings of one check in all pages.
fn findings(check: impl Fn(&Code) -> Option<String>) -> Vec<String> {
    let mut findings = Vec::new();
    for (name, page) in pages() {
        let wrong = code_in(&page).into_iter().filter_map(|code| check(&code));
        findings.extend(wrong.map(|wrong| format!("{name}: {wrong}")));
    }
    findings
}

/// A command line's words as a shell splits them, up to a comment or the next program.
fn shell_words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for c in line.chars() {
        match quote {
            Some(end) if c == end => quote = None,
            None if c == '"' || c == '\'' => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            None if c.is_whitespace() => words.extend(word.take()),
            None if word.is_none() && "#|>&;\\".contains(c) => return words,
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

/// The parser's error for a command line of `beeline`. A line of a block is complete; in running text a command may
/// lack its arguments, and a value in capitals stands for one of the reader's.
fn refusal(code: &Code) -> Option<String> {
    let line = code.text.trim();
    let line = line.strip_prefix("$ ").unwrap_or(line);
    let words = shell_words(line);
    if words.first()? != "beeline" {
        return None;
    }
    let is_elided = words.iter().any(|word| word == "...");
    let words = words.iter().filter(|word| *word != "...");
    let error = Cli::try_parse_from(words.clone()).err()?;
    let is_placeholder = |word: &String| {
        let last = word.rsplit(':').next().unwrap_or_default();
        last.len() > 1 && last.chars().all(|c| c.is_ascii_uppercase() || c == '_')
    };
    let is_fine = match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => true,
        ErrorKind::MissingRequiredArgument
        | ErrorKind::MissingSubcommand
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => is_elided || !code.is_block,
        ErrorKind::InvalidValue if words.clone().next_back()?.starts_with('-') => !code.is_block,
        ErrorKind::InvalidValue | ErrorKind::ValueValidation => words.clone().any(is_placeholder),
        _ => false,
    };
    (!is_fine).then(|| format!("`{line}`: {error}"))
}

/// Every flag of every command.
fn flags() -> BTreeSet<String> {
    fn collect(command: &clap::Command, into: &mut BTreeSet<String>) {
        let long = command.get_arguments().filter_map(clap::Arg::get_long);
        into.extend(long.map(|name| format!("--{name}")));
        command.get_subcommands().for_each(|inner| collect(inner, into));
    }
    let mut flags = BTreeSet::from(["--help".to_string(), "--version".to_string()]);
    collect(&Cli::command(), &mut flags);
    flags
}

/// Flags of other programs that the pages name alone: `cargo run --config`.
const OTHERS: [&str; 1] = ["--config"];

/// A flag that stands alone and that no command has.
fn unknown_flag(code: &Code) -> Option<String> {
    let flag = code.text.split([' ', '=']).next()?;
    let is_flag = !code.is_block && flag.starts_with("--");
    let is_known = || flags().contains(flag) || OTHERS.contains(&flag);
    (is_flag && !is_known()).then(|| format!("`{}`: no command has this flag", code.text))
}

/// A dotted name that is a key neither of the configuration nor of a scenario.
fn unknown_key(code: &Code) -> Option<String> {
    let key = if code.is_block {
        // In a block, only the arguments of `config set`.
        let words = shell_words(&code.text);
        let set = words.iter().position(|word| word == "config")?;
        words.get(set + 2).filter(|_| words.get(set + 1).is_some_and(|word| word == "set"))?.clone()
    } else {
        code.text.split(" = ").next()?.to_string()
    };
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_*".contains(c);
    let mut parts = key.split('.');
    let is_key = key.contains('.')
        && parts.all(|part| !part.is_empty() && part.chars().all(plain))
        && key.starts_with(|c: char| c.is_ascii_lowercase());
    let is_file =
        [".rs", ".md", ".toml", ".csv", ".svg", ".html", ".json", ".txt", ".py", ".sealed"]
            .iter()
            .any(|end| key.ends_with(end));
    if !is_key || is_file || is_config_key(&key) || is_scenario_key(&key) {
        return None;
    }
    Some(format!("`{key}`: no key of the configuration, nor of a scenario"))
}

fn is_config_key(key: &str) -> bool {
    let left = key.replace('*', "left");
    Config::FIELDS.iter().any(|field| field.path == left) || {
        // Keys that are not numbers are not in the table of fields, but they are in the file.
        let value = toml::Value::try_from(Config::default()).expect("a configuration is TOML");
        left.split('.').try_fold(&value, |value, part| value.get(part)).is_some()
    }
}

/// Whether a scenario may have this key, at its top or under `[plant]`.
fn is_scenario_key(key: &str) -> bool {
    let left = key.replace('*', "left");
    let is_known = |key: String| {
        let parsed = Scenario::parse("page", &format!("name = 'page'\n{key} = 1\n"));
        !parsed.is_err_and(|error| error.problem.contains("unknown field"))
    };
    is_known(left.clone()) || is_known(format!("plant.{left}"))
}

#[test]
fn every_command_line_is_one() {
    let code = pages().into_iter().flat_map(|(_, page)| code_in(&page));
    let lines = code.filter(|code| code.text.trim_start_matches("$ ").starts_with("beeline "));
    assert!(lines.count() >= 40);
    let findings = findings(refusal);
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

#[test]
fn every_flag_is_one_of_a_command() {
    let findings = findings(unknown_flag);
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

#[test]
fn every_key_is_one_of_the_configuration_or_of_a_scenario() {
    let findings = findings(unknown_key);
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

/// The findings of a check in a page with only this text.
fn planted(page: &str, check: impl Fn(&Code) -> Option<String>) -> Vec<String> {
    code_in(page).iter().filter_map(check).collect()
}

#[test]
fn a_planted_command_line_flag_or_key_is_found() {
    for page in [
        "Then `beeline calibarte`.",
        "Then `beeline calibrate --undoo`.",
        "```sh\nbeeline explain my-robot --fromat json   # for machines\n```",
        "```console\n$ beeline explain my-robot --format yaml\n```",
        "```sh\nbeeline wheel-weight --dx 2.525cm extra\n```",
        "```sh\nbeeline explain\n```",
    ] {
        assert_eq!(planted(page, refusal).len(), 1, "{page}");
    }
    for page in [
        "`beeline calibrate`, `beeline config set`, `beeline model add --custom`, `beeline --json ...`, `beeline-like`",
        "`beeline calibrate --measure track:FILE`, `beeline drive straight 1rev --port PORT`",
        "```sh\nbeeline explain my-robot --format json > answer.json   # for machines\n```",
    ] {
        assert_eq!(planted(page, refusal), [""; 0], "{page}");
    }
    assert_eq!(planted("`--undoo`", unknown_flag).len(), 1);
    assert_eq!(planted("`--undo`, `--runs 4`", unknown_flag), [""; 0]);
    for page in [
        "Set `geometry.wheel_diameter_m`.",
        "`encoder.left.counts` stands for it",
        "`tyre.stiffness_n_per_m`",
        "```sh\nbeeline config set geometry.wheel_diameter_m 0.072\n```",
    ] {
        assert_eq!(planted(page, unknown_key).len(), 1, "{page}");
    }
    let page = "`geometry.wheel_radius_m`, `encoder.left.reversed`, `tyre.contact_width_m`, \
                `wheel.*.eccentricity`, `robot.toml`, `5.0x`, `plant.gear.right.backlash_rad`";
    assert_eq!(planted(page, unknown_key), [""; 0]);
}

/// The first block of TOML below a heading of a page.
fn block(page: &str, heading: &str) -> String {
    let page = std::fs::read_to_string(root().join(page)).unwrap();
    let (_, below) = page.split_once(&format!("\n## {heading}\n")).expect("the heading");
    let (_, block) = below.split_once("```toml\n").expect("a block of TOML");
    block.split_once("```").expect("its end").0.to_string()
}

#[test]
fn the_robot_and_the_plan_of_the_campaigns_page_are_read() {
    let temp = TempFolder::new();
    temp.run("record my-robot straight 1rev --json").ok();
    let runs = std::fs::read_dir(temp.path("my-robot/runs")).unwrap();
    let runs: Vec<PathBuf> = runs.map(|entry| entry.unwrap().path()).collect();
    let [run] = &runs[..] else { panic!("one run: {runs:?}") };
    let run = run.file_stem().unwrap().to_str().unwrap();
    // The page's run, with a recorded one in its place.
    let robot = block("docs/campaign.md", "robot.toml")
        .replace("01_straight", run)
        .replace("held_out = true", "held_out = false");
    temp.write("my-robot/robot.toml", &robot);
    temp.run("compare my-robot").ok();
    temp.write("my-robot/robot.toml", &robot.replace("payload_kg", "payload"));
    assert!(temp.run("compare my-robot").refused().contains("payload"));

    let plan = block("docs/campaign.md", "plan.toml");
    temp.write("plan.toml", &plan);
    temp.run("campaign record other --plan plan.toml").ok();
    temp.write("plan.toml", &plan.replace("heading_deg", "heading"));
    assert!(temp.run("campaign record other --plan plan.toml").refused().contains("heading"));
}
