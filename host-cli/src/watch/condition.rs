//! How the robot is: state, faults, who drives, how the link is; all in words.

use std::collections::VecDeque;

use host_link::fault_in_words::FaultInWords;
use shared_proto::{Event, FaultReport, MotionEnd, State};

/// So many of the last events are shown.
const EVENTS: usize = 50;

/// Who drives, as far as a host that watches is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Driver {
    /// The robot stands still, and would obey the next one.
    #[default]
    Nobody,
    /// Another host.
    Another,
}

/// How the robot is.
#[derive(Clone, Debug, Default)]
pub struct Condition {
    /// Its name, or that of its board.
    pub robot: String,
    /// Where it is reached.
    pub port: String,
    /// Its state; none before it is known.
    pub state: Option<State>,
    /// What is wrong, and what to do.
    pub fault: Option<(String, String)>,
    /// Who drives.
    pub driver: Driver,
    /// Frames that were lost for good.
    pub lost: u64,
    /// Frames that came late: lost, asked for again and received.
    pub late: u64,
    /// Frames in the last second.
    pub rate_hz: f64,
    /// How long no frame has come \[s\].
    pub silent_s: f64,
    /// What happened, the newest last.
    pub events: VecDeque<String>,
}

impl Condition {
    /// Notes the latched fault, or that there is none.
    pub fn set_fault(&mut self, fault: Option<&FaultReport>) {
        let words =
            |report: &FaultReport| (FaultInWords(report).to_string(), report.fault.remedy().into());
        self.fault = fault.map(words);
    }

    /// Notes an event.
    pub fn note(&mut self, event: &Event) {
        let (t_us, words) = match event {
            Event::Fault(report) => {
                self.set_fault(Some(report));
                self.state = Some(State::Faulted);
                (report.t_us, format!("fault: {}", report.fault))
            }
            Event::State { t_us, state } => {
                self.state = Some(*state);
                (*t_us, state.name().to_owned())
            }
            Event::MotionEnded { t_us, end, .. } => (*t_us, end_in_words(*end).to_owned()),
        };
        self.say(format!("{:.1} s  {words}", t_us as f64 * 1e-6));
    }

    /// Adds a line to what happened.
    pub fn say(&mut self, line: String) {
        if self.events.len() >= EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(line);
    }
}

/// How a motion ended.
fn end_in_words(end: MotionEnd) -> &'static str {
    match end {
        MotionEnd::Completed => "motion completed",
        MotionEnd::Stopped => "motion stopped",
        _ => "motion ended early",
    }
}
