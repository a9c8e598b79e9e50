//! From the motors' constants and the gains to a configuration.

use robot_model::drivetrain::{self, DrivetrainFit, Gains, LoopFacts, WheelMotor};
use serde::{Deserialize, Serialize};
use shared_proto::{
    Config, FeedforwardConfig, LimitsConfig, PidConfig, ProtectionConfig, WheelFeedforward,
    WheelPair,
};

use super::following;
use super::shortfall::Shortfall;
use crate::error::{Error, Result};
use crate::undo::{Restorable, Undo};

/// The firmware's control period, and the time over which it averages speeds \[s\].
const PERIOD_S: f64 = 1e-3;
const SPEED_WINDOW_S: f64 = 0.04;
/// The firmware compares the measured speed with the setpoint's of so long ago, and adds kd times this to kA \[s\].
const SETPOINT_LAG_S: f64 = 0.016;
/// Duty that the encoder check may take in the experiments: motors with much friction need it.
const PROBE_DUTY: f64 = 0.5;
/// The encoder check lets a wheel roll by 6.8 mm, or 6 counts if they are longer \[m\].
pub const CHECK_COUNT_M: f64 = 0.0068 / 6.0;
/// It turns a wheel for so long and so many stall times, if it needs to; while its duty rises, half as far. Longest stall time.
const CHECK_RISE_S: f64 = 0.2;
const CHECK_STALL_TIMES: f64 = 7.0;
const STALL_TIME_S_MAX: f64 = 0.09;
/// The encoder check leaves a wheel so many counts ahead, or this far, if it is more \[m\].
const CHECK_COUNTS: f64 = 3.5;
const CHECK_M: f64 = 2e-4;
/// What the integral took up meanwhile may put the wheel off by so many counts, or by as much as a quiet supply's noise does
/// \[m\], if that is more.
const WOUND_UP_COUNTS: f64 = 0.5;
const WOUND_UP_M: f64 = 2e-5;
/// The nominal supply is a multiple of a tenth of a volt, so that the same battery gives the same number.
const SUPPLY_STEPS_PER_V: f64 = 10.0;
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

/// What the encoder check reckons with, as long as the motors are not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckFor {
    /// Friction \[V\].
    pub ks_v: f64,
    /// The motors are so many times as slow as the configuration has it.
    pub slower: f64,
}

/// The same configuration with an encoder check for such motors.
pub fn for_experiments(config: &Config, CheckFor { ks_v, slower }: CheckFor) -> Config {
    let mut config = config.clone();
    config.protection.probe_duty_max = config.protection.probe_duty_max.max(PROBE_DUTY);
    for wheel in [&mut config.feedforward.left, &mut config.feedforward.right] {
        wheel.ks_forward_v = wheel.ks_forward_v.max(ks_v);
        wheel.ks_backward_v = wheel.ks_backward_v.max(ks_v);
        wheel.kv_v_s_per_m *= slower;
    }
    if slower > 1.0 {
        allow_longest_check(&mut config);
    }
    config
}

/// The encoder check holds its duty for some stall times: a slow motor with long counts needs the longest.
fn allow_longest_check(config: &mut Config) {
    let stall_time_s = &mut config.protection.stall_time_s;
    *stall_time_s = stall_time_s.max(STALL_TIME_S_MAX);
}

