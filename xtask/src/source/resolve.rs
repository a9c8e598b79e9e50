//! The file that a path leads to.

use std::path::Path;

use super::{Crate, Module};

/// Re-exports of re-exports; more than this many go round in a circle.
const DEPTH_MAX: usize = 16;

/// What a path has led to.
#[derive(Clone, Copy)]
enum Place {
    Module(usize),
    /// An item that is defined in this module; what follows is its own (a variant, a method).
    Item(usize),
}

impl Crate {
    /// The file in which the item at the end of a path is defined, and the item's name.
    pub fn definition(&self, from: usize, path: &[String]) -> Option<(&Path, String)> {
        match self.resolve(from, path, DEPTH_MAX)? {
            // A module that is imported is used where something of it is named.
            (Place::Module(_), _) => None,
            (Place::Item(module), name) => Some((&self.modules[module].file, name)),
        }
    }

    fn resolve(&self, from: usize, path: &[String], depth: usize) -> Option<(Place, String)> {
        let (first, rest) = path.split_first()?;
        let mut name = first.clone();
        let mut place = match first.as_str() {
            "crate" => Place::Module(0),
            "self" => Place::Module(from),
            "super" => Place::Module(self.modules[from].parent?),
            first => self.lookup(from, first, depth)?,
        };
        for segment in rest {
            let Place::Module(module) = place else { break };
            name.clone_from(segment);
            place = match segment.as_str() {
                "self" => Place::Module(module),
                "super" => Place::Module(self.modules[module].parent?),
                // What no line defines, a macro does, or another crate that is re-exported here.
                segment => self.lookup(module, segment, depth).unwrap_or(Place::Item(module)),
            };
        }
        Some((place, name))
    }

    /// What a name means in a module.
    fn lookup(&self, module: usize, name: &str, depth: usize) -> Option<Place> {
        let depth = depth.checked_sub(1)?;
        let here: &Module = &self.modules[module];
        if let Some(&child) = here.children.get(name) {
            return Some(Place::Module(child));
        }
        if here.items.contains(name) {
            return Some(Place::Item(module));
        }
        if let Some(path) = here.imports.get(name) {
            // `use name;` of another crate would lead here again.
            let leads_here = path.len() == 1 && path[0] == name;
            return if leads_here { None } else { Some(self.resolve(module, path, depth)?.0) };
        }
        here.globs.iter().find_map(|glob| match self.resolve(module, glob, depth)?.0 {
            Place::Module(other) if other != module => self.lookup(other, name, depth),
            _ => None,
        })
    }
}
