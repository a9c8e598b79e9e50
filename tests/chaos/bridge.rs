//! What lies between hosts and robot: a server with a client for each host, on lines that lose, delay, repeat, reorder and damage
//! frames, and that send recorded ones again.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::rc::Rc;

use host_link::Wire;
use host_link::wire::Waiting;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sim_target::{HostWire, now_us, sleep_until_us};

use super::plant::Plant;
use super::witness::Witness;

/// How bad the lines of a session are: shares of frames.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weather {
    pub lost: f64,
    pub damaged: f64,
    pub twice: f64,
    /// Sent again at any later time.
    pub again: f64,
    pub late: f64,
    pub late_us_max: u64,
}

impl Weather {
    /// A fifth of the sessions have good lines; in the others each share is drawn by itself.
    pub(crate) fn draw(rng: &mut ChaCha8Rng) -> Self {
        let bad = rng.random_bool(0.8);
        let mut share = |most: f64| {
            if bad && rng.random_bool(0.6) { most * rng.random::<f64>().powi(2) } else { 0.0 }
        };
        let (lost, damaged, twice, again) = (share(0.3), share(0.1), share(0.2), share(0.2));
        let late = share(0.2);
        Self { lost, damaged, twice, again, late, late_us_max: rng.random_range(10_000..3_000_000) }
    }
}

/// Frames on their way: when each arrives \[us\], and its number, so that each has a place of its own.
type Underway = BTreeMap<(u64, u64), Vec<u8>>;

/// The server; clones are the same one.
#[derive(Clone)]
pub(crate) struct Bridge(Rc<RefCell<State>>);

struct State {
    wire: HostWire,
    rng: ChaCha8Rng,
    weather: Weather,
    plant: Plant,
    pub witness: Rc<RefCell<Witness>>,
    up: bool,
    /// Rises whenever the server is killed: clients of before have lost their connection.
    epoch: u32,
    count: u64,
    to_robot: Underway,
    to_hosts: BTreeMap<u64, Underway>,
    /// What was sent to the robot, to be sent again.
    sent: Vec<Vec<u8>>,
    from_robot: Vec<u8>,
}

impl Bridge {
    pub(crate) fn new(
        wire: HostWire,
        seed: u64,
        weather: Weather,
        plant: Plant,
        witness: Rc<RefCell<Witness>>,
    ) -> Self {
        Self(Rc::new(RefCell::new(State {
            wire,
            rng: ChaCha8Rng::seed_from_u64(seed),
            weather,
            plant,
            witness,
            up: true,
            epoch: 0,
            count: 0,
            to_robot: Underway::new(),
            to_hosts: BTreeMap::new(),
            sent: Vec::new(),
            from_robot: Vec::new(),
        })))
    }

    /// A connection of a host; none while the server is down.
    pub(crate) fn connect(&self) -> Option<Connection> {
        let mut state = self.0.borrow_mut();
        state.count += 1;
        let (client, epoch) = (state.count, state.epoch);
        state.up.then(|| {
            state.to_hosts.insert(client, Underway::new());
            Connection { bridge: self.clone(), client, epoch }
        })
    }

    /// Kills the server with all that is under way in it, or starts it again.
    pub(crate) fn set_up(&self, up: bool) {
        let mut state = self.0.borrow_mut();
        if !up {
            state.epoch += 1;
            state.to_robot.clear();
            state.to_hosts.clear();
        }
        state.up = up;
    }

    /// Passes on what is due. To be called every millisecond.
    pub(crate) fn pass_on(&self) {
        let mut state = self.0.borrow_mut();
        state.hear_the_robot();
        while state.wire.has_room()
            && let Some(first) = state.to_robot.first_entry()
            && first.key().0 <= now_us()
        {
            let frame = first.remove();
            state.tell_the_robot(&frame);
        }
    }
}

