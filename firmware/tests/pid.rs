//! The controller against its equations in f64, over every accepted configuration.

use std::f64::consts::TAU;

use firmware::pid::{self, Gains, PidState};
use firmware::profile::Setpoint;
use firmware::supply::UNSCALED;
use firmware::units::{Acceleration, Speed, Travel};
use fixed::types::{I8F24, I32F32};
use proptest::prelude::*;
use shared_proto::{Config, Wheel, WheelFeedforward};

const DT_S: f64 = 1e-3;
/// The default configuration's.
const NOMINAL_V: f64 = 12.0;
/// By how much the setpoint's speed lags \[ticks\], and the same in seconds, in the controller's steps of 2^-20 s.
const LAG_TICKS: f64 = 16.0;
const LAG_S: f64 = 16_777.0 / 1_048_576.0;
/// A step of a speed \[m/s\].
const SPEED_STEP: f64 = 1.0 / 16_777_216.0;

/// Gains and limits anywhere in their ranges, each decade as likely as the next, and zero.
fn configs() -> impl Strategy<Value = Config> {
    let gain = |max: f64| prop_oneof![4 => (-4.0..max.log10()).prop_map(|e| 10f64.powf(e)), 1 => Just(0.0), 1 => Just(max)];
    (
        (gain(1e4), gain(1e4), gain(1e3)),
        (0.0..=0.5, gain(1e3), gain(100.0)),
        (prop_oneof![0.05..=1.0, Just(1.0)], prop_oneof![0.5..=1000.0, Just(1000.0)]),
    )
        .prop_map(|((kp, ki, kd), (ks, kv, ka), (duty_max, slew))| {
            let mut config = Config::default();
            (config.pid.kp_per_m, config.pid.ki_per_m_s, config.pid.kd_s_per_m) = (kp, ki, kd);
            // Shares of the nominal supply, as the equations have them. Nothing of the right wheel's comes in.
            config.feedforward.left = WheelFeedforward {
                ks_forward_v: ks * NOMINAL_V,
                ks_backward_v: (0.5 - ks) * NOMINAL_V,
                kv_v_s_per_m: kv * NOMINAL_V,
                ka_v_s2_per_m: ka * NOMINAL_V,
            };
            (config.limits.duty_max, config.limits.duty_slew_per_s) = (duty_max, slew);
            config.validate().unwrap();
            config
        })
}

/// Any bits at all.
fn wild() -> impl Strategy<Value = (Setpoint, Travel, Speed)> {
    (any::<[i64; 2]>(), any::<[i32; 3]>()).prop_map(|([s, s_m], [v, a, v_m])| {
        let setpoint = Setpoint {
            travel: Travel(I32F32::from_bits(s)),
            speed: Speed(I8F24::from_bits(v)),
            acceleration: Acceleration(I8F24::from_bits(a)),
        };
        (setpoint, Travel(I32F32::from_bits(s_m)), Speed(I8F24::from_bits(v_m)))
    })
}

/// What a robot meets: error to 1 m, speed to 20 m/s, acceleration to 100 m/s^2.
fn tame() -> impl Strategy<Value = (Setpoint, Travel, Speed)> {
    (-1e4..1e4, -1.0..1.0, -20.0..20.0, -1.0..1.0, -100.0..100.0).prop_map(|(s, e, v, v_e, a)| {
        let (speed, acceleration) = (Speed::from_si(v), Acceleration::from_si(a));
        let setpoint = Setpoint { travel: Travel::from_si(s), speed, acceleration };
        // Small errors are as likely as large ones.
        (setpoint, Travel::from_si(s - e * e * e), Speed::from_si(v - v_e * v_e * v_e))
    })
}

fn rest_band_m(config: &Config) -> f64 {
    let q_m = TAU * config.geometry.wheel_radius_m / config.encoder.left.counts_per_rev;
    q_m.max(0.25e-3)
}

/// The equations (1) to (5) as they stand.
#[derive(Default)]
struct Reference {
    integral: f64,
    duty: f64,
    /// v_r, in whole steps of a speed.
    lagging: f64,
}

