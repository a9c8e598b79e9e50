//! What is wrong with all runs alike, or with the data sheet?

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::numeric::angle::wrap;
use crate::numeric::parallel::map;

use super::data_fault::{Axes, DataFault, DataHypothesis, Wheel};
use super::geometry_fit::{Solution, Tracks};
use super::relative_geometry::{OFF_BY, RelativeGeometry};
use super::start_pose_fit::Fit;
use super::thinned_run::{ThinnedRun, every_few};

/// As many of the runs that are far off, and of the others, are looked at.
const RUNS: (usize, usize) = (10, 6);
/// Errors are mended if they fall to this share; that of a single run must fall to this one in this share of the runs
/// that are far off, and at most this share of all may become worse, by this factor.
const MENDED: f64 = 1.0 / 3.0;
const MENDED_RUN: f64 = 0.5;
const MENDED_RUNS: f64 = 0.8;
const WORSE_RUNS: f64 = 0.1;
const WORSE_TIMES: f64 = 2.0;
/// So many explanations are looked at closely.
const LIKELY: usize = 16;
/// A factor of a length shows in this share of the runs.
const FACTOR_RUNS: f64 = 0.2;
/// The wheels went this far, in levers: the rms from the middle of the path.
const WENT: f64 = 0.2;
/// The tracks cannot tell explanations apart whose errors are within this factor and the error of a run in order.
const ALIKE: f64 = 1.3;
/// Factors of lengths and counts that people mistake: a diameter, edges of an encoder, 2 pi, units.
const FACTORS: [f64; 6] = [2.0, 4.0, TAU, 10.0, 100.0, 1000.0];
/// Units of positions in a metre: millimetres, centimetres, inches, feet.
pub(super) const UNITS_PER_M: [f64; 4] = [1000.0, 100.0, 39.37, 3.281];
/// Counts that are taken once, twice or four times a line.
pub(super) const EDGES: [f64; 4] = [2.0, 0.5, 4.0, 0.25];
/// A smaller angle between headings and travel may be a crooked marker \[rad\]; one this near to a quarter turn is one.
const TURNED_MIN_RAD: f64 = 0.35;
const QUARTER_RAD: f64 = 0.1;
/// So much of the runs agree on an angle: the length of the mean of unit vectors.
const AGREE: f64 = 0.9;

/// What would mend all runs, and the runs with that mended.
pub(super) struct Found {
    pub(super) hypothesis: DataHypothesis,
    pub(super) tracks: Vec<ThinnedRun>,
    pub(super) solution: Solution,
}

/// An explanation, tried.
struct Tried {
    what: DataFault,
    /// The error (rms) of the runs that were far off, in the units that they had \[m\].
    error_m: f64,
    holds: bool,
}

/// Explains the runs that are far off, if one thing is wrong with all runs.
pub(super) fn all_runs(tracks: &Tracks, as_is: &Solution) -> Option<Found> {
    let far = tracks.far(as_is);
    let near: Vec<usize> = (0..tracks.each.len()).filter(|run| !far.contains(run)).collect();
    let mut chosen = every_few(&far, RUNS.0);
    chosen.extend(every_few(&near, RUNS.1));
    let few =
        Tracks::new(tracks.robot, chosen.iter().map(|run| tracks.each[*run].clone()).collect());
    let errors = as_is.errors_m();
    let before: Vec<f64> = chosen.iter().map(|run| errors[*run]).collect();
    let whats = explanations(&few);
    let attempt = |what: &DataFault| {
        let mended = mend(&few, what);
        let solution = mended.solve(&center(what));
        (tried(&few, &mended, &before, what, &solution), solution)
    };
    let rough = map(&whats, |what| mend(&few, what).rough_cost(&center(what)));
    let mut order: Vec<usize> = (0..whats.len()).collect();
    order.sort_by(|a, b| rough[*a].total_cmp(&rough[*b]));
    order.truncate(LIKELY);
    order.sort_unstable();
    let whats: Vec<DataFault> = order.into_iter().map(|index| whats[index]).collect();
    let first = map(&whats, attempt);
    let turned = |(tried, solution): &(Tried, Solution)| turned(&tried.what, solution);
    let mut again: Vec<DataFault> = first.iter().filter_map(turned).collect();
    again.extend(angle(&as_is.fits).and_then(|turned_rad| {
        (turned_rad.abs() > TURNED_MIN_RAD).then_some(heading(false, false, turned_rad))
    }));
    let second = map(&again, attempt);
    let all: Vec<Tried> = first.into_iter().chain(second).map(|(tried, _)| tried).collect();
    let best_m =
        all.iter().filter(|tried| tried.holds).map(|tried| tried.error_m).reduce(f64::min)?;
    let limit_m = ALIKE * best_m + rms(far.iter().map(|run| tracks.near_m(*run)));
    let alike = |tried: &&Tried| tried.holds && tried.error_m <= limit_m;
    let mut class = all.iter().filter(alike);
    let what = class.next()?.what;
    let or: Vec<DataFault> =
        class.map(|tried| tried.what).filter(|other| !covers(&what, other)).collect();
    let others = all.iter().filter(|tried| !alike(tried) && !same(&tried.what, &what));
    let next = others.min_by(|a, b| a.error_m.total_cmp(&b.error_m));
    let mended = mend(tracks, &what);
    let solution = mended.solve(&center(&what));
    let all_tried = tried(tracks, &mended, &errors, &what, &solution);
    if !all_tried.holds {
        return None;
    }
    let after = solution.errors_m();
    let hypothesis = DataHypothesis {
        what,
        run: None,
        or,
        error_m: rms(far.iter().map(|run| errors[*run])),
        mended_m: rms(far.iter().map(|run| after[*run])),
        next: next.map(|tried| (tried.what, tried.error_m)),
    };
    Some(Found { hypothesis, tracks: mended.each, solution })
}

