//! Fits a model to a campaign: its parameters by Gauss-Newton on whitened residuals, and the noise by maximum
//! likelihood, in turns.
//!
//! Which effects are in the model is the caller's; see `selection`.

use nalgebra::{DMatrix, DVector};

use crate::effect::composition::{Composer, PlacedTerm, Term, Terms};
use crate::effect::definition::{Effect, Role};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::ekf::{FilterObserver, Innovation, whiten};
use crate::estimation::gyro::{fixed_segments, whiten_gyro};
use crate::estimation::most_likely_noise::{Search, most_likely};
use crate::estimation::noise_segments::NoiseSegments;
use crate::numeric::parallel;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::odometry_noise::{NUMBERS, OdometryNoise};
use crate::recording::run::PoseMeasurement;

/// Most iterations of Gauss-Newton.
const ROUNDS_MAX: usize = 8;
/// On the way of a search, a step that can lower chi^2 by less than this is not worth another pass over all runs.
const FALL_MIN: f64 = 0.05;
/// A campaign of fewer poses is fitted in no time, so every fit of it converges.
const QUICK_POSES: usize = 20_000;
/// A step by which chi^2 grows more than this is too long.
const RISE: f64 = 0.5;

/// A fitted set of effects.
#[derive(Clone, Debug)]
pub(crate) struct Fitted<'a> {
    pub terms: Vec<Term<'a>>,
    /// Covariance of all parameters, in the order of the terms.
    pub covariance: DMatrix<f64>,
    pub noise: OdometryNoise,
    /// Sum of the squared whitened residuals.
    pub chi_squared: f64,
    pub rows: f64,
}

/// Adds up the likelihood.
#[derive(Default)]
struct Likelihood {
    minus_two_log: f64,
}

impl FilterObserver for Likelihood {
    fn row(&mut self, innovation: Innovation, _: &[f64]) {
        let Innovation { value, variance, .. } = innovation;
        self.minus_two_log += variance.ln() + value * value / variance;
    }
}

/// -2 log likelihood of some runs, up to a constant.
pub(crate) fn minus_two_log_likelihood(
    runs: &[&PreparedRun],
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> f64 {
    let each = parallel::map(runs, |run| {
        let mut sum = Likelihood::default();
        let terms = Terms::Fixed(terms);
        whiten(&run.motion, &run.recording.measured_poses, terms, noise, &mut sum);
        whiten_gyro(run, terms, noise, &mut sum);
        sum.minus_two_log
    });
    each.iter().sum()
}

/// Most poses that the noise is estimated from, during the search and at its end; of more poses, bursts are taken.
const NOISE_POSES_MAX: [usize; 2] = [4_000, 8_000];
/// Most poses that tell which of several starts is the right one.
const EXPLORED_POSES_MAX: usize = 2_000;
/// Consecutive poses in a burst, so that noise that fades within a second shows its correlation.
const BURST: usize = 10;

/// The noise that fits best with these terms as they are.
pub(crate) fn fit_noise(
    prepared: &Prepared,
    terms: &[Term<'_>],
    start: OdometryNoise,
    search: Search,
) -> OdometryNoise {
    let view = Composer::new(Terms::Fixed(terms)).view().0;
    let measurements: usize =
        prepared.runs.iter().map(|run| run.recording.measured_poses.len()).sum();
    let every = |most: usize| measurements.div_ceil(most).max(1);
    let segments = |every: usize| -> Vec<NoiseSegments> {
        parallel::map(&prepared.runs, |run| {
            let bursts = run.recording.measured_poses.chunks(BURST).step_by(every);
            let thinned: Vec<PoseMeasurement> = bursts.flatten().copied().collect();
            let mut segments =
                NoiseSegments::new(view.offset_m.map(|jet| jet.value), fixed_segments(run, terms));
            whiten(&run.motion, &thinned, Terms::Fixed(terms), &start, &mut segments);
            segments
        })
    };
    let robot = &prepared.robot;
    let mut given = [false; NUMBERS];
    given[0] = robot.position_sigma_m.is_some();
    given[1] = robot.heading_sigma_rad.is_some();
    given[7] = prepared.runs.iter().all(|run| run.recording.gyro.len() < 2);
    let told = |noise: OdometryNoise| OdometryNoise {
        position_sigma_m: robot.position_sigma_m.unwrap_or(noise.position_sigma_m),
        heading_sigma_rad: robot.heading_sigma_rad.unwrap_or(noise.heading_sigma_rad),
        ..noise
    };
    let start = told(start);
    if search == Search::Near {
        return most_likely(&segments(every(NOISE_POSES_MAX[0])), start, given, search);
    }
    let found = most_likely(&segments(every(EXPLORED_POSES_MAX)), start, given, search);
    if measurements <= EXPLORED_POSES_MAX {
        return found;
    }
    most_likely(&segments(every(NOISE_POSES_MAX[1])), found, given, Search::Near)
}

/// Fits the parameters of these terms, with the noise as given.
///
/// Amplitudes that are never negative are first fitted as if they could be, for on the way to its shape an effect may
/// need them to; where that ends below zero, the fit goes on from zero and stays there or above.
///
/// Where a full step raises the cost, as it may behind a kink, half of it is taken. A fit that does not converge stays
/// at its best point. An effect that ends at zero in this way is not accepted
/// ([`crate::selection::candidates::Screening::is_unsettled`]).
pub(crate) fn fit_parameters<'a>(
    prepared: &Prepared,
    terms: Vec<Term<'a>>,
    noise: OdometryNoise,
) -> Fitted<'a> {
    fit_as_near(prepared, terms, noise, Nearness::Converged)
}

