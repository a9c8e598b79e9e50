//! Does a wheel count wrongly by the same factor throughout a run?
//!
//! Counts that are taken once, twice or four times a line are wrong by just that factor, in every part of the run. A
//! wheel that slips counts more than it rolls as well: on a wet patch for a part of the run, in turns by any factor. So a
//! factor of the counts is believed only if both hold:
//!
//! ```text
//! every part of the run in which the wheels turned, fitted by itself, gets better with it      (1)
//! the factor that fits best is that one: least error(f) near f = times, to NEAR                (2)
//! ```

use super::data_fault::DataFault;
use super::geometry_fit::Tracks;
use super::relative_geometry::RelativeGeometry;
use super::thinned_run::ThinnedRun;

/// A run is divided in so many parts, in each of which its wheels turned as far.
const PARTS: usize = 4;
/// Fewer poses of a part show nothing of it.
const POSES_MIN: usize = 3;
/// (1): the error of a part falls to this share.
const MENDED_PART: f64 = 0.5;
/// (2): the logarithm of how far the best factor is from the one supposed, and of the steps in which it is sought.
const NEAR: f64 = 0.05;
const STEP: f64 = 0.1;

/// Whether a run is wrong by this factor of its counts, and not by anything that its wheels did; true of what is no factor
/// of counts.
pub(super) fn is_constant(
    tracks: &Tracks,
    track: &ThinnedRun,
    what: &DataFault,
    geometry: &RelativeGeometry,
) -> bool {
    let DataFault::Counts { wheel, times } = *what else { return true };
    let error_m = |track: &ThinnedRun, times: f64| {
        let mended = track.mended(&DataFault::Counts { wheel, times });
        tracks.error_of(&mended, geometry).0.error_m
    };
    // A part that is in order either way shows nothing.
    let worse = |part: &ThinnedRun| {
        let (before_m, after_m) = (error_m(part, 1.0), error_m(part, times));
        after_m > MENDED_PART * before_m && tracks.is_off(part, before_m.max(after_m))
    };
    if track.parts(PARTS).iter().filter(|part| part.poses.len() >= POSES_MIN).any(worse) {
        return false;
    }
    let squares = [-STEP, 0.0, STEP].map(|by| error_m(track, times * by.exp()).powi(2));
    // The least of the parabola through these three.
    let bend = squares[0] - 2.0 * squares[1] + squares[2];
    let best = STEP / 2.0 * (squares[0] - squares[2]) / bend;
    bend > 0.0 && best.abs() < NEAR
}
