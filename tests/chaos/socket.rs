//! The server's end of a connection, without a network: it never blocks, and is bounded as the systems' own are.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::rc::Rc;

/// What the operating systems hold for a connection each way \[bytes\].
pub const SOCKET: usize = 64 * 1024;

/// The server's end of a connection.
#[derive(Clone, Default)]
pub struct Socket(pub Rc<RefCell<Buffers>>);

/// What has arrived at the server, and what waits for the host.
#[derive(Default)]
pub struct Buffers {
    pub in_: VecDeque<u8>,
    pub out: VecDeque<u8>,
    pub ended: bool,
    /// A planted fault: it takes everything and passes nothing on.
    pub hoards: bool,
}

impl Read for Socket {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let Buffers { in_, ended, .. } = &mut *self.0.borrow_mut();
        if in_.is_empty() {
            return if *ended { Ok(0) } else { Err(ErrorKind::WouldBlock.into()) };
        }
        in_.read(buffer)
    }
}

impl Write for Socket {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let Buffers { out, ended, hoards, .. } = &mut *self.0.borrow_mut();
        match SOCKET.saturating_sub(out.len()) {
            _ if *ended => Err(ErrorKind::BrokenPipe.into()),
            0 if !*hoards => Err(ErrorKind::WouldBlock.into()),
            room => {
                let len = if *hoards { bytes.len() } else { bytes.len().min(room) };
                out.extend(&bytes[..len]);
                Ok(len)
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