impl Reference {
    fn step(&mut self, config: &Config, setpoint: &Setpoint, travel: Travel, speed: Speed) {
        let (pid, feedforward, limits) = (&config.pid, &config.feedforward, &config.limits);
        let e = (setpoint.travel.0 - travel.0).to_num::<f64>();
        let (v, a) = (setpoint.speed.to_si(), setpoint.acceleration.to_si());
        let sign = if v == 0.0 { 0.0 } else { v.signum() };
        let v_r = self.lagging * SPEED_STEP;
        self.lagging += ((v / SPEED_STEP - self.lagging) / LAG_TICKS).floor();
        let feedforward = &feedforward.left;
        let ks_v = if v < 0.0 { feedforward.ks_backward_v } else { feedforward.ks_forward_v };
        let wanted = (ks_v * sign + feedforward.kv_v_s_per_m * v + feedforward.ka_v_s2_per_m * a)
            / NOMINAL_V
            + pid.kp_per_m * e
            + self.integral
            + pid.kd_s_per_m * (v_r - speed.to_si() + LAG_S * a);
        let change = limits.duty_slew_per_s * DT_S;
        let low = (self.duty - change).max(-limits.duty_max);
        let high = (self.duty + change).min(limits.duty_max);
        self.duty = wanted.clamp(low, high);
        let unseen = v == 0.0 && e.abs() < rest_band_m(config);
        let into_limit = (wanted > high && e > 0.0) || (wanted < low && e < 0.0);
        if !unseen && !into_limit {
            self.integral = (self.integral + pid.ki_per_m_s * e * DT_S)
                .clamp(-limits.duty_max, limits.duty_max);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn limit_and_slew_hold_for_any_inputs_and_nothing_overflows(
        config in configs(), inputs in prop::collection::vec(prop_oneof![wild(), tame()], 1..60),
    ) {
        let (gains, mut state) = (Gains::new(&config, Wheel::Left), PidState::default());
        let mut last = 0.0;
        for (setpoint, travel, speed) in inputs {
            let duty = pid::step(&gains, &mut state, &setpoint, travel, speed, UNSCALED).to_si();
            state.terms();
            // To the step of a duty, 2^-30.
            prop_assert!(duty.abs() <= config.limits.duty_max + 1e-9);
            prop_assert!((duty - last).abs() <= config.limits.duty_slew_per_s * DT_S + 1e-9);
            last = duty;
        }
    }

    #[test]
    fn one_tick_is_the_equations_to_the_resolution_of_the_gains(
        config in configs(), (setpoint, travel, speed) in tame(),
    ) {
        let mut unlimited = config;
        unlimited.limits.duty_max = 1.0;
        unlimited.limits.duty_slew_per_s = 1000.0;
        let (gains, mut state) = (Gains::new(&unlimited, Wheel::Left), PidState::default());
        let mut reference = Reference::default();
        let duty = pid::step(&gains, &mut state, &setpoint, travel, speed, UNSCALED);
        reference.step(&unlimited, &setpoint, travel, speed);
        // Half a step of kp times 1 m, of kv and kd times 41 m/s together, of ka times 100 m/s^2, and a step of its part
        // from kd; a step of the error times kp.
        let resolution = 0.5f64.powi(15) + 41.0 * 0.5f64.powi(21) + 300.0 * 0.5f64.powi(21)
            + unlimited.pid.kp_per_m * 0.5f64.powi(30) + 1e-8;
        prop_assert!((duty.to_si() - reference.duty).abs() <= resolution, "{} {}", duty.to_si(), reference.duty);
    }

    #[test]
    fn many_ticks_follow_the_equations_with_integral_and_limits(
        config in configs(),
        inputs in prop::collection::vec((-1e-3..1e-3, -0.6..0.6, -1.0..1.0, -0.05..0.05), 100),
    ) {
        let (gains, mut state) = (Gains::new(&config, Wheel::Left), PidState::default());
        let mut reference = Reference::default();
        for (e, v, a, v_e) in inputs {
            let setpoint = Setpoint {
                travel: Travel::from_si(1000.0),
                speed: Speed::from_si(v),
                acceleration: Acceleration::from_si(a),
            };
            let (travel, speed) = (Travel::from_si(1000.0 - e), Speed::from_si(v - v_e));
            let duty = pid::step(&gains, &mut state, &setpoint, travel, speed, UNSCALED);
            reference.step(&config, &setpoint, travel, speed);
            // As above, for 1 mm, 0.65 m/s, 1 m/s^2; the integral over 100 ticks; and where a limit
            // is just met, one tick's increment of ki = 10^4 goes in or not.
            let edge = config.pid.ki_per_m_s * 1e-3 * DT_S;
            let resolution = 3e-6 + (config.pid.kp_per_m + 0.1 * config.pid.ki_per_m_s) * 0.5f64.powi(30);
            let off = (duty.to_si() - reference.duty).abs();
            prop_assert!(off <= resolution + edge * 1.01, "{} {}", duty.to_si(), reference.duty);
            if off > resolution { return Ok(()) }
        }
    }
}

#[test]
fn the_integral_does_not_wind_up_while_the_output_is_limited() {
    let config = Config::default();
    let (gains, mut state) = (Gains::new(&config, Wheel::Left), PidState::default());
    let setpoint = Setpoint { travel: Travel::from_si(0.5), ..Setpoint::default() };
    // Held back by 0.5 m for 10 s: kp e alone is 20 times full duty.
    for _ in 0..10_000 {
        pid::step(&gains, &mut state, &setpoint, Travel::default(), Speed::default(), UNSCALED);
    }
    assert_eq!(state.duty().to_si(), 1.0);
    assert_eq!(state.terms().integral, 0);
    // Once released and there, the drive is gone as fast as the slew limit allows: 1 / 20 s.
    for _ in 0..50 {
        pid::step(&gains, &mut state, &setpoint, setpoint.travel, Speed::default(), UNSCALED);
    }
    // 50 roundings of the slew limit to 2^-30.
    assert!(state.duty().to_si().abs() < 50.0 * 0.5f64.powi(30));
}

#[test]
fn an_error_below_a_count_of_a_wheel_that_should_stand_is_not_summed() {
    let config = Config::default();
    let q_m = rest_band_m(&config);
    let gains = Gains::new(&config, Wheel::Left);
    // (v, e in counts, whether it is summed).
    for (v, counts, summed) in [
        (0.0, 0.9, false),
        (0.0, -0.9, false),
        (0.0, 1.1, true),
        (0.0, -1.1, true),
        (0.01, 0.9, true),
    ] {
        let mut state = PidState::default();
        let travel = Travel::from_si(counts * q_m);
        let setpoint = Setpoint { travel, speed: Speed::from_si(v), ..Setpoint::default() };
        for _ in 0..10_000 {
            pid::step(
                &gains,
                &mut state,
                &setpoint,
                Travel::default(),
                Speed::from_si(v),
                UNSCALED,
            );
        }
        assert_eq!(state.terms().integral != 0, summed, "{v} m/s, {counts} counts");
    }
}

#[test]
fn friction_is_fed_forward_with_the_sign_of_the_speed_and_not_at_standstill() {
    let gains = Gains::new(&Config::default(), Wheel::Left);
    for (speed, expected) in [(1e-3, 0.042), (-1e-3, -0.042), (0.0, 0.0)] {
        let mut state = PidState::default();
        let speed = Speed::from_si(speed);
        let setpoint = Setpoint { speed, ..Setpoint::default() };
        pid::step(&gains, &mut state, &setpoint, Travel::default(), speed, UNSCALED);
        assert!((f64::from(state.terms().feedforward) / 32767.0 - expected).abs() < 2e-5);
    }
}

#[test]
fn each_term_shows_in_telemetry_by_itself() {
    let mut config = Config::default();
    // No slew limit, which would hold the integral back at the first tick.
    config.limits.duty_slew_per_s = 1000.0;
    let (gains, mut state) = (Gains::new(&config, Wheel::Left), PidState::default());
    let setpoint = Setpoint { travel: Travel::from_si(0.001), ..Setpoint::default() };
    for _ in 0..101 {
        pid::step(&gains, &mut state, &setpoint, Travel::default(), Speed::from_si(0.01), UNSCALED);
    }
    let terms = state.terms();
    // 40/m x 1 mm, 60/(m s) x 1 mm x 0.1 s, 1 s/m x -0.01 m/s
    for (term, expected) in
        [(terms.proportional, 0.04), (terms.integral, 0.006), (terms.derivative, -0.01)]
    {
        assert!((f64::from(term) / 32767.0 - expected).abs() < 2e-5, "{term} for {expected}");
    }
    assert_eq!(terms.feedforward, 0);
}

/// The mean of the last 40 ms, as the encoder measures speed.
struct Window([f64; 41]);

impl Window {
    fn measure(&mut self, speed: f64) -> f64 {
        self.0.rotate_left(1);
        self.0[40] = speed;
        // From edge to edge: half of the first and of the last.
        (self.0.iter().sum::<f64>() - 0.5 * (self.0[0] + self.0[40])) / 40.0
    }
}

#[test]
fn an_acceleration_that_begins_or_ends_leaves_no_sum_of_the_derivative_term() {
    let mut config = Config::default();
    config.limits.duty_slew_per_s = 1000.0;
    // A wheel that is where it should be: no kA is needed, as nothing else than the derivative is looked at.
    config.feedforward.left = WheelFeedforward {
        ks_forward_v: 0.0,
        ks_backward_v: 0.0,
        kv_v_s_per_m: 0.0,
        ka_v_s2_per_m: 0.0,
    };
    (config.pid.kp_per_m, config.pid.ki_per_m_s) = (0.0, 0.0);
    let (gains, mut state) = (Gains::new(&config, Wheel::Left), PidState::default());
    let mut window = Window([0.0; 41]);
    let (mut v, mut sums) = (0.0, [0.0; 2]);
    for tick in 0..1000 {
        // Up for half a second, then even.
        let a = if tick < 500 { 0.5 } else { 0.0 };
        v += a * DT_S;
        let (speed, acceleration) = (Speed::from_si(v), Acceleration::from_si(a));
        let setpoint = Setpoint { speed, acceleration, ..Setpoint::default() };
        let measured = Speed::from_si(window.measure(v));
        let duty = pid::step(&gains, &mut state, &setpoint, Travel::default(), measured, UNSCALED);
        // kF is meant to be kd W / 2 smaller: what is left is what the lags do not cancel.
        let left = duty.to_si() - config.pid.kd_s_per_m * 0.02 * a;
        sums[usize::from(tick >= 500)] += left * DT_S;
    }
    // Without the lag: kd a times 40 ms squared, a sixth, 1.3e-4 s of duty, either way.
    for sum in sums {
        assert!(sum.abs() < 2e-5, "{sums:?}");
    }
}
