//! The robot's end of a link, on TCP or a pseudo-terminal.
//!
//! On TCP several clients share the robot's line. Whole frames of theirs take turns on it, and what the robot says goes
//! to all whom it has let in; requests and replies carry their session. Nothing is read from a client for which
//! the line has no room, so whatever waits does so at the client, and ages: a lease tells the robot what is late.
//!
//! The robot lets in hosts that have its key, or everybody if it has none. The server needs no key: it reads from the
//! robot's answers which clients are let in. Any other client hears only the answers to its own attempts, and nothing but
//! these attempts is passed on to the robot.

mod client;
mod client_log;
mod from_robot;
mod hub;

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::str::FromStr;
use std::time::{Duration, Instant};

use crate::address::Address;
use crate::error::{Error, Result};

pub use self::client::ClientEvent;
pub use self::client_log::ClientLog;
pub use self::hub::Hub;

/// Where a robot listens for a host.
#[derive(Clone, Debug, PartialEq)]
pub enum Listen {
    /// A TCP address.
    Tcp(String),
    /// A new pseudo-terminal.
    Pty,
}

impl FromStr for Listen {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text.parse() {
            Ok(Address::Tcp(address)) => Ok(Listen::Tcp(address)),
            _ if text == "pty" => Ok(Listen::Pty),
            _ => Err("must be tcp:HOST:PORT or pty".into()),
        }
    }
}

impl Listen {
    /// Whether only programs on this machine reach it.
    pub fn is_local(&self) -> bool {
        match self {
            Listen::Pty => true,
            Listen::Tcp(address) => match address.parse::<SocketAddr>() {
                Ok(address) => address.ip().is_loopback(),
                Err(_) => address.rsplit_once(':').is_some_and(|(host, _)| host == "localhost"),
            },
        }
    }
}

/// The robot's end of a line. No method blocks.
pub struct Line {
    address: String,
    end: End,
}

enum End {
    Tcp {
        listener: TcpListener,
        hub: Box<Hub<TcpStream>>,
        began: Instant,
    },
    #[cfg(unix)]
    Pty {
        master: serialport::TTYPort,
        // Held open, so that the terminal stays when a client leaves.
        _slave: serialport::TTYPort,
    },
}

impl Line {
    /// Opens the robot's end.
    pub fn open(listen: &Listen) -> Result<Self> {
        match listen {
            Listen::Tcp(address) => {
                let failed = |cause| Error::Listen { address: address.clone(), cause };
                let listener = TcpListener::bind(address).map_err(failed)?;
                listener.set_nonblocking(true).map_err(failed)?;
                let bound = listener.local_addr().map_err(failed)?;
                Ok(Self {
                    address: format!("tcp:{bound}"),
                    end: End::Tcp { listener, hub: Box::default(), began: Instant::now() },
                })
            }
            #[cfg(unix)]
            Listen::Pty => {
                use serialport::SerialPort;
                let (mut master, slave) =
                    serialport::TTYPort::pair().map_err(Error::PseudoTerminal)?;
                master.set_timeout(Duration::from_millis(1)).map_err(Error::PseudoTerminal)?;
                let address = slave.name().unwrap_or_default();
                Ok(Self { address, end: End::Pty { master, _slave: slave } })
            }
            #[cfg(not(unix))]
            Listen::Pty => Err(Error::NoPseudoTerminals),
        }
    }

    /// The port by which a host reaches the robot.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Accepts clients, and passes on to the robot what they have sent, while `room` says that the line takes more bytes.
    pub fn pass_on(
        &mut self,
        room: &dyn Fn() -> bool,
        to_robot: &mut dyn FnMut(&[u8]),
        tell: &mut dyn FnMut(ClientEvent),
    ) {
        match &mut self.end {
            End::Tcp { listener, hub, began } => {
                while hub.has_place(began.elapsed())
                    && let Ok((stream, _)) = listener.accept()
                {
                    // Unless it is gone already.
                    if stream.set_nonblocking(true).and(stream.set_nodelay(true)).is_ok() {
                        hub.join(stream, began.elapsed(), tell);
                    }
                }
                hub.pass_on(began.elapsed(), room, to_robot, tell);
            }
            #[cfg(unix)]
            End::Pty { master, .. } => {
                use serialport::SerialPort;
                use std::io::Read;
                let mut buffer = [0; 64];
                while room()
                    && master.bytes_to_read().is_ok_and(|waiting| waiting > 0)
                    && let Ok(len @ 1..) = master.read(&mut buffer)
                {
                    to_robot(&buffer[..len]);
                }
            }
        }
    }

