//! One serial port for many hosts: whoever owns it passes on what the robot says, and takes what hosts send in turns.
//!
//! A serial port belongs to one process. The owner announces where it listens in a file of the user's own, so that other
//! programs find it by the port's name: [`connect`](crate::address::connect) does.

use std::cell::RefCell;
use std::io::{self, Read, Write};
use std::time::Duration;

use crate::announcement::{Announcement, owner_of};
use crate::cancel::Cancel;
use crate::error::{Error, Result};
use crate::listen::{ClientEvent, Line};

/// How long the port waits for bytes before hosts are looked at.
const TURN: Duration = Duration::from_millis(1);

/// So many bytes wait for the port at most, a frame more: 11 ms at the usual rate. What has to wait longer waits at its host, and ages.
const WAITING_MAX: usize = 1024;

/// Whether another program owns this serial port and shares it.
pub fn is_shared(path: &str) -> bool {
    owner_of(path).is_some()
}

/// A serial port that is shared, announced until this value is dropped.
pub struct SharedPort {
    port: Box<dyn serialport::SerialPort>,
    path: String,
    /// For the robot, and not written yet.
    waiting: Vec<u8>,
    _announced: Option<Announcement>,
}

impl SharedPort {
    /// Opens the port and announces that hosts reach it at the line's address.
    pub fn open(path: &str, baud: u32, line: &Line) -> Result<Self> {
        let failed = |cause| Error::OpenSerial { path: path.into(), cause };
        let port = serialport::new(path, baud).timeout(TURN).open().map_err(failed)?;
        // Without it, nobody finds this owner by the port's name; the line's address serves all the same.
        let announced = Announcement::new(path, line.address());
        Ok(Self { port, path: path.into(), waiting: Vec::new(), _announced: announced })
    }

    /// Passes bytes on, both ways, until `cancel` is requested or the port is gone.
    pub fn pass_on(
        &mut self,
        line: &mut Line,
        cancel: &Cancel,
        tell: &mut dyn FnMut(ClientEvent),
    ) -> Result<()> {
        while !cancel.is_requested() {
            let turned = self.turn(line, tell);
            turned.map_err(|cause| Error::ConnectionLost { port: self.path.clone(), cause })?;
        }
        Ok(())
    }

    /// What has come from the robot to the hosts, and from them to the robot as much as the port takes.
    fn turn(&mut self, line: &mut Line, tell: &mut dyn FnMut(ClientEvent)) -> io::Result<()> {
        let mut buffer = [0; 1024];
        match self.port.read(&mut buffer) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            // Nothing, too: what a host did not take before may go out now.
            Ok(len) => line.write(&buffer[..len], tell),
            Err(error) if is_pause(&error) => line.write(&[], tell),
            Err(error) => return Err(error),
        }
        // Not every system tells.
        let queued = self.port.bytes_to_write().map_or(0, |bytes| bytes as usize);
        take(line, &mut self.waiting, queued, tell);
        write(&mut self.port, &mut self.waiting)
    }
}

/// Takes from the hosts what there is room for behind what waits and what the system has queued.
fn take(line: &mut Line, waiting: &mut Vec<u8>, queued: usize, tell: &mut dyn FnMut(ClientEvent)) {
    let waiting = RefCell::new(waiting);
    let room = || queued + waiting.borrow().len() < WAITING_MAX;
    line.pass_on(&room, &mut |bytes| waiting.borrow_mut().extend_from_slice(bytes), tell);
}

/// Writes as much as the port takes. That it takes no more now, as when hosts send faster than the line, is no end of the line.
fn write(port: &mut impl Write, waiting: &mut Vec<u8>) -> io::Result<()> {
    if waiting.is_empty() {
        return Ok(());
    }
    match port.write(waiting) {
        Ok(0) => Err(io::ErrorKind::WriteZero.into()),
        Ok(len) => {
            waiting.drain(..len);
            Ok(())
        }
        Err(error) if is_pause(&error) => Ok(()),
        Err(error) => Err(error),
    }
}

fn is_pause(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), TimedOut | Interrupted | WouldBlock)
}

#[cfg(test)]
mod tests {
    use std::net::TcpStream;

    use shared_proto::{Command, Encoder, FRAME_LEN_MAX, Hello, Request};

    use super::*;
    use crate::listen::Listen;

    /// A port that takes so many bytes, and then no more.
    struct Port(usize);

    impl Write for Port {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let len = bytes.len().min(self.0);
            self.0 -= len;
            if len > 0 { Ok(len) } else { Err(io::ErrorKind::TimedOut.into()) }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn hosts_that_send_faster_than_the_line_wait_and_cut_nobody_off() {
        let mut line = Line::open(&Listen::Tcp("127.0.0.1:0".into())).unwrap();
        let mut host = TcpStream::connect(&line.address()["tcp:".len()..]).unwrap();
        host.set_nonblocking(true).unwrap();
        let mut encoder = Encoder::new();
        host.write_all(&encoder.hello(Hello::of_this_build(1))).unwrap();
        let request = Request { session: 1, id: 1, until_ms: 0, command: Command::Status };
        let flood = encoder.message(&request).repeat(50);
        let (mut port, mut waiting, mut had_to_wait) = (Port(100), Vec::new(), 0);
        while had_to_wait < 20 {
            match host.write(&flood) {
                Ok(_) => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => had_to_wait += 1,
                Err(error) => panic!("the host was cut off: {error}"),
            }
            take(&mut line, &mut waiting, 0, &mut |_| ());
            write(&mut port, &mut waiting).expect("the port is there");
            assert!(waiting.len() < WAITING_MAX + FRAME_LEN_MAX, "{}", waiting.len());
        }
        assert_eq!(port.0, 0);
        let before = waiting.clone();
        port.0 = 7;
        write(&mut port, &mut waiting).unwrap();
        assert_eq!(waiting, before[7..], "what was not taken goes out next, and nothing twice");
        waiting.clear();
        take(&mut line, &mut waiting, WAITING_MAX, &mut |_| ());
        assert!(waiting.is_empty(), "what the system has queued counts");
    }
}
