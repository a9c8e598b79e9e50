//! A tuned robot whose motors are no longer what they were when it was tuned, on a full and on an empty battery.

use std::f64::consts::TAU;

use host_link::motion::{self, RecordOptions};
use shared_proto::{Config, State, Telemetry, Wheel};
use sim_target::{Options, Scenario};

use super::robots::UntunedRobot;
use crate::robot::{Snapshot, meters, on_robot_with};

/// kV and kA are so many times what they were.
pub const CHANGES: [(f64, f64); 4] = [(0.7, 0.7), (0.7, 1.3), (1.3, 0.7), (1.3, 1.3)];
/// The supplies \[V\].
pub const SUPPLIES_V: [f64; 2] = [10.5, 12.6];
/// A tenth of a millimetre beside the counts: friction lets a wheel creep as far \[m\].
const STILL_M: f64 = 1e-4;
/// Time after the motion in which the robot holds its place, of which the last half is looked at \[s\].
const HOLD_S: f64 = 1.0;

/// How a changed robot drove.
#[derive(Clone, Debug)]
pub struct ChangedRobot {
    /// kV and kA as shares of what they were.
    pub change: (f64, f64),
    /// The supply \[V\].
    pub supply_v: f64,
    /// Why it did not drive to its end, if so.
    pub fault: Option<String>,
    /// In the last half of the cruise, a wheel's distance from its setpoint without the mean, root mean square \[m\].
    pub cruise_m: f64,
    /// While it holds its place, from one end of a wheel's motion to the other \[m\].
    pub hold_m: f64,
}

impl ChangedRobot {
    /// No fault, and no oscillation beyond what a count hides.
    pub fn is_stable(&self, count_m: f64) -> bool {
        let told_m = 2.0 * count_m + STILL_M;
        self.fault.is_none() && self.cruise_m < told_m && self.hold_m < told_m
    }
}

impl UntunedRobot {
    /// Drives with a tuned configuration, with each change of the motors at each supply.
    pub fn drive_changed(&self, tuned: &Config) -> Vec<ChangedRobot> {
        let supplies = CHANGES.into_iter().flat_map(|change| SUPPLIES_V.map(|v| (change, v)));
        supplies.map(|(change, supply_v)| self.drive_one(tuned, change, supply_v)).collect()
    }

    fn drive_one(&self, tuned: &Config, change: (f64, f64), supply_v: f64) -> ChangedRobot {
        let mut config = tuned.clone();
        config.limits.hold_s = HOLD_S;
        let scenario = changed(&self.scenario, change, supply_v);
        let options = Options { config: Some(config.clone()), ..Options::default() };
        on_robot_with(&scenario, options, async |robot| {
            robot.listen(0.01).await;
            // Slow enough for the weakest motor at the lowest supply.
            let turn_m = TAU * config.geometry.wheel_radius_m;
            let reached_mps = (0.8 * 10.5 - self.truth[0]).max(1.0) / (1.3 * self.truth[1]);
            let cruise_mps = turn_m.min(0.5 * reached_mps).min(0.9 * config.limits.speed_mps_max);
            let acceleration = cruise_mps.min(0.9 * config.limits.acceleration_mps2_max);
            let distance_m = cruise_mps * (cruise_mps / acceleration + 1.5);
            let motion = meters(distance_m, distance_m, cruise_mps, acceleration);
            let mut telemetry = Vec::new();
            let options = RecordOptions::default();
            let fault = motion::drive_into(
                &mut robot.session,
                &motion,
                options,
                &mut telemetry,
                &mut |_| {},
            )
            .await
            .err()
            .map(|error| error.to_string());
            let ended_us = robot.snapshot().t_us;
            robot.listen(HOLD_S).await;
            let hold = robot.snapshots_from(ended_us + (0.5 * HOLD_S * 1e6) as u64);
            let hold_m = Wheel::BOTH.map(|wheel| extent_m(&hold, wheel));
            let cruise_m = Wheel::BOTH.map(|wheel| cruise_m(&telemetry, wheel, cruise_mps));
            let [hold_m, cruise_m] = [hold_m, cruise_m].map(|of| of[0].max(of[1]));
            ChangedRobot { change, supply_v, fault, cruise_m, hold_m }
        })
    }
}

/// With k the torque constant at the wheel: kV ~ k, kA ~ R/k, kS ~ R/k times the friction, which is left as it was.
fn changed(scenario: &Scenario, (kv, ka): (f64, f64), supply_v: f64) -> Scenario {
    let mut scenario = scenario.clone();
    let plant = &mut scenario.plant;
    for motor in [&mut plant.motor.left, &mut plant.motor.right] {
        motor.torque_constant_nm_per_a *= kv;
        motor.resistance_ohm *= kv * ka;
        motor.coulomb_torque_nm /= ka;
    }
    plant.supply.open_circuit_v = supply_v;
    scenario
}

/// In the last half of its cruise, a wheel's distance from its setpoint without the mean, root mean square \[m\].
fn cruise_m(telemetry: &[Telemetry], wheel: Wheel, cruise_mps: f64) -> f64 {
    let of = |frame: &Telemetry| *frame.wheels.get(wheel);
    let cruising = telemetry.windows(2).filter(|pair| {
        let way_m = (of(&pair[1]).setpoint_um - of(&pair[0]).setpoint_um) as f64 * 1e-6;
        let dt_s = pair[1].t_us.saturating_sub(pair[0].t_us) as f64 * 1e-6;
        pair[1].state == State::Driving && way_m > 0.99 * cruise_mps * dt_s - 1e-6
    });
    let errors: Vec<f64> = cruising.map(|pair| f64::from(of(&pair[1]).error_um) * 1e-6).collect();
    let last = &errors[errors.len() / 2..];
    let count = last.len() as f64;
    let mean = last.iter().sum::<f64>() / count;
    (last.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// From one end of a wheel's motion to the other \[m\].
fn extent_m(seen: &[Snapshot], wheel: Wheel) -> f64 {
    let travels = || seen.iter().map(|snapshot| *snapshot.rolled_m.get(wheel));
    travels().fold(f64::MIN, f64::max) - travels().fold(f64::MAX, f64::min)
}
