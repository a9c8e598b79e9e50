//! What a `use` brings in.

use syn::UseTree;

/// `a::{b, c as d}` as (b, a::b), (d, a::c); everything of a module as (*, module).
pub fn flatten(tree: &UseTree) -> Vec<(String, Vec<String>)> {
    let mut flat = Vec::new();
    walk(tree, &mut Vec::new(), &mut flat);
    flat
}

fn walk(tree: &UseTree, before: &mut Vec<String>, into: &mut Vec<(String, Vec<String>)>) {
    let mut leaf = |name: String, last: &syn::Ident| {
        let mut path = before.clone();
        match last.to_string() {
            // `a::{self}` is `a`.
            last if last == "self" && !path.is_empty() => {
                let name = if name == "self" { path[path.len() - 1].clone() } else { name };
                into.push((name, path));
            }
            last => {
                path.push(last);
                into.push((name, path));
            }
        }
    };
    match tree {
        UseTree::Name(name) => leaf(name.ident.to_string(), &name.ident),
        UseTree::Rename(rename) => leaf(rename.rename.to_string(), &rename.ident),
        UseTree::Glob(_) => into.push(("*".into(), before.clone())),
        UseTree::Path(path) => {
            before.push(path.ident.to_string());
            walk(&path.tree, before, into);
            before.pop();
        }
        UseTree::Group(group) => group.items.iter().for_each(|tree| walk(tree, before, into)),
    }
}
