//! Which last poses lie far from where the wheels led, as they were misread, or the robot was moved?
//!
//! By a geometry that fits most runs. A robot could reach a pose that was misread by ten degrees, and a fit takes it
//! for noise or for an effect; among twenty runs that agree to one degree it stands out.

use crate::recording::run::{Recording, Robot};

use super::end_pose::{End, FAR_OFF, OffEndPose};
use super::geometry_fit::Tracks;
use super::relative_geometry::RelativeGeometry;

/// From the first number of runs on there may be one outlier, from the second on two.
const RUNS_MIN: [usize; 2] = [5, 9];
/// An outlier is this many times as far off as the farthest of the others.
const TIMES_OTHERS: f64 = 5.0;
/// The least error of an outlier: of the position, as a share of what the wheels rolled and [`NEAR_M`], and of the heading.
const POSITION_MIN: f64 = 0.025;
const HEADING_MIN_RAD: f64 = 0.06;
/// The error of a position is taken in proportion to what the wheels rolled plus this \[m\]: a carpet carries a robot as far as
/// they roll, in a spin too.
const NEAR_M: f64 = 0.3;

/// The last pose of each of the runs that are `open`, if it is far off.
pub(super) fn last_poses(
    robot: &Robot,
    runs: &[Recording],
    tracks: &Tracks,
    geometry: &RelativeGeometry,
    open: &[bool],
) -> Vec<Option<OffEndPose>> {
    let ends: Vec<Option<End>> = tracks
        .each
        .iter()
        .zip(open)
        .map(|(track, open)| open.then(|| End::of(track, &track.reckon(robot, geometry))).flatten())
        .collect();
    let bound = |of: &dyn Fn(&End) -> Option<f64>, least: f64| {
        let mut all: Vec<f64> = ends.iter().flatten().filter_map(of).collect();
        all.sort_by(|a, b| b.total_cmp(a));
        let outliers = RUNS_MIN.iter().filter(|runs| all.len() >= **runs).count();
        let others = all.get(outliers).filter(|_| outliers > 0);
        others.map_or(f64::INFINITY, |farthest| (TIMES_OTHERS * farthest).max(least))
    };
    let rolled_m = |end: &End| end.path_m.max(end.turn_rad * robot.track_width_m / 2.0);
    let share = |end: &End| end.position_off_m().map(|off_m| off_m / (NEAR_M + rolled_m(end)));
    let turned = |end: &End| end.heading_off_rad().map(f64::abs);
    let position = bound(&share, POSITION_MIN);
    let heading_rad = bound(&turned, HEADING_MIN_RAD);
    let off = |(end, run): (&Option<End>, &Recording)| {
        let end = end.as_ref()?;
        // A run with a load may well differ from all others.
        let outlier = || {
            let off = OffEndPose {
                t_s: end.last.t_s,
                position_m: end.position_off_m().filter(|_| share(end) > Some(position)),
                heading_rad: end.heading_off_rad().filter(|rad| rad.abs() > heading_rad),
            };
            let is_off = off.position_m.is_some() || off.heading_rad.is_some();
            (is_off && run.payload_kg == 0.0).then_some(off)
        };
        end.off(FAR_OFF).or_else(outlier)
    };
    ends.iter().zip(runs).map(off).collect()
}
