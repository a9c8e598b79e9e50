//! What a drive shows to be missing in the feedforward: friction, speed and acceleration, for each wheel.
//!
//! ```text
//! f(t) = u(t) U(t) - u_ff(t) U_0 + kV e'(t)
//! ```
//!
//! u: the duty; U: the supply that the robot reckons with; u_ff: the feedforward as a share of the nominal supply U_0; e': how fast
//! the wheel gains on its setpoint. f is what the profile would have needed beside its feedforward. Some of it, in proportion to kd a,
//! is meant to come from the loop (see [`Gains`](robot_model::drivetrain::Gains)). The rest is a feedforward that is off: the supply
//! sags under the load, and kS, kV, kA and the delay are known to some per cent.

use robot_model::drivetrain::{Added, AddedTerms};
use shared_proto::{Config, Telemetry, Wheel, WheelPair};

/// Frames on each side from which an acceleration is taken.
const SIDE: usize = 3;
/// A wheel that breaks away tells nothing for so long \[frames\], nor as long as it makes up for the encoder check, which leaves
/// it some counts ahead.
const START: usize = 15;
const START_COUNTS: f64 = 8.0;
/// The robot's own mean \[s\], and by how much it may be off the supply that the robot reckons with \[V\].
const SUPPLY_MEAN_S: f64 = 0.064;
const SUPPLY_REST_V: f64 = 0.032;

/// One wheel at one instant.
#[derive(Clone, Copy, Debug)]
struct Instant {
    speed_mps: f64,
    acceleration_mps2: f64,
    /// What the loop gave beside the feedforward \[V\].
    feedback_v: f64,
    gaining_mps: f64,
}

/// Instants of some drives with one configuration.
#[derive(Clone, Debug, Default)]
pub struct Shortfall {
    wheels: WheelPair<Vec<Instant>>,
}

impl Shortfall {
    /// Adds one drive: the frames in which the robot drove.
    pub fn add(&mut self, config: &Config, driving: &[&Telemetry]) {
        let supply_v = supply_v(config, driving);
        let nominal_v = config.feedforward.nominal_v();
        for wheel in Wheel::BOTH {
            let count_um = 1e6 * config.meters_per_count(config.encoder.get(wheel));
            let setpoint_um = |frame: &Telemetry| frame.wheels.get(wheel).setpoint_um;
            let Some(first) = driving.first().copied().map(setpoint_um) else { continue };
            let moved = |frame: &&Telemetry| setpoint_um(frame) != first;
            let Some(begins) = driving.iter().position(moved) else { continue };
            let is_settled = |frame: &Telemetry| {
                setpoint_um(frame).abs_diff(first) as f64 > START_COUNTS * count_um
            };
            let windows = driving.windows(2 * SIDE + 1).enumerate().skip(begins + START);
            let settled = windows.filter(|(_, frames)| is_settled(frames[0]));
            let instants = settled
                .map(|(index, frames)| instant(frames, wheel, supply_v[index + SIDE], nominal_v));
            self.wheels.get_mut(wheel).extend(instants);
        }
    }

    /// What is missing in volts, where the drives tell it.
    pub fn missing_v(&self, kv_v_s_per_m: WheelPair<f64>) -> WheelPair<Option<AddedTerms>> {
        let of = |instants: &[Instant], kv: f64| {
            let added = instants.iter().map(|instant| Added {
                speed_mps: instant.speed_mps,
                acceleration_mps2: instant.acceleration_mps2,
                feedback: instant.feedback_v + kv * instant.gaining_mps,
            });
            AddedTerms::of(&added.collect::<Vec<_>>())
        };
        WheelPair {
            left: of(&self.wheels.left, kv_v_s_per_m.left),
            right: of(&self.wheels.right, kv_v_s_per_m.right),
        }
    }
}

/// The supply that the robot reckoned with at each frame of a drive \[V\]: the nominal one where it is not measured.
fn supply_v(config: &Config, driving: &[&Telemetry]) -> Vec<f64> {
    let measured_v = |frame: &Telemetry| match config.protection.supply_v_min {
        0.0 => config.feedforward.nominal_v(),
        _ => f64::from(frame.supply_mv) * 1e-3,
    };
    let Some(first) = driving.first() else { return Vec::new() };
    let (mut t_us, mut mean_v) = (first.t_us, measured_v(first));
    let mut reckoned_v = mean_v;
    let step = |frame: &&Telemetry| {
        let time_s = frame.t_us.saturating_sub(t_us) as f64 * 1e-6;
        t_us = frame.t_us;
        mean_v += (measured_v(frame) - mean_v) * (1.0 - (-time_s / SUPPLY_MEAN_S).exp());
        reckoned_v = reckoned_v.clamp(mean_v - SUPPLY_REST_V, mean_v + SUPPLY_REST_V);
        reckoned_v
    };
    driving.iter().map(step).collect()
}