/// How near to its optimum a fit has to come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Nearness {
    /// For a model that a search goes on from: to a tenth of a sigma.
    OnTheWay,
    /// For what is told.
    Converged,
}

impl Nearness {
    /// A fit is near enough if its step is shorter than this many sigmas.
    fn step_sigmas(self) -> f64 {
        match self {
            Self::OnTheWay => 0.1,
            Self::Converged => 0.02,
        }
    }
}

fn fit_as_near<'a>(
    prepared: &Prepared,
    terms: Vec<Term<'a>>,
    noise: OdometryNoise,
    nearness: Nearness,
) -> Fitted<'a> {
    let fitted = descend(prepared, terms, noise, (Signs::Any, nearness));
    let mut terms = fitted.terms.clone();
    raise_to_zero(&mut terms);
    let same = terms.iter().zip(&fitted.terms).all(|(a, b)| a.values == b.values);
    if same { fitted } else { descend(prepared, terms, noise, (Signs::Kept, nearness)) }
}

/// Whether amplitudes that are never negative may become so on the way.
#[derive(Clone, Copy, PartialEq)]
enum Signs {
    Any,
    Kept,
}

/// Whether a pass over all runs takes no time.
fn is_quick(prepared: &Prepared) -> bool {
    let poses = prepared.runs.iter().map(|run| run.recording.measured_poses.len());
    poses.sum::<usize>() < QUICK_POSES
}

/// Gauss-Newton from these terms on.
fn descend<'a>(
    prepared: &Prepared,
    mut terms: Vec<Term<'a>>,
    noise: OdometryNoise,
    (signs, nearness): (Signs, Nearness),
) -> Fitted<'a> {
    let nearness = if is_quick(prepared) { Nearness::Converged } else { nearness };
    let moved = |terms: &mut [Term<'a>], step: &[f64]| {
        moved_within_range(prepared, terms, step);
        if signs == Signs::Kept {
            raise_to_zero(terms);
        }
    };
    let mut best: Option<Point<'a>> = None;
    let mut round = 0;
    loop {
        let equations = CampaignEquations::gather(prepared, &PlacedTerm::place(&terms), &noise);
        let cost = equations.total.squares + equations.prior_cost();
        round += 1;
        if let Some(before) = &mut best
            && cost > before.cost + RISE
        {
            before.shorten(cost, (round, nearness));
            terms.clone_from(&before.terms);
            moved(&mut terms, before.step.as_slice());
            continue;
        }
        let columns: Vec<usize> = (0..equations.priors.len()).collect();
        let mut solution = equations.solve(&equations.total, &columns);
        if signs == Signs::Kept {
            solution.delta = within_signs(&equations, &terms, &columns);
        }
        let distance = (0..columns.len())
            .map(|i| solution.delta[i].abs() / solution.covariance[(i, i)].sqrt())
            .fold(0.0, f64::max);
        let ends = best.as_ref().is_some_and(|before| before.step.amax() == 0.0);
        if distance < nearness.step_sigmas() || round > ROUNDS_MAX || ends {
            return Fitted {
                terms,
                covariance: solution.covariance,
                noise,
                chi_squared: equations.total.squares,
                rows: equations.total.rows,
            };
        }
        let before = terms.clone();
        moved(&mut terms, solution.delta.as_slice());
        let fall = equations.expected_fall(&columns, &solution.delta);
        best = Some(Point { cost, terms: before, step: solution.delta, fall });
    }
}

/// The best point so far, and the step from there.
struct Point<'a> {
    cost: f64,
    terms: Vec<Term<'a>>,
    step: DVector<f64>,
    /// By how much the cost falls with this step if it is quadratic: half of its slope along the step.
    fall: f64,
}

impl Point<'_> {
    /// Shortens a step that raised the cost to this: to half, and to none where another round is not worth it.
    ///
    /// The parabola through the cost here, its slope, and the cost there has its least value
    ///
    /// ```text
    /// fall^2 / (cost there - cost here + 2 fall)                                        (1)
    /// ```
    ///
    /// below the cost here.
    fn shorten(&mut self, there: f64, (round, nearness): (usize, Nearness)) {
        let least_fall = self.fall.powi(2) / (there - self.cost + 2.0 * self.fall);
        let is_near = nearness == Nearness::OnTheWay && least_fall < FALL_MIN;
        let share = if round > ROUNDS_MAX || is_near { 0.0 } else { 0.5 };
        self.step *= share;
        self.fall *= share;
    }
}

