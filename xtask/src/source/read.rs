//! Reads a crate's files into a tree of modules.

use std::path::{Path, PathBuf};

use syn::{Attribute, Item, ItemMacro, ItemMod, ItemUse, Visibility};

use super::use_tree::flatten;
use super::{Crate, Module, names, tidy};

impl Crate {
    /// Reads the crate whose root module is `file`, a path below `base`.
    pub fn read(base: &Path, file: &Path) -> Result<Self, String> {
        let mut reader = Reader { base, modules: Vec::new() };
        let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
        reader.read_file(Module { file: file.into(), folder, ..Module::default() })?;
        Ok(Self { modules: reader.modules })
    }
}

struct Reader<'a> {
    base: &'a Path,
    modules: Vec<Module>,
}

impl Reader<'_> {
    /// Reads the file of a module, and all below; returns the module's number.
    fn read_file(&mut self, module: Module) -> Result<usize, String> {
        let name = module.file.display().to_string();
        let text = std::fs::read_to_string(self.base.join(&module.file))
            .map_err(|error| format!("{name}: {error}"))?;
        let file = syn::parse_file(&text).map_err(|error| format!("{name}: {error}"))?;
        self.modules.push(module);
        let index = self.modules.len() - 1;
        self.read_items(index, file.items)?;
        Ok(index)
    }

    fn read_items(&mut self, index: usize, items: Vec<Item>) -> Result<(), String> {
        for item in items {
            match item {
                Item::Mod(item) => self.read_module(index, item)?,
                item if is_for_tests(attributes(&item)) => {}
                Item::Use(item) => self.read_use(index, &item),
                Item::Macro(item) => self.read_macro(index, item)?,
                item => {
                    let module = &mut self.modules[index];
                    module.items.extend(name_of(&item));
                    names::collect(quote::quote!(#item), &mut module.mentions);
                }
            }
        }
        Ok(())
    }

    fn read_module(&mut self, parent: usize, item: ItemMod) -> Result<(), String> {
        let name = item.ident.to_string();
        let above = &self.modules[parent];
        let mut module = Module {
            file: above.file.clone(),
            folder: above.folder.join(&name),
            is_test: above.is_test || is_for_tests(&item.attrs),
            parent: Some(parent),
            ..Module::default()
        };
        let index = if let Some((_, items)) = item.content {
            self.modules.push(module);
            let index = self.modules.len() - 1;
            self.read_items(index, items)?;
            index
        } else {
            let beside = above.folder.join(&name).with_extension("rs");
            let inside = above.folder.join(&name).join("mod.rs");
            module.file = match path_attribute(&item.attrs) {
                Some(path) => tidy(&above.file.parent().unwrap_or(Path::new("")).join(path)),
                None if self.exists(&beside) => beside,
                None if self.exists(&inside) => inside,
                None => {
                    return Err(format!("{}: no file for `mod {name}`", above.file.display()));
                }
            };
            if module.file.ends_with("mod.rs") || path_attribute(&item.attrs).is_some() {
                module.folder = module.file.parent().unwrap_or(Path::new("")).to_path_buf();
            }
            self.read_file(module)?
        };
        self.modules[parent].children.insert(name, index);
        Ok(())
    }

    /// `use`: a re-export is no use by itself, any other one is.
    fn read_use(&mut self, index: usize, item: &ItemUse) {
        let module = &mut self.modules[index];
        let is_private = matches!(item.vis, Visibility::Inherited);
        for (name, path) in flatten(&item.tree) {
            match name.as_str() {
                "*" => module.globs.push(path),
                _ => {
                    if is_private {
                        module.mentions.insert(path.clone());
                    }
                    if name != "_" {
                        module.imports.insert(name, path);
                    }
                }
            }
        }
    }

    /// A macro's definition, or a call: this may declare modules, whose names it is given.
    fn read_macro(&mut self, index: usize, item: ItemMacro) -> Result<(), String> {
        let module = &mut self.modules[index];
        module.items.extend(item.ident.as_ref().map(ToString::to_string));
        names::collect(quote::quote!(#item), &mut module.mentions);
        if item.ident.is_some() {
            return Ok(());
        }
        let mut words = std::collections::BTreeSet::new();
        names::idents(item.mac.tokens, &mut words);
        for word in words {
            let beside = self.modules[index].folder.join(&word).with_extension("rs");
            let is_root = self.modules[index].file == beside;
            if !is_root && !self.modules[index].children.contains_key(&word) && self.exists(&beside)
            {
                let name = syn::Ident::new(&word, proc_macro2::Span::call_site());
                self.read_module(index, syn::parse_quote!(mod #name;))?;
            }
        }
        Ok(())
    }

    fn exists(&self, file: &PathBuf) -> bool {
        self.base.join(file).is_file()
    }
}

/// Whether an attribute is `cfg(test)` or `cfg(all(test, ...))`.
pub fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let syn::Meta::List(list) = &attribute.meta else { return false };
        list.path.is_ident("cfg") && names::requires_test(&list.tokens)
    })
}

fn path_attribute(attributes: &[Attribute]) -> Option<String> {
    attributes.iter().find_map(|attribute| {
        let syn::Meta::NameValue(pair) = &attribute.meta else { return None };
        let syn::Expr::Lit(value) = &pair.value else { return None };
        let syn::Lit::Str(text) = &value.lit else { return None };
        pair.path.is_ident("path").then(|| text.value())
    })
}

fn name_of(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::TraitAlias(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}
