//! Errors of the angle that an encoder reads: an eccentric disc, a magnet that is not a dipole, uneven gear
//! teeth.

use core::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::range_check::{ParameterError, RangeCheck};

/// Errors of one encoder's reading that repeat with its shaft or its gear.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AngleErrorParameters {
    /// Distance between the disc's centre and its shaft, as a share of its radius, e.
    pub eccentricity: f64,
    /// Encoder angle at which the reading runs fastest \[rad\].
    pub eccentricity_phase_rad: f64,
    /// Amplitude of an error that comes twice per encoder turn, as of a magnet that is not round \[rad\].
    pub two_per_turn_rad: f64,
    /// Encoder angle at which that error passes upwards through zero \[rad\].
    pub two_per_turn_phase_rad: f64,
    /// Amplitude of the error of a gear between encoder and wheel, as wheel angle \[rad\].
    pub mesh_rad: f64,
    /// Periods of that error per turn of the wheel: the gear's teeth.
    pub mesh_teeth: f64,
}

impl Default for AngleErrorParameters {
    fn default() -> Self {
        Self {
            eccentricity: 0.0,
            eccentricity_phase_rad: 0.0,
            two_per_turn_rad: 0.0,
            two_per_turn_phase_rad: 0.0,
            mesh_rad: 0.0,
            mesh_teeth: 24.0,
        }
    }
}

impl AngleErrorParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("eccentricity", self.eccentricity, 0.0, 0.2)?;
        check.within("eccentricity_phase_rad", self.eccentricity_phase_rad, -7.0, 7.0)?;
        check.within("two_per_turn_rad", self.two_per_turn_rad, 0.0, 0.2)?;
        check.within("two_per_turn_phase_rad", self.two_per_turn_phase_rad, -7.0, 7.0)?;
        check.within("mesh_rad", self.mesh_rad, 0.0, 0.1)?;
        check.within("mesh_teeth", self.mesh_teeth, 1.0, 1000.0)
    }
}

/// With the encoder's angle psi = r phi, r the gear reduction, the head of a disc whose centre is off by e radii reads
///
/// ```text
/// psi + e sin(psi - psi_1)                        (1)  to first order in e
///     + A sin(2 (psi - psi_2))                    (2)  a magnet with a second pole pair
/// phi + M sin(n phi)                              (3)  n teeth
/// ```
///
/// All three are zero at phi = 0: the counter starts at zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct AngleError {
    parameters: AngleErrorParameters,
    gear_reduction: f64,
    at_zero_rad: f64,
}

impl AngleError {
    /// None for an encoder without angle error.
    pub fn new(parameters: &AngleErrorParameters, gear_reduction: f64) -> Option<Self> {
        let AngleErrorParameters { eccentricity, two_per_turn_rad, mesh_rad, .. } = *parameters;
        if eccentricity == 0.0 && two_per_turn_rad == 0.0 && mesh_rad == 0.0 {
            return None;
        }
        let mut error = Self { parameters: *parameters, gear_reduction, at_zero_rad: 0.0 };
        error.at_zero_rad = error.at(0.0);
        Some(error)
    }

    /// Error of the reading, as wheel angle \[rad\].
    #[inline]
    pub fn at(&self, angle_rad: f64) -> f64 {
        let p = &self.parameters;
        // Whole turns taken off first: a long way costs no digits.
        let psi = (angle_rad * self.gear_reduction) % TAU;
        let disc = p.eccentricity * (psi - p.eccentricity_phase_rad).sin(); // (1)
        let magnet = p.two_per_turn_rad * (2.0 * (psi - p.two_per_turn_phase_rad)).sin(); // (2)
        let mesh = p.mesh_rad * ((angle_rad * p.mesh_teeth) % TAU).sin(); // (3)
        (disc + magnet) / self.gear_reduction + mesh - self.at_zero_rad
    }
}
