//! `beeline watch`: shows telemetry and events live, on the whole screen of a terminal or as lines.
//!
//! What is shown is left to [`crate::watch`].

use std::time::Duration;

use host_link::Session;
use host_link::fault_in_words::FaultInWords;
use serde_json::json;
use shared_proto::{Command, Event, Refusal, State, Telemetry};

use super::identify::display_name;
use crate::cli::{Common, WatchArgs, period_ms};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::port::with_robot;
use crate::ui::{BAD, DIM, is_heard, note, paint, say};
use crate::watch::{Column, Condition, Driver, History, Key, Screen, Shown, USUAL, draw};

/// How much of a simulated robot's time is shown, as it exists only as long as the command.
const SIM_S: f64 = 2.0;

/// Frames a second, if nothing else was asked for: of lines, and of a screen.
const LINES_HZ: u16 = 10;
const SCREEN_HZ: u16 = 50;

/// The screen is drawn this often.
const DRAWN_EVERY: Duration = Duration::from_millis(40);

/// A robot on the screen is asked for its condition this often \[us\].
const ASKED_EVERY_US: u64 = 400_000;

pub(super) fn run(common: &Common, args: &WatchArgs) -> Result<()> {
    with_robot(&common.port, &common.sim(), async |session, _| {
        // What takes no time at all cannot be watched.
        let asks_for_lines = args.plain || common.json || !args.columns.is_empty();
        let on_screen = !asks_for_lines && !session.clock().is_virtual() && Screen::is_there();
        if on_screen {
            Watcher::new(common, session).await?.run(args).await
        } else {
            lines(common, args, session).await
        }
    })
}

async fn lines(common: &Common, args: &WatchArgs, session: &mut Session) -> Result<()> {
    let period_ms = period_ms(args.rate.unwrap_or(LINES_HZ));
    let duration_s = args.duration.map(|time| time.s).or(common.port.is_sim().then_some(SIM_S));
    let columns = if args.columns.is_empty() { &USUAL[..] } else { &args.columns[..] };
    subscribe(session, period_ms).await?;
    if !common.json {
        say(paint(DIM, Column::heads(columns)));
    }
    // What was latched before is no event any more.
    if let Some(report) = session.status().await?.fault {
        show_event(common, &Event::Fault(report));
    }
    let start_us = session.clock().now_us();
    let mut checked_us = start_us;
    let (mut shown_us, mut silent) = (0_u64, true);
    loop {
        session.listen(Duration::from_millis(u64::from(period_ms).max(20))).await?;
        let mut heard = session.take_events().all(|event| show_event(common, &event));
        // Another host may have asked for more, before or since.
        let every_us = u64::from(period_ms) * 1000;
        let due: Vec<Telemetry> = session
            .take_telemetry()
            .filter(|frame| {
                let is_due = frame.t_us >= shown_us.saturating_add(every_us);
                shown_us = if is_due { frame.t_us } else { shown_us };
                is_due
            })
            .collect();
        silent &= due.is_empty();
        heard &= due.iter().all(|frame| match common.json {
            true => is_heard(json!(frame)),
            false => is_heard(Column::line(columns, frame)),
        });
        let now_us = session.clock().now_us();
        let elapsed_s = (now_us - start_us) as f64 * 1e-6;
        if !heard || interrupt::requested() || duration_s.is_some_and(|end| elapsed_s >= end) {
            break;
        }
        // Once a second, whether the robot is still there: this fails if it is not.
        if now_us - checked_us > 1_000_000 {
            checked_us = now_us;
            session.status().await?;
            // Its driver may be gone, and the telemetry with it.
            if std::mem::replace(&mut silent, true) || session.overhears() {
                subscribe(session, period_ms).await?;
            }
        }
    }
    leave(session).await
}

/// Ends the telemetry that was asked for, and says what of it was lost.
async fn leave(session: &mut Session) -> Result<()> {
    if !session.overhears() {
        subscribe(session, 0).await?;
    }
    match session.statistics().telemetry_lost {
        0 => {}
        lost => note(paint(DIM, format_args!("{lost} frames of telemetry were lost"))),
    }
    Ok(())
}

/// Requests telemetry; of a robot that another host drives, takes what that one has requested.
async fn subscribe(session: &mut Session, period_ms: u16) -> Result<()> {
    match session.ask(Command::Subscribe { period_ms }).await? {
        Ok(_) => Ok(()),
        Err(Refusal::Driven) => {
            session.overhear();
            Ok(())
        }
        Err(refusal) => {
            Err(host_link::Error::Refused { request: "send telemetry", refusal }.into())
        }
    }
}

/// Shows an event; false if nobody reads the output any more.
fn show_event(common: &Common, event: &Event) -> bool {
    if common.json {
        return is_heard(json!(event));
    }
    match event {
        Event::Fault(report) => note(paint(
            BAD,
            format_args!("fault: {}; {}", FaultInWords(report), report.fault.remedy()),
        )),
        Event::State { t_us, state } => {
            note(paint(DIM, format_args!("{:>9.3}  {}", *t_us as f64 * 1e-6, state.name())));
        }
        Event::MotionEnded { t_us, end, .. } => {
            note(paint(DIM, format_args!("{:>9.3}  motion ended: {end:?}", *t_us as f64 * 1e-6)));
        }
    }
    true
}

