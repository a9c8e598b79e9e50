//! The whole screen of a terminal: taken, drawn on, and given back, whatever happens.

use std::io::{IsTerminal, Stdout, Write, stdout};
use std::panic;
use std::time::Duration;

use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use ratatui::crossterm::terminal::{
    EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use ratatui::crossterm::{cursor, execute};
use ratatui::{Frame, Terminal};

/// What a user wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// No more.
    Quit,
    /// Zero duty at once.
    EmergencyStop,
    /// The curves stand still, or go on.
    Pause,
}

/// The screen; dropped, the terminal is as it was.
pub struct Screen {
    terminal: Terminal<CrosstermBackend<Stdout>>,
}

impl Screen {
    /// Whether there is one, and somebody at its keys.
    pub fn is_there() -> bool {
        stdout().is_terminal() && std::io::stdin().is_terminal()
    }

    /// Takes the screen.
    pub fn take() -> std::io::Result<Self> {
        enable_raw_mode()?;
        // From here on it is given back, even if the rest fails.
        let guard = GiveBack;
        execute!(stdout(), EnterAlternateScreen, cursor::Hide)?;
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |panicked| {
            give_back();
            before(panicked);
        }));
        let terminal = Terminal::new(CrosstermBackend::new(stdout()))?;
        std::mem::forget(guard);
        Ok(Self { terminal })
    }

    /// Draws; a terminal that has another size since is drawn anew.
    pub fn draw(&mut self, view: impl FnOnce(&mut Frame<'_>)) -> std::io::Result<()> {
        self.terminal.draw(view).map(drop)
    }

    /// The keys that were pressed since the last time.
    pub fn keys(&self) -> std::io::Result<Vec<Key>> {
        let mut keys = Vec::new();
        while event::poll(Duration::ZERO)? {
            if let Event::Key(key) = event::read()?
                && key.kind != KeyEventKind::Release
            {
                let control = key.modifiers.contains(KeyModifiers::CONTROL);
                keys.extend(key_of(key.code, control));
            }
        }
        Ok(keys)
    }
}

fn key_of(code: KeyCode, control: bool) -> Option<Key> {
    match code {
        KeyCode::Char('c' | 'd') if control => Some(Key::Quit),
        KeyCode::Char('q' | 'Q') | KeyCode::Esc => Some(Key::Quit),
        KeyCode::Char('s' | 'S' | ' ') if !control => Some(Key::EmergencyStop),
        KeyCode::Char('p' | 'P') => Some(Key::Pause),
        _ => None,
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        give_back();
    }
}

struct GiveBack;

impl Drop for GiveBack {
    fn drop(&mut self) {
        give_back();
    }
}

/// Gives the terminal back. A terminal that is gone needs nothing.
fn give_back() {
    let _ = execute!(stdout(), LeaveAlternateScreen, cursor::Show);
    let _ = disable_raw_mode();
    let _ = stdout().flush();
}
