//! What a drive shows to be missing in the feedforward: friction, speed and acceleration, for each wheel.
//!
//! ```text
//! f(t) = u(t) U(t) - u_ff(t) U_0 + kV e'(t)
//! ```
//!
//! u: the duty; U: the supply that the robot will reckon with; u_ff: the feedforward as a share of U_0; e': how fast the wheel gains
//! on its setpoint. f is what the profile would have needed beside its feedforward. kd a W / 2 of it is meant to come from the
//! loop (see [`Gains`](robot_model::drivetrain::Gains)). The rest is a feedforward that is off: the supply sags under the load,
//! and kS, kV, kA and the delay are known to some per cent.

use robot_model::drivetrain::{Added, AddedTerms};
use shared_proto::{Config, Telemetry, Wheel, WheelPair};

/// Frames on each side from which an acceleration is taken.
const SIDE: usize = 3;
/// A wheel that breaks away tells nothing for so long \[frames\], nor as long as it makes up for the encoder check, which leaves
/// it some counts ahead.
const START: usize = 15;
const START_COUNTS: f64 = 8.0;
/// Frames over which the supply is averaged for its range.
const SUPPLY: usize = 7;
/// The robot's own mean \[s\], and by which share it may be off the supply that the robot reckons with.
const SUPPLY_MEAN_S: f64 = 0.064;
const SUPPLY_SHARE: f64 = 1.0 / 64.0;
/// At rest, the supply is not to reach that limit by its noise \[V\].
const SUPPLY_NOISE_V: f64 = 0.02;

/// One wheel at one instant.
#[derive(Clone, Copy, Debug)]
struct Instant {
    speed_mps: f64,
    acceleration_mps2: f64,
    duty: f64,
    feedforward: f64,
    gaining_mps: f64,
    /// Which of the drives' frames it is.
    frame: usize,
}

/// Instants of some drives with one configuration.
#[derive(Clone, Debug)]
pub struct Shortfall {
    wheels: WheelPair<Vec<Instant>>,
    /// Time since the frame before \[s\] and supply \[V\] of each frame of all drives.
    frames: Vec<(f64, f64)>,
    /// Lowest and highest supply, averaged \[V\].
    supply_v: (f64, f64),
}

impl Default for Shortfall {
    fn default() -> Self {
        let supply_v = (f64::INFINITY, f64::NEG_INFINITY);
        Self { wheels: WheelPair::default(), frames: Vec::new(), supply_v }
    }
}

impl Shortfall {
    /// Adds one drive: the frames in which the robot drove.
    pub fn add(&mut self, config: &Config, driving: &[&Telemetry]) {
        for frames in driving.windows(SUPPLY) {
            let sum_mv: f64 = frames.iter().map(|frame| f64::from(frame.supply_mv)).sum();
            let mean_v = sum_mv * 1e-3 / SUPPLY as f64;
            self.supply_v = (self.supply_v.0.min(mean_v), self.supply_v.1.max(mean_v));
        }
        let before = self.frames.len();
        for (index, frame) in driving.iter().enumerate() {
            let last = driving[index.saturating_sub(1)];
            let time_s = frame.t_us.saturating_sub(last.t_us) as f64 * 1e-6;
            self.frames.push((time_s, f64::from(frame.supply_mv) * 1e-3));
        }
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
            let instants = settled.map(|(index, frames)| Instant {
                frame: before + index + SIDE,
                ..instant(frames, wheel)
            });
            self.wheels.get_mut(wheel).extend(instants);
        }
    }

    /// The range of nominal supplies \[V\] at which the robot, when it stands, reckons with the nominal one. None if nothing was
    /// driven.
    pub fn nominal_supply_v(&self) -> Option<(f64, f64)> {
        let (low, high) = self.supply_v;
        let lowest = high / (1.0 + SUPPLY_SHARE) + SUPPLY_NOISE_V;
        (low <= high).then_some((lowest, high))
    }

    /// A first choice: the middle of the supply under these loads \[V\], in that range.
    pub fn loaded_supply_v(&self) -> Option<f64> {
        let (lowest, highest) = self.nominal_supply_v()?;
        Some((0.5 * (self.supply_v.0 + highest)).max(lowest))
    }

    /// The supply that a robot with this nominal one \[V\] would have reckoned with, at each frame.
    fn held_supply_v(&self, nominal_v: f64) -> Vec<f64> {
        let (mut mean_v, mut held_v) = (nominal_v, nominal_v);
        let step = |&(time_s, supply_v): &(f64, f64)| {
            mean_v += (supply_v - mean_v) * (1.0 - (-time_s / SUPPLY_MEAN_S).exp());
            if (mean_v - held_v).abs() > SUPPLY_SHARE * held_v {
                held_v = mean_v;
            }
            held_v
        };
        self.frames.iter().map(step).collect()
    }

    /// What is missing in volts, where the drives tell it, if the robot is to have this nominal supply \[V\]; `present_v` is the
    /// one that it has.
    pub fn missing_v(
        &self,
        present_v: f64,
        supply_v: f64,
        kv_v_s_per_m: WheelPair<f64>,
    ) -> WheelPair<Option<AddedTerms>> {
        let held_v = self.held_supply_v(supply_v);
        let of = |instants: &[Instant], kv: f64| {
            let added = instants.iter().map(|instant| Added {
                speed_mps: instant.speed_mps,
                acceleration_mps2: instant.acceleration_mps2,
                feedback: instant.duty * held_v[instant.frame] - instant.feedforward * present_v
                    + kv * instant.gaining_mps,
            });
            AddedTerms::of(&added.collect::<Vec<_>>())
        };
        WheelPair {
            left: of(&self.wheels.left, kv_v_s_per_m.left),
            right: of(&self.wheels.right, kv_v_s_per_m.right),
        }
    }
}

