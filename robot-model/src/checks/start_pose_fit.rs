//! How far is a run from where its wheels led, wherever it began and however late its poses are?
//!
//! The start pose is found in closed form. With `p` the measured positions and `q` those by the wheels, both from
//! their mean and as complex numbers, `h` and `theta` the headings and `l` the lever, the sum
//!
//! ```text
//! sum |p - e^(i r) q|^2 + l^2 sum |e^(i h) - e^(i (theta + r))|^2
//! ```
//!
//! is least for `r = arg(sum p q* + l^2 sum e^(i (h - theta)))`. No heading has to be unwrapped for that.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::{Direction, wrap};
use crate::recording::run::PoseMeasurement;

use super::thinned_run::ThinnedRun;

/// A pose this many times as far off as the median one is an outlier, as long as there are few.
const OUTLIER_TIMES: f64 = 6.0;
const OUTLIERS_MAX: f64 = 0.15;
/// Fewer poses have no outliers.
const POSES_MIN: usize = 10;
/// Poses may be early or late by this \[s\]; tried at these steps, then halved so often.
const LATE_S: f64 = 1.25;
const TRIED: i32 = 5;
const HALVINGS: usize = 5;

/// A run beside where its wheels led.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// Of each pose: along x, along y \[m\], and of the heading, times the lever; zero if not measured or left out.
    pub(super) residuals: Vec<[f64; 3]>,
    /// The poses that count.
    pub(super) kept: Vec<bool>,
    /// The distance of the poses that count (rms) \[m\].
    pub(super) error_m: f64,
    /// By how much the measured headings are turned against the direction of travel, if both are known \[rad\].
    pub(super) turned: Option<f64>,
    /// How far the middle of the path is from its points by the wheels: the sum of squares \[m^2\].
    pub(super) by_wheels_m2: f64,
    /// The sum of products of positions measured and by the wheels, turned for the best \[m^2\].
    pub(super) along_m2: f64,
    /// The direction at which the wheels began, as measured \[rad\].
    pub(super) direction_rad: f64,
    each: Vec<Beside>,
}

/// A measured pose beside where the wheels led.
#[derive(Clone, Debug)]
struct Beside {
    measured_m: Option<[f64; 2]>,
    wheels_m: [f64; 2],
    /// The measured heading, against that of the wheels.
    off: Option<Direction>,
}

impl Beside {
    fn of(measured: &PoseMeasurement, wheels: &Pose) -> Self {
        let off = |heading_rad| Direction::of(heading_rad - wheels.heading_rad);
        Self {
            measured_m: measured.position_m,
            wheels_m: [wheels.x_m, wheels.y_m],
            off: measured.heading_rad.map(off),
        }
    }

    /// The residuals, with the track by the wheels turned and its middle on the measured one's \[m\].
    fn residual(&self, middles_m: &Middles, turned: Direction, lever_m: f64) -> [f64; 3] {
        let Direction { sin, cos } = turned;
        let [x, y] = middles_m.from(self).map_or([0.0; 2], |([px, py], [qx, qy])| {
            [px - cos * qx + sin * qy, py - sin * qx - cos * qy]
        });
        let heading = self.off.map_or(0.0, |off| lever_m * off.turned_back(turned).chord());
        [x, y, heading]
    }
}

/// Each measured pose of a track beside where the wheels led, as if it had been measured `late_s` after its time.
fn beside(track: &ThinnedRun, reckoned: &[Pose], late_s: f64) -> Vec<Beside> {
    let one = |pose: &PoseMeasurement| Beside::of(pose, &track.at(reckoned, pose.t_s - late_s));
    track.poses.iter().map(one).collect()
}

/// The means of the measured positions and of those by the wheels.
struct Middles {
    measured_m: [f64; 2],
    wheels_m: [f64; 2],
}

impl Middles {
    fn of<'a>(each: impl Iterator<Item = &'a Beside>) -> Self {
        let (mut measured_m, mut wheels_m, mut count) = ([0.0; 2], [0.0; 2], 0.0_f64);
        for beside in each {
            let Some([x_m, y_m]) = beside.measured_m else { continue };
            count += 1.0;
            measured_m = [measured_m[0] + x_m, measured_m[1] + y_m];
            wheels_m = [wheels_m[0] + beside.wheels_m[0], wheels_m[1] + beside.wheels_m[1]];
        }
        let mean = |sum: [f64; 2]| sum.map(|sum| sum / count.max(1.0));
        Self { measured_m: mean(measured_m), wheels_m: mean(wheels_m) }
    }

    /// Both positions from here, if one was measured \[m\].
    fn from(&self, beside: &Beside) -> Option<([f64; 2], [f64; 2])> {
        let [x_m, y_m] = beside.measured_m?;
        let wheels_m = beside.wheels_m;
        Some((
            [x_m - self.measured_m[0], y_m - self.measured_m[1]],
            [wheels_m[0] - self.wheels_m[0], wheels_m[1] - self.wheels_m[1]],
        ))
    }
}