/// The middle one of some frames.
fn instant(frames: &[&Telemetry], wheel: Wheel, supply_v: f64, nominal_v: f64) -> Instant {
    let (first, middle, last) = (frames[0], frames[SIDE], frames[2 * SIDE]);
    let per_s = |from: &Telemetry, to: &Telemetry, change_um: f64| {
        change_um / to.t_us.saturating_sub(from.t_us).max(1) as f64
    };
    let speed_mps = |from: &Telemetry, to: &Telemetry| {
        let way_um = to.wheels.get(wheel).setpoint_um - from.wheels.get(wheel).setpoint_um;
        per_s(from, to, way_um as f64)
    };
    let half_s = last.t_us.saturating_sub(first.t_us).max(1) as f64 * 0.5e-6;
    let now = middle.wheels.get(wheel);
    let error_um = |frame: &Telemetry| f64::from(frame.wheels.get(wheel).error_um);
    Instant {
        speed_mps: speed_mps(first, last),
        acceleration_mps2: (speed_mps(middle, last) - speed_mps(first, middle)) / half_s,
        feedback_v: (f64::from(now.duty) * supply_v - f64::from(now.terms.feedforward) * nominal_v)
            / 32767.0,
        gaining_mps: per_s(first, last, error_um(last) - error_um(first)),
    }
}

#[cfg(test)]
mod tests {
    use shared_proto::{
        Config, PidTerms, Pose, PoseDeviation, State, Telemetry, WheelPair, WheelTelemetry,
    };

    use super::{Shortfall, supply_v};

    /// Up to 0.4 m/s with 0.5 m/s^2, and down again: speed, acceleration, travel.
    fn profile(t_s: f64) -> (f64, f64, f64) {
        let left_s = 2.0 - t_s;
        match t_s {
            ..0.8 => (0.5 * t_s, 0.5, 0.25 * t_s * t_s),
            0.8..1.2 => (0.4, 0.0, 0.16 + 0.4 * (t_s - 0.8)),
            _ => (0.5 * left_s, -0.5, 0.48 - 0.25 * left_s * left_s),
        }
    }

    /// The robot needs 1 V, 20 V s/m and 2 V s^2/m, of a supply of 12 V that sags by so much for 1 m/s; its feedforward has less. It
    /// reckons with a mean of the supply over 64 ms, once that is 32 mV off.
    fn frames(sag_v_s_per_m: f64) -> Vec<Telemetry> {
        let (mut mean_v, mut reckoned_v) = (12.0, 12.0_f64);
        let frame = |number: u32| {
            let t_s = f64::from(number) * 0.01;
            let (speed, acceleration, travel) = profile(t_s);
            let supply_v = 12.0 - sag_v_s_per_m * speed;
            for _ in 0..10 {
                mean_v += (supply_v - mean_v) / 64.0;
                reckoned_v = reckoned_v.clamp(mean_v - 0.032, mean_v + 0.032);
            }
            let share = |volts: f64, of_v: f64| (volts / of_v * 32767.0).round() as i16;
            let needed_v = 1.0 + 20.0 * speed + 2.0 * acceleration;
            let feedforward = share(0.9 + 19.0 * speed + 1.7 * acceleration, 12.0);
            let wheel = WheelTelemetry {
                setpoint_um: (travel * 1e6) as i64,
                terms: PidTerms { feedforward, ..PidTerms::default() },
                duty: share(needed_v, reckoned_v),
                ..WheelTelemetry::default()
            };
            Telemetry {
                number,
                t_us: u64::from(number) * 10_000,
                state: State::Driving,
                probing: false,
                wheels: WheelPair::both(wheel),
                supply_mv: (supply_v * 1e3) as u16,
                pose: Pose::default(),
                deviation: PoseDeviation::default(),
            }
        };
        (0..=200).map(frame).collect()
    }

    #[test]
    fn what_a_feedforward_lacks_is_told_by_friction_speed_and_acceleration() {
        let mut shortfall = Shortfall::default();
        let frames = frames(0.5);
        shortfall.add(&Config::default(), &frames.iter().collect::<Vec<_>>());
        let missing = shortfall.missing_v(WheelPair::both(20.0));
        assert_eq!(missing.left, missing.right);
        let missing = missing.left.unwrap();
        assert!((missing.ks_forward - 0.1).abs() < 0.01, "{missing:?}");
        assert!((missing.kv - 1.0).abs() < 0.05, "{missing:?}");
        assert!((missing.ka - 0.3).abs() < 0.02, "{missing:?}");
        assert_eq!(missing.ks_backward, 0.0);
    }

    #[test]
    fn nothing_driven_tells_nothing() {
        let nothing = Shortfall::default();
        assert_eq!(nothing.missing_v(WheelPair::both(20.0)), WheelPair::both(None));
    }

    #[test]
    fn the_robot_reckons_with_the_supply_that_it_measures_or_with_the_nominal_one() {
        let frames = frames(3.0);
        let driving = frames.iter().collect::<Vec<_>>();
        let mut config = Config::default();
        // At 0.4 m/s the supply is 10.8 V.
        let measured_v = supply_v(&config, &driving);
        assert_eq!(measured_v[0], 12.0);
        assert!((measured_v[115] - 10.8).abs() < 0.05, "{}", measured_v[115]);
        config.protection.supply_v_min = 0.0;
        let nominal_v = config.feedforward.nominal_v();
        assert!(supply_v(&config, &driving).iter().all(|supply_v| *supply_v == nominal_v));
    }
}
