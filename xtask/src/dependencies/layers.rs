//! What a crate must not depend on, neither directly nor through others.
//!
//! The graph is cargo's own (`cargo tree`): with all features, for all systems, without what only tests or build
//! scripts need.

use std::process::Stdio;

use crate::steps::cargo_command;

/// One crate, and what must not be below it.
struct Rule {
    package: &'static str,
    forbidden: &'static [&'static [&'static str]],
    /// What a reader is told.
    why: &'static str,
}

const FILES: &[&str] = &["serde_json", "toml", "toml_edit"];

const COMMAND_LINE: &[&str] = &["clap", "clap_builder", "clap_derive", "clap_complete"];

/// Crates that write to terminals or read from them.
const TERMINAL: &[&str] = &[
    "anstream",
    "anstyle",
    "colored",
    "console",
    "crossterm",
    "ctrlc",
    "dialoguer",
    "indicatif",
    "inquire",
    "nu-ansi-term",
    "owo-colors",
    "ratatui",
    "rustyline",
    "termcolor",
    "terminal_size",
    "termion",
    "yansi",
];

const RULES: [Rule; 7] = [
    Rule {
        package: "robot-model",
        forbidden: &[FILES, COMMAND_LINE, TERMINAL, &["shared-proto", "campaign", "sim-target"]],
        why: "the estimator's model reads and writes nothing, and needs no other crate of ours",
    },
    Rule {
        package: "sim-target",
        forbidden: &[&["robot-model"]],
        why: "the simulator must not share a mistake with the model that is tested on it",
    },
    Rule {
        package: "campaign",
        forbidden: &[COMMAND_LINE, TERMINAL, &["host-link", "sim-target", "host-cli"]],
        why: "campaigns are read by any program, with or without a terminal, a robot or a simulator",
    },
    Rule {
        package: "import",
        forbidden: &[COMMAND_LINE, TERMINAL, &["host-link", "sim-target", "host-cli"]],
        why: "logs are imported by any program, and no robot is needed for it",
    },
    Rule {
        package: "findings",
        forbidden: &[COMMAND_LINE, TERMINAL, &["host-link", "sim-target", "host-cli"]],
        why: "what is found is told by any program, with or without a terminal",
    },
    Rule {
        package: "host-link",
        forbidden: &[COMMAND_LINE, TERMINAL, &["robot-model", "sim-target", "host-cli"]],
        why: "the link to a robot is for any program, which has a terminal and a model of its own, or none",
    },
    Rule {
        package: "emulated-board",
        forbidden: &[&["host-cli"]],
        why: "only its tests use the command",
    },
];

/// Which rules are broken, each with a chain of dependencies.
pub fn findings() -> Result<Vec<String>, String> {
    let mut findings = Vec::new();
    for rule in &RULES {
        findings.extend(broken(rule, &tree(rule)?));
    }
    Ok(findings)
}

/// What a crate depends on: each line is the depth and the package, `2 nalgebra v0.35.0`.
fn tree(rule: &Rule) -> Result<String, String> {
    let graph = ["--edges", "normal", "--all-features", "--target", "all", "--locked"];
    let lines = ["--prefix", "depth", "--format", " {p}"];
    let package = ["tree", "--quiet", "--package", rule.package];
    let output = cargo_command(&[&package[..], &graph, &lines].concat())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cannot run `cargo tree`: {error}"))?;
    if !output.status.success() {
        return Err(format!("`cargo tree --package {}`: {}", rule.package, output.status));
    }
    String::from_utf8(output.stdout).map_err(|_| "`cargo tree` is not UTF-8".to_owned())
}

/// What a tree has against a rule. Each forbidden crate is named once: its first chain says enough.
fn broken(rule: &Rule, tree: &str) -> Vec<String> {
    let mut chain: Vec<&str> = Vec::new();
    let mut named: Vec<&str> = Vec::new();
    let mut findings = Vec::new();
    for line in tree.lines() {
        let mut words = line.split_whitespace();
        let depth = words.next().and_then(|depth| depth.parse().ok());
        let (Some(depth), Some(name)) = (depth, words.next()) else { continue };
        chain.truncate(depth);
        chain.push(name);
        let is_forbidden = rule.forbidden.iter().any(|group| group.contains(&name));
        if is_forbidden && !named.contains(&name) {
            named.push(name);
            findings.push(format!(
                "{} must not depend on {name}: {} ({})",
                rule.package,
                chain.join(" -> "),
                rule.why
            ));
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(package: &str) -> &'static Rule {
        RULES.iter().find(|rule| rule.package == package).unwrap()
    }

    #[test]
    fn a_forbidden_crate_is_named_once_with_the_chain_that_leads_to_it() {
        let tree = "0 robot-model v0.1.0 (/robot-model)\n1 nalgebra v0.35.0\n2 simba v0.10.0\n\
                    1 reader v1.0.0\n2 words v1.0.0\n3 serde_json v1.0.0\n2 clap v4.6.0\n\
                    1 serde_json v1.0.0 (*)\n";
        let found = broken(rule("robot-model"), tree);
        assert_eq!(found.len(), 2, "{found:#?}");
        let chain = "robot-model must not depend on serde_json: \
                     robot-model -> reader -> words -> serde_json (";
        assert!(found[0].starts_with(chain), "{found:#?}");
        assert!(found[1].contains(": robot-model -> reader -> clap ("), "{found:#?}");
    }

    #[test]
    fn the_model_and_the_simulator_do_not_depend_on_each_other_in_either_direction() {
        for (one, other) in [("robot-model", "sim-target"), ("sim-target", "robot-model")] {
            let tree = format!("0 {one} v0.1.0\n1 between v0.1.0\n2 {other} v0.1.0\n");
            assert_eq!(broken(rule(one), &tree).len(), 1, "{one}");
        }
    }

    #[test]
    fn the_link_draws_no_progress_and_fits_no_model() {
        for other in ["indicatif", "robot-model"] {
            let tree = format!("0 host-link v0.1.0\n1 between v0.1.0\n2 {other} v0.1.0\n");
            let found = broken(rule("host-link"), &tree);
            let chain =
                format!("host-link must not depend on {other}: host-link -> between -> {other} (");
            assert!(found.len() == 1 && found[0].starts_with(&chain), "{found:?}");
        }
    }

    #[test]
    fn the_tree_of_each_rule_is_read_and_has_no_forbidden_crate() {
        for rule in &RULES {
            let tree = tree(rule).unwrap();
            assert!(tree.starts_with(&format!("0 {} v", rule.package)), "{tree}");
            assert!(tree.lines().count() > 10, "{tree}");
            assert_eq!(broken(rule, &tree), [""; 0]);
        }
    }

    #[test]
    fn what_only_tests_need_is_not_in_the_tree() {
        let manifest = crate::repository::root().join("emulated-board/Cargo.toml");
        let manifest = std::fs::read_to_string(manifest);
        let (_, for_tests) = manifest.as_ref().unwrap().split_once("[dev-dependencies]").unwrap();
        assert!(for_tests.contains("host-cli"));
        assert!(!tree(rule("emulated-board")).unwrap().contains("host-cli"));
    }
}
