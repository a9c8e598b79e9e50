//! What a yaw rate sensor measured during a run, from a file that a logger appends to by a clock of
//! its own.
//!
//! The log is moved to the robot's clock by the turns themselves: the shift is the one at which
//! readings and yaw rate by the wheels have the greatest correlation,
//!
//! ```text
//! shift = argmax  corr(reading(t), omega_wheels(t + shift))
//! ```
//!
//! A correlation depends neither on bias nor on scale, so both stay in the data for `explain` to
//! find. The shift contains a constant delay of the sensor. A run without a turn uses the shift of
//! the last run with one; before the first turn, the first reading of the run is put at the run's
//! first sample, which is exact enough for a robot that does not turn.

use std::path::{Path, PathBuf};

use super::align::Reckoned;
use crate::error::{Error, Result};
use crate::ui;
use campaign::live_file::whole_lines;
use campaign::table::Table;
use campaign::{CampaignError, Column, Warning};

/// A run does not turn if the yaw rate by the wheels has a smaller standard deviation than this
/// \[rad/s\].
const TURNS: f64 = 0.03;
/// How wrong the first guess may be \[s\], and the step of the first search.
const REACH_S: f64 = 4.0;
const COARSE_S: f64 = 0.02;
/// The least correlation between a gyro and the wheels of its robot: it is usually far greater.
const CORRELATION_MIN: f64 = 0.7;
/// With fewer readings in a run the logger was not running.
const READINGS_MIN: usize = 10;

/// The log, and how many of its readings are from before the run.
#[derive(Clone, Debug)]
pub struct GyroLog {
    path: PathBuf,
    before: usize,
    shift_s: Option<f64>,
}

impl GyroLog {
    /// A log that exists, or will exist when a run begins.
    pub fn new(path: &Path) -> Self {
        Self { path: path.into(), before: 0, shift_s: None }
    }

    /// Notes how far the log has come before a run.
    ///
    /// # Errors
    /// If it cannot be read, or lacks a column.
    pub fn begin(&mut self) -> Result<()> {
        if !self.path.exists() {
            return Err(Error::new(format_args!("there is no gyro log {}", self.path.display()))
                .hint("start the logger first, so that the file is there"));
        }
        self.before = self.so_far()?.len();
        Ok(())
    }

    /// The readings of the run that `wheels` drove: time on the robot's clock, rate \[s, rad/s\].
    ///
    /// # Errors
    /// If the log did not grow, or its turns are not those of the wheels.
    pub fn take(&mut self, run: &str, wheels: &[Reckoned]) -> Result<Vec<(f64, f64)>> {
        let mut readings = self.so_far()?.split_off(self.before);
        let path = self.path.display();
        if readings.len() < READINGS_MIN {
            return Err(Error::new(format_args!(
                "{path} got {} readings during the run {run}",
                readings.len()
            ))
            .hint("is the logger running, and does it append to this file?"));
        }
        let rates = yaw_rates(wheels);
        let (Some(first), Some(begin)) = (readings.first(), wheels.first()) else {
            return Ok(Vec::new());
        };
        let guess_s = self.shift_s.unwrap_or(begin.t_s - first.0);
        let shift_s = if standard_deviation(rates.iter().map(|(_, rate)| *rate)) < TURNS {
            guess_s
        } else {
            let (shift_s, correlation) = best_shift_s(&readings, &rates, guess_s);
            if correlation < CORRELATION_MIN {
                return Err(Error::new(format_args!(
                    "{path} and the wheels do not show the same turns in the run {run}"
                ))
                .hint("is it of this robot, in rad/s, and counter-clockwise positive?"));
            }
            self.shift_s = Some(shift_s);
            shift_s
        };
        readings.iter_mut().for_each(|(t_s, _)| *t_s += shift_s);
        Ok(readings)
    }

    /// The readings in all whole lines of the log; none if there is no row yet.
    fn so_far(&self) -> Result<Vec<(f64, f64)>> {
        let text = whole_lines(&self.path)
            .map_err(|error| CampaignError::io(&self.path, "read it", error))?;
        let (readings, warnings) = parse(&self.path, text)?;
        if self.before == 0 {
            warnings.iter().for_each(ui::warn);
        }
        Ok(readings)
    }
}

