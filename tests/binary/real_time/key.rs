//! A robot with a key on a port that everybody can reach: who holds the key drives, and nobody else moves or hears
//! anything.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use shared_proto::{
    Channel, Command, Decoder, Encoder, Hello, Refusal, Reply, Request, SCHEMA_HASH,
};

use super::TCP;
use super::network::{DRIVE, commands, connect};
use crate::outcome::collect;
use crate::served::Served;
use crate::temp_folder::TempFolder;

/// A robot with the key in `robot.key`; `other.key` is another one.
fn with_key(temp: &TempFolder) -> Served<'_> {
    temp.run("key new robot.key").ok();
    temp.run("key new other.key").ok();
    Served::start_with(temp, TCP, "--key-file robot.key")
}

fn run(robot: &Served<'_>, arguments: &str) -> crate::outcome::Outcome {
    robot.run(&format!("{arguments} --key-file robot.key"))
}

#[test]
fn who_holds_the_key_drives_watches_and_stops_and_others_are_told_what_to_do() {
    let temp = TempFolder::new();
    let robot = with_key(&temp);
    let driver = robot.spawn(&format!("{DRIVE} --key-file robot.key"));
    robot.wait_until_travelled(0.1);
    for (arguments, said) in [
        ("identify", "--key-file FILE"),
        ("stop --now", "--key-file FILE"),
        ("stop", "--key-file FILE"),
        ("drive straight 1rev --key-file other.key", "has a different key"),
        ("stop --now --key-file other.key", "has a different key"),
        ("key clear --key-file robot.key", "over its serial line"),
    ] {
        let message = robot.run(arguments).refused();
        assert!(message.contains(said), "{arguments}: {message}");
    }
    let watched = run(&robot, "watch --json --rate 50 --for 300ms").ok();
    assert!(watched.stdout.lines().count() >= 5, "{watched:#?}");
    let outcome = collect(driver).ok();
    assert!(outcome.stdout.contains("Completed"), "nobody stopped it: {outcome:#?}");
    let driver = robot.spawn(&format!("{DRIVE} --key-file robot.key"));
    robot.wait_until_travelled(0.8);
    run(&robot, "stop").ok();
    let outcome = collect(driver);
    assert!(outcome.stderr.contains("another host stopped the robot"), "{outcome:#?}");
    let identity = run(&robot, "identify --json").ok();
    let key = String::from_utf8(temp.read("robot.key")).unwrap();
    let config = run(&robot, "config get --json").ok();
    for said in [&identity, &config] {
        assert!(!said.stdout.contains(key.trim()) && !said.stderr.contains(key.trim()), "{said:?}");
    }
}

#[test]
fn a_key_that_others_may_read_or_that_is_none_is_refused_and_a_robot_without_a_key_too() {
    let temp = TempFolder::new();
    temp.run("key new robot.key").ok();
    let message = temp.run("key new robot.key").refused();
    assert!(message.contains("is not overwritten"), "{message}");
    let robot = Served::start(&temp, TCP);
    let message = run(&robot, "identify").refused();
    assert!(message.contains("has none") && message.contains("leave --key-file"), "{message}");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let path = temp.path("robot.key");
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o644)).unwrap();
        let message = run(&robot, "identify").refused();
        assert!(message.contains("mode 644") && message.contains("chmod 600"), "{message}");
    }
    let message = temp.run("sim --listen tcp:0.0.0.0:0 --for 1s").refused();
    assert!(message.contains("it has no key"), "{message}");
    temp.run("key new robots.key").ok();
    temp.run("sim --listen tcp:0.0.0.0:0 --key-file robots.key --for 200ms").ok();
}

/// Everything that a stranger hears until it is cut off.
fn hear(mut stream: TcpStream) -> Vec<u8> {
    let mut heard = Vec::new();
    let _ = stream.read_to_end(&mut heard);
    heard
}

#[test]
fn a_client_without_the_key_hears_the_hello_and_refusals_and_is_cut_off() {
    let temp = TempFolder::new();
    let robot = with_key(&temp);
    let driver = robot.spawn(&format!("{DRIVE} --key-file robot.key"));
    robot.wait_until_travelled(0.05);
    let mut encoder = Encoder::new();
    let mut said = encoder.hello(Hello::of_this_build(5)).to_vec();
    for command in [Command::Subscribe { period_ms: 5 }, Command::Status, Command::EmergencyStop] {
        let request = Request { session: 5, id: 9, until_ms: 0, command };
        said.extend(encoder.message(&request).iter());
    }
    said.extend(commands());
    let first = Hello { protocol: 1, schema: SCHEMA_HASH ^ 9, session: 6 };
    let older = [encoder.hello(first).to_vec(), commands()].concat();
    for greeting in [said, older] {
        let begin = Instant::now();
        let mut stranger = connect(&robot);
        stranger.write_all(&greeting).expect("it listens");
        let heard = hear(stranger);
        assert!(begin.elapsed() < Duration::from_secs(8), "it is cut off");
        let mut decoder = Decoder::new();
        let mut hellos = 0;
        for byte in heard {
            let Some(frame) = decoder.push(byte) else { continue };
            let frame = frame.expect("whole frames");
            match frame.channel {
                Channel::Hello => hellos += 1,
                Channel::Reply => {
                    let reply: Reply = frame.message().expect("a reply");
                    assert_eq!((reply.id, reply.outcome), (0, Err(Refusal::Key)));
                }
                channel => panic!("a stranger hears {channel:?}"),
            }
        }
        assert_eq!(hellos, 1);
    }
    let outcome = collect(driver).ok();
    assert!(outcome.stdout.contains("Completed"), "{outcome:#?}");
}

#[test]
fn many_strangers_that_flood_the_port_keep_nobody_from_stopping_the_robot() {
    let temp = TempFolder::new();
    let robot = with_key(&temp);
    let driver = robot.spawn(&format!("{DRIVE} --key-file robot.key"));
    robot.wait_until_travelled(0.05);
    // More than there is room for, each saying hello and forged requests without end.
    let strangers: Vec<_> = (0..40_u32)
        .map(|number| {
            let mut stream = connect(&robot);
            let address = stream.peer_addr().expect("it is connected");
            std::thread::spawn(move || {
                let mut encoder = Encoder::new();
                let hello = Hello::of_this_build(1000 + number);
                let end = Instant::now() + Duration::from_secs(6);
                while Instant::now() < end {
                    let said = [encoder.hello(hello).to_vec(), commands()].concat();
                    // Whoever is cut off comes back.
                    if stream.write_all(&said).is_err() {
                        let Ok(again) = TcpStream::connect(address) else { return };
                        stream = again;
                    }
                    std::thread::sleep(Duration::from_millis(2));
                }
            })
        })
        .collect();
    run(&robot, "stop --now").ok();
    let outcome = collect(driver);
    assert!(
        outcome.stdout.contains("emergency_stop") || outcome.stderr.contains("emergency"),
        "{outcome:#?}"
    );
    strangers.into_iter().for_each(|stranger| drop(stranger.join()));
    assert_eq!(run(&robot, "identify --json").ok().json()["status"]["state"], "faulted");
}
