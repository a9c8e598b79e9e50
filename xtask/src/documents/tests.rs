//! What is planted in a page is found, and nothing else is.

use super::findings;
use crate::example_repository::Example;

/// What is found in a page of a small repository.
fn found(name: &str, page: &str) -> Vec<String> {
    let example = Example::new(&[
        (name, page),
        ("docs/other.md", "# A page\n\n## What it is, `here`\n\n## Twice\n\n## Twice\n"),
        ("robot/Cargo.toml", "[package]\nname = \"robot\"\n"),
        ("robot/src/pid.rs", "env(\"BEELINE_PORT\")"),
        ("tests/examples/bench_blind.rs", "fn main() { let _ = \"--seed\"; }"),
        ("tests/examples/bench_scale/main.rs", "fn main() { let _ = \"--one\"; }"),
        ("robot/examples/drive.rs", ""),
        ("robot/tests/whole/main.rs", ""),
        ("robot/src/bin/tool.rs", ""),
        (
            "model/Cargo.toml",
            "[package]\nname = \"robot-model\"\n[features]\nusb = []\nled = []\n[[test]]\nname = \"fit\"\n",
        ),
        ("robot-model/src/lib.rs", ""),
    ]);
    findings(example.base(), example.files()).unwrap().0
}

#[test]
fn what_is_there_is_not_found() {
    let page = "`robot/src/pid.rs`, `BEELINE_PORT=a x`, [a page](other.md#what-it-is-here), [up](#top), `pid.rs`, \
                [twice](other.md#twice-1), [the web](https://example.org/a#b), `a/b`, `2 m/s`, \
                `robot.toml`\n\n# Top\n\n```sh\n\
                cargo xtask bench blind --seed 2  # one more\ncargo run -p robot --example drive\n\
                cargo xtask firmware --board NAME\ncat robot/src/pid.rs\n\
                cargo xtask bench faults --seed S --cases 3\ncargo xtask fuzz [TARGET] [--seconds S]\n\
                cargo test -p robot --test whole NAME -- --nocapture\ncargo test -p robot-model --test=fit --features usb,led\n\
                cargo run --release --bin tool --config 'a.b=\"c d\"' && x --no-flag\n```\n\
                `cargo test -p NAME`, `robust/s`, `text/html`, `tset/x`, `runs/01.csv`, `cargo`\n";
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
        ("`robot-modl/src`", "`robot-modl/src` does not exist"),
        ("`robto-model/Cargo.toml`", "`robto-model/Cargo.toml` does not exist"),
        ("`doc/page`", "`doc/page` does not exist"),
        ("`cargo xtask tset`", "`cargo xtask tset`: there is no chore `tset`"),
        ("`cargo xtask firmware --bord X`", "`firmware` has no flag `--bord`"),
        ("`cargo xtask test --board X`", "`test` has no flag `--board`"),
        ("`cargo xtask emulate --port X`", "`emulate` has no flag `--port`"),
        ("`cargo xtask fuzz [--secnds S]`", "`fuzz` has no flag `--secnds`"),
        ("`cargo xtask bench blnid`", "there is no bench `blnid`"),
        ("`cargo xtask bench blind --sede 1`", "`bench blind` has no flag `--sede`"),
        ("`cargo xtask bench blind --one`", "`bench blind` has no flag `--one`"),
        ("`cargo xtask bench scale --seed 1`", "`bench scale` has no flag `--seed`"),
        ("`cargo xtask bench crash --seed 1`", "`bench crash` has no flag `--seed`"),
        ("`cargo xtask bench faults --threds 1`", "`bench faults` has no flag `--threds`"),
        ("```\ncd robot && cargo run --relaese\n```", "`cargo run` has no flag `--relaese`"),
        ("```\nmkdir a; cargo xtask chekc\n```", "there is no chore `chekc`"),
        ("`A_B=1 cargo xtask tset`", "there is no chore `tset`"),
        ("`BEELINE_PROT`", "`BEELINE_PROT`: nothing reads it"),
        ("`cargo rnu --release`", "cargo has no command `rnu`"),
        ("`cargo run --relaese`", "`cargo run` has no flag `--relaese`"),
        ("`cargo run --no-run`", "`cargo run` has no flag `--no-run`"),
        ("`cargo run --example drvie`", "there is no `drvie` for `--example`"),
        ("`cargo run --bin tol`", "there is no `tol` for `--bin`"),
        ("`cargo test -p robto`", "there is no package `robto`"),
        ("`cargo test -p fit`", "there is no package `fit`"),
        ("`cargo test --test binry`", "there is no `binry` for `--test`"),
        ("`cargo test --test=binry`", "there is no `binry` for `--test`"),
        ("`cargo test --features usb,lde`", "there is no `lde` for `--features`"),
        ("`cargo bench --bench tick`", "there is no `tick` for `--bench`"),
        ("`cargo test -p robot --test fit`", "there is no `fit` for `--test` of robot"),
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
    assert_eq!(
        found("README.md", &"word ".repeat(1001)),
        ["README.md:1: 1001 words, at most 1000"]
    );
}
