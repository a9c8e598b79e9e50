//! The contact between a driven wheel and the floor.

use serde::{Deserialize, Serialize};

use super::range_check::{ParameterError, RangeCheck};

/// The tyres of the driven wheels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TyreParameters {
    /// Force per deflection along the rolling direction, k_x \[N/m\].
    pub longitudinal_stiffness_n_per_m: f64,
    /// Force per deflection across the rolling direction, k_y \[N/m\].
    pub lateral_stiffness_n_per_m: f64,
    /// Distance rolled in which a deflection fades to 1/e: about the contact's length, sigma \[m\].
    pub relaxation_length_m: f64,
    /// Force per deflection rate, either way, c \[N s/m\].
    pub damping_ns_per_m: f64,
    /// Rolling resistance as a share of the load.
    pub rolling_resistance: f64,
    /// Width over which the tread touches the floor; 0 for a point \[m\].
    pub contact_width_m: f64,
    /// Speed at which the contact creeps sideways under a force, rolling or not, as on a film of
    /// oil \[(m/s)/N\].
    pub lateral_creep_mps_per_n: f64,
}

impl Default for TyreParameters {
    /// A narrow rubber ring: 0.5 % of slip carries about as much as a twelfth of the load.
    fn default() -> Self {
        Self {
            longitudinal_stiffness_n_per_m: 20_000.0,
            lateral_stiffness_n_per_m: 12_000.0,
            relaxation_length_m: 0.012,
            damping_ns_per_m: 40.0,
            rolling_resistance: 0.012,
            contact_width_m: 0.0,
            lateral_creep_mps_per_n: 0.0,
        }
    }
}

impl TyreParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        let (long, lat) = (self.longitudinal_stiffness_n_per_m, self.lateral_stiffness_n_per_m);
        check.within("longitudinal_stiffness_n_per_m", long, 100.0, 1e7)?;
        check.within("lateral_stiffness_n_per_m", lat, 100.0, 1e7)?;
        check.within("relaxation_length_m", self.relaxation_length_m, 1e-4, 1.0)?;
        check.within("damping_ns_per_m", self.damping_ns_per_m, 0.0, 1e4)?;
        check.within("rolling_resistance", self.rolling_resistance, 0.0, 0.3)?;
        check.within("contact_width_m", self.contact_width_m, 0.0, 0.5)?;
        check.within("lateral_creep_mps_per_n", self.lateral_creep_mps_per_n, 0.0, 1.0)
    }

    /// True for a contact that is a point and does not creep.
    pub(super) fn is_ideal(&self) -> bool {
        self.contact_width_m == 0.0 && self.lateral_creep_mps_per_n == 0.0
    }
}

/// One tyre's contact patch: bristles that stick to the floor, bend, and slide when bent too far.
///
/// With the slip velocity s (tread relative to floor), the bristles' deflection z follows
///
/// ```text
/// dz/dt = s - |R w| z / sigma                     (1)  fresh bristles enter as the wheel rolls
/// F     = k z + c dz/dt,  |F| <= mu N             (2)  on the robot, along the slip
/// |k z| <= mu N                                   (3)  beyond that they slide
/// ```
///
/// At a steady slip ratio kappa = s/|R w| this is F = k sigma kappa, the usual slip stiffness. At zero
/// speed the contact is a spring, so a robot at rest stays in place: no equation divides by a speed.
/// Source: the stretched-string single contact point model, Pacejka, Tire and Vehicle Dynamics, ch. 7.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    /// Deflection forward and to the left \[m\].
    deflection_m: (f64, f64),
    /// Force on the wheel, forward and to the left \[N\].
    pub force_n: (f64, f64),
}

impl Contact {
    /// Advances by h, at a slip velocity and a rolling speed |R w|, under the grip mu N.
    #[inline]
    pub fn advance(
        &mut self,
        tyre: &TyreParameters,
        slip_mps: (f64, f64),
        rolling_mps: f64,
        grip_n: f64,
        h_s: f64,
    ) {
        let fade = 0.5 * h_s * rolling_mps / tyre.relaxation_length_m;
        self.advance_fading(tyre, slip_mps, (fade, fade), grip_n, h_s);
    }

    /// As [`advance`](Self::advance), with half the share of the deflection that fades in this step,
    /// forward and to the left.
    #[inline]
    pub fn advance_fading(
        &mut self,
        tyre: &TyreParameters,
        slip_mps: (f64, f64),
        (fade_x, fade_y): (f64, f64),
        grip_n: f64,
        h_s: f64,
    ) {
        let (kx, ky) = (tyre.longitudinal_stiffness_n_per_m, tyre.lateral_stiffness_n_per_m);
        let before = self.deflection_m;
        // (1), by the trapezoidal rule.
        let zx = (before.0 * (1.0 - fade_x) + slip_mps.0 * h_s) * (1.0 / (1.0 + fade_x));
        let zy = (before.1 * (1.0 - fade_y) + slip_mps.1 * h_s) * (1.0 / (1.0 + fade_y));
        let slide = grip_share(kx * zx, ky * zy, grip_n);
        if slide < 1.0 {
            // (3). No damping here: the bristles' ends follow the grip, not the slip.
            self.deflection_m = (zx * slide, zy * slide);
            self.force_n = (kx * zx * slide, ky * zy * slide);
            return;
        }
        self.deflection_m = (zx, zy);
        let damping = tyre.damping_ns_per_m / h_s;
        let fx = kx * zx + damping * (zx - before.0); // (2)
        let fy = ky * zy + damping * (zy - before.1);
        let limit = grip_share(fx, fy, grip_n);
        self.force_n = (fx * limit, fy * limit);
    }

    /// Energy in the bent bristles \[J\].
    pub fn energy_j(&self, tyre: &TyreParameters) -> f64 {
        let (zx, zy) = self.deflection_m;
        0.5 * (tyre.longitudinal_stiffness_n_per_m * zx * zx
            + tyre.lateral_stiffness_n_per_m * zy * zy)
    }
}

/// What share of the force (x, y) the grip can carry.
#[inline]
fn grip_share(x: f64, y: f64, grip_n: f64) -> f64 {
    let square = x * x + y * y;
    if square <= grip_n * grip_n { 1.0 } else { grip_n / square.sqrt() }
}
