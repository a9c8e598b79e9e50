//! The walk-through of the README, command by command: what it prints there is what is printed here.
//!
//! In a `console` block a line after `$ ` is a command, what follows is its output, and a line `...` stands
//! for any number of lines. Where a figure has changed, the failure says which line of README.md is to be
//! replaced by what.

use std::path::{Path, PathBuf};

use crate::desk::Desk;

const SECTION: &str = "## Find what the model lacks";
const PICTURE: &str = "docs/mystery.svg";

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A command of the README, and what it prints there, with the numbers of the lines.
struct Example {
    line: usize,
    command: String,
    output: Vec<(usize, String)>,
}

/// The commands of the section's `console` blocks.
fn examples(readme: &str) -> Vec<Example> {
    let mut examples: Vec<Example> = Vec::new();
    let (mut here, mut console) = (false, false);
    for (index, text) in readme.lines().enumerate() {
        if text.starts_with("## ") {
            here = text == SECTION;
        }
        match text {
            "```console" if here => console = true,
            "```" => console = false,
            _ if console => match (text.strip_prefix("$ "), examples.last_mut()) {
                (Some(command), _) => examples.push(Example {
                    line: index + 1,
                    command: command.into(),
                    output: Vec::new(),
                }),
                (None, Some(it)) => it.output.push((index + 1, text.trim_end().into())),
                (None, None) => panic!("README.md, line {}: output of no command", index + 1),
            },
            _ => {}
        }
    }
    examples
}

/// What is wrong with the output that the README shows, and what is to be written there.
fn difference(example: &Example, printed: &str) -> Option<String> {
    let printed: Vec<&str> = printed.lines().map(str::trim_end).collect();
    let (mut at, mut skip) = (0, false);
    for (line, shown) in &example.output {
        if shown == "..." {
            skip = true;
            continue;
        }
        let found = if skip {
            printed[at..].iter().position(|it| it == shown).map(|it| at + it)
        } else {
            (printed.get(at) == Some(&shown.as_str())).then_some(at)
        };
        let Some(found) = found else {
            // The line that begins as the shown one does, or the one in its place.
            let first = |text: &str| text.split_whitespace().take(2).collect::<String>();
            let same = printed[at..].iter().find(|it| first(it) == first(shown));
            let now = same.or(printed.get(at)).unwrap_or(&"(nothing)");
            return Some(format!(
                "README.md, line {line}, in the output of `{}`: replace\n{shown}\nby\n{now}\n\nall that it prints now:\n{}\n",
                example.command,
                printed.join("\n")
            ));
        };
        (at, skip) = (found + 1, false);
    }
    let rest = !skip && at < printed.len();
    rest.then(|| {
        format!(
            "README.md, line {}: `{}` prints more than is shown; a line `...` would say so:\n{}",
            example.line,
            example.command,
            printed[at..].join("\n")
        )
    })
}

/// Does what the command line says; `None` where it is another program's business.
fn output_of(desk: &Desk, command: &str) -> Option<String> {
    if let Some(arguments) = command.strip_prefix("beeline ") {
        return Some(desk.run(arguments).ok().stdout);
    }
    let words: Vec<&str> = command.split_whitespace().collect();
    match words[..] {
        ["cp", "-r", from, to] => {
            copy(&repository().join(from), &desk.path(to));
            Some(String::new())
        }
        ["tail", "-n", "1", file] => {
            let text = String::from_utf8(desk.read(file)).unwrap();
            text.lines().last().map(str::to_owned)
        }
        // Held by the tests of the example itself.
        ["cargo", "run", "--release", "-p", "beeline-tests", "--example", "mystery", ..] => None,
        _ => panic!("README.md has a command that this test does not know: {command}"),
    }
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[test]
fn the_readmes_walk_through_prints_what_the_readme_shows() {
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let examples = examples(&readme);
    let beeline = examples.iter().filter(|it| it.command.starts_with("beeline ")).count();
    assert!(beeline >= 6, "only {beeline} commands of {}", examples.len());
    let desk = Desk::new();
    let mut wrong = Vec::new();
    for example in &examples {
        if let Some(printed) = output_of(&desk, &example.command) {
            wrong.extend(difference(example, &printed));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    the_picture_is_what_was_drawn(&desk);
}

/// `BEELINE_GOLDEN=write` draws it anew.
fn the_picture_is_what_was_drawn(desk: &Desk) {
    let drawn = desk.read("mystery.svg");
    let kept = repository().join(PICTURE);
    if std::env::var_os("BEELINE_GOLDEN").is_some() {
        std::fs::write(&kept, &drawn).unwrap();
    }
    assert!(
        std::fs::read(&kept).unwrap_or_default() == drawn,
        "{PICTURE} has changed: BEELINE_GOLDEN=write cargo test -p host-cli --test binary walk_through"
    );
}

#[test]
fn a_figure_that_has_changed_is_named_with_its_line_and_its_new_value() {
    let readme = format!(
        "{SECTION}\n\n```console\n$ beeline compare x\nIt is off by 3.1 mm.\n...\nrun a  2 mm\n```\n\n## Next\n```console\n$ rm\n```\n"
    );
    let examples = examples(&readme);
    assert_eq!((examples.len(), examples[0].command.as_str()), (1, "beeline compare x"));
    let same = difference(&examples[0], "It is off by 3.1 mm.\n\nrun b  4 mm\nrun a  2 mm\n");
    assert_eq!(same, None);
    let other = difference(&examples[0], "It is off by 3.1 mm.\n\nrun a  5 mm\n").unwrap();
    assert!(other.contains("README.md, line 7"), "{other}");
    assert!(other.contains("replace\nrun a  2 mm\nby\nrun a  5 mm"), "{other}");
    let more = difference(&examples[0], "It is off by 3.1 mm.\nrun a  2 mm\nand\n").unwrap();
    assert!(more.contains("prints more than is shown"), "{more}");
}
