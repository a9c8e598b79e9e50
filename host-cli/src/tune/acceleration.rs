//! What the loop itself adds to the feedforward while the robot accelerates on its profile.
//!
//! ```text
//! f = p + i + d,   a: the setpoints' acceleration          c = sum(a f) / sum(a^2)
//! ```
//!
//! Over a drive that begins and ends at rest, what belongs to friction and to speed cancels: the robot drives with a and -a
//! at the same speeds. kd a W / 2 of it is meant to be there (see [`Gains`](robot_model::drivetrain::Gains)). The rest is
//! missing in the feedforward: the measured supply is behind the one at hand while the load grows, and kA or the delay may
//! be off.

use shared_proto::{Telemetry, Wheel, WheelPair};

/// Frames on each side from which an acceleration is taken.
const SIDE: usize = 3;

/// Sums over the drives, of one wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct OfWheel {
    products: f64,
    squares: f64,
}

/// Sums over the drives.
#[derive(Clone, Copy, Debug, Default)]
pub struct AccelerationSums(WheelPair<OfWheel>);

impl AccelerationSums {
    /// Adds one drive: the frames in which the robot drove.
    pub fn add(&mut self, driving: &[&Telemetry]) {
        for wheel in Wheel::BOTH {
            let sums = self.0.get_mut(wheel);
            for frames in driving.windows(2 * SIDE + 1) {
                let acceleration_mps2 =
                    acceleration_mps2([frames[0], frames[SIDE], frames[2 * SIDE]], wheel);
                let terms = frames[SIDE].wheels.get(wheel).terms;
                let feedback = [terms.proportional, terms.integral, terms.derivative];
                let feedback = feedback.map(|term| f64::from(term) / 32767.0).iter().sum::<f64>();
                sums.products += acceleration_mps2 * feedback;
                sums.squares += acceleration_mps2 * acceleration_mps2;
            }
        }
    }

    /// c, as a share of the nominal supply \[s^2/m\].
    pub fn feedback_s2_per_m(&self) -> WheelPair<f64> {
        self.0.map(|sums| if sums.squares > 0.0 { sums.products / sums.squares } else { 0.0 })
    }
}

/// The setpoints' acceleration in the middle one of three frames.
fn acceleration_mps2(frames: [&Telemetry; 3], wheel: Wheel) -> f64 {
    let speed_mps = |from: &Telemetry, to: &Telemetry| {
        let way_um = to.wheels.get(wheel).setpoint_um - from.wheels.get(wheel).setpoint_um;
        way_um as f64 / to.t_us.saturating_sub(from.t_us).max(1) as f64
    };
    let [before, middle, after] = frames;
    let time_s = after.t_us.saturating_sub(before.t_us).max(1) as f64 * 0.5e-6;
    (speed_mps(middle, after) - speed_mps(before, middle)) / time_s
}

#[cfg(test)]
mod tests {
    use shared_proto::{
        PidTerms, Pose, PoseDeviation, State, Telemetry, WheelPair, WheelTelemetry,
    };

    use super::AccelerationSums;

    #[test]
    fn what_the_loop_adds_by_acceleration_is_told_from_what_friction_and_speed_take() {
        // Up to 0.4 m/s with 0.5 m/s^2, and down again; the loop adds 0.02 s^2/m, 0.005 for speed and 0.003 for friction.
        let frames: Vec<Telemetry> = (0..=200_u32)
            .map(|number| {
                let t_s = f64::from(number) * 0.01;
                let left_s = 2.0 - t_s;
                let (speed, acceleration, travel) = if t_s < 0.8 {
                    (0.5 * t_s, 0.5, 0.25 * t_s * t_s)
                } else if t_s < 1.2 {
                    (0.4, 0.0, 0.16 + 0.4 * (t_s - 0.8))
                } else {
                    (0.5 * left_s, -0.5, 0.48 - 0.25 * left_s * left_s)
                };
                let added = 0.02 * acceleration + 0.005 * speed + 0.003;
                let terms = PidTerms { integral: (added * 32767.0) as i16, ..PidTerms::default() };
                let wheel = WheelTelemetry {
                    setpoint_um: (travel * 1e6) as i64,
                    terms,
                    ..WheelTelemetry::default()
                };
                Telemetry {
                    number,
                    t_us: u64::from(number) * 10_000,
                    state: State::Driving,
                    probing: false,
                    wheels: WheelPair::both(wheel),
                    supply_mv: 12_000,
                    pose: Pose::default(),
                    deviation: PoseDeviation::default(),
                }
            })
            .collect();
        let mut sums = AccelerationSums::default();
        sums.add(&frames.iter().collect::<Vec<_>>());
        let found = sums.feedback_s2_per_m();
        assert!((found.left - 0.02).abs() < 1e-3 && found.left == found.right, "{found:?}");
    }
}
