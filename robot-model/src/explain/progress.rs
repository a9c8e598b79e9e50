//! What [`super::explain_observed`] tells while it works.

use crate::clocks::ClockFound;
use crate::estimation::errors::Errors;
use crate::explain::answer::StepFound;

/// Something that was found, in the order in which it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<'p> {
    /// The clocks that were corrected.
    Clocks(&'p [ClockFound]),
    /// Cross-validated errors of the nominal robot, and with its radius, ratio of radii and track width fitted.
    Geometry {
        /// Of the nominal robot.
        before: Errors,
        /// With the three fitted.
        after: Errors,
    },
    /// An effect of the answer.
    Effect(&'p StepFound),
}

/// Who is told.
pub type Observer<'o> = &'o mut dyn FnMut(Progress<'_>);
