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
use crate::numeric::angle::wrap;
use crate::recording::run::PoseMeasurement;

use super::track::Track;

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
}

/// What turns the track by the wheels into the measured one: middles and direction.

#[derive(Clone, Copy, Debug, Default)]
struct Placed {
    measured_m: [f64; 2],
    wheels_m: [f64; 2],
    turned_rad: f64,
}

impl Placed {
    /// The residuals of a pose \[m\].
    fn residual(&self, measured: &PoseMeasurement, wheels: &Pose, lever_m: f64) -> [f64; 3] {
        let (sin, cos) = self.turned_rad.sin_cos();
        let [x, y] = measured.position_m.map_or([0.0; 2], |[x_m, y_m]| {
            let (qx, qy) = (wheels.x_m - self.wheels_m[0], wheels.y_m - self.wheels_m[1]);
            [
                x_m - self.measured_m[0] - cos * qx + sin * qy,
                y_m - self.measured_m[1] - sin * qx - cos * qy,
            ]
        });
        let heading = measured.heading_rad.map_or(0.0, |heading_rad| {
            let off_rad = wrap(heading_rad - wheels.heading_rad - self.turned_rad);
            2.0 * lever_m * (off_rad / 2.0).sin()
        });
        [x, y, heading]
    }
}

impl Fit {
    /// The poses of a track against where its wheels led, as if they had been measured `late_s` after their time;
    /// without outliers.
    pub(super) fn robust(track: &Track, reckoned: &[Pose], late_s: f64, lever_m: f64) -> Self {
        let all = vec![true; track.poses.len()];
        let whole = Self::of(track, reckoned, late_s, lever_m, &all);
        if track.poses.len() < POSES_MIN {
            return whole;
        }
        let size = |residual: &[f64; 3]| residual.iter().map(|value| value * value).sum::<f64>();
        let sizes: Vec<f64> = whole.residuals.iter().map(size).collect();
        let mut sorted = sizes.clone();
        sorted.sort_by(f64::total_cmp);
        let limit = OUTLIER_TIMES.powi(2) * sorted[sorted.len() / 2];
        let kept: Vec<bool> = sizes.iter().map(|size| *size <= limit).collect();
        let outliers = kept.iter().filter(|kept| !**kept).count();
        if outliers == 0 || outliers as f64 > OUTLIERS_MAX * kept.len() as f64 {
            return whole;
        }
        Self::of(track, reckoned, late_s, lever_m, &kept)
    }

    /// The same with these poses.
    pub(super) fn of(
        track: &Track,
        reckoned: &[Pose],
        late_s: f64,
        lever_m: f64,
        kept: &[bool],
    ) -> Self {
        let wheels: Vec<Pose> =
            track.poses.iter().map(|pose| track.at(reckoned, pose.t_s - late_s)).collect();
        let both = || track.poses.iter().zip(&wheels).zip(kept).filter(|(_, kept)| **kept);
        let mut placed = Placed::default();
        let mut positions = 0.0_f64;
        for ((measured, wheels), _) in both() {
            let Some([x_m, y_m]) = measured.position_m else { continue };
            positions += 1.0;
            placed.measured_m = [placed.measured_m[0] + x_m, placed.measured_m[1] + y_m];
            placed.wheels_m = [placed.wheels_m[0] + wheels.x_m, placed.wheels_m[1] + wheels.y_m];
        }
        placed.measured_m = placed.measured_m.map(|sum| sum / positions.max(1.0));
        placed.wheels_m = placed.wheels_m.map(|sum| sum / positions.max(1.0));
        let (mut along, mut facing) = ([0.0; 2], [0.0; 2]);
        let mut by_wheels_m2 = 0.0;
        for ((measured, wheels), _) in both() {
            if let Some([x_m, y_m]) = measured.position_m {
                let (px, py) = (x_m - placed.measured_m[0], y_m - placed.measured_m[1]);
                let (qx, qy) = (wheels.x_m - placed.wheels_m[0], wheels.y_m - placed.wheels_m[1]);
                along = [along[0] + px * qx + py * qy, along[1] + py * qx - px * qy];
                by_wheels_m2 += qx * qx + qy * qy;
            }
            if let Some(heading_rad) = measured.heading_rad {
                let (sin, cos) = (heading_rad - wheels.heading_rad).sin_cos();
                facing = [facing[0] + cos, facing[1] + sin];
            }
        }
        let lever_m2 = lever_m * lever_m;
        placed.turned_rad =
            (along[1] + lever_m2 * facing[1]).atan2(along[0] + lever_m2 * facing[0]);
        let angle = |[re, im]: [f64; 2]| (re != 0.0 || im != 0.0).then(|| im.atan2(re));
        let residual = |((measured, wheels), kept): ((&PoseMeasurement, &Pose), &bool)| {
            if *kept { placed.residual(measured, wheels, lever_m) } else { [0.0; 3] }
        };
        let residuals: Vec<[f64; 3]> =
            track.poses.iter().zip(&wheels).zip(kept).map(residual).collect();
        let sum: f64 = residuals.iter().flatten().map(|value| value * value).sum();
        let count = kept.iter().filter(|kept| **kept).count().max(1);
        Self {
            error_m: (sum / count as f64).sqrt(),
            residuals,
            kept: kept.to_vec(),
            turned: angle(facing).zip(angle(along)).map(|(facing, along)| wrap(facing - along)),
            by_wheels_m2,
            along_m2: along[0].hypot(along[1]),
            direction_rad: placed.turned_rad,
        }
    }
}

/// How late the poses are, so that they agree best with the wheels \[s\].
pub(super) fn lateness(track: &Track, reckoned: &[Pose], lever_m: f64) -> f64 {
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
