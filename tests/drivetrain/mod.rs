//! The blind benchmark of the motors: robots with a hidden effect in motor, gear, driver or battery, what `explain --drivetrain`
//! says about them, and how that is judged.

pub mod case;
pub mod hidden;
pub mod score;
