//! Motions of the three kinds that hosts command: a way, a velocity, a voltage.

use std::time::Duration;

use host_link::motion::{self, RecordOptions, Twist, VoltageRun, VoltageStep};
use host_link::{Error, Session};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use shared_proto::{Command, WheelPair};

use super::host::{Laboratory, Role};
use super::judge::{CRUISE_MPS, RAMP_MPS2};
use crate::robot::meters;

/// Where a voltage ends by its speed \[m/s\]: 6 V would make it faster, 3 V do not.
const SPEED_MPS_MAX: f64 = 0.12;

impl Laboratory {
    /// Clears what is latched, and drives a short way.
    pub async fn drive(
        &self,
        role: Role,
        session: &mut Session,
        rng: &mut ChaCha8Rng,
    ) -> Result<(), Error> {
        clear(session).await?;
        let way_m = rng.random_range(0.1..0.4) * sign(rng);
        let motion = meters(way_m, way_m, CRUISE_MPS, RAMP_MPS2);
        let rest = Duration::from_millis(50);
        let options = RecordOptions { period_ms: 10, rest, ..RecordOptions::default() };
        let recording = motion::drive(session, &motion, options, &mut |_| ()).await?;
        self.count(|done| done.drives += 1);
        if role == Role::Record {
            self.record(&recording.telemetry, rng);
        }
        Ok(())
    }

    /// Clears what is latched, and steers for a second or two, now left, now right.
    pub async fn steer(&self, session: &mut Session, rng: &mut ChaCha8Rng) -> Result<(), Error> {
        clear(session).await?;
        let (lasts_s, period_s) = (rng.random_range(0.3..2.0), rng.random_range(0.4..2.0));
        let forward_mps = rng.random_range(0.5..0.7) * CRUISE_MPS * sign(rng);
        // On a track of 0.37 m the outer wheel stays below the speed of a drive.
        let turn_rad_s = rng.random_range(0.0..0.3);
        let mut wanted = |t_s: f64| {
            let turn_rad_s = turn_rad_s * (std::f64::consts::TAU * t_s / period_s).sin();
            (t_s < lasts_s).then_some(Twist { forward_mps, turn_rad_s })
        };
        motion::drive_at(session, RAMP_MPS2, &mut wanted).await?;
        self.count(|done| done.velocities += 1);
        Ok(())
    }

    /// Clears what is latched, and applies one voltage or two, with a limit that some of them reach.
    pub async fn apply_voltages(
        &self,
        session: &mut Session,
        rng: &mut ChaCha8Rng,
    ) -> Result<(), Error> {
        clear(session).await?;
        let mut steps = Vec::new();
        for _ in 0..rng.random_range(1..3) {
            let volts = [3.0, 6.0][rng.random_range(0..2)] * sign(rng);
            let duration_s = rng.random_range(0.2..1.0);
            steps.push(VoltageStep { volts: WheelPair::both(volts), duration_s });
        }
        let run = VoltageRun {
            steps,
            ramp_v_per_s: 20.0,
            travel_m_max: rng.random_range(0.03..0.15),
            speed_mps_max: SPEED_MPS_MAX,
            period_ms: 10,
        };
        motion::apply_voltages(session, &run, &mut Vec::new()).await?;
        self.count(|done| done.voltages += 1);
        Ok(())
    }
}

async fn clear(session: &mut Session) -> Result<(), Error> {
    if let Some(report) = session.status().await?.fault {
        session.request(Command::ClearFault { number: report.number }).await?;
    }
    Ok(())
}

fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 1.0 } else { -1.0 }
}
