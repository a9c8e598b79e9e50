//! Which single poses are elsewhere for one frame, or for a few? A fit can live with some.

use core::ops::Range;

use crate::numeric::angle::wrap;
use crate::numeric::median::median;
use crate::recording::run::{Recording, Robot};

use super::dead_reckoning::Reckoned;

/// A position far from those before and after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spike {
    /// When \[s\].
    pub t_s: f64,
    /// How far off it is \[m\].
    pub off_m: f64,
}

/// A spike is off by at least this \[m\], and by this many times the median error between frames.
const SPIKE_M: f64 = 0.1;
const SPIKE_TIMES: f64 = 10.0;
/// Outliers that are to be left out are off by at least so much, in position \[m\] or heading \[rad\].
const OUTLIER: (f64, f64) = (0.02, 0.2);
/// Outliers last for so many frames at most.
const FRAMES_MAX: usize = 3;
/// Frames farther apart than this do not show that the one between them is wrong \[s\].
const SPIKE_S: f64 = 1.0;
/// Fewer rows do not show what is usual.
const STEPS_MIN: usize = 20;

/// The first position of a run that is elsewhere for one frame: an outlier, which a fit may well ignore.
pub fn spike(robot: &Robot, run: &Recording) -> Option<Spike> {
    let reckoned = Reckoned::of(robot, run);
    let track = positions(run, &reckoned);
    let limit_m = track.limit(SPIKE_M)?;
    let mut single = track.outliers(limit_m, 1);
    single.next().map(|range| Spike { t_s: track.times_s[range.start], off_m: track.off(&range) })
}

/// The times of all poses of a run that are elsewhere, or turned another way, for a frame or a few \[s\].
///
/// A tracker that finds a marker in the wrong place, or back to front. Also at either end, where nothing shows whether the
/// tracker jumped.
pub fn outliers_s(robot: &Robot, run: &Recording) -> Vec<f64> {
    let reckoned = Reckoned::of(robot, run);
    let mut times_s = positions(run, &reckoned).outliers_s(OUTLIER.0);
    times_s.extend(headings(run, &reckoned).outliers_s(OUTLIER.1));
    times_s.sort_by(f64::total_cmp);
    times_s.dedup();
    times_s
}

/// Times, and how much farther one of them is from another than the wheels say.
struct Track<F> {
    times_s: Vec<f64>,
    apart: F,
}

fn positions(run: &Recording, reckoned: &Reckoned<'_>) -> Track<impl Fn(usize, usize) -> f64> {
    let poses = run.measured_poses.iter();
    let (times_s, at): (Vec<f64>, Vec<[f64; 2]>) =
        poses.filter_map(|pose| Some((pose.t_s, pose.position_m?))).unzip();
    let times = times_s.clone();
    let apart = move |a: usize, b: usize| {
        let gap_m = (at[b][0] - at[a][0]).hypot(at[b][1] - at[a][1]);
        gap_m - reckoned.rolled(times[a], times[b]).0
    };
    Track { times_s, apart }
}

fn headings(run: &Recording, reckoned: &Reckoned<'_>) -> Track<impl Fn(usize, usize) -> f64> {
    let poses = run.measured_poses.iter();
    let (times_s, heading_rad): (Vec<f64>, Vec<f64>) =
        poses.filter_map(|pose| Some((pose.t_s, pose.heading_rad?))).unzip();
    let times = times_s.clone();
    let apart = move |a: usize, b: usize| {
        let gap_rad = wrap(heading_rad[b] - heading_rad[a]).abs();
        gap_rad - reckoned.rolled(times[a], times[b]).1
    };
    Track { times_s, apart }
}

impl<F: Fn(usize, usize) -> f64> Track<F> {
    /// From where on an error is not usual; `None` if too little is known of what is.
    fn limit(&self, least: f64) -> Option<f64> {
        let count = self.times_s.len();
        if count <= STEPS_MIN {
            return None;
        }
        let usual = median((1..count).map(|k| (self.apart)(k - 1, k).abs()).collect())?;
        Some(least.max(SPIKE_TIMES * usual))
    }

    /// How far these are off from those before and after them, the nearest of them.
    fn off(&self, range: &Range<usize>) -> f64 {
        let nearest = |k: usize| (self.apart)(range.start - 1, k).min((self.apart)(k, range.end));
        range.clone().map(nearest).fold(f64::INFINITY, f64::min)
    }

