//! Which axis conventions other than the campaign's measured poses may follow.
//!
//! Whether a recording follows one of them is found in `checks`.

use std::f64::consts::FRAC_PI_2;
use std::fmt;

use robot_model::recording::{PoseMeasurement, Recording};

use super::Column;

/// A convention for poses that differs from the campaign's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convention {
    /// y is to the right of x.
    Mirrored,
    /// Headings count clockwise.
    Clockwise,
    /// Both: y points down, as in a picture.
    Picture,
    /// The columns x and y are exchanged.
    Exchanged,
    /// Headings count from the y axis.
    FromY,
    /// Headings count from the negative y axis.
    FromMinusY,
    /// Headings count from the y axis, clockwise, as a compass does.
    Compass,
    /// As a compass does, with the columns x and y exchanged.
    NorthEast,
    /// The axes are a quarter turn to the right of ours.
    QuarterRight,
    /// The axes are a quarter turn to the left of ours.
    QuarterLeft,
}

impl Convention {
    pub(super) const ALL: [Self; 10] = [
        Self::Mirrored,
        Self::Clockwise,
        Self::Picture,
        Self::Exchanged,
        Self::FromY,
        Self::FromMinusY,
        Self::Compass,
        Self::NorthEast,
        Self::QuarterRight,
        Self::QuarterLeft,
    ];

    /// The column in which it shows.
    pub(super) fn column(self) -> Column {
        match self {
            Self::Mirrored | Self::Picture => Column::Y,
            Self::Exchanged | Self::NorthEast | Self::QuarterRight | Self::QuarterLeft => Column::X,
            Self::Clockwise | Self::FromY | Self::FromMinusY | Self::Compass => Column::Heading,
        }
    }

    /// How to change the columns.
    fn hint(self) -> &'static str {
        match self {
            Self::Mirrored => "the other sign of y_m (y is to the left of x)",
            Self::Clockwise => "the other sign of heading_rad (it is counter-clockwise)",
            Self::Picture => {
                "the other sign of y_m and heading_rad (y is to the left of x, headings are counter-clockwise)"
            }
            Self::Exchanged => "x_m and y_m swapped",
            Self::FromY => "pi/2 added to heading_rad (it counts from x towards y)",
            Self::FromMinusY => "pi/2 subtracted from heading_rad (it counts from x towards y)",
            Self::Compass => {
                "pi/2 - heading_rad in place of heading_rad (it counts from x towards y)"
            }
            Self::NorthEast => {
                "x_m and y_m swapped and pi/2 - heading_rad in place of heading_rad (it counts from x towards y)"
            }
            Self::QuarterRight => {
                "-y_m in place of x_m, x_m in place of y_m and pi/2 added to heading_rad (axes as the campaign's)"
            }
            Self::QuarterLeft => {
                "y_m in place of x_m, -x_m in place of y_m and pi/2 subtracted from heading_rad (axes as the campaign's)"
            }
        }
    }

    /// A pose in our axes.
    fn ours(self, pose: PoseMeasurement) -> PoseMeasurement {
        let with = |position: fn([f64; 2]) -> [f64; 2], heading: fn(f64) -> f64| PoseMeasurement {
            position_m: pose.position_m.map(position),
            heading_rad: pose.heading_rad.map(heading),
            ..pose
        };
        match self {
            Self::Mirrored => with(|[x, y]| [x, -y], |heading| heading),
            Self::Clockwise => with(|position| position, |heading| -heading),
            Self::Picture => with(|[x, y]| [x, -y], |heading| -heading),
            Self::Exchanged => with(|[x, y]| [y, x], |heading| heading),
            Self::FromY => with(|position| position, |heading| heading + FRAC_PI_2),
            Self::FromMinusY => with(|position| position, |heading| heading - FRAC_PI_2),
            Self::Compass => with(|position| position, |heading| FRAC_PI_2 - heading),
            Self::NorthEast => with(|[x, y]| [y, x], |heading| FRAC_PI_2 - heading),
            Self::QuarterRight => with(|[x, y]| [-y, x], |heading| heading + FRAC_PI_2),
            Self::QuarterLeft => with(|[x, y]| [y, -x], |heading| heading - FRAC_PI_2),
        }
    }
}

/// Which poses follow another convention.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OtherConvention {
    /// The convention.
    pub convention: Convention,
    /// Only the poses after the first of each run: the first is a mark on the floor, and was not
    /// measured.
    pub ends_only: bool,
}

impl OtherConvention {
    /// All runs, with these poses in our axes.
    pub(super) fn in_ours(self, runs: &[Recording]) -> Vec<Recording> {
        let ours = |run: &Recording| {
            let first = usize::from(self.ends_only);
            let poses = run.measured_poses.iter().enumerate();
            let ours = |(k, pose): (usize, &PoseMeasurement)| {
                if k < first { *pose } else { self.convention.ours(*pose) }
            };
            Recording { measured_poses: poses.map(ours).collect(), ..run.clone() }
        };
        runs.iter().map(ours).collect()
    }
}

impl fmt::Display for OtherConvention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.convention.hint())?;
        if self.ends_only {
            f.write_str(", in all poses except the first of each run")
        } else {
            Ok(())
        }
    }
}
