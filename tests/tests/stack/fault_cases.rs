//! What may break, and which faults may be reported then.

use shared_proto::{Fault, Wheel};
use sim_target::plant::PlantFault;

/// A name, what breaks, and the faults that may be reported.
pub type WheelCase = (&'static str, fn(Wheel) -> PlantFault, fn(Wheel) -> Vec<Fault>);

/// Faults of one wheel, and the names that each may get.
///
/// The hand that blocks a wheel stops the paper's cruise within 7 ms and two or three counts of 2 ms
/// each: at ticks of 1 ms that cannot be told from a dead wire. At the fast cruise it can.
pub const WHEEL_FAULTS: &[WheelCase] = &[
    ("encoder unplugged", PlantFault::EncoderUnplugged, |w| vec![Fault::EncoderDead(w)]),
    ("encoder reversed", PlantFault::EncoderReversed, |w| vec![Fault::EncoderReversed(w)]),
    ("wheel blocked", PlantFault::WheelBlocked, |w| vec![Fault::Stall(w), Fault::EncoderDead(w)]),
    ("encoder noise", |w| PlantFault::EncoderNoise(w, 5e4), |w| vec![Fault::CountRate(w)]),
    // As hard as can be: stopped at once.
    ("wheel jammed", PlantFault::WheelJammed, |w| vec![Fault::Stall(w), Fault::EncoderDead(w)]),
];

/// Faults of the whole robot.
pub const ROBOT_FAULTS: &[(&str, PlantFault, Fault)] = &[
    ("driver fault line", PlantFault::DriverFault, Fault::Driver),
    ("supply dip", PlantFault::SupplyDip { volts: 4.0 }, Fault::SupplyLow),
    ("emergency stop", PlantFault::EmergencyStop, Fault::EmergencyStop),
];
