//! A fault in words.

use std::fmt;

use shared_proto::{Fault, FaultReport};

/// A fault in words: its name, its time, and the numbers that tell about it.
pub struct FaultInWords<'a>(pub &'a FaultReport);

impl fmt::Display for FaultInWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FaultReport { fault, t_us, wheels, supply_mv, .. } = self.0;
        write!(f, "{fault} at {:.3} s", *t_us as f64 * 1e-6)?;
        let supply_v = f64::from(*supply_mv) * 1e-3;
        match (fault, fault.wheel()) {
            // The encoder check ends at rest and without a duty: its figures say nothing.
            (Fault::NoResponse(_), Some(wheel)) if wheels.get(wheel).duty == 0 => {
                write!(f, " (in the encoder check, supply {supply_v:.1} V)")
            }
            (_, Some(wheel)) => {
                let wheel = wheels.get(wheel);
                write!(
                    f,
                    " ({:.1} mm from its setpoint, at {:.3} m/s, duty {:.2}, supply {supply_v:.1} V)",
                    f64::from(wheel.error_um.unsigned_abs()) * 1e-3,
                    f64::from(wheel.speed_um_s) * 1e-6,
                    f64::from(wheel.duty) / f64::from(i16::MAX),
                )
            }
            (Fault::SupplyLow | Fault::SupplyHigh | Fault::Driver, None) => {
                write!(f, " (supply {supply_v:.1} V)")
            }
            (_, None) => Ok(()),
        }
    }
}
