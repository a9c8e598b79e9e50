//! Does the robot turn by a wave over the floor, as from tiles, planks or seams?
//!
//! Places of [`super::floor_location`] are wider than a tile, and what one edge does the next one undoes. So a wave is looked
//! for: every measured heading contains what the floor did since the one before. With x the place along one axis of the floor,
//!
//! ```text
//! z_k = a int cos(q x) |ds| + b int sin(q x) |ds| + 1 sigma,   q = 2 pi / wavelength           (1)
//! gain of a and b: without a wave chi^2 of two degrees, for each q and each axis                (2)
//! ```

use core::f64::consts::TAU;

use crate::effect::composition::{Increment, Terms};
use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::estimation::ekf::{FilterObserver, Innovation, numbers, whiten};
use crate::estimation::fit::Fitted;
use crate::estimation::state::Quantity;
use crate::kinematics::pose::Pose;
use crate::numeric::distributions::chi_squared;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::numeric::parallel;
use crate::recording::campaign::Prepared;
use crate::recording::motion::Step;
use crate::recording::run::PoseMeasurement;

/// Longest wavelength \[m\], the spacing of q \[1/m\], and how many there are: down to 15 cm.
const LONGEST_M: f64 = 1.0;
const SPACING_PER_M: f64 = 1.0;
const WAVES: usize = 36;
/// Significance level of a wave, all asked for counted.
const P_MAX: f64 = 1e-6;

/// A turn by a wave along both axes of the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaceWave {
    /// q of (1) \[1/m\].
    per_m: f64,
}

/// The strongest wave, and the probability of as strong a one by chance; if it is significant.
pub(super) fn strongest(prepared: &Prepared, fitted: &Fitted<'_>) -> Option<(PlaceWave, f64)> {
    let fixed = Terms::Fixed(&fitted.terms);
    let runs = parallel::map(&prepared.runs, |run| {
        let mut waves = Waves::new();
        whiten(&run.motion, &run.recording.measured_poses, fixed, &fitted.noise, &mut waves);
        waves.sums
    });
    let gain = |axis: usize, wave: usize| {
        let each = runs.iter().map(|run| run[axis][wave]);
        each.fold([0.0; 5], |a, b| core::array::from_fn(|i| a[i] + b[i]))
    };
    let all = (0..2).flat_map(|axis| (0..WAVES).map(move |wave| (axis, wave)));
    let gains = all.map(|(axis, wave)| (gain_of(gain(axis, wave)), wave));
    let (most, wave) = gains.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let p_value = (chi_squared(2, most) * (2 * WAVES) as f64).min(1.0);
    (p_value < P_MAX).then_some((PlaceWave { per_m: per_m(wave) }, p_value))
}

/// q of each wave \[1/m\].
fn per_m(wave: usize) -> f64 {
    TAU / LONGEST_M + SPACING_PER_M * wave as f64
}

/// Equation (2), of the sums of c^2, c s, s^2, z c and z s.
fn gain_of([cc, cs, ss, zc, zs]: [f64; 5]) -> f64 {
    let determinant = cc * ss - cs * cs;
    if determinant <= 1e-6 * cc * ss {
        return 0.0;
    }
    (zc * zc * ss - 2.0 * zc * zs * cs + zs * zs * cc) / determinant
}

/// The sums of a run, for each axis and each wave.
struct Waves {
    /// The integrals of (1) since the last heading.
    since: Box<[[[f64; 2]; WAVES]; 2]>,
    sums: Box<[[[f64; 5]; WAVES]; 2]>,
    pending: Vec<f64>,
}

impl Waves {
    fn new() -> Self {
        Self {
            since: Box::new([[[0.0; 2]; WAVES]; 2]),
            sums: Box::new([[[0.0; 5]; WAVES]; 2]),
            pending: Vec::new(),
        }
    }
}

impl FilterObserver for Waves {
    fn row(&mut self, innovation: Innovation, _: &[f64]) {
        self.pending.push(innovation.value / innovation.variance.sqrt());
    }

    fn motion(&mut self, step: &Step, _: &Increment, share: f64) {
        let ds_m = step.travel_m().abs() * share;
        for (since, x_m) in self.since.iter_mut().zip(step.place_m) {
            // The next q turns by as much again.
            let (mut sin, mut cos) = (per_m(0) * x_m).sin_cos();
            let (sin_by, cos_by) = (SPACING_PER_M * x_m).sin_cos();
            for [c, s] in since {
                *c += cos * ds_m;
                *s += sin * ds_m;
                (sin, cos) = (sin * cos_by + cos * sin_by, cos * cos_by - sin * sin_by);
            }
        }
    }

    /// The filter gives the numbers of a pose first, then the pose.
    fn pose(&mut self, measurement: &PoseMeasurement, _: &Step, _: Pose) {
        let mut headings = numbers(measurement).zip(&self.pending);
        let heading = headings.find(|((quantity, ..), _)| *quantity == Quantity::Heading);
        if let Some((_, z)) = heading {
            for (sums, since) in self.sums.iter_mut().zip(self.since.iter_mut()) {
                for (sums, [c, s]) in sums.iter_mut().zip(since) {
                    let more = [*c * *c, *c * *s, *s * *s, z * *c, z * *s];
                    *sums = core::array::from_fn(|i| sums[i] + more[i]);
                    (*c, *s) = (0.0, 0.0);
                }
            }
        }
        self.pending.clear();
    }
}

static FACTS: Facts<'static> = Facts {
    id: "place_wave",
    name: "a wave over the floor",
    equation: "dtheta = (a cos qx + b sin qx + c cos qy + d sin qy) |ds|",
    parameters: &[
        Parameter::amplitude("a", "rad/m", 1.0),
        Parameter::amplitude("b", "rad/m", 1.0),
        Parameter::amplitude("c", "rad/m", 1.0),
        Parameter::amplitude("d", "rad/m", 1.0),
    ],
    ..Facts::DEFAULT
};

impl Effect for PlaceWave {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let [x, y] = step.place_m.map(|x_m| (self.per_m * x_m).sin_cos());
        let wave = p[0] * x.1 + p[1] * x.0 + p[2] * y.1 + p[3] * y.0;
        Change { turn_rad: wave * step.travel_m().abs(), ..Change::NONE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::composition::Term;
    use crate::explain::explain;
    use crate::residuals::regressor::Regressor;
    use crate::selection::select::select;
    use crate::tests::synthetic::{TurnsPerMetre, campaign, full_plan};

    /// Tiles of 22 cm that turn the robot, one to the left and the next to the right.
    const TILES: TurnsPerMetre =
        TurnsPerMetre(
            |step| {
                if (step.place_m[0] / 0.22).floor() % 2.0 == 0.0 { 0.04 } else { -0.04 }
            },
        );

    #[test]
    fn tiles_are_a_wave_over_the_floor_and_no_noise() {
        let tiles = [Term::new(&TILES, Vec::new())];
        for seed in 0..2 {
            let answer = explain(&campaign(&full_plan(), &tiles, seed)).unwrap();
            let found = answer.unexplained;
            assert!(found.depends_on.contains(&Regressor::Place), "seed {seed}: {found:?}");
            for (hidden, is_found) in [(&tiles[..], true), (&[], false)] {
                let prepared = campaign(&full_plan(), hidden, seed).prepare().unwrap();
                let fitted = select(&prepared, &[]).fitted;
                let wave = strongest(&prepared, &fitted);
                assert_eq!(wave.is_some(), is_found, "seed {seed}: {wave:?}");
            }
        }
    }
}
