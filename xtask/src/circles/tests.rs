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
fn a_module_and_its_parts_go_in_no_circle_either() {
    let parts = |module: &str, part: &str| {
        circles(&[
            ("robot/src/lib.rs", "mod a;\n"),
            ("robot/src/a/mod.rs", module),
            ("robot/src/a/part.rs", part),
        ])
    };
    // Down by a re-export and a method, and up by the type that is continued.
    let module = "mod part;\npub use part::f;\npub struct A;\nfn g() { A.h() }\n";
    let part = "use super::A;\npub fn f() {}\nimpl A { pub fn h(&self) {} }\n";
    assert!(parts(module, part).is_empty());
    let calls = "mod part;\npub struct A;\nfn g() { part::f() }\n";
    let told = "circle of 2:\n  robot/src/a/mod.rs -> robot/src/a/part.rs: f\n  \
                robot/src/a/part.rs -> robot/src/a/mod.rs: A";
    assert_eq!(parts(calls, part), [told]);
}

#[test]
fn a_way_round_by_another_file_is_a_circle() {
    let found = circles(&[
        ("robot/src/lib.rs", "mod a;\nmod d;\n"),
        ("robot/src/a/mod.rs", "mod part;\npub struct A;\nfn f() { part::f() }\n"),
        ("robot/src/a/part.rs", "pub fn f() { crate::d::g() }\n"),
        ("robot/src/d.rs", "use crate::a::A;\npub fn g() {}\n"),
    ]);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].starts_with("circle of 3:"), "{found:#?}");
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
