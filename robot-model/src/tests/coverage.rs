//! How often do the 95 % intervals cover the truth, and how large are the errors? Each effect alone, many times.
//!
//! The bounds follow from chance, if the intervals are right and the noise is that of the model:
//!
//! - Of [`SEEDS`] intervals of one parameter, misses are binomial with p = 0.05. No parameter may have as
//!   many as chance gives with less than [`CHANCE`]: five are allowed and six are not, which comes up by
//!   chance in one of 2,500 such sets of 36 parameters.
//! - Of all 432 intervals, misses are 21.6 +- 4.5; the errors of one effect's parameters are correlated, which
//!   widens this by no more than a half. 92 % to 98 % is then 1.9 such deviations either way.
//! - Twelve intervals that all cover the truth may still be too wide. So for effects that are linear in their
//!   parameters the squared errors, in standard errors, are summed: a chi^2 of [`SEEDS`] degrees, which has to lie
//!   between its quantiles of [`CHANCE`] on either side. So has their plain sum, normal with variance [`SEEDS`], as a
//!   bias is not chance either.

use statrs::distribution::{Binomial, ChiSquared, ContinuousCDF, DiscreteCDF, Normal};

use crate::effect::catalogue::{CATALOGUE, find};
use crate::effect::definition::ActsOn;
use crate::explain::model::fit_from_best_starts;
use crate::explain::parameters::parameters;
use crate::kinematics::pose::Pose;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::random::Random;
use crate::recording::campaign::Campaign;
use crate::recording::nominal_run::{Piece, Sampling, nominal_run};
use crate::recording::run::Robot;
use crate::selection::candidates::Screening;
use crate::tests::synthetic::{ALONE, NOISE, ROBOT, measure, part_of_plan, term};

/// Campaigns of each effect.
const SEEDS: u64 = 12;
/// What is less probable than this is not chance.
const CHANCE: f64 = 1e-4;

/// An encoder of its own: two and a half turns to one of the wheel.
const GEARED: Robot = Robot { gear_reduction: 2.5, ..ROBOT };

/// Twenty samples and five poses a second: half of those of other tests, as there are hundreds of campaigns.
const SAMPLING: Sampling = Sampling { sample_s: 0.04, samples_per_pose: 5, ..Sampling::USUAL };

/// Ten runs that show every effect: straight in four headings, on the spot, in arcs, and the first once more.
fn plan() -> Vec<(String, f64, Vec<Piece>)> {
    part_of_plan(&["out_and_back", "spin_0.2", "arc_0.4_0.12", "arc_0.9_0.35_6", "repeat"])
}

/// A campaign with one effect.
fn campaign(id: &str, values: &[f64], seed: u64) -> Campaign {
    let robot = if id == "encoder_eccentricity" { GEARED } else { ROBOT };
    let truth = [term(id, values)];
    let mut random = Random::new(seed);
    let mut phi = WheelPair::both(0.0);
    let mut runs = Vec::new();
    for (k, (name, heading_rad, pieces)) in plan().iter().enumerate() {
        let mut planned = nominal_run(&robot, name, pieces, &SAMPLING);
        planned.started_s = Some(120.0 * k as f64);
        planned.payload_kg = if k % 2 == 1 { 3.0 } else { 0.0 };
        for sample in &mut planned.wheels {
            sample.phi_rad = sample.phi_rad.zip(phi).map(|(a, b)| a + b);
        }
        phi = planned.wheels.last().expect("a run has samples").phi_rad;
        let start = Pose::new(0.0, 0.0, heading_rad + 0.03 * random.normal());
        runs.push(measure(&robot, &planned, start, &truth, &NOISE, &mut random));
    }
    Campaign { robot, runs }
}

/// The errors of one parameter over its campaigns.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    misses: u64,
    /// Sum of the squared errors, in standard errors.
    squares: f64,
    /// Sum of the errors.
    sum: f64,
}

/// Fits an effect to campaigns of its own.
fn tallies(id: &'static str, values: &[f64], first_seed: u64) -> Vec<Tally> {
    let effect = find(id).expect("an id of the catalogue");
    let mut tallies = vec![Tally::default(); values.len()];
    for seed in 0..SEEDS {
        let mut campaign = campaign(id, values, first_seed + seed);
        if effect.facts().acts_on != ActsOn::Gyro {
            campaign.runs.iter_mut().for_each(|run| run.gyro.clear());
        }
        let prepared = campaign.prepare().expect("a sound campaign");
        let fitted = fit_from_best_starts(&prepared, &[effect]);
        let screening = Screening::new(&prepared, &fitted, &CATALOGUE);
        let found = parameters(&prepared, &fitted, screening.kept()).swap_remove(0);
        for ((tally, parameter), truth) in tallies.iter_mut().zip(&found).zip(values) {
            tally.misses += u64::from(!(parameter.low95..=parameter.high95).contains(truth));
            let z = (parameter.value - truth) / parameter.sigma;
            tally.squares += z * z;
            tally.sum += z;
        }
    }
    tallies
}

#[test]
fn intervals_of_95_percent_hold_the_truth_in_95_percent_for_each_effect_alone() {
    let missed = Binomial::new(0.05, SEEDS).expect("a share");
    let squared = ChiSquared::new(SEEDS as f64).expect("degrees");
    let (mut intervals, mut misses) = (0, 0);
    let mut wrong = Vec::new();
    for (index, (id, values)) in ALONE.into_iter().enumerate() {
        // Each effect has noise of its own.
        let first_seed = 7000 + SEEDS * index as u64;
        let effect = find(id).expect("an id of the catalogue");
        for (parameter, tally) in
            effect.facts().parameters.iter().zip(tallies(id, values, first_seed))
        {
            let name = format!("{id} {}", parameter.name);
            println!("{name}: {tally:?}");
            intervals += SEEDS;
            misses += tally.misses;
            let by_chance = if tally.misses == 0 { 1.0 } else { missed.sf(tally.misses - 1) };
            if by_chance < CHANCE {
                wrong.push(format!("{name}: {} of {SEEDS} missed", tally.misses));
            }
            let likely = |below: f64| (CHANCE..=1.0 - CHANCE).contains(&below);
            let sum = tally.sum / (SEEDS as f64).sqrt();
            let (size, side) = (squared.cdf(tally.squares), Normal::standard().cdf(sum));
            if effect.is_linear() && !(likely(size) && likely(side)) {
                wrong.push(format!("{name}: chi^2 {:.1} of {SEEDS}, sum {sum:.1}", tally.squares));
            }
        }
    }
    assert_eq!(wrong, [""; 0]);
    let coverage = 1.0 - misses as f64 / intervals as f64;
    assert!((0.92..=0.98).contains(&coverage), "{misses} of {intervals} missed");
}
