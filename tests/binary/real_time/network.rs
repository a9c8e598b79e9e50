//! Several programs at one robot's port: hosts, strangers, and a host that died.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use host_link::Motion;
use shared_proto::{
    Channel, Command, Decoder, Encoder, Hello, MotionId, Reply, Request, WheelPair,
};

use super::TCP;
use crate::outcome::{collect, wait_for};
use crate::served::{Served, interrupt};
use crate::temp_folder::TempFolder;

/// 0.68 m in 2.8 s of cruise and ramps.
pub const DRIVE: &str = "drive straight 3rev --cruise 1.2rev/s --acceleration 2rev/s^2";

#[test]
fn a_second_host_may_look_and_is_refused_by_name_while_one_drives() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let driver = robot.spawn(DRIVE);
    robot.wait_until_travelled(0.1);
    let identity = robot.identify();
    assert_eq!(identity["status"]["state"], "driving", "{identity}");
    let message = robot.run("drive straight 1rev").refused();
    assert!(message.contains("already driving"), "{message}");
    let message = robot.run("config set limits.duty_max 0.5").refused();
    assert!(message.contains("another host drives it"), "{message}");
    // And it may watch the driver's telemetry.
    let watched = robot.run("watch --json --rate 50 --for 400ms").ok();
    assert!((5..25).contains(&watched.stdout.lines().count()), "at its own rate: {watched:#?}");
    let frame: serde_json::Value =
        serde_json::from_str(watched.stdout.lines().last().unwrap()).unwrap();
    assert!(frame["pose"]["x_um"].as_i64().unwrap() > 100_000, "{frame}");
    let outcome = collect(driver).ok();
    assert!(outcome.stdout.contains("Completed"), "{outcome:#?}");
    assert!(robot.travelled_m() > 0.6, "{}", robot.travelled_m());
}

#[test]
fn who_looks_at_a_stopped_robot_reads_why() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    robot.run("stop --now").ok();
    let lines = robot.run("watch --plain --for 200ms").ok();
    assert!(lines.stderr.contains("fault: emergency_stop"), "{lines:#?}");
    let json = robot.run("watch --json --for 200ms").ok();
    let first: serde_json::Value =
        serde_json::from_str(json.stdout.lines().next().unwrap()).unwrap();
    assert_eq!(first["Fault"]["fault"], "emergency_stop", "{json:#?}");
}

#[test]
fn who_watches_goes_on_seeing_the_robot_when_the_host_that_drove_it_is_gone() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let watcher = robot.spawn("watch --json --rate 5");
    robot.run("drive straight 5cm").ok();
    std::thread::sleep(Duration::from_secs(4));
    interrupt(&watcher);
    let seen = collect(watcher);
    let states: Vec<String> = seen
        .stdout
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter_map(|frame| frame["state"].as_str().map(str::to_owned))
        .collect();
    let driven = states.iter().rposition(|state| state == "driving").expect("it drove");
    let idle = states[driven..].iter().filter(|state| *state == "idle").count();
    assert!(idle >= 5, "{idle} frames after the drive, of {}", states.len());
}

#[test]
fn a_second_host_stops_the_first_one() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let driver = robot.spawn(DRIVE);
    robot.wait_until_travelled(0.1);
    robot.run("stop").ok();
    let outcome = collect(driver);
    assert_eq!(outcome.code, Some(2), "{outcome:#?}");
    assert!(outcome.stdout.contains("Stopped"), "{outcome:#?}");
    assert!(outcome.stderr.contains("another host stopped the robot"), "{outcome:#?}");
    assert!(robot.travelled_m() < 0.5, "{}", robot.travelled_m());
    assert_eq!(robot.identify()["status"]["state"], "idle");
}

#[test]
fn a_host_whose_drive_was_ended_leaves_the_next_drive_alone() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let driver = robot.spawn(DRIVE);
    robot.wait_until_travelled(0.1);
    robot.run("stop --now").ok();
    robot.run("clear").ok();
    // Until then the first host may have seen nothing but the end of its motion.
    let next = robot.run("drive straight 15cm --cruise 0.08m/s").ok();
    assert!(!next.stdout.contains("Stopped"), "{next:#?}");
    let outcome = collect(driver);
    assert_eq!(outcome.code, Some(2), "{outcome:#?}");
    assert!(!outcome.stderr.contains("refused"), "{outcome:#?}");
}

