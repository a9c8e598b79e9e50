//! Kinematics: where does the robot go when its wheels turn?
//!
//! | file | what it holds |
//! | --- | --- |
//! | `wheel_pair.rs` | [`WheelPair`]: a value for each wheel, left and right |
//! | `geometry.rs` | [`Geometry`]: the robot as its data sheet has it, with tolerances |
//! | `pose.rs` | [`Pose`], and dead reckoning along exact arcs |
//!
//! Nothing here knows of time, of measurements or of effects: a run is in [`crate::recording`], and what
//! makes a real robot depart from these equations in [`crate::effect`].

pub(crate) mod geometry;
pub(crate) mod pose;
pub(crate) mod wheel_pair;

pub use geometry::{Geometry, GeometryError, Limit};
pub use pose::{Pose, dead_reckon};
pub use wheel_pair::WheelPair;
