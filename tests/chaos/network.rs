//! What lies between hosts and robot: a line that several hosts share, or a server with a connection for each.
//!
//! On a shared line frames are lost, held back, repeated and overtaken. A connection keeps their order, and may break; what a
//! dead host has sent before may still be under way. The server is the real one, [`Hub`].

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::rc::Rc;
use std::task::Waker;
use std::time::Duration;

use host_link::listen::Hub;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Command, Decoder, Encoder, Request};
use sim_target::{HostWire, now_us};

use super::judge::Judge;
use super::plant::{Plant, request, send};
use super::socket::{SOCKET, Socket};

/// What the network does to frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct Weather {
    /// Share of frames that are lost, come twice, and are held back for up to `delay_us`.
    pub loss: f64,
    pub twice: f64,
    pub held: f64,
    pub delay_us: u64,
    /// What every frame takes \[us\].
    pub base_us: u64,
}

impl Weather {
    /// From calm to a storm.
    pub fn draw(rng: &mut ChaCha8Rng) -> Self {
        let hard: f64 = rng.random_range(0.0..1.0);
        Self {
            loss: rng.random_range(0.0..0.2) * hard,
            twice: rng.random_range(0.0..0.2) * hard,
            held: rng.random_range(0.0..0.3) * hard,
            delay_us: rng.random_range(1_000..1_500_000),
            base_us: rng.random_range(0..8_000),
        }
    }
}

/// Frames under way, each with its time of arrival \[us\].
type UnderWay = VecDeque<(u64, Vec<u8>)>;

/// One host's line or connection.
pub struct Link {
    to_robot: UnderWay,
    to_host: UnderWay,
    open: bool,
    reads: bool,
    waker: Option<Waker>,
    socket: Option<Socket>,
}

impl Link {
    /// What has arrived at the host; none while nothing has, and an error if the connection is over.
    pub fn take(&mut self, waker: &Waker) -> Option<io::Result<Vec<u8>>> {
        let mut bytes = Vec::new();
        while self.to_host.front().is_some_and(|(due_us, _)| *due_us <= now_us()) {
            bytes.extend(self.to_host.pop_front().expect("it is there").1);
        }
        if !bytes.is_empty() {
            return Some(Ok(bytes));
        }
        if !self.open {
            return Some(Err(ErrorKind::UnexpectedEof.into()));
        }
        self.waker = Some(waker.clone());
        None
    }

    /// Whether the host can send.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// The host is gone. What it has sent stays under way, or vanishes with it.
    pub fn end(&mut self, vanishes: bool) {
        self.open = false;
        if vanishes {
            self.to_robot.clear();
        }
    }

    /// The host reads no more.
    pub fn stop_reading(&mut self) {
        self.reads = false;
    }

    fn wake(&mut self) {
        let due = self.to_host.front().is_some_and(|(due_us, _)| *due_us <= now_us());
        if (due || !self.open)
            && let Some(waker) = self.waker.take()
        {
            waker.wake();
        }
    }
}

/// Hosts' links, and the robot's line.
pub struct Network {
    links: Vec<Rc<RefCell<Link>>>,
    hub: Option<Hub<Socket>>,
    /// Whether there is a server between, and since when it is up again if it was killed \[us\].
    served: bool,
    up_us: u64,
    pub weather: Weather,
    rng: ChaCha8Rng,
    wire: HostWire,
    /// Frames that hosts have sent: somebody may send them again.
    pub recorded: Vec<Vec<u8>>,
    from_robot: Vec<u8>,
    decoder: Decoder,
    judge: Rc<RefCell<Judge>>,
    plant: Option<Plant>,
    renewal: Option<(u64, Request)>,
}

impl Network {
    pub fn new(
        wire: HostWire,
        served: bool,
        seed: u64,
        judge: Rc<RefCell<Judge>>,
        plant: Option<Plant>,
    ) -> Self {
        Self {
            links: Vec::new(),
            hub: served.then(Hub::default),
            served,
            up_us: 0,
            weather: Weather::default(),
            rng: ChaCha8Rng::seed_from_u64(seed),
            wire,
            recorded: Vec::new(),
            from_robot: Vec::new(),
            decoder: Decoder::new(),
            judge,
            plant,
            renewal: None,
        }
    }

    /// A further host's link; none while the server is down.
    pub fn connect(&mut self) -> Option<Rc<RefCell<Link>>> {
        let socket = Socket::default();
        if self.served {
            let now = Duration::from_micros(now_us());
            socket.0.borrow_mut().hoards = self.plant == Some(Plant::ServerThatHoards);
            self.hub.as_mut()?.join(socket.clone(), now, &mut |_| ());
        }
        let link = Link {
            to_robot: VecDeque::new(),
            to_host: VecDeque::new(),
            open: true,
            reads: true,
            waker: None,
            socket: self.served.then_some(socket),
        };
        let link = Rc::new(RefCell::new(link));
        self.links.push(link.clone());
        Some(link)
    }

    /// The server dies, with all that it holds, and comes back.
    pub fn kill_server(&mut self, down_us: u64) {
        if self.served {
            self.hub = None;
            self.up_us = now_us() + down_us;
            self.links.drain(..).for_each(|link| {
                link.borrow_mut().end(true);
                link.borrow_mut().wake();
            });
        }
    }

    /// Every host is gone, with all that is under way; the weather is fine.
    pub fn clear(&mut self) {
        for link in &self.links {
            link.borrow_mut().end(true);
        }
        self.weather = Weather::default();
        self.up_us = 0;
    }

