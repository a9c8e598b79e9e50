//! How fast wheels and poses go and turn, on one grid.

use crate::log::usual_step_s;
use crate::plane::FlatPose;

/// Half of the window of a speed, at least \[s\].
const HALF_WINDOW_S: f64 = 0.2;
/// Steps of the grid in half a window.
const STEPS: f64 = 4.0;
/// A jump is seen for a window; places in which a median does not see it, and how many of them must be known.
const MEDIAN_HALF: usize = 10;
const MEDIAN_STRIDE: usize = 5;
/// What is faster by this than the fastest of these medians is a jump.
const JUMP_TIMES: f32 = 2.0;
/// A gap between two samples in which nothing is known of the motion \[s\].
const GAP_S: f64 = 1.0;
/// So many places on a grid at most: 50 hours at 20 Hz; and so many for each sample, and for a log of few, as a wrong stamp makes
/// a log of years.
const GRID_MAX: f64 = 4e6;
const GRID_PER_SAMPLE: f64 = 64.0;
const GRID_OF_FEW: f64 = 1e5;

/// How fast something went and turned, on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Speeds {
    /// Time of the first \[s\].
    pub start_s: f64,
    /// Between two \[s\].
    pub step_s: f64,
    /// Travel and turn per second, without a sign; `NAN` where nothing is known.
    pub values: Vec<[f32; 2]>,
}

/// Speeds of both on one grid.
pub fn speeds(t_s: &[f64], turned: &[[f64; 2]], poses: &[FlatPose]) -> Option<[Speeds; 2]> {
    let wheels_s = usual_step_s(t_s.iter().copied())?;
    let poses_s = usual_step_s(poses.iter().map(|pose| pose.t_s))?;
    let half_s = HALF_WINDOW_S.max(1.5 * wheels_s).max(1.5 * poses_s);
    let span_s = |first: f64, last: f64| last - first;
    let longest_s =
        span_s(t_s[0], t_s[t_s.len() - 1]).max(span_s(poses[0].t_s, poses[poses.len() - 1].t_s));
    let samples = (t_s.len() + poses.len()) as f64;
    let places_max = GRID_MAX.min(GRID_OF_FEW + GRID_PER_SAMPLE * samples);
    let step_s = (half_s / STEPS).max(longest_s / places_max);
    let wheels = sampled(
        t_s,
        step_s,
        half_s,
        |a, b, share| {
            [0, 1].map(|side| turned[a][side] + share * (turned[b][side] - turned[a][side]))
        },
        |from, to| {
            let (left, right) = (to[0] - from[0], to[1] - from[1]);
            [(left + right) / 2.0, right - left]
        },
    );
    let times: Vec<f64> = poses.iter().map(|pose| pose.t_s).collect();
    let poses = sampled(
        &times,
        step_s,
        half_s,
        |a, b, share| {
            let mix = |a: f64, b: f64| a + share * (b - a);
            let (a, b) = (&poses[a], &poses[b]);
            let heading = a.heading_rad.zip(b.heading_rad).map_or(f64::NAN, |(a, b)| mix(a, b));
            [mix(a.position_m[0], b.position_m[0]), mix(a.position_m[1], b.position_m[1]), heading]
        },
        |from, to| [(to[0] - from[0]).hypot(to[1] - from[1]), to[2] - from[2]],
    );
    Some([wheels, poses])
}

/// Differences over a window, per second, on a grid over all times.
fn sampled<const N: usize>(
    times: &[f64],
    step_s: f64,
    half_s: f64,
    at: impl Fn(usize, usize, f64) -> [f64; N],
    moved: impl Fn([f64; N], [f64; N]) -> [f64; 2],
) -> Speeds {
    let (start_s, end_s) = (times[0], times[times.len() - 1]);
    let count = ((end_s - start_s) / step_s) as usize + 1;
    let interpolated = |after: &mut usize, t_s: f64| -> Option<[f64; N]> {
        while *after < times.len() - 1 && times[*after] <= t_s {
            *after += 1;
        }
        let before = *after - 1;
        let gap_s = times[*after] - times[before];
        let share = ((t_s - times[before]) / gap_s).clamp(0.0, 1.0);
        // Within a gap nothing is known.
        (gap_s < GAP_S.max(2.0 * half_s)).then(|| at(before, *after, share))
    };
    let (mut first, mut last) = (1, 1);
    let values = (0..count)
        .map(|k| {
            let t_s = start_s + k as f64 * step_s;
            let from = interpolated(&mut first, t_s - half_s);
            let to = interpolated(&mut last, t_s + half_s);
            let moved = from.zip(to).map(|(from, to)| moved(from, to));
            moved.map_or([f32::NAN; 2], |moved| {
                moved.map(|moved| (moved.abs() / (2.0 * half_s)) as f32)
            })
        })
        .collect();
    let mut speeds = Speeds { start_s, step_s, values };
    (0..2).for_each(|axis| speeds.forget_jumps(axis));
    speeds
}

impl Speeds {
    /// Of wheels: what they are if one of them counts backwards.
    pub fn one_reversed(&self) -> Self {
        let values = self.values.iter().map(|[travel, turn]| [turn / 2.0, 2.0 * travel]);
        Self { values: values.collect(), ..*self }
    }

    /// Takes out what is far faster than the robot ever was for longer than a jump is seen.
    fn forget_jumps(&mut self, axis: usize) {
        let mut fastest = 0.0_f32;
        let mut known = Vec::with_capacity(2 * MEDIAN_HALF + 1);
        for window in self.values.windows(2 * MEDIAN_HALF + 1).step_by(MEDIAN_STRIDE) {
            known.clear();
            known.extend(window.iter().map(|value| value[axis]).filter(|value| !value.is_nan()));
            if known.len() > MEDIAN_HALF {
                let middle = known.len() / 2;
                fastest = fastest.max(*known.select_nth_unstable_by(middle, f32::total_cmp).1);
            }
        }
        if fastest > 0.0 {
            let jumps = self.values.iter_mut().filter(|value| value[axis] > JUMP_TIMES * fastest);
            jumps.for_each(|value| value[axis] = f32::NAN);
        }
    }

    /// Means of so many each: a coarser grid.
    pub(super) fn coarser(&self, by: usize) -> Self {
        let mean = |values: &[[f32; 2]]| {
            [0, 1].map(|axis| {
                let known = values.iter().map(|value| value[axis]).filter(|value| !value.is_nan());
                let (sum, count) =
                    known.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
                if count > 0.0 { sum / count } else { f32::NAN }
            })
        };
        let values = self.values.chunks(by).map(mean).collect();
        Self { start_s: self.start_s, step_s: self.step_s * by as f64, values }
    }
}