/// The readings in the text of a log, which errors call `file`: time on the logger's clock, rate \[s, rad/s\].
/// None if there is no row yet.
///
/// # Errors
/// If a column is missing, or a cell is no number of its column.
#[allow(clippy::type_complexity, reason = "readings and warnings, as every table gives them")]
pub fn parse(
    file: &Path,
    text: String,
) -> std::result::Result<(Vec<(f64, f64)>, Vec<Warning>), CampaignError> {
    const HEADER_AND_TWO_ROWS: usize = 3;
    if text.is_empty() {
        return Ok((Vec::new(), Vec::new()));
    }
    let known = |name: &str| {
        Column::from_name(name).filter(|column| matches!(column, Column::Time | Column::GyroZ))
    };
    let required = [Column::Time, Column::GyroZ];
    let short = text.lines().count() < HEADER_AND_TWO_ROWS;
    // Two rows stand in for those that will come, so that the header is checked now.
    let text = if short { header_and_zeros(&text) } else { text };
    let table = Table::parse(file, text.as_bytes(), known, &required)?;
    if short {
        return Ok((Vec::new(), Vec::new()));
    }
    let reading = |cells: &[(Column, Option<f64>)]| {
        let cell = |wanted| {
            cells.iter().find(|(column, _)| *column == wanted).and_then(|(_, value)| *value)
        };
        Some((cell(Column::Time)?, cell(Column::GyroZ)?))
    };
    Ok((table.rows.iter().filter_map(|(_, cells)| reading(cells)).collect(), table.warnings))
}

fn header_and_zeros(text: &str) -> String {
    let header = text.lines().next().unwrap_or_default();
    let row = |t: u8| header.split(',').map(|_| t.to_string()).collect::<Vec<_>>().join(",");
    format!("{header}\n{}\n{}\n", row(0), row(1))
}

/// The yaw rate by the wheels, between samples: time, rate \[s, rad/s\].
fn yaw_rates(wheels: &[Reckoned]) -> Vec<(f64, f64)> {
    let rate = |pair: &[Reckoned]| {
        let dt_s = pair[1].t_s - pair[0].t_s;
        let turned_rad = pair[1].pose.heading_rad - pair[0].pose.heading_rad;
        (dt_s > 0.0).then(|| ((pair[0].t_s + pair[1].t_s) / 2.0, turned_rad / dt_s))
    };
    wheels.windows(2).filter_map(rate).collect()
}