impl State {
    /// One write of a host is lost, damaged, delayed or repeated as a whole.
    fn accept(&mut self, bytes: &[u8]) {
        self.witness.borrow_mut().host_sends(bytes);
        self.sent.push(bytes.to_vec());
        for (due, frame) in self.fate(bytes) {
            self.to_robot.insert(due, frame);
        }
        if self.rng.random_bool(self.weather.again) {
            let old = self.sent[self.rng.random_range(0..self.sent.len())].clone();
            let due = self.due();
            self.to_robot.insert(due, old);
        }
    }

    fn fate(&mut self, bytes: &[u8]) -> Vec<((u64, u64), Vec<u8>)> {
        let Weather { lost, damaged, twice, .. } = self.weather;
        let copies = match (self.rng.random_bool(lost), self.rng.random_bool(twice)) {
            (true, _) => 0,
            (_, true) => 2,
            _ => 1,
        };
        let mut all = Vec::new();
        for _ in 0..copies {
            let mut frame = bytes.to_vec();
            if self.rng.random_bool(damaged) {
                for _ in 0..self.rng.random_range(1..5) {
                    let at = self.rng.random_range(0..frame.len());
                    frame[at] ^= 1 << self.rng.random_range(0..8);
                }
            }
            all.push((self.due(), frame));
        }
        all
    }

    /// When a frame that is sent now arrives.
    fn due(&mut self) -> (u64, u64) {
        let Weather { late, late_us_max, .. } = self.weather;
        let after_us = match self.rng.random_bool(late) {
            true => self.rng.random_range(0..late_us_max),
            false => 0,
        };
        self.count += 1;
        (now_us() + after_us, self.count)
    }

    fn tell_the_robot(&mut self, frame: &[u8]) {
        let planted = self.plant.on_the_way(frame, &self.witness.borrow());
        let frame = planted.as_deref().unwrap_or(frame);
        self.witness.borrow_mut().robot_hears(frame);
        self.wire.write_now(frame);
    }

    fn hear_the_robot(&mut self) {
        let mut buffer = [0; 1024];
        loop {
            let len = self.wire.read_now(&mut buffer);
            if len == 0 {
                break;
            }
            self.from_robot.extend_from_slice(&buffer[..len]);
        }
        while let Some(end) = self.from_robot.iter().position(|byte| *byte == 0) {
            let frame: Vec<u8> = self.from_robot.drain(..=end).collect();
            self.witness.borrow_mut().robot_sends(&frame);
            if let Some(own) = self.plant.of_its_own(&self.witness.borrow()) {
                self.wire.write_now(&own);
            }
            let clients: Vec<u64> = self.to_hosts.keys().copied().collect();
            for client in clients {
                for (due, frame) in self.fate(&frame) {
                    self.to_hosts.entry(client).or_default().insert(due, frame);
                }
            }
        }
    }
}

/// A host's end.
pub(crate) struct Connection {
    bridge: Bridge,
    client: u64,
    epoch: u32,
}

impl Connection {
    fn is_lost(&self) -> bool {
        self.bridge.0.borrow().epoch != self.epoch
    }

    fn due(&self) -> Option<Vec<u8>> {
        let mut state = self.bridge.0.borrow_mut();
        let first = state.to_hosts.get_mut(&self.client)?.first_entry()?;
        (first.key().0 <= now_us()).then(|| first.remove())
    }
}

impl Wire for Connection {
    fn write<'a>(&'a mut self, bytes: &'a [u8]) -> Waiting<'a, io::Result<()>> {
        Box::pin(async move {
            if self.is_lost() {
                return Err(io::ErrorKind::BrokenPipe.into());
            }
            self.bridge.0.borrow_mut().accept(bytes);
            Ok(())
        })
    }

    fn read(&mut self) -> Waiting<'_, io::Result<Vec<u8>>> {
        Box::pin(async move {
            loop {
                if self.is_lost() {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
                if let Some(frame) = self.due() {
                    return Ok(frame);
                }
                sleep_until_us(now_us() + 1000).await;
            }
        })
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.bridge.0.borrow_mut().to_hosts.remove(&self.client);
    }
}
