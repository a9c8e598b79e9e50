//! What stands in a page: code, links, headings.

use std::collections::BTreeSet;
use std::ops::Range;

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// A piece of a page, and the number of its line.
#[derive(Debug, PartialEq, Eq)]
pub struct Piece {
    pub line: usize,
    pub text: String,
}

/// What stands in a page.
#[derive(Debug, Default)]
pub struct Page {
    /// In backquotes, and line by line in fenced blocks.
    pub code: Vec<Piece>,
    /// Where links and pictures lead.
    pub links: Vec<Piece>,
    /// What a link may name behind `#`.
    pub anchors: BTreeSet<String>,
}

impl Page {
    pub fn read(text: &str) -> Self {
        let mut page = Self::default();
        let mut heading: Option<String> = None;
        let mut is_block = false;
        for (event, range) in Parser::new_ext(text, Options::ENABLE_TABLES).into_offset_iter() {
            match event {
                Event::Code(code) => {
                    heading.iter_mut().for_each(|heading| heading.push_str(&code));
                    page.code.push(piece(text, &range, &code));
                }
                Event::Text(words) => {
                    heading.iter_mut().for_each(|heading| heading.push_str(&words));
                    if is_block {
                        let first = piece(text, &range, "").line;
                        let lines = words.lines().enumerate();
                        let lines =
                            lines.map(|(n, line)| Piece { line: first + n, text: line.into() });
                        page.code.extend(lines);
                    }
                }
                Event::Start(Tag::CodeBlock(_)) => is_block = true,
                Event::End(TagEnd::CodeBlock) => is_block = false,
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push(piece(text, &range, &dest_url));
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    let heading = heading.take().unwrap_or_default();
                    page.add_anchor(&anchor(&heading));
                }
                _ => {}
            }
        }
        page
    }

    /// The second heading of the same words is `words-1`.
    fn add_anchor(&mut self, anchor: &str) {
        let numbered = (1..).map(|number| format!("{anchor}-{number}"));
        let mut names = std::iter::once(anchor.to_string()).chain(numbered);
        let free = names.find(|name| !self.anchors.contains(name));
        self.anchors.extend(free);
    }
}

fn piece(page: &str, range: &Range<usize>, text: &str) -> Piece {
    let line = page[..range.start].matches('\n').count() + 1;
    Piece { line, text: text.into() }
}

/// A heading as a link names it, by GitHub's rule.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
    heading.trim().to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-")
}