    /// Sends bytes to the clients that the robot has let in, and to others what is for them; without any client they
    /// are lost, as on a cable.
    pub fn write(&mut self, bytes: &[u8], tell: &mut dyn FnMut(ClientEvent)) {
        match &mut self.end {
            End::Tcp { hub, began, .. } => hub.write(bytes, began.elapsed(), tell),
            #[cfg(unix)]
            End::Pty { master, .. } => {
                use std::io::Write;
                // The terminal's buffer is full: nobody reads.
                let _ = master.write_all(bytes);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};

    use shared_proto::{Command, Encoder, Hello, Request};

    use super::*;

    /// A line, and what it passes on and tells.
    struct Bench {
        line: Line,
        to_robot: Vec<Vec<u8>>,
        news: Vec<ClientEvent>,
    }

    impl Bench {
        fn new() -> Self {
            let line = Line::open(&Listen::Tcp("127.0.0.1:0".into())).unwrap();
            Self { line, to_robot: Vec::new(), news: Vec::new() }
        }

        /// A client that has said hello.
        fn client(&mut self, session: u32) -> TcpStream {
            let mut client = TcpStream::connect(&self.line.address()["tcp:".len()..]).unwrap();
            client.write_all(&Encoder::new().hello(Hello::of_this_build(session))).unwrap();
            let known = self.count(ClientEvent::Connected);
            while self.count(ClientEvent::Connected) == known {
                self.pass_on(usize::MAX);
            }
            // The robot has no key.
            let Self { line, news, .. } = self;
            let hello = Encoder::new().hello(Hello::of_this_build(session));
            line.write(&hello, &mut |told| news.push(told));
            let mut heard = vec![0; hello.len()];
            client.read_exact(&mut heard).unwrap();
            assert_eq!(heard, *hello);
            client
        }

        fn count(&self, what: ClientEvent) -> usize {
            self.news.iter().filter(|news| **news == what).count()
        }

        /// Passes on frames until this many have been.
        fn pass_on(&mut self, frames: usize) {
            let Self { line, to_robot, news } = self;
            let passed = std::cell::Cell::new(0);
            let mut take = |bytes: &[u8]| {
                passed.set(passed.get() + 1);
                to_robot.push(bytes.to_vec());
            };
            line.pass_on(&|| passed.get() < frames, &mut take, &mut |told| news.push(told));
        }
    }

    #[test]
    fn a_client_that_does_not_read_is_cut_off_and_holds_nobody_up() {
        /// More than the system holds for a connection.
        const CHUNKS_MAX: usize = 64 * 1024;
        let mut bench = Bench::new();
        let _silent = bench.client(1);
        let mut reader = bench.client(2);
        reader.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let (mut chunks, mut heard) = (0, [0; 1024]);
        while bench.count(ClientEvent::NotReading) == 0 && chunks < CHUNKS_MAX {
            chunks += 1;
            let Bench { line, news, .. } = &mut bench;
            // What is no frame is passed on as well, at the zero that ends it.
            let mut said = [chunks as u8; 1024];
            said[1023] = 0;
            line.write(&said, &mut |told| news.push(told));
            reader.read_exact(&mut heard).expect("nobody holds this one up");
            assert_eq!(heard, said);
        }
        assert_eq!(
            (bench.count(ClientEvent::NotReading), bench.count(ClientEvent::Disconnected)),
            (1, 0)
        );
    }

    #[test]
    fn frames_of_two_clients_take_turns_however_many_one_of_them_sends() {
        let mut bench = Bench::new();
        let (mut flood, mut other) = (bench.client(1), bench.client(2));
        bench.pass_on(usize::MAX);
        let frame = |session: u32, command| {
            let request = Request { session, id: 1, until_ms: 0, command };
            Encoder::new().message(&request).to_vec()
        };
        flood.write_all(&frame(1, Command::Status).repeat(100)).unwrap();
        other.write_all(&frame(2, Command::EmergencyStop)).unwrap();
        std::thread::sleep(Duration::from_millis(50));
        bench.to_robot.clear();
        bench.pass_on(4);
        let sessions: Vec<u32> = bench
            .to_robot
            .iter()
            .map(|bytes| {
                let mut decoder = shared_proto::Decoder::new();
                let mut session = 0;
                for &byte in bytes {
                    if let Some(Ok(frame)) = decoder.push(byte) {
                        session = frame.message::<Request>().unwrap().session;
                    }
                }
                session
            })
            .collect();
        assert!(sessions.len() <= 5 && sessions[..2].contains(&2), "{sessions:?}");
    }

    #[test]
    fn only_this_machine_reaches_a_loopback_address_and_a_terminal() {
        for (text, local) in [
            ("tcp:127.0.0.1:7700", true),
            ("tcp:127.9.9.9:0", true),
            ("tcp:[::1]:7700", true),
            ("tcp:localhost:7700", true),
            ("pty", true),
            ("tcp:0.0.0.0:7700", false),
            ("tcp:[::]:7700", false),
            ("tcp:192.168.1.7:7700", false),
            ("tcp:robot.example:7700", false),
            ("tcp:localhost.example:7700", false),
        ] {
            assert_eq!(text.parse::<Listen>().map(|listen| listen.is_local()), Ok(local), "{text}");
        }
    }
}
