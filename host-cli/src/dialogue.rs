//! What a command says and asks when a page runs it instead of a terminal.
//!
//! A command knows nothing of it: where its words go is a matter of the thread on which it runs ([`Dialogue::run`]). What is
//! printed and asked through [`crate::ui`] then comes here, and so does Ctrl-C, as the page's Stop.

use std::cell::RefCell;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use host_link::{Cancel, Holder};
use serde_json::{Value, json};

use crate::question::Question;

/// So many lines are kept; then the oldest go.
const LINES_MAX: usize = 1000;

thread_local! {
    static CURRENT: RefCell<Option<Arc<Dialogue>>> = const { RefCell::new(None) };
}

/// What one command says and asks; shared between its thread and the page's server.
#[derive(Default)]
pub struct Dialogue {
    said: Mutex<Said>,
    changes: AtomicU64,
    cancel: Cancel,
    holder: Holder,
}

#[derive(Default)]
struct Said {
    /// Each a list of pieces, the style and the text of each.
    lines: Vec<Vec<(&'static str, String)>>,
    progress: Option<(String, f64)>,
    /// How many questions there have been: the number of the last.
    asked: u32,
    question: Option<Value>,
    /// The last answer, and the warnings since: what is wrong with it, if it is asked again.
    before: Option<(String, Vec<String>)>,
    answer: Option<String>,
}

/// The dialogue of this thread's command, if a page runs it.
pub fn current() -> Option<Arc<Dialogue>> {
    CURRENT.with_borrow(Clone::clone)
}

impl Dialogue {
    /// Runs a command whose words go to this dialogue.
    pub fn run<T>(self: &Arc<Self>, command: impl FnOnce() -> T) -> T {
        /// Also if the command panics.
        struct Leave;
        impl Drop for Leave {
            fn drop(&mut self) {
                CURRENT.set(None);
            }
        }
        CURRENT.set(Some(Arc::clone(self)));
        let _leave = Leave;
        command()
    }

    /// The request to end, which the page's Stop makes.
    pub fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    /// Whoever holds the page: without signs of life, no motion goes on.
    pub fn holder(&self) -> &Holder {
        &self.holder
    }

    /// Rises with every change.
    pub fn changes(&self) -> u64 {
        self.changes.load(Ordering::Acquire)
    }

    /// Has the page shown anew.
    pub fn touch(&self) {
        self.changes.fetch_add(1, Ordering::AcqRel);
    }

    /// A line: its pieces, each in a style.
    pub fn line(&self, pieces: Vec<(&'static str, String)>) {
        let mut said = self.said();
        said.lines.push(pieces);
        let over = said.lines.len().saturating_sub(LINES_MAX);
        said.lines.drain(..over);
        drop(said);
        self.touch();
    }

    /// A warning, which may be about the last answer.
    pub fn warning(&self, text: &str) {
        if let Some((_, warnings)) = &mut self.said().before {
            warnings.push(text.to_owned());
        }
    }

    /// How far a motion is; `None` once it is over.
    pub fn progress(&self, progress: Option<(&str, f64)>) {
        let mut said = self.said();
        // Whatever was answered before it drove was in order.
        said.before = None;
        // The page shows whole percents.
        let now =
            progress.map(|(title, share)| (title.to_owned(), (share * 100.0).floor() / 100.0));
        if said.progress != now {
            said.progress = now;
            drop(said);
            self.touch();
        }
    }

    /// Puts a question; [`answer`](Self::take_answer) tells what was said to it.
    pub fn ask(&self, question: &Question) {
        let mut said = self.said();
        said.asked += 1;
        said.answer = None;
        let mut value = question.to_json(said.asked);
        if let Some((answer, warnings)) = said.before.take().filter(|(_, all)| !all.is_empty()) {
            value["refused"] = json!({"answer": answer, "why": warnings.join(" ")});
        }
        said.question = Some(value);
        drop(said);
        self.touch();
    }

    /// The page's answer to the question of this number; an answer to another comes too late.
    pub fn answer(&self, number: u32, text: &str) -> bool {
        let mut said = self.said();
        if said.question.is_none() || said.asked != number || said.answer.is_some() {
            return false;
        }
        said.answer = Some(text.to_owned());
        drop(said);
        self.touch();
        true
    }

    /// What was said to the question, once; it is then no longer shown.
    pub fn take_answer(&self) -> Option<String> {
        let mut said = self.said();
        let answer = said.answer.take()?;
        said.question = None;
        said.before = Some((answer.clone(), Vec::new()));
        drop(said);
        self.touch();
        Some(answer)
    }

    /// Takes the question back.
    pub fn withdraw(&self) {
        self.said().question = None;
        self.touch();
    }

    /// All that the page shows of it.
    pub fn to_json(&self) -> Value {
        let said = self.said();
        let progress = said.progress.as_ref();
        json!({
            "lines": said.lines,
            "progress": progress.map(|(title, share)| json!({"title": title, "share": share})),
            "question": said.question,
        })
    }

    fn said(&self) -> MutexGuard<'_, Said> {
        // Whoever panicked while it was locked left whole values.
        self.said.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_for_its_question_and_taken_once() {
        let dialogue = Dialogue::default();
        assert!(!dialogue.answer(0, "early"));
        dialogue.ask(&Question::new("How far?"));
        assert!(!dialogue.answer(2, "of another"));
        assert!(dialogue.answer(1, "12mm"));
        assert!(!dialogue.answer(1, "13mm"));
        assert_eq!(dialogue.take_answer().as_deref(), Some("12mm"));
        assert_eq!(dialogue.take_answer(), None);
        assert_eq!(dialogue.to_json()["question"], Value::Null);
        assert!(!dialogue.answer(1, "late"));
        // It is asked again, with what is wrong with the answer.
        dialogue.warning("too far");
        dialogue.ask(&Question::new("How far?"));
        let refused = json!({"answer": "12mm", "why": "too far"});
        assert_eq!(dialogue.to_json()["question"]["refused"], refused);
        assert!(dialogue.answer(2, "1mm") && dialogue.take_answer().is_some());
        dialogue.ask(&Question::new("And now?"));
        assert_eq!(dialogue.to_json()["question"]["refused"], Value::Null);
    }

    #[test]
    fn a_threads_dialogue_ends_with_its_command() {
        let dialogue = Arc::new(Dialogue::default());
        dialogue.run(|| assert!(current().is_some()));
        assert!(current().is_none());
        let panicked = std::panic::catch_unwind(|| dialogue.run(|| panic!("a mistake")));
        assert!(panicked.is_err() && current().is_none());
    }
}
