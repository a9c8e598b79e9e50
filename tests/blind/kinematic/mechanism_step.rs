//! What does each mechanism do in a step of a millisecond?

use super::mechanism::{Hidden, Mechanism};
use super::planned_run::DT_S;

/// The payload at which slip by curvature and load has doubled \[kg\].
const LOAD_KG: f64 = 3.0;

/// What is known before a step: by the encoders and the nominal robot, but for heading and place, which are true.
#[derive(Clone, Copy, Debug, Default)]
pub struct Step {
    /// Rolled in the step \[m\].
    pub wheel_m: [f64; 2],
    /// Speeds \[m/s\].
    pub wheel_mps: [f64; 2],
    /// Accelerations \[m/s^2\].
    pub wheel_mps2: [f64; 2],
    /// Wheel angles since the campaign began \[rad\].
    pub phi_rad: [f64; 2],
    /// Encoder revolutions per wheel revolution.
    pub gear: f64,
    /// Wheel radius \[m\].
    pub radius_m: f64,
    /// Track width \[m\].
    pub track_m: f64,
    /// Speed of the fastest wheel in the campaign \[m/s\].
    pub fastest_mps: f64,
    /// Heading \[rad\].
    pub heading_rad: f64,
    /// Place \[m\].
    pub place_m: [f64; 2],
    /// Travelled since the last reversal of travel, if there was one \[m\].
    pub since_reversal_m: Option<f64>,
    /// Rolled since the last stop \[m\].
    pub since_stop_m: f64,
    /// Time in the run, and in the campaign \[s\].
    pub time_s: [f64; 2],
    /// On board \[kg\].
    pub payload_kg: f64,
}

impl Step {
    fn travel_m(&self) -> f64 {
        (self.wheel_m[0] + self.wheel_m[1]) / 2.0
    }

    fn speed_mps(&self) -> f64 {
        (self.wheel_mps[0] + self.wheel_mps[1]) / 2.0
    }

    fn rate_rad_s(&self) -> f64 {
        (self.wheel_mps[1] - self.wheel_mps[0]) / self.track_m
    }

    /// 0 on a straight, 1 in a spin.
    fn chi(&self) -> f64 {
        let rim_mps = self.rate_rad_s().abs() * self.track_m;
        let both_mps = 2.0 * self.speed_mps().abs() + rim_mps;
        if both_mps > 0.0 { rim_mps / both_mps } else { 0.0 }
    }

    /// How far the rims rolled \[m\].
    pub fn rolled_m(&self) -> f64 {
        (self.wheel_m[0].abs() + self.wheel_m[1].abs()) / 2.0
    }
}

/// What a mechanism changes in a step.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// Factor of each wheel's travel.
    pub wheel: [f64; 2],
    /// Added to each wheel's travel \[m\].
    pub wheel_m: [f64; 2],
    /// Factor of the turn.
    pub turning: f64,
    /// Added to the turn \[rad\].
    pub turn_rad: f64,
    /// To the left \[m\].
    pub left_m: f64,
    /// In the world \[m\].
    pub world_m: [f64; 2],
}

impl Change {
    /// No change.
    pub const NONE: Self = Self {
        wheel: [1.0; 2],
        wheel_m: [0.0; 2],
        turning: 1.0,
        turn_rad: 0.0,
        left_m: 0.0,
        world_m: [0.0; 2],
    };

    fn wheels(wheel: [f64; 2]) -> Self {
        Self { wheel, ..Self::NONE }
    }

    fn both(factor: f64) -> Self {
        Self::wheels([factor; 2])
    }

    fn turning(turning: f64) -> Self {
        Self { turning, ..Self::NONE }
    }

    fn turn(turn_rad: f64) -> Self {
        Self { turn_rad, ..Self::NONE }
    }

    /// Of one wheel alone: 0 left, 1 right.
    fn one(wheel: f64, factor: f64) -> Self {
        Self::wheels(if wheel > 0.0 { [1.0, factor] } else { [factor, 1.0] })
    }
}

/// What a mechanism remembers in a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Memory {
    /// Where in its play each gear is \[m of the rim\]; `None` before the first motion.
    play_m: [Option<f64>; 2],
    /// Slip angle of late tyres \[rad\].
    slip_rad: f64,
}

