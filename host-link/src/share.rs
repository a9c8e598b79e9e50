//! One serial port for many hosts: whoever owns it passes on what the robot says, and takes what hosts send in turns.
//!
//! A serial port belongs to one process. The owner announces where it listens in a file of the user's own, so that other
//! programs find it by the port's name: [`connect`](crate::address::connect) does.

use std::io::{self, Read, Write};
use std::time::Duration;

use crate::announcement::{Announcement, owner_of};
use crate::cancel::Cancel;
use crate::error::{Error, Result};
use crate::listen::{ClientEvent, Line};

/// How long the port waits for bytes before hosts are looked at.
const TURN: Duration = Duration::from_millis(1);

/// Whether another program owns this serial port and shares it.
pub fn is_shared(path: &str) -> bool {
    owner_of(path).is_some()
}

/// A serial port that is shared, announced until this value is dropped.
pub struct SharedPort {
    port: Box<dyn serialport::SerialPort>,
    path: String,
    _announced: Option<Announcement>,
}

impl SharedPort {
    /// Opens the port and announces that hosts reach it at the line's address.
    pub fn open(path: &str, baud: u32, line: &Line) -> Result<Self> {
        let failed = |cause| Error::OpenSerial { path: path.into(), cause };
        let port = serialport::new(path, baud).timeout(TURN).open().map_err(failed)?;
        // Without it, nobody finds this owner by the port's name; the line's address serves all the same.
        let announced = Announcement::new(path, line.address());
        Ok(Self { port, path: path.into(), _announced: announced })
    }

    /// Passes bytes on, both ways, until `cancel` is requested or the port is gone.
    pub fn pass_on(
        &mut self,
        line: &mut Line,
        cancel: &Cancel,
        tell: &mut dyn FnMut(ClientEvent),
    ) -> Result<()> {
        let lost = |path: &str, cause| Error::ConnectionLost { port: path.to_owned(), cause };
        let mut buffer = [0; 1024];
        while !cancel.is_requested() {
            match self.port.read(&mut buffer) {
                Ok(0) => return Err(lost(&self.path, io::ErrorKind::UnexpectedEof.into())),
                Ok(len) => line.write(&buffer[..len], tell),
                Err(error)
                    if matches!(
                        error.kind(),
                        io::ErrorKind::TimedOut | io::ErrorKind::Interrupted
                    ) => {}
                Err(error) => return Err(lost(&self.path, error)),
            }
            let mut to_robot = Vec::new();
            line.pass_on(&|| true, &mut |bytes| to_robot.extend_from_slice(bytes), tell);
            if !to_robot.is_empty() {
                self.port.write_all(&to_robot).map_err(|error| lost(&self.path, error))?;
            }
        }
        Ok(())
    }
}
