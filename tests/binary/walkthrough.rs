//! The `console` blocks of the pages: each command prints what the page shows.
//!
//! A line after `$ ` is a command, what follows is its output, and a line `...` stands for any number of
//! lines. Where a figure has changed, the failure says which line of which page is to be replaced by what.

use std::path::{Path, PathBuf};

use crate::temp_folder::{TempFolder, copy};

/// A page with `console` blocks, and how many commands of `beeline` it has at least.
const PAGES: [(&str, usize); 3] =
    [("README.md", 4), ("docs/find-what-is-missing.md", 7), ("docs/calibrate.md", 1)];
/// What the walk-through of this page draws.
const WALK_THROUGH: &str = "docs/find-what-is-missing.md";
const PICTURE: &str = "docs/mystery.svg";

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A command of a page, and what it prints there, with the numbers of the lines.
struct Example {
    page: &'static str,
    line: usize,
    command: String,
    output: Vec<(usize, String)>,
}

/// The commands of the `console` blocks in a page of this text.
fn examples(page: &'static str, text: &str) -> Vec<Example> {
    let mut examples: Vec<Example> = Vec::new();
    let mut console = false;
    for (index, text) in text.lines().enumerate() {
        match text {
            "```console" => console = true,
            "```" => console = false,
            _ if console => match (text.strip_prefix("$ "), examples.last_mut()) {
                (Some(command), _) => examples.push(Example {
                    page,
                    line: index + 1,
                    command: command.into(),
                    output: Vec::new(),
                }),
                (None, Some(last)) => last.output.push((index + 1, text.trim_end().into())),
                (None, None) => panic!("{page}, line {}: output of no command", index + 1),
            },
            _ => {}
        }
    }
    examples
}

/// The difference between the output that a page shows and the real one, with the line to write there.
fn difference(example: &Example, printed: &str) -> Option<String> {
    let printed: Vec<&str> = printed.lines().map(str::trim_end).collect();
    let (mut at, mut skip) = (0, false);
    for (line, shown) in &example.output {
        if shown == "..." {
            skip = true;
            continue;
        }
        let found = if skip {
            printed[at..].iter().position(|line| line == shown).map(|skipped| at + skipped)
        } else {
            (printed.get(at) == Some(&shown.as_str())).then_some(at)
        };
        let Some(found) = found else {
            // The line that begins like the shown one, or else the line at its position.
            let first = |text: &str| text.split_whitespace().take(2).collect::<String>();
            let same = printed[at..].iter().find(|line| first(line) == first(shown));
            let now = same.or(printed.get(at)).unwrap_or(&"(nothing)");
            return Some(format!(
                "{}, line {line}, in the output of `{}`: replace\n{shown}\nby\n{now}\n\nall that it prints now:\n{}\n",
                example.page,
                example.command,
                printed.join("\n")
            ));
        };
        (at, skip) = (found + 1, false);
    }
    let rest = !skip && at < printed.len();
    rest.then(|| {
        format!(
            "{}, line {}: `{}` prints more than is shown; a line `...` would say so:\n{}",
            example.page,
            example.line,
            example.command,
            printed[at..].join("\n")
        )
    })
}

/// Runs the command line; `None` if it is for another program.
fn output_of(temp: &TempFolder, command: &str) -> Option<String> {
    if let Some(arguments) = command.strip_prefix("beeline ") {
        return Some(temp.run(arguments).ok().stdout);
    }
    let words: Vec<&str> = command.split_whitespace().collect();
    match words[..] {
        ["cp", "-r", from, to] => {
            copy(&repository().join(from), &temp.path(to));
            Some(String::new())
        }
        ["tail", "-n", "1", file] => {
            let text = String::from_utf8(temp.read(file)).unwrap();
            text.lines().last().map(str::to_owned)
        }
        // The tests of the example itself cover this.
        ["cargo", "run", "--release", "-p", "beeline-tests", "--example", "mystery", ..] => None,
        _ => panic!("a page has a command that this test does not know: {command}"),
    }
}

#[test]
fn commands_print_what_the_pages_show() {
    let mut wrong = Vec::new();
    for (page, commands_min) in PAGES {
        let text = std::fs::read_to_string(repository().join(page)).unwrap();
        let examples = examples(page, &text);
        let is_ours = |example: &&Example| example.command.starts_with("beeline ");
        let beeline = examples.iter().filter(is_ours).count();
        assert!(beeline >= commands_min, "{page}: only {beeline} commands of {}", examples.len());
        let temp = TempFolder::new();
        for example in &examples {
            if let Some(printed) = output_of(&temp, &example.command) {
                wrong.extend(difference(example, &printed));
            }
        }
        if page == WALK_THROUGH {
            the_picture_is_what_was_drawn(&temp);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// `BEELINE_GOLDEN=write` draws it anew.
fn the_picture_is_what_was_drawn(temp: &TempFolder) {
    let drawn = temp.read("mystery.svg");
    let kept = repository().join(PICTURE);
    if std::env::var_os("BEELINE_GOLDEN").is_some() {
        std::fs::write(&kept, &drawn).unwrap();
    }
    assert!(
        std::fs::read(&kept).unwrap_or_default() == drawn,
        "{PICTURE} has changed: BEELINE_GOLDEN=write cargo test -p host-cli --test binary walkthrough"
    );
}

#[test]
fn a_figure_that_has_changed_is_named_with_its_line_and_its_new_value() {
    let text = "## Compare\n\n```console\n$ beeline compare x\nIt is off by 3.1 mm.\n...\nrun a  2 mm\n```\n\n```sh\nrm\n```\n";
    let examples = examples("page.md", text);
    assert_eq!((examples.len(), examples[0].command.as_str()), (1, "beeline compare x"));
    let same = difference(&examples[0], "It is off by 3.1 mm.\n\nrun b  4 mm\nrun a  2 mm\n");
    assert_eq!(same, None);
    let other = difference(&examples[0], "It is off by 3.1 mm.\n\nrun a  5 mm\n").unwrap();
    assert!(other.contains("page.md, line 7"), "{other}");
    assert!(other.contains("replace\nrun a  2 mm\nby\nrun a  5 mm"), "{other}");
    let more = difference(&examples[0], "It is off by 3.1 mm.\nrun a  2 mm\nand\n").unwrap();
    assert!(more.contains("prints more than is shown"), "{more}");
}
