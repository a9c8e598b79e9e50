//! Brings the clocks of wheels and poses together, however far apart they are: by how fast the robot moved and turned.
//!
//! Neither depends on the tracker's axes, nor on where a marker sits. With w the wheels' numbers and z the poses', both on
//! one grid, a the best factors (nobody need know a radius), and the sum over the overlap:
//!
//! ```text
//! misfit(lag) = sum (z - a w(t - lag))^2 / sum z^2                (1)
//! ```
//!
//! A lag at which less of the poses' motion has wheels beside it has to fit better for that: of drives that repeat themselves, the
//! lag is right that brings all of them together. A jump of a tracker and a counter that restarts are faster than the robot ever
//! was for longer, and do not count. Where the wheels only go, or only turn, the rest of the poses' motion is noise, and does not
//! count either. If one wheel counts backwards, going looks like turning to the wheels: that is tried as well.
//!
//! The lag is found on a grid that is coarse enough for the whole of both logs, and then on finer ones. What is left, half
//! a step of the grid, is found by `robot_model::clocks` run by run.

use crate::plane::FlatPose;

/// Half of the window of a speed, at least \[s\].
const HALF_WINDOW_S: f64 = 0.2;
/// Steps of the grid in half a window.
const STEPS: f64 = 4.0;
/// The coarsest grid has at most so many places: every lag is tried on it.
const COARSE_MAX: usize = 3000;
/// So many lags of the coarsest grid are followed.
const FOLLOWED: usize = 6;
/// A lag has to leave at most this misfit: a robot that is carried from run to run moves without its wheels.
const MISFIT_MAX: f64 = 0.5;
/// The same with what the motion costs that has no wheels beside it: parts of two drives may look alike.
const COST_MAX: f64 = 0.4;
/// Others, further away, have to leave more by this factor; by the second one if the lag leaves so much itself: the motions of
/// another drive may resemble these.
const RIVAL_FACTOR: f64 = 1.2;
const RIVAL_FACTOR_OF_POOR: f64 = 1.3;
const POOR_MISFIT: f64 = 0.25;
/// Lags nearer than this are no others \[s\].
const NEIGHBOUR_S: f64 = 2.0;
/// A lag has to bring together so much of the motion that the poses show.
const OVERLAP_MIN: f64 = 0.3;
/// What motion of the poses without wheels beside it costs, as a misfit of all of it would cost 1.
const ALONE_COSTS: f64 = 0.3;
/// Wheels of which one is reversed have to fit better by this factor.
const REVERSED_FACTOR: f64 = 0.5;
/// Wheels hardly go, or hardly turn, if that is so small a share of what they do; in squares.
const HARDLY: f64 = 0.003;
/// A robot that turns on the spot moves no further than its track width, whatever its marker does; and one that goes straight turns
/// less than one whose wheels roll round each other \[m\].
const METRES_A_RADIAN: (f64, f64) = (0.02, 1.0);
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

/// How both clocks go together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Time of the poses less that of the wheels \[s\].
    pub late_s: f64,
    /// What is left of the motion; equation (1).
    pub misfit: f64,
    /// Metres that the robot goes for a radian of both wheels, where wheels are in radians: the radius. `None` if it only turned.
    pub travel_per_unit: Option<f64>,
    /// Radians that it turns for a radian of difference. `None` if it only went straight.
    pub turn_per_unit: Option<f64>,
    /// One of the wheels counts backwards.
    pub one_reversed: bool,
}

