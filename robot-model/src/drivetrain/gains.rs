//! Gains with a stated margin: the stiffest loop whose sensitivity stays bounded when the constants are 30 % off.
//!
//! ```text
//! P(s) = 1 / (s (kA s + kV))                      volts to travel, friction left out: it damps
//! C(s) = kp + ki / s + kd s H(s)                  H: the speed's mean over its window
//! L(s) = P C exp(-s T)                            T: delay, and one and a half control periods
//! Ms   = max |1 / (1 + L)|                        1 / Ms: the distance of L from -1               (1)
//! ```
//!
//! Of all gains with Ms at most 1.6 for kV and kA of 0.7 and 1.3 times their values, straight on and on the spot, those
//! with the largest ki are taken: a steady push, a slope for one, then takes the robot least far from its setpoint (its
//! sum over time is push / ki). Ms of 1.6 keeps a phase margin of 36 degrees and a gain margin of 2.7 at least, for each
//! of those constants.
//!
//! # Feedforward of the acceleration
//!
//! The feedforward acts late by tau, the delay and half a control period, and the measured speed is W / 2 old. On its
//! profile, e = 0, a wheel that accelerates by a therefore gets kd a W / 2 from the loop, and needs kV for the speed that it
//! will have at t + tau:
//!
//! ```text
//! kA a(t) + kV v(t + tau) = kF a + kV v + kd a W / 2    =>    kF = kA + kV tau - kd W / 2              (2)
//! ```
//!
//! Without (2) the integral would have to find the difference anew after each change of the acceleration.

use nalgebra::Complex;

use super::model::{Drivetrain, WheelMotor};

/// Largest sensitivity.
pub const MS_MAX: f64 = 1.6;
/// Largest complementary sensitivity: no resonance beyond it.
const MT_MAX: f64 = 1.6;
/// The constants are off by so much.
const UNCERTAINTY: f64 = 0.3;
/// One count may change the voltage by this share of the supply.
const COUNT_SHARE: f64 = 0.1;
/// kp that are tried, as shares of kV \[1/s\]: so many, from the first on, each so many times the one before.
const KP_SHARES: (i32, f64, f64) = (52, 0.5, 1.125);
/// kd, as shares of kV.
const KD_SHARES: (i32, f64, f64) = (36, 0.1, 1.15);

/// The controller's gains in volts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Volts per travel error \[V/m\].
    pub kp_v_per_m: f64,
    /// Volts per travel error and time \[V/(m s)\].
    pub ki_v_per_m_s: f64,
    /// Volts per speed error \[V s/m\].
    pub kd_v_s_per_m: f64,
    /// Ms with the constants as they are.
    pub ms: f64,
    /// Ms with the worst constants.
    pub ms_worst: f64,
    /// Where |L| = 1, with the constants as they are \[rad/s\].
    pub crossover_rad_s: f64,
    /// Phase of L there, above -180 degrees \[rad\].
    pub phase_margin_rad: f64,
}

impl Gains {
    /// kF (2) of one wheel, straight on \[V s^2/m\], at least zero.
    pub fn feedforward_ka(
        &self,
        model: &Drivetrain,
        motor: &WheelMotor,
        period_s: f64,
        window_s: f64,
    ) -> f64 {
        let late_s = model.delay_s + 0.5 * period_s;
        let of_speed = 0.5 * window_s * self.kd_v_s_per_m;
        (model.ka_of_robot(motor).0 + motor.kv_v_s_per_m * late_s - of_speed).max(0.0)
    }
}

/// What the loop is made of besides the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopFacts {
    /// Control period \[s\].
    pub period_s: f64,
    /// Time over which the speed is averaged \[s\].
    pub speed_window_s: f64,
    /// Travel of one encoder count \[m\].
    pub meters_per_count: f64,
    /// Supply \[V\].
    pub supply_v: f64,
    /// 1 for the stiffest loop that keeps the margin, less for a softer one.
    pub stiffness: f64,
    /// Largest ki, as a share of kp \[1/s\].
    pub integral_share_max_per_s: f64,
}

/// Why there are no gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GainsError {
    /// No gains keep the margin: the delay is too long, or a count too coarse.
    None,
}

/// One motor as the loop has it.
#[derive(Clone, Copy)]
struct Plant {
    kv: f64,
    ka: f64,
    delay_s: f64,
}

