//! What does each campaign of the benchmark hide? Drawn by seed.

use rand::seq::{IndexedRandom, SliceRandom};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::hard::Hard;
use super::hidden_effects::Secret;
use super::plant::Plant;

/// What a campaign hides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// One effect of the catalogue, at 30 sigma.
    Strong,
    /// One effect of the catalogue, at 10 sigma.
    Medium,
    /// One effect of the catalogue, at 4 sigma.
    Weak,
    /// Two effects of the catalogue, at 15 sigma each.
    Two,
    /// Nothing: a sound robot on an even floor.
    Nothing,
    /// Nothing but crooked starts, another camera, other motors.
    Nuisance,
    /// An effect outside the catalogue: of forces at its typical strength, and at least at 30 sigma; of kinematics so
    /// strong that it moves the robot 3 to 10 times as far as noise does.
    Outside,
}

impl Kind {
    /// All kinds, with their share of a benchmark.
    const SHARES: [(Kind, f64); 7] = [
        (Kind::Nothing, 100.0),
        (Kind::Nuisance, 100.0),
        (Kind::Strong, 44.0),
        (Kind::Medium, 44.0),
        (Kind::Weak, 44.0),
        (Kind::Two, 44.0),
        (Kind::Outside, 44.0),
    ];

    /// By how many sigma each effect has to stand out, where that is given.
    pub fn sigmas(self) -> Option<f64> {
        match self {
            Kind::Strong | Kind::Outside => Some(30.0),
            Kind::Medium => Some(10.0),
            Kind::Weak => Some(4.0),
            Kind::Two => Some(15.0),
            Kind::Nothing | Kind::Nuisance => None,
        }
    }

    /// Its name in a table.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Strong => "one, strong",
            Kind::Medium => "one, medium",
            Kind::Weak => "one, weak",
            Kind::Two => "two",
            Kind::Nothing => "nothing",
            Kind::Nuisance => "nuisances",
            Kind::Outside => "outside",
        }
    }
}

/// One campaign to be recorded and explained.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its index in the benchmark.
    pub index: usize,
    /// Draws everything about it.
    pub seed: u64,
    /// What it hides.
    pub kind: Kind,
    /// Where the robot comes from.
    pub plant: Plant,
    /// In which way the campaign is hard.
    pub hard: Hard,
    /// The hidden effects.
    pub effects: Vec<Secret>,
}

/// The cases of a benchmark: effects take turns, the seed draws the rest.
pub fn cases(seed: u64, campaigns: usize) -> Vec<Case> {
    let whole: f64 = Kind::SHARES.iter().map(|entry| entry.1).sum();
    let mut kinds = Vec::new();
    let mut upto = 0.0;
    for (kind, share) in Kind::SHARES {
        upto += share / whole * campaigns as f64;
        while kinds.len() < upto.round() as usize {
            kinds.push(kind);
        }
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // The first effect is drawn, so that a small benchmark does not always have the same ones.
    let mut turns: [usize; 2] = [rng.random_range(0..1000), rng.random_range(0..1000)];
    let plants = dealt(&Plant::BOTH, campaigns, &mut rng);
    let hards = dealt(&Hard::TURNS, campaigns, &mut rng);
    let each = kinds.into_iter().enumerate().map(|(index, kind)| {
        let (plant, mut hard) = (plants[index], hards[index]);
        let turn = &mut turns[usize::from(plant == Plant::Kinematic)];
        let secrets = Secret::all(plant, kind != Kind::Outside);
        let effects = match kind {
            Kind::Strong | Kind::Medium | Kind::Weak | Kind::Outside => {
                vec![secrets[*turn % secrets.len()]]
            }
            Kind::Two => pair(&secrets, *turn, &mut rng),
            Kind::Nothing | Kind::Nuisance => Vec::new(),
        };
        *turn += usize::from(!effects.is_empty());
        // A late camera under a clock that is off is not two things, and where the robot stands it shows nothing.
        let unlike_late = matches!(hard, Hard::Clock | Hard::Ends);
        if unlike_late && effects.iter().any(|effect| effect.id() == "measurement_delay") {
            hard = Hard::None;
        }
        let seed = seed.wrapping_mul(1_000_003).wrapping_add(index as u64);
        Case { index, seed, kind, plant, hard, effects }
    });
    each.collect()
}

/// So many of them, each as often as any other, in an order that is drawn.
fn dealt<T: Copy>(all: &[T], many: usize, rng: &mut ChaCha8Rng) -> Vec<T> {
    let mut drawn = Vec::new();
    while drawn.len() < many {
        let mut round = all.to_vec();
        round.shuffle(rng);
        drawn.extend(round);
    }
    drawn
}

/// Two effects that differ on this robot.
fn pair(inside: &[Secret], turn: usize, rng: &mut ChaCha8Rng) -> Vec<Secret> {
    let first = inside[turn % inside.len()];
    let differs = |other: &&Secret| **other != first && !same(first, **other);
    let others: Vec<Secret> = inside.iter().filter(differs).copied().collect();
    vec![first, others.choose(rng).copied().unwrap_or(first)]
}

/// At a gear reduction of one, wheel and encoder turn together.
fn same(a: Secret, b: Secret) -> bool {
    a.id().ends_with("_eccentricity") && b.id().ends_with("_eccentricity")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_benchmark_has_two_hundred_sound_robots_and_every_effect_of_both_plants() {
        let cases = cases(1, 420);
        assert_eq!(cases.len(), 420);
        let count = |kind: Kind| cases.iter().filter(|case| case.kind == kind).count();
        assert_eq!(count(Kind::Nothing) + count(Kind::Nuisance), 200);
        for plant in Plant::BOTH {
            assert_eq!(cases.iter().filter(|case| case.plant == plant).count(), 210);
            for effect in [true, false].into_iter().flat_map(|inside| Secret::all(plant, inside)) {
                let alone = cases.iter().filter(|case| case.effects == [effect]).count();
                assert!(alone >= 1, "{effect:?}");
            }
        }
        for hard in Hard::TURNS {
            let share = Hard::TURNS.iter().filter(|other| **other == hard).count() * 70;
            let here = cases.iter().filter(|case| case.hard == hard).count();
            // Those with a late camera move from two of them to the first.
            assert!(here.abs_diff(share) <= 5, "{hard:?}: {here} of {share}");
        }
        assert!(
            cases.iter().filter(|case| case.kind == Kind::Two).all(|case| case.effects.len() == 2)
        );
    }

    #[test]
    fn the_same_seed_hides_the_same_effects_and_another_seed_others() {
        let effects =
            |seed| cases(seed, 100).into_iter().flat_map(|case| case.effects).collect::<Vec<_>>();
        assert_eq!(effects(7), effects(7));
        assert_ne!(effects(7), effects(8));
    }
}
