//! What is drawn, and in which styles.

use ratatui::style::{Color, Modifier, Style};

use super::condition::Condition;
use super::history::History;

/// What is drawn, and how.
pub struct Shown<'a> {
    /// How the robot is, now.
    pub condition: &'a Condition,
    /// The last seconds; as they were when the user paused.
    pub history: &'a History,
    /// The curves stand still.
    pub paused: bool,
    /// Colours may be used.
    pub colours: bool,
}

impl Shown<'_> {
    fn colour(&self, colour: Color, otherwise: Modifier) -> Style {
        match self.colours {
            true => Style::new().fg(colour).add_modifier(otherwise),
            false => Style::new().add_modifier(otherwise),
        }
    }

    pub(super) fn good(&self) -> Style {
        self.colour(Color::Green, Modifier::empty())
    }

    pub(super) fn bad(&self) -> Style {
        self.colour(Color::Red, Modifier::BOLD)
    }

    pub(super) fn attention(&self) -> Style {
        self.colour(Color::Yellow, Modifier::BOLD)
    }

    pub(super) fn dim(&self) -> Style {
        Style::new().add_modifier(Modifier::DIM)
    }
}
