//! The handshake: two ends that do not understand each other disconnect at once, and say why.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

use beeline_tests::robot::on_robot;
use host_cli::port::{Port, SimOptions, with_robot};
use host_link::Error;
use shared_proto::{
    Answer, Channel, Command, Decoder, Encoder, Hello, PROTOCOL_VERSION, Refusal, Reply, Request,
    SCHEMA_HASH, State,
};
use sim_target::{HostWire, Options, Scenario, SimTarget};

/// What a robot says within 20 ms.
struct Heard {
    hello: Option<Hello>,
    replies: Vec<Reply>,
}

fn hear(target: &mut SimTarget, wire: &HostWire, decoder: &mut Decoder) -> Heard {
    let mut heard = Heard { hello: None, replies: Vec::new() };
    target.run_until_us(sim_target::now_us() + 20_000);
    let mut buffer = [0; 256];
    loop {
        let len = wire.read_now(&mut buffer);
        if len == 0 {
            return heard;
        }
        for &byte in &buffer[..len] {
            let Some(frame) = decoder.push(byte) else { continue };
            let frame = frame.expect("a clean line");
            match frame.channel {
                Channel::Hello => heard.hello = frame.hello(),
                Channel::Reply => heard.replies.extend(frame.message::<Reply>()),
                _ => {}
            }
        }
    }
}

#[test]
fn a_robot_refuses_requests_until_a_hello_of_its_own_version() {
    let mut target = SimTarget::new(&Scenario::default(), Options::default()).expect("no file");
    let wire = target.host_wire();
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    let ours = Hello::of_this_build(11);
    let request =
        Request { session: 11, id: 5, until_ms: 5000, command: Command::Arm { take: false } };
    let hellos = [
        ("none", None, false),
        ("of another protocol", Some(Hello { protocol: PROTOCOL_VERSION + 1, ..ours }), false),
        ("of another schema", Some(Hello { schema: SCHEMA_HASH ^ 1, ..ours }), false),
        ("of ours", Some(ours), true),
        ("of another protocol again", Some(Hello { protocol: 0, ..ours }), false),
    ];
    for (name, hello, agreed) in hellos {
        if let Some(hello) = hello {
            wire.write_now(&encoder.hello(hello));
            // Whatever version the host has, the robot reports its own.
            let answer = hear(&mut target, &wire, &mut decoder).hello;
            assert_eq!(answer, Some(Hello::of_this_build(11)), "hello {name}");
        }
        wire.write_now(&encoder.message(&request));
        let replies = hear(&mut target, &wire, &mut decoder).replies;
        let expected = match agreed {
            true => (11, 5, Ok(Answer::Done)),
            false => (0, 0, Err(Refusal::HelloFirst)),
        };
        let replies: Vec<_> =
            replies.into_iter().map(|reply| (reply.session, reply.id, reply.outcome)).collect();
        assert_eq!(replies, [expected], "hello {name}");
    }
}

#[test]
fn noise_on_the_line_is_no_request_and_the_next_frame_is_understood() {
    on_robot(&Scenario::default(), async |robot| {
        let mut byte = 1_u8;
        let noise: Vec<u8> = (0..5000)
            .map(|_| {
                byte = byte.wrapping_mul(181).wrapping_add(71);
                byte
            })
            .collect();
        robot.wire.write_now(&noise);
        robot.wire.write_now(&[0]);
        assert_eq!(robot.state().await, State::Idle);
        assert!(robot.session.status().await.expect("it answers").link.frames_damaged > 0);
    });
}

/// A robot on a socket that sends what a test gives it.
struct FakeRobot {
    stream: TcpStream,
    encoder: Encoder,
    decoder: Decoder,
}

/// What a host says.
#[allow(clippy::large_enum_variant, reason = "one lives at a time")]
enum Asked {
    Hello(Hello),
    Request(Request),
}

impl FakeRobot {
    /// Listens on a free port and answers one host in a thread; returns the port.
    fn listen(answer: impl Fn(&mut FakeRobot, Asked) + Send + 'static) -> Port {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = listener.local_addr().expect("bound");
        std::thread::spawn(move || {
            let (stream, _) = listener.accept().expect("a host");
            let mut robot = FakeRobot { stream, encoder: Encoder::new(), decoder: Decoder::new() };
            while let Some(heard) = robot.hear() {
                answer(&mut robot, heard);
            }
        });
        format!("tcp:{address}").parse().expect("a port")
    }

