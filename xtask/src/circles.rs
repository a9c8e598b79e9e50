//! No circles of uses between the files of a crate, and none between the folders of robot-model.
//!
//! What counts as a use is said in `source`. Every crate is read: the workspace's, the emulated
//! board's, their examples and their tests' programs. A module's file (`a/mod.rs`, or `a.rs` beside `a/`) and
//! a file below it are no exception: what both need is in a third file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::repository::{root, tracked_files};
use crate::source::{Crate, Uses, crate_roots};
use crate::steps::Outcome;

/// Holds that no files go in a circle.
pub fn check() -> Outcome {
    let files = tracked_files()?;
    let (circles, read) = find(root(), &files)?;
    println!("    {} files in {} crates", read.files, read.crates);
    if circles.is_empty() {
        return Ok(());
    }
    Err(message(&circles))
}

/// What is said of circles.
fn message(circles: &[Uses]) -> String {
    let all: Vec<String> = circles.iter().map(describe).collect();
    let number = match circles.len() {
        1 => "1 circle".to_owned(),
        more => format!("{more} circles"),
    };
    let advice = "files that use each other; move what both need into a third file";
    format!("{number} of {advice}:\n{}", all.join("\n"))
}

/// How much was read.
struct Read {
    crates: usize,
    files: usize,
}

/// The circles in all crates among these files, each as the uses within it.
fn find(base: &Path, files: &[PathBuf]) -> Result<(Vec<Uses>, Read), String> {
    let mut circles = Vec::new();
    let mut read = BTreeSet::new();
    let roots = crate_roots(base, files)?;
    for crate_root in &roots {
        let source = Crate::read(base, crate_root)?;
        read.extend(source.files().map(Path::to_path_buf));
        circles.extend(circles_in(&source.uses()));
    }
    Ok((circles, Read { crates: roots.len(), files: read.len() }))
}

/// The circles of a graph: its strongly connected parts, each with the uses within it.
pub fn circles_in(uses: &Uses) -> Vec<Uses> {
    let to_all = graph(uses);
    let reach: BTreeMap<&Path, BTreeSet<&Path>> =
        to_all.keys().map(|from| (*from, reachable(from, &to_all))).collect();
    let in_one_circle = |a: &Path, b: &Path| {
        let leads = |from: &Path, to: &Path| reach.get(from).is_some_and(|all| all.contains(to));
        leads(a, b) && leads(b, a)
    };
    let mut circles = Vec::new();
    let mut seen: BTreeSet<&Path> = BTreeSet::new();
    for &file in reach.keys() {
        if !in_one_circle(file, file) || seen.contains(file) {
            continue;
        }
        let within = |other: &PathBuf| in_one_circle(file, other);
        let circle: Uses = uses
            .iter()
            .filter(|((from, to), _)| within(from) && within(to))
            .map(|(arrow, names)| (arrow.clone(), names.clone()))
            .collect();
        seen.extend(reach.keys().copied().filter(|other| in_one_circle(file, other)));
        circles.push(circle);
    }
    circles
}

/// Each file, with those that it uses.
type Graph<'a> = BTreeMap<&'a Path, BTreeSet<&'a Path>>;

fn graph(uses: &Uses) -> Graph<'_> {
    let mut to_all = Graph::new();
    for (from, to) in uses.keys() {
        to_all.entry(from).or_default().insert(to);
    }
    to_all
}

fn reachable<'a>(from: &Path, to_all: &Graph<'a>) -> BTreeSet<&'a Path> {
    let mut reached = BTreeSet::new();
    let mut open = vec![from];
    while let Some(file) = open.pop() {
        for &next in to_all.get(file).into_iter().flatten() {
            if reached.insert(next) {
                open.push(next);
            }
        }
    }
    reached
}

/// A circle in words: its uses, one per line.
pub fn describe(circle: &Uses) -> String {
    let files: BTreeSet<&PathBuf> = circle.keys().flat_map(|(from, to)| [from, to]).collect();
    let mut text = format!("circle of {}:", files.len());
    for ((from, to), names) in circle {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        text += &format!("\n  {} -> {}: {}", from.display(), to.display(), names.join(", "));
    }
    text
}

#[cfg(test)]
mod tests;
