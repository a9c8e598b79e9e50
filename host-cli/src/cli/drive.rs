//! The motions of `beeline drive` and `beeline record`.

use clap::{Args, Subcommand};

use super::check::{above_zero, acceleration, speed};
use crate::quantity::{Acceleration, Angle, Distance, Length, Speed};

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
