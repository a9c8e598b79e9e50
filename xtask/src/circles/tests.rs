//! Circles that are planted are found, and nothing else is.

use super::{describe, find, message};
use crate::example_repository::Example;

const MANIFEST: (&str, &str) = ("robot/Cargo.toml", "[package]\nname = \"robot\"\n");

/// The circles of a crate of these files, in words.
fn circles(files: &[(&str, &str)]) -> Vec<String> {
    let example = Example::new(&[&[MANIFEST], files].concat());
    let (circles, read) = find(example.base(), example.files()).unwrap();
    assert_eq!(read.crates, 1);
    circles.iter().map(describe).collect()
}

const LIB: (&str, &str) = ("robot/src/lib.rs", "pub mod a;\npub mod b;\npub mod c;\n");

#[test]
fn a_circle_of_two_is_told_with_the_names_that_tie_it() {
    let found = circles(&[
        LIB,
        ("robot/src/a.rs", "use crate::b::Wheel;\npub const TURN: f64 = 1.0;\n"),
        ("robot/src/b.rs", "pub struct Wheel;\nfn turn() -> f64 { crate::a::TURN }\n"),
        ("robot/src/c.rs", "use crate::a::TURN;\n"),
    ]);
    let told = "circle of 2:\n  robot/src/a.rs -> robot/src/b.rs: Wheel\n  \
                robot/src/b.rs -> robot/src/a.rs: TURN";
    assert_eq!(found, [told]);
}

#[test]
fn a_chain_is_no_circle() {
    let chain = [
        LIB,
        ("robot/src/a.rs", "use super::b::f;\npub fn g() { f() }\n"),
        ("robot/src/b.rs", "pub fn f() { crate::c::h(\"crate::a::g\") }\n// crate::a::g\n"),
        ("robot/src/c.rs", "pub fn h(_: &str) {}\n"),
    ];
    assert!(circles(&chain).is_empty());
}

#[test]
fn a_circle_of_three_is_seen_through_re_exports() {
    let found = circles(&[
        ("robot/src/lib.rs", "mod a;\nmod b;\nmod c;\npub use c::Third;\n"),
        ("robot/src/a.rs", "pub fn f() { let _ = crate::Third; }\n"),
        ("robot/src/b.rs", "use crate::{a::{self, f as first}};\npub fn g() { a::f() }\n"),
        ("robot/src/c.rs", "pub struct Third;\nimpl Third { fn h() { super::b::g() } }\n"),
    ]);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].starts_with("circle of 3:"), "{found:#?}");
    assert!(found[0].contains("robot/src/a.rs -> robot/src/c.rs: Third"), "{found:#?}");
}

#[test]
fn uses_in_macros_functions_and_by_everything_count() {
    for line in [
        "fn f() { assert_eq!(crate::b::ONE, 1); }",
        "fn f() { use crate::b::{ONE, TWO}; }",
        "use crate::b::*;\nfn f() -> u8 { ONE }",
        "macro_rules! one { () => { $crate::b::ONE } }",
        "fn f() { for _ in 0..crate::b::ONE {} }",
        "use crate::b;\nfn f() -> u8 { b::ONE }",
    ] {
        let b = "use crate::a::Item;\npub const ONE: u8 = 1;\n";
        let a = format!("pub struct Item;\n{line}\n");
        let found = circles(&[LIB, ("robot/src/a.rs", &a), ("robot/src/b.rs", b), C]);
        assert_eq!(found.len(), 1, "{line}: {found:#?}");
    }
}

const C: (&str, &str) = ("robot/src/c.rs", "");

#[test]
fn tests_do_not_count() {
    for line in [
        "#[cfg(test)]\nmod tests { use crate::b::ONE; }",
        "#[cfg(test)]\nuse crate::b::ONE;",
        "impl Item {\n#[cfg(test)]\nfn f() -> u8 { crate::b::ONE }\nfn g() {} }",
        "#[cfg(all(test, unix))]\nfn f() -> u8 { crate::b::ONE }",
    ] {
        let b = "use crate::a::Item;\npub const ONE: u8 = 1;\n";
        let a = format!("pub struct Item;\n{line}\n");
        let found = circles(&[LIB, ("robot/src/a.rs", &a), ("robot/src/b.rs", b), C]);
        assert!(found.is_empty(), "{line}: {found:#?}");
    }
}