/// Why no lag was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlignError {
    /// One of them hardly moved.
    NoMotion {
        /// The wheels, else the poses.
        of_wheels: bool,
    },
    /// At no lag do both move alike.
    NothingInCommon {
        /// The least that is left.
        misfit: f64,
    },
    /// Several lags fit about as well.
    Ambiguous {
        /// Two of them \[s\].
        lags_s: [f64; 2],
    },
}

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
    let spacing = |times: &mut dyn Iterator<Item = f64>| {
        let times: Vec<f64> = times.collect();
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied()
    };
    let wheels_s = spacing(&mut t_s.iter().copied())?;
    let poses_s = spacing(&mut poses.iter().map(|pose| pose.t_s))?;
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
    fn coarser(&self, by: usize) -> Self {
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

/// What equation (1) needs at one lag.
#[derive(Clone, Copy, Debug, Default)]
struct Products {
    /// z w, w^2 and z^2, of travel and turn.
    both: [f64; 2],
    wheels: [f64; 2],
    poses: [f64; 2],
}

impl Products {
    /// At a shift: place k of the wheels is place k + shift of the poses.
    fn at(wheels: &Speeds, poses: &Speeds, shift: i64) -> Self {
        let mut products = Self::default();
        let first = usize::try_from(shift).unwrap_or(0).min(poses.values.len());
        let beside = usize::try_from(-shift).unwrap_or(0).min(wheels.values.len());
        for (z, w) in poses.values[first..].iter().zip(&wheels.values[beside..]) {
            for axis in 0..2 {
                if !z[axis].is_nan() && !w[axis].is_nan() {
                    let (z, w) = (f64::from(z[axis]), f64::from(w[axis]));
                    products.both[axis] += z * w;
                    products.wheels[axis] += w * w;
                    products.poses[axis] += z * z;
                }
            }
        }
        products
    }

    /// Equation (1), travel and turn weighed alike, as far as the wheels show them; `None` if too little of the poses' motion
    /// overlaps.
    fn fit(&self, energies: &[f64; 2], shown: [bool; 2]) -> Option<Fit> {
        let (mut left, mut alone, mut axes) = (0.0, 0.0, 0.0);
        for (axis, energy) in energies.iter().enumerate() {
            // Headings that were not measured, or a robot that never turned.
            if *energy <= 0.0 || !shown[axis] {
                continue;
            }
            if self.poses[axis] < OVERLAP_MIN * energy {
                return None;
            }
            let explained = self.both[axis].powi(2) / self.wheels[axis].max(f64::MIN_POSITIVE);
            left += (self.poses[axis] - explained) / self.poses[axis];
            alone += 1.0 - self.poses[axis] / energy;
            axes += 1.0;
        }
        let fit = || Fit { misfit: left / axes, cost: (left + ALONE_COSTS * alone) / axes };
        (axes > 0.0).then(fit)
    }
}

/// How well a lag fits.
#[derive(Clone, Copy, Debug)]
struct Fit {
    /// Equation (1).
    misfit: f64,
    /// The same, and what the motion costs that has no wheels beside it.
    cost: f64,
}

fn energies(speeds: &Speeds) -> [f64; 2] {
    [0, 1].map(|axis| {
        let known = speeds
            .values
            .iter()
            .map(|value| f64::from(value[axis]))
            .filter(|value| !value.is_nan());
        known.map(|value| value * value).sum()
    })
}

/// Whether travel and turn are shown: of a robot that only goes straight, or only spins, the other is noise. Wheels are compared at
/// their rims, which turn with half of the difference. Poses that go metres a radian, or turn radians in centimetres, do move:
/// these wheels count something else.
fn shown(wheels: &Speeds, poses: &Speeds) -> [bool; 2] {
    let [travel, turn] = energies(wheels);
    let rims = [travel, turn / 4.0];
    let [went, turned] = energies(poses);
    let moves =
        [went > METRES_A_RADIAN.1.powi(2) * turned, went < METRES_A_RADIAN.0.powi(2) * turned];
    [0, 1].map(|axis| moves[axis] || rims[axis] > HARDLY * rims[1 - axis])
}

/// Finds how late the poses are.
pub fn align([wheels, poses]: &[Speeds; 2]) -> Result<Alignment, AlignError> {
    let moves = |speeds: &Speeds| energies(speeds).iter().any(|energy| *energy > 0.0);
    if !moves(wheels) || !moves(poses) {
        return Err(AlignError::NoMotion { of_wheels: !moves(wheels) });
    }
    let reversed = wheels.one_reversed();
    let (as_is, other) = (lags(wheels, poses), lags(&reversed, poses));
    let cost = |lags: &[(i64, Fit)]| lags.first().map_or(f64::INFINITY, |(_, fit)| fit.cost);
    let one_reversed = cost(&other) < REVERSED_FACTOR * cost(&as_is);
    let (wheels, best) = if one_reversed { (&reversed, other) } else { (wheels, as_is) };
    let Some(&(shift, Fit { misfit, cost })) = best.first() else {
        return Err(AlignError::NothingInCommon { misfit: 1.0 });
    };
    let late_s = |shift: i64| poses.start_s - wheels.start_s + shift as f64 * wheels.step_s;
    if misfit > MISFIT_MAX || cost > COST_MAX {
        return Err(AlignError::NothingInCommon { misfit });
    }
    let factor = if misfit > POOR_MISFIT { RIVAL_FACTOR_OF_POOR } else { RIVAL_FACTOR };
    let is_rival = |(other, fit): &&(i64, Fit)| {
        (other - shift).abs() as f64 * wheels.step_s > NEIGHBOUR_S
            && fit.misfit < factor * misfit
            && fit.cost < factor * cost
    };
    if let Some(rival) = best.iter().find(is_rival) {
        return Err(AlignError::Ambiguous { lags_s: [late_s(shift), late_s(rival.0)] });
    }
    let products = Products::at(wheels, poses, shift);
    let shown = shown(wheels, poses);
    let factor = |axis: usize| {
        let is_known = shown[axis] && products.wheels[axis] > 0.0;
        is_known.then(|| products.both[axis] / products.wheels[axis])
    };
    Ok(Alignment {
        late_s: late_s(shift),
        misfit,
        travel_per_unit: factor(0),
        turn_per_unit: factor(1).filter(|_| products.poses[1] > 0.0),
        one_reversed,
    })
}

/// The best lags, the best first, in steps of the grid.
fn lags(wheels: &Speeds, poses: &Speeds) -> Vec<(i64, Fit)> {
    let longest = wheels.values.len().max(poses.values.len());
    let mut by = longest.div_ceil(COARSE_MAX).next_power_of_two();
    let (mut w, mut z) = (wheels.coarser(by), poses.coarser(by));
    let all = -(w.values.len() as i64)..=z.values.len() as i64;
    let mut best = followed(&w, &z, all);
    while by > 1 {
        by /= 2;
        (w, z) = (wheels.coarser(by), poses.coarser(by));
        let near = best.iter().flat_map(|(shift, _)| 2 * shift - 2..=2 * shift + 2);
        let mut near: Vec<i64> = near.collect();
        near.sort_unstable();
        near.dedup();
        best = followed(&w, &z, near.into_iter());
    }
    best
}

/// The best shifts, the best first, each a valley of its own.
fn followed(wheels: &Speeds, poses: &Speeds, shifts: impl Iterator<Item = i64>) -> Vec<(i64, Fit)> {
    let (energies, shown) = (energies(poses), shown(wheels, poses));
    let mut fits: Vec<(i64, Fit)> = shifts
        .filter_map(|shift| {
            Some((shift, Products::at(wheels, poses, shift).fit(&energies, shown)?))
        })
        .collect();
    fits.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let mut best: Vec<(i64, Fit)> = Vec::new();
    for (shift, fit) in fits {
        if best.len() == FOLLOWED {
            break;
        }
        if best.iter().all(|(other, _)| (other - shift).abs() > 3) {
            best.push((shift, fit));
        }
    }
    best
}
