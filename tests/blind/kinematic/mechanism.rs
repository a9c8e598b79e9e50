//! What can be hidden in a robot of this plant? With its true parameters, and what it depends on.

use core::f64::consts::TAU;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

macro_rules! mechanisms {
    ($($(#[$doc:meta])* $name:ident = $id:literal, $catalogue:literal, $regressors:expr;)*) => {
        /// Something that can be wrong with a robot.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Mechanism {
            $($(#[$doc])* $name,)*
        }

        impl Mechanism {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Its name; of the catalogue's effects, that of the catalogue.
            pub fn id(self) -> &'static str {
                match self { $(Self::$name => $id,)* }
            }

            /// True if the catalogue of model effects lists it.
            pub fn is_in_catalogue(self) -> bool {
                match self { $(Self::$name => $catalogue,)* }
            }

            /// What it depends on, by the names of `explain`; any of them is right.
            pub fn regressors(self) -> &'static [&'static str] {
                match self { $(Self::$name => &$regressors,)* }
            }
        }
    };
}

mechanisms! {
    /// R_L = R (1 - rho/2), R_R = R (1 + rho/2).
    WheelRadiusRatio = "wheel_radius_ratio", true, [];
    /// ds_i (1 + s).
    WheelRadiusScale = "wheel_radius_scale", true, [];
    /// dtheta / (1 + delta).
    TrackWidth = "track_width", true, [];
    /// b (1 + k chi), chi = |omega| b / (2 |v| + |omega| b).
    Scrub = "scrub", true, [];
    /// dn = -k v omega dt.
    SideSlip = "side_slip", true, [];
    /// ds_i (1 - c a_i sgn v_i).
    TractionSlip = "traction_slip", true, [];
    /// domega = -k v^2 omega.
    TurnLoadTransfer = "turn_load_transfer", true, [];
    /// R_i (1 + k v_i^2).
    SpeedGrowth = "speed_growth", true, [];
    /// R_i (1 + c_i cos phi_i + s_i sin phi_i).
    WheelEccentricity = "wheel_eccentricity", true, [];
    /// The same at the encoder's angle.
    EncoderEccentricity = "encoder_eccentricity", true, [];
    /// dphi_i (1 + k max(0, |dphi_i/dt| - w0)/w0).
    LostCounts = "lost_counts", true, [];
    /// The ground lags the encoder by beta_i/2 after a reversal.
    Backlash = "backlash", true, [];
    /// dtheta = A exp(-s/l) ds/l after a reversal of travel.
    CasterKick = "caster_kick", true, [];
    /// dtheta = c |ds|.
    HeadingPull = "heading_pull", true, [];
    /// dtheta (1 + k sgn omega).
    TurnAsymmetry = "turn_asymmetry", true, [];
    /// Creep l (k_x, k_y) ds_w, dtheta = k sin(beta - theta) ds_w, ds_w = (|ds_L| + |ds_R|)/2.
    Slope = "slope", true, [];
    /// World drift (d_x, d_y) (|ds_L| + |ds_R|)/2.
    CarpetDrift = "carpet_drift", true, [];
    /// R (1 + k t) across the campaign.
    ThermalDrift = "thermal_drift", true, [];
    /// R (1 - k m).
    Payload = "payload", true, [];
    /// The measured pose lags by tau.
    MeasurementDelay = "measurement_delay", true, [];
    /// The measured point sits at (l_x, l_y) on the body.
    MarkerOffset = "marker_offset", true, [];
    /// The measured heading drifts by r t.
    HeadingDrift = "heading_drift", true, [];
    /// The yaw rate sensor reads something at rest.
    GyroBias = "gyro_bias", true, [];
    /// The yaw rate sensor reads too much or too little.
    GyroScale = "gyro_scale", true, [];

    /// Tyres answer sideways late: dn = alpha ds, and alpha relaxes to -k omega over a time or a length.
    LateSideSlip = "late_side_slip", false, ["turn rate", "speed", "wheel speed", "acceleration"];
    /// domega = k v |v|.
    TurnWithSpeed = "turn_with_speed", false, ["speed", "wheel speed", "direction of travel"];
    /// domega = k v omega^2.
    GainWithSpeedAndTurn = "gain_with_speed_and_turn", false, ["turn rate", "speed", "wheel speed"];
    /// R (1 + k v^2) of one wheel only.
    OneWheelGrowth = "one_wheel_growth", false, ["wheel speed", "speed"];
    /// ds_i (1 - k chi (1 + m/m0)): slip by curvature and load.
    CurvatureLoadSlip = "curvature_load_slip", false, ["turn rate", "load", "wheel speed", "speed"];
    /// ds_i (1 - k) of a wheel on a patch.
    SlipperyPatch = "slippery_patch", false, ["place", "heading"];
    /// domega = 2 k t while it rolls: the heading drifts with the square of the time in the run.
    QuadraticDrift = "quadratic_drift", false, ["time in the run"];
    /// dtheta = k sin(2 (theta - theta0)) |ds|.
    TwoHeadings = "two_headings", false, ["heading", "place"];
    /// A turn by A over the first l after each stop.
    StictionTurn = "stiction_turn", false,
        ["distance since reversal", "acceleration", "time in the run", "direction of travel"];
    /// ds_i (1 + c_i cos 3 phi_i + s_i sin 3 phi_i).
    ThirdHarmonic = "third_harmonic", false, ["wheel angle"];
    /// ds_i (1 + k sgn v_i) of one wheel.
    DirectionalGain = "directional_gain", false, ["direction of travel", "turn rate", "wheel speed"];
}

/// A mechanism with its numbers.
#[derive(Clone, Copy, Debug)]
pub struct Hidden {
    /// Which.
    pub mechanism: Mechanism,
    /// Its numbers, in the order of [`Hidden::true_parameters`]; those of outside mechanisms as in
    /// [`super::mechanism_step`].
    pub p: [f64; 4],
}

/// Draws what strength does not scale: signs, sides, phases, lengths.
struct Draw<R>(R);

impl<R: Rng> Draw<R> {
    fn sign(&mut self) -> f64 {
        if self.0.random() { 1.0 } else { -1.0 }
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    /// A vector of this length in any direction.
    fn vector(&mut self, length: f64) -> [f64; 2] {
        let (sin, cos) = self.between(0.0, TAU).sin_cos();
        [length * cos, length * sin]
    }

    fn four(&mut self, length: f64) -> [f64; 4] {
        let (left, right) = (self.between(0.7, 1.3), self.between(0.7, 1.3));
        let ([a, b], [c, d]) = (self.vector(length * left), self.vector(length * right));
        [a, b, c, d]
    }
}

impl Hidden {
    /// The mechanism at a strength, 1 being typical; the seed draws the rest, alike at every strength.
    pub fn new(mechanism: Mechanism, strength: f64, seed: u64) -> Self {
        use Mechanism as M;
        let (mut draw, s) = (Draw(ChaCha8Rng::seed_from_u64(seed)), strength);
        let p = match mechanism {
            M::WheelRadiusRatio => [0.008 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::WheelRadiusScale => [0.005 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::TrackWidth => [0.02 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::Scrub | M::SideSlip | M::TractionSlip => [0.02 * s, 0.0, 0.0, 0.0],
            M::TurnLoadTransfer | M::SpeedGrowth => [0.04 * s, 0.0, 0.0, 0.0],
            M::WheelEccentricity => draw.four(0.006 * s),
            M::EncoderEccentricity => draw.four(0.015 * s),
            M::LostCounts => [0.05 * s, draw.between(0.45, 0.65), 0.0, 0.0],
            M::Backlash => [draw.between(0.02, 0.05) * s, draw.between(0.02, 0.05) * s, 0.0, 0.0],
            M::CasterKick => [0.05 * s * draw.sign(), draw.between(0.03, 0.1), 0.0, 0.0],
            M::HeadingPull => [0.005 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::TurnAsymmetry => [0.006 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::Slope => {
                let ([x, y], creep_m) = (draw.vector(0.005 * s), draw.between(0.2, 0.8));
                [x, y, creep_m * draw.sign(), 0.0]
            }
            M::CarpetDrift => {
                let [x, y] = draw.vector(0.005 * s);
                [x, y, 0.0, 0.0]
            }
            M::ThermalDrift => [4e-6 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::Payload => [5e-4 * s, 0.0, 0.0, 0.0],
            M::MeasurementDelay => [0.05 * s, 0.0, 0.0, 0.0],
            M::MarkerOffset => [0.01 * s * draw.sign(), 0.01 * s * draw.sign(), 0.0, 0.0],
            M::HeadingDrift => [0.001 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::GyroBias => [0.01 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::GyroScale => [0.02 * s * draw.sign(), 0.0, 0.0, 0.0],
            outside => outside.draw(s, &mut draw),
        };
        Self { mechanism, p }
    }

    /// Its parameters by the names of the catalogue; none for what is outside.
    ///
    /// The rate above which counts are lost is a share of the fastest wheel's, `fastest_rad_s`.
    pub fn true_parameters(&self, fastest_rad_s: f64) -> Vec<(&'static str, f64)> {
        use Mechanism as M;
        let p = self.p;
        match self.mechanism {
            M::WheelRadiusRatio => vec![("rho", p[0])],
            M::WheelRadiusScale => vec![("s", p[0])],
            M::TrackWidth => vec![("delta", p[0])],
            M::TractionSlip | M::HeadingPull => vec![("c", p[0])],
            M::WheelEccentricity | M::EncoderEccentricity => {
                ["c_left", "s_left", "c_right", "s_right"].into_iter().zip(p).collect()
            }
            M::LostCounts => vec![("k", p[0]), ("w0", p[1] * fastest_rad_s)],
            M::Backlash => vec![("beta_left", p[0]), ("beta_right", p[1])],
            M::CasterKick => vec![("angle", p[0]), ("length", p[1])],
            M::Slope => vec![("k_x", p[0]), ("k_y", p[1]), ("l", p[2])],
            M::CarpetDrift => vec![("d_x", p[0]), ("d_y", p[1])],
            M::MeasurementDelay => vec![("tau", p[0])],
            M::MarkerOffset => vec![("l_x", p[0]), ("l_y", p[1])],
            M::HeadingDrift => vec![("r", p[0])],
            M::GyroBias => vec![("bias", p[0])],
            inside if inside.is_in_catalogue() => vec![("k", p[0])],
            _ => Vec::new(),
        }
    }
}

impl Mechanism {
    /// The greatest strength that a robot can have: a play of five degrees, wheels that differ by 2.4 %.
    pub fn strength_max(self) -> f64 {
        use Mechanism as M;
        match self {
            M::Backlash | M::EncoderEccentricity => 2.0,
            M::WheelRadiusRatio | M::WheelRadiusScale => 3.0,
            M::TurnLoadTransfer | M::SpeedGrowth | M::GyroScale => 4.0,
            M::TrackWidth | M::Scrub | M::CasterKick | M::MeasurementDelay => 5.0,
            M::SideSlip | M::WheelEccentricity | M::TurnAsymmetry => 6.0,
            M::TractionSlip | M::LostCounts | M::HeadingPull | M::Slope | M::CarpetDrift => 8.0,
            // Beyond that the wheel hardly rolls at all on its patch.
            M::SlipperyPatch => 12.0,
            M::Payload | M::ThermalDrift | M::MarkerOffset | M::HeadingDrift | M::GyroBias => 15.0,
            _ => 30.0,
        }
    }

    /// The numbers of a mechanism that is not in the catalogue.
    fn draw<R: Rng>(self, s: f64, draw: &mut Draw<R>) -> [f64; 4] {
        use Mechanism as M;
        // 0 is the left wheel, 1 the right one.
        let wheel = f64::from(u8::from(draw.sign() > 0.0));
        match self {
            M::LateSideSlip => {
                // Over a time \[s\], or if negative over a length \[m\].
                let late =
                    if wheel > 0.0 { draw.between(0.3, 1.0) } else { -draw.between(0.1, 0.3) };
                [0.03 * s, late, 0.0, 0.0]
            }
            M::TurnWithSpeed => [0.05 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::GainWithSpeedAndTurn => [0.1 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::OneWheelGrowth => [0.05 * s * draw.sign(), wheel, 0.0, 0.0],
            M::CurvatureLoadSlip => [0.01 * s, 0.0, 0.0, 0.0],
            M::SlipperyPatch => [(0.05 * s).min(0.6), draw.between(0.4, 0.6), draw.sign(), 0.2],
            M::QuadraticDrift => [2e-4 * s * draw.sign(), 0.0, 0.0, 0.0],
            M::TwoHeadings => [0.01 * s, draw.between(0.0, TAU), 0.0, 0.0],
            M::StictionTurn => [0.005 * s * draw.sign(), draw.between(0.01, 0.03), 0.0, 0.0],
            M::ThirdHarmonic => draw.four(0.01 * s),
            M::DirectionalGain => [0.005 * s * draw.sign(), wheel, 0.0, 0.0],
            inside => unreachable!("{inside:?} is in the catalogue"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_catalogues_effects_and_their_parameters_have_the_catalogues_names() {
        for mechanism in Mechanism::ALL.iter().copied().filter(|one| one.is_in_catalogue()) {
            let found = robot_model::effect::find(mechanism.id());
            let effect = found.unwrap_or_else(|| panic!("{mechanism:?}"));
            let known: Vec<String> = effect
                .facts()
                .parameters
                .iter()
                .map(|parameter| parameter.name.to_string())
                .collect();
            let hidden = Hidden::new(mechanism, 1.0, 7);
            for (name, _) in hidden.true_parameters(10.0) {
                assert!(
                    known.iter().any(|known| known == name),
                    "{} {name}: {known:?}",
                    mechanism.id()
                );
            }
        }
        assert!(Mechanism::ALL.iter().any(|one| !one.is_in_catalogue()));
    }
}