    fn hear(&mut self) -> Option<Asked> {
        let mut byte = [0];
        loop {
            if self.stream.read(&mut byte).ok()? == 0 {
                return None;
            }
            let Some(Ok(frame)) = self.decoder.push(byte[0]) else { continue };
            if let Some(hello) = frame.hello() {
                return Some(Asked::Hello(hello));
            }
            if let Some(request) = frame.message() {
                return Some(Asked::Request(request));
            }
        }
    }

    fn send(&mut self, frame: &[u8]) {
        // A host that has gone away is the test's business, not the robot's.
        let _ = self.stream.write_all(frame);
    }
}

#[test]
fn a_host_refuses_a_robot_of_another_version_and_names_both() {
    let ours = Hello::of_this_build(0);
    let others = [
        (Hello { protocol: PROTOCOL_VERSION + 1, schema: 0xabcd, ..ours }, "update beeline"),
        (Hello { protocol: 0, schema: 0xabcd, ..ours }, "flash the robot"),
        (Hello { schema: 0xabcd, ..ours }, "flash the robot"),
    ];
    for (theirs, hint) in others {
        let port = FakeRobot::listen(move |robot, heard| {
            if let Asked::Hello(hello) = heard {
                let frame = robot.encoder.hello(Hello { session: hello.session, ..theirs });
                robot.send(&frame);
            }
        });
        let error = with_robot(&port, &SimOptions::default(), async |_, _| Ok(()))
            .expect_err("they do not understand each other");
        let message = error.to_string();
        for part in [
            format!("protocol {} (schema 000000000000abcd)", theirs.protocol),
            format!("protocol {PROTOCOL_VERSION} (schema {SCHEMA_HASH:016x})"),
        ] {
            assert!(message.contains(&part), "{message:?} lacks {part:?}");
        }
        assert!(error.hint_text().is_some_and(|text| text.contains(hint)), "{error:?}");
        assert_eq!(error.exit_code(), 2);
    }
}

#[test]
fn a_host_takes_the_reply_to_its_own_question_and_no_other() {
    let port = FakeRobot::listen(|robot, heard| match heard {
        Asked::Hello(hello) => {
            let frame = robot.encoder.hello(Hello::of_this_build(hello.session));
            robot.send(&frame);
        }
        Asked::Request(Request { session, id, .. }) => {
            let t_us = 1_000_000;
            // Late replies to earlier questions, one to a later one, one to another host with the same
            // question, and ours last, twice.
            for (session, id) in
                [(session, id.wrapping_sub(1)), (session, id + 7), (session ^ 1, id)]
            {
                let outcome = Err(Refusal::State(State::Boot));
                let frame = robot.encoder.message(&Reply { session, id, t_us, outcome });
                robot.send(&frame);
            }
            let outcome = Ok(Answer::Done);
            let frame = robot.encoder.message(&Reply { session, id, t_us, outcome });
            robot.send(&frame);
            robot.send(&frame);
        }
    });
    with_robot(&port, &SimOptions::default(), async |session, _| {
        for _ in 0..5 {
            assert_eq!(session.ask(Command::Arm { take: false }).await?, Ok(Answer::Done));
        }
        Ok(())
    })
    .expect("the host is not confused");
}

#[test]
fn a_reboot_in_the_middle_is_noticed() {
    let port = FakeRobot::listen(|robot, heard| match heard {
        Asked::Hello(hello) => {
            let frame = robot.encoder.hello(Hello::of_this_build(hello.session));
            robot.send(&frame);
        }
        Asked::Request(_) => {
            let outcome = Err(Refusal::HelloFirst);
            let reply = Reply { session: 0, id: 0, t_us: 0, outcome };
            let frame = robot.encoder.message(&reply);
            robot.send(&frame);
        }
    });
    let error = with_robot(&port, &SimOptions::default(), async |session, _| {
        Ok(session.ask(Command::Arm { take: false }).await.map(drop)?)
    })
    .expect_err("it restarted");
    assert!(error.to_string().contains("restarted"), "{error}");
}

#[test]
fn a_host_that_others_pushed_out_is_not_told_of_a_restart() {
    on_robot(&Scenario::default(), async |robot| {
        robot.session.status().await.expect("the robot answers");
        let mut first = robot.another_host(2).await;
        // It remembers eight, and forgets who was silent for longest.
        for number in 3..=10 {
            robot.another_host(number).await;
        }
        let error = first.status().await.expect_err("it is forgotten");
        assert!(matches!(error, Error::Forgotten { .. }), "{error}");
        first.open().await.expect("another hello helps");
        first.status().await.expect("the robot answers");
    });
}