/// A connection to a robot's port.
pub fn connect(robot: &Served<'_>) -> TcpStream {
    let address = robot.port().strip_prefix("tcp:").expect("a TCP port");
    let stream = TcpStream::connect(address).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(10))).expect("a timeout");
    stream
}

/// What arms a robot and drives it, without a word before.
pub fn commands() -> Vec<u8> {
    let mut encoder = Encoder::new();
    let mut bytes = Vec::new();
    let drive = Motion::PAPER.drive_now(MotionId(7));
    for command in [Command::Arm { take: true }, Command::Drive(drive)] {
        let request = Request { session: 5, id: 1, until_ms: 5_000, command };
        bytes.extend_from_slice(&encoder.message(&request));
    }
    bytes
}

#[test]
fn strangers_are_cut_off_and_end_nobodys_drive() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let driver = robot.spawn(DRIVE);
    robot.wait_until_travelled(0.05);
    // A scan of the port.
    for _ in 0..30 {
        drop(connect(&robot));
    }
    let mut post = b"POST / HTTP/1.1\r\nOrigin: http://evil.example\r\n\r\n\0".to_vec();
    post.extend(Encoder::new().hello(Hello::of_this_build(5)).iter());
    post.extend(commands());
    let tls = b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".to_vec();
    let get = b"GET / HTTP/1.1\r\n\r\n".to_vec();
    for greeting in [post, get, tls, commands(), vec![b'x'; 100_000], vec![0xFF; 300]] {
        let begin = Instant::now();
        let mut stranger = connect(&robot);
        // Cut off while it still writes.
        let _ = stranger.write_all(&greeting);
        let mut heard = Vec::new();
        let _ = stranger.read_to_end(&mut heard);
        assert!(heard.is_empty(), "nothing is said to a stranger: {heard:?}");
        assert!(begin.elapsed() < Duration::from_millis(1500), "at its first bytes");
    }
    let outcome = collect(driver).ok();
    assert!(outcome.stdout.contains("Completed"), "{outcome:#?}");
    let stands_m = robot.travelled_m();
    std::thread::sleep(Duration::from_millis(500));
    assert!((robot.travelled_m() - stands_m).abs() < 0.005, "nothing moves");
    assert_eq!(robot.identify()["status"]["state"], "idle");
}

/// A host that speaks the protocol by hand.
struct ByHand {
    stream: TcpStream,
    encoder: Encoder,
    decoder: Decoder,
    next_id: u32,
}

const SESSION: u32 = 4711;

impl ByHand {
    fn open(robot: &Served<'_>) -> Self {
        let mut host = Self {
            stream: connect(robot),
            encoder: Encoder::new(),
            decoder: Decoder::new(),
            next_id: 0,
        };
        let hello = host.encoder.hello(Hello::of_this_build(SESSION));
        host.stream.write_all(&hello).expect("it listens");
        host
    }

    fn frame(&mut self, command: Command, until_ms: u64) -> Vec<u8> {
        self.next_id += 1;
        let request = Request { session: SESSION, id: self.next_id, until_ms, command };
        self.encoder.message(&request).to_vec()
    }

    /// Sends a request, and waits for its reply.
    fn ask(&mut self, command: Command, until_ms: u64) -> Reply {
        let frame = self.frame(command, until_ms);
        self.stream.write_all(&frame).expect("it listens");
        let mut byte = [0];
        loop {
            self.stream.read_exact(&mut byte).expect("it answers");
            if let Some(Ok(frame)) = self.decoder.push(byte[0])
                && frame.channel == Channel::Reply
                && let Some(reply) = frame.message::<Reply>()
                && reply.id == self.next_id
            {
                return reply;
            }
        }
    }
}

