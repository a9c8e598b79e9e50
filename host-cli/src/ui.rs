//! What the user sees while a command runs: lines, progress, questions.
//!
//! Results go to standard output, everything else to standard error. There are colours only on a
//! terminal. The text of the lines is left to the commands.

use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use anstyle::{AnsiColor, Style};
use indicatif::{ProgressBar, ProgressStyle};

use campaign::bounded_text::bounded;

use crate::dialogue::{self, Dialogue};
use crate::error::{Error, Result};
use crate::escape::{self, style_mark};
use crate::interrupt;
use crate::question::Question;
use host_link::Clock;

/// Emphasis.
pub const BOLD: Style = Style::new().bold();
/// Secondary text.
pub const DIM: Style = Style::new().dimmed();
/// Success.
pub const GOOD: Style = AnsiColor::Green.on_default();
/// Failure.
pub const BAD: Style = AnsiColor::Red.on_default().bold();
/// A warning.
pub const WARN: Style = AnsiColor::Yellow.on_default();

/// `1 run`, `3 runs`.
pub fn runs(count: usize) -> String {
    format!("{count} run{}", if count == 1 { "" } else { "s" })
}

/// The styles, in the order of their marks.
const STYLES: [Style; 5] = [BOLD, DIM, GOOD, BAD, WARN];

/// What a page calls them, and what has none.
const STYLE_NAMES: [&str; 6] = ["bold", "dim", "good", "bad", "warn", "plain"];

/// The mark at which a style ends.
const PLAIN: u8 = STYLES.len() as u8;

/// Text in a style: between marks, which become the terminal's codes when the line is printed. A code in the text itself, from a
/// file say, is no mark.
pub fn paint(style: Style, text: impl Display) -> String {
    match STYLES.iter().position(|known| *known == style) {
        Some(number) => format!("{}{text}{}", style_mark(number as u8), style_mark(PLAIN)),
        None => text.to_string(),
    }
}

/// The terminal's code for a mark.
fn style_code(number: u8) -> String {
    match STYLES.get(usize::from(number)) {
        Some(style) => style.to_string(),
        None => anstyle::Reset.to_string(),
    }
}

/// A line as a terminal may have it.
fn line_of(text: impl Display) -> String {
    escape::terminal(&text.to_string(), true, style_code)
}

/// Gives lines to the page that runs this command; false if none does. A line feed within a line is shown as such.
fn is_for_page<'a>(lines: impl IntoIterator<Item = &'a str>) -> bool {
    let Some(dialogue) = dialogue::current() else { return false };
    for line in lines {
        let named = |(style, text): (u8, String)| {
            (STYLE_NAMES.get(usize::from(style)).copied().unwrap_or("plain"), text)
        };
        dialogue.line(escape::pieces(line, PLAIN).into_iter().map(named).collect());
    }
    true
}

/// Prints a line of the result. A reader that has gone away is not an error.
pub fn say(line: impl Display) {
    let _ = is_heard(line);
}

/// Prints a result of several lines.
pub fn say_text(text: impl Display) {
    let text = text.to_string();
    let _ = is_for_page(text.split('\n')) || print(&escape::terminal(&text, false, style_code));
}

/// The first error of writing a line of the result.
static WRITE_ERROR: OnceLock<String> = OnceLock::new();

/// Prints a line of the result; false if its reader has gone away, or the line cannot be written.
pub fn is_heard(line: impl Display) -> bool {
    let line = line.to_string();
    is_for_page([&*line]) || print(&line_of(line))
}

fn print(line: &str) -> bool {
    let mut stdout = anstream::stdout().lock();
    match writeln!(stdout, "{line}").and_then(|()| stdout.flush()) {
        Ok(()) => true,
        Err(error) => {
            if error.kind() != ErrorKind::BrokenPipe {
                let _later_error = WRITE_ERROR.set(error.to_string());
            }
            false
        }
    }
}

/// An error if part of the result could not be written, as on a full disk. A reader that has gone
/// away is not an error.
pub fn finish_output() -> Result<()> {
    match WRITE_ERROR.get() {
        None => Ok(()),
        Some(error) => {
            Err(Error::new(format_args!("cannot write the result to standard output: {error}"))
                .hint("the command itself has finished; is the output's disk full?"))
        }
    }
}

/// Prints a line about the progress of the command.
pub fn note(line: impl Display) {
    let line = line.to_string();
    let _ =
        is_for_page([&*line]) || writeln!(anstream::stderr().lock(), "{}", line_of(line)).is_ok();
}

/// Prints several lines about the progress of the command.
pub fn note_text(text: impl Display) {
    text.to_string().lines().for_each(note);
}

/// Prints that something was done: as a line of text, or as a JSON value.
pub fn tell(json: bool, value: serde_json::Value, line: impl Display) {
    if json {
        say(value);
    } else {
        note(line);
    }
}

/// Prints a warning.
pub fn warn(line: impl Display) {
    let line = line.to_string();
    let line = bounded(&line, &[]);
    if let Some(dialogue) = dialogue::current() {
        dialogue.warning(&line_of(&line));
    }
    note(format_args!("{} {line}", paint(WARN, "warning:")));
}

/// Begins a line below an error's own, as of an equation with the place of a mistake. A text from outside that has it
/// cannot pass for a line of ours, which is never indented.
const BELOW: &str = "\n    ";

