//! Converts telemetry, measured poses and yaw rates into the rows of a run file.

use robot_model::calibration::TrackSample;
use shared_proto::{Config, Telemetry};

use crate::pose_source::Sigma;

use campaign::{Column, RobotFile, Row};

/// The `robot.toml` of a robot with this configuration, and with this noise of its poses if it is
/// known. A simulated camera without noise leaves it to be learnt.
///
/// The file has one encoder for both wheels, the left one: see [`on_one_encoder`].
pub fn robot_file(config: &Config, noise: Option<Sigma>) -> RobotFile {
    RobotFile {
        position_sigma_m: noise.map(|noise| noise.position_m).filter(|sigma| *sigma > 0.0),
        heading_sigma_rad: noise.map(|noise| noise.heading_rad).filter(|sigma| *sigma > 0.0),
        ..RobotFile::of(config)
    }
}

/// The columns of a run, with or without measured poses and yaw rates.
pub fn columns(poses: bool, gyro: bool) -> Vec<Column> {
    let mut columns = vec![Column::LeftDuty, Column::RightDuty, Column::BusV];
    if poses {
        columns.extend([Column::X, Column::Y, Column::Heading]);
    }
    if gyro {
        columns.push(Column::GyroZ);
    }
    columns
}

/// Telemetry, measured poses and yaw rates, all on the robot's clock, in order of time; a pose has
/// a row of its own. Poses and rates before or after the telemetry are dropped.
pub fn rows(telemetry: &[Telemetry], track: &[TrackSample], gyro: &[(f64, f64)]) -> Vec<Row> {
    let (Some(first), Some(last)) = (telemetry.first(), telemetry.last()) else {
        return Vec::new();
    };
    let start_us = first.t_us;
    let mut rows: Vec<_> = telemetry
        .iter()
        .map(|frame| Row {
            t_s: seconds(start_us, frame.t_us),
            counts: frame.wheels.map(|wheel| Some(wheel.counts as f64)),
            duty: frame.wheels.map(|wheel| Some(f64::from(wheel.duty) / 32767.0)),
            bus_v: Some(f64::from(frame.supply_mv) * 1e-3),
            ..Row::default()
        })
        .collect();
    let end_s = seconds(start_us, last.t_us);
    for sample in track {
        // In whole microseconds, so that equal instants of two recordings have equal bits, however
        // long the robot has been switched on.
        let t_s = ((sample.t_s * 1e6).round() - start_us as f64) * 1e-6;
        if (0.0..=end_s).contains(&t_s) {
            let (x_m, y_m) = (Some(sample.x_m), Some(sample.y_m));
            let heading_rad = sample.heading_rad;
            rows.push(Row { t_s, x_m, y_m, heading_rad, ..Row::default() });
        }
    }
    for (t_s, rate_rad_s) in gyro {
        let t_s = t_s - start_us as f64 * 1e-6;
        if (0.0..=end_s).contains(&t_s) {
            rows.push(Row { t_s, gyro_z_rad_s: Some(*rate_rad_s), ..Row::default() });
        }
    }
    rows.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    merge_equal_times(rows)
}

/// From one time of the robot's clock to another, before it if negative \[s\].
pub fn seconds(from_us: u64, to_us: u64) -> f64 {
    // The difference of any two times is exact so, and a clock that goes back makes no huge one.
    to_us.wrapping_sub(from_us).cast_signed() as f64 * 1e-6
}

/// A row with the right wheel's counts converted to the left wheel's encoder: a file has one number
/// of counts per revolution for both wheels.
pub fn on_one_encoder(row: &Row, config: &Config) -> Row {
    let per_turn = config.encoder.map(|encoder| encoder.counts_per_rev * encoder.gear_reduction);
    let mut row = *row;
    if per_turn.left != per_turn.right {
        row.counts.right = row.counts.right.map(|counts| counts * per_turn.left / per_turn.right);
    }
    row
}

/// One row for each time: the times in a file are whole microseconds, and increase strictly.
fn merge_equal_times(rows: Vec<Row>) -> Vec<Row> {
    let mut merged: Vec<Row> = Vec::with_capacity(rows.len());
    for row in rows {
        match merged.last_mut() {
            Some(last) if (row.t_s - last.t_s) < 1e-6 => {
                last.counts.left = last.counts.left.or(row.counts.left);
                last.counts.right = last.counts.right.or(row.counts.right);
                last.duty.left = last.duty.left.or(row.duty.left);
                last.duty.right = last.duty.right.or(row.duty.right);
                last.bus_v = last.bus_v.or(row.bus_v);
                last.applied_v.left = last.applied_v.left.or(row.applied_v.left);
                last.applied_v.right = last.applied_v.right.or(row.applied_v.right);
                last.x_m = last.x_m.or(row.x_m);
                last.y_m = last.y_m.or(row.y_m);
                last.heading_rad = last.heading_rad.or(row.heading_rad);
                last.gyro_z_rad_s = last.gyro_z_rad_s.or(row.gyro_z_rad_s);
            }
            _ => merged.push(row),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use shared_proto::WheelPair;

    use super::*;

    #[test]
    fn a_camera_without_noise_leaves_it_to_be_learnt() {
        let exact = Sigma { position_m: 0.0, heading_rad: 0.002 };
        let robot = robot_file(&Config::default(), Some(exact));
        assert_eq!((robot.position_sigma_m, robot.heading_sigma_rad), (None, Some(0.002)));
    }

    #[test]
    fn wheels_that_turn_equally_have_equal_counts_whatever_their_encoders() {
        let mut config = Config::default();
        config.encoder.left.counts_per_rev = 900.0;
        config.encoder.right.counts_per_rev = 1024.0;
        let row = Row { counts: WheelPair::new(Some(1800.0), Some(2048.0)), ..Row::default() };
        let written = on_one_encoder(&row, &config);
        assert_eq!(written.counts, WheelPair::both(Some(1800.0)));
        assert_eq!(robot_file(&config, None).counts_per_rev, 900.0);
        // With equal encoders the row does not change by a bit.
        config.encoder.right = config.encoder.left;
        assert_eq!(on_one_encoder(&row, &config), row);
    }
}
