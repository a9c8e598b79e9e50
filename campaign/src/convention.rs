//! Axes of whoever measured, that are not those of a campaign.

use std::f64::consts::FRAC_PI_2;
use std::fmt;

use robot_model::recording::{PoseMeasurement, Recording};

use super::Column;

/// How the poses of all runs may be meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convention {
    /// y is to the right of x.
    Mirrored,
    /// Headings count clockwise.
    Clockwise,
    /// Both: y goes down, as in a picture.
    Picture,
    /// x stands under y, and y under x.
    Exchanged,
    /// Headings count from the y axis.
    FromY,
    /// Headings count from the axis against y.
    FromMinusY,
    /// Headings count from the y axis, clockwise, as a compass does.
    Compass,
    /// That, and x stands under y, and y under x.
    NorthEast,
    /// All is seen from axes that are a quarter of a turn to the right of ours.
    QuarterRight,
    /// The same, to the left.
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

    /// Where it shows.
    pub(super) fn column(self) -> Column {
        match self {
            Self::Mirrored | Self::Picture => Column::Y,
            Self::Exchanged | Self::NorthEast | Self::QuarterRight | Self::QuarterLeft => Column::X,
            Self::Clockwise | Self::FromY | Self::FromMinusY | Self::Compass => Column::Heading,
        }
    }

    /// What to do to the columns.
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
    fn ours(self, sight: PoseMeasurement) -> PoseMeasurement {
        let with = |position: fn([f64; 2]) -> [f64; 2], heading: fn(f64) -> f64| PoseMeasurement {
            position_m: sight.position_m.map(position),
            heading_rad: sight.heading_rad.map(heading),
            ..sight
        };
        match self {
            Self::Mirrored => with(|[x, y]| [x, -y], |it| it),
            Self::Clockwise => with(|it| it, |it| -it),
            Self::Picture => with(|[x, y]| [x, -y], |it| -it),
            Self::Exchanged => with(|[x, y]| [y, x], |it| it),
            Self::FromY => with(|it| it, |it| it + FRAC_PI_2),
            Self::FromMinusY => with(|it| it, |it| it - FRAC_PI_2),
            Self::Compass => with(|it| it, |it| FRAC_PI_2 - it),
            Self::NorthEast => with(|[x, y]| [y, x], |it| FRAC_PI_2 - it),
            Self::QuarterRight => with(|[x, y]| [-y, x], |it| it + FRAC_PI_2),
            Self::QuarterLeft => with(|[x, y]| [y, -x], |it| it - FRAC_PI_2),
        }
    }
}

/// What is meant otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meant {
    /// How.
    pub convention: Convention,
    /// All poses but the first of each run: that one is a mark, and was not read.
    pub ends_only: bool,
}

impl Meant {
    /// All runs in our axes.
    pub(super) fn in_ours(self, runs: &[Recording]) -> Vec<Recording> {
        let ours = |run: &Recording| {
            let first = usize::from(self.ends_only);
            let sights = run.measured_poses.iter().enumerate();
            let ours = |(k, it): (usize, &PoseMeasurement)| {
                if k < first { *it } else { self.convention.ours(*it) }
            };
            Recording { measured_poses: sights.map(ours).collect(), ..run.clone() }
        };
        runs.iter().map(ours).collect()
    }
}

impl fmt::Display for Meant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.convention.hint())?;
        if self.ends_only {
            f.write_str(", in all poses except the first of each run")
        } else {
            Ok(())
        }
    }
}
