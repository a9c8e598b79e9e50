//! What every source becomes: the angles of two wheels, and poses in space, each over time on a clock of its own.

use campaign::{CampaignError, Place};
use std::path::{Path, PathBuf};

/// The wheels over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WheelLog {
    /// The file.
    pub file: PathBuf,
    /// What in the file, for people: a topic, columns.
    pub what: String,
    /// Times, strictly increasing \[s\].
    pub t_s: Vec<f64>,
    /// How far the left and the right wheel have turned, in `unit`.
    pub turned: Vec<[f64; 2]>,
    /// Of the angles.
    pub unit: WheelUnit,
    /// What else the robot measured.
    pub gyro_and_supply: GyroAndSupply,
}

/// What else a robot measured, by the clock of its wheels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GyroAndSupply {
    /// Rates of a gyro about its own axes \[s, rad/s\].
    pub turn_rates: Vec<(f64, [f64; 3])>,
    /// Voltages of the battery \[s, V\].
    pub supply_v: Vec<(f64, f64)>,
}

/// In what wheels are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WheelUnit {
    /// Radians of the wheel.
    #[default]
    Radians,
    /// Counts of an encoder.
    Counts,
    /// Metres that the rim rolled.
    Metres,
}

/// A pose in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose3 {
    /// When \[s\].
    pub t_s: f64,
    /// Where \[m\].
    pub position_m: [f64; 3],
    /// A unit quaternion x, y, z, w from the body's axes to the frame's.
    pub orientation: Option<[f64; 4]>,
}

/// Poses over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseLog {
    /// The file.
    pub file: PathBuf,
    /// What in the file, for people.
    pub what: String,
    /// The poses, times strictly increasing.
    pub poses: Vec<Pose3>,
}

/// Something that a user should know about a source, and that stops nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The file or folder.
    pub file: PathBuf,
    /// What.
    pub text: String,
}

impl Note {
    /// A note about a file.
    pub fn new(file: &Path, text: impl Into<String>) -> Self {
        Self { file: file.into(), text: text.into() }
    }
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.file.display(), self.text)
    }
}

/// An error about a file as a whole.
pub(crate) fn error(
    file: &Path,
    problem: impl Into<String>,
    hint: impl Into<String>,
) -> CampaignError {
    CampaignError::new(Place::whole(file), problem, hint)
}

/// Sorts samples by their times, and keeps the first of those with the same time; what was done, in words.
///
/// No log has other times, in whatever unit they were taken for \[s\].
const TIME_MAX_S: f64 = 1e11;

/// Only finite times and numbers stay. More than a few samples that go back in time are no disorder of messages but a
/// clock that was set.
pub(crate) fn ordered<T>(
    samples: &mut Vec<T>,
    time_s: impl Fn(&T) -> f64,
    is_finite: impl Fn(&T) -> bool,
) -> Vec<String> {
    let mut said = Vec::new();
    let before = samples.len();
    samples.retain(|sample| time_s(sample).abs() < TIME_MAX_S && is_finite(sample));
    if samples.len() < before {
        said.push(format!("{} samples are not numbers and were left out", before - samples.len()));
    }
    let back = samples.windows(2).filter(|pair| time_s(&pair[1]) < time_s(&pair[0])).count();
    if back > 0 {
        said.push(format!("time goes back {back} times; the samples were put in order"));
    }
    samples.sort_by(|a, b| time_s(a).total_cmp(&time_s(b)));
    let before = samples.len();
    samples.dedup_by(|later, first| time_s(later) <= time_s(first));
    if samples.len() < before {
        let doubles = before - samples.len();
        said.push(format!("{doubles} samples have the time of another and were left out"));
    }
    said
}

/// The middle of the times between two samples, which are in order \[s\]; `None` of fewer than two.
pub(crate) fn usual_step_s(times_s: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let mut steps_s: Vec<f64> =
        times_s.clone().skip(1).zip(times_s).map(|(later, earlier)| later - earlier).collect();
    let middle = steps_s.len() / 2;
    (!steps_s.is_empty()).then(|| *steps_s.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_put_in_order_and_what_was_done_is_said() {
        let mut samples = vec![(0.0, 1.0), (2.0, 1.0), (1.0, 1.0), (2.0, 3.0), (3.0, f64::NAN)];
        let said = ordered(&mut samples, |sample| sample.0, |sample| sample.1.is_finite());
        assert_eq!(samples, [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0)]);
        assert_eq!(said.len(), 3, "{said:?}");
    }
}