#[test]
fn a_module_and_its_parts_may_go_down_and_up_but_not_round_by_another_file() {
    let parts = [
        ("robot/src/lib.rs", "mod a;\nmod d;\n"),
        ("robot/src/a/mod.rs", "mod part;\npub struct A;\nfn f() { part::f() }\n"),
        ("robot/src/a/part.rs", "use super::A;\npub fn f() {}\n"),
    ];
    assert!(circles(&[&parts[..], &[("robot/src/d.rs", "")]].concat()).is_empty());
    // The part needs another file, which needs the module.
    let round = [
        parts[0],
        parts[1],
        ("robot/src/a/part.rs", "pub fn f() { crate::d::g() }\n"),
        ("robot/src/d.rs", "use crate::a::A;\npub fn g() {}\n"),
    ];
    let found = circles(&round);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].starts_with("circle of 3:"), "{found:#?}");
}

#[test]
fn parts_side_by_side_go_in_no_circle_by_their_module() {
    let selection = |classes: &str, select: &str| {
        circles(&[
            ("robot/src/lib.rs", "mod selection;\n"),
            (
                "robot/src/selection/mod.rs",
                "mod classes;\nmod select;\npub struct S;\nfn f() { select::g() }\n",
            ),
            ("robot/src/selection/classes.rs", classes),
            ("robot/src/selection/select.rs", select),
        ])
    };
    // The module's file calls one part, both parts use its type, and one of them the other.
    let uses_the_module = "use super::S;\npub struct Class;\n";
    let uses_classes = "use super::classes::Class;\npub fn g() {}\n";
    let told = "circle of 3:\n  \
                robot/src/selection/classes.rs -> robot/src/selection/mod.rs: S\n  \
                robot/src/selection/mod.rs -> robot/src/selection/select.rs: g\n  \
                robot/src/selection/select.rs -> robot/src/selection/classes.rs: Class";
    assert_eq!(selection(uses_the_module, uses_classes), [told]);
    // Two circles of two files, each of the module's file and a part, are let pass.
    let uses_both = "use super::S;\npub fn g() { super::f() }\n";
    assert!(selection(uses_the_module, uses_both).is_empty());
}

#[test]
fn a_name_that_the_module_re_exports_is_a_use_of_the_part_that_defines_it() {
    let module = "mod a;\nmod b;\npub use a::A;\npub use b::*;\n";
    let found = circles(&[
        ("robot/src/lib.rs", "mod m;\n"),
        ("robot/src/m.rs", module),
        ("robot/src/m/a.rs", "pub struct A;\nfn f() -> super::B { todo!() }\n"),
        ("robot/src/m/b.rs", "use super::A;\npub struct B;\n"),
    ]);
    let told = "circle of 2:\n  robot/src/m/a.rs -> robot/src/m/b.rs: B\n  \
                robot/src/m/b.rs -> robot/src/m/a.rs: A";
    assert_eq!(found, [told]);
}

#[test]
fn one_circle_is_told_in_the_singular() {
    let circle = super::Uses::from([(("a.rs".into(), "b.rs".into()), ["B".to_owned()].into())]);
    assert!(message(std::slice::from_ref(&circle)).starts_with("1 circle of files"));
    assert!(message(&[circle.clone(), circle]).starts_with("2 circles of files"));
}

#[test]
fn modules_that_a_macro_declares_are_read() {
    let found = circles(&[
        (
            "robot/src/lib.rs",
            "macro_rules! all { ($($m:ident,)*) => { $(mod $m;)* } }\nall!(a, b,);\n",
        ),
        ("robot/src/a.rs", "pub struct A;\nuse crate::b::B;\n"),
        ("robot/src/b.rs", "pub struct B;\nuse crate::a::A;\n"),
    ]);
    assert_eq!(found.len(), 1, "{found:#?}");
}

#[test]
fn this_repository_is_read_to_the_last_file() {
    let files = crate::repository::tracked_files().unwrap();
    let (_, read) = find(crate::repository::root(), &files).unwrap();
    let sources = files.iter().filter(|file| file.extension().is_some_and(|end| end == "rs"));
    assert_eq!(read.files, sources.count());
}
