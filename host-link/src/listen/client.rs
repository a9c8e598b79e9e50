//! One client on TCP: its frames to the robot, and the robot's bytes to it.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use shared_proto::{Bound, Channel, Decoder, Encoder, Frame};

use super::News;

/// The first byte of a hello's frame: COBS for a zero at once.
const HELLO_FIRST: u8 = 1;

/// A client that has not said hello by then is none.
const GREETING_MAX: Duration = Duration::from_secs(2);

/// A client may leave this much of what the robot says unread \[bytes\]: two seconds of the quickest line.
const UNREAD_MAX: usize = 256 * 1024;

/// So many bytes of a client are held until the line takes them: a few of the longest frames.
const HELD_MAX: usize = 1024;

/// A client.
pub(super) struct Client {
    stream: TcpStream,
    since: Instant,
    greeted: bool,
    decoder: Decoder,
    /// Received, and not passed on yet.
    held: VecDeque<u8>,
    /// For the client, and not sent yet.
    unsent: VecDeque<u8>,
    /// The stream has ended; what is held is passed on all the same.
    ended: bool,
}

impl Client {
    /// A client that has connected, unless it is gone already.
    pub fn new(stream: TcpStream) -> Option<Self> {
        stream.set_nonblocking(true).ok()?;
        stream.set_nodelay(true).ok()?;
        Some(Self {
            stream,
            since: Instant::now(),
            greeted: false,
            decoder: Decoder::new(),
            held: VecDeque::new(),
            unsent: VecDeque::new(),
            ended: false,
        })
    }

    /// Takes from the network what there is room for; false if the client is to be forgotten.
    pub fn receive(&mut self, tell: &mut dyn FnMut(News)) -> bool {
        if !self.ended && self.held.len() < HELD_MAX {
            let mut buffer = [0; HELD_MAX];
            match self.stream.read(&mut buffer[self.held.len()..]) {
                Ok(0) => self.ended = true,
                Ok(len) => {
                    let from = self.held.len();
                    self.held.extend(&buffer[from..from + len]);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(_) => self.ended = true,
            }
        }
        if !self.greeted {
            match self.greeting() {
                Greeting::None if self.since.elapsed() < GREETING_MAX && !self.ended => {}
                Greeting::Hello => {
                    self.greeted = true;
                    tell(News::Connected);
                }
                // Whoever connects and leaves without a word is not worth one.
                Greeting::None if self.ended && self.held.is_empty() => return false,
                Greeting::None | Greeting::Other => {
                    tell(News::Stranger);
                    return false;
                }
            }
        }
        if self.ended && self.held.is_empty() {
            tell(News::Disconnected);
            return false;
        }
        true
    }

    /// What the client's first frame is. Zeros before it are silence.
    fn greeting(&mut self) -> Greeting {
        while self.held.front() == Some(&0) {
            self.held.pop_front();
        }
        // A hello's frame begins with the code of its channel, which is zero.
        if self.held.front().is_some_and(|&first| first != HELLO_FIRST) {
            return Greeting::Other;
        }
        let Some(end) = self.held.iter().position(|&byte| byte == 0) else {
            let longest = Bound::ALL[Channel::Hello as usize].frame_len;
            return if self.held.len() > longest { Greeting::Other } else { Greeting::None };
        };
        let mut decoder = Decoder::new();
        for &byte in self.held.iter().take(end + 1) {
            if let Some(Ok(frame)) = decoder.push(byte)
                && frame.hello().is_some()
            {
                return Greeting::Hello;
            }
        }
        Greeting::Other
    }

    /// The client's next whole frame, counted by this encoder.
    pub fn next_frame(&mut self, encoder: &mut Encoder) -> Option<Frame> {
        if !self.greeted {
            return None;
        }
        while let Some(byte) = self.held.pop_front() {
            // A damaged frame is dropped here: between client and robot there is a second checksum.
            if let Some(Ok(frame)) = self.decoder.push(byte) {
                return Some(encoder.relay(&frame));
            }
        }
        None
    }

    /// Sends as much as the client takes; false if the client is to be forgotten.
    pub fn send(&mut self, bytes: &[u8], tell: &mut dyn FnMut(News)) -> bool {
        if !self.greeted || self.ended {
            return true;
        }
        self.unsent.extend(bytes);
        let sent = self.send_unsent();
        if sent.is_err() {
            tell(News::Disconnected);
            return false;
        }
        if self.unsent.len() > UNREAD_MAX {
            tell(News::NotReading);
            return false;
        }
        true
    }

    fn send_unsent(&mut self) -> io::Result<()> {
        while !self.unsent.is_empty() {
            match self.stream.write(self.unsent.as_slices().0) {
                Ok(len) => drop(self.unsent.drain(..len)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

enum Greeting {
    None,
    Hello,
    Other,
}
