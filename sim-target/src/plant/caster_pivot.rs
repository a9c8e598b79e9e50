//! A stiff caster pivot that rolling shakes loose.

use serde::{Deserialize, Serialize};

use super::range_check::{ParameterError, RangeCheck};

/// A bush round the caster's pivot: a dry seal, a hair wound in, a washer pressed too hard.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BushParameters {
    /// Torque at which the bush slides, T_b; 0 for a pivot without a bush \[N m\].
    pub torque_nm: f64,
    /// Twist at which the bush begins to slide, psi_b \[rad\].
    pub windup_rad: f64,
    /// Distance that the caster's wheel rolls while vibration reduces the twist to 1/e, L \[m\].
    pub relaxation_m: f64,
}

impl Default for BushParameters {
    fn default() -> Self {
        Self { torque_nm: 0.0, windup_rad: 0.1, relaxation_m: 0.01 }
    }
}

impl BushParameters {
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("caster.bush.");
        check.within("torque_nm", self.torque_nm, 0.0, 10.0)?;
        check.within("windup_rad", self.windup_rad, 0.01, 3.0)?;
        check.within("relaxation_m", self.relaxation_m, 1e-3, 10.0)
    }

    /// Torque per twist, k = T_b / psi_b \[N m/rad\].
    pub(super) fn stiffness_nm(&self) -> f64 {
        self.torque_nm / self.windup_rad
    }
}

/// How far the bush is twisted, psi, the fork turned left against the body counting positive.
///
/// ```text
/// dpsi/dt = delta' - |v_d| psi / L,   |psi| <= psi_b      (1)
/// T = k psi                                               (2)  on the body; -T on the fork
/// ```
///
/// Dry friction with elastic deflection before it slides (Dahl), under vibration. At rest the bush holds its
/// twist; every knock of the rolling wheel lets the twist creep back a little, so the bush has relaxed a few L
/// after the fork comes to rest. The twist therefore outlasts the swing, and meanwhile a side force T/e of
/// the caster's wheel balances the torque.
///
/// Sources: Dahl, A solid friction model (1968); on friction that vibration turns into creep,
/// Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994), 1083.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bush {
    parameters: BushParameters,
    twist_rad: f64,
}

impl Bush {
    /// None for a pivot without a bush.
    pub fn new(parameters: &BushParameters) -> Option<Self> {
        (parameters.torque_nm > 0.0).then_some(Self { parameters: *parameters, twist_rad: 0.0 })
    }

    /// Resets the twist.
    pub fn lift(&mut self) {
        self.twist_rad = 0.0;
    }

    /// Its torque on the body (2) \[N m\].
    #[inline]
    pub fn torque_nm(&self) -> f64 {
        self.parameters.stiffness_nm() * self.twist_rad
    }

    /// The fork turns, the wheel rolls: (1) by the trapezoidal rule.
    #[inline]
    pub fn advance(&mut self, turn_rad: f64, rolled_m: f64) {
        let fade = 0.5 * rolled_m / self.parameters.relaxation_m;
        let free_rad = (self.twist_rad * (1.0 - fade) + turn_rad) / (1.0 + fade);
        let most_rad = self.parameters.windup_rad;
        self.twist_rad = free_rad.clamp(-most_rad, most_rad);
    }

    /// Energy of its twist \[J\].
    pub fn energy_j(&self) -> f64 {
        0.5 * self.torque_nm() * self.twist_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bush(torque_nm: f64) -> Option<Bush> {
        let parameters = BushParameters { torque_nm, windup_rad: 0.1, relaxation_m: 0.05 };
        assert_eq!(parameters.check(), Ok(()));
        Bush::new(&parameters)
    }

    #[test]
    fn a_pivot_without_torque_has_none() {
        assert!(bush(0.0).is_none());
    }

    #[test]
    fn a_bush_gives_like_a_spring_and_slides_at_its_torque_either_way() {
        for sign in [1.0, -1.0] {
            let mut bush = bush(0.4).expect("a bush with torque");
            bush.advance(sign * 0.05, 0.0);
            assert!((bush.torque_nm() - sign * 0.2).abs() < 1e-12, "{}", bush.torque_nm());
            assert!((bush.energy_j() - 0.5 * 0.2 * 0.05).abs() < 1e-12);
            bush.advance(sign * 1.0, 0.0);
            assert!((bush.torque_nm() - sign * 0.4).abs() < 1e-12, "{}", bush.torque_nm());
            // Back by twice the sliding twist: the bush slides the other way.
            bush.advance(-sign * 0.2, 0.0);
            assert!((bush.torque_nm() + sign * 0.4).abs() < 1e-12, "{}", bush.torque_nm());
        }
    }

    #[test]
    fn a_bush_holds_at_rest_and_relaxes_over_its_length_while_rolling() {
        let mut bush = bush(0.4).expect("a bush with torque");
        bush.advance(0.1, 0.0);
        (0..1000).for_each(|_| bush.advance(0.0, 0.0));
        assert_eq!(bush.torque_nm(), 0.4);
        (0..1000).for_each(|_| bush.advance(0.0, 0.05e-3));
        let left = bush.torque_nm() / 0.4;
        assert!((left - (-1.0_f64).exp()).abs() < 1e-6, "{left}");
        bush.lift();
        assert_eq!(bush.torque_nm(), 0.0);
    }
}
