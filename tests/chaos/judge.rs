//! What must hold whatever happens: one list, and the judge of it.
//!
//! The judge sees the plant, what hosts hand to the network, what the robot puts on its line, the bytes of its flash, and the
//! campaign's files. It asks neither robot nor host.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use firmware::hal::Store;
use firmware::store::FlashStore;
use futures_lite::future::block_on;
use shared_proto::{Channel, Command, Config, Key, MotionId, Nonce, Received, Request};
use sim_target::{Nor, Testbed, now_us};

/// The speed of every drive \[m/s\]; velocities and voltages are slower.
pub const CRUISE_MPS: f64 = 0.2;

/// What must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Invariant {
    /// A controlled stop begins within 250 ms of the last renewal that a living host sent, and the robot stands after its ramp.
    MovesOnlyUnderALease,
    /// The wheels travel no farther than the motions that hosts have commanded, each once and for its time.
    NothingIsObeyedTwice,
    /// No wheel is more than `OVERSHOOT` times as fast as the fastest motion that hosts command, whatever the voltage.
    SpeedsAreKept,
    /// After an emergency stop the motors are off until somebody clears it; from a fresh host under flood within 100 ms.
    EmergencyStopStops,
    /// The stored configuration is the old one or the new one; the new one once the robot has said so.
    StoredConfigIsOldOrNew,
    /// The same of the key.
    StoredKeyIsOldOrNew,
    /// No challenge comes again after a restart.
    NoChallengeComesAgain,
    /// Queues of server and host are bounded.
    QueuesAreBounded,
    /// A recorded run is there whole and with its facts, or not at all.
    RunsAreWhole,
    /// When the storm is over, a holder of the key drives, with a fresh session.
    TheSessionResumes,
}

impl Invariant {
    /// All.
    pub const ALL: [Self; 10] = [
        Self::MovesOnlyUnderALease,
        Self::NothingIsObeyedTwice,
        Self::SpeedsAreKept,
        Self::EmergencyStopStops,
        Self::StoredConfigIsOldOrNew,
        Self::StoredKeyIsOldOrNew,
        Self::NoChallengeComesAgain,
        Self::QueuesAreBounded,
        Self::RunsAreWhole,
        Self::TheSessionResumes,
    ];
}

/// An invariant that did not hold.
#[derive(Clone, Debug)]
pub struct Broken {
    /// Which one.
    pub invariant: Invariant,
    /// When, on the virtual clock \[us\].
    pub t_us: u64,
    /// What was seen.
    pub seen: String,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} at {:.3} s: {}", self.invariant, self.t_us as f64 * 1e-6, self.seen)
    }
}

/// What the wheels may still travel when the motors go off, for each motion, and what else they may in a session \[m\].
const ROLL_M: f64 = 0.045;

/// The ramps of all motions, and of a controlled stop \[m/s^2\].
pub const RAMP_MPS2: f64 = 0.5;

/// By how much a wheel may exceed the fastest speed that is asked of it: a controller overshoots, and a voltage's limit is
/// found a moment after it.
const OVERSHOOT: f64 = 1.15;

/// A robot obeys a velocity for so long at most \[us\].
const LIVES_US: u64 = 250_000;

/// Half the track, and a little more \[m\].
const HALF_TRACK_M: f64 = 0.19;

/// What the judge knows.
pub struct Judge {
    testbed: Testbed,
    nor: Nor,
    /// What did not hold; of each invariant the first in a session.
    pub broken: Vec<Broken>,
    session_broke: BTreeSet<Invariant>,
    /// When a living host last sent a renewal, or began a motion \[us\].
    live_us: u64,
    /// Sessions and their motions.
    motions: BTreeSet<(u32, u32)>,
    may_travel_m: f64,
    /// The fastest velocity of this session \[m/s\], and until when the last one is obeyed \[us\].
    velocity_mps: f64,
    velocity_until_us: u64,
    travelled_m: f64,
    last_us: u64,
    /// When the motors went off by an emergency stop \[us\].
    stopped_us: Option<u64>,
    pub cleared_us: u64,
    pub restarted_us: u64,
    starts: u32,
    challenges: BTreeMap<Nonce, u32>,
    /// What may be stored: the last that is known, and what was written since.
    configs: Vec<Option<Config>>,
    keys: Vec<Option<Key>>,
}

