//! What the loop adds to a feedforward that is a little off, by friction, speed and acceleration.
//!
//! ```text
//! f = kS sign(v) + kV v + kA a        v, a: the setpoints' speed and acceleration; f: what the loop adds
//! ```
//!
//! Least squares over all instants. A direction that was not driven gives no kS.

use nalgebra::{Matrix4, Vector4};

/// What the loop added at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Added {
    /// The setpoint's speed \[m/s\].
    pub speed_mps: f64,
    /// Its acceleration \[m/s^2\].
    pub acceleration_mps2: f64,
    /// What the loop added, in volts or as a share of a supply.
    pub feedback: f64,
}

/// What the loop added by each of them, in the unit of [`Added::feedback`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AddedTerms {
    /// By the direction, forwards.
    pub ks_forward: f64,
    /// By the direction, backwards; positive as friction is.
    pub ks_backward: f64,
    /// By speed.
    pub kv: f64,
    /// By acceleration.
    pub ka: f64,
}

impl AddedTerms {
    /// From what was added during drives; None if they tell nothing, as without any acceleration.
    pub fn of(instants: &[Added]) -> Option<Self> {
        let mut normal = Matrix4::zeros();
        let mut right = Vector4::zeros();
        for added in instants.iter().filter(|added| added.speed_mps != 0.0) {
            let forward = f64::from(u8::from(added.speed_mps > 0.0));
            let terms =
                Vector4::new(forward, forward - 1.0, added.speed_mps, added.acceleration_mps2);
            normal += terms * terms.transpose();
            right += terms * added.feedback;
        }
        // Each by its own size: a direction that was not driven has none, and stays at zero.
        let size = normal.diagonal().map(|square: f64| square.sqrt());
        if size[2] <= 0.0 || size[3] <= 0.0 {
            return None;
        }
        let per_size = size.map(|size| if size > 0.0 { 1.0 / size } else { 0.0 });
        let scale = Matrix4::from_diagonal(&per_size);
        let ridge = Matrix4::from_diagonal_element(1e-6);
        let found = (scale * normal * scale + ridge).cholesky()?.solve(&(scale * right));
        let found = scale * found;
        found.iter().all(|value| value.is_finite()).then(|| Self {
            ks_forward: found[0],
            ks_backward: found[1],
            kv: found[2],
            ka: found[3],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Added, AddedTerms};

    /// Up to 0.4 m/s with 0.5 m/s^2, and down again.
    fn profile(sign: f64) -> impl Iterator<Item = (f64, f64)> {
        (1..200).map(move |number| {
            let t_s = f64::from(number) * 0.01;
            let (speed, acceleration) = match t_s {
                0.0..0.8 => (0.5 * t_s, 0.5),
                0.8..1.2 => (0.4, 0.0),
                _ => (0.5 * (2.0 - t_s), -0.5),
            };
            (sign * speed, sign * acceleration)
        })
    }

    fn added((speed_mps, acceleration_mps2): (f64, f64)) -> Added {
        let friction = if speed_mps > 0.0 { 0.003 } else { -0.001 };
        let feedback = friction + 0.005 * speed_mps + 0.02 * acceleration_mps2;
        Added { speed_mps, acceleration_mps2, feedback }
    }

    #[test]
    fn friction_speed_and_acceleration_are_told_apart() {
        let instants: Vec<Added> = profile(1.0).chain(profile(-1.0)).map(added).collect();
        let found = AddedTerms::of(&instants).unwrap();
        let expected = AddedTerms { ks_forward: 0.003, ks_backward: 0.001, kv: 0.005, ka: 0.02 };
        for (found, expected) in [
            (found.ks_forward, expected.ks_forward),
            (found.ks_backward, expected.ks_backward),
            (found.kv, expected.kv),
            (found.ka, expected.ka),
        ] {
            assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
        }
    }

    #[test]
    fn a_direction_that_was_not_driven_gives_nothing_and_a_robot_at_rest_neither() {
        let forwards: Vec<Added> = profile(1.0).map(added).collect();
        let found = AddedTerms::of(&forwards).unwrap();
        assert_eq!(found.ks_backward, 0.0);
        assert!((found.ks_forward / 0.003 - 1.0).abs() < 0.01, "{found:?}");
        assert_eq!(AddedTerms::of(&[]), None);
    }
}
