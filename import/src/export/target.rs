//! The programs that take a robot's numbers, each with its own limits.
//!
//! | program | numbers | file |
//! | --- | --- | --- |
//! | ROS 2 `diff_drive_controller` | both radii, track width | parameters (YAML) |
//! | TurtleBot3 `turtlebot3_node` | one radius, track width | parameters (YAML) |
//! | linorobot2 | diameter, track width, whole counts of each wheel | a header |
//! | WPILib | track width, distance per pulse of each side | Java constants |

use campaign::RobotFile;

use crate::geometry::Geometry;

/// The effects that equation (1) of [`geometry`](crate::geometry) can express: scale and ratio of the radii, and the track
/// width.
pub(super) const EFFECTS: [&str; 3] = ["wheel_radius_scale", "wheel_radius_ratio", "track_width"];

/// A program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// ROS 2's `diff_drive_controller`.
    DiffDrive,
    /// TurtleBot3's `turtlebot3_node`.
    TurtleBot3,
    /// The firmware of linorobot2.
    Linorobot2,
    /// WPILib.
    Wpilib,
}

impl Target {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DiffDrive => "diff_drive_controller",
            Self::TurtleBot3 => "turtlebot3_node",
            Self::Linorobot2 => "linorobot2",
            Self::Wpilib => "WPILib",
        }
    }

    /// The effects that its numbers can be.
    pub(super) fn effects(self) -> &'static [&'static str] {
        const ONE_RADIUS: [&str; 2] = [EFFECTS[0], EFFECTS[2]];
        match self {
            Self::TurtleBot3 => &ONE_RADIUS,
            Self::DiffDrive | Self::Linorobot2 | Self::Wpilib => &EFFECTS,
        }
    }

    /// The numbers as it can have them.
    pub(super) fn rounded(self, exact: &Geometry, robot: &RobotFile) -> Geometry {
        let (Self::Linorobot2, Some(counts)) = (self, counts_per_turn(robot)) else {
            return *exact;
        };
        let (diameter_m, counts_of) = linorobot2(exact, counts);
        let radius =
            |side: usize| diameter_m / 2.0 * counts / counts_of[side] / exact.wheel_radius_m;
        Geometry { radius_multipliers: [radius(0), radius(1)], ..*exact }
    }
}

/// Counts per turn of a wheel. A campaign that was imported from angles knows none.
pub(super) fn counts_per_turn(robot: &RobotFile) -> Option<f64> {
    let counts = robot.counts_per_rev;
    let is_whole = (counts - counts.round()).abs() < 1e-6 * counts;
    is_whole.then_some(counts * robot.gear_reduction)
}

/// The diameter, and the whole counts of each wheel, which are all that can differ between both.
pub(super) fn linorobot2(geometry: &Geometry, counts: f64) -> (f64, [f64; 2]) {
    let radii_m = geometry.radii_m();
    let mean_m = (radii_m[0] + radii_m[1]) / 2.0;
    // Of a smaller wheel more counts make a turn of the common diameter.
    let counts_of = radii_m.map(|radius_m| (counts * mean_m / radius_m).round().max(1.0));
    // What rounding does to both alike, the diameter takes out.
    let diameter_m = (radii_m[0] * counts_of[0] + radii_m[1] * counts_of[1]) / counts;
    (diameter_m, counts_of)
}
