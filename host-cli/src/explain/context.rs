//! What was asked, for the words of an answer.

use campaign::model::EffectEntry;
use findings::headline::Asked;
use robot_model::effect::{Effect, Facts};
use robot_model::explain::Answer;

/// What was asked, for the words of the answer.
pub struct AnswerContext<'a> {
    /// Name of the robot.
    pub robot: &'a str,
    /// The folder, as the user wrote it.
    pub campaign: String,
    /// The options that reach the robot for the next run, as the user would write them.
    pub robot_options: String,
    /// The runs that a model is fitted to.
    pub runs: Vec<String>,
    /// The number of the motion of each: runs with the same number repeat one another.
    pub motions: Vec<usize>,
    /// All candidate effects.
    pub catalogue: &'a [&'a dyn Effect],
    /// The effects that the user's model has already.
    pub in_model: &'a [EffectEntry],
    /// The net change by each step in one number, where there is one.
    pub combinations: Vec<Option<String>>,
    /// Wheel radius and track width as `robot.toml` has them \[m\].
    pub nominal_m: [f64; 2],
}

impl<'a> AnswerContext<'a> {
    /// As much of it as the main finding needs.
    pub fn asked(&self) -> Asked<'a> {
        Asked { runs: self.runs.len(), catalogue: self.catalogue, nominal_m: self.nominal_m }
    }

    pub(crate) fn facts(&self, id: &str) -> Option<Facts<'a>> {
        self.asked().facts(id)
    }

    /// The plain name of an effect.
    pub fn name<'b>(&self, id: &'b str) -> &'b str
    where
        'a: 'b,
    {
        self.asked().name(id)
    }
}

/// The main finding, in a few sentences.
pub fn headline(answer: &Answer, context: &AnswerContext<'_>) -> String {
    findings::headline::headline(answer, &context.asked())
}