impl Judge {
    pub fn new(testbed: Testbed, nor: Nor) -> Self {
        Self {
            testbed,
            nor,
            broken: Vec::new(),
            session_broke: BTreeSet::new(),
            live_us: 0,
            motions: BTreeSet::new(),
            may_travel_m: 0.0,
            velocity_mps: 0.0,
            velocity_until_us: 0,
            travelled_m: 0.0,
            last_us: 0,
            stopped_us: None,
            cleared_us: 0,
            restarted_us: 0,
            starts: 0,
            challenges: BTreeMap::new(),
            configs: vec![None],
            keys: vec![None],
        }
    }

    /// A further session begins: the robot stands.
    pub fn begin(&mut self) {
        self.session_broke.clear();
        self.motions.clear();
        (self.may_travel_m, self.travelled_m, self.velocity_mps) = (0.0, 0.0, 0.0);
    }

    pub fn fail(&mut self, invariant: Invariant, seen: String) {
        if self.session_broke.insert(invariant) {
            self.broken.push(Broken { invariant, t_us: now_us(), seen });
        }
    }

    pub fn bounded(&mut self, what: &str, waiting: usize, bound: usize) {
        if waiting > bound {
            self.fail(
                Invariant::QueuesAreBounded,
                format!("{waiting} wait at {what}: above {bound}"),
            );
        }
    }

    /// A living host hands this to the network.
    pub fn host_sends(&mut self, request: &Request) {
        match &request.command {
            Command::Renew { .. } => self.live_us = now_us(),
            Command::Drive(drive) => {
                self.live_us = now_us();
                let distance_m = 0.5 * (drive.distance.left.abs() + drive.distance.right.abs());
                self.motion_may_travel(request.session, drive.motion, distance_m);
            }
            Command::Velocity(velocity) => {
                self.live_us = now_us();
                self.motion_may_travel(request.session, velocity.motion, 0.0);
                let turning_mps = HALF_TRACK_M * velocity.turn_rad_s.abs();
                let faster_mps = velocity.forward_mps.abs() + turning_mps;
                self.velocity_mps = self.velocity_mps.max(faster_mps);
                self.velocity_until_us = now_us() + LIVES_US;
            }
            Command::Voltage(voltage) => {
                self.live_us = now_us();
                let in_its_time_m = voltage.speed_mps_max * voltage.duration_s;
                let distance_m = voltage.travel_m_max.min(in_its_time_m);
                self.motion_may_travel(request.session, voltage.motion, distance_m);
            }
            Command::ClearFault { .. } => {
                self.cleared_us = now_us();
                self.stopped_us = None;
            }
            Command::WriteConfig(config) => self.configs.push(Some(config.clone())),
            _ => {}
        }
    }

    /// A motion that is commanded again travels no farther.
    fn motion_may_travel(&mut self, session: u32, motion: MotionId, distance_m: f64) {
        if self.motions.insert((session, motion.0)) {
            self.may_travel_m += distance_m + ROLL_M;
        }
    }

    /// A host is about to set this key, which nobody else can read in its frames.
    pub fn key_may_be(&mut self, key: Option<Key>) {
        self.keys.push(key);
    }

    /// The robot puts this on its line.
    pub fn robot_says(&mut self, frame: &Received<'_>) {
        // What was on the line when it restarted is still the old one's.
        if frame.channel == Channel::Hello
            && now_us() > self.restarted_us + 20_000
            && let Some(challenge) = frame.challenge()
        {
            let first = *self.challenges.entry(challenge).or_insert(self.starts);
            if first != self.starts {
                let seen = format!("a challenge of start {first} at start {}", self.starts);
                self.fail(Invariant::NoChallengeComesAgain, seen);
            }
        }
    }

    /// The motors are off by an emergency stop that was commanded at this time, if nothing came between.
    pub fn emergency_stop_done(&mut self, called_us: u64) {
        if called_us > self.cleared_us + 500_000 && called_us > self.restarted_us {
            self.stopped_us = Some(now_us());
        }
    }

    /// The controller restarts now.
    pub fn restarts(&mut self) {
        self.starts += 1;
        self.restarted_us = now_us();
        self.stopped_us = None;
        self.look_into_flash();
    }

