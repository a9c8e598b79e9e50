//! Ports without a Beeline robot: one clear error each.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

use shared_proto::{Channel, Decoder, Encoder, Hello, PROTOCOL_VERSION};

use crate::temp_folder::TempFolder;

/// A server in the place of a robot; `behave` serves each client.
fn impostor(behave: impl Fn(TcpStream) + Send + 'static) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("tcp:{}", listener.local_addr().unwrap());
    std::thread::spawn(move || listener.incoming().flatten().for_each(&behave));
    address
}

/// A robot that answers a hello with another one, and nothing else.
fn foreign_robot(theirs: impl Fn(Hello) -> Hello + Send + 'static) -> String {
    impostor(move |mut stream| {
        let (mut decoder, mut encoder) = (Decoder::new(), Encoder::new());
        let mut byte = [0];
        while matches!(stream.read(&mut byte), Ok(1)) {
            let Some(Ok(frame)) = decoder.push(byte[0]) else { continue };
            if frame.channel == Channel::Hello
                && let Some(hello) = frame.hello()
            {
                let _ = stream.write_all(&encoder.hello(theirs(hello)));
            }
        }
    })
}

#[test]
fn a_port_that_is_none_is_refused() {
    let temp = TempFolder::new();
    temp.write("file", "not a device");
    for (port, expected) in [
        ("/dev/no-such-device", "/dev/no-such-device"),
        ("file", "file"),
        ("/tmp", "/tmp"),
        ("/dev/ttyACM0@fast", "`fast` is not a baud rate"),
        ("/dev/ttyACM0@9600", "too slow to keep a motion alive: at least 38400"),
        ("@115200", "missing"),
        ("tcp:somewhere", "tcp:HOST:PORT"),
        ("tcp:127.0.0.1:99999", "tcp:HOST:PORT"),
        ("tcp::7700", "tcp:HOST:PORT"),
        // Port 1 of this computer: nobody listens there.
        ("tcp:127.0.0.1:1", "cannot connect to tcp:127.0.0.1:1"),
        ("tcp:no-such-host.invalid:7700", "cannot connect"),
        ("sim:", "scenario"),
        ("sim:nowhere.toml", "nowhere.toml"),
    ] {
        let message = temp.run(&format!("identify --port {port}")).refused();
        assert!(message.contains(expected), "{port}: {message}");
    }
}

#[test]
fn a_port_that_is_none_costs_no_picture_and_no_campaign() {
    let temp = TempFolder::new();
    for command in ["calibrate --yes", "record robot straight 1rev", "config export robot.toml"] {
        temp.run(&format!("{command} --port tcp:127.0.0.1:1")).refused();
    }
    assert_eq!(temp.listing(), [""; 0]);
}

#[test]
fn another_protocol_version_is_refused_with_both_versions_named() {
    let newer = PROTOCOL_VERSION + 1;
    let port = foreign_robot(move |hello| Hello { protocol: newer, ..hello });
    let message = TempFolder::new().run(&format!("identify --port {port}")).refused();
    assert!(message.contains(&format!("the robot speaks protocol {newer}")), "{message}");
    assert!(
        message.contains(&format!("this host speaks protocol {PROTOCOL_VERSION}")),
        "{message}"
    );
    assert!(message.contains("update beeline"), "{message}");

    let port = foreign_robot(move |hello| Hello { protocol: 0, ..hello });
    let message = TempFolder::new().run(&format!("calibrate --yes --port {port}")).refused();
    assert!(message.contains("the robot speaks protocol 0"), "{message}");
    assert!(message.contains("flash the robot"), "{message}");
}

#[test]
fn another_layout_of_the_same_version_is_refused_with_both_named() {
    let port = foreign_robot(|hello| Hello { schema: 0xdead_beef, ..hello });
    let message = TempFolder::new().run(&format!("identify --port {port}")).refused();
    assert!(message.contains("schema 00000000deadbeef"), "{message}");
    assert!(message.contains(&format!("schema {:016x}", shared_proto::SCHEMA_HASH)), "{message}");
}

#[test]
fn noise_on_the_port_ends_in_one_error() {
    let port = impostor(|mut stream| {
        // xorshift: any bytes will do, zeros among them, for as long as the client listens.
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut noise = [0; 4096];
        loop {
            for byte in &mut noise {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                *byte = state as u8;
            }
            if stream.write_all(&noise).is_err() {
                return;
            }
        }
    });
    let message = TempFolder::new().run(&format!("identify --port {port}")).refused();
    assert!(message.contains("not as a Beeline robot"), "{message}");
}

#[test]
fn a_console_that_chatters_is_told_from_a_robot() {
    let port = impostor(|mut stream| while stream.write_all(b"login: \r\n\0").is_ok() {});
    let message = TempFolder::new().run(&format!("identify --port {port}")).refused();
    assert!(message.contains("not as a Beeline robot"), "{message}");
}

#[test]
fn silence_on_the_port_ends_in_one_error() {
    let port = impostor(|mut stream| {
        let _ = stream.read_to_end(&mut Vec::new());
    });
    let message = TempFolder::new().run(&format!("identify --port {port}")).refused();
    assert!(message.contains("no robot answers"), "{message}");
}

#[test]
fn an_echo_on_the_port_is_no_robot() {
    let port = impostor(|stream| {
        let _ = std::io::copy(&mut &stream, &mut &stream);
    });
    TempFolder::new().run(&format!("identify --port {port}")).refused();
}

#[test]
fn a_port_that_hangs_up_ends_in_one_error() {
    let port = impostor(drop);
    let message = TempFolder::new().run(&format!("identify --port {port}")).refused();
    assert!(message.contains(&port), "{message}");
}
