//! Where a robot is reached: a serial port or a TCP address.
//!
//! What is said over the connection is left to [`crate::session`].

use std::fmt;
use std::io;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::str::FromStr;
use std::time::Duration;

use crate::announcement::owner_of;
use crate::clock::Clock;
use crate::error::{Error, Result};
use crate::session::Session;
use crate::wire::ThreadedWire;

/// The link's speed on a serial port unless the address says otherwise (`/dev/ttyACM0@115200`).
pub const BAUD: u32 = 921_600;

/// The slowest line that carries the renewals of a motion beside its telemetry. Simulated robots drive and calibrate from
/// 28800 baud upwards; at 19200 calibrations succeed, and drives, with their telemetry, end with `time_to_live`.
pub const BAUD_MIN: u32 = 38_400;

/// Where a robot is reached.
#[derive(Clone, Debug, PartialEq)]
pub enum Address {
    /// `tcp:host:port`.
    Tcp(String),
    /// `/dev/ttyACM0`, `COM3`, with `@baud` if it is not [`BAUD`].
    Serial {
        /// The device.
        path: String,
        /// Bits per second.
        baud: u32,
    },
}

/// Why a text is not an address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AddressError {
    /// It begins with `tcp:`, but is not `tcp:HOST:PORT`.
    NotTcp(String),
    /// The text after the `@` is not a baud rate.
    NotABaudRate(String),
    /// Below [`BAUD_MIN`].
    TooSlow(u32),
    /// There is no device before the `@`.
    NoDevice,
}

impl std::error::Error for AddressError {}

impl fmt::Display for AddressError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotTcp(text) => {
                write!(f, "`{text}` must read tcp:HOST:PORT, for example tcp:127.0.0.1:7700")
            }
            Self::NotABaudRate(text) => write!(f, "`{text}` is not a baud rate"),
            Self::TooSlow(baud) => {
                write!(f, "{baud} baud is too slow to keep a motion alive: at least {BAUD_MIN}")
            }
            Self::NoDevice => f.write_str("the name of a serial device is missing"),
        }
    }
}

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(text: &str) -> std::result::Result<Self, AddressError> {
        if let Some(address) = text.strip_prefix("tcp:") {
            return match address.rsplit_once(':') {
                Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => {
                    Ok(Self::Tcp(address.into()))
                }
                _ => Err(AddressError::NotTcp(text.into())),
            };
        }
        let (path, baud) = match text.rsplit_once('@') {
            Some((path, baud)) => {
                let baud = baud.parse().map_err(|_| AddressError::NotABaudRate(baud.into()))?;
                if baud < BAUD_MIN {
                    return Err(AddressError::TooSlow(baud));
                }
                (path, baud)
            }
            None => (text, BAUD),
        };
        if path.is_empty() {
            return Err(AddressError::NoDevice);
        }
        Ok(Self::Serial { path: path.into(), baud })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Serial { path, baud: BAUD } => f.write_str(path),
            Self::Serial { path, baud } => write!(f, "{path}@{baud}"),
        }
    }
}

/// A session with the robot at this address, in real time; not opened yet.
pub fn connect(address: &Address) -> Result<Session> {
    let wire = open(address)?;
    Ok(Session::new(wire, Clock::real(), session_number(), address.to_string()))
}

/// A session number that very probably differs from that of the last session.
fn session_number() -> u32 {
    let now =
        std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    (now.as_micros() as u32).rotate_left(7) ^ std::process::id()
}

fn over(stream: TcpStream) -> io::Result<ThreadedWire> {
    // Renewals are small and must not wait for more bytes.
    stream.set_nodelay(true)?;
    let reader = stream.try_clone()?;
    Ok(ThreadedWire::new(reader, stream))
}

fn open(address: &Address) -> Result<ThreadedWire> {
    match address {
        Address::Tcp(address) => {
            let failed = |cause| Error::Connect { address: address.clone(), cause };
            let resolved = address.to_socket_addrs().map_err(failed)?;
            let stream = connect_any(resolved).map_err(failed)?;
            over(stream).map_err(failed)
        }
        Address::Serial { path, baud } => {
            // A program that has the port may share it.
            if let Some(stream) = owner_of(path) {
                return over(stream)
                    .map_err(|cause| Error::Connect { address: path.clone(), cause });
            }
            let failed = |cause| Error::OpenSerial { path: path.clone(), cause };
            let writer = serialport::new(path, *baud)
                .timeout(Duration::from_millis(100))
                .open()
                .map_err(failed)?;
            let reader = writer.try_clone().map_err(failed)?;
            Ok(ThreadedWire::new(reader, writer))
        }
    }
}

/// Connects to the first address that answers: `localhost` has an IPv6 and an IPv4 address.
fn connect_any(addresses: impl Iterator<Item = SocketAddr>) -> io::Result<TcpStream> {
    let mut failure = io::Error::new(io::ErrorKind::NotFound, "no such host");
    for address in addresses {
        match TcpStream::connect_timeout(&address, Duration::from_secs(3)) {
            Ok(stream) => return Ok(stream),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, TcpListener};

    use super::*;

    #[test]
    fn a_host_that_answers_on_its_second_address_is_reached() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let there = listener.local_addr().unwrap();
        // Nobody listens on port 1.
        let nobody = SocketAddr::from((Ipv4Addr::LOCALHOST, 1));
        assert_eq!(connect_any([nobody, there].into_iter()).unwrap().peer_addr().unwrap(), there);
        assert!(connect_any([nobody].into_iter()).is_err());
        assert!(connect_any([].into_iter()).unwrap_err().to_string().contains("no such host"));
    }
}
