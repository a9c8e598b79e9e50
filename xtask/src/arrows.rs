//! The arrows between the folders of robot-model: a page of ARCHITECTURE.md that is drawn from the code.
//!
//! A folder uses another one if a file in it uses a file of the other; a file in the crate's root
//! stands for itself. Folders go in no circle, and a folder stands above all that it uses.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::circles::{circles_in, describe};
use crate::repository::root;
use crate::source::{Crate, Uses};
use crate::steps::Outcome;

const CRATE: &str = "robot-model/src";
const PAGE: &str = "ARCHITECTURE.md";
const BEGIN: &str = "<!-- arrows of robot-model: drawn by `cargo xtask arrows` -->";
const END: &str = "<!-- end of the arrows -->";

/// The chore: draws the arrows, and puts them into the page if it has a place for them.
pub fn run() -> Outcome {
    let uses = folder_uses(root())?;
    let drawing = draw(&uses);
    print!("{drawing}");
    let page = read_page()?;
    if let Some(page) = with_drawing(&page, &drawing) {
        std::fs::write(root().join(PAGE), page).map_err(|error| format!("{PAGE}: {error}"))?;
    } else {
        println!("\nTo have it in {PAGE}, put these two lines there:\n{BEGIN}\n{END}");
    }
    no_circle(&uses)
}

/// Holds that folders go in no circle, and that the page's drawing is that of the code.
pub fn check() -> Outcome {
    let uses = folder_uses(root())?;
    no_circle(&uses)?;
    let page = read_page()?;
    match with_drawing(&page, &draw(&uses)) {
        Some(drawn) if drawn == page => Ok(()),
        Some(_) => {
            Err(format!("the arrows in {PAGE} are not those of the code: run `cargo xtask arrows`"))
        }
        None => Err(format!("{PAGE} lacks the lines `{BEGIN}` and `{END}`")),
    }
}

fn no_circle(uses: &Uses) -> Outcome {
    let circles: Vec<String> = circles_in(uses).iter().map(describe).collect();
    if circles.is_empty() {
        return Ok(());
    }
    Err(format!("folders of {CRATE} use each other in circles:\n{}", circles.join("\n")))
}

fn read_page() -> Result<String, String> {
    std::fs::read_to_string(root().join(PAGE)).map_err(|error| format!("{PAGE}: {error}"))
}

/// Which folder of robot-model uses which.
fn folder_uses(base: &Path) -> Result<Uses, String> {
    let source = Crate::read(base, &Path::new(CRATE).join("lib.rs"))?;
    let mut folders = Uses::new();
    for ((from, to), names) in source.uses() {
        let (from, to) = (folder_of(base, &from), folder_of(base, &to));
        // The crate's root declares and re-exports: it stands above all.
        if from != to && from != Path::new("lib.rs") {
            folders.entry((from, to)).or_default().extend(names);
        }
    }
    Ok(folders)
}

/// `effect/` for a file in that folder or below, `effect.rs` too; a file of the root as it is.
fn folder_of(base: &Path, file: &Path) -> PathBuf {
    let inner = file.strip_prefix(CRATE).unwrap_or(file);
    let mut parts = inner.iter();
    let first = parts.next().unwrap_or_default();
    if parts.next().is_some() {
        return PathBuf::from(format!("{}/", first.display()));
    }
    let stem = Path::new(first).with_extension("");
    if base.join(CRATE).join(&stem).is_dir() {
        PathBuf::from(format!("{}/", stem.display()))
    } else {
        first.into()
    }
}

/// One line a folder: whatever it uses stands below.
fn draw(uses: &Uses) -> String {
    let mut to_all: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
    for (from, to) in uses.keys() {
        to_all.entry(from).or_default().insert(to);
        to_all.entry(to).or_default();
    }
    let mut floors: BTreeMap<&Path, usize> = to_all.keys().map(|folder| (*folder, 0)).collect();
    // As many rounds as there are folders; in a circle they would rise for ever.
    for _ in 0..to_all.len() {
        for (from, all) in &to_all {
            let above = all.iter().map(|to| floors[to] + 1).max().unwrap_or(0);
            floors.insert(from, above);
        }
    }
    let mut lines: Vec<(usize, &Path)> =
        floors.iter().map(|(path, floor)| (*floor, *path)).collect();
    lines.sort_by_key(|(floor, folder)| (std::cmp::Reverse(*floor), *folder));
    let width = to_all.keys().map(|folder| folder.as_os_str().len()).max().unwrap_or(0);
    let mut drawing = String::new();
    for (_, folder) in lines {
        let mut below: Vec<&Path> = to_all[folder].iter().copied().collect();
        below.sort_by_key(|to| (std::cmp::Reverse(floors[to]), *to));
        let below: Vec<String> = below.iter().map(|to| to.display().to_string()).collect();
        let name = folder.display().to_string();
        let line = match below.len() {
            0 => name,
            _ => format!("{name:<width$}  ->  {}", below.join(" ")),
        };
        drawing += &format!("{line}\n");
    }
    drawing
}

/// The page with this drawing between its two marks; `None` if it lacks them.
fn with_drawing(page: &str, drawing: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n```text\n{drawing}```\n{END}{after}"))
}

#[cfg(test)]
mod tests;