/// Whether the encoder check may end before a wheel has turned by the counts that it needs.
fn check_is_short(config: &Config) -> bool {
    let FeedforwardConfig { left, right, .. } = config.feedforward;
    let full_v = config.protection.probe_duty_max * config.feedforward.nominal_v();
    let time_s = CHECK_RISE_S + CHECK_STALL_TIMES * config.protection.stall_time_s;
    let is_short = |wheel: WheelFeedforward, count_m: f64| {
        let ks_v = wheel.ks_forward_v.max(wheel.ks_backward_v);
        let way_m = time_s * (full_v - ks_v).max(0.0) / wheel.kv_v_s_per_m.max(1e-3);
        count_m > CHECK_COUNT_M && way_m < CHECK_COUNTS * count_m
    };
    let counts_m = config.encoder.map(|encoder| config.meters_per_count(&encoder));
    is_short(left, counts_m.left) || is_short(right, counts_m.right)
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
        integral_share_max_per_s: integral_share_max_per_s(
            counts_m.left.max(counts_m.right),
            config.geometry.wheel_radius_m,
        ),
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
        tuned.feedforward.supply_v = (supply_v * SUPPLY_STEPS_PER_V).round() / SUPPLY_STEPS_PER_V;
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
    tuned.protection.probe_duty_max = tuned.protection.probe_duty_max.max(check).min(PROBE_DUTY);
    if check_is_short(&tuned) {
        allow_longest_check(&mut tuned);
    }
    let protection = &mut tuned.protection;
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

/// The same with what drives have shown to be missing in the feedforward. If the robot is pushed, friction is what both directions
/// lack.
pub fn refined(tuned: &Config, shortfall: &Shortfall, pushed: bool) -> Config {
    let mut refined = tuned.clone();
    let FeedforwardConfig { left, right, .. } = tuned.feedforward;
    let kv = WheelPair { left: left.kv_v_s_per_m, right: right.kv_v_s_per_m };
    let missing = shortfall.missing_v(kv);
    // The measured speed is half a window old, the setpoint's a little less: this much is meant to come from the loop.
    let meant_v_s2_per_m = (0.5 * SPEED_WINDOW_S - SETPOINT_LAG_S)
        * tuned.pid.kd_s_per_m
        * tuned.feedforward.nominal_v();
    let FeedforwardConfig { left, right, .. } = &mut refined.feedforward;
    for (wheel, missing) in [(left, missing.left), (right, missing.right)] {
        let Some(missing) = missing else { continue };
        let mean_v = 0.5 * (missing.ks_forward + missing.ks_backward);
        let of_direction = |missing_v: f64| if pushed { mean_v } else { missing_v };
        wheel.ks_forward_v = (wheel.ks_forward_v + of_direction(missing.ks_forward)).max(0.0);
        wheel.ks_backward_v = (wheel.ks_backward_v + of_direction(missing.ks_backward)).max(0.0);
        wheel.kv_v_s_per_m = (wheel.kv_v_s_per_m + missing.kv).max(0.0);
        wheel.ka_v_s2_per_m = (wheel.ka_v_s2_per_m + missing.ka - meant_v_s2_per_m).max(0.0);
    }
    refined
}

/// Largest ki, as a share of kp \[1/s\]: what the encoder check leaves must not wind up the integral.
///
/// The check leaves a wheel a little ahead. Until the paper's profile has caught up with it, the integral takes up
/// 2/3 of that distance times that time, and the wheel is then off by this, times ki / kp.
fn integral_share_max_per_s(count_m: f64, wheel_radius_m: f64) -> f64 {
    let ahead_m = (CHECK_COUNTS * count_m).max(CHECK_M);
    let caught_up_s = (2.0 * ahead_m / following::paper_acceleration_mps2(wheel_radius_m)).sqrt();
    let tolerated_m = (WOUND_UP_COUNTS * count_m).max(WOUND_UP_M);
    tolerated_m / (2.0 / 3.0 * ahead_m * caught_up_s)
}

#[cfg(test)]
mod tests {
    use shared_proto::{Config, Wheel};

    use super::{
        CheckFor, STALL_TIME_S_MAX, Shortfall, check_is_short, for_experiments,
        integral_share_max_per_s, refined,
    };

    /// A robot with such counts and motors.
    fn config(counts_per_rev: f64, kv_v_s_per_m: f64) -> Config {
        let mut config = Config::default();
        config.protection.probe_duty_max = 0.5;
        config.feedforward.left.kv_v_s_per_m = kv_v_s_per_m;
        config.feedforward.right.kv_v_s_per_m = kv_v_s_per_m;
        for wheel in Wheel::BOTH {
            let encoder = config.encoder.get_mut(wheel);
            (encoder.counts_per_rev, encoder.gear_reduction) = (counts_per_rev, 1.0);
        }
        config
    }

    #[test]
    fn long_counts_bound_the_integral_more_than_fine_ones() {
        let coarse = integral_share_max_per_s(0.015, 0.04);
        assert!((0.02..0.3).contains(&coarse), "{coarse}");
        let fine = integral_share_max_per_s(3e-5, 0.04);
        assert!((0.5..5.0).contains(&fine), "{fine}");
    }

    #[test]
    fn a_slow_motor_with_long_counts_gets_the_longest_encoder_check_and_no_other_robot() {
        assert!(check_is_short(&config(15.0, 80.0)));
        assert!(!check_is_short(&config(15.0, 12.0)));
        assert!(!check_is_short(&config(2000.0, 60.0)));
        let known = Config::default();
        let first = for_experiments(&known, CheckFor { ks_v: 0.5, slower: 1.0 });
        assert_eq!(first.protection.stall_time_s, known.protection.stall_time_s);
        let slow = for_experiments(&known, CheckFor { ks_v: 0.5, slower: 4.0 });
        assert_eq!(slow.protection.stall_time_s, STALL_TIME_S_MAX);
        assert_eq!(slow.feedforward.left.kv_v_s_per_m, 4.0 * known.feedforward.left.kv_v_s_per_m);
    }

    #[test]
    fn a_drive_that_tells_nothing_changes_nothing() {
        let known = Config::default();
        assert_eq!(refined(&known, &Shortfall::default(), false), known);
    }
}
