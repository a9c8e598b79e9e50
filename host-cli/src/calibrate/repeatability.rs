//! Do drives of one robot repeat well enough for the correction that they ask for?
//!
//! Every drive along the line says what W_T is, whatever W_T it was driven with. Two drives that differ by more than
//! their own sigmas, or a correction that is small, do not tell a radius from what differs from drive to drive: a
//! caster that hangs to one side until it swings round, a start that was not straight. Then a third drive, with the
//! old W_T again, decides. With W_i of n drives and W of the correction from W_0:
//!
//! ```text
//! s^2 = (sum (W_i - mean)^2 + 2 s_0^2) / (n - 1 + 2),   s_0 = 2 b y_0 / L^2,  y_0 = 1 mm in L = 2 m    (1)
//! saved if |W - W_0| > 2 t s,   t: Student's t with n - 1 + 2 degrees of freedom, two-sided 1 in 50  (2)
//! ```
//!
//! s_0 is how well an ordinary robot repeats, and counts as two drives. A next drive whose W differs by t s is then
//! still not worse off with the correction than without: three drives that happen to agree do not prove that the next
//! one does.

use robot_model::calibration::{Source, WheelWeight};
use robot_model::kinematics::Geometry;
use robot_model::numeric::students_t_quantile;

use super::mean_of_runs::is_straight_within;

/// As an ordinary robot repeats, y_0 after L \[m\].
const USUAL_M: (f64, f64) = (0.001, 2.0);
/// How many drives s_0 counts for.
const USUAL_DRIVES: f64 = 2.0;
/// The next drive may be worse off with the correction once in so many times.
const WORSE_ONCE_IN: f64 = 50.0;
/// Two drives contradict each other beyond this many of their sigmas: one in a hundred by chance.
const CONTRADICT_SIGMAS: f64 = 2.58;

/// Whether a third drive is needed: the correction is less than a centimetre in two metres, or the drives before and
/// after it contradict each other.
pub(super) fn is_third_needed(
    correction: f64,
    before: &WheelWeight,
    after: &WheelWeight,
    geometry: &Geometry,
) -> bool {
    let apart = (before.value - after.value).abs();
    is_straight_within(correction.abs(), geometry)
        || apart > CONTRADICT_SIGMAS * own_sigma(before).hypot(own_sigma(after))
}

/// Whether these drives repeat well enough for this correction (2).
pub(super) fn repeats(correction: f64, drives: &[f64], geometry: &Geometry) -> bool {
    correction.abs() > 2.0 * next_drive(freedom(drives)) * scatter(drives, geometry)
}

/// Degrees of freedom of s.
fn freedom(drives: &[f64]) -> f64 {
    drives.len() as f64 - 1.0 + USUAL_DRIVES
}

/// t of (2).
fn next_drive(freedom: f64) -> f64 {
    students_t_quantile(freedom, 1.0 - 0.5 / WORSE_ONCE_IN)
}

/// s (1).
fn scatter(drives: &[f64], geometry: &Geometry) -> f64 {
    let (offset_m, length_m) = USUAL_M;
    let usual = 2.0 * geometry.track_width_m * offset_m / (length_m * length_m);
    let mean = drives.iter().sum::<f64>() / drives.len() as f64;
    let squares: f64 = drives.iter().map(|value| (value - mean).powi(2)).sum();
    ((squares + USUAL_DRIVES * usual * usual) / freedom(drives)).sqrt()
}

/// The sigma of one drive without the tolerances of the nominal robot, which all drives share.
fn own_sigma(weight: &WheelWeight) -> f64 {
    let own = weight.contributions.iter();
    let own = own.filter(|part| !matches!(part.source, Source::TrackWidth | Source::WheelRadius));
    own.map(|part| part.sigma * part.sigma).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAPER: Geometry = Geometry::PAPER;

    #[test]
    fn a_small_correction_needs_drives_that_repeat() {
        // Equal wheels, a caster that hangs aside until it swings round before the third drive.
        assert!(!repeats(0.0009, &[0.9991, 0.9993, 1.0], &PAPER));
        // Unequal wheels, 5 mm off in two metres.
        assert!(repeats(0.0011, &[0.9989, 0.9989, 0.9989], &PAPER));
        // Four millimetres are within what robots repeat, of three drives; of five, three.
        assert!(!repeats(0.0009, &[0.9991; 3], &PAPER) && repeats(0.0009, &[0.9991; 5], &PAPER));
        assert!(!repeats(0.0007, &[0.9993; 4], &PAPER) && repeats(0.0007, &[0.9993; 8], &PAPER));
    }

    #[test]
    fn few_drives_that_agree_ask_for_a_larger_correction_than_many() {
        // Tables of Student's t: 4 and 12 degrees of freedom, 0.99.
        assert!(
            (next_drive(4.0) - 3.7469).abs() < 1e-4 && (next_drive(12.0) - 2.6810).abs() < 1e-4
        );
    }

    #[test]
    fn a_large_correction_stands_out_from_drives_that_contradict_each_other() {
        assert!(repeats(0.0081, &[0.9915, 0.9919, 0.9922], &PAPER));
        assert!(!repeats(0.0081, &[0.9919, 1.0, 0.9919], &PAPER));
    }
}
