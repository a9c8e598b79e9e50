//! A host that dies while the robot drives, with anything up to 16 MB of it held back on the way, and a second host that
//! stops the robot under flood: on the flashed image.
//!
//! What a bridge holds back reaches the line at the line's speed. One board has many cases, one after the other.

use std::cell::{Cell, RefCell};
use std::path::Path;
use std::time::Duration;

use futures_lite::future;
use host_link::motion::Motion;
use host_link::session::Session;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Command, Encoder, MotionId, Request, State, TravelUnit, WheelPair};
use sim_target::{Scenario, Testbed, now_us, sleep_until_us};

use crate::emulation::Emulation;
use crate::monitor::Bench;

/// A controlled stop begins this soon after the last word of a host that died \[us\].
pub const BEGINS_US_MAX: u64 = 250_000;
/// The motors are off this soon after an emergency stop under flood \[us\].
pub const OFF_US_MAX: u64 = 100_000;

const CRUISE_MPS: f64 = 0.2;
const AHEAD: Motion = Motion {
    unit: TravelUnit::Meter,
    distance: WheelPair::both(5.0),
    cruise: CRUISE_MPS,
    acceleration: 1.0,
};

/// Bytes that a bridge keeps waiting for the line.
const ON_LINE: usize = 150;

/// What is held back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// Renewals as the host sent them while it lived.
    Renewals,
    /// The same, with questions in between: the line never falls silent.
    RenewalsAndQuestions,
    /// Renewals, and the beginning of motions.
    Drives,
    /// Anything.
    Garbage,
    /// The host lives, and floods the line: a second one stops the robot.
    Flood,
}

/// One case, and what became of it.
#[derive(Clone, Debug)]
pub struct Found {
    /// What was held back.
    pub held: Held,
    /// How much of it \[bytes\].
    pub len: usize,
    /// When the controlled stop began, or the motors were off \[us\].
    pub after_us: u64,
    /// Whether the robot moved afterwards, or does not answer.
    pub wrong: Option<String>,
}

impl Found {
    /// Whether what is promised held.
    pub fn holds(&self) -> bool {
        let bound_us = if self.held == Held::Flood { OFF_US_MAX } else { BEGINS_US_MAX };
        self.wrong.is_none() && self.after_us <= bound_us
    }
}

/// So many cases on one board, drawn from a seed.
///
/// # Errors
/// If the image cannot be run.
pub fn run(image: &Path, seed: u64, cases: u32) -> Result<Vec<Found>, String> {
    let emulation = Emulation::of(image, Scenario::default());
    let ended = emulation
        .run(move |bench: Bench| async move {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut found = Vec::new();
            for number in 0..cases {
                found.push(case(&bench, number, &mut rng).await);
            }
            found
        })
        .map_err(|error| error.to_string())?;
    match ended.unexpected.first() {
        Some(unexpected) => Err(unexpected.clone()),
        None if ended.resets > 0 => Err(format!("{} restarts", ended.resets)),
        None => Ok(ended.found),
    }
}

async fn case(bench: &Bench, number: u32, rng: &mut ChaCha8Rng) -> Found {
    let held =
        [Held::Renewals, Held::RenewalsAndQuestions, Held::Drives, Held::Garbage, Held::Flood]
            [number as usize % 5];
    // From nothing to 16 MB, as many small ones as large ones.
    let len = (rng.random_range(0.0..24.0_f64).exp2() - 1.0) as usize;
    let cruise_ms = rng.random_range(600..800);
    let mut session = bench.session(100 + 2 * number);
    let mut found = Found { held, len, after_us: 0, wrong: None };
    let motion = match cruise(&mut session, cruise_ms).await {
        Ok(motion) => motion,
        Err(error) => {
            found.wrong = Some(format!("it does not drive: {error}"));
            return found;
        }
    };
    found.after_us = match held {
        Held::Flood => stop_under_flood(bench, session, motion, 101 + 2 * number).await,
        _ => die(bench, &session, held, len, motion, rng).await,
    };
    // To the end of the ramp; then it stands.
    sleep_until_us(now_us() + 500_000).await;
    let stood_m = travel_m(&bench.testbed);
    sleep_until_us(now_us() + 50_000).await;
    let moved_m = travel_m(&bench.testbed) - stood_m;
    if moved_m.abs() > 1e-4 {
        found.wrong = Some(format!("it still moves: {moved_m} m"));
    }
    found
}

/// Clears what is latched, and drives.
async fn cruise(session: &mut Session, ms: u64) -> Result<MotionId, host_link::Error> {
    session.open().await?;
    let status = session.status().await?;
    if let Some(report) = status.fault {
        session.request(Command::ClearFault { number: report.number }).await?;
    }
    if status.state != State::Armed {
        session.request(Command::Arm { take: true }).await?;
    }
    let motion = session.new_motion();
    session.request(Command::Drive(AHEAD.drive_now(motion))).await?;
    let until_us = now_us() + ms * 1000;
    while now_us() < until_us {
        session.post(Command::Renew { motion }).await?;
        let pause_us = (until_us - now_us()).min(30_000);
        session.listen(Duration::from_micros(pause_us)).await?;
    }
    Ok(motion)
}

