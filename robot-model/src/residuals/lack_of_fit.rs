//! Does an error come back when a run is driven again? What does is no noise, whatever its shape.
//!
//! The test of lack of fit against pure error, which asks for no regressor. Runs with the same motion are divided into parts of
//! equal path. With z_rj the sum of the normalised innovations of part j of run r over the root of their number, of k runs:
//!
//! ```text
//! lack of fit = sum over parts of k mean(z_rj)^2                   of J parts
//! pure error  = sum over parts and runs of (z_rj - mean(z_rj))^2   with N - J degrees of freedom
//! (lack of fit / J) / (pure error / (N - J)) ~ Fisher's F(J, N - J) if what is left is noise          (1)
//! ```
//!
//! It does not depend on how large the noise was estimated to be. How much of the error comes back is told by the tracks: with
//! e_rj the mean error of part j from the best start, n_j poses in it, and s_j^2 the variance of e_rj over the runs,
//!
//! ```text
//! what comes back^2 = sum over parts of n_j (mean(e_rj)^2 - s_j^2 / k) / sum of n_j                    (2)
//! ```

use serde::{Deserialize, Serialize};

use super::innovations::{Innovations, Normalised, innovations};
use crate::estimation::errors::{Errors, errors_of_run};
use crate::estimation::fit::Fitted;
use crate::estimation::predict::PoseError;
use crate::numeric::distributions::fisher;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::repetitions::repetitions;

/// Parts of a run.
const PARTS: usize = 16;
/// Significance level of (1); above the other one, nothing speaks for errors that come back.
const P_MAX: f64 = 1e-4;
const P_NOISE: f64 = 0.01;
/// Fewer degrees of freedom of the pure error do not show that nothing comes back.
const FREEDOM_MIN: f64 = 12.0;

/// What runs that were driven again say of the errors that are left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum DrivenAgain {
    /// Nothing: no run was, or too few.
    #[default]
    TooFew,
    /// The errors differ each time, as noise does.
    Differ,
    /// Some of the error comes back: so much of that of the position, root of the mean square \[m\].
    ComesBack(f64),
}

/// Lack of fit against pure error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LackOfFit {
    /// Probability of as much by chance.
    pub p_value: f64,
    /// Degrees of freedom of the pure error.
    freedom: f64,
    /// The shares of a track's squared error of position and of heading that do not come back: what is noise.
    pure: [f64; 2],
}

impl LackOfFit {
    /// Whether errors come back beyond chance.
    pub fn comes_back(&self) -> bool {
        self.p_value < P_MAX
    }

    /// Whether what is left is noise: runs that were driven again are as far from each other as from the model.
    pub fn is_noise(&self) -> bool {
        self.p_value > P_NOISE && self.freedom >= FREEDOM_MIN
    }

    /// What stays of these errors without what comes back.
    pub fn pure(&self, errors: &Errors) -> Errors {
        Errors {
            position_rms_m: errors.position_rms_m * self.pure[0].sqrt(),
            heading_rms_rad: errors.heading_rms_rad * self.pure[1].sqrt(),
            chi: errors.chi,
        }
    }
}

/// Whether errors come back; `None` where no run was driven again.
pub(crate) fn lack_of_fit(prepared: &Prepared, fitted: &Fitted<'_>) -> Option<LackOfFit> {
    let groups = driven_again(prepared);
    if groups.is_empty() {
        return None;
    }
    let (p_value, freedom) = p_value(&groups, &innovations(prepared, fitted));
    Some(LackOfFit { p_value, freedom, pure: pure(&groups, prepared, fitted) })
}

/// The runs of each motion that was driven more than once.
fn driven_again(prepared: &Prepared) -> Vec<Vec<usize>> {
    let motions = repetitions(&prepared.robot, prepared.runs.iter().map(|run| &run.recording));
    let of = |motion| (0..motions.len()).filter(|run| motions[*run] == motion).collect();
    let groups = (0..motions.len()).map(of);
    groups.filter(|runs: &Vec<usize>| runs.len() > 1).collect()
}

/// By (1), with N - J.
fn p_value(groups: &[Vec<usize>], runs: &[Innovations]) -> (f64, f64) {
    let (mut lack, mut parts, mut pure, mut freedom) = (0.0, 0, 0.0, 0.0);
    let quantities: [fn(&Innovations) -> &[Normalised]; 3] =
        [|run| &run.heading, |run| &run.along, |run| &run.left];
    for group in groups {
        for quantity in quantities {
            let each: Vec<[Option<f64>; PARTS]> =
                group.iter().map(|run| of_parts(quantity(&runs[*run]))).collect();
            for part in 0..PARTS {
                let z: Vec<f64> = each.iter().filter_map(|parts| parts[part]).collect();
                if z.len() < 2 {
                    continue;
                }
                let Spread { mean, squares } = Spread::of(&z);
                lack += z.len() as f64 * mean * mean;
                parts += 1;
                pure += squares;
                freedom += z.len() as f64 - 1.0;
            }
        }
    }
    let p_value = if pure > 0.0 { fisher(parts, freedom, lack / (pure / freedom)) } else { 1.0 };
    (p_value, freedom)
}

/// Which part of a run a pose is in, after so much of the whole path.
fn part(share: f64) -> usize {
    ((share * PARTS as f64).ceil() as usize).clamp(1, PARTS) - 1
}

