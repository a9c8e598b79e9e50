//! The trailing caster.

use serde::{Deserialize, Serialize};

use super::caster_pivot::{Bush, BushParameters};
use super::pose::Twist;
use super::range_check::{ParameterError, RangeCheck};
use super::rotation::Rotation;
use super::wheel::less_friction;

/// A caster behind the axle, on the midline.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CasterParameters {
    /// Distance of the pivot behind the axle, l \[m\].
    pub pivot_behind_m: f64,
    /// Distance of the contact behind the pivot, when trailing, e \[m\].
    pub trail_m: f64,
    /// Swivel angle at the start: 0 trails forward travel \[rad\], counter-clockwise positive.
    pub start_angle_rad: f64,
    /// Inertia of fork and wheel about the pivot, I_c \[kg m^2\].
    pub swivel_inertia_kgm2: f64,
    /// Dry friction of the pivot, contact scrub included \[N m\].
    pub swivel_friction_nm: f64,
    /// Sideways force per deflection of its tyre \[N/m\].
    pub lateral_stiffness_n_per_m: f64,
    /// Damping of its tyre \[N s/m\].
    pub damping_ns_per_m: f64,
    /// Distance rolled in which a deflection fades to 1/e \[m\].
    pub relaxation_length_m: f64,
    /// Rolling resistance as a share of the load.
    pub rolling_resistance: f64,
    /// Side force of a leaning or conical wheel in either rolling direction, as the equivalent slip angle;
    /// positive to the left of the rolling direction \[rad\].
    pub conicity_rad: f64,
    /// A bush that holds the fork besides dry friction.
    pub bush: BushParameters,
}

impl Default for CasterParameters {
    /// A 30 mm plastic swivel caster.
    fn default() -> Self {
        Self {
            pivot_behind_m: 0.2,
            trail_m: 0.02,
            start_angle_rad: 0.0,
            swivel_inertia_kgm2: 2e-5,
            swivel_friction_nm: 0.001,
            lateral_stiffness_n_per_m: 8000.0,
            damping_ns_per_m: 10.0,
            relaxation_length_m: 0.006,
            rolling_resistance: 0.02,
            conicity_rad: 0.0,
            bush: BushParameters::default(),
        }
    }
}

impl CasterParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("pivot_behind_m", self.pivot_behind_m, 0.01, 10.0)?;
        check.within("trail_m", self.trail_m, 0.001, 1.0)?;
        check.within("start_angle_rad", self.start_angle_rad, -7.0, 7.0)?;
        check.within("swivel_inertia_kgm2", self.swivel_inertia_kgm2, 1e-7, 10.0)?;
        check.within("swivel_friction_nm", self.swivel_friction_nm, 0.0, 10.0)?;
        check.within("lateral_stiffness_n_per_m", self.lateral_stiffness_n_per_m, 10.0, 1e7)?;
        check.within("damping_ns_per_m", self.damping_ns_per_m, 0.0, 1e4)?;
        check.within("relaxation_length_m", self.relaxation_length_m, 1e-4, 1.0)?;
        check.within("rolling_resistance", self.rolling_resistance, 0.0, 0.3)?;
        check.within("conicity_rad", self.conicity_rad, -0.3, 0.3)?;
        self.bush.check()
    }

    /// Square of the fork's fastest vibration, but for what the body adds \[(rad/s)^2\].
    pub(super) fn vibration_squared(&self) -> f64 {
        let tyre_nm = self.lateral_stiffness_n_per_m * self.trail_m * self.trail_m;
        (tyre_nm + self.bush.stiffness_nm()) / self.swivel_inertia_kgm2
    }
}

/// The caster's state. Its direction d is where its wheel rolls, n is d turned left; delta is the
/// angle from the body's forward axis to d.
///
/// ```text
/// contact's velocity:   v_d = v_pivot . d,   v_n = v_pivot . n - e (omega + delta')      (1)
/// deflection:           dz/dt = -v_n + |v_d| (gamma - z / sigma)
///                       F_n = k z + c dz/dt <= mu N                                      (2)
/// swivel:               I_c (delta'' + omega') = -e F_n - friction - bush                (3)
/// rolling resistance:   F_d = -f N v_d / (|v_d| + v_0)                                   (4)
/// ```
///
/// At delta = 0, (3) is stable forwards and unstable backwards. After a reversal the caster swings round as
/// soon as a disturbance exceeds the pivot's friction, and kicks the robot.
///
/// A wheel that leans by gamma, or is conical, pushes to the same side in both rolling directions. So its
/// fork trails at -gamma, and backwards its equilibrium is at +gamma. After a reversal the fork is 2 gamma
/// away from equilibrium and swings at once, always the same way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Caster {
    direction: Rotation,
    angle_rad: f64,
    swivel_rad_s: f64,
    deflection_m: f64,
    /// Force on the body at the pivot, forward and to the left \[N\].
    pub force_n: (f64, f64),
    lateral_n: f64,
    /// The pivot's friction and its bush, as they turn the body \[N m\].
    pub reaction_nm: f64,
    bush: Option<Bush>,
}

