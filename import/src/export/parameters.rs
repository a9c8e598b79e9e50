//! The files of the programs: each has its own names.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use campaign::RobotFile;

use super::controller::{Controller, PUBLISH_HZ};
use super::target::{Target, counts_per_turn, linorobot2};
use crate::geometry::Geometry;

/// The variances of what is not measured: z, roll, pitch.
const UNKNOWN: &str = "1000000.0, 1000000.0, 1000000.0";
/// Counts of a pulse in WPILib, which takes the pulses of the encoder's data sheet, and counts all four edges.
const COUNTS_PER_PULSE: f64 = 4.0;

impl Controller {
    /// The file of its program.
    pub fn file(&self, robot: &RobotFile) -> String {
        match self.target {
            Target::DiffDrive => diff_drive(self, &robot.name),
            Target::TurtleBot3 => turtlebot3(self, &robot.name),
            Target::Linorobot2 => linorobot2_header(self, robot),
            Target::Wpilib => wpilib(self, robot),
        }
    }
}

/// A text from outside as part of a comment, which ends with its line. Java reads `\u000a` as the end of a line even in a
/// comment, and C continues a line after a backslash at its end: none is left.
fn in_comment(text: &str) -> String {
    let plain = |c: char| match c {
        '\\' => Some('/'),
        // The last ones turn round the order in which the rest is shown.
        '\u{2028}'
        | '\u{2029}'
        | '\u{61c}'
        | '\u{200b}'..='\u{200f}'
        | '\u{202a}'..='\u{202e}'
        | '\u{2060}'..='\u{206f}'
        | '\u{feff}' => None,
        c => (!c.is_control()).then_some(c),
    };
    text.chars().filter_map(plain).collect()
}

/// What the first lines of a file say: whose it is, how good it is, and what it lacks.
fn head(controller: &Controller, comment: &str, robot: &str) -> String {
    let mm = |m: f64| m * 1e3;
    let [nominal, errors] = controller.errors.map(|errors| mm(errors.fitted.position_rms_m));
    let robot = in_comment(robot);
    let mut head = format!(
        "{comment} {}, from a campaign of: {robot}\n\
         {comment} error of the odometry, root mean square: {nominal:.1} mm with the nominal numbers, {errors:.1} mm with these\n",
        controller.target.name()
    );
    if let Some(cost) = &controller.cost {
        let [own, whole] = cost.position_m.map(mm);
        let what = cost.effects.join(", ");
        let _ = writeln!(
            head,
            "{comment} not expressible: {what}; this costs {:.1} mm ({own:.1} mm instead of {whole:.1} mm)",
            own - whole
        );
    }
    head
}

fn diff_drive(controller: &Controller, robot: &str) -> String {
    let head = head(controller, "#", robot);
    let Geometry { wheel_radius_m, radius_multipliers: [left, right], .. } = controller.geometry;
    let Geometry { wheel_separation_m, separation_multiplier, .. } = controller.geometry;
    let ([pose, heading], [speed, rate]) = (controller.pose_variances, controller.twist_variances);
    format!(
        "{head}\
         diff_drive_controller:\n  ros__parameters:\n    \
         wheel_separation: {wheel_separation_m:.6}\n    wheel_separation_multiplier: {separation_multiplier:.6}\n    \
         wheel_radius: {wheel_radius_m:.6}\n    left_wheel_radius_multiplier: {left:.6}\n    right_wheel_radius_multiplier: {right:.6}\n    \
         # x, y, z, roll, pitch, yaw: of the pose within a run like those of the campaign, and of one message at {PUBLISH_HZ:.0} Hz\n    \
         pose_covariance_diagonal: [{pose:.3e}, {pose:.3e}, {UNKNOWN}, {heading:.3e}]\n    \
         twist_covariance_diagonal: [{speed:.3e}, {speed:.3e}, {UNKNOWN}, {rate:.3e}]\n"
    )
}

fn turtlebot3(controller: &Controller, robot: &str) -> String {
    let head = head(controller, "#", robot);
    // Both are the same.
    let [radius_m, _] = controller.geometry.radii_m();
    format!(
        "{head}\
         # With odometry.use_imu: true the gyro alone turns the odometry, and the separation has no part in it.\n\
         turtlebot3_node:\n  ros__parameters:\n    wheels:\n      \
         separation: {:.6}\n      radius: {radius_m:.6}\n",
        controller.geometry.track_width_m()
    )
}

fn linorobot2_header(controller: &Controller, robot: &RobotFile) -> String {
    let mut header = head(controller, "//", &robot.name);
    let radii_m = controller.exact.radii_m();
    header.push_str("// config/lino_base_config.h, or your own of config/custom; motor 1 is the left one, motor 2 the right one\n");
    let diameter_m = match counts_per_turn(robot) {
        Some(counts) => {
            let (diameter_m, [left, right]) = linorobot2(&controller.exact, counts);
            let _ = write!(
                header,
                "#define COUNTS_PER_REV1 {left:.0}\n#define COUNTS_PER_REV2 {right:.0}\n"
            );
            diameter_m
        }
        None => {
            let mean_m = (radii_m[0] + radii_m[1]) / 2.0;
            let [left, right] = radii_m.map(|radius_m| mean_m / radius_m);
            let _ = writeln!(
                header,
                "// this campaign knows no counts: multiply COUNTS_PER_REV1 by {left:.6} and COUNTS_PER_REV2 by {right:.6}, and round"
            );
            2.0 * mean_m
        }
    };
    let _ = write!(
        header,
        "#define WHEEL_DIAMETER {diameter_m:.6}\n#define LR_WHEELS_DISTANCE {:.6}\n",
        controller.geometry.track_width_m()
    );
    header
}

fn wpilib(controller: &Controller, robot: &RobotFile) -> String {
    let mut java = head(controller, "//", &robot.name);
    java.push_str(
        "// The odometry takes its heading from the gyro; the track width serves kinematics and feedforward.\n\
         public final class DriveConstants {\n",
    );
    let radii_m = controller.geometry.radii_m();
    let mut constant = |name: &str, value_m: f64| {
        let _ = writeln!(java, "    public static final double {name} = {value_m:.9};");
    };
    constant("kTrackwidthMeters", controller.geometry.track_width_m());
    constant("kWheelDiameterMeters", radii_m[0] + radii_m[1]);
    let sides = ["Left", "Right"].into_iter().zip(radii_m);
    match counts_per_turn(robot) {
        Some(counts) => {
            for (side, radius_m) in sides {
                let per_pulse_m = TAU * radius_m * COUNTS_PER_PULSE / counts;
                constant(&format!("k{side}EncoderDistancePerPulse"), per_pulse_m);
            }
        }
        None => {
            for (side, radius_m) in sides {
                constant(&format!("k{side}MetersPerWheelTurn"), TAU * radius_m);
            }
            java.push_str("    // this campaign knows no counts: divide these by the pulses per turn of the wheel for setDistancePerPulse\n");
        }
    }
    java.push_str("}\n");
    java
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_stays_in_its_comment_in_every_language() {
        let name = "bot \\u000aclass Pwn {} \r\n\u{2028}#include\\";
        assert_eq!(in_comment(name), "bot /u000aclass Pwn {} #include/");
        assert_eq!(in_comment("C:\\users bot"), "C:/users bot");
    }
}