/// z of each part.
fn of_parts(run: &[Normalised]) -> [Option<f64>; PARTS] {
    let whole_m = run.last().map_or(0.0, |last| last.rolled_m).max(f64::MIN_POSITIVE);
    let mut parts = [(0.0, 0.0_f64); PARTS];
    for Normalised { rolled_m, z } in run {
        let (sum, n) = &mut parts[part(rolled_m / whole_m)];
        (*sum, *n) = (*sum + z, *n + 1.0);
    }
    parts.map(|(sum, n)| (n > 0.0).then(|| sum / n.sqrt()))
}

/// Some numbers: their mean, and the sum of their squared deviations from it.
struct Spread {
    mean: f64,
    squares: f64,
}

impl Spread {
    fn of(numbers: &[f64]) -> Self {
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        Self { mean, squares: numbers.iter().map(|number| (number - mean).powi(2)).sum() }
    }
}

/// By (2), of position and of heading.
fn pure(groups: &[Vec<usize>], prepared: &Prepared, fitted: &Fitted<'_>) -> [f64; 2] {
    let (mut back, mut all) = ([0.0; 2], [0.0; 2]);
    for group in groups {
        let runs = group.iter().map(|run| {
            let run = &prepared.recorded()[*run];
            errors_of_parts(run, &errors_of_run(run, &fitted.terms, &fitted.noise))
        });
        let runs: Vec<_> = runs.collect();
        for part in 0..PARTS {
            for axis in 0..3 {
                let seen: Vec<&Sum> =
                    runs.iter().map(|run| &run[part][axis]).filter(|sum| sum.n > 0.0).collect();
                if seen.len() < 2 {
                    continue;
                }
                let means: Vec<f64> = seen.iter().map(|sum| sum.sum / sum.n).collect();
                let Spread { mean, squares } = Spread::of(&means);
                let k = means.len() as f64;
                let n: f64 = seen.iter().map(|sum| sum.n).sum();
                let quantity = usize::from(axis == 2);
                back[quantity] += n * (mean * mean - squares / (k - 1.0) / k);
                all[quantity] += seen.iter().map(|sum| sum.squares).sum::<f64>();
            }
        }
    }
    let share =
        |quantity: usize| if all[quantity] > 0.0 { back[quantity] / all[quantity] } else { 0.0 };
    [0, 1].map(|quantity| 1.0 - share(quantity).clamp(0.0, 1.0))
}

/// Errors of one quantity in one part.
#[derive(Clone, Copy, Default)]
struct Sum {
    n: f64,
    sum: f64,
    squares: f64,
}

/// Errors of position ahead and to the left, and of heading, in each part of a run.
fn errors_of_parts(run: &PreparedRun, errors: &[PoseError]) -> [[Sum; 3]; PARTS] {
    let mut rolled_m = 0.0;
    let ends_m: Vec<f64> = run
        .motion
        .steps
        .iter()
        .map(|step| {
            rolled_m += step.rolled_m();
            rolled_m
        })
        .collect();
    let mut parts = [[Sum::default(); 3]; PARTS];
    for error in errors {
        let share = ends_m.get(error.step).map_or(1.0, |m| m / rolled_m.max(f64::MIN_POSITIVE));
        let [ahead, left] = [0, 1].map(|axis| error.position_m.map(|position_m| position_m[axis]));
        for (sum, number) in parts[part(share)].iter_mut().zip([ahead, left, error.heading_rad]) {
            let Some(number) = number else { continue };
            sum.n += 1.0;
            sum.sum += number;
            sum.squares += number * number;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::composition::Term;
    use crate::explain::{Answer, explain};
    use crate::tests::synthetic::{TurnsPerMetre, campaign, part_of_plan};

    /// A pull that comes and goes within a run, as nothing does that was recorded.
    const SWAYING: TurnsPerMetre = TurnsPerMetre(|step| 0.06 * (1.7 * step.t_s).sin());

    /// Eight arcs and four drives out and back, `times` over.
    fn answered(times: usize, truth: &[Term<'_>], seed: u64) -> Answer {
        let once = part_of_plan(&["out_and_back", "arc"]);
        let plan: Vec<_> = (0..times).flat_map(|_| once.clone()).collect();
        let mut driven = campaign(&plan, truth, seed);
        driven.runs.iter_mut().for_each(|run| run.payload_kg = 0.0);
        explain(&driven).unwrap()
    }

    #[test]
    fn what_comes_back_is_no_noise_and_the_rest_is() {
        let of = |answer: &Answer| 1e3 * answer.reachable.position_rms_m;
        for seed in 0..3 {
            let sound = answered(4, &[], seed);
            assert_eq!(sound.unexplained.driven_again, DrivenAgain::Differ, "seed {seed}");
            let found = answered(4, &[Term::new(&SWAYING, Vec::new())], seed);
            let DrivenAgain::ComesBack(back_m) = found.unexplained.driven_again else {
                panic!("seed {seed}: {:?}", found.unexplained)
            };
            assert!(found.unexplained.structure && (1.5e-3..2.2e-3).contains(&back_m), "{back_m}");
            assert!(
                of(&found) < 1.15 * of(&sound),
                "seed {seed}: {} and {}",
                of(&found),
                of(&sound)
            );
        }
        // Each run once: nothing tells, but as noise that would be much.
        let sound = answered(1, &[], 0).unexplained;
        assert_eq!((sound.driven_again, sound.random_turn_rad), (DrivenAgain::TooFew, None));
        let found = answered(1, &[Term::new(&SWAYING, Vec::new())], 0).unexplained;
        assert_eq!(found.driven_again, DrivenAgain::TooFew);
        assert!(found.random_turn_rad.is_some_and(|rad| (0.01..0.03).contains(&rad)), "{found:?}");
    }
}
