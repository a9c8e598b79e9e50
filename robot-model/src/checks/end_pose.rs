//! How far is the last pose of a run from where the wheels led from the first one?

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::run::PoseMeasurement;

use super::thinned_run::ThinnedRun;

/// The last pose of a run that lies far from where the wheels led.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffEndPose {
    /// When it was measured \[s\].
    pub t_s: f64,
    /// The error of its position, if that is off \[m\].
    pub position_m: Option<f64>,
    /// The error of its heading, if that is off, counter-clockwise positive \[rad\].
    pub heading_rad: Option<f64>,
}

/// How far a last pose may lie from where the wheels led: this, plus this share of the path or of the turn.
#[derive(Clone, Copy)]
pub(super) struct Allowed {
    position_m: (f64, f64),
    heading_rad: (f64, f64),
}

/// By a geometry that is fitted to all runs.
pub(super) const FAR_OFF: Allowed = Allowed { position_m: (0.15, 0.15), heading_rad: (0.5, 0.06) };
/// By the data sheet, for a reading that a person can repeat at once: one question too many does no harm.
const FOR_A_QUESTION: Allowed = Allowed { position_m: (0.1, 0.05), heading_rad: (0.3, 0.08) };

/// Whether a pose that a person has just read, `last`, lies far from where the wheels led from `first`, and
/// should be read again. `wheels` are the poses by the wheels, in any frame.
pub fn implausible_end_pose(
    first: &PoseMeasurement,
    last: &PoseMeasurement,
    wheels: &[Pose],
) -> Option<OffEndPose> {
    End::between(first, last, wheels)?.off(FOR_A_QUESTION)
}

/// Where a run ended: as measured, and by its wheels.
pub(super) struct End<'a> {
    first: &'a PoseMeasurement,
    pub(super) last: &'a PoseMeasurement,
    /// By the wheels, in the frame of the first pose; its heading counts whole turns.
    to: Pose,
    /// Path by the wheels, without a sign \[m\].
    pub(super) path_m: f64,
    /// Turn by the wheels, without a sign \[rad\].
    pub(super) turn_rad: f64,
}

impl<'a> End<'a> {
    /// From the first position of a track to its last pose.
    pub(super) fn of(track: &'a ThinnedRun, reckoned: &[Pose]) -> Option<Self> {
        let first = track.poses.iter().find(|pose| pose.position_m.is_some())?;
        let last = track.poses.last().filter(|pose| pose.t_s > first.t_s)?;
        let within = track.wheels.iter().zip(reckoned);
        let within = within.filter(|(sample, _)| first.t_s < sample.t_s && sample.t_s < last.t_s);
        let mut wheels = vec![track.at(reckoned, first.t_s)];
        wheels.extend(within.map(|(_, pose)| *pose));
        wheels.push(track.at(reckoned, last.t_s));
        Self::between(first, last, &wheels)
    }

    fn between(
        first: &'a PoseMeasurement,
        last: &'a PoseMeasurement,
        wheels: &[Pose],
    ) -> Option<Self> {
        let (from, to) = (wheels.first()?, wheels.last()?);
        let steps = || wheels.windows(2).map(|pair| pair[1].seen_from(pair[0]));
        Some(Self {
            first,
            last,
            to: to.seen_from(*from),
            path_m: steps().map(|step| step.x_m.hypot(step.y_m)).sum(),
            turn_rad: steps().map(|step| step.heading_rad.abs()).sum(),
        })
    }

    /// How far its heading is from where the wheels led \[rad\].
    pub(super) fn heading_off_rad(&self) -> Option<f64> {
        let both = self.first.heading_rad.zip(self.last.heading_rad);
        both.map(|(first, last)| wrap(last - first - self.to.heading_rad))
    }

    /// How far its position is from where the wheels led \[m\].
    pub(super) fn position_off_m(&self) -> Option<f64> {
        let both_m = self.first.position_m.zip(self.last.position_m);
        both_m.map(|([from_x_m, from_y_m], [x_m, y_m])| {
            match self.first.heading_rad {
                Some(heading_rad) => {
                    let to = Pose::new(from_x_m, from_y_m, heading_rad).compose(self.to);
                    (x_m - to.x_m).hypot(y_m - to.y_m)
                }
                // Without a first heading, only the distance can be compared.
                None => {
                    let went_m = (x_m - from_x_m).hypot(y_m - from_y_m);
                    (went_m - self.to.x_m.hypot(self.to.y_m)).abs()
                }
            }
        })
    }

    /// The last pose, if it is off by more than allowed.
    pub(super) fn off(&self, allowed: Allowed) -> Option<OffEndPose> {
        let bound = |(least, share): (f64, f64), of: f64| least + share * of;
        let off = OffEndPose {
            t_s: self.last.t_s,
            position_m: self
                .position_off_m()
                .filter(|off_m| *off_m > bound(allowed.position_m, self.path_m)),
            heading_rad: self
                .heading_off_rad()
                .filter(|off_rad| off_rad.abs() > bound(allowed.heading_rad, self.turn_rad)),
        };
        (off.position_m.is_some() || off.heading_rad.is_some()).then_some(off)
    }
}