/// Prints an error and what to try.
pub fn print_error(error: &Error, json: bool) {
    if json {
        say(error.to_json());
        return;
    }
    let text = error.to_string();
    let mut lines = text.split(BELOW);
    note(format_args!("{} {}", paint(BAD, "error:"), lines.next().unwrap_or_default()));
    lines.for_each(|line| note(format_args!("    {line}")));
    if let Some(hint) = error.hint_text() {
        note(format_args!("  {} {hint}", paint(BOLD, "try:")));
    }
}

/// A progress bar: on a page, or on a terminal if standard error is one.
pub struct Progress {
    bar: ProgressBar,
    page: Option<(Arc<Dialogue>, String)>,
}

impl Progress {
    /// A progress bar with a title.
    pub fn new(title: impl Into<String>, quiet: bool) -> Self {
        let title = line_of(title.into());
        if let Some(dialogue) = dialogue::current().filter(|_| !quiet) {
            dialogue.progress(Some((&title, 0.0)));
            return Self { bar: ProgressBar::hidden(), page: Some((dialogue, title)) };
        }
        if quiet || !std::io::stderr().is_terminal() {
            return Self { bar: ProgressBar::hidden(), page: None };
        }
        let style = ProgressStyle::with_template("  {msg:<28} {bar:40.green/dim} {percent:>3} %")
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("━╸─");
        Self { bar: ProgressBar::new(1000).with_style(style).with_message(title), page: None }
    }

    /// Sets the share that is done.
    pub fn set(&self, share: f64) {
        self.bar.set_position((share * 1000.0) as u64);
        if let Some((dialogue, title)) = &self.page {
            dialogue.progress(Some((title, share)));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
        if let Some((dialogue, _)) = &self.page {
            dialogue.progress(None);
        }
    }
}

/// What was found so far, one line for each finding, and what is being done; invisible if standard error is not a terminal.
pub struct Steps(ProgressBar);

impl Steps {
    /// Nothing so far.
    pub fn new(quiet: bool) -> Self {
        if quiet || dialogue::current().is_some() || !std::io::stderr().is_terminal() {
            return Self(ProgressBar::hidden());
        }
        let style = ProgressStyle::with_template("  {spinner} {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_spinner());
        let bar = ProgressBar::new_spinner().with_style(style);
        bar.enable_steady_tick(Duration::from_millis(120));
        Self(bar)
    }

    /// Whether anybody sees them.
    pub fn are_seen(&self) -> bool {
        !self.0.is_hidden()
    }

    /// Prints what was found, to stay.
    pub fn found(&self, line: &str) {
        self.0.println(line_of(paint(DIM, format_args!("  {line}"))));
    }

    /// Shows what is being done until the next thing is.
    pub fn now(&self, doing: &'static str) {
        self.0.set_message(doing);
    }
}

impl Drop for Steps {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// What to try if nobody answers.
const NOBODY: &str =
    "run it in a terminal; where a command has them, --yes and --measure track:FILE need nobody";

/// Asks the user and waits for an answer, which may be empty.
pub async fn ask(question: &Question, clock: &Clock) -> Result<String> {
    if let Some(dialogue) = dialogue::current() {
        return ask_page(&dialogue, question, clock).await;
    }
    {
        let mut stderr = anstream::stderr().lock();
        let line = format_args!("{} {}", paint(BOLD, "?"), question.on_terminal()).to_string();
        let _ = write!(stderr, "{} ", line_of(line));
        let _ = stderr.flush();
    }
    let (sender, receiver) = async_channel::bounded(1);
    // In a thread, as reading blocks: Ctrl-C must not wait for it.
    std::thread::spawn(move || {
        let mut line = String::new();
        let _ = sender.send_blocking(std::io::stdin().read_line(&mut line).map(|len| (len, line)));
    });
    loop {
        match receiver.try_recv() {
            Ok(Ok((0, _))) => {
                note("");
                return Err(Error::new("there is nobody to answer the question").hint(NOBODY));
            }
            Ok(Ok((_, line))) => {
                let answer = line.trim();
                if !std::io::stdin().is_terminal() {
                    // A terminal shows what was typed; a pipe does not.
                    note(answer);
                }
                return Ok(answer.to_owned());
            }
            Ok(Err(error)) => {
                note("");
                return Err(
                    Error::new(format_args!("cannot read the answer: {error}")).hint(NOBODY)
                );
            }
            Err(_) if interrupt::requested() => {
                note("");
                return Err(Error::interrupted(interrupt::words()));
            }
            // In virtual time the simulated robot waits too.
            Err(_) if clock.is_virtual() => std::thread::sleep(LOOKED_EVERY),
            Err(_) => clock.sleep(LOOKED_EVERY).await,
        }
    }
}

/// For an answer is looked this often.
const LOOKED_EVERY: Duration = Duration::from_millis(50);

async fn ask_page(dialogue: &Dialogue, question: &Question, clock: &Clock) -> Result<String> {
    dialogue.ask(question);
    loop {
        if let Some(answer) = dialogue.take_answer() {
            note(format_args!("{} {} {answer}", paint(BOLD, "?"), question.text()));
            return Ok(answer.trim().to_owned());
        }
        if interrupt::requested() {
            dialogue.withdraw();
            return Err(Error::interrupted(interrupt::words()));
        }
        clock.sleep(LOOKED_EVERY).await;
    }
}
