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

use nalgebra::Complex;

use super::model::Drivetrain;

/// Largest sensitivity.
pub const MS_MAX: f64 = 1.6;
/// Largest complementary sensitivity: no resonance beyond it.
const MT_MAX: f64 = 1.6;
/// The constants are off by so much.
const UNCERTAINTY: f64 = 0.3;
/// One count may change the voltage by this share of the supply.
const COUNT_SHARE: f64 = 0.1;

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
    let mut best: Option<Trial> = None;
    for step in 0..40 {
        // From 0.5 /s to 200 /s times kV, in steps of a sixth.
        let kp = kv * 0.5 * 1.165_f64.powi(step);
        if kp > kp_max {
            break;
        }
        for kd in [0.0, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.2, 3.2].map(|share| share * kv) {
            if kd > kd_max {
                continue;
            }
            let trial = |ki: f64| Trial { kp, ki, kd };
            if !keeps(&trial(0.0)) {
                continue;
            }
            let (mut low, mut high) = (0.0, kp * kp / kv);
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
