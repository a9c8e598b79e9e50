//! Fits a model to a campaign: its parameters by Gauss-Newton on whitened residuals, and the noise by
//! maximum likelihood, in turns.

use nalgebra::DMatrix;

use crate::campaign::{Prepared, PreparedRun};
use crate::effect::{Effect, Role};
use crate::evidence::Evidence;
use crate::gyro::whiten_gyro;
use crate::increment::Term;
use crate::odometry_noise::{NUMBERS, OdometryNoise, Search, most_likely};
use crate::parallel;
use crate::whiten::{Innovation, Sink, whiten};

/// Most rounds of Gauss-Newton.
const ROUNDS_MAX: usize = 8;
/// A step of this many sigmas is no step.
const STEP_SIGMAS: f64 = 0.02;

/// A fitted set of effects.
#[derive(Clone, Debug)]
pub(crate) struct Fitted<'a> {
    pub terms: Vec<Term<'a>>,
    /// Covariance of all parameters, in the order of the terms.
    pub covariance: DMatrix<f64>,
    pub noise: OdometryNoise,
    /// Mean square of the whitened residuals, of each number measured.
    pub chi_squared: f64,
    pub rows: f64,
}

/// Sums up the likelihood.
#[derive(Default)]
struct Likelihood {
    minus_two_log: f64,
}

impl Sink for Likelihood {
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
        whiten(&run.motion, &run.recording.sights, terms, 0, noise, &mut sum);
        whiten_gyro(run, terms, 0, noise, &mut sum);
        sum.minus_two_log
    });
    each.iter().sum()
}

/// Steps that the noise is learnt from; of more, every so many runs are taken.
const NOISE_STEPS_MAX: usize = 30_000;

/// The noise that fits best with these terms as they are.
pub(crate) fn fit_noise(
    prepared: &Prepared,
    terms: &[Term<'_>],
    start: OdometryNoise,
    search: Search,
) -> OdometryNoise {
    let fixed: Vec<Term<'_>> =
        terms.iter().map(|term| Term { column: None, ..term.clone() }).collect();
    let steps: usize = prepared.runs.iter().map(|run| run.motion.steps.len()).sum();
    let every = steps.div_ceil(NOISE_STEPS_MAX).max(1);
    let runs: Vec<&PreparedRun> = prepared.runs.iter().step_by(every).collect();
    let robot = &prepared.robot;
    let mut given = [false; NUMBERS];
    given[0] = robot.position_sigma_m.is_some();
    given[1] = robot.heading_sigma_rad.is_some();
    given[7] = runs.iter().all(|run| run.recording.gyro.len() < 2);
    let told = |noise: OdometryNoise| OdometryNoise {
        position_sigma_m: robot.position_sigma_m.unwrap_or(noise.position_sigma_m),
        heading_sigma_rad: robot.heading_sigma_rad.unwrap_or(noise.heading_sigma_rad),
        ..noise
    };
    most_likely(told(start), given, search, |noise| minus_two_log_likelihood(&runs, &fixed, noise))
}

/// Fits the parameters of these terms, with the noise as given.
pub(crate) fn fit_parameters<'a>(
    prepared: &Prepared,
    mut terms: Vec<Term<'a>>,
    noise: OdometryNoise,
) -> Fitted<'a> {
    let mut round = 0;
    loop {
        let evidence = Evidence::gather(prepared, &mut terms, &noise);
        let columns: Vec<usize> = (0..evidence.priors.len()).collect();
        let solution = evidence.solve(&evidence.total, &columns);
        let distance = (0..columns.len())
            .map(|i| solution.delta[i].abs() / solution.covariance[(i, i)].sqrt())
            .fold(0.0, f64::max);
        round += 1;
        if distance < STEP_SIGMAS || round > ROUNDS_MAX {
            return Fitted {
                terms,
                covariance: solution.covariance,
                noise,
                chi_squared: evidence.total.squares,
                rows: evidence.total.rows,
            };
        }
        let mut next = 0;
        for term in &mut terms {
            let effect: &dyn Effect = term.effect;
            for (value, parameter) in term.values.iter_mut().zip(effect.facts().parameters) {
                *value += solution.delta[next];
                if parameter.role == Role::Shape {
                    *value = value.clamp(parameter.low, parameter.high);
                }
                next += 1;
            }
        }
    }
}

/// Less change of chi^2 than this share leaves the noise as it is.
const NOISE_CHANGE: f64 = 0.003;

/// Fits parameters, and the noise anew where that made a difference.
pub(crate) fn fit<'a>(
    prepared: &Prepared,
    terms: Vec<Term<'a>>,
    start: OdometryNoise,
) -> Fitted<'a> {
    let first = fit_parameters(prepared, terms, start);
    // At the right noise chi^2 is the number of rows.
    if (first.chi_squared / first.rows.max(1.0) - 1.0).abs() < NOISE_CHANGE {
        return first;
    }
    let noise = fit_noise(prepared, &first.terms, start, Search::Near);
    fit_parameters(prepared, first.terms, noise)
}

/// Fits from nothing known of the noise.
pub(crate) fn fit_afresh<'a>(prepared: &Prepared, terms: Vec<Term<'a>>) -> Fitted<'a> {
    let first = fit_parameters(prepared, terms, OdometryNoise::TYPICAL);
    let noise = fit_noise(prepared, &first.terms, OdometryNoise::TYPICAL, Search::Wide);
    fit_parameters(prepared, first.terms, noise)
}
