//! What is reported of a campaign, and how before and after are called.

use std::fmt::Write;

use robot_model::compare::{Comparison, Curve, Path};
use robot_model::explain::Answer;

use crate::explain::AnswerContext;

/// Everything that is on the page.
pub struct CampaignReport<'a> {
    /// What was asked.
    pub context: &'a AnswerContext<'a>,
    /// What was found.
    pub answer: &'a Answer,
    /// The nominal robot, with what it compensates already, against the runs; and the model that was found.
    pub comparisons: [&'a Comparison; 2],
    /// Their paths.
    pub paths: [&'a [Path]; 2],
    /// What each leaves.
    pub curves: [&'a [Curve]; 2],
}

/// What the effects of the answer are added to, in a legend.
pub(super) fn before(answer: &Answer) -> &'static str {
    if answer.known.is_empty() { "nominal robot" } else { "robot as configured" }
}

/// The names of the three colours.
pub(super) fn legend(html: &mut String, before: &str, measured: bool) {
    html.push_str("<p class=\"legend\">");
    if measured {
        html.push_str("<span><i class=\"k\"></i>measured</span>");
    }
    let _ = write!(
        html,
        "<span><i class=\"b\"></i>{before}</span><span><i class=\"a\"></i>with the missing effects</span></p>"
    );
}
