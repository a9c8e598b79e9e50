//! A procedure that the page guides through: a command of the terminal, whose questions the page asks.
//!
//! The command drives the robot over a link of its own. The page keeps its motions alive: no lease ends later than one after
//! the page's last sign of life ([`host_link::Holder`]).

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use serde_json::{Value, json};

use super::asked::{Asked, on_page};
use super::campaign_so_far::follow;
use crate::dialogue::Dialogue;
use crate::error::{Error, Result};

/// Runs a command line for the page.
pub type RunCommand = Box<dyn Fn(&[String]) -> Result<()> + Send + Sync>;

/// Serves the page of a campaign's model; returns its link.
pub type ServeModel = Box<dyn Fn(&Path) -> Result<String> + Send + Sync>;

/// The procedures of a page: one at a time.
pub struct Procedures {
    run: RunCommand,
    serve_model: ServeModel,
    /// Its number, from 1, and the procedure.
    last: Mutex<(u64, Option<Arc<Procedure>>)>,
}

/// A procedure that runs, or has run last.
pub struct Procedure {
    asked: Asked,
    /// The page that keeps its motions alive.
    holder: AtomicU64,
    dialogue: Arc<Dialogue>,
    ended: OnceLock<Result<()>>,
    /// What its campaign's folder says by now.
    campaign: Mutex<Value>,
}

impl Procedures {
    /// None so far.
    pub fn new(run: RunCommand, serve_model: ServeModel) -> Self {
        Self { run, serve_model, last: Mutex::default() }
    }

