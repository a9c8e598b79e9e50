//! What do the readings of a yaw rate sensor tell? A filter of its own, in one dimension, against the measured
//! heading.
//!
//! ```text
//! gyro = omega + sum sense(omega)                                                     (1)
//! z_k = theta_0 + integral of omega + n_k,   theta_0 a random walk, k_g^2 t            (2)
//! ```
//!
//! The wheels have no part in it: an error of the sensor must not turn the track, nor the track the sensor.

use crate::effect::composition::{Composer, Term, Terms};
use crate::effect::definition::ActsOn;
use crate::estimation::ekf::{FilterObserver, Innovation};
use crate::estimation::state::Variances;
use crate::numeric::angle::wrap;
use crate::numeric::jet::Jet;
use crate::numeric::lanes::Number;
use crate::recording::campaign::PreparedRun;
use crate::recording::odometry_noise::OdometryNoise;

/// From one measured heading to the next by the yaw rate sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GyroSegment {
    /// Integral of the rate \[rad\].
    turn_rad: f64,
    dt_s: f64,
    /// The heading measured at its end \[rad\].
    measured_rad: f64,
    /// Its position in the run, in steps of the wheels: it determines the block.
    step: usize,
}

/// The segments of a run with a yaw rate sensor, from the first measured heading on; and of each, the
/// derivatives of its turn by every column, one segment after the other.
fn segments(run: &PreparedRun, terms: Terms<'_, '_>) -> (Vec<GyroSegment>, Vec<f64>) {
    let columns = terms.columns();
    let gyro = &run.recording.gyro;
    let (mut segments, mut slopes) = (Vec::new(), Vec::new());
    if gyro.len() < 2 {
        return (segments, slopes);
    }
    let mut sensor = terms.each();
    sensor.retain(|(term, _)| term.effect.facts().acts_on == ActsOn::Gyro);
    // A delayed measurement is the heading of a moment before.
    let (view, view_by_column) = Composer::new(terms).view();
    let delay_s = view.delay_s.value;
    let mut measurements = run
        .recording
        .measured_poses
        .iter()
        .filter_map(|pose| Some((pose.t_s - delay_s, pose.heading_rad?)))
        .skip_while(|(t_s, _)| *t_s < gyro[0].t_s)
        .peekable();
    let mut omega_before = 0.0;
    let mut by_column = vec![0.0; columns];
    let mut open = vec![0.0; columns];
    let (mut turn_rad, mut dt_s) = (0.0, 0.0);
    for (k, pair) in gyro.windows(2).enumerate() {
        let (mut now_s, end_s) = (pair[0].t_s, pair[1].t_s);
        let reading = (pair[0].rate_rad_s + pair[1].rate_rad_s) / 2.0;
        let omega = true_rate(reading, &sensor, &mut by_column);
        loop {
            let measurement = measurements.next_if(|(t_s, _)| *t_s <= end_s);
            let until_s = measurement.map_or(end_s, |(t_s, _)| t_s.max(now_s));
            turn_rad += omega * (until_s - now_s);
            dt_s += until_s - now_s;
            open.iter_mut().zip(&by_column).for_each(|(s, by)| *s += by * (until_s - now_s));
            now_s = until_s;
            let Some((_, measured_rad)) = measurement else { break };
            let step = k * run.motion.steps.len() / gyro.len();
            segments.push(GyroSegment { turn_rad, dt_s, measured_rad, step });
            let faster = omega - omega_before;
            omega_before = omega;
            let later = open.iter().zip(&view_by_column);
            slopes.extend(later.map(|(slope, view)| slope - faster * view.delay_s.value));
            (turn_rad, dt_s) = (0.0, 0.0);
            open.fill(0.0);
        }
    }
    (segments, slopes)
}

