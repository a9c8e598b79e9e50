//! Chaos: hosts, server and robot in one virtual time, and everything between and around them that can fail.
//!
//! A session is a few seconds in which hosts drive, record, configure, change the key, stop and watch, while the network loses,
//! holds back, repeats and reorders, hosts are killed, stall and have their clocks set, the server dies and comes back, the
//! robot's power goes (in the middle of a write to its flash, too), somebody floods the line and sends again what was said
//! before, and the disk is full. Then the storm is over, and a fresh host must be able to drive. What must hold all the time
//! is one list, [`Invariant`]. Ten sessions are one robot's, with its flash and its campaign.
//!
//! | file | what it is |
//! | --- | --- |
//! | `network.rs`, `socket.rs` | the line or the server, and the weather on it |
//! | `host.rs` | hosts, with the real session procedures |
//! | `motions.rs` | the motions that they command: ways, velocities, voltages |
//! | `judge.rs` | the invariants |
//! | `storm.rs` | what happens to hosts, server and robot |
//!
//! One seed draws everything; the same seed gives the same session.

mod host;
mod judge;
mod motions;
mod network;
mod plant;
mod small_disk;
mod socket;
mod storm;

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::future::{Future, poll_fn};
use std::pin::Pin;
use std::rc::Rc;
use std::task::Poll;

use futures_lite::future;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Command, Encoder, Request};
use sim_target::{Nor, Options, Scenario, SimTarget, Testbed, now_us, sleep_until_us};

use crate::robot::meters;

pub use self::host::Done;
use self::host::{Fate, Laboratory, Role};
pub use self::judge::{Broken, Invariant};
use self::judge::{CRUISE_MPS, Judge};
use self::network::Network;
pub use self::plant::Plant;

/// Sessions of one robot.
pub const SESSIONS_EACH: u32 = 10;

/// What a robot's sessions came to.
pub struct Outcome {
    /// What did not hold, with the number of the session.
    pub broken: Vec<(u32, Broken)>,
    /// What was done.
    pub done: Done,
    /// How long it took \[us\].
    pub virtual_us: u64,
    /// A number that differs if anything differed.
    pub fingerprint: u64,
}

type Life = Pin<Box<dyn Future<Output = ()>>>;

/// Everything that takes part in a session, polled together.
struct Crew {
    actors: Vec<(Life, Rc<Fate>)>,
    others: Vec<Life>,
}

impl Crew {
    /// Until this time. A host that is killed is dropped where it is; one that stalls is not polled.
    async fn run(mut self, until_us: u64) {
        let end = sleep_until_us(until_us);
        let all = poll_fn(|context| {
            self.actors.retain(|(_, fate)| !fate.killed.get());
            self.actors.retain_mut(|(life, fate)| {
                fate.stalled_until_us.get() > now_us() || life.as_mut().poll(context).is_pending()
            });
            self.others.retain_mut(|other| other.as_mut().poll(context).is_pending());
            Poll::<()>::Pending
        });
        future::or(end, all).await;
    }
}

