//! What [`super::explain_observed`] tells while it works.

use crate::clocks::ClockFound;
use crate::effect::composition::Term;
use crate::effect::definition::Effect;
use crate::estimation::errors::Errors;
use crate::estimation::fit::fit_roughly;
use crate::explain::answer::StepFound;
use crate::explain::explanation::errors_as_fitted;
use crate::recording::campaign::Prepared;
use crate::selection::candidates::is_geometry;

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

/// What the geometry alone explains.
pub(super) fn geometry(prepared: &Prepared, catalogue: &[&dyn Effect]) -> Progress<'static> {
    let terms = catalogue.iter().filter(|effect| is_geometry(**effect));
    let terms: Vec<Term<'_>> = terms.map(|effect| Term::new(*effect, vec![0.0])).collect();
    let fitted = fit_roughly(prepared, terms);
    let of = |terms: &[Term<'_>]| errors_as_fitted(prepared, &fitted.noise, terms).cross_validated;
    Progress::Geometry { before: of(&[]), after: of(&fitted.terms) }
}