    /// Begins one, held by this page; the error is for the page to show.
    pub fn begin(self: &Arc<Self>, asked: Asked, page: u64) -> std::result::Result<(), String> {
        let args = asked.args()?;
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.1.as_ref().is_some_and(|procedure| procedure.runs()) {
            return Err("a procedure runs already: stop it first".to_owned());
        }
        let procedure = Arc::new(Procedure {
            asked,
            holder: page.into(),
            dialogue: Arc::default(),
            ended: OnceLock::new(),
            campaign: Mutex::default(),
        });
        *last = (last.0 + 1, Some(Arc::clone(&procedure)));
        drop(last);
        if let Some(folder) = procedure.asked.folder() {
            let beside = Arc::clone(&procedure);
            std::thread::spawn(move || {
                follow(&folder, || !beside.runs(), |so_far| beside.set_campaign(so_far));
            });
        }
        let procedures = Arc::clone(self);
        std::thread::spawn(move || {
            let run = || procedure.dialogue.run(|| (procedures.run)(&args));
            let outcome = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| {
                Err(Error::new("the procedure has ended by a mistake of Beeline's")
                    .hint("`beeline identify` shows the robot's state, `beeline stop` stops it"))
            });
            // It ends once.
            let _ = procedure.ended.set(outcome);
            procedure.dialogue.touch();
        });
        Ok(())
    }

    /// The procedure that runs.
    pub fn running(&self) -> Option<Arc<Procedure>> {
        self.last().1.filter(|procedure| procedure.runs())
    }

    /// Ends it in good order.
    pub fn stop(&self) {
        if let Some(procedure) = self.running() {
            procedure.dialogue.cancel().request();
        }
    }

    /// What the page shows, if it is newer than what it has `seen`; and its age for the next time.
    pub fn news(&self, seen: (u64, u64)) -> (Option<Value>, (u64, u64)) {
        let (number, procedure) = self.last();
        let changes = procedure.as_ref().map_or(0, |procedure| procedure.dialogue.changes() + 1);
        let now = (number, changes);
        let value = (now != seen).then(|| procedure.map_or(Value::Null, |one| one.to_json(number)));
        (value, now)
    }

    /// Serves the page on which effects are switched, of the last campaign.
    pub fn serve_model(&self) -> std::result::Result<String, String> {
        let folder = self.last().1.and_then(|procedure| procedure.asked.folder());
        let folder = folder.ok_or("no campaign was recorded here")?;
        (self.serve_model)(&folder).map_err(|error| error.to_string())
    }

    /// The drawing of the last procedure, if that was a calibration.
    pub fn drawing(&self) -> Option<PathBuf> {
        self.last().1?.drawing()
    }

    fn last(&self) -> (u64, Option<Arc<Procedure>>) {
        self.last.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Procedure {
    fn runs(&self) -> bool {
        self.ended.get().is_none()
    }

    /// A sign of life of a page: of one that does not hold it, nothing, unless it `takes` it from the other.
    pub fn beat(&self, page: u64, takes: bool) {
        if takes && self.holder.swap(page, Ordering::Relaxed) != page {
            self.dialogue.touch();
        }
        if self.holder.load(Ordering::Relaxed) == page {
            self.dialogue.holder().beat();
        }
    }

    /// The page's answer to the question of this number; false if that is no longer asked.
    pub fn answer(&self, number: u32, text: &str) -> bool {
        self.dialogue.answer(number, text)
    }

    fn set_campaign(&self, so_far: Value) {
        *self.campaign.lock().unwrap_or_else(PoisonError::into_inner) = so_far;
        self.dialogue.touch();
    }

    fn drawing(&self) -> Option<PathBuf> {
        let done = matches!(self.ended.get(), Some(Ok(())));
        self.asked.drawing().filter(|file| done && file.is_file())
    }

    fn to_json(&self, number: u64) -> Value {
        let mut value = self.dialogue.to_json();
        value["kind"] = json!(self.asked.name());
        value["running"] = json!(self.runs());
        value["held_by"] = json!(self.holder.load(Ordering::Relaxed));
        value["folder"] = json!(self.asked.folder());
        value["campaign"] = self.campaign.lock().unwrap_or_else(PoisonError::into_inner).clone();
        value["drawing"] = json!(self.drawing().map(|_| format!("api/drawing?number={number}")));
        value["ended"] = match self.ended.get() {
            None => Value::Null,
            Some(Ok(())) => json!({"ok": true}),
            Some(Err(error)) => {
                // The state of a robot that was stopped stands on the page already.
                let hint = error.hint_text().filter(|_| !error.is_interrupted());
                json!({
                    "ok": false,
                    "said_no": error.exit_code() == 1,
                    "error": on_page(&error.to_string()),
                    "hint": hint.map(on_page),
                })
            }
        };
        value
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;
    use crate::question::Question;
    use crate::ui;

    fn procedures(
        run: impl Fn(&[String]) -> Result<()> + Send + Sync + 'static,
    ) -> Arc<Procedures> {
        let serve_model = |_: &Path| Ok(String::new());
        Arc::new(Procedures::new(Box::new(run), Box::new(serve_model)))
    }

    fn calibrate() -> Asked {
        serde_json::from_value(json!({"kind": "calibrate", "options": {"distance": "2m"}})).unwrap()
    }

    /// What the page shows once this holds.
    fn shown(procedures: &Procedures, holds: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let shown = procedures.news((0, 0)).0.unwrap();
            if holds(&shown) {
                return shown;
            }
            assert!(begun.elapsed() < Duration::from_secs(20), "{shown}");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn a_command_asks_on_the_page_and_its_lines_are_shown_there() {
        let procedures = procedures(|args| {
            ui::note(ui::paint(ui::BOLD, "Calibrating"));
            let asked = Question::new("How far?");
            let answer = host_link::block_on(ui::ask(&asked, &host_link::Clock::real()))?;
            ui::say(format_args!("{} {answer}", args[0]));
            // What is from outside cannot pass for a line of ours.
            ui::note("a\nb");
            ui::say_text("two\nlines");
            Err(Error::said_no("not straight").hint("measure again"))
        });
        assert_eq!(procedures.news((0, 0)), (None, (0, 0)));
        procedures.begin(calibrate(), 7).unwrap();
        let asked = shown(&procedures, |shown| shown["question"].is_object());
        assert_eq!(asked["question"]["text"], "How far?");
        assert_eq!(asked["lines"][0], json!([["bold", "Calibrating"]]));
        assert!(procedures.begin(calibrate(), 7).unwrap_err().contains("runs already"));
        assert!(procedures.running().unwrap().answer(1, "-36mm"));
        let ended = shown(&procedures, |shown| shown["running"] == false);
        assert_eq!(ended["lines"][2], json!([["plain", "calibrate -36mm"]]));
        assert_eq!(ended["lines"][3], json!([["plain", r"a\u000ab"]]));
        assert_eq!(ended["lines"].as_array().unwrap().len(), 6);
        let said = json!({
            "ok": false, "said_no": true, "error": "not straight", "hint": "measure again"
        });
        assert_eq!(ended["ended"], said);
        assert!(procedures.running().is_none());
    }

    #[test]
    fn only_the_page_that_holds_a_procedure_keeps_it_alive() {
        let held = procedures(|_| {
            let holder = crate::dialogue::current().unwrap().holder().clone();
            while !holder.is_gone() {
                std::thread::sleep(Duration::from_millis(1));
            }
            Ok(())
        });
        held.begin(calibrate(), 7).unwrap();
        let procedure = held.running().unwrap();
        let begun = Instant::now();
        let (first, second) = (Duration::from_millis(300), Duration::from_millis(600));
        while let Some(procedure) = held.running() {
            let lasts = begun.elapsed();
            procedure.beat(8, lasts > first && lasts < second);
            if lasts < first {
                procedure.beat(7, false);
            }
            assert!(lasts < Duration::from_secs(20));
            // Of whoever gave it away, nothing counts any more.
            if lasts > second {
                procedure.beat(7, false);
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        assert!(begun.elapsed() > first, "it is kept alive");
        assert_eq!(procedure.to_json(1)["held_by"], 8);
        shown(&held, |shown| shown["running"] == false);
    }

    #[test]
    fn a_stop_ends_a_command_that_asks_and_a_mistake_is_an_error() {
        let asking = procedures(|_| {
            let asked = Question::new("How far?");
            host_link::block_on(ui::ask(&asked, &host_link::Clock::real())).map(drop)
        });
        asking.begin(calibrate(), 7).unwrap();
        shown(&asking, |shown| shown["question"].is_object());
        asking.stop();
        let ended = shown(&asking, |shown| shown["running"] == false);
        assert_eq!(ended["ended"]["error"], "stopped on the page");
        let mistaken = procedures(|_| panic!("a mistake"));
        mistaken.begin(calibrate(), 7).unwrap();
        let ended = shown(&mistaken, |shown| shown["running"] == false);
        assert!(ended["ended"]["error"].as_str().unwrap().contains("mistake"));
    }
}
