//! What is wrong with one run, while the others are in order?

use super::all_runs::{EDGES, UNITS_PER_M, angle, heading, of_axes, shows, shrunk};
use super::constant_factor;
use super::data_fault::{Axes, DataFault, DataHypothesis, Wheel};
use super::geometry_fit::Tracks;
use super::relative_geometry::RelativeGeometry;
use super::start_pose_fit::Fit;
use super::thinned_run::ThinnedRun;

/// An error is mended if it falls to this share.
const MENDED: f64 = 1.0 / 3.0;
/// Fewer poses do not show what is wrong with a run: the last one may be misread.
const POSES_MIN: usize = 5;
/// Explanations whose errors are within this factor and the error of a run in order cannot be told apart.
const ALIKE: f64 = 1.3;
/// Positions go where headings point as well as before if what goes across grows by no more than this factor.
const SAME_WAY: f64 = 2.0;
/// Smaller turns of headings are none \[rad\].
const TURNED_MIN_RAD: f64 = 0.35;

/// Explains a run that is far off, by the geometry of the others.
pub(super) fn one_run(
    tracks: &Tracks,
    run: usize,
    geometry: &RelativeGeometry,
) -> Option<DataHypothesis> {
    let track = &tracks.each[run];
    if track.poses.len() < POSES_MIN {
        return None;
    }
    let as_is = tracks.error_of(track, geometry).0;
    let attempt = |what: &DataFault| tracks.error_of(&track.mended(what), geometry).0;
    let mut tried: Vec<(DataFault, Fit)> =
        explanations(track).into_iter().map(|what| (what, attempt(&what))).collect();
    let bases = tried.iter().map(|(what, fit)| (*what, fit.clone()));
    let plain = (heading(false, false, 0.0), as_is.clone());
    let turned: Vec<DataFault> =
        bases.chain([plain]).filter_map(|(what, fit)| turned(&what, fit)).collect();
    tried.extend(turned.into_iter().map(|what| (what, attempt(&what))));
    let error = |(what, fit): &(DataFault, Fit)| shrunk(what) * fit.error_m;
    let holds = |tried: &&(DataFault, Fit)| {
        let (what, fit) = tried;
        let mended = fit.error_m < MENDED * as_is.error_m && !tracks.is_far(run, fit.error_m);
        mended
            && keeps_directions(track, what)
            && shows(tracks, track, what, fit)
            && constant_factor::is_constant(tracks, track, what, geometry)
    };
    let best_m = tried.iter().filter(holds).map(error).reduce(f64::min)?;
    let limit_m = ALIKE * best_m + tracks.near_m(run);
    let alike = |tried: &&(DataFault, Fit)| holds(tried) && error(tried) <= limit_m;
    let mut class = tried.iter().filter(alike);
    let (what, mended) = class.next()?;
    let or = class.map(|(what, _)| *what).collect();
    let others = tried.iter().filter(|tried| !alike(tried));
    let next = others.min_by(|a, b| error(a).total_cmp(&error(b)));
    let hypothesis = DataHypothesis {
        what: *what,
        run: None,
        or,
        error_m: as_is.error_m,
        mended_m: mended.error_m,
        next: next.map(|next| (next.0, error(next))),
    };
    Some(hypothesis)
}

/// Whether positions go where headings point as well as before, with this mended. A robot that only drives crooked goes where
/// it points: with other axes it may come nearer to what the wheels say, but it goes elsewhere.
fn keeps_directions(track: &ThinnedRun, what: &DataFault) -> bool {
    let DataFault::Axes { .. } = what else { return true };
    let [before, after] = [track, &track.mended(what)].map(ThinnedRun::across);
    before.zip(after).is_none_or(|(before, after)| after <= SAME_WAY * before)
}

/// Everything that may be wrong with one run.
fn explanations(track: &ThinnedRun) -> Vec<DataFault> {
    let mut all = vec![DataFault::WheelsExchanged];
    all.extend(of_axes(track.has_headings()));
    all.extend(
        [Wheel::Left, Wheel::Right, Wheel::Both].map(|wheel| DataFault::CountsReversed { wheel }),
    );
    all.extend(UNITS_PER_M.map(|per_m| DataFault::Positions { per_m }));
    for wheel in [Wheel::Both, Wheel::Left, Wheel::Right] {
        all.extend(EDGES.map(|times| DataFault::Counts { wheel, times }));
    }
    all
}

/// The same axes with headings turned as this run has them.
fn turned(what: &DataFault, fit: Fit) -> Option<DataFault> {
    let DataFault::Axes { axes: Axes::Heading { degrees, negated, .. }, .. } = *what else {
        return None;
    };
    let turned_rad = angle(&[fit]).filter(|rad| rad.abs() > TURNED_MIN_RAD)?;
    Some(heading(degrees, negated, turned_rad))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::synthetic::{ROBOT, campaign, part_of_plan, term};

    #[test]
    fn a_robot_that_goes_where_it_points_has_no_mirrored_axes() {
        let mirrored = DataFault::Axes { axes: Axes::YMirrored, after_first: false };
        let pulls = [term("heading_pull", &[0.07])];
        for run in &campaign(&part_of_plan(&["out_and_back", "arc"]), &pulls, 4).runs {
            let track = ThinnedRun::of(&ROBOT, &run.wheels, &run.measured_poses);
            assert!(!keeps_directions(&track, &mirrored), "{}", run.name);
            // Where they are mirrored, to mend them is no worse.
            assert!(keeps_directions(&track.mended(&mirrored), &mirrored), "{}", run.name);
            let round = DataFault::Axes {
                axes: Axes::Heading {
                    degrees: false,
                    negated: false,
                    turned_rad: core::f64::consts::PI,
                },
                after_first: false,
            };
            assert!(keeps_directions(&track, &round), "{}: the other way round", run.name);
        }
    }
}
