//! What measures the robot: an overhead camera, a ruler, and a gyro on board.
//!
//! The start line is the line that somebody put the robot on, the x axis unless a run begins elsewhere. The
//! robot's own start heading differs from it by what the placement drew, and no instrument tells by how
//! much. The camera sees the floor's frame; the ruler measures from a line.

mod camera;
mod camera_sample;
mod gyro;
mod lens;
mod ruler;
mod stale;

pub use camera::{Camera, CameraParameters};
pub use camera_sample::CameraSample;
pub use gyro::{Gyro, GyroParameters, GyroSample};
pub use lens::{LensParameters, MarkerParameters};
pub use ruler::{EndReading, Ruler, RulerParameters, TangentReading};
pub use stale::StaleParameters;
