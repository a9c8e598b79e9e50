//! Counting and speed, against a wheel whose motion is known by formula.

use firmware::encoder::{CounterExtender, SpeedEstimator};
use firmware::units::MetersPerCount;
use proptest::prelude::*;

/// The paper's encoder: 2 pi 0.036 m / 900.
const Q_M: f64 = core::f64::consts::TAU * 0.036 / 900.0;

proptest! {
    #[test]
    fn extending_16_bits_follows_the_true_count_both_ways(
        start in any::<u16>(), steps in prop::collection::vec(-32_767i64..=32_767, 1..200),
    ) {
        let mut extender = CounterExtender::new(start);
        let mut truth = 0;
        for step in steps {
            truth += step;
            let hardware = start.wrapping_add(truth as u16);
            prop_assert_eq!(extender.extend(hardware), truth);
        }
    }

    #[test]
    fn steady_speed_is_known_to_a_tick_of_the_window_from_90_to_20_million_counts_a_second(
        exponent in 0.0..1.0f64, phase in 0.0..1.0f64, back in any::<bool>(), fine in any::<bool>(), start in any::<u32>(),
    ) {
        let (q_m, slowest, fastest): (f64, f64, f64) = if fine { (1e-6, 1e-3, 20.0) } else { (Q_M, 90.0 * Q_M, 20.0) };
        let speed_mps: f64 = slowest * (fastest / slowest).powf(exponent);
        let sign: f64 = if back { -1.0 } else { 1.0 };
        let mut estimator = SpeedEstimator::new(MetersPerCount::from_si(q_m), 0);
        for tick in 0..400u32 {
            let counts = (sign * speed_mps * f64::from(tick) / 1000.0 / q_m + phase).floor() as i64;
            let estimate = estimator.step(start.wrapping_add(tick), counts).to_si() * sign;
            if tick > 100 {
                // A window holds 40 ticks less one count's time at least, or one count; its two
                // ends are known to one tick together, or to one count where counts are quicker.
                let ticks_per_count = q_m / speed_mps * 1000.0;
                let window = (40.0 - ticks_per_count).max(ticks_per_count - 1.0).max(19.0);
                let bound = speed_mps * 1.05 / window * ticks_per_count.clamp(1e-4, 1.0) + 2e-7 + speed_mps * 2e-8;
                prop_assert!((estimate - speed_mps).abs() <= bound, "{tick}: {estimate} for {speed_mps}");
            }
        }
    }

    #[test]
    fn any_counts_at_all_give_a_speed_without_overflow(
        counts in prop::collection::vec(any::<i64>(), 1..100), q_m in 1e-6..0.125, start in any::<u32>(),
    ) {
        let mut estimator = SpeedEstimator::new(MetersPerCount::from_si(q_m), 0);
        for (n, counts) in counts.into_iter().enumerate() {
            estimator.step(start.wrapping_add(n as u32), counts);
        }
    }
}

/// The estimate at each tick for a wheel whose travel is a formula.
fn estimates(q_m: f64, seconds: f64, travel_m: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut estimator = SpeedEstimator::new(MetersPerCount::from_si(q_m), 0);
    (0..(seconds * 1000.0) as u32)
        .map(|tick| {
            let counts = (travel_m(f64::from(tick) / 1000.0) / q_m + 0.5).floor() as i64;
            estimator.step(tick, counts).to_si()
        })
        .collect()
}

#[test]
fn on_the_papers_ramp_the_estimate_lags_by_half_a_window() {
    // 0.101 rev/s^2
    let a = 0.101 * 900.0 * Q_M;
    let speeds = estimates(Q_M, 5.0, |t| a * t * t / 2.0);
    for (tick, estimate) in speeds.iter().enumerate().skip(500) {
        let t = tick as f64 / 1000.0;
        // One count's time at this speed, or the window, whichever is longer, in which the speed is
        // a mean over the last one or two; and one tick of quantisation in 19 at least.
        let count_s = (Q_M / (a * t)).max(0.02);
        let (slowest, fastest) = (a * (t - 2.5 * count_s).max(0.0), a * t);
        assert!(
            (slowest * 0.94..=fastest * 1.06).contains(estimate),
            "{t}: {estimate} {slowest} {fastest}"
        );
    }
}

#[test]
fn a_wheel_that_stops_dead_decays_as_one_count_per_time_and_then_stands() {
    let speeds = estimates(Q_M, 22.0, |t| 0.118 * t.min(1.0));
    for (tick, estimate) in speeds.iter().enumerate().skip(1010) {
        let since_s = (tick as f64 - 1001.0) / 1000.0;
        assert!(*estimate <= 0.118f64.min(Q_M / (since_s - 0.003)) + 1e-6, "{tick}: {estimate}");
    }
    assert_eq!(speeds[21_500], 0.0);
}

#[test]
fn dither_on_an_edge_at_standstill_is_no_speed() {
    let mut estimator = SpeedEstimator::new(MetersPerCount::from_si(Q_M), 0);
    for tick in 0..1000u32 {
        // On and off, at every tick and at every third one.
        let period = if tick < 500 { 2 } else { 6 };
        let speed = estimator.step(tick, i64::from(tick % period < period / 2));
        assert_eq!(speed.to_si(), 0.0, "{tick}");
    }
}

#[test]
fn turning_round_never_shows_more_speed_than_there_is() {
    // From 0.1 m/s to -0.1 m/s in one second.
    let speeds = estimates(Q_M, 1.0, |t| 0.1 * t - 0.1 * t * t);
    for (tick, estimate) in speeds.iter().enumerate().skip(60) {
        let speed = 0.1 - 0.2 * tick as f64 / 1000.0;
        assert!(estimate.abs() <= 0.106, "{tick}: {estimate}");
        // Within the change of speed over a window, and the time of a count near the turn.
        let count_s = (Q_M / speed.abs().max(1e-3)).min(0.1);
        assert!(
            (estimate - speed).abs() < 0.2 * (0.04 + 2.0 * count_s) + 0.006,
            "{tick}: {estimate} {speed}"
        );
    }
}
