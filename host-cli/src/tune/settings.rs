//! From the motors' constants and the gains to a configuration.

use robot_model::drivetrain::{self, DrivetrainFit, Gains, LoopFacts, WheelMotor};
use serde::{Deserialize, Serialize};
use shared_proto::{
    Config, FeedforwardConfig, LimitsConfig, PidConfig, ProtectionConfig, WheelFeedforward,
    WheelPair,
};

use crate::error::{Error, Result};
use crate::undo::{Restorable, Undo};

/// The firmware's control period, and the time over which it averages speeds \[s\].
const PERIOD_S: f64 = 1e-3;
const SPEED_WINDOW_S: f64 = 0.04;
/// Duty that the encoder check may take in the experiments: motors with much friction need it.
const PROBE_DUTY: f64 = 0.5;
/// The encoder check lets a wheel roll by 6.8 mm, or 6 counts if they are longer \[m\].
const CHECK_COUNT_M: f64 = 0.0068 / 6.0;
/// A wheel may be so many counts off its setpoint before that is a fault.
const COUNTS_OFF: f64 = 6.0;
/// Of the supply, for the fastest motion: the rest is for the loop, and for a battery that runs down.
const USABLE: f64 = 0.8;

/// What `tune` changes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopConfig {
    /// The gains.
    pub pid: PidConfig,
    /// The feedforward.
    pub feedforward: FeedforwardConfig,
    /// The limits.
    pub limits: LimitsConfig,
    /// The protection.
    pub protection: ProtectionConfig,
}

impl Restorable for LoopConfig {
    const FILE: &'static str = "undo-tune";
    const NOTHING: (&'static str, &'static str) = (
        "no tuning of this robot to undo",
        "only what this computer tuned last can be undone; `beeline config set` sets any gain",
    );

    fn of(config: &Config) -> Self {
        let Config { pid, feedforward, limits, protection, .. } = *config;
        Self { pid, feedforward, limits, protection }
    }

    fn put_into(self, config: &mut Config) {
        (config.pid, config.feedforward) = (self.pid, self.feedforward);
        (config.limits, config.protection) = (self.limits, self.protection);
    }

    fn changed_since(_now: Self, _undo: &Undo<Self>) -> Error {
        Error::new("the robot's gains, feedforward or limits were changed after `beeline tune`")
            .hint("set the values that you want, for example with `beeline config set pid.kp_per_m ...`")
    }
}

/// The same configuration with an encoder check for motors with this much friction \[V\].
pub fn for_experiments(config: &Config, ks_v: f64) -> Config {
    let mut config = config.clone();
    config.protection.probe_duty_max = config.protection.probe_duty_max.max(PROBE_DUTY);
    for wheel in [&mut config.feedforward.left, &mut config.feedforward.right] {
        wheel.ks_forward_v = wheel.ks_forward_v.max(ks_v);
        wheel.ks_backward_v = wheel.ks_backward_v.max(ks_v);
    }
    config
}

/// Gains for both wheels.
pub fn design(
    config: &Config,
    fit: &DrivetrainFit,
    supply_v: f64,
    stiffness: f64,
) -> Result<Gains> {
    let counts_m = config.encoder.map(|encoder| config.meters_per_count(&encoder));
    let facts = LoopFacts {
        period_s: PERIOD_S,
        speed_window_s: SPEED_WINDOW_S,
        meters_per_count: counts_m.left.max(counts_m.right),
        supply_v,
        stiffness,
    };
    drivetrain::design(&fit.constants.value, &facts).map_err(|_| {
        Error::said_no("no gains are stable enough on these motors: the delay is too long, or a count too coarse")
            .hint("an encoder on the motor's shaft has a finer resolution than one on the wheel's")
    })
}

