//! The code in a page, and a command line as a shell takes it apart.

use pulldown_cmark::{CodeBlockKind, Event, Parser as Markdown, Tag, TagEnd};

/// Code in a page: between backquotes, or a line of a fenced block.
#[derive(Debug)]
pub struct Code {
    pub line: usize,
    pub text: String,
    pub is_block: bool,
    pub is_toml: bool,
}

/// All code in a page.
pub fn code_in(page: &str) -> Vec<Code> {
    let mut code = Vec::new();
    let (mut is_block, mut is_toml) = (false, false);
    let options = pulldown_cmark::Options::ENABLE_TABLES;
    for (event, range) in Markdown::new_ext(page, options).into_offset_iter() {
        let line = page[..range.start].matches('\n').count() + 1;
        match event {
            Event::Start(Tag::CodeBlock(kind)) => {
                is_block = true;
                is_toml = matches!(kind, CodeBlockKind::Fenced(language) if &*language == "toml");
            }
            Event::End(TagEnd::CodeBlock) => (is_block, is_toml) = (false, false),
            Event::Code(text) => code.push(Code { line, text: text.into(), is_block, is_toml }),
            Event::Text(text) if is_block => {
                let lines = text.lines().zip(line..);
                let lines =
                    lines.map(|(text, line)| Code { line, text: text.into(), is_block, is_toml });
                code.extend(lines);
            }
            _ => {}
        }
    }
    code
}

/// The words of the first command in a line.
pub fn shell_words(line: &str) -> Vec<String> {
    shell_commands(line).into_iter().next().unwrap_or_default()
}

/// The words of each command in a line, up to a comment or where its output goes, without variables in front.
pub fn shell_commands(line: &str) -> Vec<Vec<String>> {
    let mut commands = vec![Vec::new()];
    let mut word: Option<String> = None;
    let mut quote = None;
    for c in line.chars() {
        let Some(words) = commands.last_mut() else { break };
        match quote {
            Some(end) if c == end => quote = None,
            None if c == '"' || c == '\'' => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            None if c.is_whitespace() => words.extend(word.take()),
            None if word.is_none() && "#>\\".contains(c) => break,
            None if c == ';' || (word.is_none() && "|&".contains(c)) => {
                words.extend(word.take());
                commands.push(Vec::new());
            }
            _ => word.get_or_insert_default().push(c),
        }
    }
    commands.last_mut().expect("there is one").extend(word);
    for words in &mut commands {
        let is_variable = |word: &String| {
            let name = word.split_once('=').map_or("", |(name, _)| name);
            !name.is_empty() && name.chars().all(|c| c.is_ascii_uppercase() || c == '_')
        };
        let variables = words.iter().take_while(|word| is_variable(word)).count();
        words.drain(..variables);
    }
    commands
}

#[test]
fn every_command_of_a_line_is_seen() {
    let line =
        "cd a && X_Y=1 beeline stop --now | grep 'a; b'; beeline identify > file # beeline x";
    let commands: Vec<String> = shell_commands(line).iter().map(|words| words.join(" ")).collect();
    assert_eq!(commands, ["cd a", "", "beeline stop --now", "grep a; b", "beeline identify"]);
}
