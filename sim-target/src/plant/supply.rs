//! The battery.

use serde::{Deserialize, Serialize};

use super::range_check::{ParameterError, RangeCheck};

/// The battery and its measurement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SupplyParameters {
    /// Voltage without load \[V\].
    pub open_circuit_v: f64,
    /// Resistance of cells and wires \[ohm\].
    pub resistance_ohm: f64,
    /// Current of the electronics \[A\].
    pub standby_current_a: f64,
    /// Noise of the measured voltage, standard deviation \[V\].
    pub noise_sigma_v: f64,
}

impl Default for SupplyParameters {
    fn default() -> Self {
        Self {
            open_circuit_v: 12.0,
            resistance_ohm: 0.08,
            standby_current_a: 0.15,
            noise_sigma_v: 0.02,
        }
    }
}

impl SupplyParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("open_circuit_v", self.open_circuit_v, 0.0, 100.0)?;
        check.within("resistance_ohm", self.resistance_ohm, 0.0, 10.0)?;
        check.within("standby_current_a", self.standby_current_a, 0.0, 10.0)?;
        check.within("noise_sigma_v", self.noise_sigma_v, 0.0, 5.0)
    }

    /// Bus voltage under the motors' load, where each motor i draws V g_i - e_i:
    ///
    /// ```text
    /// V = E - r (i_0 + V sum g - sum e)   =>   V = (E - r (i_0 - sum e)) / (1 + r sum g)
    /// ```
    ///
    /// A braking motor charges the battery. The bridge's diodes keep the bus from going below zero.
    #[inline]
    pub(super) fn bus_v(&self, dip_v: f64, conductance: f64, back_emf_a: f64) -> f64 {
        let r = self.resistance_ohm;
        let open_v = self.open_circuit_v - dip_v;
        let bus_v = (open_v - r * (self.standby_current_a - back_emf_a)) / (1.0 + r * conductance);
        bus_v.max(0.0)
    }
}