#[test]
fn a_dead_host_with_a_full_queue_drives_no_further_and_locks_nobody_out() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let mut host = ByHand::open(&robot);
    let lease = |reply: &Reply| reply.t_us / 1000 + 200;
    let now = host.ask(Command::Status, 0);
    let armed = host.ask(Command::Arm { take: false }, lease(&now));
    assert!(armed.outcome.is_ok(), "{armed:?}");
    let motion = MotionId(7);
    let far = Motion {
        distance: WheelPair::both(100.0),
        cruise: 1.2,
        acceleration: 2.0,
        ..Motion::PAPER
    };
    let mut latest = host.ask(Command::Drive(far.drive_now(motion)), lease(&armed));
    assert!(latest.outcome.is_ok(), "{latest:?}");
    let until = Instant::now() + Duration::from_millis(1500);
    while Instant::now() < until {
        latest = host.ask(Command::Renew { motion }, lease(&latest));
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(robot.travelled_m() > 0.1, "it drives: {}", robot.travelled_m());
    // 2 MB of the renewals of a living host, as fast as the network takes them; and it dies.
    let renew = host.frame(Command::Renew { motion }, lease(&latest));
    let queue = renew.repeat(2_000_000 / renew.len());
    let mut stream = host.stream.try_clone().expect("one more");
    let before_m = robot.travelled_m();
    std::thread::spawn(move || {
        let _ = stream.write_all(&queue);
    });
    // Another host is answered beside it, and names what happened.
    let fault = wait_for("the fault of a robot without its host", || {
        let fault = robot.identify()["status"]["fault"]["fault"].clone();
        (!fault.is_null()).then_some(fault)
    });
    assert_eq!(fault, "time_to_live", "it was talked to all the time");
    wait_for("the robot to stand", || {
        (robot.identify()["status"]["state"] == "faulted").then_some(())
    });
    // 0.27 m/s for 250 ms and its ramp; the rest is what two processes on a busy machine take to notice.
    let further_m = robot.travelled_m() - before_m;
    assert!(further_m < 0.3, "{further_m}");
    robot.run("stop --now").ok();
    robot.run("clear").ok();
    drop(host);
}

#[test]
fn a_port_that_others_can_reach_needs_a_word() {
    let temp = TempFolder::new();
    let message = temp.run("sim --listen tcp:0.0.0.0:0 --for 1s").refused();
    assert!(message.contains("anyone who can reach that address can drive the robot"), "{message}");
    let outcome = temp.run("sim --listen tcp:0.0.0.0:0 --insecure --for 200ms").ok();
    assert!(outcome.stdout.contains("0.0.0.0"), "{outcome:#?}");
}

#[test]
fn velocities_from_standard_input_are_driven_until_it_ends() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let mut host = robot.spawn("drive velocity -");
    let mut input = host.stdin.take().expect("a pipe");
    for _ in 0..20 {
        input.write_all(b"0.2 0\n").expect("it reads");
        std::thread::sleep(Duration::from_millis(100));
    }
    drop(input);
    let outcome = collect(host).ok();
    assert!(outcome.stderr.contains("done"), "{outcome:#?}");
    // 2.5 s less the encoder check, and the ramps.
    assert!((0.2..0.6).contains(&robot.travelled_m()), "{}", robot.travelled_m());
    assert_eq!(robot.identify()["status"]["state"], "idle");

    // A velocity that the robot refuses is named by its line as well.
    let mut host = robot.spawn("drive velocity -");
    let mut input = host.stdin.take().expect("a pipe");
    input.write_all(b"0.05 0\n\n").expect("it reads");
    std::thread::sleep(Duration::from_millis(300));
    input.write_all(b"900 0\n").expect("it reads");
    let message = collect(host).refused();
    assert!(message.contains("line 3 of standard input: the robot refused to drive"), "{message}");

    let mut host = robot.spawn("drive velocity -");
    host.stdin.take().expect("a pipe").write_all(b"0.1 0\nleft\n").expect("it reads");
    let message = collect(host).refused();
    assert!(message.contains("line 2 of standard input"), "{message}");
    assert_eq!(robot.identify()["status"]["state"], "idle");
}