/// A robot on the whole screen.
struct Watcher<'s> {
    session: &'s mut Session,
    condition: Condition,
    history: History,
    /// What was shown when the user paused.
    frozen: Option<History>,
    begun_us: u64,
    asked_us: u64,
    /// When the last frame came.
    heard_us: u64,
    /// Frames since then are counted.
    counted: (u64, u32),
    /// Whether a frame came since the condition was asked for.
    silent: bool,
}

impl<'s> Watcher<'s> {
    async fn new(common: &Common, session: &'s mut Session) -> Result<Self> {
        let robot = display_name(&session.identify().await?);
        let now_us = session.clock().now_us();
        let condition = Condition { robot, port: common.port.to_string(), ..Condition::default() };
        Ok(Self {
            session,
            condition,
            history: History::default(),
            frozen: None,
            begun_us: now_us,
            asked_us: now_us,
            heard_us: now_us,
            counted: (now_us, 0),
            silent: true,
        })
    }

    async fn run(mut self, args: &WatchArgs) -> Result<()> {
        let period_ms = period_ms(args.rate.unwrap_or(SCREEN_HZ));
        self.ask(period_ms).await?;
        let colours = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        let failed = |error: std::io::Error| {
            Error::new(format_args!("cannot draw on this terminal: {error}"))
                .hint("--plain prints lines")
        };
        let mut screen = Screen::take().map_err(failed)?;
        loop {
            self.session.listen(DRAWN_EVERY).await?;
            self.take_what_came();
            for key in screen.keys().map_err(failed)? {
                match key {
                    Key::Quit => return self.end(screen).await,
                    Key::Pause => {
                        self.frozen = match self.frozen {
                            Some(_) => None,
                            None => Some(self.history.clone()),
                        };
                    }
                    Key::EmergencyStop => self.stop(period_ms).await?,
                }
            }
            let now_us = self.session.clock().now_us();
            let elapsed_s = (now_us - self.begun_us) as f64 * 1e-6;
            if interrupt::requested() || args.duration.is_some_and(|end| elapsed_s >= end.s) {
                return self.end(screen).await;
            }
            if now_us - self.asked_us > ASKED_EVERY_US {
                self.ask(period_ms).await?;
            }
            let shown = Shown {
                condition: &self.condition,
                history: self.frozen.as_ref().unwrap_or(&self.history),
                paused: self.frozen.is_some(),
                colours,
            };
            screen.draw(|frame| draw(frame, &shown)).map_err(failed)?;
        }
    }

    async fn end(self, screen: Screen) -> Result<()> {
        drop(screen);
        leave(self.session).await
    }

    fn take_what_came(&mut self) {
        let now_us = self.session.clock().now_us();
        let frames: Vec<Telemetry> = self.session.take_telemetry().collect();
        if let Some(last) = frames.last() {
            self.condition.state = Some(last.state);
            (self.heard_us, self.silent) = (now_us, false);
        }
        self.counted.1 += frames.len() as u32;
        frames.iter().for_each(|frame| self.history.push(frame));
        let events: Vec<Event> = self.session.take_events().collect();
        events.iter().for_each(|event| self.condition.note(event));
        let counted_s = (now_us - self.counted.0) as f64 * 1e-6;
        if counted_s >= 1.0 {
            self.condition.rate_hz = f64::from(self.counted.1) / counted_s;
            self.counted = (now_us, 0);
        }
        let statistics = self.session.statistics();
        self.condition.lost = statistics.telemetry_lost;
        self.condition.late = statistics.telemetry_recalled;
        self.condition.silent_s = (now_us - self.heard_us) as f64 * 1e-6;
    }

    /// State and fault. And telemetry: if none has come, another host may have ended it; if the robot moves, the answer says
    /// that another host drives it.
    async fn ask(&mut self, period_ms: u16) -> Result<()> {
        let status = self.session.status().await?;
        self.condition.state = Some(status.state);
        self.condition.set_fault(status.fault.as_ref());
        let moves = !matches!(status.state, State::Boot | State::Idle | State::Faulted);
        if std::mem::replace(&mut self.silent, true) || moves || self.session.overhears() {
            subscribe(self.session, period_ms).await?;
        }
        self.condition.driver = match self.session.overhears() {
            true => Driver::Another,
            false => Driver::Nobody,
        };
        self.asked_us = self.session.clock().now_us();
        Ok(())
    }

    async fn stop(&mut self, period_ms: u16) -> Result<()> {
        let said = match self.session.ask(Command::EmergencyStop).await? {
            Ok(_) => "emergency stop: zero duty".to_owned(),
            Err(refusal) => host_link::Error::Refused { request: "stop", refusal }.to_string(),
        };
        self.condition.say(said);
        self.ask(period_ms).await
    }
}
