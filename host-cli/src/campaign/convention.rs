//! Axes of whoever measured, that are not those of a campaign.

use std::f64::consts::FRAC_PI_2;

use robot_model::recording::{Recording, Sight};

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
}

impl Convention {
    pub(super) const ALL: [Self; 6] = [
        Self::Mirrored,
        Self::Clockwise,
        Self::Picture,
        Self::Exchanged,
        Self::FromY,
        Self::FromMinusY,
    ];

    /// Where it shows.
    pub(super) fn column(self) -> Column {
        match self {
            Self::Mirrored | Self::Picture => Column::Y,
            Self::Exchanged => Column::X,
            Self::Clockwise | Self::FromY | Self::FromMinusY => Column::Heading,
        }
    }

    /// What to do to the columns.
    pub(super) fn hint(self) -> &'static str {
        match self {
            Self::Mirrored => "the other sign of y_m (y is to the left of x)",
            Self::Clockwise => "the other sign of heading_rad (it is counter-clockwise)",
            Self::Picture => {
                "the other sign of y_m and heading_rad (y is to the left of x, headings are counter-clockwise)"
            }
            Self::Exchanged => "x_m and y_m exchanged",
            Self::FromY => "pi/2 added to heading_rad (it counts from x towards y)",
            Self::FromMinusY => "pi/2 taken off heading_rad (it counts from x towards y)",
        }
    }

    /// A pose in our axes.
    fn ours(self, sight: Sight) -> Sight {
        let with = |position: fn([f64; 2]) -> [f64; 2], heading: fn(f64) -> f64| Sight {
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
        }
    }

    /// All poses in our axes.
    pub(super) fn in_ours(self, runs: &[Recording]) -> Vec<Recording> {
        let ours = |run: &Recording| {
            let sights = run.sights.iter().map(|it| self.ours(*it)).collect();
            Recording { sights, ..run.clone() }
        };
        runs.iter().map(ours).collect()
    }
}
