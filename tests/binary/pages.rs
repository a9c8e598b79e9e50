//! Is what the pages say of `beeline` true? Every `.md` file of the root, of `docs/` and of `examples/`.
//!
//! Command lines and flags are checked against the parser, dotted keys, and those of `config set`, against the
//! program's own. A key without a dot may be of a campaign's files, a fault, or a column: the sources have to know the
//! word. Examples of a campaign's files are read by the program. Paths and links are checked by `cargo xtask check`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use host_cli::cli::Cli;
use shared_proto::Config;
use sim_target::Scenario;

use crate::page_code::{Code, code_in, shell_commands, shell_words};
use crate::temp_folder::TempFolder;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// All pages: names and texts.
fn pages() -> Vec<(String, String)> {
    let mut pages = Vec::new();
    let mut open = vec![root()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let file = entry.unwrap().path();
            if file.is_dir()
                && (folder != root() || file.ends_with("docs") || file.ends_with("examples"))
            {
                open.push(file);
            } else if file.extension().is_some_and(|end| end == "md") {
                let name = file.strip_prefix(root()).unwrap().display().to_string();
                pages.push((name, std::fs::read_to_string(&file).unwrap()));
            }
        }
    }
    assert!(pages.len() >= 25, "{}", pages.len());
    pages
}

/// The findings of one check in all pages.
fn findings(check: impl Fn(&Code) -> Option<String>) -> Vec<String> {
    pages().iter().flat_map(|(name, page)| findings_in(name, page, &check)).collect()
}

fn findings_in(name: &str, page: &str, check: impl Fn(&Code) -> Option<String>) -> Vec<String> {
    let wrong = |code: &Code| Some(format!("{name}:{}: {}", code.line, check(code)?));
    code_in(page).iter().filter_map(wrong).collect()
}

/// The parser's error for a command line of `beeline`. A line of a block is complete; in running text a command may
/// lack its arguments, and a value in capitals stands for one of the reader's.
fn refusal(code: &Code) -> Option<String> {
    let line = code.text.trim();
    let line = line.strip_prefix("$ ").unwrap_or(line);
    shell_commands(line).iter().find_map(|words| refusal_of(words, line, code.is_block))
}

