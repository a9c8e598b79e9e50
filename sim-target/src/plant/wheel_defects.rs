//! Defects of a driven wheel: eccentricity, growth with speed, compliance, a flat spot, a bent axle.

use core::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};

use super::range_check::{ParameterError, RangeCheck};

/// The defects of one driven wheel. All zero is a perfect wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WheelParameters {
    /// Distance from the rim's centre to the hub, as a share of the radius, e.
    pub eccentricity: f64,
    /// Wheel angle at which the hub stands highest \[rad\].
    pub eccentricity_phase_rad: f64,
    /// Growth of the radius by spin, share per (rad/s)^2.
    pub centrifugal_growth_s2: f64,
    /// Loss of radius per load beyond that of the unladen robot at rest \[m/N\].
    pub radial_compliance_m_per_n: f64,
    /// Half the angle that a flat spot takes up, as seen from the hub \[rad\].
    pub flat_half_angle_rad: f64,
    /// Angle between the axle's end and the axle \[rad\].
    pub bend_rad: f64,
    /// Wheel angle at which a bent axle turns the wheel to the left most \[rad\].
    pub bend_phase_rad: f64,
    /// How far the wheel can slide along its axle, from stop to stop \[m\].
    pub end_float_m: f64,
    /// Distance of the contact in front of the axle \[m\].
    pub contact_ahead_m: f64,
    /// Dry friction of the bearing, on the wheel's side of the gear \[N m\].
    pub hub_friction_nm: f64,
}

impl WheelParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("eccentricity", self.eccentricity, 0.0, 0.2)?;
        check.within("eccentricity_phase_rad", self.eccentricity_phase_rad, -7.0, 7.0)?;
        check.within("centrifugal_growth_s2", self.centrifugal_growth_s2, 0.0, 1e-2)?;
        check.within("radial_compliance_m_per_n", self.radial_compliance_m_per_n, 0.0, 1e-2)?;
        check.within("flat_half_angle_rad", self.flat_half_angle_rad, 0.0, 0.5)?;
        check.within("bend_rad", self.bend_rad, 0.0, 0.3)?;
        check.within("bend_phase_rad", self.bend_phase_rad, -7.0, 7.0)?;
        check.within("end_float_m", self.end_float_m, 0.0, 0.1)?;
        check.within("contact_ahead_m", self.contact_ahead_m, -0.2, 0.2)?;
        check.within("hub_friction_nm", self.hub_friction_nm, 0.0, 10.0)
    }

    pub(super) fn is_ideal(&self) -> bool {
        *self
            == Self {
                eccentricity_phase_rad: self.eccentricity_phase_rad,
                bend_phase_rad: self.bend_phase_rad,
                ..Self::default()
            }
    }
}

/// Where and how a wheel touches the floor at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactGeometry {
    /// Height of the hub above the floor: the tread moves at this times the spin \[m\].
    pub radius_m: f64,
    /// Direction of the wheel's plane, to the left of the body's \[rad\].
    pub toe_rad: f64,
    /// Lateral shift of the contact, to the left \[m\].
    pub aside_m: f64,
}

impl WheelParameters {
    /// A wheel rolls about the floor under its hub, at the hub's height:
    ///
    /// ```text
    /// rim off its hub:   R (1 + e cos(phi - phi_e))                                  (1)
    /// spin:              R (1 + q w^2)                                               (2)
    /// load:              R - c (N - N_0)                                             (3)
    /// flat spot:         R cos(alpha)/cos(psi), psi from its middle, |psi| < alpha   (4)
    /// bent axle:         toe = beta cos(phi - phi_b), lean = beta sin(phi - phi_b)   (5)
    /// ```
    ///
    /// A wheel that leans by an angle touches the floor R sin(lean) aside.
    #[inline]
    pub(super) fn contact(
        &self,
        radius_m: f64,
        angle_rad: f64,
        spin_rad_s: f64,
        extra_n: f64,
    ) -> ContactGeometry {
        let mut share = 1.0 + self.centrifugal_growth_s2 * spin_rad_s * spin_rad_s; // (2)
        if self.eccentricity != 0.0 {
            share += self.eccentricity * (angle_rad - self.eccentricity_phase_rad).cos(); // (1)
        }
        if self.flat_half_angle_rad != 0.0 {
            // Its middle stands opposite the floor at the start.
            let psi = angle_rad.rem_euclid(TAU) - PI;
            if psi.abs() < self.flat_half_angle_rad {
                share += self.flat_half_angle_rad.cos() / psi.cos() - 1.0; // (4)
            }
        }
        // A tyre can be compressed no further than its rim.
        let rim_m = 0.5 * radius_m;
        let radius_m = radius_m * share - self.radial_compliance_m_per_n * extra_n; // (3)
        let radius_m = radius_m.max(rim_m);
        if self.bend_rad == 0.0 {
            return ContactGeometry { radius_m, toe_rad: 0.0, aside_m: 0.0 };
        }
        let (sin, cos) = (angle_rad - self.bend_phase_rad).sin_cos(); // (5)
        ContactGeometry {
            radius_m,
            toe_rad: self.bend_rad * cos,
            aside_m: radius_m * self.bend_rad * sin,
        }
    }
}
