//! What a robot tells of itself besides its wheels: duty, supply, gyro.

use campaign::Row;

/// Numbers over the time of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Telemetry {
    /// Duty of both motors, -1 to 1.
    pub duty: Vec<(f64, [f64; 2])>,
    /// Voltage of the supply \[V\].
    pub supply_v: Vec<(f64, f64)>,
    /// Rate of the gyro about the axis that points up \[rad/s\].
    pub yaw_rates: Vec<(f64, f64)>,
}

impl Telemetry {
    /// Of the rows of a run.
    pub fn of(rows: &[Row]) -> Self {
        let mut telemetry = Self::default();
        for row in rows {
            if let (Some(left), Some(right)) = (row.duty.left, row.duty.right) {
                telemetry.duty.push((row.t_s, [left, right]));
            }
            telemetry.supply_v.extend(row.bus_v.map(|volts| (row.t_s, volts)));
            telemetry.yaw_rates.extend(row.gyro_z_rad_s.map(|rate| (row.t_s, rate)));
        }
        telemetry
    }
}