/// The sessions of one robot.
///
/// # Panics
/// If this thread has a robot already, or there is no room for a campaign.
pub fn run_robot(seed: u64, sessions: u32, plant: Option<Plant>) -> Outcome {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let scenario = Scenario { seed, ..Scenario::default() };
    let nor = Nor::blank(rng.random());
    let random = rng.random_bool(0.5).then(|| rng.random());
    let options = Options { nor: Some(nor.clone()), random, ..Options::default() };
    let mut target = SimTarget::new(&scenario, options).expect("there is no file");
    let (testbed, wire) = (target.testbed(), target.host_wire());
    let judge = Rc::new(RefCell::new(Judge::new(testbed.clone(), nor.clone())));
    let served = rng.random_bool(0.5);
    let network = Network::new(wire.clone(), served, rng.random(), judge.clone(), plant);
    let folder = campaign_folder();
    let laboratory = Laboratory {
        network: Rc::new(RefCell::new(network)),
        judge: judge.clone(),
        keys: Rc::new(RefCell::new(vec![None])),
        folder: folder.path().join("campaign"),
        runs: Rc::new(RefCell::new(BTreeMap::new())),
        counter: Rc::new(Cell::new(seed as u32 & 0xfff)),
        done: Rc::default(),
    };
    let mut broken = Vec::new();
    for session in 0..sessions {
        let before = nor.copy();
        let rewind =
            (plant == Some(Plant::CountThatIsForgotten)).then(|| (nor.clone(), nor.copy()));
        let world =
            World { laboratory: laboratory.clone(), testbed: testbed.clone(), plant, rewind };
        target.run(world.session(rng.random()));
        judge.borrow_mut().settle();
        for found in judge.borrow_mut().broken.drain(..) {
            broken.push((session, found));
        }
        match plant {
            Some(Plant::ConfigThatIsForgotten | Plant::KeyThatIsForgotten) => nor.put_back(&before),
            Some(Plant::LineThatStaysCut) => wire.set_cut(true),
            _ => {}
        }
    }
    let pose = testbed.pose();
    let fingerprint = [pose.x_m, pose.y_m, pose.heading_rad].map(f64::to_bits);
    let fingerprint = fingerprint.iter().fold(now_us(), |sum, bits| sum.rotate_left(7) ^ bits);
    Outcome { broken, done: laboratory.done.get(), virtual_us: now_us(), fingerprint }
}

