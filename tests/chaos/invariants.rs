//! What must hold in every session, whatever breaks: the one list.
//!
//! | invariant | held |
//! | --- | --- |
//! | no motor drives a wheel faster than a ramp allows, from 250 ms after a living host last wanted a motion | every ms |
//! | no motor is on without an arming that the robot has heard since it last started | every ms |
//! | 100 ms after an emergency stop was heard the motors are off, until the robot is armed again | every ms |
//! | only the session that the robot has told that it drives moves it | every answer |
//! | a fault stays latched until a host clears it | every frame of telemetry |
//! | telemetry numbers and times only rise, until the robot restarts | every frame of telemetry |
//! | what a host receives rises in time as well, each frame once | every drive |
//! | the saved configuration is the factory's or one that a host wrote, whole | every restart, the end |
//! | a host ends with a result or one clear error, within a minute | every procedure |
//! | nothing panics | the session |

use shared_proto::{Config, WheelPair};
use sim_target::Lab;

use super::witness::Witness;

/// From the last wish of a living host to the beginning of the controlled stop \[us\].
const LEASE_US: u64 = 250_000;
/// The gentlest ramp of a motion here is 0.5 m/s^2; a wheel lags a little behind its ramp \[m/s^2\], \[m/s\].
const RAMP_MPS2: f64 = 0.45;
const LAG_MPS: f64 = 0.03;
/// From an emergency stop at the robot to motors without current \[us\].
const EMERGENCY_US: u64 = 100_000;
/// Within this the watchdog has restarted a robot of which a task stands still \[us\].
const RESTART_US: u64 = 500_000;

/// What must be remembered from one millisecond to the next.
#[derive(Default)]
pub(crate) struct Invariants {
    /// When the last lease ended at the latest, and how fast the wheels were then \[us\], \[m/s\].
    expired: Option<(u64, f64)>,
}

impl Invariants {
    /// Every millisecond; a sentence for what does not hold.
    pub(crate) fn check(
        &mut self,
        now_us: u64,
        lab: &Lab,
        witness: &mut Witness,
    ) -> Result<(), String> {
        if let Some(broken) = witness.broken.pop() {
            return Err(broken);
        }
        let (speed_mps, powered) = lab.plant(|plant| {
            let radius_m = plant.parameters().geometry.wheel_radius_m;
            let rims: WheelPair<f64> =
                plant.wheel_speeds_rad_s().zip(radius_m).map(|(speed, radius)| speed * radius);
            (
                rims.left.abs().max(rims.right.abs()),
                plant.currents_a().any(|current_a| current_a != 0.0),
            )
        });
        let ends_us = witness.wanted_us.map_or(0, |wanted_us| wanted_us + LEASE_US);
        if now_us < ends_us {
            self.expired = None;
        } else {
            let (from_us, from_mps) = *self.expired.get_or_insert((now_us, speed_mps));
            let ramp_mps = (from_mps - RAMP_MPS2 * (now_us - from_us) as f64 * 1e-6).max(0.0);
            if powered && speed_mps > ramp_mps + LAG_MPS {
                let late_ms = (now_us - ends_us) / 1000;
                return Err(format!(
                    "{late_ms} ms after the last lease the motors drive at {speed_mps:.3} m/s, not {ramp_mps:.3} m/s"
                ));
            }
        }
        let Some(allowed) = armed_at(now_us, witness) else { return Ok(()) };
        if powered && !allowed {
            return Err("the motors are on, and nobody has armed the robot since it started".into());
        }
        if let Some(stop_us) = witness.heard_emergency_stop_us
            && powered
            && now_us > stop_us + EMERGENCY_US
            && witness.heard_arm_us.is_none_or(|arm_us| arm_us < stop_us)
        {
            let ms = (now_us - stop_us) / 1000;
            return Err(format!("the motors are on {ms} ms after an emergency stop"));
        }
        Ok(())
    }
}

/// Whether the robot has heard an arming since its last start; unknown while it restarts.
fn armed_at(now_us: u64, witness: &Witness) -> Option<bool> {
    match witness.restarted_us {
        Some(restart_us) if now_us < restart_us + RESTART_US => None,
        Some(restart_us) => Some(witness.heard_arm_us.is_some_and(|arm_us| arm_us > restart_us)),
        None => Some(witness.heard_arm_us.is_some()),
    }
}

/// The flash holds a configuration that somebody wanted, whole.
pub(crate) fn check_flash(content: Option<&str>, witness: &Witness) -> Result<(), String> {
    let Some(text) = content else { return Ok(()) };
    let saved: Config = match toml::from_str(text) {
        Ok(saved) => saved,
        Err(error) => {
            return Err(format!("the saved configuration cannot be read: {}", error.message()));
        }
    };
    match saved == Config::default() || witness.configs.contains(&saved) {
        true => Ok(()),
        false => Err("nobody wrote the configuration that is saved".into()),
    }
}

/// A procedure's end: a result, or an error in one line.
pub(crate) fn check_end(error: &host_link::Error) -> Result<(), String> {
    let text = error.to_string();
    match text.is_empty() || text.contains('\n') {
        true => Err(format!("no clear error: {text:?}")),
        false => Ok(()),
    }
}