/// The segments of a run with fixed effects.
pub(crate) fn fixed_segments(run: &PreparedRun, terms: &[Term<'_>]) -> Vec<GyroSegment> {
    segments(run, Terms::Fixed(terms)).0
}

/// How far an effect of these turns the heading that the yaw rate sensor tells, root of the mean square over all measured
/// headings, from the best start of each run \[rad\].
pub(crate) fn heading_turned_rad(runs: &[PreparedRun], terms: &[Term<'_>], effect: usize) -> f64 {
    let mut without = terms.to_vec();
    without.remove(effect);
    let (mut sum, mut count) = (0.0, 0.0);
    for run in runs {
        let pairs = fixed_segments(run, terms).into_iter().zip(fixed_segments(run, &without));
        let mut turned_rad = 0.0;
        // The first one ends where the heading is first measured.
        let each: Vec<f64> = pairs
            .enumerate()
            .map(|(index, (with, without))| {
                turned_rad += if index > 0 { with.turn_rad - without.turn_rad } else { 0.0 };
                turned_rad
            })
            .collect();
        let mean = each.iter().sum::<f64>() / each.len().max(1) as f64;
        sum += each.iter().map(|rad| (rad - mean).powi(2)).sum::<f64>();
        count += each.len() as f64;
    }
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}

/// The innovations of the segments of a run with this noise: for each after the first, with its index, nu, its variance
/// s and the gain.
pub(crate) fn follow<T: Number>(
    segments: &[GyroSegment],
    noise: &Variances<T>,
    mut seen: impl FnMut(usize, T, T, T),
) {
    let Some(first) = segments.first() else { return };
    let heading_var = noise.whole_heading();
    let (mut heading_rad, mut variance) = (T::of(first.measured_rad), heading_var);
    for (index, segment) in segments.iter().enumerate().skip(1) {
        heading_rad += T::of(segment.turn_rad);
        variance += noise.gyro_per_s() * T::of(segment.dt_s);
        let nu = (T::of(segment.measured_rad) - heading_rad).each(wrap);
        let s = variance + heading_var;
        let gain = variance / s;
        heading_rad += gain * nu;
        variance *= T::of(1.0) - gain;
        seen(index, nu, s, gain);
    }
}

/// Gives the observer a whitened row for each measured heading of a run with a yaw rate sensor.
pub(crate) fn whiten_gyro(
    run: &PreparedRun,
    terms: Terms<'_, '_>,
    noise: &OdometryNoise,
    observer: &mut impl FilterObserver,
) {
    let columns = terms.columns();
    let (segments, slopes) = segments(run, terms);
    let mut slope = vec![0.0; columns];
    let mut row = vec![0.0; columns];
    follow(&segments, &Variances::of(noise), |index, value, variance, gain| {
        let innovation = Innovation { step: segments[index].step, value, variance };
        let by = &slopes[index * columns..(index + 1) * columns];
        for ((slot, slope), by) in row.iter_mut().zip(&mut slope).zip(by) {
            *slope += by;
            *slot = *slope / innovation.variance.sqrt();
            *slope *= 1.0 - gain;
        }
        observer.row(innovation, &row);
    });
}

/// The rate behind a reading, by (1); its derivative by each column is left in `by_column`.
fn true_rate(reading: f64, sensor: &[(&Term<'_>, Option<usize>)], by_column: &mut [f64]) -> f64 {
    let sense = |omega: f64| -> f64 {
        let each = sensor.iter();
        each.map(|(term, _)| term.effect.sense_rate(&Jet::parameters(&term.values), omega).value)
            .sum()
    };
    // What sensors add is linear in the rate, so one step of Newton is exact.
    let (at_zero, slope) = (sense(0.0), sense(1.0) - sense(0.0));
    let omega = (reading - at_zero) / (1.0 + slope);
    for (term, first) in sensor {
        let Some(first) = first else { continue };
        let added = term.effect.sense_rate(&Jet::parameters(&term.values), omega);
        for j in 0..term.values.len() {
            by_column[first + j] = -added.by[j] / (1.0 + slope);
        }
    }
    omega
}