    /// Those that are elsewhere for at most so many frames, after which the track goes on as before them.
    fn outliers(&self, limit: f64, frames_max: usize) -> impl Iterator<Item = Range<usize>> {
        let count = self.times_s.len();
        let is_off = move |range: &Range<usize>| {
            let (before, after) = (range.start - 1, range.end);
            let off = self.off(range);
            off > limit
                && self.times_s[after] - self.times_s[before] < SPIKE_S
                && (self.apart)(before, after) < 0.5 * off
        };
        let mut next = 1;
        core::iter::from_fn(move || {
            while next < count {
                let from = next;
                let ranges = (1..=frames_max).map(|frames| from..from + frames);
                let found = ranges.take_while(|range| range.end < count).find(is_off);
                next = found.as_ref().map_or(from + 1, |range| range.end + 1);
                if found.is_some() {
                    return found;
                }
            }
            None
        })
    }

    /// Those before the first frames that agree, and after the last ones, if they are few.
    fn ends(&self, limit: f64) -> [Range<usize>; 2] {
        let count = self.times_s.len();
        let jumps = |k: usize| (self.apart)(k - 1, k) > limit;
        let agree = |mut range: Range<usize>| !range.any(jumps);
        let first = (1..=FRAMES_MAX).find(|k| jumps(*k) && agree(k + 1..k + 1 + FRAMES_MAX));
        let last = (count - FRAMES_MAX..count).find(|k| jumps(*k) && agree(k - FRAMES_MAX..*k));
        [0..first.unwrap_or(0), last.unwrap_or(count)..count]
    }

    /// The times of all outliers \[s\].
    fn outliers_s(&self, least: f64) -> Vec<f64> {
        let Some(limit) = self.limit(least) else { return Vec::new() };
        let mut found: Vec<Range<usize>> = self.outliers(limit, FRAMES_MAX).collect();
        // Beside an outlier, a jump at an end is the way back.
        let is_near = |a: &Range<usize>, b: &Range<usize>| a.start <= b.end && b.start <= a.end;
        for end in self.ends(limit) {
            if !found.iter().any(|outlier| is_near(outlier, &end)) {
                found.push(end);
            }
        }
        found.into_iter().flatten().map(|k| self.times_s[k]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::synthetic::{ROBOT, each_alone, sound};

    #[test]
    fn a_robot_that_is_merely_inaccurate_has_no_spikes() {
        for (id, campaign) in each_alone() {
            assert_eq!(campaign.runs.iter().find_map(|run| spike(&ROBOT, run)), None, "{id}");
        }
    }

    #[test]
    fn outliers_are_found_wherever_they_are_and_nothing_else() {
        for run in sound().runs.iter().filter(|run| run.measured_poses.len() > 2 * STEPS_MIN) {
            assert_eq!(outliers_s(&ROBOT, run), [], "{}", run.name);
            let count = run.measured_poses.len();
            for (number, places) in
                [vec![0], vec![1], vec![10, 11, 12, 20], vec![2, count - 2, count - 1]]
                    .iter()
                    .enumerate()
            {
                let mut wrong = run.clone();
                for (nth, k) in places.iter().enumerate() {
                    let pose = &mut wrong.measured_poses[*k];
                    // By turns back to front and elsewhere.
                    if number % 2 == 0 {
                        pose.position_m =
                            pose.position_m.map(|[x, y]| [x + 0.3 + 0.1 * nth as f64, y]);
                    } else {
                        pose.heading_rad = pose.heading_rad.map(|rad| rad + 3.0);
                    }
                }
                let expected: Vec<f64> =
                    places.iter().map(|k| run.measured_poses[*k].t_s).collect();
                assert_eq!(outliers_s(&ROBOT, &wrong), expected, "{} {places:?}", run.name);
            }
        }
        for (id, campaign) in each_alone() {
            for run in &campaign.runs {
                assert_eq!(outliers_s(&ROBOT, run), [], "{id}");
            }
        }
    }

    #[test]
    fn one_position_that_is_elsewhere_is_found() {
        for run in sound().runs.iter().filter(|run| run.measured_poses.len() > 2 * STEPS_MIN) {
            let mut wrong = run.clone();
            let middle = wrong.measured_poses.len() / 2;
            wrong.measured_poses[middle].position_m =
                run.measured_poses[middle].position_m.map(|[x, y]| [x, y + 0.5]);
            let found = spike(&ROBOT, &wrong);
            let at_s = run.measured_poses[middle].t_s;
            assert!(
                found.is_some_and(|spike| spike.t_s == at_s && spike.off_m > 0.4),
                "{}: {found:?}",
                run.name
            );
        }
    }
}
