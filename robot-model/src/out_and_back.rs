//! Is it the radius at all? A run forward and a run backward tell a radius from a pull.
//!
//! Unequal radii turn the robot one way forwards and the other way backwards. A pull (a caster that
//! drags, a slope, a crooked tyre) turns it the same way on every metre it drives, whichever
//! direction that is. With alpha clockwise positive and p the pull per metre driven:
//!
//! ```text
//! alpha = (R_L phi_L - W_T R_L phi_R) / b + p |s|,   s = R_L phi_L - b alpha / 2      (1)
//! ```
//!
//! For wheels that turn equally far out and back this is alpha_forward = A + P,
//! alpha_backward = -A + P. Each run gives one equation (1), linear in W_T and p.

use core::fmt;

use crate::geometry::{Geometry, Turns};
use crate::wheel_weight::{SIGMAS_95, WheelWeight};

/// One of the two runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Deviation angle over the run, **clockwise positive** \[rad\].
    pub alpha_rad: f64,
    /// Its standard uncertainty \[rad\].
    pub alpha_sigma_rad: f64,
    /// How far the wheels turned; negative angles backwards.
    pub turns: Turns,
}

impl From<&WheelWeight> for Leg {
    fn from(weight: &WheelWeight) -> Self {
        Self {
            alpha_rad: weight.alpha_rad,
            alpha_sigma_rad: weight.alpha_sigma_rad,
            turns: weight.turns,
        }
    }
}

/// What bends the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The curvature flips: unequal radii, and nothing else beyond noise.
    Radius,
    /// The curvature does not flip: a pull.
    Pull,
    /// There are both.
    Both,
    /// Neither is beyond noise.
    Neither,
}

impl Verdict {
    /// The sentence to print.
    pub const fn sentence(self) -> &'static str {
        match self {
            Self::Radius => "the curvature flips its sign on reversing: unequal radii",
            Self::Pull => "the curvature does not flip its sign on reversing: a pull, not a radius",
            Self::Both => {
                "the curvature changes on reversing but does not just flip: unequal radii and a pull"
            }
            Self::Neither => "neither unequal radii nor a pull stands out from the noise",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.sentence())
    }
}

/// What two runs say together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutAndBack {
    /// W_T from the part that flips.
    pub wheel_weight: f64,
    /// Its standard uncertainty.
    pub wheel_weight_sigma: f64,
    /// The part of the forward run's alpha that flips, A \[rad\], clockwise positive.
    pub radius_alpha_rad: f64,
    /// Its standard uncertainty \[rad\].
    pub radius_alpha_sigma_rad: f64,
    /// The part that does not flip, per metre driven \[rad/m\], clockwise positive.
    pub pull_rad_per_m: f64,
    /// Its standard uncertainty \[rad/m\].
    pub pull_sigma_rad_per_m: f64,
    /// Which of the two stands out.
    pub verdict: Verdict,
}

