//! What measures the robot from outside: an overhead camera and a ruler.
//!
//! The start line is the line that somebody put the robot on, the x axis unless a run begins elsewhere. The
//! robot's own start heading differs from it by what the placement drew, and no instrument tells by how
//! much. The camera sees the floor's frame; the ruler measures from a line.

mod camera;
mod ruler;

pub use camera::{Camera, CameraParameters, CameraSample};
pub use ruler::{EndReading, Ruler, RulerParameters, TangentReading};
