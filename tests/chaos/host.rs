//! A host: connects, does something, and begins again; it may be killed at any time.

use std::cell::RefCell;
use std::rc::Rc;

use futures_lite::future;
use host_link::clock::{Clock, TimeSource};
use host_link::motion::{Motion, RecordOptions, Twist, drive_at, drive_into};
use host_link::wire::Waiting;
use host_link::{Error, Session};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use shared_proto::{Command, ConfigOrigin};
use sim_target::{now_us, sleep_until_us};

use super::bridge::Bridge;
use super::invariants::check_end;
use crate::robot::meters;

/// A procedure that takes longer hangs \[us\].
const PATIENCE_US: u64 = 60_000_000;

/// How many procedures ended well, and how many with an error.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ends {
    /// With a result.
    pub well: u32,
    /// With one clear error.
    pub error: u32,
    /// Killed, with their host or by the end of the session.
    pub killed: u32,
}

/// The clock of a host: it began some time ago, and runs a little wrong.
struct HostClock {
    rate: f64,
    began_us: u64,
}

impl TimeSource for HostClock {
    fn now_us(&self) -> u64 {
        (now_us() as f64 * self.rate) as u64 + self.began_us
    }

    fn sleep_until_us(&self, t_us: u64) -> Waiting<'_, ()> {
        let at_us = (t_us.saturating_sub(self.began_us) as f64 / self.rate).ceil() as u64;
        Box::pin(sleep_until_us(at_us))
    }

    fn is_virtual(&self) -> bool {
        true
    }
}

/// Hosts, one after the other, until the session ends. Returns only what is broken.
pub(crate) async fn hosts(
    bridge: Bridge,
    mut rng: ChaCha8Rng,
    until_us: u64,
    ends: Rc<RefCell<Ends>>,
) -> Result<(), String> {
    while now_us() < until_us {
        let lives_us = rng.random_range(50_000..6_000_000);
        let dies = async {
            sleep_until_us((now_us() + lives_us).min(until_us)).await;
            None
        };
        let lives = async { Some(one_host(&bridge, &mut rng, &ends).await) };
        match future::or(lives, dies).await {
            Some(end) => end?,
            None => ends.borrow_mut().killed += 1,
        }
        let pause_us = rng.random_range(0..1_000_000);
        sleep_until_us(now_us() + pause_us).await;
    }
    Ok(())
}

/// One host until its connection breaks or it has done enough.
async fn one_host(
    bridge: &Bridge,
    rng: &mut ChaCha8Rng,
    ends: &RefCell<Ends>,
) -> Result<(), String> {
    let Some(connection) = bridge.connect() else { return Ok(()) };
    // Within what is promised of two clocks: a thousandth.
    let rate = rng.random_range(0.9995..1.0005);
    let clock = Clock::new(HostClock { rate, began_us: rng.random_range(0..1 << 40) });
    let mut session =
        Session::new(connection, clock, rng.random_range(1..u32::MAX), "chaos".into());
    for _ in 0..rng.random_range(1..6) {
        let began_us = now_us();
        let hangs = async {
            sleep_until_us(began_us + PATIENCE_US).await;
            None
        };
        let name = rng.random_range(0..9_u8);
        let acts = async { Some(procedure(name, &mut session, rng).await) };
        match future::or(acts, hangs).await {
            Some(Ok(())) => ends.borrow_mut().well += 1,
            Some(Err(Broken::Error(error))) => {
                ends.borrow_mut().error += 1;
                check_end(&error)?;
            }
            Some(Err(Broken::Promise(what))) => return Err(what),
            None => return Err(format!("procedure {name} hangs")),
        }
    }
    Ok(())
}

enum Broken {
    Error(Error),
    Promise(String),
}

impl From<Error> for Broken {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

async fn procedure(name: u8, session: &mut Session, rng: &mut ChaCha8Rng) -> Result<(), Broken> {
    // An emergency stop needs no open session.
    if name == 0 {
        return Ok(session.emergency_stop().await?);
    }
    session.open().await?;
    match name {
        1 => drop(session.identify().await?),
        2 => drop(session.request(Command::Stop).await?),
        3 => save(session, rng).await?,
        4 => twist(session, rng).await?,
        5 | 6 => clear(session).await?,
        _ => {
            clear(session).await?;
            travel(session, rng).await?;
        }
    }
    Ok(())
}

async fn clear(session: &mut Session) -> Result<(), Error> {
    if let Some(report) = session.status().await?.fault {
        session.request(Command::ClearFault { number: report.number }).await?;
    }
    Ok(())
}

async fn save(session: &mut Session, rng: &mut ChaCha8Rng) -> Result<(), Error> {
    let mut config = session.read_config().await?;
    config.geometry.wheel_weight = 1.0 + 1e-4 * f64::from(rng.random_range(-99..100_i32));
    session.write_config(&config).await?;
    if rng.random_bool(0.2) {
        session.restore_config(ConfigOrigin::Saved).await?;
    }
    session.save_config().await
}

/// A drive with its telemetry.
async fn travel(session: &mut Session, rng: &mut ChaCha8Rng) -> Result<(), Broken> {
    let way = |rng: &mut ChaCha8Rng| rng.random_range(-0.5..0.5);
    let (left, right) = (way(rng), way(rng));
    let motion: Motion =
        meters(left, right, rng.random_range(0.1..0.3), rng.random_range(0.5..1.5));
    let options = RecordOptions { period_ms: 20, ..RecordOptions::default() };
    let mut telemetry = Vec::new();
    let end = drive_into(session, &motion, options, &mut telemetry, &mut |_| ()).await;
    if let Some(pair) = telemetry.windows(2).find(|pair| pair[1].t_us <= pair[0].t_us) {
        let (before, after) = (pair[0].t_us, pair[1].t_us);
        return Err(Broken::Promise(format!("a host received {after} us after {before} us")));
    }
    end?;
    Ok(())
}

/// Velocities that change.
async fn twist(session: &mut Session, rng: &mut ChaCha8Rng) -> Result<(), Error> {
    let lasts_s = rng.random_range(0.1..2.0);
    let (forward_mps, turn_rad_s) = (rng.random_range(-0.2..0.2), rng.random_range(-0.5..0.5));
    drive_at(session, rng.random_range(0.5..1.5), &mut |t_s| {
        (t_s < lasts_s).then(|| Twist { forward_mps: forward_mps * (3.0 * t_s).cos(), turn_rad_s })
    })
    .await
}
