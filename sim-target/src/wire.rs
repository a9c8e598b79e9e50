//! The serial line between host and robot: baud rate, a finite buffer, lost frames, flipped bits.

use core::cell::RefCell;
use core::convert::Infallible;
use core::future::poll_fn;
use core::task::{Poll, Waker};
use std::collections::VecDeque;
use std::rc::Rc;

use embassy_time::Instant;
use embedded_io_async::{ErrorType, Read, Write};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The properties of one direction of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WireParameters {
    /// Bits per second, ten to a byte; 0 for no delay at all.
    pub baud: u32,
    /// Share of written chunks (one frame each) that vanish.
    pub frame_loss: f64,
    /// Share of bits that flip.
    pub bit_error: f64,
}

/// A writer waits while this many bytes are still on the line: a UART's transmit buffer.
const BACKLOG_BYTES_MAX: u64 = 256;

/// A robot that does not read loses everything as soon as this many bytes have arrived: a board's ring buffer, which
/// begins anew when it overflows.
const RECEIVE_BYTES_MAX: usize = 512;

/// What is written arrives in pieces of this many bytes.
const PIECE_BYTES: usize = 32;

/// One direction of a line.
#[derive(Clone)]
pub struct Wire(Rc<RefCell<LineState>>);

struct LineState {
    parameters: WireParameters,
    rng: ChaCha8Rng,
    /// Bytes in transit, each chunk with the time at which its last byte arrives \[us\].
    in_transit: VecDeque<(u64, Vec<u8>)>,
    /// How much of the first chunk has been read.
    read: usize,
    /// When the line has sent everything that was written \[us\].
    idle_us: u64,
    reader: Option<Waker>,
    cut: bool,
    /// Unread bytes that the receiver holds at most.
    receive_max: usize,
}

impl Wire {
    /// A line whose damage is drawn from `seed`.
    pub fn new(parameters: WireParameters, seed: u64) -> Self {
        Self(Rc::new(RefCell::new(LineState {
            parameters,
            rng: ChaCha8Rng::seed_from_u64(seed),
            in_transit: VecDeque::new(),
            read: 0,
            idle_us: 0,
            reader: None,
            cut: false,
            receive_max: usize::MAX,
        })))
    }

    /// As [`new`](Self::new), to a receiver with the buffer of a board. A line without delay is taken to be one that
    /// loses nothing.
    pub fn to_board(parameters: WireParameters, seed: u64) -> Self {
        let wire = Self::new(parameters, seed);
        if parameters.baud > 0 {
            wire.0.borrow_mut().receive_max = RECEIVE_BYTES_MAX;
        }
        wire
    }

    /// Cuts or restores the line. Bytes that are written while the line is cut are lost.
    pub fn set_cut(&self, cut: bool) {
        self.0.borrow_mut().cut = cut;
    }

    /// Drops the reader's waker: its task is about to be freed.
    pub(crate) fn forget_reader(&self) {
        self.0.borrow_mut().reader = None;
    }

    /// Puts bytes on the line without waiting.
    pub fn write_now(&self, bytes: &[u8]) {
        let mut state = self.0.borrow_mut();
        let state = &mut *state;
        let begin_us = state.idle_us.max(crate::clock::now_us());
        let baud = u64::from(state.parameters.baud);
        let arrival_us = |len: usize| match baud {
            0 => begin_us,
            baud => begin_us + len as u64 * 10_000_000 / baud,
        };
        state.idle_us = arrival_us(bytes.len());
        let WireParameters { frame_loss, bit_error, .. } = state.parameters;
        if state.cut || (frame_loss > 0.0 && state.rng.random_bool(frame_loss)) {
            return;
        }
        let mut bytes = bytes.to_vec();
        if bit_error > 0.0 {
            for byte in &mut bytes {
                for bit in 0..8 {
                    if state.rng.random_bool(bit_error) {
                        *byte ^= 1 << bit;
                    }
                }
            }
        }
        let mut len = 0;
        for piece in bytes.chunks(PIECE_BYTES) {
            len += piece.len();
            state.in_transit.push_back((arrival_us(len), piece.to_vec()));
        }
        if let Some(reader) = state.reader.take() {
            reader.wake();
        }
    }

