//! What is planted in a page is found, and nothing else is.

use super::findings;
use crate::example::Example;

/// What is found in a page of a small repository.
fn found(name: &str, page: &str) -> Vec<String> {
    let example = Example::new(&[
        (name, page),
        ("docs/other.md", "# A page\n\n## What it is, `here`\n\n## Twice\n\n## Twice\n"),
        ("robot/Cargo.toml", "[package]\nname = \"robot\"\n"),
        ("robot/src/pid.rs", ""),
        ("tests/examples/bench_blind.rs", "fn main() { let _ = \"--seed\"; }"),
        ("robot/examples/drive.rs", ""),
    ]);
    findings(example.base(), example.files()).unwrap().0
}

#[test]
fn what_is_there_is_not_found() {
    let page = "`robot/src/pid.rs`, [a page](other.md#what-it-is-here), [up](#top), `pid.rs`, \
                [twice](other.md#twice-1), [the web](https://example.org/a#b), `a/b`, `2 m/s`, \
                `robot.toml`\n\n# Top\n\n```sh\n\
                cargo xtask bench blind --seed 2  # one more\ncargo run -p robot --example drive\n\
                cargo xtask firmware --board NAME\ncat robot/src/pid.rs\n```\n";
    assert_eq!(found("docs/page.md", page), [""; 0]);
}

#[test]
fn each_planted_mistake_is_found_in_its_line() {
    for (mistake, said) in [
        ("`robot/src/gone.rs`", "`robot/src/gone.rs` does not exist"),
        ("`gone.rs`", "`gone.rs` does not exist"),
        ("```\nx --port sim:robot/gone.toml\n```", "`robot/gone.toml` does not exist"),
        ("[a](gone.md)", "the link to `gone.md` leads nowhere"),
        ("[a](other.md#nothing)", "`other.md#nothing` has no such heading"),
        ("[a](#nothing)", "`#nothing` has no such heading"),
        ("`cargo xtask tset`", "`cargo xtask tset`: there is no chore `tset`"),
        ("`cargo xtask firmware --bord X`", "there is no flag `--bord`"),
        ("`cargo xtask bench blnid`", "there is no bench `blnid`"),
        ("`cargo xtask bench blind --sede 1`", "no bench has a flag `--sede`"),
        ("`cargo run --example drvie`", "there is no `drvie`"),
        ("`cargo test -p robto`", "there is no `robto`"),
    ] {
        let found = found("docs/page.md", &format!("# A page\n\n{mistake}\n"));
        assert_eq!(found.len(), 1, "{mistake}: {found:#?}");
        let line = if mistake.starts_with("```") { 4 } else { 3 };
        assert!(found[0].starts_with(&format!("docs/page.md:{line}: ")), "{found:#?}");
        assert!(found[0].ends_with(said), "{found:#?}");
    }
}

#[test]
fn a_first_page_of_too_many_words_is_found() {
    assert_eq!(found("README.md", &"word ".repeat(1000)), [""; 0]);
    assert_eq!(found("README.md", &"word ".repeat(1001)), ["README.md: 1001 words, at most 1000"]);
}
