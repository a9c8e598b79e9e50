//! No circles of uses between the files of a crate, and none between the folders of robot-model.
//!
//! What counts as a use is said in `source`. Every crate is read: the workspace's, the emulated
//! board's, their examples and their tests' programs.
//!
//! A module file and the files below it are one concept, so one kind of circle is let pass: `a/mod.rs`
//! calls `a/b.rs`, and this one uses a type of `a/mod.rs`. That is how Rust splits a large module. It
//! passes only as long as it stays among them and needs the way down. So files side by side never use
//! one another in a circle, except through their module's file; files in different folders never do.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::source::{Crate, Uses, crate_roots};
use crate::{Outcome, root, tracked_files};

/// Holds that no files go in a circle.
pub fn check() -> Outcome {
    let files = tracked_files()?;
    let (circles, read) = find(root(), &files)?;
    println!("    {} files in {} crates", read.files, read.crates);
    if circles.is_empty() {
        return Ok(());
    }
    let all: Vec<String> = circles.iter().map(describe).collect();
    let advice = "files that use each other; move what both need into a third file";
    Err(format!("{} circles of {advice}:\n{}", circles.len(), all.join("\n")))
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
        let mut uses = source.uses();
        let mut found: Vec<Uses> = circles_in(&uses).into_iter().filter(crosses_modules).collect();
        uses.retain(|(from, to), _| !is_below(to, from));
        for circle in circles_in(&uses) {
            let is_in = |larger: &Uses| circle.keys().all(|arrow| larger.contains_key(arrow));
            if !found.iter().any(is_in) {
                found.push(circle);
            }
        }
        circles.extend(found);
    }
    Ok((circles, Read { crates: roots.len(), files: read.len() }))
}

/// Whether a circle is more than one module file and files below it.
fn crosses_modules(circle: &Uses) -> bool {
    let files: BTreeSet<&PathBuf> = circle.keys().map(|(from, _)| from).collect();
    !files.iter().any(|head| files.iter().all(|file| file == head || is_below(file, head)))
}

/// Whether a file is of a module inside that of the other file.
fn is_below(inner: &Path, outer: &Path) -> bool {
    let folder = outer.parent().unwrap_or(Path::new(""));
    let is_head = ["mod.rs", "lib.rs", "main.rs"].iter().any(|name| outer.ends_with(name));
    if is_head { inner.starts_with(folder) } else { inner.starts_with(outer.with_extension("")) }
}

/// The circles of a graph: its strongly connected parts, each with the uses within it.
pub fn circles_in(uses: &Uses) -> Vec<Uses> {
    let mut to_all: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
    for (from, to) in uses.keys() {
        to_all.entry(from).or_default().insert(to);
    }
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

fn reachable<'a>(
    from: &Path,
    to_all: &BTreeMap<&'a Path, BTreeSet<&'a Path>>,
) -> BTreeSet<&'a Path> {
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