/// Everything that may be wrong with all runs, the likelier first; angles are found in a second round.
fn explanations(tracks: &Tracks) -> Vec<DataFault> {
    let gear = tracks.robot.gear_reduction;
    let gear = (!(1.0 / OFF_BY..OFF_BY).contains(&gear)).then_some(gear.max(1.0 / gear));
    let factors = || FACTORS.into_iter().chain(gear).flat_map(|times| [times, 1.0 / times]);
    let headings = tracks.each.iter().any(ThinnedRun::has_headings);
    let mut all = vec![DataFault::WheelsExchanged];
    all.extend(of_axes(headings));
    all.extend(
        [Wheel::Left, Wheel::Right, Wheel::Both].map(|wheel| DataFault::CountsReversed { wheel }),
    );
    all.extend(UNITS_PER_M.map(|per_m| DataFault::Positions { per_m }));
    all.extend(factors().map(|times| DataFault::Radius { times }));
    all.extend(factors().map(|times| DataFault::Track { times }));
    all.extend([1e-3, 1e-2].map(|times| DataFault::Lengths { times }));
    for wheel in [Wheel::Left, Wheel::Right] {
        all.extend(EDGES.map(|times| DataFault::Counts { wheel, times }));
    }
    if tracks.each.iter().all(|track| track.poses.len() <= 2) {
        all.extend(of_marks());
    }
    all
}

/// Axes of all poses.
pub(super) fn of_axes(headings: bool) -> Vec<DataFault> {
    let axes = |axes: Axes| DataFault::Axes { axes, after_first: false };
    let mut all = vec![axes(Axes::YMirrored)];
    if headings {
        all.extend([axes(Axes::XMirrored), axes(Axes::Exchanged)]);
        all.extend(
            [(false, true), (true, false), (true, true)]
                .map(|(degrees, negated)| heading(degrees, negated, 0.0)),
        );
    }
    all
}

/// Axes of the poses after the first of each run, which is a mark on the floor in our axes.
fn of_marks() -> Vec<DataFault> {
    let heading =
        |negated: bool, turned_rad: f64| Axes::Heading { degrees: false, negated, turned_rad };
    let all = [
        Axes::YMirrored,
        Axes::XMirrored,
        Axes::Exchanged,
        heading(true, 0.0),
        heading(true, FRAC_PI_2),
        heading(true, -FRAC_PI_2),
        heading(false, FRAC_PI_2),
        heading(false, -FRAC_PI_2),
        heading(false, PI),
        Axes::Frame { turned_rad: FRAC_PI_2 },
        Axes::Frame { turned_rad: -FRAC_PI_2 },
        Axes::Frame { turned_rad: PI },
    ];
    all.map(|axes| DataFault::Axes { axes, after_first: true }).to_vec()
}

pub(super) fn heading(degrees: bool, negated: bool, turned_rad: f64) -> DataFault {
    let axes = Axes::Heading { degrees, negated, turned_rad };
    DataFault::Axes { axes, after_first: false }
}

fn mend<'a>(tracks: &Tracks<'a>, what: &DataFault) -> Tracks<'a> {
    Tracks::new(tracks.robot, tracks.each.iter().map(|track| track.mended(what)).collect())
}

/// The geometry by the data sheet with this mended.
fn center(what: &DataFault) -> RelativeGeometry {
    match *what {
        DataFault::Radius { times } => RelativeGeometry::times(times, times),
        DataFault::Track { times } => RelativeGeometry::times(1.0, 1.0 / times),
        DataFault::Lengths { times } => RelativeGeometry::times(times, 1.0),
        _ => RelativeGeometry::NOMINAL,
    }
}

/// How many times larger the errors of mended tracks would be in the units as they are, to compare with others.
pub(super) fn shrunk(what: &DataFault) -> f64 {
    match *what {
        DataFault::Positions { per_m } => per_m,
        _ => 1.0,
    }
}

/// Whether a run that fits can show this: to shrink everything to a point is no explanation.
pub(super) fn shows(tracks: &Tracks, track: &ThinnedRun, what: &DataFault, fit: &Fit) -> bool {
    let count = fit.kept.iter().filter(|kept| **kept).count() as f64;
    match what {
        DataFault::Positions { .. } => fit.by_wheels_m2 > (WENT * tracks.lever_m).powi(2) * count,
        DataFault::Axes { axes: Axes::Heading { degrees: true, .. }, .. } => {
            track.turned_rad(tracks.robot) > TURNED_MIN_RAD
        }
        _ => true,
    }
}

