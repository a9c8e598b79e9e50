//! Do the residuals come from a place on the floor that is wet or uneven, or has a cable under it?
//!
//! ```text
//! w_i  = exp(-d_i^2 / (2 L^2)),   d_i from wheel i to the place                           (1)
//! ds_i += w_i (p + q a_i sign(ds_i)) ds_i                                                 (2)
//! ```
//!
//! A puddle has an edge: its weight is
//!
//! ```text
//! w_i  = exp(-(d_i / L)^8)                                                                (3)
//! ```
//!
//! p makes a wheel's travel over the place longer or shorter, q is slip under force. A place acts on whichever
//! wheel comes there, in every run. The search is coarse over the whole floor, then fine around the best place.

use serde::{Deserialize, Serialize};

use std::collections::{BTreeMap, BTreeSet};

use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::fit::Fitted;
use crate::estimation::normal_equations::Sums;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::distributions::chi_squared;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::campaign::Prepared;
use crate::recording::motion::Step;

/// L of (1) in the coarse search \[m\].
const REACH_M: f64 = 0.15;
/// The coarse search tests at most this many places: those that most runs come to.
const PATCHES_MAX: usize = 32;
/// In a place that fewer runs come to, an effect of the floor cannot be told from a single disturbance.
const RUNS_MIN: usize = 2;
/// Without a coarse p-value below this there is no fine search.
const COARSE_P: f64 = 1e-3;
/// L of (1) in the fine search \[m\]: a cable under the carpet, a puddle.
const FINE_REACHES_M: [f64; 2] = [0.06, 0.15];
/// L of (3) \[m\].
const EDGED_REACHES_M: [f64; 3] = [0.1, 0.2, 0.3];
/// Offsets of the fine search from the best coarse place, along x and y \[m\].
const FINE_OFFSETS_M: [f64; 5] = [-0.15, -0.075, 0.0, 0.075, 0.15];

/// One place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FloorPatch {
    /// Its middle \[m\].
    pub at_m: [f64; 2],
    reach_m: f64,
    /// Whether it has an edge, (3).
    edged: bool,
}

static FLOOR_PATCH: Facts<'static> = Facts {
    id: "floor_patch",
    name: "something on the floor",
    equation: "ds_i += w_i (p + q a_i sign(ds_i)) ds_i",
    parameters: &[Parameter::amplitude("p", "1", 1.0), Parameter::amplitude("q", "s^2/m", 1.0)],
    ..Facts::DEFAULT
};

/// Where the weight of (1) or (3) is less, a place does nothing.
const WEIGHT_MIN: f64 = 3e-4;

impl FloorPatch {
    /// So far from its middle it does nothing \[m\].
    fn nothing_from_m(&self) -> f64 {
        // exp(-1.7^4) and exp(-4.1^2 / 2) are less than `WEIGHT_MIN`.
        self.reach_m * if self.edged { 1.7_f64.sqrt() } else { 4.1 }
    }
}

impl Effect for FloorPatch {
    fn facts(&self) -> Facts<'_> {
        FLOOR_PATCH
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let away_m = [step.place_m[0] - self.at_m[0], step.place_m[1] - self.at_m[1]];
        let from_m = self.nothing_from_m() + step.track_width_m / 2.0;
        // Most places are far away in most steps.
        if away_m[0] * away_m[0] + away_m[1] * away_m[1] > from_m * from_m {
            return Change::NONE;
        }
        let places = wheel_places_m(step.place_m, step.heading_rad, step.track_width_m);
        let (ds_m, accel) = (step.wheel_travel_m(), step.wheel_accel_mps2);
        let share = |[x_m, y_m]: [f64; 2], ds_m: f64, accel_mps2: f64| {
            let (dx, dy) = (x_m - self.at_m[0], y_m - self.at_m[1]);
            let square = (dx * dx + dy * dy) / (self.reach_m * self.reach_m);
            let weight = if self.edged { (-square.powi(4)).exp() } else { (-square / 2.0).exp() };
            if weight < WEIGHT_MIN {
                return Jet::ZERO;
            }
            p[0] * weight + p[1] * (weight * accel_mps2 * ds_m.signum())
        };
        Change {
            travel: WheelPair::new(
                share(places.left, ds_m.left, accel.left),
                share(places.right, ds_m.right, accel.right),
            ),
            ..Change::NONE
        }
    }
}