/// Amplitudes that are never negative, at zero where they were.
pub(crate) fn raise_to_zero(terms: &mut [Term<'_>]) {
    for term in terms {
        for (value, of) in term.values.iter_mut().zip(term.effect.facts().parameters) {
            if of.is_never_negative() {
                *value = value.max(0.0);
            }
        }
    }
}

/// The step of Gauss-Newton in these columns, none for an amplitude at zero that would fall below it.
pub(crate) fn within_signs(
    equations: &CampaignEquations,
    terms: &[Term<'_>],
    columns: &[usize],
) -> DVector<f64> {
    let values = terms.iter().flat_map(|term| {
        let parameters = term.effect.facts().parameters;
        term.values.iter().zip(parameters).map(|(value, of)| (*value, of.is_never_negative()))
    });
    let at_zero: Vec<bool> = values.map(|(value, never)| never && value <= 0.0).collect();
    let mut free = columns.to_vec();
    loop {
        let delta = equations.best(&equations.total, &free);
        let falls = |(column, delta): (&usize, &f64)| at_zero[*column] && *delta < 0.0;
        let pairs = free.iter().zip(delta.iter());
        let rest: Vec<usize> = pairs.filter(|pair| !falls(*pair)).map(|pair| *pair.0).collect();
        if rest.len() == free.len() {
            let of = |column: &usize| free.iter().position(|other| other == column);
            let step = columns.iter().map(|column| of(column).map_or(0.0, |index| delta[index]));
            return DVector::from_iterator(columns.len(), step);
        }
        free = rest;
    }
}

/// Moves every parameter, in the order of the terms; a shape stays within what the runs can show.
pub(crate) fn moved_within_range(prepared: &Prepared, terms: &mut [Term<'_>], step: &[f64]) {
    let mut next = 0;
    for term in terms {
        let effect: &dyn Effect = term.effect;
        for (j, value) in term.values.iter_mut().enumerate() {
            *value += step[next];
            if effect.facts().parameters[j].role == Role::Shape {
                let (low, high) = effect.range(j, &prepared.excitation);
                *value = value.clamp(low, high.max(low));
            }
            next += 1;
        }
    }
}

/// The noise stays as it is if chi^2 differs from the number of rows by less than this share.
const NOISE_CHANGE: f64 = 0.005;

/// Fits the parameters, and the noise anew unless it still agrees.
pub(crate) fn fit<'a>(
    prepared: &Prepared,
    terms: Vec<Term<'a>>,
    start: OdometryNoise,
    nearness: Nearness,
) -> Fitted<'a> {
    let first = fit_as_near(prepared, terms, start, nearness);
    // With the right noise, chi^2 is the number of rows.
    if (first.chi_squared / first.rows.max(1.0) - 1.0).abs() < NOISE_CHANGE {
        return first;
    }
    with_noise(prepared, first, (Search::Near, nearness))
}

/// Fits parameters and noise from typical noise, near enough to go on from there.
pub(crate) fn fit_roughly<'a>(prepared: &Prepared, terms: Vec<Term<'a>>) -> Fitted<'a> {
    let first = fit_as_near(prepared, terms, OdometryNoise::TYPICAL, Nearness::OnTheWay);
    with_noise(prepared, first, (Search::Near, Nearness::OnTheWay))
}

/// Fits parameters and noise from typical noise, with the wide search.
pub(crate) fn fit_afresh<'a>(prepared: &Prepared, terms: Vec<Term<'a>>) -> Fitted<'a> {
    let first = fit_as_near(prepared, terms, OdometryNoise::TYPICAL, Nearness::OnTheWay);
    with_noise(prepared, first, (Search::Wide, Nearness::Converged))
}

/// Estimates the noise about a fit, and fits once more with it.
fn with_noise<'a>(
    prepared: &Prepared,
    about: Fitted<'a>,
    (search, nearness): (Search, Nearness),
) -> Fitted<'a> {
    if let Some(noise) = prepared.noise {
        return fit_as_near(prepared, about.terms, noise, nearness);
    }
    let noise = fit_noise(prepared, &about.terms, about.noise, search);
    let fitted = fit_as_near(prepared, about.terms, noise, nearness);
    // The ratios of the noise's parameters come from some of the poses, its overall size from all of them.
    let robot = &prepared.robot;
    let given = robot.position_sigma_m.is_some() || robot.heading_sigma_rad.is_some();
    if given || fitted.rows < ROWS_FOR_SIZE {
        return fitted;
    }
    let size = (fitted.chi_squared / fitted.rows).sqrt();
    Fitted {
        noise: noise.times(size),
        covariance: fitted.covariance * (size * size),
        chi_squared: fitted.rows,
        ..fitted
    }
}

/// From this many rows on, the data alone determine the size of the noise, not the prior.
const ROWS_FOR_SIZE: f64 = 1000.0;

#[cfg(test)]
mod tests;
