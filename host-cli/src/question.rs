//! A question to a person: in words for a terminal, with a picture and buttons for a page.

use serde_json::{Value, json};

/// A question to a person.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// What is asked.
    text: String,
    /// How it is answered on a terminal; a page has buttons instead.
    on_terminal: &'static str,
    picture: Option<Picture>,
    /// An answer that somebody knows already, as the simulator's ruler does.
    suggested: Option<String>,
    choices: &'static [Choice],
    /// Whether an answer may be typed besides.
    typed: bool,
}

/// What a picture beside a question shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picture {
    /// The robot on its start line, with room ahead.
    Line,
    /// How far the robot has ended beside its line, left positive.
    Offset,
    /// How far it is ahead of its mark, and to the left of it.
    AheadLeft,
    /// The robot at the mark of a run, facing an angle.
    Mark,
    /// x along the axis, y to its left, and the heading.
    Pose,
    /// The heading alone.
    Heading,
}

/// An answer that a page has a button for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// On the button.
    pub label: &'static str,
    /// What is answered.
    pub answer: &'static str,
}

impl Question {
    /// A question that is answered in words.
    pub fn new(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            on_terminal: "",
            picture: None,
            suggested: None,
            choices: &[],
            typed: true,
        }
    }

    /// With buttons on a page, and on a terminal with the words that say the same.
    pub fn choices(self, choices: &'static [Choice], on_terminal: &'static str) -> Self {
        Self { choices, on_terminal, ..self }
    }

    /// Answered by its buttons alone.
    pub fn not_typed(self) -> Self {
        Self { typed: false, ..self }
    }

    /// With a picture.
    pub fn picture(self, picture: Picture) -> Self {
        Self { picture: Some(picture), ..self }
    }

    /// With an answer that is known already.
    pub fn suggested(self, suggested: Option<String>) -> Self {
        Self { suggested, ..self }
    }

    /// What is asked.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The line of a terminal.
    pub fn on_terminal(&self) -> String {
        match self.on_terminal {
            "" => self.text.clone(),
            how => format!("{} {how}", self.text),
        }
    }

    /// As a page takes it.
    pub fn to_json(&self, number: u32) -> Value {
        let picture = self.picture.map(|picture| match picture {
            Picture::Line => "line",
            Picture::Offset => "offset",
            Picture::AheadLeft => "ahead_left",
            Picture::Mark => "mark",
            Picture::Pose => "pose",
            Picture::Heading => "heading",
        });
        let choice = |choice: &Choice| json!({"label": choice.label, "answer": choice.answer});
        json!({
            "number": number,
            "text": self.text,
            "picture": picture,
            "suggested": self.suggested,
            "choices": self.choices.iter().map(choice).collect::<Vec<_>>(),
            "types": self.typed,
        })
    }
}