/// Where each wheel stands \[m\].
fn wheel_places_m(
    [x_m, y_m]: [f64; 2],
    heading_rad: f64,
    track_width_m: f64,
) -> WheelPair<[f64; 2]> {
    let (sin, cos) = heading_rad.sin_cos();
    let half_m = track_width_m / 2.0;
    WheelPair::new(
        [x_m - half_m * sin, y_m + half_m * cos],
        [x_m + half_m * sin, y_m - half_m * cos],
    )
}

/// A place of the coarse search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaceSeen {
    /// Its middle \[m\].
    pub at_m: [f64; 2],
    /// How much of the residuals it would explain, in -2 log likelihood.
    pub gain: f64,
}

impl PlaceSeen {
    /// Places of the coarse search are cells with this side \[m\].
    pub const SIDE_M: f64 = 2.0 * REACH_M;
}

/// What the search of the floor found.
pub(super) struct FloorSearch {
    /// The places of the fine search, if the coarse one found anything.
    pub(super) patches: Vec<FloorPatch>,
    /// How many places were tested, coarse and fine.
    pub(super) tested: usize,
    /// The places of the coarse search.
    pub(super) seen: Vec<PlaceSeen>,
}

/// Searches the floor for a place that the residuals come from.
pub(super) fn search_floor(prepared: &Prepared, fitted: &Fitted<'_>) -> FloorSearch {
    let patches = visited(prepared);
    let seen: Vec<PlaceSeen> = patches
        .iter()
        .zip(gains(prepared, fitted, &patches))
        .map(|(patch, gain)| PlaceSeen { at_m: patch.at_m, gain })
        .collect();
    let best = seen.iter().max_by(|a, b| a.gain.total_cmp(&b.gain));
    let Some(best) =
        best.filter(|place| chi_squared(2, place.gain) * (patches.len() as f64) < COARSE_P)
    else {
        return FloorSearch { patches: Vec::new(), tested: patches.len(), seen };
    };
    let fine: Vec<FloorPatch> = FINE_REACHES_M
        .iter()
        .flat_map(|reach_m| FINE_OFFSETS_M.iter().map(move |dx| (*reach_m, *dx)))
        .flat_map(|(reach_m, dx)| FINE_OFFSETS_M.iter().map(move |dy| (reach_m, [dx, *dy])))
        .map(|(reach_m, [dx, dy])| FloorPatch {
            at_m: [best.at_m[0] + dx, best.at_m[1] + dy],
            reach_m,
            edged: false,
        })
        .collect();
    FloorSearch { tested: patches.len() + fine.len(), patches: fine, seen }
}

/// Around the place that residuals come from, the place of each size, with an edge and without, that explains most; none
/// where they come from no place.
pub(super) fn best_places(prepared: &Prepared, fitted: &Fitted<'_>) -> Vec<FloorPatch> {
    let mut patches = search_floor(prepared, fitted).patches;
    if patches.is_empty() {
        return patches;
    }
    // All places of one size are together.
    let each = FINE_OFFSETS_M.len().pow(2);
    let middles_m: Vec<[f64; 2]> = patches.iter().take(each).map(|patch| patch.at_m).collect();
    patches.extend(EDGED_REACHES_M.iter().flat_map(|&reach_m| {
        middles_m.iter().map(move |&at_m| FloorPatch { at_m, reach_m, edged: true })
    }));
    let gains = gains(prepared, fitted, &patches);
    let most = |(patches, gains): (&[FloorPatch], &[f64])| {
        let of_size = patches.iter().zip(gains);
        of_size.max_by(|a, b| a.1.total_cmp(b.1)).map(|(patch, _)| *patch)
    };
    patches.chunks(each).zip(gains.chunks(each)).filter_map(most).collect()
}

