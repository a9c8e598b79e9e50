//! Hosts: what they do, and what happens to them.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::future::poll_fn;
use std::io;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::{Arc, Mutex};
use std::task::Poll;
use std::time::Duration;

use campaign::disk::{Disk, SystemDisk};
use campaign::{CampaignWriter, Column, RobotFile, Row, RunFacts};
use host_link::clock::TimeSource;
use host_link::wire::{Waiting, Wire};
use host_link::{Clock, Error, Session};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Command, Decoder, Key, Name, Request};
use sim_target::{now_us, sleep_until_us};

use super::judge::{Invariant, Judge};
use super::network::{Link, Network};
use super::small_disk::SmallDisk;
use crate::robot::own_secret;

/// What all hosts of a robot share.
#[derive(Clone)]
pub struct Laboratory {
    pub network: Rc<RefCell<Network>>,
    pub judge: Rc<RefCell<Judge>>,
    /// Keys that the robot may have, the likeliest first.
    pub keys: Rc<RefCell<Vec<Option<Key>>>>,
    /// The campaign, and what of it must be there: rows and load of each run.
    pub folder: PathBuf,
    pub runs: Rc<RefCell<BTreeMap<String, (usize, f64)>>>,
    pub counter: Rc<Cell<u32>>,
    pub done: Rc<Cell<Done>>,
}

/// How often what was meant succeeded: a storm in which nothing does would show nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Done {
    /// Motions driven to their end.
    pub drives: u32,
    /// Drives at a velocity that changes.
    pub velocities: u32,
    /// Voltages applied to their end.
    pub voltages: u32,
    /// Configurations saved.
    pub saves: u32,
    /// Keys changed.
    pub keys: u32,
    /// Emergency stops.
    pub stops: u32,
    /// Runs recorded.
    pub runs: u32,
    /// Runs for which the disk was full.
    pub full_disks: u32,
    /// Hosts killed.
    pub kills: u32,
    /// Hosts that stalled.
    pub stalls: u32,
    /// Power cuts.
    pub restarts: u32,
    /// Servers killed.
    pub servers: u32,
}

impl Done {
    /// Each with its name.
    pub fn named(&self) -> [(&'static str, u32); 12] {
        [
            ("drives", self.drives),
            ("velocities", self.velocities),
            ("voltages", self.voltages),
            ("saves", self.saves),
            ("keys changed", self.keys),
            ("emergency stops", self.stops),
            ("runs recorded", self.runs),
            ("full disks", self.full_disks),
            ("hosts killed", self.kills),
            ("hosts stalled", self.stalls),
            ("power cuts", self.restarts),
            ("servers killed", self.servers),
        ]
    }
}

/// What a host is there for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Drive,
    /// As a joystick does.
    Steer,
    /// Measures motors.
    ApplyVoltages,
    Record,
    Configure,
    ChangeKey,
    Stop,
    Watch,
    /// It asks for telemetry and reads none.
    Deaf,
}

/// What happens to a host from outside.
#[derive(Default)]
pub struct Fate {
    pub killed: Cell<bool>,
    pub stalled_until_us: Cell<u64>,
    /// What its clock shows more than the world's \[us\].
    pub ahead_us: Cell<i64>,
    /// How much faster it runs.
    pub skew: Cell<f64>,
    pub link: RefCell<Option<Rc<RefCell<Link>>>>,
}

/// A host's own clock, which somebody may set.
struct HostClock(Rc<Fate>);

impl TimeSource for HostClock {
    fn now_us(&self) -> u64 {
        let t_us = now_us() as f64 * (1.0 + self.0.skew.get());
        (3_600_000_000 + t_us as i64 + self.0.ahead_us.get()) as u64
    }

    fn sleep_until_us(&self, t_us: u64) -> Waiting<'_, ()> {
        Box::pin(async move {
            while self.now_us() < t_us {
                let left_us = (t_us - self.now_us()).min(5_000);
                sleep_until_us(now_us() + left_us).await;
            }
        })
    }

    fn is_virtual(&self) -> bool {
        true
    }
}

/// A host's end of its link.
struct HostEnd {
    link: Rc<RefCell<Link>>,
    network: Rc<RefCell<Network>>,
    judge: Rc<RefCell<Judge>>,
    decoder: Decoder,
}

