//! Where does a model predict that the robot went? Open loop: from the start on, without the measured poses.

use crate::effect::composition::{Composer, Term, Terms};
use crate::estimation::blocks::block_of;
use crate::estimation::transition::{TIME_ROUNDING_S, Transition, within};
use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::motion::Motion;
use crate::recording::run::PoseMeasurement;

/// A predicted track beside the measured one, at the times of the measurements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PredictedTrack {
    /// What was measured.
    pub measured: Vec<PoseMeasurement>,
    /// What the model predicts for those times, from a start at the origin.
    pub predicted: Vec<Pose>,
    /// For each measurement, the index of its step.
    pub step: Vec<usize>,
}

/// Position and heading error of one measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseError {
    /// Measured less predicted, along the predicted heading and to the left of it \[m\].
    pub position_m: Option<[f64; 2]>,
    /// Measured less predicted \[rad\].
    pub heading_rad: Option<f64>,
    /// Index of the step of the measurement.
    pub step: usize,
}

/// The track that these terms predict, from the origin.
pub(crate) fn open_loop(
    motion: &Motion,
    measurements: &[PoseMeasurement],
    terms: Terms<'_, '_>,
) -> PredictedTrack {
    let from = Pose::ORIGIN;
    open_loop_from(from, motion, measurements, terms)
}

