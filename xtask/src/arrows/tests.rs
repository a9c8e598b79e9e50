//! The drawing is that of the code.

use super::{BEGIN, END, draw, folder_uses, no_circle, with_drawing};
use crate::example_repository::Example;

/// A robot-model of three folders, and a line more in the lowest one.
fn example(line: &str) -> Example {
    Example::new(&[
        ("robot-model/src/lib.rs", "pub mod low;\npub mod mid;\npub mod top;\n"),
        ("robot-model/src/top/mod.rs", "use crate::mid::M;\nuse crate::low::L;\npub struct T;\n"),
        ("robot-model/src/mid.rs", "mod part;\npub struct M;\n"),
        ("robot-model/src/mid/part.rs", "use super::M;\nuse crate::low::L;\n"),
        ("robot-model/src/low/mod.rs", &format!("pub struct L;\n{line}\n")),
    ])
}

#[test]
fn a_folder_stands_above_all_that_it_uses() {
    let uses = folder_uses(example("").base()).unwrap();
    no_circle(&uses).unwrap();
    assert_eq!(draw(&uses), "top/  ->  mid/ low/\nmid/  ->  low/\nlow/\n");
}

#[test]
fn a_planted_circle_of_folders_is_found() {
    let uses = folder_uses(example("use crate::top::T;").base()).unwrap();
    let error = no_circle(&uses).unwrap_err();
    assert!(error.contains("low/ -> top/: T"), "{error}");
}

#[test]
fn the_drawing_goes_between_the_marks_of_the_page() {
    let page = format!("before\n{BEGIN}\nold\n{END}\nafter\n");
    let drawn = with_drawing(&page, "a -> b\n").unwrap();
    assert_eq!(drawn, format!("before\n{BEGIN}\n```text\na -> b\n```\n{END}\nafter\n"));
    assert_eq!(with_drawing(&drawn, "a -> b\n").unwrap(), drawn);
    assert_eq!(with_drawing("no marks", "a -> b\n"), None);
}