impl Wire for HostEnd {
    fn write<'a>(&'a mut self, bytes: &'a [u8]) -> Waiting<'a, io::Result<()>> {
        Box::pin(async move {
            if !self.link.borrow().is_open() {
                return Err(io::ErrorKind::BrokenPipe.into());
            }
            for &byte in bytes {
                if let Some(Ok(frame)) = self.decoder.push(byte)
                    && let Some(request) = frame.message::<Request>()
                {
                    self.judge.borrow_mut().host_sends(&request);
                }
            }
            self.network.borrow_mut().submit(&self.link, bytes);
            Ok(())
        })
    }

    fn read(&mut self) -> Waiting<'_, io::Result<Vec<u8>>> {
        Box::pin(poll_fn(|context| match self.link.borrow_mut().take(context.waker()) {
            Some(taken) => Poll::Ready(taken),
            None => Poll::Pending,
        }))
    }
}

impl Laboratory {
    pub fn count(&self, what: impl FnOnce(&mut Done)) {
        let mut done = self.done.get();
        what(&mut done);
        self.done.set(done);
    }

    fn next(&self) -> u32 {
        self.counter.set(self.counter.get() + 1);
        self.counter.get()
    }

    /// A session on a new link, once the robot has let it in; tries every key that the robot may have.
    pub async fn open(&self, fate: &Rc<Fate>) -> Result<Session, Error> {
        let mut last = Error::NoAnswer { port: "chaos".into() };
        let keys = self.keys.borrow().clone();
        for key in keys {
            let Some(link) = self.network.borrow_mut().connect() else {
                sleep_until_us(now_us() + 50_000).await;
                continue;
            };
            let before = fate.link.replace(Some(link.clone()));
            if let Some(before) = before {
                before.borrow_mut().end(false);
            }
            let (network, judge) = (self.network.clone(), self.judge.clone());
            let wire = HostEnd { link, network, judge, decoder: Decoder::new() };
            let number = self.next().wrapping_mul(0x9e37_79b9) | 1;
            let clock = Clock::new(HostClock(fate.clone()));
            let mut session = Session::new(wire, clock, number, "chaos".into());
            if let Some(key) = key {
                session.use_key(key, own_secret(number));
            }
            match session.open().await {
                Ok(()) => {
                    // Tried first from now on.
                    self.keys.borrow_mut().sort_by_key(|other| *other != key);
                    return Ok(session);
                }
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    /// A host's life: it does what it is there for, again and again, until its time is over.
    pub async fn live(self, role: Role, fate: Rc<Fate>, seed: u64, until_us: u64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        sleep_until_us(now_us() + rng.random_range(0..400_000)).await;
        while now_us() < until_us {
            if let Ok(mut session) = self.open(&fate).await {
                while now_us() < until_us
                    && self.act(role, &mut session, &fate, &mut rng).await.is_ok()
                {
                    let waiting = session.waiting();
                    self.judge.borrow_mut().bounded("a host", waiting, Session::WAITING_MAX);
                }
            }
            sleep_until_us(now_us() + rng.random_range(10_000..200_000)).await;
        }
    }

    async fn act(
        &self,
        role: Role,
        session: &mut Session,
        fate: &Rc<Fate>,
        rng: &mut ChaCha8Rng,
    ) -> Result<(), Error> {
        match role {
            Role::Drive | Role::Record => self.drive(role, session, rng).await,
            Role::Steer => self.steer(session, rng).await,
            Role::ApplyVoltages => self.apply_voltages(session, rng).await,
            Role::Configure => self.configure(session).await,
            Role::ChangeKey => self.change_key(session, rng).await,
            Role::Stop => {
                session.listen(Duration::from_millis(rng.random_range(200..2500))).await?;
                let called_us = now_us();
                session.emergency_stop().await?;
                self.judge.borrow_mut().emergency_stop_done(called_us);
                self.count(|done| done.stops += 1);
                Ok(())
            }
            Role::Watch => {
                session.overhear();
                session.status().await?;
                session.listen(Duration::from_millis(rng.random_range(1..300))).await?;
                session.take_events().for_each(drop);
                session.take_telemetry().for_each(drop);
                Ok(())
            }
            Role::Deaf => {
                let _ = session.ask(Command::Subscribe { period_ms: 1 }).await?;
                let link = fate.link.borrow().clone();
                if let Some(link) = link {
                    link.borrow_mut().stop_reading();
                }
                sleep_until_us(now_us() + 10_000_000).await;
                Ok(())
            }
        }
    }

    /// Writes the run into the campaign; the disk may be full.
    pub fn record(&self, telemetry: &[shared_proto::Telemetry], rng: &mut ChaCha8Rng) {
        let start_us = telemetry.first().map_or(0, |frame| frame.t_us);
        let load_kg = f64::from(rng.random_range(1..100_u32)) / 8.0;
        let disk: Arc<dyn Disk> = match rng.random_bool(0.3) {
            true => Arc::new(SmallDisk(Mutex::new(rng.random_range(0..6_000)))),
            false => Arc::new(SystemDisk),
        };
        let mut rows = 0;
        let mut write = || -> Result<PathBuf, campaign::CampaignError> {
            let writer = CampaignWriter::open_on(disk.clone(), &self.folder, &robot_file())?;
            let mut run = writer.start_run("chaos", &[Column::LeftCounts, Column::RightCounts])?;
            for frame in telemetry {
                let counts = frame.wheels.map(|wheel| Some(wheel.counts as f64));
                let t_s = (frame.t_us - start_us) as f64 * 1e-6;
                run.push(&Row { t_s, counts, ..Row::default() })?;
                rows += 1;
            }
            run.finish(RunFacts { payload_kg: Some(load_kg), ..RunFacts::default() })
        };
        let written = write();
        match written {
            Ok(path) => {
                let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                self.runs.borrow_mut().insert(name, (rows, load_kg));
                self.count(|done| done.runs += 1);
            }
            Err(_) => self.count(|done| done.full_disks += 1),
        }
        self.judge_runs();
    }

    /// Whether the campaign has every run whole, with its facts.
    pub fn judge_runs(&self) {
        let fail = |seen| self.judge.borrow_mut().fail(Invariant::RunsAreWhole, seen);
        if !self.folder.join("robot.toml").exists() {
            return;
        }
        let robot = match RobotFile::read(&self.folder.join("robot.toml")) {
            Ok(robot) => robot,
            Err(error) => return fail(format!("robot.toml cannot be read: {error}")),
        };
        let mut runs = self.runs.borrow_mut();
        let mut there = BTreeSet::new();
        for entry in std::fs::read_dir(self.folder.join("runs")).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.extension().is_none_or(|extension| extension != "csv") {
                continue;
            }
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let rows = campaign::read_run(&path).map_or(0, |(rows, _)| rows.len());
            let facts = robot.runs.iter().find(|facts| facts.name == name);
            let load_kg = facts.and_then(|facts| facts.payload_kg);
            let found = (rows, load_kg.unwrap_or(0.0));
            // A run whose writer was told of an error may be there all the same, with its facts.
            let meant = *runs.entry(name.clone()).or_insert((rows, found.1.max(0.125)));
            if meant != found {
                fail(format!("{name}: {found:?}, and {meant:?} was written"));
            }
            there.insert(name);
        }
        if let Some(name) = runs.keys().find(|name| !there.contains(*name)) {
            fail(format!("{name} is gone"));
        }
    }

    async fn configure(&self, session: &mut Session) -> Result<(), Error> {
        let mut config = session.read_config().await?;
        for _ in 0..2 {
            config.name = Name::new(&format!("robot {}", self.next())).unwrap_or_default();
            session.write_config(&config).await?;
        }
        session.save_config().await?;
        self.judge.borrow_mut().saved(&config);
        self.count(|done| done.saves += 1);
        Ok(())
    }

    async fn change_key(&self, session: &mut Session, rng: &mut ChaCha8Rng) -> Result<(), Error> {
        session.listen(Duration::from_millis(rng.random_range(100..1500))).await?;
        let new = rng.random_bool(0.7).then(|| Key::new(rng.random()));
        if !self.keys.borrow().contains(&new) {
            self.keys.borrow_mut().insert(0, new);
        }
        self.judge.borrow_mut().key_may_be(new);
        session.set_key(new, own_secret(self.next())).await?;
        self.judge.borrow_mut().key_is(new);
        *self.keys.borrow_mut() = vec![new];
        self.count(|done| done.keys += 1);
        Ok(())
    }
}

/// The nominal robot of the campaign.
fn robot_file() -> RobotFile {
    let text =
        "name = \"chaos\"\nwheel_radius_m = 0.036\ntrack_width_m = 0.372\ncounts_per_rev = 900\n";
    toml::from_str(text).expect("a robot")
}
