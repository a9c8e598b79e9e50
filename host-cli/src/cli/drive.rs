//! The motions of `beeline drive` and `beeline record`.

use std::str::FromStr;

use clap::{Args, Subcommand};

use super::value_parsers::{above_zero, acceleration, speed, up_to_a_day};
use crate::quantity::{
    Acceleration, Angle, Distance, Length, QuantityError, Speed, Time, TurnRate,
};

/// Shape of a motion, shared by all of them.
#[derive(Args, Clone, Copy, Debug)]
pub struct ProfileArgs {
    /// Speed between the ramps, of the faster wheel: 0.2m/s, 0.523rev/s.
    #[arg(long, value_name = "SPEED", default_value = "0.523rev/s", allow_hyphen_values = true, value_parser = above_zero(speed))]
    pub cruise: Speed,
    /// Acceleration of the ramps: 0.05m/s^2, 0.101rev/s^2.
    #[arg(long, value_name = "ACCELERATION", default_value = "0.101rev/s^2", allow_hyphen_values = true, value_parser = above_zero(acceleration))]
    pub acceleration: Acceleration,
    /// Drive it even if it takes longer than ten minutes.
    #[arg(long)]
    pub long: bool,
}

/// `beeline drive ...`
#[derive(Clone, Debug, Subcommand)]
pub enum DriveArgs {
    /// A motion that ends by itself.
    #[command(flatten)]
    Motion(DriveCommand),
    /// Drive at a velocity for a time, then brake along a ramp.
    #[command(
        allow_negative_numbers = true,
        after_help = "\
Without --for the robot drives until Ctrl-C. With - for the speed, each line of standard input has two numbers, forward
speed in m/s and turn rate in rad/s; the robot drives them until the next line, for 0.5 s at most.

Examples:
  beeline drive velocity 0.2m/s --turn 30deg/s --for 5s
  my-joystick | beeline drive velocity -"
    )]
    Velocity {
        /// Forward speed, or - to read velocities from standard input.
        #[arg(value_name = "SPEED", allow_hyphen_values = true)]
        forward: VelocitySource,
        /// Turn rate, counter-clockwise positive.
        #[arg(long, value_name = "RATE", default_value = "0rad/s", allow_hyphen_values = true)]
        turn: TurnRate,
        /// Drive for this time.
        #[arg(long = "for", value_name = "TIME", allow_hyphen_values = true, value_parser = up_to_a_day)]
        duration: Option<Time>,
        /// Acceleration of the wheel whose speed changes most.
        #[arg(long, value_name = "ACCELERATION", default_value = "0.2m/s^2", allow_hyphen_values = true, value_parser = above_zero(acceleration))]
        acceleration: Acceleration,
    },
}

/// Where velocities come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VelocitySource {
    /// A constant one.
    Speed(Speed),
    /// Lines of standard input.
    Stdin,
}

impl FromStr for VelocitySource {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        if text == "-" { Ok(Self::Stdin) } else { text.parse().map(Self::Speed) }
    }
}

/// A motion of `beeline drive` and `beeline record`.
#[derive(Clone, Debug, Subcommand)]
pub enum DriveCommand {
    /// Drive straight; a negative distance goes backwards.
    #[command(
        allow_negative_numbers = true,
        after_help = "Examples:\n  beeline drive straight -50cm --cruise 0.3m/s\n  beeline record my-robot straight 8rev"
    )]
    Straight {
        /// How far: 1.8m, 8rev (turns of a wheel).
        #[arg(allow_hyphen_values = true)]
        distance: Distance,
        /// Shape of the motion.
        #[command(flatten)]
        profile: ProfileArgs,
    },
    /// Turn on the spot; positive is counter-clockwise.
    #[command(
        after_help = "Examples:\n  beeline drive spin -360deg --cruise 0.2m/s\n  beeline record my-robot spin 360deg --name spin_left"
    )]
    Spin {
        /// How far: 90deg, -1rev (turns of the robot).
        #[arg(allow_hyphen_values = true)]
        angle: Angle,
        /// Shape of the motion.
        #[command(flatten)]
        profile: ProfileArgs,
    },
    /// Drive an arc; positive angles turn left, a negative radius drives the same circle backwards,
    /// so that the robot turns the other way.
    #[command(
        after_help = "Examples:\n  beeline drive arc 1m 90deg\n  beeline record my-robot arc 50cm -300deg"
    )]
    Arc {
        /// Radius of the circle that the robot's centre drives.
        #[arg(allow_hyphen_values = true)]
        radius: Length,
        /// How far the robot turns.
        #[arg(allow_hyphen_values = true)]
        angle: Angle,
        /// Shape of the motion.
        #[command(flatten)]
        profile: ProfileArgs,
    },
}