    /// Whether the transmit buffer has room.
    pub fn has_room(&self) -> bool {
        let state = self.0.borrow();
        let waiting_us = state.idle_us.saturating_sub(crate::clock::now_us());
        waiting_us * u64::from(state.parameters.baud) < BACKLOG_BYTES_MAX * 10_000_000
    }

    /// Takes the bytes that have arrived, without waiting. Returns how many.
    pub fn read_now(&self, buffer: &mut [u8]) -> usize {
        let mut state = self.0.borrow_mut();
        let state = &mut *state;
        let now = crate::clock::now_us();
        state.overflow(now);
        let mut len = 0;
        while len < buffer.len()
            && let Some((arrival, chunk)) = state.in_transit.front()
            && *arrival <= now
        {
            let rest = &chunk[state.read..];
            let take = rest.len().min(buffer.len() - len);
            buffer[len..len + take].copy_from_slice(&rest[..take]);
            len += take;
            state.read += take;
            if state.read == chunk.len() {
                state.in_transit.pop_front();
                state.read = 0;
            }
        }
        len
    }

    /// Waits for bytes and takes them.
    pub async fn read(&self, buffer: &mut [u8]) -> usize {
        poll_fn(|context| {
            let len = self.read_now(buffer);
            if len > 0 {
                return Poll::Ready(len);
            }
            let mut state = self.0.borrow_mut();
            match state.in_transit.front() {
                Some(&(arrival, _)) => embassy_time_driver::schedule_wake(arrival, context.waker()),
                None => state.reader = Some(context.waker().clone()),
            }
            Poll::Pending
        })
        .await
    }

    /// Waits until the transmit buffer has room, then writes.
    pub async fn write(&self, bytes: &[u8]) {
        let room_us = {
            let state = self.0.borrow();
            match state.parameters.baud {
                0 => 0,
                baud => {
                    state.idle_us.saturating_sub(BACKLOG_BYTES_MAX * 10_000_000 / u64::from(baud))
                }
            }
        };
        if room_us > crate::clock::now_us() {
            embassy_time::Timer::at(Instant::from_micros(room_us)).await;
        }
        self.write_now(bytes);
    }
}

impl LineState {
    /// Drops what has arrived, if it is more than the receiver holds.
    fn overflow(&mut self, now: u64) {
        let arrived = self.in_transit.iter().take_while(|(arrival, _)| *arrival <= now);
        let (pieces, bytes) =
            arrived.fold((0, 0), |(pieces, bytes), (_, piece)| (pieces + 1, bytes + piece.len()));
        if bytes - self.read > self.receive_max {
            self.in_transit.drain(..pieces);
            self.read = 0;
        }
    }
}

/// The host's end of the serial line.
#[derive(Clone)]
pub struct HostWire {
    pub(crate) to_robot: Wire,
    pub(crate) to_host: Wire,
}

impl HostWire {
    /// Sends bytes to the robot.
    pub async fn write(&self, bytes: &[u8]) {
        self.to_robot.write(bytes).await;
    }

    /// Waits for bytes from the robot.
    pub async fn read(&self, buffer: &mut [u8]) -> usize {
        self.to_host.read(buffer).await
    }

    /// Sends bytes to the robot without waiting for room on the line.
    pub fn write_now(&self, bytes: &[u8]) {
        self.to_robot.write_now(bytes);
    }

    /// Whether the transmit buffer to the robot has room.
    pub fn has_room(&self) -> bool {
        self.to_robot.has_room()
    }

    /// Takes the bytes that have arrived from the robot, without waiting.
    pub fn read_now(&self, buffer: &mut [u8]) -> usize {
        self.to_host.read_now(buffer)
    }

    /// Unplugs the line, or plugs it in again.
    pub fn set_cut(&self, cut: bool) {
        self.cut_to_robot(cut);
        self.cut_to_host(cut);
    }

    /// Cuts the wire on which the robot hears the host, or mends it.
    pub fn cut_to_robot(&self, cut: bool) {
        self.to_robot.set_cut(cut);
    }

    /// Cuts the wire on which the host hears the robot, or mends it.
    pub fn cut_to_host(&self, cut: bool) {
        self.to_host.set_cut(cut);
    }
}

impl ErrorType for Wire {
    type Error = Infallible;
}

impl Read for Wire {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        Ok(Wire::read(self, buffer).await)
    }
}

impl Write for Wire {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        Wire::write(self, bytes).await;
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