    /// The robot has said that it saved this configuration, and nobody else has written since.
    pub fn saved(&mut self, config: &Config) {
        self.configs = vec![Some(config.clone())];
        self.look_into_flash();
    }

    /// Only this key is stored now.
    pub fn key_is(&mut self, key: Option<Key>) {
        self.keys = vec![key];
        self.look_into_flash();
    }

    /// What the flash would hold if the power went now.
    pub fn look_into_flash(&mut self) {
        let mut store = FlashStore::new(self.nor.copy());
        let config = match block_on(store.load()) {
            Ok(config) => config,
            Err(error) => {
                return self.fail(Invariant::StoredConfigIsOldOrNew, format!("{error:?}"));
            }
        };
        if !self.configs.contains(&config) {
            let names = self.configs.iter().map(name).collect::<Vec<_>>();
            let seen = format!("{} is stored, and was none of {names:?}", name(&config));
            self.fail(Invariant::StoredConfigIsOldOrNew, seen);
        }
        match block_on(store.link(None)) {
            Ok(record) if self.keys.contains(&record.key) => {}
            other => {
                let seen = format!("{other:?} is stored, and was none of {}", self.keys.len());
                self.fail(Invariant::StoredKeyIsOldOrNew, seen);
            }
        }
    }

    /// When a session has ended, nobody writes any more: what is stored now is the old one.
    pub fn settle(&mut self) {
        self.look_into_flash();
        let mut store = FlashStore::new(self.nor.copy());
        self.configs = vec![block_on(store.load()).unwrap_or_default()];
        self.keys.retain(|key| block_on(store.link(None)).is_ok_and(|record| record.key == *key));
    }

    /// Every millisecond.
    pub fn watch(&mut self) {
        let (speed_mps, faster_mps, powered) = self.testbed.plant(|plant| {
            let radius_m = plant.parameters().geometry.wheel_radius_m;
            let speed = plant.wheel_speeds_rad_s().zip(radius_m).map(|(w, r)| (w * r).abs());
            let mean = 0.5 * (speed.left + speed.right);
            (mean, speed.left.max(speed.right), plant.currents_a().any(|a| a != 0.0))
        });
        let now_us = now_us();
        let obeyed_us = now_us.min(self.velocity_until_us).saturating_sub(self.last_us);
        self.may_travel_m += self.velocity_mps * obeyed_us as f64 * 1e-6;
        self.travelled_m += speed_mps * (now_us - self.last_us) as f64 * 1e-6;
        self.last_us = now_us;
        if self.travelled_m > self.may_travel_m + ROLL_M {
            let seen =
                format!("{:.3} m travelled, {:.3} allowed", self.travelled_m, self.may_travel_m);
            self.fail(Invariant::NothingIsObeyedTwice, seen);
        }
        if faster_mps > OVERSHOOT * CRUISE_MPS {
            let seen = format!("{faster_mps:.3} m/s, and {CRUISE_MPS} m/s at most were asked for");
            self.fail(Invariant::SpeedsAreKept, seen);
        }
        // As `begins_to_stop_us` has it: at 0.95 of the cruise it has begun.
        let late_us = now_us.saturating_sub(self.live_us + 250_000);
        let limit_mps = (0.95 * CRUISE_MPS - RAMP_MPS2 * late_us as f64 * 1e-6).max(0.015);
        if late_us > 0 && speed_mps > limit_mps {
            let seen =
                format!("{speed_mps:.3} m/s, {} ms after the last renewal", late_us / 1000 + 250);
            self.fail(Invariant::MovesOnlyUnderALease, seen);
        }
        if let Some(stopped_us) = self.stopped_us.filter(|_| powered) {
            let seen = format!("powered {} us after it", now_us - stopped_us);
            self.fail(Invariant::EmergencyStopStops, seen);
        }
    }

    /// Whether a motor carries current, and whether a wheel turns.
    pub fn moves(&self) -> (bool, bool) {
        self.testbed.plant(|plant| {
            let powered = plant.currents_a().any(|a| a != 0.0);
            (powered, plant.wheel_speeds_rad_s().any(|w| w.abs() > 0.01))
        })
    }
}

fn name(config: &Option<Config>) -> String {
    config.as_ref().map_or("none".into(), |config| config.name.to_string())
}
