//! Motions by plain formulas in `f64`, and what the tests of plans share.

use firmware::profile::ProfileState;
use proptest::prelude::*;
use shared_proto::{Config, Drive, MotionId, TravelUnit, WheelPair};

pub const HZ: f64 = 1000.0;

/// The finest encoder's count; the reference has to be met within it.
pub const COUNT_M: f64 = 1e-6;

/// How well the fixed-point plan knows the time of a phase boundary [s]: cruise speed is rounded to
/// 2^-64 m per tick, which counts over the whole duration, and the time to 2^-32 ticks; the
/// reference's own f64 rounds both to some 1e-16.
pub fn boundary_s(cruise_mps: f64, duration_s: f64) -> f64 {
    duration_s * (0.5f64.powi(64) * HZ / cruise_mps + 1e-15) + 1e-12
}

/// One wheel's motion by plain formulas: v0 to vc at a, cruise, vc to 0 at a, in a given time.
#[derive(Clone, Copy, Debug)]
pub struct Reference {
    pub v0: f64,
    pub vc: f64,
    pub a: f64,
    pub duration_s: f64,
}

impl Reference {
    pub fn state(&self, t_s: f64) -> (f64, f64) {
        let Self { v0, vc, a, duration_s } = *self;
        let t1 = (vc - v0).abs() / a;
        let t3 = vc.abs() / a;
        let first = (t_s.min(t1), (vc - v0).signum() * a);
        let mut s = v0 * first.0 + first.1 * first.0 * first.0 / 2.0;
        if t_s <= t1 {
            return (s, v0 + first.1 * first.0);
        }
        let cruised = (t_s.min(duration_s - t3) - t1).max(0.0);
        s += vc * cruised;
        let braked = (t_s.min(duration_s) - (duration_s - t3)).max(0.0);
        s += vc * braked - vc.signum() * a * braked * braked / 2.0;
        (s, if t_s >= duration_s { 0.0 } else { vc - vc.signum() * a * braked })
    }

    pub fn distance(&self) -> f64 {
        self.state(self.duration_s).0
    }

    /// The quickest motion, found by bisection: of the cruise velocity, or of the duration.
    pub fn quickest(v0: f64, distance: f64, limit: f64, a: f64) -> Self {
        let braking = v0 * v0.abs() / (2.0 * a);
        let sign = if distance < braking { -1.0 } else { 1.0 };
        let shortest = |vc: f64| Self { v0, vc, a, duration_s: ((vc - v0).abs() + vc.abs()) / a };
        let vc = sign * limit;
        if (shortest(vc).distance() - distance) * sign <= 0.0 {
            let missing = (distance - shortest(vc).distance()).abs();
            return Self { duration_s: shortest(vc).duration_s + missing / limit, ..shortest(vc) };
        }
        let (mut low, mut high) = (0.0, limit);
        for _ in 0..200 {
            let middle = (low + high) / 2.0;
            if (shortest(sign * middle).distance() - distance) * sign < 0.0 {
                low = middle
            } else {
                high = middle
            }
        }
        shortest(sign * high)
    }

    /// The same distance in a given longer time.
    pub fn stretched(self, distance: f64, duration_s: f64) -> Self {
        let with = |share: f64| Self { vc: self.vc * share, duration_s, ..self };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..200 {
            let middle = (low + high) / 2.0;
            if (with(middle).distance() - distance) * self.vc.signum() < 0.0 {
                low = middle
            } else {
                high = middle
            }
        }
        with(high)
    }
}

pub fn at_rest() -> WheelPair<ProfileState> {
    WheelPair::default()
}

pub fn fast_config() -> Config {
    let mut config = Config::default();
    config.limits.speed_mps_max = 20.0;
    config.limits.acceleration_mps2_max = 100.0;
    config
}

pub fn order(left_m: f64, right_m: f64, cruise: f64, acceleration: f64) -> Drive {
    Drive {
        motion: MotionId(1),
        unit: TravelUnit::Meter,
        distance: WheelPair::new(left_m, right_m),
        cruise,
        acceleration,
        start_us: None,
    }
}

pub fn position_m(state: ProfileState) -> f64 {
    state.position.0.to_num()
}

pub fn speed_mps(state: ProfileState) -> f64 {
    state.velocity.0.to_num::<f64>() * HZ
}

/// From `low` to `high`, each decade as likely as the next.
pub fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..=high.ln()).prop_map(move |exponent: f64| exponent.exp().clamp(low, high))
}

pub fn signed_distance() -> impl Strategy<Value = f64> {
    (prop_oneof![decades(1e-7, 1e4), Just(0.0), Just(1e4)], any::<bool>())
        .prop_map(|(d, back)| if back { -d } else { d })
}

/// Ticks worth looking at: every phase boundary of `references`, and some between.
pub fn ticks_of_interest(references: &WheelPair<Reference>, shares: &[f64]) -> Vec<u32> {
    let mut ticks = Vec::new();
    for r in [references.left, references.right] {
        for t_s in [0.0, (r.vc - r.v0).abs() / r.a, r.duration_s - r.vc.abs() / r.a, r.duration_s] {
            let middle = (t_s * HZ).max(2.0) as u32;
            ticks.extend(middle - 2..=middle + 2);
        }
        ticks.extend(shares.iter().map(|share| (share * r.duration_s * HZ) as u32));
    }
    ticks
}

pub fn drives() -> impl Strategy<Value = (f64, f64, f64, f64)> {
    (signed_distance(), signed_distance(), decades(1e-3, 20.0), decades(1e-3, 100.0))
}