/// What each of these places would explain beside the model, in -2 log likelihood.
fn gains(prepared: &Prepared, fitted: &Fitted<'_>, patches: &[FloorPatch]) -> Vec<f64> {
    let mut terms = fitted.terms.clone();
    terms.extend(patches.iter().map(|patch| Term::new(patch, vec![0.0; 2])));
    let terms = PlacedTerm::place(&terms);
    let equations = CampaignEquations::gather(prepared, &terms, &fitted.noise);
    let in_model = &terms[..fitted.terms.len()];
    let model: Vec<usize> = in_model.iter().flat_map(PlacedTerm::columns).collect();
    let chi_squared_of = |columns: &[usize]| {
        let delta = equations.best(&equations.total, columns);
        equations.total.chi_squared(columns, &delta)
    };
    let without = chi_squared_of(&model);
    let gain = |term: &PlacedTerm<'_>| {
        let both: Vec<usize> = model.iter().copied().chain(term.columns()).collect();
        without - chi_squared_of(&both)
    };
    terms[fitted.terms.len()..].iter().map(gain).collect()
}

/// The places that wheels came to in several runs.
pub(super) fn visited(prepared: &Prepared) -> Vec<FloorPatch> {
    let mut runs_of: BTreeMap<(i64, i64), BTreeSet<usize>> = BTreeMap::new();
    let pitch_m = PlaceSeen::SIDE_M;
    let track_width_m = prepared.robot.track_width_m;
    for (index, run) in prepared.runs.iter().enumerate() {
        for measurement in &run.recording.measured_poses {
            let Some((position_m, heading_rad)) =
                measurement.position_m.zip(measurement.heading_rad)
            else {
                continue;
            };
            let places = wheel_places_m(position_m, heading_rad, track_width_m);
            for [x_m, y_m] in [places.left, places.right] {
                let cell = ((x_m / pitch_m).round() as i64, (y_m / pitch_m).round() as i64);
                runs_of.entry(cell).or_default().insert(index);
            }
        }
    }
    let mut cells: Vec<_> =
        runs_of.into_iter().filter(|(_, runs)| runs.len() >= RUNS_MIN).collect();
    cells.sort_by_key(|(_, runs)| std::cmp::Reverse(runs.len()));
    cells.truncate(PATCHES_MAX);
    let middle = |cell: i64| cell as f64 * pitch_m;
    cells
        .into_iter()
        .map(|((x, y), _)| FloorPatch {
            at_m: [middle(x), middle(y)],
            reach_m: REACH_M,
            edged: false,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::explanation::explain;
    use crate::residuals::regressor::Regressor;
    use crate::tests::synthetic::{campaign, full_plan};

    #[test]
    fn a_place_where_a_wheel_loses_travel_is_found() {
        // A quarter of the small circle to the left, on the path of the right wheel: it loses 4 mm at either speed.
        let bump = FloorPatch { at_m: [0.586, 0.4], reach_m: 0.05, edged: false };
        let truth = [Term::new(&bump, vec![-0.03, 0.0])];
        let answer = explain(&campaign(&full_plan(), &truth, 31)).unwrap();
        let found = &answer.unexplained;
        assert_eq!(found.depends_on.first(), Some(&Regressor::Place), "{found:?}");
        let [x_m, y_m] = found.place_m.unwrap();
        let distance_m = (x_m - bump.at_m[0]).hypot(y_m - bump.at_m[1]);
        assert!(distance_m < 0.12, "{distance_m} m away");
    }

    #[test]
    fn on_a_sound_floor_no_place_is_found() {
        for seed in 0..4 {
            let answer = explain(&campaign(&full_plan(), &[], 310 + seed)).unwrap();
            assert!(!answer.unexplained.structure, "{:?}", answer.unexplained);
            assert_eq!(answer.unexplained.place_m, None);
        }
    }
}
