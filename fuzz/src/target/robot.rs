//! The firmware's own tasks, on a simulated robot: the dispatcher of frames and everything behind it.

use shared_proto::{
    Answer, Channel, Command, Decoder, Encoder, Event, Hello, Received, Reply, Request, Telemetry,
};
use sim_target::plant::PlantFault;
use sim_target::scenario::LinkParameters;
use sim_target::{HostWire, Options, Scenario, SimTarget, Testbed, now_us};

use crate::bytes::Bytes;

/// At most this long in all, before the silence \[us\].
const DRIVE_US_MAX: u64 = 3_000_000;

/// The longest silence after which a robot with its own configuration has stopped \[us\]: 200 ms of the link's timeout,
/// then the ramp, then the last of its oscillation.
const SILENCE_US: u64 = 2_500_000;

/// An input is a list of acts: a byte says which, and what it needs follows.
pub fn robot(input: &[u8]) {
    // A line without delay, as the bytes are to be tested, and not their times.
    let link = LinkParameters { baud: 0, ..LinkParameters::default() };
    let scenario = Scenario { link, ..Scenario::default() };
    let target = SimTarget::new(&scenario, Options::default()).expect("there is no file");
    let (testbed, wire) = (target.testbed(), target.host_wire());
    let mut host = Host {
        target,
        testbed,
        wire,
        encoder: Encoder::new(),
        sent: Decoder::new(),
        heard: Decoder::new(),
        may_be_armed: false,
        configured: false,
        may_have_key: false,
    };
    let mut bytes = Bytes(input);
    while !bytes.is_empty() && now_us() < DRIVE_US_MAX {
        host.act(&mut bytes);
        host.hear();
    }
    host.fall_silent();
}

struct Host {
    target: SimTarget,
    testbed: Testbed,
    wire: HostWire,
    encoder: Encoder,
    /// Reads what is sent, as the robot does: damage may make frames that nobody meant.
    sent: Decoder,
    heard: Decoder,
    /// A command to arm, with any lease, has been sent.
    may_be_armed: bool,
    /// So has another configuration: the robot may be a slow one.
    configured: bool,
    /// And a key: this host, which seals nothing, may be a stranger now.
    may_have_key: bool,
}

impl Host {
    fn act(&mut self, bytes: &mut Bytes<'_>) {
        match bytes.byte() % 8 {
            0 => {
                let session = u32::from(bytes.byte() % 6);
                let frame = self.encoder.hello(Hello::of_this_build(session));
                self.send(&frame);
            }
            1..=3 => self.request(bytes),
            4 => {
                let len = usize::from(bytes.byte());
                let raw = bytes.take(len).to_vec();
                self.send(&raw);
            }
            5 | 6 => {
                let wait_us = 1000 * (1 + u64::from(bytes.byte()));
                self.target.run_until_us(now_us() + wait_us);
            }
            _ => {
                let button = PlantFault::EmergencyStop;
                self.testbed.inject(button);
                self.stands_without_current("the button");
                if bytes.byte().is_multiple_of(2) {
                    self.testbed.mend(button);
                }
            }
        }
    }

    /// A session, a lease, the length of a command and its bytes.
    fn request(&mut self, bytes: &mut Bytes<'_>) {
        let session = u32::from(bytes.byte() % 6);
        let lease_ms = u64::from(bytes.byte());
        let len = usize::from(bytes.byte());
        let Ok((command, _)) = postcard::take_from_bytes::<Command>(bytes.take(len)) else {
            return;
        };
        let until_ms = if lease_ms == 0 { 0 } else { now_us() / 1000 + 4 * lease_ms };
        let stops = command == Command::EmergencyStop;
        let frame = self.encoder.message(&Request { session, id: 7, until_ms, command });
        self.send(&frame);
        if stops && !self.may_have_key {
            self.stands_without_current("an emergency stop");
        } else {
            self.target.run_until_us(now_us() + 1000);
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if let Some(Ok(received)) = self.sent.push(byte)
                && let Some(request) = received.message::<Request>()
            {
                self.may_be_armed |= matches!(request.command, Command::Arm { .. });
                self.configured |= matches!(request.command, Command::WriteConfig(_));
                self.may_have_key |= matches!(request.command, Command::SetKey { key: Some(_) });
            }
        }
        self.wire.write_now(bytes);
    }

    /// The motors are off within 20 ms.
    fn stands_without_current(&mut self, why: &str) {
        // Damage before it may have taken the frame with it.
        if why != "the button" {
            self.wire.write_now(&[0]);
            let again = Request { session: 1, id: 8, until_ms: 0, command: Command::EmergencyStop };
            // No session has agreed on the protocol: the robot reads no request.
            let hello = self.encoder.hello(Hello::of_this_build(1));
            self.send(&hello);
            let frame = self.encoder.message(&again);
            self.send(&frame);
        }
        self.target.run_until_us(now_us() + 20_000);
        self.no_current(why);
    }

    fn no_current(&self, why: &str) {
        let current_a = self.testbed.plant(|plant| plant.currents_a());
        assert!(!current_a.any(|current_a| current_a != 0.0), "{current_a:?} after {why}");
    }

    /// Reads what the robot says.
    fn hear(&mut self) {
        let mut buffer = [0; 2048];
        loop {
            let len = self.wire.read_now(&mut buffer);
            if len == 0 {
                break;
            }
            for &byte in &buffer[..len] {
                if let Some(frame) = self.heard.push(byte) {
                    understood(&frame.expect("a robot sends good frames"));
                }
            }
        }
        if !self.may_be_armed {
            self.no_current("no command to arm");
        }
    }

    /// Nobody speaks any more: the robot stops, and stands.
    fn fall_silent(&mut self) {
        self.target.run_until_us(now_us() + SILENCE_US);
        self.hear();
        if self.configured {
            return;
        }
        let before = self.testbed.pose();
        self.target.run_until_us(now_us() + 200_000);
        let way = self.testbed.pose().relative_to(before);
        let moved_m = way.x_m.hypot(way.y_m);
        assert!(moved_m < 1e-3, "it still moves: {moved_m} m");
    }
}

/// Every frame of a robot can be read.
fn understood(frame: &Received<'_>) {
    match frame.channel {
        Channel::Hello => drop(frame.hello().expect("a hello")),
        Channel::Opened => panic!("nobody has shown a key"),
        Channel::Reply => {
            let reply: Reply = frame.message().expect("a reply");
            if let Ok(Answer::Config(config)) = reply.outcome {
                assert!(config.validate().is_ok(), "{config:?}");
            }
        }
        Channel::Telemetry => drop(frame.message::<Telemetry>().expect("telemetry")),
        Channel::Event => drop(frame.message::<Event>().expect("an event")),
        Channel::Open | Channel::Request => panic!("a robot asks for nothing"),
    }
}