/// The stiffest gains that keep the margin, the same for both wheels.
pub fn design(model: &Drivetrain, facts: &LoopFacts) -> Result<Gains, GainsError> {
    let delay_s = model.delay_s + 1.5 * facts.period_s;
    let plants: Vec<Plant> = [model.wheels.left, model.wheels.right]
        .iter()
        .flat_map(|motor| {
            let (straight, spin) = model.ka_of_robot(motor);
            [straight, spin].map(|ka| Plant { kv: motor.kv_v_s_per_m, ka: ka.max(0.0), delay_s })
        })
        .collect();
    let off: Vec<Plant> = plants
        .iter()
        .flat_map(|plant| {
            [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)].map(|(kv, ka)| Plant {
                kv: plant.kv * (1.0 + UNCERTAINTY * kv),
                ka: plant.ka * (1.0 + UNCERTAINTY * ka),
                delay_s,
            })
        })
        .collect();
    let kv = plants.iter().map(|plant| plant.kv).sum::<f64>() / plants.len() as f64;
    let kp_max = COUNT_SHARE * facts.supply_v / facts.meters_per_count;
    let kd_max = kp_max * facts.speed_window_s;
    let keeps = |gains: &Trial| {
        off.iter().all(|plant| {
            let (ms, mt) = gains.sensitivities(plant, facts.speed_window_s);
            ms <= MS_MAX && mt <= MT_MAX
        })
    };
    let tried = |(len, first, ratio): (i32, f64, f64)| {
        (0..len).map(move |step| kv * first * ratio.powi(step))
    };
    let mut best: Option<Trial> = None;
    for kp in tried(KP_SHARES).take_while(|kp| *kp <= kp_max) {
        for kd in [0.0].into_iter().chain(tried(KD_SHARES)).take_while(|kd| *kd <= kd_max) {
            let trial = |ki: f64| Trial { kp, ki, kd };
            // Most trials end here: they keep no margin with as much ki as the best has.
            if !keeps(&trial(best.map_or(0.0, |best| best.ki))) {
                continue;
            }
            let (mut low, mut high) = (0.0, kp * (kp / kv).min(facts.integral_share_max_per_s));
            for _ in 0..12 {
                let middle = 0.5 * (low + high);
                if keeps(&trial(middle)) { low = middle } else { high = middle }
            }
            if best.is_none_or(|best| low > best.ki) {
                best = Some(trial(low));
            }
        }
    }
    let best = best.ok_or(GainsError::None)?.softened(facts.stiffness);
    let nominal = plants.iter().map(|plant| best.sensitivities(plant, facts.speed_window_s).0);
    let worst = off.iter().map(|plant| best.sensitivities(plant, facts.speed_window_s).0);
    let (crossover_rad_s, phase_margin_rad) = best.crossover(&plants[0], facts.speed_window_s);
    Ok(Gains {
        kp_v_per_m: best.kp,
        ki_v_per_m_s: best.ki,
        kd_v_s_per_m: best.kd,
        ms: nominal.fold(0.0, f64::max),
        ms_worst: worst.fold(0.0, f64::max),
        crossover_rad_s,
        phase_margin_rad,
    })
}

/// Gains on trial, in volts.
#[derive(Clone, Copy)]
struct Trial {
    kp: f64,
    ki: f64,
    kd: f64,
}

impl Trial {
    /// As slow as a loop of this share of the speed.
    fn softened(self, stiffness: f64) -> Self {
        let Self { kp, ki, kd } = self;
        Self { kp: kp * stiffness, ki: ki * stiffness * stiffness, kd: kd * stiffness.sqrt() }
    }

    fn open_loop(&self, plant: &Plant, window_s: f64, rad_s: f64) -> Complex<f64> {
        let s = Complex::new(0.0, rad_s);
        let late = |time_s: f64| Complex::from_polar(1.0, -rad_s * time_s);
        // s H(s) = (1 - exp(-s W)) / W
        let speed = (Complex::new(1.0, 0.0) - late(window_s)) / window_s;
        let controller = self.ki / s + self.kd * speed + self.kp;
        let motor = s * (s * plant.ka + plant.kv);
        controller / motor * late(plant.delay_s)
    }

    /// The frequencies that matter \[rad/s\].
    fn frequencies() -> impl Iterator<Item = f64> {
        (0..72).map(|i| 0.5 * 1.12_f64.powi(i))
    }

    /// Largest |1 / (1 + L)| and |L / (1 + L)|; infinite if the closed loop is unstable.
    fn sensitivities(&self, plant: &Plant, window_s: f64) -> (f64, f64) {
        let (mut ms, mut mt) = (0.0_f64, 0.0_f64);
        for rad_s in Self::frequencies() {
            let open = self.open_loop(plant, window_s, rad_s);
            let apart = (open + 1.0).norm();
            ms = ms.max(1.0 / apart);
            mt = mt.max(open.norm() / apart);
        }
        let (_, margin) = self.crossover(plant, window_s);
        if margin <= 0.0 { (f64::INFINITY, f64::INFINITY) } else { (ms, mt) }
    }

    /// The last frequency at which |L| = 1, and the phase above -180 degrees there.
    fn crossover(&self, plant: &Plant, window_s: f64) -> (f64, f64) {
        let mut last = (0.0, std::f64::consts::PI);
        for rad_s in Self::frequencies() {
            let open = self.open_loop(plant, window_s, rad_s);
            if open.norm() >= 1.0 {
                // L begins at -180 degrees, or at -90 without ki, and falls: its angle is taken without a jump.
                let angle = open.arg();
                let margin = if angle > 0.0 {
                    angle - std::f64::consts::PI
                } else {
                    angle + std::f64::consts::PI
                };
                last = (rad_s, margin);
            }
        }
        last
    }
}
