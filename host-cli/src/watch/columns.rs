//! The columns of a line of telemetry.

use clap::ValueEnum;
use shared_proto::{Telemetry, WheelTelemetry};

/// A column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Column {
    /// Time since power-on.
    Time,
    /// The robot's state.
    State,
    /// Its supply.
    Supply,
    /// Position ahead of where it was at power-on.
    X,
    /// Position to the left.
    Y,
    /// Heading to the left.
    Heading,
    /// Standard deviation of the position ahead.
    XDeviation,
    /// Of the position to the left.
    YDeviation,
    /// Of the heading.
    HeadingDeviation,
    /// Speed of the left wheel.
    LeftSpeed,
    /// Of the right wheel.
    RightSpeed,
    /// Following error of the left wheel.
    LeftError,
    /// Of the right wheel.
    RightError,
    /// Duty of the left motor.
    LeftDuty,
    /// Of the right motor.
    RightDuty,
    /// Encoder count of the left wheel.
    LeftCounts,
    /// Of the right wheel.
    RightCounts,
    /// Where the left wheel should be.
    LeftSetpoint,
    /// Where the right wheel should be.
    RightSetpoint,
}

/// What is shown if nothing else was asked for: 79 characters.
pub const USUAL: [Column; 10] = [
    Column::Time,
    Column::State,
    Column::Supply,
    Column::LeftSpeed,
    Column::RightSpeed,
    Column::LeftError,
    Column::RightError,
    Column::X,
    Column::Y,
    Column::Heading,
];

impl Column {
    /// Its head and its width.
    fn head(self) -> (&'static str, usize) {
        match self {
            Self::Time => ("t s", 8),
            Self::State => ("state", 8),
            Self::Supply => ("V", 5),
            Self::X => ("x m", 7),
            Self::Y => ("y m", 7),
            Self::Heading => ("head \u{b0}", 7),
            Self::XDeviation => ("x sd mm", 7),
            Self::YDeviation => ("y sd mm", 7),
            Self::HeadingDeviation => ("head sd \u{b0}", 9),
            Self::LeftSpeed => ("L mm/s", 6),
            Self::RightSpeed => ("R mm/s", 6),
            Self::LeftError => ("L err mm", 8),
            Self::RightError => ("R err mm", 8),
            Self::LeftDuty => ("L duty %", 8),
            Self::RightDuty => ("R duty %", 8),
            Self::LeftCounts => ("L counts", 10),
            Self::RightCounts => ("R counts", 10),
            Self::LeftSetpoint => ("L goal m", 9),
            Self::RightSetpoint => ("R goal m", 9),
        }
    }

    fn cell(self, frame: &Telemetry) -> String {
        let (left, right) = (frame.wheels.left, frame.wheels.right);
        let speed = |wheel: WheelTelemetry| format!("{:.1}", f64::from(wheel.speed_um_s) * 1e-3);
        let error = |wheel: WheelTelemetry| format!("{:.3}", f64::from(wheel.error_um) * 1e-3);
        let duty = |wheel: WheelTelemetry| format!("{:.1}", f64::from(wheel.duty) / 327.67);
        let mm = |um: u32| format!("{:.2}", f64::from(um) * 1e-3);
        let m = |um: i64| format!("{:.3}", um as f64 * 1e-6);
        match self {
            Self::Time => format!("{:.3}", frame.t_us as f64 * 1e-6),
            Self::State if frame.probing => "probing".to_owned(),
            Self::State => frame.state.name().to_owned(),
            Self::Supply => format!("{:.2}", f64::from(frame.supply_mv) * 1e-3),
            Self::X => m(frame.pose.x_um),
            Self::Y => m(frame.pose.y_um),
            Self::Heading => {
                format!("{:.2}", (frame.pose.heading_urad as f64 * 1e-6).to_degrees())
            }
            Self::XDeviation => mm(frame.deviation.x_um),
            Self::YDeviation => mm(frame.deviation.y_um),
            Self::HeadingDeviation => {
                format!("{:.3}", (f64::from(frame.deviation.heading_urad) * 1e-6).to_degrees())
            }
            Self::LeftSpeed => speed(left),
            Self::RightSpeed => speed(right),
            Self::LeftError => error(left),
            Self::RightError => error(right),
            Self::LeftDuty => duty(left),
            Self::RightDuty => duty(right),
            Self::LeftCounts => left.counts.to_string(),
            Self::RightCounts => right.counts.to_string(),
            Self::LeftSetpoint => m(left.setpoint_um),
            Self::RightSetpoint => m(right.setpoint_um),
        }
    }

    fn padded(self, text: &str) -> String {
        let (_, width) = self.head();
        if self == Self::State { format!("{text:<width$}") } else { format!("{text:>width$}") }
    }

    /// The heads of these columns, as a line.
    pub fn heads(columns: &[Self]) -> String {
        joined(columns.iter().map(|column| column.padded(column.head().0)))
    }

    /// A frame as a line.
    pub fn line(columns: &[Self], frame: &Telemetry) -> String {
        joined(columns.iter().map(|column| column.padded(&column.cell(frame))))
    }
}

fn joined(cells: impl Iterator<Item = String>) -> String {
    cells.collect::<Vec<_>>().join(" ").trim_end().to_owned()
}