impl OutAndBack {
    /// Separates radius from pull.
    pub fn new(forward: Leg, backward: Leg, geometry: &Geometry) -> Result<Self, OutAndBackError> {
        let legs = [forward, backward];
        if !legs.iter().all(Leg::is_sound) {
            return Err(OutAndBackError::BadNumber);
        }
        let radius_m = geometry.wheel_radius_m;
        let same_way = forward.turns.phi_left_rad * backward.turns.phi_left_rad >= 0.0
            || legs.iter().any(|leg| leg.turns.phi_left_rad * leg.turns.phi_right_rad <= 0.0);
        if same_way {
            return Err(OutAndBackError::SameDirection);
        }

        // (1) as  q W_T - |s| p = c  with  q = R_L phi_R / b,  c = R_L phi_L / b - alpha.
        let q = legs.map(|leg| radius_m * leg.turns.phi_right_rad / geometry.track_width_m);
        let c = legs
            .map(|leg| radius_m * leg.turns.phi_left_rad / geometry.track_width_m - leg.alpha_rad);
        let s_m = legs.map(|leg| {
            (radius_m * leg.turns.phi_left_rad - geometry.track_width_m * leg.alpha_rad / 2.0).abs()
        });
        let determinant = q[1] * s_m[0] - q[0] * s_m[1];
        let wheel_weight = (s_m[0] * c[1] - s_m[1] * c[0]) / determinant;
        let pull_rad_per_m = (q[0] * c[1] - q[1] * c[0]) / determinant;

        let sigma = legs.map(|leg| leg.alpha_sigma_rad);
        let wheel_weight_sigma = (s_m[0] * sigma[1]).hypot(s_m[1] * sigma[0]) / determinant.abs();
        let pull_sigma_rad_per_m = (q[0] * sigma[1]).hypot(q[1] * sigma[0]) / determinant.abs();
        let turns = forward.turns;
        let radius_alpha_rad = radius_m * (turns.phi_left_rad - wheel_weight * turns.phi_right_rad)
            / geometry.track_width_m;
        let radius_alpha_sigma_rad = (q[0] * wheel_weight_sigma).abs();

        let radius = radius_alpha_rad.abs() > SIGMAS_95 * radius_alpha_sigma_rad;
        let pull = pull_rad_per_m.abs() > SIGMAS_95 * pull_sigma_rad_per_m;
        Ok(Self {
            wheel_weight,
            wheel_weight_sigma,
            radius_alpha_rad,
            radius_alpha_sigma_rad,
            pull_rad_per_m,
            pull_sigma_rad_per_m,
            verdict: match (radius, pull) {
                (true, true) => Verdict::Both,
                (true, false) => Verdict::Radius,
                (false, true) => Verdict::Pull,
                (false, false) => Verdict::Neither,
            },
        })
    }
}

impl Leg {
    fn is_sound(&self) -> bool {
        let Turns { phi_left_rad, phi_right_rad } = self.turns;
        [self.alpha_rad, phi_left_rad, phi_right_rad].into_iter().all(f64::is_finite)
            && self.alpha_sigma_rad >= 0.0
            && self.alpha_sigma_rad.is_finite()
    }
}

/// Why two runs cannot be separated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutAndBackError {
    /// Both runs went the same way.
    SameDirection,
    /// A number is not finite, or a sigma negative.
    BadNumber,
}

impl fmt::Display for OutAndBackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SameDirection => write!(
                f,
                "both runs went the same way: one of them must be driven backwards, \
                 without turning the robot"
            ),
            Self::BadNumber => write!(f, "an angle is not finite, or its sigma is negative"),
        }
    }
}

