//! Instruments that measure the robot: an overhead camera, a ruler, and a gyro on board.
//!
//! The start line is the x axis unless a run begins elsewhere. The robot's start heading differs from the
//! start line by a random placement error, which no instrument measures. The camera measures in the floor's
//! frame; the ruler measures from a line.

mod camera;
mod camera_sample;
mod dropped_pictures;
mod gyro;
mod lens;
mod ruler;

pub use camera::{Camera, CameraParameters};
pub use camera_sample::CameraSample;
pub use dropped_pictures::StaleParameters;
pub use gyro::{Gyro, GyroParameters, GyroSample};
pub use lens::{LensParameters, MarkerParameters};
pub use ruler::{EndReading, Ruler, RulerParameters, TangentReading};