/// The sign, zero for zero.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// What a mechanism changes in this step; gyro and camera are none of it.
pub fn act(hidden: &Hidden, step: &Step, memory: &mut Memory) -> Change {
    use Mechanism as M;
    let p = hidden.p;
    let (v, omega, path_m) = (step.speed_mps(), step.rate_rad_s(), step.travel_m().abs());
    let each = |of: &dyn Fn(usize) -> f64| Change::wheels([of(0), of(1)]);
    match hidden.mechanism {
        M::WheelRadiusRatio => Change::wheels([1.0 - p[0] / 2.0, 1.0 + p[0] / 2.0]),
        M::WheelRadiusScale => Change::both(1.0 + p[0]),
        M::TrackWidth => Change::turning(1.0 / (1.0 + p[0])),
        M::Scrub => Change::turning(1.0 / (1.0 + p[0] * step.chi())),
        M::SideSlip => Change { left_m: -p[0] * v * omega * DT_S, ..Change::NONE },
        M::TractionSlip => each(&|i| 1.0 - p[0] * step.wheel_mps2[i] * sign(step.wheel_mps[i])),
        M::TurnLoadTransfer => Change::turning(1.0 - p[0] * v * v),
        M::SpeedGrowth => each(&|i| 1.0 + p[0] * step.wheel_mps[i].powi(2)),
        M::WheelEccentricity => ripple(p, step, 1.0),
        M::EncoderEccentricity => ripple(p, step, step.gear),
        M::LostCounts => {
            let from_mps = p[1] * step.fastest_mps;
            each(&|i| 1.0 + p[0] * ((step.wheel_mps[i].abs() - from_mps) / from_mps).max(0.0))
        }
        M::Backlash => {
            let wheel_m = [0, 1].map(|i| {
                let play_m = p[i] * step.radius_m;
                take_up(&mut memory.play_m[i], step.wheel_m[i], play_m)
            });
            Change { wheel_m, ..Change::NONE }
        }
        M::CasterKick => match step.since_reversal_m {
            Some(since_m) => Change::turn(p[0] * (-since_m / p[1]).exp() * step.travel_m() / p[1]),
            None => Change::NONE,
        },
        M::HeadingPull => Change::turn(p[0] * path_m),
        M::TurnAsymmetry => Change::turning(1.0 + p[0] * sign(omega)),
        M::Slope => {
            let (sin, cos) = step.heading_rad.sin_cos();
            // k sin(beta - theta), with (p0, p1) = k (cos beta, sin beta).
            let turn_rad = (p[1] * cos - p[0] * sin) * step.rolled_m();
            let world_m = [p[0], p[1]].map(|k| p[2] * k * step.rolled_m());
            Change { turn_rad, world_m, ..Change::NONE }
        }
        M::CarpetDrift => {
            Change { world_m: [p[0], p[1]].map(|d| d * step.rolled_m()), ..Change::NONE }
        }
        M::ThermalDrift => Change::both(1.0 + p[0] * step.time_s[1]),
        M::Payload => Change::both(1.0 - p[0] * step.payload_kg),
        M::MeasurementDelay | M::MarkerOffset | M::HeadingDrift | M::GyroBias | M::GyroScale => {
            Change::NONE
        }
        _ => act_outside(hidden, step, memory),
    }
}

/// What is in no catalogue.
fn act_outside(hidden: &Hidden, step: &Step, memory: &mut Memory) -> Change {
    use Mechanism as M;
    let p = hidden.p;
    let (v, omega, path_m) = (step.speed_mps(), step.rate_rad_s(), step.travel_m().abs());
    let side = usize::from(p[1] > 0.0);
    match hidden.mechanism {
        M::LateSideSlip => {
            let share = if p[1] > 0.0 { DT_S / p[1] } else { path_m / -p[1] };
            memory.slip_rad += (-p[0] * omega - memory.slip_rad) * share.min(1.0);
            Change { left_m: memory.slip_rad * step.travel_m(), ..Change::NONE }
        }
        M::TurnWithSpeed => Change::turn(p[0] * v * v.abs() * DT_S),
        M::GainWithSpeedAndTurn => Change::turning(1.0 + p[0] * v * omega),
        M::OneWheelGrowth => Change::one(p[1], 1.0 + p[0] * step.wheel_mps[side].powi(2)),
        M::CurvatureLoadSlip => {
            Change::both(1.0 - p[0] * step.chi() * (1.0 + step.payload_kg / LOAD_KG))
        }
        M::SlipperyPatch => {
            let half_m = step.track_m / 2.0;
            let (sin, cos) = step.heading_rad.sin_cos();
            let slips = |left: f64| {
                // The wheel stands half a track to the left or right of the middle.
                let x_m = step.place_m[0] - left * half_m * sin - p[1];
                let y_m = step.place_m[1] + left * half_m * cos - p[2] * half_m;
                if x_m.hypot(y_m) < p[3] { 1.0 - p[0] } else { 1.0 }
            };
            Change::wheels([slips(1.0), slips(-1.0)])
        }
        M::QuadraticDrift => {
            let moves = if step.rolled_m() > 0.0 { 1.0 } else { 0.0 };
            Change::turn(2.0 * p[0] * step.time_s[0] * DT_S * moves)
        }
        M::TwoHeadings => Change::turn(p[0] * (2.0 * step.heading_rad - p[1]).sin() * path_m),
        M::StictionTurn => {
            Change::turn(p[0] * (-step.since_stop_m / p[1]).exp() * step.rolled_m() / p[1])
        }
        M::ThirdHarmonic => ripple(p, step, 3.0),
        M::DirectionalGain => Change::one(p[1], 1.0 + p[0] * sign(step.wheel_mps[side])),
        inside => unreachable!("{inside:?} is in the catalogue"),
    }
}