/// Whether this explains the runs that were far off: their errors are `before`.
fn tried(
    few: &Tracks,
    mended: &Tracks,
    before: &[f64],
    what: &DataFault,
    solution: &Solution,
) -> Tried {
    let after = solution.errors_m();
    let far: Vec<usize> = (0..after.len()).filter(|run| few.is_far(*run, before[*run])).collect();
    let showing = |run: &&usize| shows(few, &few.each[**run], what, &solution.fits[**run]);
    let showing: Vec<usize> = far.iter().filter(showing).copied().collect();
    let times = shrunk(what);
    let mends = |run: &&usize| after[**run] < MENDED_RUN * before[**run];
    let worsens =
        |run: &usize| mended.is_far(*run, after[*run]) && after[*run] > WORSE_TIMES * before[*run];
    let mends = showing.iter().filter(mends).count();
    let worse = (0..after.len()).filter(worsens).count();
    let error_m = times * rms(far.iter().map(|run| after[*run]));
    let is_of_all = !matches!(
        what,
        DataFault::Radius { .. }
            | DataFault::Track { .. }
            | DataFault::Lengths { .. }
            | DataFault::Positions { .. }
    );
    let what = fitted(what, &solution.geometry);
    let beyond = |times: f64| !(1.0 / OFF_BY..OFF_BY).contains(&times);
    let is_factor = match what {
        DataFault::Radius { times } | DataFault::Track { times } | DataFault::Lengths { times } => {
            beyond(times)
        }
        _ => true,
    };
    let holds = is_factor
        && (is_of_all || far.len() as f64 >= FACTOR_RUNS * after.len() as f64)
        && !showing.is_empty()
        && mends as f64 >= MENDED_RUNS * showing.len() as f64
        && worse as f64 <= WORSE_RUNS * after.len() as f64
        && rms(far.iter().map(|run| after[*run]))
            < MENDED * rms(far.iter().map(|run| before[*run]));
    Tried { what, error_m, holds }
}

/// The factor of a length as it was fitted.
fn fitted(what: &DataFault, geometry: &RelativeGeometry) -> DataFault {
    match what {
        DataFault::Radius { .. } => DataFault::Radius { times: geometry.travel.exp() },
        DataFault::Lengths { .. } => DataFault::Lengths { times: geometry.travel.exp() },
        DataFault::Track { .. } => {
            DataFault::Track { times: (geometry.travel - geometry.turn).exp() }
        }
        what => *what,
    }
}

/// Whether two factors of one kind, found from different beginnings, are the same.
fn same(a: &DataFault, b: &DataFault) -> bool {
    let near = |a: f64, b: f64| (a / b).ln().abs() < OFF_BY.ln();
    match (a, b) {
        (DataFault::Radius { times: a }, DataFault::Radius { times: b })
        | (DataFault::Track { times: a }, DataFault::Track { times: b })
        | (DataFault::Lengths { times: a }, DataFault::Lengths { times: b }) => near(*a, *b),
        (DataFault::Positions { per_m: a }, DataFault::Positions { per_m: b }) => near(*a, *b),
        (a, b) => a == b,
    }
}

/// Whether one explanation says all that the other says: the same, or of all poses and not only of some.
fn covers(what: &DataFault, other: &DataFault) -> bool {
    match (what, other) {
        (DataFault::Axes { axes: a, after_first: false }, DataFault::Axes { axes: b, .. }) => {
            a == b
        }
        _ => same(what, other),
    }
}

/// The same axes with headings turned by the angle that all runs share.
fn turned(what: &DataFault, solution: &Solution) -> Option<DataFault> {
    let DataFault::Axes { axes: Axes::Heading { degrees, negated, .. }, .. } = *what else {
        return None;
    };
    let turned_rad = angle(&solution.fits).filter(|rad| rad.abs() > TURNED_MIN_RAD)?;
    Some(heading(degrees, negated, turned_rad))
}

/// The angle by which headings are turned, if the runs agree on it; a quarter turn if it is near to one \[rad\].
pub(super) fn angle(fits: &[Fit]) -> Option<f64> {
    let (mut sum, mut weight) = ([0.0; 2], 0.0);
    for fit in fits {
        let Some(turned_rad) = fit.turned else { continue };
        let far = fit.along_m2.sqrt();
        sum = [sum[0] + far * turned_rad.cos(), sum[1] + far * turned_rad.sin()];
        weight += far;
    }
    if sum[0].hypot(sum[1]) < AGREE * weight || weight <= 0.0 {
        return None;
    }
    Some(quarter(sum[1].atan2(sum[0])))
}

/// A quarter turn, if it is near to one.
fn quarter(turned_rad: f64) -> f64 {
    let nearest = (turned_rad / FRAC_PI_2).round() * FRAC_PI_2;
    wrap(if (turned_rad - nearest).abs() < QUARTER_RAD { nearest } else { turned_rad })
}

pub(super) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) =
        values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}