/// The middle one of some frames.
fn instant(frames: &[&Telemetry], wheel: Wheel) -> Instant {
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
        duty: f64::from(now.duty) / 32767.0,
        feedforward: f64::from(now.terms.feedforward) / 32767.0,
        gaining_mps: per_s(first, last, error_um(last) - error_um(first)),
        frame: 0,
    }
}

#[cfg(test)]
mod tests {
    use shared_proto::{
        Config, PidTerms, Pose, PoseDeviation, State, Telemetry, WheelPair, WheelTelemetry,
    };

    use super::Shortfall;

    /// Up to 0.4 m/s with 0.5 m/s^2, and down again: speed, acceleration, travel.
    fn profile(t_s: f64) -> (f64, f64, f64) {
        let left_s = 2.0 - t_s;
        match t_s {
            ..0.8 => (0.5 * t_s, 0.5, 0.25 * t_s * t_s),
            0.8..1.2 => (0.4, 0.0, 0.16 + 0.4 * (t_s - 0.8)),
            _ => (0.5 * left_s, -0.5, 0.48 - 0.25 * left_s * left_s),
        }
    }

    /// The robot needs 1 V, 20 V s/m and 2 V s^2/m, of a supply of 12 V that sags by so much for 1 m/s; its feedforward has less.
    fn frames(sag_v_s_per_m: f64) -> Vec<Telemetry> {
        let frame = move |number: u32| {
            let t_s = f64::from(number) * 0.01;
            let (speed, acceleration, travel) = profile(t_s);
            let supply_v = 12.0 - sag_v_s_per_m * speed;
            let share = |volts: f64, of_v: f64| (volts / of_v * 32767.0).round() as i16;
            let needed_v = 1.0 + 20.0 * speed + 2.0 * acceleration;
            let feedforward = share(0.9 + 19.0 * speed + 1.7 * acceleration, 12.0);
            let wheel = WheelTelemetry {
                setpoint_um: (travel * 1e6) as i64,
                terms: PidTerms { feedforward, ..PidTerms::default() },
                duty: share(needed_v, 11.9),
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
        let missing = shortfall.missing_v(12.0, 11.9, WheelPair::both(20.0));
        assert_eq!(missing.left, missing.right);
        let missing = missing.left.unwrap();
        assert!((missing.ks_forward - 0.1).abs() < 0.01, "{missing:?}");
        assert!((missing.kv - 1.0).abs() < 0.05, "{missing:?}");
        assert!((missing.ka - 0.3).abs() < 0.02, "{missing:?}");
        assert_eq!(missing.ks_backward, 0.0);
    }

    #[test]
    fn the_loaded_supply_is_in_the_middle_of_what_a_drive_takes_it_to() {
        let nothing = Shortfall::default();
        assert_eq!(nothing.loaded_supply_v(), None);
        assert_eq!(nothing.missing_v(12.0, 12.0, WheelPair::both(20.0)), WheelPair::both(None));
        let mut shortfall = Shortfall::default();
        let frames = frames(0.5);
        shortfall.add(&Config::default(), &frames.iter().collect::<Vec<_>>());
        let loaded_v = shortfall.loaded_supply_v().unwrap();
        assert!((loaded_v - 11.9).abs() < 0.02, "{loaded_v}");
        assert!(shortfall.held_supply_v(11.9).iter().all(|held_v| *held_v == 11.9));
    }

    #[test]
    fn a_supply_that_sags_by_much_leaves_the_robot_at_rest_what_it_reckons_with() {
        let mut shortfall = Shortfall::default();
        let frames = frames(3.0);
        shortfall.add(&Config::default(), &frames.iter().collect::<Vec<_>>());
        let loaded_v = shortfall.loaded_supply_v().unwrap();
        assert!((11.78..11.81).contains(&loaded_v), "{loaded_v}");
        let held_v = shortfall.held_supply_v(loaded_v);
        assert_eq!(held_v[0], loaded_v);
        // At 0.4 m/s the supply is 10.8 V.
        assert!((held_v[115] - 10.8).abs() < 0.2, "{}", held_v[115]);
    }
}
