//! The paths that code names.

use std::collections::BTreeSet;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use super::use_tree::flatten;

/// Adds the paths in these tokens; the name of a macro that is called ends in `!`. What stands under `#[cfg(test)]` is
/// left out.
pub fn collect(tokens: TokenStream, into: &mut BTreeSet<Vec<String>>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut at = 0;
    while at < tokens.len() {
        at = match &tokens[at] {
            TokenTree::Punct(_) if is_test_attribute(&tokens, at) => skip_item(&tokens, at + 2),
            TokenTree::Group(group) => {
                collect(group.stream(), into);
                at + 1
            }
            TokenTree::Ident(word) if word == "use" => collect_use(&tokens, at, into),
            TokenTree::Ident(_) => collect_path(&tokens, at, into),
            _ => at + 1,
        };
    }
}

/// Every word in these tokens.
pub fn idents(tokens: TokenStream, into: &mut BTreeSet<String>) {
    for token in tokens {
        match token {
            TokenTree::Group(group) => idents(group.stream(), into),
            TokenTree::Ident(word) => _ = into.insert(word.to_string()),
            _ => {}
        }
    }
}

/// Whether a condition holds for tests only: `test`, or `all(test, ...)`.
pub fn requires_test(condition: &TokenStream) -> bool {
    let tokens: Vec<TokenTree> = condition.clone().into_iter().collect();
    match &tokens[..] {
        [TokenTree::Ident(word)] => word == "test",
        [TokenTree::Ident(word), TokenTree::Group(inner)] => {
            word == "all" && inner.stream().into_iter().any(|token| is_word(Some(&token), "test"))
        }
        _ => false,
    }
}

fn is_test_attribute(tokens: &[TokenTree], at: usize) -> bool {
    let Some(TokenTree::Group(group)) = tokens.get(at + 1) else { return false };
    let inner: Vec<TokenTree> = group.stream().into_iter().collect();
    is_punct(tokens.get(at), '#')
        && matches!(&inner[..], [word, TokenTree::Group(condition)]
            if is_word(Some(word), "cfg") && requires_test(&condition.stream()))
}

/// The place behind an item, or a statement, that begins here.
fn skip_item(tokens: &[TokenTree], from: usize) -> usize {
    let ends = |token: &TokenTree| {
        is_punct(Some(token), ';')
            || is_punct(Some(token), ',')
            || matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace)
    };
    let length = tokens[from.min(tokens.len())..].iter().position(ends);
    length.map_or(tokens.len(), |length| from + length + 1)
}

/// A `use` within a function.
fn collect_use(tokens: &[TokenTree], at: usize, into: &mut BTreeSet<Vec<String>>) -> usize {
    let rest = &tokens[at..];
    let Some(end) = rest.iter().position(|token| is_punct(Some(token), ';')) else {
        return at + 1;
    };
    let line: TokenStream = rest[..=end].iter().cloned().collect();
    if let Ok(item) = syn::parse2::<syn::ItemUse>(line) {
        into.extend(flatten(&item.tree).into_iter().map(|(_, path)| path));
    }
    at + end + 1
}

/// A path, or a name alone; returns the place behind it.
fn collect_path(tokens: &[TokenTree], at: usize, into: &mut BTreeSet<Vec<String>>) -> usize {
    let mut path = Vec::new();
    let mut next = at;
    while let Some(TokenTree::Ident(word)) = tokens.get(next) {
        path.push(word.to_string());
        next += 1;
        if !(is_punct(tokens.get(next), ':') && is_punct(tokens.get(next + 1), ':')) {
            break;
        }
        next += 2;
    }
    let before = |distance| at.checked_sub(distance).and_then(|at| tokens.get(at));
    // A field or a method is no path, but the end of a range is; `'a` is a lifetime.
    let is_member = is_punct(before(1), '.') && !is_punct(before(2), '.');
    let is_lifetime = is_punct(before(1), '\'');
    // A lower-case name alone is a function if it is called; else a variable, as far as can be told.
    let is_called = matches!(tokens.get(next), Some(TokenTree::Group(group))
        if group.delimiter() == Delimiter::Parenthesis)
        && !is_word(before(1), "fn");
    let is_variable = path.len() == 1 && path[0].starts_with(char::is_lowercase) && !is_called;
    if is_macro_call(tokens, next) {
        into.extend(path.last().map(|name| vec![format!("{name}!")]));
    }
    if !(is_member || is_lifetime || is_variable) {
        into.insert(path);
    }
    next
}

/// Whether what stands before this place is the name of a macro that is called.
fn is_macro_call(tokens: &[TokenTree], at: usize) -> bool {
    is_punct(tokens.get(at), '!') && matches!(tokens.get(at + 1), Some(TokenTree::Group(_)))
}

fn is_punct(token: Option<&TokenTree>, wanted: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == wanted)
}

fn is_word(token: Option<&TokenTree>, wanted: &str) -> bool {
    matches!(token, Some(TokenTree::Ident(word)) if word == wanted)
}