/// In memory, where the system has it: every file is synced.
fn campaign_folder() -> tempfile::TempDir {
    let memory = std::path::Path::new("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    folder.expect("room for a campaign")
}

/// A robot's world for one session.
struct World {
    laboratory: Laboratory,
    testbed: Testbed,
    plant: Option<Plant>,
    /// A planted fault: the flash, and what it holds again after a power cut.
    rewind: Option<(Nor, Nor)>,
}

impl World {
    async fn session(self, seed: u64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        self.laboratory.judge.borrow_mut().begin();
        let roles = roles(&mut rng);
        let mut until_us = now_us() + rng.random_range(1_500_000..6_000_000);
        if roles.contains(&Role::Deaf) {
            // Until more waits for it than a server keeps.
            until_us += 3_000_000;
        }
        let mut crew = Crew { actors: Vec::new(), others: vec![self.network(), self.observer()] };
        let mut fates = Vec::new();
        for role in roles {
            let fate = Rc::new(Fate::default());
            fate.skew.set(rng.random_range(-2e-4..2e-4));
            let life = self.laboratory.clone().live(role, fate.clone(), rng.random(), until_us);
            crew.actors.push((Box::pin(life), fate.clone()));
            fates.push(fate);
        }
        let storm = storm::Storm {
            laboratory: self.laboratory.clone(),
            testbed: self.testbed.clone(),
            rewind: self.rewind.clone(),
            fates,
            until_us,
        };
        crew.others.push(Box::pin(storm.rage(rng.random())));
        crew.run(until_us).await;
        if self.plant == Some(Plant::FileThatIsCutShort) {
            cut_short(&self.laboratory);
        }
        let background = vec![self.network(), self.observer()];
        let crew = Crew { actors: Vec::new(), others: background };
        future::or(self.aftermath(&mut rng), crew.run(u64::MAX)).await;
    }

    /// Passes on frames, for ever.
    fn network(&self) -> Life {
        let network = self.laboratory.network.clone();
        Box::pin(async move {
            loop {
                network.borrow_mut().step();
                sleep_until_us(now_us() + 500).await;
            }
        })
    }

    fn observer(&self) -> Life {
        let judge = self.laboratory.judge.clone();
        Box::pin(async move {
            loop {
                judge.borrow_mut().watch();
                sleep_until_us(now_us() + 1_000).await;
            }
        })
    }

    /// The storm is over: the robot comes to rest, and a fresh host drives it; now and then a second one stops it.
    async fn aftermath(&self, rng: &mut ChaCha8Rng) {
        self.laboratory.network.borrow_mut().clear();
        storm::mend(&self.testbed);
        sleep_until_us(now_us() + 1_500_000).await;
        self.laboratory.judge_runs();
        let fate = Rc::new(Fate::default());
        let resumed = async {
            let mut session = self.laboratory.open(&fate).await?;
            self.laboratory.drive(Role::Record, &mut session, rng).await?;
            Ok::<_, host_link::Error>(session)
        };
        let patience = async {
            sleep_until_us(now_us() + 20_000_000).await;
            Err(host_link::Error::NeverStands)
        };
        let fail = |invariant, seen| self.laboratory.judge.borrow_mut().fail(invariant, seen);
        match future::or(resumed, patience).await {
            Ok(session) => {
                if rng.random_bool(0.3)
                    && let Err(error) = self.stop_under_flood(session).await
                {
                    fail(Invariant::TheSessionResumes, format!("a stop under flood: {error}"));
                }
            }
            Err(error) => fail(Invariant::TheSessionResumes, error.to_string()),
        }
        self.laboratory.network.borrow_mut().clear();
        sleep_until_us(now_us() + 1_500_000).await;
    }

    /// A host drives and floods the line; another one, whose connection is fresh, stops the robot.
    async fn stop_under_flood(
        &self,
        mut session: host_link::Session,
    ) -> Result<(), host_link::Error> {
        let fate = Rc::new(Fate::default());
        let mut other = self.laboratory.open(&fate).await?;
        session.request(Command::Arm { take: false }).await?;
        let motion = session.new_motion();
        let drive = meters(0.4, 0.4, CRUISE_MPS, 1.0).drive_now(motion);
        session.request(Command::Drive(drive)).await?;
        let flood = async {
            let mut number = 0;
            loop {
                number += 1;
                if number % 10 == 0 {
                    session.post(Command::Renew { motion }).await?;
                }
                while self.laboratory.network.borrow().has_room() {
                    let request =
                        Request { session: 1, id: number, until_ms: 0, command: Command::Status };
                    self.laboratory.network.borrow_mut().intrude(&Encoder::new().message(&request));
                }
                sleep_until_us(now_us() + 1_000).await;
            }
        };
        let stop = async {
            sleep_until_us(now_us() + 600_000).await;
            let called_us = now_us();
            let stopping = async { other.emergency_stop().await };
            let off = async {
                while self.laboratory.judge.borrow().moves().0 && now_us() < called_us + 1_000_000 {
                    sleep_until_us(now_us() + 1_000).await;
                }
                let took_us = now_us() - called_us;
                if took_us > 100_000 {
                    let seen = format!("under flood after {took_us} us");
                    self.laboratory.judge.borrow_mut().fail(Invariant::EmergencyStopStops, seen);
                }
            };
            // Every answer to it may be lost on this line.
            let _ = future::zip(stopping, off).await;
            Ok(())
        };
        future::or(stop, flood).await
    }
}

/// One host that drives, and up to three more; one at most changes configuration or key.
fn roles(rng: &mut ChaCha8Rng) -> Vec<Role> {
    let first = [
        Role::Drive,
        Role::Record,
        Role::Steer,
        Role::ApplyVoltages,
        Role::Configure,
        Role::ChangeKey,
    ];
    let mut roles = vec![first[rng.random_range(0..first.len())]];
    let more = [
        Role::Stop,
        Role::Watch,
        Role::Drive,
        Role::Steer,
        Role::ApplyVoltages,
        Role::Watch,
        Role::Stop,
        Role::Deaf,
    ];
    for _ in 0..rng.random_range(0..3) {
        roles.push(more[rng.random_range(0..more.len())]);
    }
    roles
}

fn cut_short(laboratory: &Laboratory) {
    if let Some(name) = laboratory.runs.borrow().keys().next() {
        let path = laboratory.folder.join("runs").join(format!("{name}.csv"));
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        std::fs::write(path, &text[..text.len() / 2]).expect("writable");
    }
}

/// The seeds of the robots of a run.
pub fn robots(seed: u64, sessions: u32) -> Vec<u64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..sessions.div_ceil(SESSIONS_EACH)).map(|_| rng.random()).collect()
}
