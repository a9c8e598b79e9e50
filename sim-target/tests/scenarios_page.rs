//! `docs/scenarios.md` names every key that a scenario may have.
//!
//! The parser itself is asked: to a key that nobody knows it answers with those that it expects.

use std::collections::BTreeSet;

use sim_target::Scenario;

const PAGE: &str = include_str!("../../docs/scenarios.md");

/// No table has it.
const NOBODYS: &str = "nobodys_key";

/// What the parser says to a scenario with this text in it.
fn complaint(text: &str) -> String {
    Scenario::parse("probe", text).expect_err("nobody knows this key").problem
}

/// The words between backticks after `expected`.
fn expected(complaint: &str) -> Vec<String> {
    let (_, expected) = complaint.split_once("expected").unwrap_or_default();
    expected.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// A scenario with a strange key in the table at this path; the first of the path may be a list of tables.
fn probe(path: &[String]) -> String {
    match path {
        [] => format!("name = 'x'\n{NOBODYS} = 1\n"),
        [list] if list == "fault" => format!("name = 'x'\n[[fault]]\n{NOBODYS} = 1\n"),
        [list, ..] if list == "fault" => {
            format!("name = 'x'\n[[fault]]\n{} = {{ {NOBODYS} = 1 }}\n", path[1..].join("."))
        }
        _ => format!("name = 'x'\n[{}]\n{NOBODYS} = 1\n", path.join(".")),
    }
}

/// Every key below a path that holds no table.
fn leaves(path: &mut Vec<String>, into: &mut Vec<Vec<String>>) {
    let complaint = complaint(&probe(path));
    if !complaint.contains(&format!("unknown field `{NOBODYS}`")) {
        into.push(path.clone());
        return;
    }
    let keys = expected(&complaint);
    assert!(!keys.is_empty(), "{path:?}: {complaint}");
    for key in keys {
        path.push(key);
        leaves(path, into);
        path.pop();
    }
}

fn all_keys() -> Vec<Vec<String>> {
    let mut keys = Vec::new();
    leaves(&mut Vec::new(), &mut keys);
    keys
}

/// The words that stand between backticks in each line of the page.
fn named() -> Vec<BTreeSet<&'static str>> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let words = |line: &'static str| {
        let code = line.split('`').skip(1).step_by(2);
        code.flat_map(|code| code.split(move |c| !is_word(c)))
            .filter(|word| !word.is_empty())
            .collect()
    };
    PAGE.lines().map(words).collect()
}

/// What of a key's path has to stand in one line of the page: each wheel has the same keys, and what the
/// tables of a section are in is said over them.
fn wanted(path: &[String]) -> Vec<&str> {
    let said_above = |word: &&str| !["plant", "fault", "left", "right"].contains(word);
    let words: Vec<_> = path.iter().map(String::as_str).collect();
    words.into_iter().filter(said_above).collect()
}

#[test]
fn every_key_that_the_parser_accepts_is_named_in_a_line_with_its_table() {
    let named = named();
    let missing: Vec<_> = all_keys()
        .into_iter()
        .filter(|path| {
            !named.iter().any(|line| wanted(path).into_iter().all(|word| line.contains(word)))
        })
        .map(|path| path.join("."))
        .collect();
    assert!(missing.is_empty(), "docs/scenarios.md does not name {missing:#?}");
}

#[test]
fn every_kind_of_fault_is_named() {
    let text = format!("name = 'x'\n[[fault]]\nkind = '{NOBODYS}'\nat_s = 1\n");
    let kinds = expected(&complaint(&text));
    assert!(kinds.len() >= 10, "{kinds:?}");
    let named = named();
    for kind in kinds {
        assert!(named.iter().any(|line| line.contains(kind.as_str())), "{kind}");
    }
}

#[test]
fn the_parser_is_asked_for_all_of_its_keys() {
    let keys: BTreeSet<_> = all_keys().into_iter().map(|path| path.join(".")).collect();
    // One of every depth: at the top, in a table, of a wheel, of a part of a wheel's part, optional, in a list.
    for known in [
        "seed",
        "link.baud",
        "plant.motor.left.resistance_ohm",
        "plant.encoder.right.error.mesh_teeth",
        "plant.gear.left.set_screw_nm",
        "plant.floor.wet.friction",
        "gyro.bias_rad_s",
        "fault.at_motion_s",
    ] {
        assert!(keys.contains(known), "{known} is not in {keys:#?}");
    }
}

#[test]
fn what_the_page_shows_is_accepted() {
    let shown = PAGE.split("```toml\n").skip(1).filter_map(|block| block.split("```").next());
    let mut blocks = 0;
    for block in shown {
        let named = if block.starts_with("name") { "" } else { "name = 'x'\n" };
        Scenario::parse("docs/scenarios.md", &format!("{named}{block}"))
            .unwrap_or_else(|error| panic!("{error}:\n{block}"));
        blocks += 1;
    }
    assert!(blocks >= 2, "{blocks}");
}