    /// Puts a frame of a host on its way.
    pub fn submit(&mut self, link: &Rc<RefCell<Link>>, bytes: &[u8]) {
        if self.recorded.len() < 400 {
            self.recorded.push(bytes.to_vec());
        }
        if let Some(request) = request(bytes)
            && match self.plant {
                Some(Plant::ServerThatRenews) => matches!(request.command, Command::Renew { .. }),
                Some(Plant::VelocityThatGoesOn) => matches!(request.command, Command::Velocity(_)),
                _ => false,
            }
        {
            self.renewal = Some((now_us(), request));
        }
        let (served, weather) = (self.served, self.weather);
        put(&mut link.borrow_mut().to_robot, bytes, served, weather, &mut self.rng);
    }

    /// Straight on the line, as somebody else on it does.
    pub fn intrude(&mut self, bytes: &[u8]) {
        if self.wire.has_room() {
            self.wire.write_now(bytes);
        }
    }

    /// Whether the robot's line takes more.
    pub fn has_room(&self) -> bool {
        self.wire.has_room()
    }

    /// Passes on what is due, both ways.
    pub fn step(&mut self) {
        let mut heard = Vec::new();
        let mut buffer = [0; 1024];
        loop {
            let len = self.wire.read_now(&mut buffer);
            if len == 0 {
                break;
            }
            heard.extend(&buffer[..len]);
        }
        for &byte in &heard {
            if let Some(Ok(frame)) = self.decoder.push(byte) {
                self.judge.borrow_mut().robot_says(&frame);
            }
        }
        if let Some((since_us, request)) = self.renewal.clone()
            && now_us() < since_us + 1_000_000
            && now_us() % 30_000 < 500
        {
            let until_ms = now_us() / 1000 + 200;
            self.wire.write_now(&Encoder::new().message(&Request { until_ms, ..request }));
        }
        if self.served {
            self.step_server(&heard)
        } else {
            self.step_line(&heard)
        }
        self.links.retain(|link| {
            let link = &mut *link.borrow_mut();
            link.wake();
            link.open || !link.to_robot.is_empty() || link.socket.is_some()
        });
    }

    fn step_server(&mut self, heard: &[u8]) {
        let now = Duration::from_micros(now_us());
        if self.hub.is_none() && now_us() >= self.up_us {
            self.hub = Some(Hub::default());
        }
        for link in &self.links {
            let link = &mut *link.borrow_mut();
            let socket = link.socket.as_ref().expect("there is a server");
            let buffers = &mut *socket.0.borrow_mut();
            while buffers.in_.len() < SOCKET
                && link.to_robot.front().is_some_and(|(due_us, _)| *due_us <= now_us())
            {
                buffers.in_.extend(link.to_robot.pop_front().expect("it is there").1);
            }
            buffers.ended |= !link.open && link.to_robot.is_empty();
        }
        let (wire, plant) = (&self.wire, self.plant);
        let mut most = 0;
        if let Some(hub) = &mut self.hub {
            hub.pass_on(
                now,
                &|| wire.has_room(),
                &mut |frame| send(wire, frame, plant),
                &mut |_| {},
            );
            hub.write(heard, now, &mut |_| {});
            most = hub.waiting_most();
        }
        let (weather, rng) = (self.weather, &mut self.rng);
        self.links.retain(|link| {
            let link = &mut *link.borrow_mut();
            let Some(socket) = &link.socket else { return true };
            // Nobody else has the other end: the server has cut it off.
            let cut_off = Rc::strong_count(&socket.0) == 1;
            let buffers = &mut *socket.0.borrow_mut();
            most = most.max(buffers.out.len());
            if link.reads && !buffers.out.is_empty() {
                let bytes: Vec<u8> = buffers.out.drain(..).collect();
                put(&mut link.to_host, &bytes, true, weather, rng);
            }
            if cut_off {
                link.open = false;
            }
            !cut_off
        });
        let bound = Hub::<Socket>::WAITING_MAX_EACH + 2048;
        self.judge.borrow_mut().bounded("a client at the server", most, bound);
    }

    fn step_line(&mut self, heard: &[u8]) {
        // In turn: a link that has much under way holds up no other.
        loop {
            let mut any = false;
            for link in &self.links {
                let link = &mut *link.borrow_mut();
                if self.wire.has_room()
                    && link.to_robot.front().is_some_and(|(due_us, _)| *due_us <= now_us())
                {
                    let (_, frame) = link.to_robot.pop_front().expect("it is there");
                    send(&self.wire, &frame, self.plant);
                    any = true;
                }
            }
            if !any {
                break;
            }
        }
        for &byte in heard {
            self.from_robot.push(byte);
            if byte == 0 {
                let frame = std::mem::take(&mut self.from_robot);
                for link in &self.links {
                    let link = &mut *link.borrow_mut();
                    if link.open && link.reads {
                        put(&mut link.to_host, &frame, false, self.weather, &mut self.rng);
                    }
                }
            }
        }
    }
}

/// Puts a frame on its way, as often as the weather has it.
fn put(way: &mut UnderWay, bytes: &[u8], ordered: bool, weather: Weather, rng: &mut ChaCha8Rng) {
    let chance = |share: f64, rng: &mut ChaCha8Rng| share > 0.0 && rng.random_bool(share);
    if !ordered && chance(weather.loss, rng) {
        return;
    }
    let copies = if !ordered && chance(weather.twice, rng) { 2 } else { 1 };
    for _ in 0..copies {
        let mut due_us = now_us() + weather.base_us;
        if chance(weather.held, rng) {
            due_us += rng.random_range(0..=weather.delay_us);
        }
        let at = match ordered {
            true => {
                due_us = due_us.max(way.back().map_or(0, |(last_us, _)| *last_us));
                way.len()
            }
            false => way.iter().position(|(other_us, _)| *other_us > due_us).unwrap_or(way.len()),
        };
        way.insert(at, (due_us, bytes.to_vec()));
    }
}