impl Fit {
    /// The poses of a track against where its wheels led, as if they had been measured `late_s` after their time;
    /// without outliers.
    pub(super) fn robust(track: &ThinnedRun, reckoned: &[Pose], late_s: f64, lever_m: f64) -> Self {
        Self::without_outliers(beside(track, reckoned, late_s), lever_m)
    }

    /// The same with these poses.
    pub(super) fn of(
        track: &ThinnedRun,
        reckoned: &[Pose],
        late_s: f64,
        lever_m: f64,
        kept: &[bool],
    ) -> Self {
        Self::with(beside(track, reckoned, late_s), lever_m, kept)
    }

    /// The same poses, had the wheels led so many times as far, in the same directions; without outliers.
    pub(super) fn times(&self, factor: f64, lever_m: f64) -> Self {
        Self::without_outliers(self.beside_times(factor), lever_m)
    }

    /// The same with the poses that count.
    pub(super) fn times_with_kept(&self, factor: f64, lever_m: f64) -> Self {
        Self::with(self.beside_times(factor), lever_m, &self.kept)
    }

    fn beside_times(&self, factor: f64) -> Vec<Beside> {
        let farther = |beside: &Beside| Beside {
            wheels_m: beside.wheels_m.map(|value| factor * value),
            ..beside.clone()
        };
        self.each.iter().map(farther).collect()
    }

    fn without_outliers(each: Vec<Beside>, lever_m: f64) -> Self {
        let all = vec![true; each.len()];
        let whole = Self::with(each, lever_m, &all);
        if all.len() < POSES_MIN {
            return whole;
        }
        let size = |residual: &[f64; 3]| residual.iter().map(|value| value * value).sum::<f64>();
        let sizes: Vec<f64> = whole.residuals.iter().map(size).collect();
        let mut ordered = sizes.clone();
        let (_, median, _) = ordered.select_nth_unstable_by(sizes.len() / 2, f64::total_cmp);
        let limit = OUTLIER_TIMES.powi(2) * *median;
        let kept: Vec<bool> = sizes.iter().map(|size| *size <= limit).collect();
        let outliers = kept.iter().filter(|kept| !**kept).count();
        if outliers == 0 || outliers as f64 > OUTLIERS_MAX * kept.len() as f64 {
            return whole;
        }
        Self::with(whole.each, lever_m, &kept)
    }

    fn with(each: Vec<Beside>, lever_m: f64, kept: &[bool]) -> Self {
        let that_count =
            || each.iter().zip(kept).filter(|(_, kept)| **kept).map(|(beside, _)| beside);
        let middles = Middles::of(that_count());
        let (mut along, mut facing) = ([0.0; 2], [0.0; 2]);
        let mut by_wheels_m2 = 0.0;
        for beside in that_count() {
            if let Some(([px, py], [qx, qy])) = middles.from(beside) {
                along = [along[0] + px * qx + py * qy, along[1] + py * qx - px * qy];
                by_wheels_m2 += qx * qx + qy * qy;
            }
            if let Some(Direction { sin, cos }) = beside.off {
                facing = [facing[0] + cos, facing[1] + sin];
            }
        }
        let lever_m2 = lever_m * lever_m;
        let turned_rad = (along[1] + lever_m2 * facing[1]).atan2(along[0] + lever_m2 * facing[0]);
        let angle = |[re, im]: [f64; 2]| (re != 0.0 || im != 0.0).then(|| im.atan2(re));
        let turned = Direction::of(turned_rad);
        let residual = |(beside, kept): (&Beside, &bool)| {
            if *kept { beside.residual(&middles, turned, lever_m) } else { [0.0; 3] }
        };
        let residuals: Vec<[f64; 3]> = each.iter().zip(kept).map(residual).collect();
        let sum: f64 = residuals.iter().flatten().map(|value| value * value).sum();
        let count = kept.iter().filter(|kept| **kept).count().max(1);
        Self {
            error_m: (sum / count as f64).sqrt(),
            residuals,
            kept: kept.to_vec(),
            turned: angle(facing).zip(angle(along)).map(|(facing, along)| wrap(facing - along)),
            by_wheels_m2,
            along_m2: along[0].hypot(along[1]),
            direction_rad: turned_rad,
            each,
        }
    }
}

/// How late the poses are, so that they agree best with the wheels \[s\].
pub(super) fn lateness(track: &ThinnedRun, reckoned: &[Pose], lever_m: f64) -> f64 {
    // With all poses: those of a ramp are what shows it, and would pass for outliers.
    let all = vec![true; track.poses.len()];
    let error = |late_s: f64| Fit::of(track, reckoned, late_s, lever_m, &all).error_m;
    let mut best = (0.0, error(0.0));
    let mut step_s = LATE_S / f64::from(TRIED);
    for k in (-TRIED..=TRIED).filter(|k| *k != 0) {
        let late_s = f64::from(k) * step_s;
        let there = error(late_s);
        if there < best.1 {
            best = (late_s, there);
        }
    }
    for _ in 0..HALVINGS {
        step_s /= 2.0;
        for late_s in [best.0 - step_s, best.0 + step_s] {
            let there = error(late_s);
            if there < best.1 {
                best = (late_s, there);
            }
        }
    }
    best.0
}