fn refusal_of(words: &[String], line: &str, is_block: bool) -> Option<String> {
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
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => is_elided || !is_block,
        ErrorKind::InvalidValue if words.clone().next_back()?.starts_with('-') => !is_block,
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

/// A flag that stands alone, or behind another one, and that no command has.
fn unknown_flag(code: &Code) -> Option<String> {
    if code.is_block || !code.text.starts_with("--") {
        return None;
    }
    let words = shell_words(&code.text);
    let mut flags_here = words.iter().filter_map(|word| word.split('=').next());
    let known = flags();
    let is_known = |flag: &str| known.contains(flag) || OTHERS.contains(&flag);
    let unknown = flags_here.find(|flag| flag.starts_with("--") && !is_known(flag))?;
    Some(format!("`{}`: no command has a flag `{unknown}`", code.text))
}

/// The arguments of `config set` and `config get`, wherever they stand.
fn unknown_argument(code: &Code) -> Option<String> {
    let words = shell_words(&code.text);
    let config = words.iter().position(|word| word == "config")?;
    let is_key = words.get(config + 1).is_some_and(|word| word == "set" || word == "get");
    let key = words.get(config + 2).filter(|word| is_key && !word.starts_with('-'))?;
    let is_placeholder = key.chars().all(|c| c.is_ascii_uppercase());
    (!is_placeholder && !is_config_key(key))
        .then(|| format!("`{key}`: no key of the configuration"))
}

/// A dotted name that is a key neither of the configuration nor of a scenario.
fn unknown_key(code: &Code) -> Option<String> {
    if code.is_block {
        return None;
    }
    let key = code.text.split(" = ").next()?;
    let mut parts = key.split('.');
    let is_key = key.contains('.')
        && parts.all(|part| !part.is_empty() && part.chars().all(is_plain))
        && key.starts_with(|c: char| c.is_ascii_lowercase());
    let is_file = [
        ".rs", ".md", ".toml", ".csv", ".svg", ".html", ".json", ".txt", ".py", ".sealed", ".yaml",
        ".h",
    ]
    .iter()
    .any(|end| key.ends_with(end));
    let is_known = FOREIGN.contains(&key) || is_config_key(key) || is_scenario_key(key);
    if !is_key || is_file || is_known {
        return None;
    }
    Some(format!("`{key}`: no key of the configuration, nor of a scenario"))
}

fn is_plain(c: char) -> bool {
    c.is_ascii_lowercase() || c.is_ascii_digit() || "_*".contains(c)
}

/// Names that are not ours: the controllers of ROS.
const FOREIGN: [&str; 4] =
    ["diff_drive_controller", "wheels.radius", "wheels.separation", "odometry.use_imu"];

/// A name without a dot that no source has: one with `_` or before ` = `, and each part of the keys in a block of TOML.
fn unknown_word(code: &Code, known: &BTreeSet<String>) -> Option<String> {
    let text = code.text.split(" #").next()?;
    let mut keys: Vec<&str> = text.split(" = ").collect();
    let last = keys.pop()?;
    let names: Vec<&str> = match (code.is_block, &keys[..]) {
        (false, []) if last.contains('_') => vec![last],
        (false, [key, ..]) => vec![*key],
        // In front of each `=` of an inline table, too.
        (true, keys) if code.is_toml => {
            keys.iter().filter_map(|key| key.rsplit([' ', '{']).next()).collect()
        }
        _ => return None,
    };
    // `_um` is the end of names.
    let is_name = |name: &&str| {
        name.starts_with(|c: char| c.is_ascii_lowercase())
            && name.chars().all(|c| is_plain(c) || c == '.')
    };
    let mut parts = names.into_iter().filter(is_name).flat_map(|name| name.split('.'));
    let is_known = |part: &str| part.contains('*') || known.contains(part);
    let unknown = parts.find(|part| !is_known(part) && !FOREIGN.contains(part))?;
    Some(format!("`{unknown}`: no source has this name"))
}

/// All words of the sources and of the files beside them, but not of this one, which plants mistakes.
fn words_of_sources() -> BTreeSet<String> {
    let crates = std::fs::read_dir(root()).unwrap().map(|entry| entry.unwrap().path());
    let mut open: Vec<PathBuf> = crates.filter(|path| path.join("Cargo.toml").exists()).collect();
    let mut words = BTreeSet::new();
    while let Some(path) = open.pop() {
        if path.ends_with("target") {
            continue;
        }
        if path.is_dir() {
            open.extend(std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|end| end == "rs" || end == "toml")
            && !path.ends_with("tests/binary/pages.rs")
        {
            let text = std::fs::read_to_string(&path).unwrap();
            let names = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
            words.extend(names.filter(|name| !name.is_empty()).map(String::from));
        }
    }
    words
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
    let mut found = findings(unknown_key);
    found.extend(findings(unknown_argument));
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn every_name_without_a_dot_is_one_of_the_sources() {
    let known = words_of_sources();
    assert!(known.contains("payload_kg") && !known.contains("payload_kgg"));
    let found = findings(|code| unknown_word(code, &known));
    assert!(found.is_empty(), "{}", found.join("\n"));
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
    assert_eq!(planted("`--seed 7 --undoo`", unknown_flag).len(), 1);
    assert_eq!(planted("`--undo`, `--runs 4`", unknown_flag), [""; 0]);
    for page in [
        "Set `geometry.wheel_diameter_m`.",
        "`encoder.left.counts` stands for it",
        "`tyre.stiffness_n_per_m`",
    ] {
        assert_eq!(planted(page, unknown_key).len(), 1, "{page}");
    }
    for page in [
        "```sh\nbeeline config set geometry.wheel_diameter_m 0.072\n```",
        "`beeline config set wheel_radius_m 0.036`",
        "`config get geometri`",
    ] {
        assert_eq!(planted(page, unknown_argument).len(), 1, "{page}");
    }
    let page = "`config set KEY VALUE`, `beeline config get`, `config get encoder.left`, `config get geometry --json`";
    assert_eq!(planted(page, unknown_argument), [""; 0]);
    let page = "`geometry.wheel_radius_m`, `encoder.left.reversed`, `tyre.contact_width_m`, \
                `wheel.*.eccentricity`, `robot.toml`, `5.0x`, `plant.gear.right.backlash_rad`";
    assert_eq!(planted(page, unknown_key), [""; 0]);
}

#[test]
fn a_planted_name_without_a_dot_is_found_with_its_line() {
    let known = ["payload_kg", "held_out", "plant", "seed", "run"].map(String::from).into();
    let found = |page: &str| findings_in("page.md", page, |code| unknown_word(code, &known));
    for (page, told) in [
        ("A page.\n\nSet `payload_kgg`.", "page.md:3: `payload_kgg`: no source has this name"),
        ("`held = true`", "page.md:1: `held`: no source has this name"),
        ("```toml\nseed = 1\nsede = 7\n```", "page.md:3: `sede`: no source has this name"),
        (
            "```toml\n  { payload_kg = 1, rest = 2 },\n```",
            "page.md:2: `rest`: no source has this name",
        ),
        ("```toml\nplant.seeed = 1 # of all\n```", "page.md:2: `seeed`: no source has this name"),
    ] {
        assert_eq!(found(page), [told], "{page}");
    }
    let page = "`payload_kg`, `held_out = true`, `word`, `a/b_c`, `Some_Name`, `_um`\n\n```toml\n\
                [[run]]\nplant.seed = { payload_kg = 2 }  # x = y\n```\n\n```sh\nx = 1\n```\n";
    assert_eq!(found(page), [""; 0]);
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