/// The configuration with these constants and gains.
pub fn tuned(config: &Config, fit: &DrivetrainFit, gains: &Gains, supply_v: f64) -> Config {
    let mut tuned = config.clone();
    let model = &fit.constants.value;
    // A push is this floor's: the friction that goes with the robot is the mean.
    let pushed = fit.constants.load_disturbance().is_some();
    let wheel = |motor: &WheelMotor| WheelFeedforward {
        ks_forward_v: if pushed { motor.ks_mean_v() } else { motor.ks_forward_v },
        ks_backward_v: if pushed { motor.ks_mean_v() } else { motor.ks_backward_v },
        kv_v_s_per_m: motor.kv_v_s_per_m,
        // Profiles are straight on, mostly.
        ka_v_s2_per_m: gains.feedforward_ka(model, motor, PERIOD_S, SPEED_WINDOW_S),
    };
    tuned.feedforward.left = wheel(&model.wheels.left);
    tuned.feedforward.right = wheel(&model.wheels.right);
    if tuned.protection.supply_v_min > 0.0 {
        // Rounded, so that the same battery gives the same number.
        tuned.feedforward.supply_v = (supply_v * 2.0).round() / 2.0;
    }
    let nominal_v = tuned.feedforward.nominal_v();
    tuned.pid = PidConfig {
        kp_per_m: gains.kp_v_per_m / nominal_v,
        ki_per_m_s: gains.ki_v_per_m_s / nominal_v,
        kd_s_per_m: gains.kd_v_s_per_m / nominal_v,
    };
    // The encoder check has to turn the wheels, and a count is not to look like a fault.
    let FeedforwardConfig { left, right, .. } = tuned.feedforward;
    let ks_v = [left, right].map(|wheel| wheel.ks_forward_v.max(wheel.ks_backward_v));
    let check = 1.5 * ks_v[0].max(ks_v[1]) / nominal_v + 0.1;
    let counts_m = tuned.encoder.map(|encoder| tuned.meters_per_count(&encoder));
    let count_m = counts_m.left.max(counts_m.right);
    // With long counts it needs the duty that it had in the experiments.
    let check = if count_m > CHECK_COUNT_M { PROBE_DUTY } else { check };
    let protection = &mut tuned.protection;
    protection.probe_duty_max = protection.probe_duty_max.max(check).min(PROBE_DUTY);
    let off_m = COUNTS_OFF * count_m;
    protection.following_error_m_max = protection.following_error_m_max.max(off_m).min(1.0);
    // No profile that the motors cannot follow.
    for motor in [model.wheels.left, model.wheels.right] {
        let ks_v = motor.ks_forward_v.max(motor.ks_backward_v);
        let free_v = (USABLE * tuned.limits.duty_max * supply_v - ks_v).max(0.0);
        let limits = &mut tuned.limits;
        limits.speed_mps_max = limits.speed_mps_max.min(free_v / motor.kv_v_s_per_m).max(0.001);
        let left_v = (free_v - motor.kv_v_s_per_m * limits.speed_mps_max).max(0.1 * free_v);
        let ka = model.ka_of_robot(&motor).0.max(1e-9);
        let steepest = left_v.max(0.25 * free_v) / ka;
        limits.acceleration_mps2_max = limits.acceleration_mps2_max.min(steepest).max(0.001);
        limits.stop_deceleration_mps2 = limits.stop_deceleration_mps2.min(steepest).max(0.05);
    }
    tuned
}

/// The same with the feedforward of the acceleration that a drive has shown to be missing; `feedback_s2_per_m` is what the loop
/// added, as a share of the nominal supply.
pub fn refined(tuned: &Config, feedback_s2_per_m: WheelPair<f64>) -> Config {
    let mut refined = tuned.clone();
    let nominal_v = tuned.feedforward.nominal_v();
    // The measured speed is half a window old: this much is meant to come from the loop.
    let meant_s2_per_m = 0.5 * SPEED_WINDOW_S * tuned.pid.kd_s_per_m;
    let FeedforwardConfig { left, right, .. } = &mut refined.feedforward;
    for (wheel, added) in [(left, feedback_s2_per_m.left), (right, feedback_s2_per_m.right)] {
        let missing_v_s2_per_m = (added - meant_s2_per_m) * nominal_v;
        wheel.ka_v_s2_per_m = (wheel.ka_v_s2_per_m + missing_v_s2_per_m).max(0.0);
    }
    refined
}
