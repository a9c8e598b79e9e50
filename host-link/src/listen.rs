//! The robot's end of a link: one client at a time, as on a cable, on TCP or a pseudo-terminal.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::str::FromStr;
use std::time::{Duration, Instant};

use crate::address::Address;
use crate::error::{Error, Result};

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

/// The robot's end of a line, with one client at a time. No method blocks, except while a client is
/// slow to read.
pub struct Line {
    address: String,
    end: End,
}

enum End {
    Tcp {
        listener: TcpListener,
        client: Option<TcpStream>,
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
                    end: End::Tcp { listener, client: None },
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

    /// Accepts a new client, which replaces the one before; true if there was one.
    pub fn accept(&mut self) -> bool {
        match &mut self.end {
            End::Tcp { listener, client } => match listener.accept() {
                Ok((stream, _)) => {
                    if stream.set_nonblocking(true).is_err() || stream.set_nodelay(true).is_err() {
                        return false;
                    }
                    *client = Some(stream);
                    true
                }
                Err(_) => false,
            },
            #[cfg(unix)]
            End::Pty { .. } => false,
        }
    }

    /// Bytes from the client, if there are any now; one error when the client has disconnected.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match &mut self.end {
            End::Tcp { client, .. } => {
                let Some(stream) = client else { return Ok(0) };
                let gone = match stream.read(buffer) {
                    Ok(0) => ErrorKind::UnexpectedEof.into(),
                    Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(0),
                    Err(error) => error,
                    Ok(len) => return Ok(len),
                };
                *client = None;
                Err(gone)
            }
            #[cfg(unix)]
            End::Pty { master, .. } => {
                use serialport::SerialPort;
                match master.bytes_to_read() {
                    Ok(0) | Err(_) => Ok(0),
                    Ok(_) => Ok(master.read(buffer).unwrap_or(0)),
                }
            }
        }
    }

    /// Sends bytes to the client; without a client they are lost, as on a cable.
    pub fn write(&mut self, bytes: &[u8]) {
        match &mut self.end {
            End::Tcp { client, .. } => {
                if let Some(stream) = client
                    && write_all_patiently(stream, bytes).is_err()
                {
                    *client = None;
                }
            }
            #[cfg(unix)]
            End::Pty { master, .. } => {
                // The terminal's buffer is full: nobody reads.
                let _ = master.write_all(bytes);
            }
        }
    }
}

/// Writes to a non-blocking socket; gives up on a client that does not read for a second.
fn write_all_patiently(stream: &mut TcpStream, mut bytes: &[u8]) -> io::Result<()> {
    const TRY_EVERY: Duration = Duration::from_millis(1);
    let give_up = Instant::now() + Duration::from_secs(1);
    while !bytes.is_empty() {
        match stream.write(bytes) {
            Ok(len) => bytes = &bytes[len..],
            Err(error) if error.kind() == ErrorKind::WouldBlock && Instant::now() < give_up => {
                std::thread::sleep(TRY_EVERY);
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