/// The host is dead from now on; returns when the robot begins to stop.
async fn die(
    bench: &Bench,
    session: &Session,
    held: Held,
    len: usize,
    motion: MotionId,
    rng: &mut ChaCha8Rng,
) -> u64 {
    let died_us = now_us();
    let until_ms = session.lease_end_ms();
    let held_back = hold_back(bench, session.number(), held, len, until_ms, motion, rng);
    let travel = RefCell::new(Vec::new());
    let watch = async {
        while now_us() < died_us + 500_000 {
            travel.borrow_mut().push((now_us() - died_us, travel_m(&bench.testbed)));
            sleep_until_us(now_us() + 1_000).await;
        }
    };
    future::or(watch, held_back).await;
    // A ramp of 0.5 m/s^2 loses 5 mm/s in 10 ms; cruise wobbles by less.
    let travel = travel.into_inner();
    let fast = |pair: &[(u64, f64)]| {
        let s = (pair[10].0 - pair[0].0) as f64 * 1e-6;
        (pair[10].1 - pair[0].1) / s > 0.95 * CRUISE_MPS
    };
    travel.windows(11).rposition(fast).map_or(0, |at| travel[at].0 + 10_000)
}

/// A bridge empties what it holds onto the line.
async fn hold_back(
    bench: &Bench,
    session: u32,
    held: Held,
    len: usize,
    until_ms: u64,
    motion: MotionId,
    rng: &mut ChaCha8Rng,
) {
    let mut encoder = Encoder::new();
    let mut left = len;
    loop {
        while left > 0 && bench.monitor.waiting() < ON_LINE {
            let bytes = piece(&mut encoder, session, held, until_ms, motion, rng);
            bench.wire.write_now(&bytes[..bytes.len().min(left)]);
            left -= bytes.len().min(left);
            // The monitor is updated at every step.
            sleep_until_us(now_us() + 60).await;
        }
        sleep_until_us(now_us() + 500).await;
    }
}

fn piece(
    encoder: &mut Encoder,
    session: u32,
    held: Held,
    until_ms: u64,
    motion: MotionId,
    rng: &mut ChaCha8Rng,
) -> Vec<u8> {
    if held == Held::Garbage {
        return (0..100).map(|_| rng.random()).collect();
    }
    // Later than all that the host had sent.
    let mut frame = |command: Command| {
        let until_ms = if command.needs_lease() { until_ms } else { 0 };
        encoder.message(&Request { session, id: 4000, until_ms, command }).to_vec()
    };
    let mut bytes = frame(Command::Renew { motion });
    match held {
        Held::RenewalsAndQuestions => bytes.extend(frame(Command::Status)),
        Held::Drives => {
            bytes.extend(frame(Command::Arm { take: true }));
            bytes.extend(frame(Command::Drive(AHEAD.drive_now(MotionId(rng.random())))));
        }
        _ => {}
    }
    bytes
}

/// A second host, whose connection is fresh, stops the robot; returns when its motors are off.
async fn stop_under_flood(
    bench: &Bench,
    mut session: Session,
    motion: MotionId,
    number: u32,
) -> u64 {
    let mut other = bench.session(number);
    let over = Cell::new(false);
    let flood = async {
        let mut encoder = Encoder::new();
        let own = session.number();
        while !over.get() {
            let until_ms = session.lease_end_ms();
            let _ = session.post(Command::Renew { motion }).await;
            while bench.monitor.waiting() < ON_LINE {
                let status = Request { session: own, id: 4000, until_ms, command: Command::Status };
                bench.wire.write_now(&encoder.message(&status));
                sleep_until_us(now_us() + 60).await;
            }
            sleep_until_us(now_us() + 200).await;
        }
    };
    let stop = async {
        sleep_until_us(now_us() + 100_000).await;
        let called_us = now_us();
        let stopping = other.emergency_stop();
        let off = async {
            while bench.testbed.plant(|plant| plant.currents_a().any(|a| a != 0.0))
                && now_us() < called_us + 1_000_000
            {
                sleep_until_us(now_us() + 500).await;
            }
            let after_us = now_us() - called_us;
            over.set(true);
            after_us
        };
        // On this line every answer to it may be lost.
        let (_, after_us) = future::zip(stopping, off).await;
        after_us
    };
    future::zip(flood, stop).await.1
}

/// How far both rims have rolled, on average \[m\].
fn travel_m(testbed: &Testbed) -> f64 {
    testbed.plant(|plant| {
        let radius_m = plant.parameters().geometry.wheel_radius_m;
        let rolled_m = plant.wheel_angles_rad().zip(radius_m).map(|(angle, radius)| angle * radius);
        0.5 * (rolled_m.left + rolled_m.right)
    })
}