/// The same from the first measured place and heading, or where there is none from the start that brings the track nearest
/// to the measured one: effects of the world depend on both.
pub(crate) fn open_loop_as_seen(
    motion: &Motion,
    measurements: &[PoseMeasurement],
    terms: &[Term<'_>],
) -> PredictedTrack {
    let terms = Terms::Fixed(terms);
    let first = within(motion, measurements).next();
    let start = match first.and_then(|first| Some((first.position_m, first.heading_rad?))) {
        Some((place_m, heading_rad)) => {
            let [x_m, y_m] = place_m.unwrap_or_default();
            Pose::new(x_m, y_m, heading_rad)
        }
        None => {
            let track = open_loop(motion, measurements, terms);
            // Either unit serves to find a heading.
            track.best_start(1.0, 1.0).unwrap_or(Pose::ORIGIN)
        }
    };
    open_loop_from(start, motion, measurements, terms)
}

/// The same from a known start, which matters where effects depend on the place in the world.
pub(crate) fn open_loop_from(
    start: Pose,
    motion: &Motion,
    measurements: &[PoseMeasurement],
    terms: Terms<'_, '_>,
) -> PredictedTrack {
    let mut composer = Composer::without_derivatives(terms);
    let (view, _) = composer.view();
    let [ahead_m, left_m] = view.offset_m.map(|jet| jet.value);
    let delay_s = view.delay_s.value;
    let drifted_rad = |t_s: f64| view.heading_drift_rad_s.value * (t_s - motion.start_s);
    let mut track = PredictedTrack::default();
    let mut pose = start;
    let mut begin_s = motion.start_s;
    let mut measurements = within(motion, measurements).peekable();
    let last = motion.steps.len().saturating_sub(1);
    for (k, nominal) in motion.steps.iter().enumerate() {
        let end_s = begin_s + nominal.dt_s;
        let mut step = *nominal;
        step.heading_rad = pose.heading_rad + nominal.turn_rad() / 2.0;
        step.place_m = [pose.x_m, pose.y_m];
        let increment = composer.step(&step);
        // Sums of steps are rounded; a pose measured a moment before or after them was measured at rest.
        while let Some(measurement) =
            measurements.next_if(|pose| k == last || pose.t_s - delay_s <= end_s + TIME_ROUNDING_S)
        {
            let seen_s = (measurement.t_s - delay_s).clamp(begin_s, end_s);
            let there = Transition::new(pose, &increment, (seen_s - begin_s) / nominal.dt_s).pose;
            track.measured.push(*measurement);
            let seen = Pose::new(ahead_m, left_m, drifted_rad(measurement.t_s));
            track.predicted.push(there.compose(seen));
            track.step.push(k);
        }
        pose = Transition::new(pose, &increment, 1.0).pose;
        begin_s = end_s;
    }
    track
}

impl PredictedTrack {
    /// A track that moves from measurement to measurement as one of these does, which are of the same measurements: as
    /// that of the block of its step, in a run that is cut into as many blocks of equal length.
    pub(crate) fn block_by_block(blocks: &[Self], steps: usize) -> Self {
        let Some((first, _)) = blocks.split_first() else { return Self::default() };
        let mut track = first.clone();
        for index in 1..track.predicted.len() {
            let block = &blocks[block_of(first.step[index], steps, blocks.len())];
            let moved = block.predicted[index].seen_from(block.predicted[index - 1]);
            track.predicted[index] = track.predicted[index - 1].compose(moved);
        }
        track
    }

    /// The start that brings the predicted positions nearest to the measured ones.
    ///
    /// `None` with fewer than two positions, or where all are in one place.
    pub fn start_from_positions(&self) -> Option<Pose> {
        let pairs: Vec<([f64; 2], [f64; 2])> = self
            .measured
            .iter()
            .zip(&self.predicted)
            .filter_map(|(measurement, pose)| Some((measurement.position_m?, [pose.x_m, pose.y_m])))
            .collect();
        if pairs.len() < 2 {
            return None;
        }
        let n = pairs.len() as f64;
        let mean = pairs.iter().fold([0.0; 4], |m, (a, b)| {
            [m[0] + a[0] / n, m[1] + a[1] / n, m[2] + b[0] / n, m[3] + b[1] / n]
        });
        let (mut dot, mut cross) = (0.0, 0.0);
        for (a, b) in &pairs {
            let (ax, ay, bx, by) = (a[0] - mean[0], a[1] - mean[1], b[0] - mean[2], b[1] - mean[3]);
            dot += ax * bx + ay * by;
            cross += bx * ay - by * ax;
        }
        // A square millimetre: less than that is noise, and has no direction.
        if dot.hypot(cross) < 1e-6 {
            return None;
        }
        let heading_rad = cross.atan2(dot);
        let moved = Pose::new(0.0, 0.0, heading_rad).compose(Pose::new(mean[2], mean[3], 0.0));
        Some(Pose::new(mean[0] - moved.x_m, mean[1] - moved.y_m, heading_rad))
    }

    /// The start's heading by the first measured heading.
    pub(crate) fn start_heading_from_headings(&self) -> Option<f64> {
        let mut pairs = self.measured.iter().zip(&self.predicted);
        pairs
            .find_map(|(measurement, pose)| Some(wrap(measurement.heading_rad? - pose.heading_rad)))
    }

    /// Root mean square distance of the predicted positions from their mean \[m\].
    pub(crate) fn spread_m(&self) -> f64 {
        let places = self.measured.iter().zip(&self.predicted);
        let places: Vec<[f64; 2]> = places
            .filter(|(measurement, _)| measurement.position_m.is_some())
            .map(|(_, pose)| [pose.x_m, pose.y_m])
            .collect();
        let n = places.len().max(1) as f64;
        let mean = [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / n);
        let square = |place: &[f64; 2]| (place[0] - mean[0]).powi(2) + (place[1] - mean[1]).powi(2);
        (places.iter().map(square).sum::<f64>() / n).sqrt()
    }

    /// The start with the least residual; `None` if too little was measured.
    ///
    /// Positions and headings are weighted by the given scales. Three Gauss-Newton steps from the
    /// first measured pose are exact to far below either scale.
    pub fn best_start(&self, position_scale_m: f64, heading_scale_rad: f64) -> Option<Pose> {
        let mut start = self.first_guess()?;
        let weights = [position_scale_m.powi(-2), heading_scale_rad.powi(-2)];
        for _ in 0..3 {
            start = self.better_start(start, weights);
        }
        Some(start)
    }

    /// Measured less predicted at every measurement, from the start with the least residual.
    pub fn errors(&self, position_scale_m: f64, heading_scale_rad: f64) -> Vec<PoseError> {
        let Some(start) = self.best_start(position_scale_m, heading_scale_rad) else {
            return Vec::new();
        };
        self.measured
            .iter()
            .zip(&self.predicted)
            .zip(&self.step)
            .map(|((measurement, local), step)| {
                let pose = start.compose(*local);
                PoseError {
                    position_m: measurement.position_m.map(|[x_m, y_m]| {
                        let seen = Pose::new(x_m, y_m, 0.0).seen_from(pose);
                        [seen.x_m, seen.y_m]
                    }),
                    heading_rad: measurement
                        .heading_rad
                        .map(|measured_rad| wrap(measured_rad - pose.heading_rad)),
                    step: *step,
                }
            })
            .collect()
    }

    fn first_guess(&self) -> Option<Pose> {
        let whole = self.measured.iter().zip(&self.predicted).find_map(|(measurement, pose)| {
            let [x_m, y_m] = measurement.position_m?;
            let heading_rad = measurement.heading_rad? - pose.heading_rad;
            let moved =
                Pose::new(0.0, 0.0, heading_rad).compose(Pose::new(pose.x_m, pose.y_m, 0.0));
            Some(Pose::new(x_m - moved.x_m, y_m - moved.y_m, heading_rad))
        });
        whole.or_else(|| self.start_from_both()).or_else(|| self.start_from_positions())
    }

    /// The start by the first place and the first heading that were measured, each at its own time.
    fn start_from_both(&self) -> Option<Pose> {
        let heading_rad = self.start_heading_from_headings()?;
        let mut pairs = self.measured.iter().zip(&self.predicted);
        pairs.find_map(|(measurement, pose)| {
            let [x_m, y_m] = measurement.position_m?;
            let moved =
                Pose::new(0.0, 0.0, heading_rad).compose(Pose::new(pose.x_m, pose.y_m, 0.0));
            Some(Pose::new(x_m - moved.x_m, y_m - moved.y_m, heading_rad))
        })
    }

    fn better_start(&self, start: Pose, [position, heading]: [f64; 2]) -> Pose {
        let mut normal = nalgebra::Matrix3::<f64>::zeros();
        let mut right = nalgebra::Vector3::<f64>::zeros();
        let mut add = |row: [f64; 3], residual: f64, weight: f64| {
            let row = nalgebra::Vector3::from(row);
            normal += weight * row * row.transpose();
            right += weight * residual * row;
        };
        for (measurement, local) in self.measured.iter().zip(&self.predicted) {
            let pose = start.compose(*local);
            if let Some([x_m, y_m]) = measurement.position_m {
                add([1.0, 0.0, -(pose.y_m - start.y_m)], x_m - pose.x_m, position);
                add([0.0, 1.0, pose.x_m - start.x_m], y_m - pose.y_m, position);
            }
            if let Some(measured) = measurement.heading_rad {
                add([0.0, 0.0, 1.0], wrap(measured - pose.heading_rad), heading);
            }
        }
        match normal.cholesky() {
            Some(factor) => {
                let step = factor.solve(&right);
                Pose::new(start.x_m + step[0], start.y_m + step[1], start.heading_rad + step[2])
            }
            None => start,
        }
    }
}