fn standard_deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    (values.map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// The shift with the greatest correlation \[s\], and that correlation.
fn best_shift_s(readings: &[(f64, f64)], rates: &[(f64, f64)], guess_s: f64) -> (f64, f64) {
    let score = |shift_s: f64| correlation(readings, rates, shift_s);
    let best_of = |tries: &mut dyn Iterator<Item = f64>| {
        let scored = tries.map(|shift_s| (shift_s, score(shift_s)));
        scored.fold((guess_s, -1.0), |best, tried| if tried.1 > best.1 { tried } else { best })
    };
    let steps = (REACH_S / COARSE_S) as i32;
    let mut best = best_of(&mut (-steps..=steps).map(|k| guess_s + f64::from(k) * COARSE_S));
    let mut step_s = COARSE_S / 4.0;
    // Down to a tenth of a millisecond.
    while step_s > 1e-4 {
        let about = best.0;
        best = best_of(&mut (-4..=4).map(|k| about + f64::from(k) * step_s));
        step_s /= 3.0;
    }
    best
}

/// Whether a log with this shift covers the whole run, except for a tenth at each end. Otherwise
/// the shift could match a turn to an earlier or later one.
fn covers(readings: &[(f64, f64)], rates: &[(f64, f64)], shift_s: f64) -> bool {
    let ends = |of: &[(f64, f64)]| Some((of.first()?.0, of.last()?.0));
    let (Some((log0, log1)), Some((run0, run1))) = (ends(readings), ends(rates)) else {
        return false;
    };
    let slack_s = 0.1 * (run1 - run0);
    log0 + shift_s <= run0 + slack_s && log1 + shift_s >= run1 - slack_s
}

/// The correlation of the readings with the yaw rate by the wheels, over the time of the wheels; -1
/// if the log does not cover the run.
fn correlation(readings: &[(f64, f64)], rates: &[(f64, f64)], shift_s: f64) -> f64 {
    if !covers(readings, rates, shift_s) {
        return -1.0;
    }
    let (mut n, mut x, mut y, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let mut after = 0;
    for (t_s, reading) in readings {
        let t_s = t_s + shift_s;
        while after < rates.len() && rates[after].0 <= t_s {
            after += 1;
        }
        let (Some(a), Some(b)) = (after.checked_sub(1).map(|k| rates[k]), rates.get(after)) else {
            continue;
        };
        let rate = a.1 + (t_s - a.0) / (b.0 - a.0) * (b.1 - a.1);
        n += 1.0;
        x += reading;
        y += rate;
        xx += reading * reading;
        xy += reading * rate;
        yy += rate * rate;
    }
    let (cov, var) = (n * xy - x * y, (n * xx - x * x) * (n * yy - y * y));
    if var > 0.0 { cov / var.sqrt() } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use robot_model::kinematics::Pose;

    use super::*;

    /// Turns left, then right, with ramps of a second: the heading \[rad\].
    fn heading_rad(t_s: f64) -> f64 {
        let hill = |t: f64| {
            let t = t.clamp(0.0, 4.0);
            match t {
                t if t < 1.0 => 0.25 * t * t,
                t if t < 3.0 => 0.25 + 0.5 * (t - 1.0),
                t => 1.5 - 0.25 * (4.0 - t) * (4.0 - t),
            }
        };
        hill(t_s - 1.0) - 0.7 * hill(t_s - 6.0)
    }

    fn wheels(turning: f64) -> Vec<Reckoned> {
        let at = |k: i32| {
            let t_s = f64::from(k) * 0.02;
            Reckoned { t_s: 50.0 + t_s, pose: Pose::new(0.0, 0.0, turning * heading_rad(t_s)) }
        };
        (0..550).map(at).collect()
    }

    /// A log by a clock that is 43 s behind, begun 0.6 s before the run, with a bias and 3 % too
    /// large a scale.
    fn log(turning: f64) -> tempfile::NamedTempFile {
        let mut text = String::from("t_s,gyro_z_rad_s\n");
        for k in 0..1200 {
            let t_s = f64::from(k) * 0.01 - 0.6;
            let rate = turning * (heading_rad(t_s + 5e-4) - heading_rad(t_s - 5e-4)) / 1e-3;
            let _ = writeln!(text, "{:.4},{:.6}", t_s + 7.0, 1.03 * rate + 0.02);
        }
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        file
    }

    #[test]
    fn a_turn_aligns_the_clocks_and_leaves_bias_and_scale_alone() {
        let file = log(1.0);
        let mut log = GyroLog::new(file.path());
        let readings = log.take("spin", &wheels(1.0)).unwrap();
        // On ramps of 0.5 rad/s^2 a millisecond is 0.5 mrad/s.
        assert!((log.shift_s.unwrap() - 43.0).abs() < 1e-3, "{:?}", log.shift_s);
        let cruise = readings.iter().find(|(t_s, _)| *t_s > 53.0).unwrap();
        assert!((cruise.1 - (1.03 * 0.5 + 0.02)).abs() < 1e-5, "{cruise:?}");
        // The next run goes straight, and uses the same shift.
        let file = super::tests::log(0.0);
        log.path = file.path().into();
        let readings = log.take("straight", &wheels(0.0)).unwrap();
        assert!((readings[0].0 - (43.0 + 6.4)).abs() < 1e-3, "{:?}", readings[0]);
    }

    #[test]
    fn a_first_run_without_a_turn_begins_with_the_telemetry() {
        let file = log(0.0);
        let readings = GyroLog::new(file.path()).take("rest", &wheels(0.0)).unwrap();
        assert!((readings[0].0 - 50.0).abs() < 1e-9);
    }

    #[test]
    fn a_file_that_is_not_a_log_of_this_run_is_refused_by_name() {
        let refused = |text: &str| {
            let file = tempfile::NamedTempFile::new().unwrap();
            std::fs::write(file.path(), text).unwrap();
            let mut log = GyroLog::new(file.path());
            let error = log.begin().and_then(|()| {
                log.before = 0;
                log.take("spin", &wheels(1.0)).map(drop)
            });
            error.unwrap_err().to_string()
        };
        assert!(refused("t_s,yaw\n").contains("`gyro_z_rad_s` is missing"));
        assert!(refused("t_s,gyro_z_rad_s\n0,0\n0.1,x\n").contains("line 3, column 2"));
        assert!(refused("t_s,gyro_z_rad_s\n0,0\n0.1,0\n").contains("got 2 readings"));
        let file = log(-1.0);
        let taken =
            GyroLog::new(file.path()).take("spin", &wheels(1.0)).map(|readings| readings.len());
        let error = taken.unwrap_err();
        assert!(error.to_string().contains("do not show the same turns in the run spin"));
        let error = GyroLog::new(Path::new("none.csv")).begin().unwrap_err();
        assert!(error.to_string().contains("none.csv"));
        // A file that is empty, or has only its header, is accepted.
        for text in ["", "t_s,gyro_z_rad_s\n"] {
            std::fs::write(file.path(), text).unwrap();
            GyroLog::new(file.path()).begin().unwrap();
        }
    }
}