/// A ripple of each wheel's travel, so many times a turn.
fn ripple(p: [f64; 4], step: &Step, times: f64) -> Change {
    Change::wheels([0, 1].map(|i| {
        let (sin, cos) = (times * step.phi_rad[i]).sin_cos();
        1.0 + p[2 * i] * cos + p[2 * i + 1] * sin
    }))
}

/// How much less the rim rolls than its encoder says, as the gear's play is taken up first \[m\].
fn take_up(play_at_m: &mut Option<f64>, rolled_m: f64, play_m: f64) -> f64 {
    if rolled_m == 0.0 {
        return 0.0;
    }
    let before_m = play_at_m.unwrap_or(sign(rolled_m) * play_m / 2.0);
    let after_m = (before_m + rolled_m).clamp(-play_m / 2.0, play_m / 2.0);
    *play_at_m = Some(after_m);
    before_m - after_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_changed_at_zero_strength() {
        let step = Step {
            wheel_m: [2e-4, 3e-4],
            wheel_mps: [0.2, 0.3],
            wheel_mps2: [0.2, 0.3],
            phi_rad: [1.0, 2.0],
            gear: 1.0,
            radius_m: 0.04,
            track_m: 0.3,
            fastest_mps: 0.35,
            heading_rad: 0.4,
            place_m: [0.5, 0.15],
            since_reversal_m: Some(0.01),
            since_stop_m: 0.01,
            time_s: [3.0, 300.0],
            payload_kg: 3.0,
        };
        for mechanism in Mechanism::ALL {
            let change = act(&Hidden::new(*mechanism, 0.0, 3), &step, &mut Memory::default());
            let sums = [change.wheel_m, change.world_m, [change.turn_rad, change.left_m]].concat();
            assert!(sums.iter().all(|sum| *sum == 0.0), "{mechanism:?}: {change:?}");
            assert_eq!((change.wheel, change.turning), ([1.0; 2], 1.0), "{mechanism:?}");
        }
    }

    #[test]
    fn a_carpet_carries_a_robot_as_far_as_its_rims_roll() {
        for (wheel_m, along_m) in [([-0.01, 0.01], 0.001), ([0.0, 0.01], 0.0005)] {
            let hidden = Hidden { mechanism: Mechanism::CarpetDrift, p: [0.0, 0.1, 0.0, 0.0] };
            let step = Step { wheel_m, ..Step::default() };
            let Change { world_m, turn_rad, .. } = act(&hidden, &step, &mut Memory::default());
            assert!((world_m[1] - along_m).abs() < 1e-15 && (world_m[0], turn_rad) == (0.0, 0.0));
        }
    }

    #[test]
    fn a_gear_takes_up_its_play_once_after_each_reversal() {
        let mut play = None;
        let rolled =
            |play: &mut Option<f64>, rolled_m: f64| rolled_m + take_up(play, rolled_m, 0.002);
        // Engaged at first, free after the reversal, then engaged again.
        let ground_m = [0.01, -0.0015, -0.0015, -0.01].map(|rolled_m| rolled(&mut play, rolled_m));
        let wanted_m = [0.01, 0.0, -0.001, -0.01];
        assert!(ground_m.iter().zip(wanted_m).all(|(a, b)| (a - b).abs() < 1e-15), "{ground_m:?}");
    }
}
