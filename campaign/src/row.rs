//! One sample of a run, and the columns that it has in a file.

use shared_proto::WheelPair;

/// One sample. `None` means "not measured at this time".
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Time, strictly increasing \[s\].
    pub t_s: f64,
    /// Cumulative encoder counts, any start value.
    pub counts: WheelPair<Option<f64>>,
    /// Applied motor duty, -1 to 1.
    pub duty: WheelPair<Option<f64>>,
    /// Supply voltage \[V\].
    pub bus_v: Option<f64>,
    /// Mean voltage at the motors since the row before that has one \[V\].
    pub applied_v: WheelPair<Option<f64>>,
    /// Measured x in a fixed frame \[m\].
    pub x_m: Option<f64>,
    /// Measured y in a fixed frame \[m\].
    pub y_m: Option<f64>,
    /// Measured heading, wrapped or not \[rad\].
    pub heading_rad: Option<f64>,
    /// Yaw rate sensor \[rad/s\].
    pub gyro_z_rad_s: Option<f64>,
    /// Motor currents \[A\].
    pub current_a: WheelPair<Option<f64>>,
}

/// One column of a run file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are the columns' names, explained at `Row`")]
pub enum Column {
    Time,
    LeftCounts,
    RightCounts,
    LeftDuty,
    RightDuty,
    BusV,
    LeftV,
    RightV,
    X,
    Y,
    Heading,
    GyroZ,
    LeftCurrent,
    RightCurrent,
}

impl Column {
    /// All columns, in the order in which they are written.
    pub const ALL: [Column; 14] = [
        Column::Time,
        Column::LeftCounts,
        Column::RightCounts,
        Column::LeftDuty,
        Column::RightDuty,
        Column::BusV,
        Column::LeftV,
        Column::RightV,
        Column::X,
        Column::Y,
        Column::Heading,
        Column::GyroZ,
        Column::LeftCurrent,
        Column::RightCurrent,
    ];

    /// The columns that every run file has.
    pub const REQUIRED: [Column; 3] = [Column::Time, Column::LeftCounts, Column::RightCounts];

    /// The name in the header.
    pub const fn name(self) -> &'static str {
        match self {
            Column::Time => "t_s",
            Column::LeftCounts => "left_counts",
            Column::RightCounts => "right_counts",
            Column::LeftDuty => "left_duty",
            Column::RightDuty => "right_duty",
            Column::BusV => "bus_v",
            Column::LeftV => "left_v",
            Column::RightV => "right_v",
            Column::X => "x_m",
            Column::Y => "y_m",
            Column::Heading => "heading_rad",
            Column::GyroZ => "gyro_z_rad_s",
            Column::LeftCurrent => "left_current_a",
            Column::RightCurrent => "right_current_a",
        }
    }

    /// The column of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|column| column.name() == name)
    }
}

impl Row {
    /// The value of the row in a column.
    pub fn get(&self, column: Column) -> Option<f64> {
        match column {
            Column::Time => Some(self.t_s),
            Column::LeftCounts => self.counts.left,
            Column::RightCounts => self.counts.right,
            Column::LeftDuty => self.duty.left,
            Column::RightDuty => self.duty.right,
            Column::BusV => self.bus_v,
            Column::LeftV => self.applied_v.left,
            Column::RightV => self.applied_v.right,
            Column::X => self.x_m,
            Column::Y => self.y_m,
            Column::Heading => self.heading_rad,
            Column::GyroZ => self.gyro_z_rad_s,
            Column::LeftCurrent => self.current_a.left,
            Column::RightCurrent => self.current_a.right,
        }
    }

    /// Sets the value in a column; a time that is missing leaves the old one.
    pub fn set(&mut self, column: Column, value: Option<f64>) {
        match column {
            Column::Time => self.t_s = value.unwrap_or(self.t_s),
            Column::LeftCounts => self.counts.left = value,
            Column::RightCounts => self.counts.right = value,
            Column::LeftDuty => self.duty.left = value,
            Column::RightDuty => self.duty.right = value,
            Column::BusV => self.bus_v = value,
            Column::LeftV => self.applied_v.left = value,
            Column::RightV => self.applied_v.right = value,
            Column::X => self.x_m = value,
            Column::Y => self.y_m = value,
            Column::Heading => self.heading_rad = value,
            Column::GyroZ => self.gyro_z_rad_s = value,
            Column::LeftCurrent => self.current_a.left = value,
            Column::RightCurrent => self.current_a.right = value,
        }
    }
}

impl Column {
    /// A value as text: more digits than are significant, and the same on every machine.
    pub(super) fn format(self, value: f64) -> String {
        let decimals = match self {
            // A microsecond; a tenth of a micrometre and of a microradian.
            Column::Time => 6,
            Column::X | Column::Y | Column::Heading => 7,
            Column::GyroZ => 6,
            Column::LeftDuty | Column::RightDuty => 6,
            // Summed up over a run.
            Column::LeftV | Column::RightV => 6,
            Column::BusV | Column::LeftCurrent | Column::RightCurrent => 4,
            // Shortest exact text: whole counts stay whole. Adding zero turns -0 into 0.
            Column::LeftCounts | Column::RightCounts => return format!("{}", value + 0.0),
        };
        let text = format!("{value:.decimals$}");
        // No "-0.000000".
        match text.strip_prefix('-') {
            Some(rest) if rest.bytes().all(|byte| byte == b'0' || byte == b'.') => rest.to_owned(),
            _ => text,
        }
    }
}