/// Speed below which rolling resistance fades out, so that the force never drives the wheel: v_0 in (4).
const ROLLING_MPS: f64 = 5e-4;

impl Caster {
    pub fn new(parameters: &CasterParameters) -> Self {
        Self {
            direction: Rotation::new(parameters.start_angle_rad),
            angle_rad: parameters.start_angle_rad,
            swivel_rad_s: 0.0,
            deflection_m: 0.0,
            force_n: (0.0, 0.0),
            lateral_n: 0.0,
            reaction_nm: 0.0,
            bush: Bush::new(&parameters.bush),
        }
    }

    /// Resets contact and motion, but not the angle.
    pub fn lift(&mut self) {
        if let Some(bush) = &mut self.bush {
            bush.lift();
        }
        (self.swivel_rad_s, self.deflection_m) = (0.0, 0.0);
        (self.force_n, self.lateral_n, self.reaction_nm) = ((0.0, 0.0), 0.0, 0.0);
    }

    /// Swivel angle, not wrapped \[rad\].
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// Advances the swivel rate by h (3), while the body's yaw rate changes by `yaw_change_rad_s`.
    #[inline]
    pub fn kick(&mut self, caster: &CasterParameters, yaw_change_rad_s: f64, h_s: f64) {
        let per_torque = h_s / caster.swivel_inertia_kgm2;
        let mut free =
            self.swivel_rad_s - caster.trail_m * self.lateral_n * per_torque - yaw_change_rad_s;
        let bush_nm = self.bush.as_ref().map_or(0.0, Bush::torque_nm);
        free -= bush_nm * per_torque;
        self.swivel_rad_s = less_friction(free, caster.swivel_friction_nm * per_torque);
        self.reaction_nm = (free - self.swivel_rad_s) / per_torque + bush_nm;
    }

    /// Swivels by h, and finds the force for the next kick.
    #[inline]
    pub fn drift(
        &mut self,
        caster: &CasterParameters,
        body: Twist,
        load_n: f64,
        friction: f64,
        h_s: f64,
    ) {
        let turn_rad = self.swivel_rad_s * h_s;
        let middle = self.direction.then(Rotation::small(0.5 * turn_rad));
        self.direction = middle.then(Rotation::small(0.5 * turn_rad));
        self.angle_rad += turn_rad;

        let pivot_left_mps = body.left_mps - caster.pivot_behind_m * body.yaw_rate_rad_s;
        let (along_mps, across_mps) = middle.undo(body.forward_mps, pivot_left_mps);
        let swing_mps = caster.trail_m * (body.yaw_rate_rad_s + self.swivel_rad_s);
        let slip_mps = swing_mps - across_mps + caster.conicity_rad * along_mps.abs(); // (1)
        if let Some(bush) = &mut self.bush {
            bush.advance(turn_rad, along_mps.abs() * h_s);
        }

        let before = self.deflection_m; // (2), by the trapezoidal rule
        let fade = 0.5 * h_s * along_mps.abs() / caster.relaxation_length_m;
        let grip_n = friction * load_n;
        let free_m = (before * (1.0 - fade) + slip_mps * h_s) / (1.0 + fade);
        let spring_n = caster.lateral_stiffness_n_per_m * free_m;
        if spring_n.abs() <= grip_n {
            let rate_mps = (free_m - before) / h_s;
            self.deflection_m = free_m;
            self.lateral_n = (spring_n + caster.damping_ns_per_m * rate_mps).clamp(-grip_n, grip_n);
        } else {
            self.lateral_n = grip_n.copysign(spring_n);
            self.deflection_m = self.lateral_n / caster.lateral_stiffness_n_per_m;
        }

        let drag_n = caster.rolling_resistance * load_n;
        let rolling_n = -drag_n * along_mps / (along_mps.abs() + ROLLING_MPS); // (4)
        self.force_n = self.direction.apply(rolling_n, self.lateral_n);
    }

    /// Energy of the swivel and of the bent tyre \[J\].
    pub fn energy_j(&self, caster: &CasterParameters, yaw_rate_rad_s: f64) -> f64 {
        let rate = self.swivel_rad_s + yaw_rate_rad_s;
        0.5 * caster.swivel_inertia_kgm2 * rate * rate
            + 0.5 * caster.lateral_stiffness_n_per_m * self.deflection_m * self.deflection_m
            + self.bush.as_ref().map_or(0.0, Bush::energy_j)
    }
}