impl core::error::Error for OutAndBackError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use crate::wheel_weight::{Deviation, Experiment};
    use core::f64::consts::TAU;

    const OUT: Turns = Turns::both(8.0 * TAU);
    const BACK: Turns = Turns::both(-8.0 * TAU);

    /// alpha by (1), s taken from the wheels.
    fn leg(wheel_weight: f64, pull_rad_per_m: f64, turns: Turns, sigma: f64) -> Leg {
        let Geometry { wheel_radius_m: r, track_width_m: b, .. } = Geometry::PAPER;
        let (left_m, right_m) = (r * turns.phi_left_rad, r * turns.phi_right_rad * wheel_weight);
        let wheels = (left_m - right_m) / b;
        // s = R_L phi_L - b alpha / 2 with alpha itself on the left: solved for alpha.
        let sign = turns.phi_left_rad.signum();
        let alpha_rad =
            (wheels + pull_rad_per_m * left_m.abs()) / (1.0 + pull_rad_per_m * sign * b / 2.0);
        Leg { alpha_rad, alpha_sigma_rad: sigma, turns }
    }

    fn judge(wheel_weight: f64, pull_rad_per_m: f64, sigma: f64) -> OutAndBack {
        let [out, back] = [OUT, BACK].map(|turns| leg(wheel_weight, pull_rad_per_m, turns, sigma));
        OutAndBack::new(out, back, &Geometry::PAPER).unwrap()
    }

    #[test]
    fn a_pull_is_not_mistaken_for_a_radius() {
        let found = judge(1.0, 0.02, 0.002);
        assert_eq!(found.verdict, Verdict::Pull);
        assert!(found.verdict.sentence().contains("a pull, not a radius"));
        assert!((found.wheel_weight - 1.0).abs() < 1e-12, "{found:?}");
        assert!((found.pull_rad_per_m - 0.02).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_radius_is_not_mistaken_for_a_pull() {
        let found = judge(0.9919, 0.0, 0.002);
        assert_eq!(found.verdict, Verdict::Radius);
        assert!((found.wheel_weight - 0.9919).abs() < 1e-12, "{found:?}");
        assert!(found.pull_rad_per_m.abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn both_and_neither_are_told_apart() {
        let both = judge(0.9919, -0.01, 0.002);
        assert_eq!(both.verdict, Verdict::Both);
        assert!((both.wheel_weight - 0.9919).abs() < 1e-12);
        assert!((both.pull_rad_per_m + 0.01).abs() < 1e-12);
        assert_eq!(judge(0.9999, 0.0002, 0.01).verdict, Verdict::Neither);
    }

    #[test]
    fn legs_of_different_length_and_an_already_weighted_robot_are_allowed_for() {
        let out = Turns { phi_left_rad: 50.0, phi_right_rad: 50.5 };
        let back = Turns { phi_left_rad: -30.0, phi_right_rad: -30.3 };
        let found = OutAndBack::new(
            leg(0.985, 0.007, out, 0.001),
            leg(0.985, 0.007, back, 0.001),
            &Geometry::PAPER,
        )
        .unwrap();
        assert!((found.wheel_weight - 0.985).abs() < 1e-12, "{found:?}");
        assert!((found.pull_rad_per_m - 0.007).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn lateral_offsets_of_both_legs_will_do() {
        let legs = [(OUT, -0.036), (BACK, -0.036)].map(|(turns, y_m)| {
            let deviation = Deviation::LateralOffset { y_m, sigma_m: 0.0005 };
            let experiment = Experiment {
                deviation,
                turns,
                geometry: Geometry::PAPER,
                start_heading_sigma_rad: 0.0,
            };
            Leg::from(&experiment.wheel_weight().unwrap())
        });
        // Right of the line both times: clockwise on the way out, counter-clockwise on the way back.
        assert!(legs[0].alpha_rad > 0.0 && legs[1].alpha_rad < 0.0, "{legs:?}");
        let found = OutAndBack::new(legs[0], legs[1], &Geometry::PAPER).unwrap();
        assert_eq!(found.verdict, Verdict::Radius);
    }

    #[test]
    fn two_runs_the_same_way_are_refused() {
        let out = leg(0.99, 0.0, OUT, 0.001);
        let error = OutAndBack::new(out, out, &Geometry::PAPER).unwrap_err();
        assert_eq!(error, OutAndBackError::SameDirection);
        let nan = Leg { alpha_rad: f64::NAN, ..out };
        assert_eq!(OutAndBack::new(nan, out, &Geometry::PAPER), Err(OutAndBackError::BadNumber));
    }

    #[test]
    fn noise_alone_is_called_a_radius_or_a_pull_once_in_twenty() {
        let mut noise = Noise::new(5);
        let mut radius = 0;
        let mut pull = 0;
        let trials = 2000;
        for _ in 0..trials {
            let [out, back] = [OUT, BACK].map(|turns| Leg {
                alpha_rad: 0.003 * noise.normal(),
                alpha_sigma_rad: 0.003,
                turns,
            });
            match OutAndBack::new(out, back, &Geometry::PAPER).unwrap().verdict {
                Verdict::Radius => radius += 1,
                Verdict::Pull => pull += 1,
                Verdict::Both => (radius, pull) = (radius + 1, pull + 1),
                Verdict::Neither => (),
            }
        }
        // 5 % of 2000 with a sigma of 10: four of them each way.
        assert!((60..=140).contains(&radius) && (60..=140).contains(&pull), "{radius} {pull}");
    }
}
