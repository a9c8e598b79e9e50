//! The yaw rate sensor against the measured heading: a track of its own, in one dimension.
//!
//! ```text
//! gyro = omega + sum sense(omega)                                                     (1)
//! z_k = theta_0 + integral of omega + n_k,   theta_0 wandering by k_g^2 t             (2)
//! ```
//!
//! The wheels have no part in it: a sensor that is off must not turn the track, nor a track the sensor.

use crate::campaign::PreparedRun;
use crate::effect::ActsOn;
use crate::increment::Term;
use crate::jet::Jet;
use crate::odometry_noise::OdometryNoise;
use crate::recording::wrap;
use crate::whiten::{Innovation, Sink};

/// Gives the sink a whitened row for each measured heading of a run with a yaw rate sensor.
pub(crate) fn whiten_gyro(
    run: &PreparedRun,
    terms: &[Term<'_>],
    columns: usize,
    noise: &OdometryNoise,
    sink: &mut impl Sink,
) {
    let gyro = &run.recording.gyro;
    if gyro.len() < 2 {
        return;
    }
    let sensor: Vec<&Term<'_>> =
        terms.iter().filter(|it| it.effect.facts().acts_on == ActsOn::Gyro).collect();
    let heading_var = noise.heading_sigma_rad.powi(2) + noise.heading_wobble_rad.powi(2);
    let mut sights = run
        .recording
        .sights
        .iter()
        .filter_map(|it| Some((it.t_s, it.heading_rad?)))
        .skip_while(|(t_s, _)| *t_s < gyro[0].t_s)
        .peekable();
    // Heading, its variance and its derivatives; none before the first sight.
    let mut heading: Option<(f64, f64)> = None;
    let mut slopes = vec![0.0; columns];
    let mut row = vec![0.0; columns];
    for (k, pair) in gyro.windows(2).enumerate() {
        let (mut now_s, end_s) = (pair[0].t_s, pair[1].t_s);
        let (omega, by_column) =
            true_rate((pair[0].rate_rad_s + pair[1].rate_rad_s) / 2.0, &sensor, columns);
        loop {
            let sight = sights.next_if(|(t_s, _)| *t_s <= end_s);
            let until_s = sight.map_or(end_s, |(t_s, _)| t_s.max(now_s));
            let dt_s = until_s - now_s;
            if let Some((theta, variance)) = &mut heading {
                *theta += omega * dt_s;
                *variance += noise.gyro_walk.powi(2) * dt_s;
                slopes.iter_mut().zip(&by_column).for_each(|(s, by)| *s += by * dt_s);
            }
            now_s = until_s;
            let Some((_, measured)) = sight else { break };
            let Some((theta, variance)) = &mut heading else {
                heading = Some((measured, heading_var));
                continue;
            };
            let nu = wrap(measured - *theta);
            let s = *variance + heading_var;
            let gain = *variance / s;
            for (slot, slope) in row.iter_mut().zip(&mut slopes) {
                *slot = *slope / s.sqrt();
                *slope *= 1.0 - gain;
            }
            *theta += gain * nu;
            *variance *= 1.0 - gain;
            // Its place in the run, in steps of the wheels, tells which block it belongs to.
            let step = k * run.motion.steps.len() / gyro.len();
            sink.row(Innovation { step, value: nu, variance: s }, &row);
        }
    }
}

/// The rate behind a reading, by (1), and its derivative by each column.
fn true_rate(reading: f64, sensor: &[&Term<'_>], columns: usize) -> (f64, Vec<f64>) {
    let sense = |omega: f64| -> f64 {
        let each = sensor.iter();
        each.map(|it| it.effect.sense_rate(&Jet::parameters(&it.values), omega).value).sum()
    };
    // What sensors add is linear in the rate, so one step of Newton is exact.
    let (at_zero, slope) = (sense(0.0), sense(1.0) - sense(0.0));
    let omega = (reading - at_zero) / (1.0 + slope);
    let mut by_column = vec![0.0; columns];
    for term in sensor {
        let Some(first) = term.column else { continue };
        let added = term.effect.sense_rate(&Jet::parameters(&term.values), omega);
        for j in 0..term.values.len() {
            by_column[first + j] = -added.by[j] / (1.0 + slope);
        }
    }
    (omega, by_column)
}
