//! External disturbances: a tether, a dragging object, warming wheels.

use serde::{Deserialize, Serialize};

use super::pose::Twist;
use super::range_check::{ParameterError, RangeCheck};

/// A cable from above that pulls and twists the robot, independent of its motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TetherParameters {
    /// Torque, counter-clockwise positive \[N m\].
    pub twist_nm: f64,
    /// Force to the robot's left \[N\].
    pub left_n: f64,
    /// Distance of the attachment behind the axle \[m\].
    pub behind_m: f64,
}

/// Something under the robot that drags over the floor: a rag, a cable tie, a brush.
///
/// With its speed s over the floor: F = -F_0 s/(|s| + v_0), so that the force fades out at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DragParameters {
    /// Its friction, F_0 \[N\].
    pub force_n: f64,
    /// Distance of the contact to the left of the midline \[m\].
    pub left_m: f64,
    /// Distance of the contact behind the axle \[m\].
    pub behind_m: f64,
}

/// Speed below which a dragging thing's friction fades out: v_0 \[m/s\].
const DRAGGING_MPS: f64 = 5e-4;

/// Cold wheels in a warm room.
///
/// ```text
/// R(t) = R (1 + a D (1 - exp(-(t_0 + t)/tau)))    (1)
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WarmingParameters {
    /// Expansion of the tyres, a \[1/K\].
    pub expansion_per_k: f64,
    /// Initial temperature difference, room minus wheels, D \[K\].
    pub difference_k: f64,
    /// Time in which the difference falls to 1/e, tau \[s\].
    pub time_constant_s: f64,
    /// How long the wheels have been in the room when the simulation begins, t_0 \[s\].
    pub age_s: f64,
}

impl Default for WarmingParameters {
    fn default() -> Self {
        Self { expansion_per_k: 0.0, difference_k: 0.0, time_constant_s: 3600.0, age_s: 0.0 }
    }
}

impl TetherParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("twist_nm", self.twist_nm, -100.0, 100.0)?;
        check.within("left_n", self.left_n, -100.0, 100.0)?;
        check.within("behind_m", self.behind_m, -10.0, 10.0)
    }

    pub(super) fn is_ideal(&self) -> bool {
        self.twist_nm == 0.0 && self.left_n == 0.0
    }
}

impl DragParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("force_n", self.force_n, 0.0, 1e3)?;
        check.within("left_m", self.left_m, -10.0, 10.0)?;
        check.within("behind_m", self.behind_m, -10.0, 10.0)
    }

    pub(super) fn is_ideal(&self) -> bool {
        self.force_n == 0.0
    }

    /// Its force on the robot, forward and to the left \[N\].
    #[inline]
    pub(super) fn force_n(&self, body: Twist) -> (f64, f64) {
        let forward_mps = body.forward_mps - body.yaw_rate_rad_s * self.left_m;
        let left_mps = body.left_mps - body.yaw_rate_rad_s * self.behind_m;
        let per_speed = self.force_n / (forward_mps.hypot(left_mps) + DRAGGING_MPS);
        (-per_speed * forward_mps, -per_speed * left_mps)
    }
}

impl WarmingParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("expansion_per_k", self.expansion_per_k, 0.0, 1e-2)?;
        check.within("difference_k", self.difference_k, -100.0, 100.0)?;
        check.within("time_constant_s", self.time_constant_s, 1.0, 1e6)?;
        check.within("age_s", self.age_s, 0.0, 1e7)
    }

    pub(super) fn is_ideal(&self) -> bool {
        self.expansion_per_k == 0.0 || self.difference_k == 0.0
    }

    /// The radius as a share of the cold one (1), at a time of the simulation.
    pub(super) fn radius_share(&self, t_s: f64) -> f64 {
        let warmed = -(-(self.age_s + t_s) / self.time_constant_s).exp_m1();
        1.0 + self.expansion_per_k * self.difference_k * warmed
    }
}
