//! The bytes to and from a robot. What they mean is left to `shared-proto` and
//! [`crate::session`].

use std::collections::VecDeque;
use std::future::Future;
use std::io::{self, Read, Write};
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use shared_proto::{Channel, FRAME_LEN_MAX};

/// The boxed future that a wire or a clock returns.
pub type Waiting<'a, T> = Pin<Box<dyn Future<Output = T> + 'a>>;

/// Bytes to and from a robot.
pub trait Wire {
    /// Sends bytes.
    fn write<'a>(&'a mut self, bytes: &'a [u8]) -> Waiting<'a, io::Result<()>>;

    /// Waits for bytes. The future can be dropped at any time without losing bytes.
    fn read(&mut self) -> Waiting<'_, io::Result<Vec<u8>>>;
}

/// A device with blocking reads, which a thread of its own does.
///
/// What was read waits as frames, up to 4096 of them: a person who is asked something may take an hour. Then the oldest
/// telemetry is dropped; the numbers of the frames that follow show how much.
pub struct ThreadedWire {
    frames: Arc<Mutex<Frames>>,
    arrived: async_channel::Receiver<()>,
    writer: Box<dyn Write + Send>,
}

/// Some twenty seconds of telemetry every 5 ms; at most two megabytes.
const FRAMES_MAX: usize = 4096;

/// What was read, in whole frames.
#[derive(Default)]
struct Frames {
    /// Each ends with its zero.
    whole: VecDeque<Vec<u8>>,
    partial: Vec<u8>,
    over: Option<io::Error>,
}

impl Frames {
    fn push(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.partial.push(*byte);
            // What is longer than any frame is noise, which the decoder counts.
            if *byte == 0 || self.partial.len() > FRAME_LEN_MAX {
                self.whole.push_back(std::mem::take(&mut self.partial));
            }
        }
        while self.whole.len() > FRAMES_MAX {
            let oldest = self.whole.iter().position(|frame| is_telemetry(frame)).unwrap_or(0);
            self.whole.remove(oldest);
        }
    }

    fn take(&mut self) -> Option<io::Result<Vec<u8>>> {
        if self.whole.is_empty() {
            return self.over.take().map(Err);
        }
        Some(Ok(self.whole.drain(..).flatten().collect()))
    }
}

/// Whether a frame is telemetry, by its first byte: in COBS, after the distance to the first zero.
fn is_telemetry(frame: &[u8]) -> bool {
    frame.first().is_some_and(|distance| *distance > 1)
        && frame.get(1) == Some(&(Channel::Telemetry as u8))
}

impl Wire for ThreadedWire {
    fn write<'a>(&'a mut self, bytes: &'a [u8]) -> Waiting<'a, io::Result<()>> {
        Box::pin(async move {
            self.writer.write_all(bytes)?;
            self.writer.flush()
        })
    }

    fn read(&mut self) -> Waiting<'_, io::Result<Vec<u8>>> {
        Box::pin(async move {
            loop {
                let taken = lock(&self.frames).take();
                if let Some(taken) = taken {
                    return taken;
                }
                if self.arrived.recv().await.is_err() {
                    // The thread has ended, and may have left something just before.
                    let last = lock(&self.frames).take();
                    return last.unwrap_or_else(|| Err(io::ErrorKind::UnexpectedEof.into()));
                }
            }
        })
    }
}

/// Nothing that holds the lock can panic.
fn lock(frames: &Mutex<Frames>) -> MutexGuard<'_, Frames> {
    frames.lock().unwrap_or_else(PoisonError::into_inner)
}

impl ThreadedWire {
    /// A wire over this device; a thread reads it until the process ends or the device is gone.
    pub fn new(
        mut reader: impl Read + Send + 'static,
        writer: impl Write + Send + 'static,
    ) -> Self {
        let frames = Arc::new(Mutex::new(Frames::default()));
        let (sender, arrived) = async_channel::bounded(1);
        let read = frames.clone();
        std::thread::spawn(move || {
            let mut buffer = [0; 1024];
            loop {
                let over = match reader.read(&mut buffer) {
                    Ok(0) => Some(io::ErrorKind::UnexpectedEof.into()),
                    Ok(len) => {
                        lock(&read).push(&buffer[..len]);
                        None
                    }
                    Err(error) if is_pause(&error) => continue,
                    Err(error) => Some(error),
                };
                let is_over = over.is_some();
                lock(&read).over = over;
                // A full channel says already that something has arrived.
                if sender.try_send(()).is_err_and(|error| error.is_closed()) || is_over {
                    return;
                }
            }
        });
        Self { frames, arrived, writer: Box::new(writer) }
    }
}

fn is_pause(error: &io::Error) -> bool {
    use io::ErrorKind;
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

#[cfg(test)]
mod tests {
    use futures_lite::future::block_on;
    use shared_proto::{
        Command, Encoder, Event, Pose, PoseDeviation, Request, State, Telemetry, WheelPair,
        WheelTelemetry,
    };

    use super::*;

    fn telemetry(encoder: &mut Encoder, number: u32) -> Vec<u8> {
        let wheels = WheelPair::both(WheelTelemetry::default());
        let state = State::Idle;
        let (pose, deviation) = (Pose::default(), PoseDeviation::default());
        let (t_us, probing, supply_mv) = (0, false, 0);
        let telemetry =
            Telemetry { number, t_us, state, probing, wheels, supply_mv, pose, deviation };
        encoder.message(&telemetry).to_vec()
    }

    #[test]
    fn a_host_that_reads_nothing_keeps_the_latest_telemetry_and_everything_else() {
        let mut encoder = Encoder::new();
        let mut frames = Frames::default();
        let event = encoder.message(&Event::State { state: State::Idle, t_us: 7 }).to_vec();
        let request = encoder
            .message(&Request { session: 1, id: 1, until_ms: 0, command: Command::Status })
            .to_vec();
        frames.push(&event);
        let mut sent = Vec::new();
        for number in 0..3 * FRAMES_MAX as u32 {
            sent.push(telemetry(&mut encoder, number));
            // In pieces that are no frames.
            sent[number as usize].chunks(7).for_each(|piece| frames.push(piece));
        }
        frames.push(&request);
        assert_eq!(frames.whole.len(), FRAMES_MAX);
        let kept = frames.take().unwrap().unwrap();
        assert!(kept.starts_with(&event) && kept.ends_with(&request));
        assert!(kept[event.len()..].starts_with(&sent[sent.len() - (FRAMES_MAX - 2)]));
        assert!(frames.take().is_none());
    }

    #[test]
    fn a_device_that_never_ends_a_frame_takes_no_more_room() {
        let mut frames = Frames::default();
        frames.push(&vec![1; 10 * FRAMES_MAX * FRAME_LEN_MAX]);
        assert!(frames.whole.len() <= FRAMES_MAX && frames.partial.len() <= FRAME_LEN_MAX + 1);
    }

    #[test]
    fn what_a_device_sent_before_its_end_is_read_before_the_error() {
        let mut encoder = Encoder::new();
        let bytes = telemetry(&mut encoder, 3);
        let mut wire = ThreadedWire::new(io::Cursor::new(bytes.clone()), io::sink());
        assert_eq!(block_on(wire.read()).unwrap(), bytes);
        let error = block_on(wire.read()).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    }
}
