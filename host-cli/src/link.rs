//! The bytes to and from a robot, and the time that a conversation goes by: in this process in
//! virtual time, or behind the operating system in the world's.

use std::io::{Read, Write};
use std::time::{Duration, Instant};

use sim_target::HostWire;

/// Bytes to and from a robot.
pub enum Wire {
    /// In this process.
    Sim(HostWire),
    /// Behind the operating system.
    Threaded(ThreadedWire),
}

/// A device whose reads block, read by a thread of its own.
pub struct ThreadedWire {
    incoming: async_channel::Receiver<std::io::Result<Vec<u8>>>,
    writer: Box<dyn Write + Send>,
}

impl Wire {
    /// Sends bytes.
    pub async fn write(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        match self {
            Wire::Sim(wire) => {
                wire.write(bytes).await;
                Ok(())
            }
            Wire::Threaded(wire) => {
                wire.writer.write_all(bytes)?;
                wire.writer.flush()
            }
        }
    }

    /// Waits for bytes. May be given up at any time without losing some.
    pub async fn read(&mut self) -> std::io::Result<Vec<u8>> {
        match self {
            Wire::Sim(wire) => {
                let mut buffer = vec![0; 512];
                let len = wire.read(&mut buffer).await;
                buffer.truncate(len);
                Ok(buffer)
            }
            Wire::Threaded(wire) => match wire.incoming.recv().await {
                Ok(bytes) => bytes,
                Err(_) => Err(std::io::ErrorKind::UnexpectedEof.into()),
            },
        }
    }
}

/// The time that a session goes by.
#[derive(Clone, Copy, Debug)]
pub enum Clock {
    /// The simulator's.
    Virtual,
    /// The world's, from this instant.
    Real(Instant),
}

impl Clock {
    /// Time on this clock \[us\].
    pub fn now_us(&self) -> u64 {
        match self {
            Clock::Virtual => sim_target::now_us(),
            Clock::Real(start) => start.elapsed().as_micros() as u64,
        }
    }

    /// Waits until the clock shows this time.
    pub async fn sleep_until_us(&self, t_us: u64) {
        match self {
            Clock::Virtual => sim_target::sleep_until_us(t_us).await,
            Clock::Real(start) => {
                async_io::Timer::at(*start + Duration::from_micros(t_us)).await;
            }
        }
    }

    /// Waits this long.
    pub async fn sleep(&self, duration: Duration) {
        self.sleep_until_us(self.now_us() + duration.as_micros() as u64).await;
    }
}

impl ThreadedWire {
    /// A device; a thread reads it until the process ends or the device is gone.
    pub fn new(
        mut reader: impl Read + Send + 'static,
        writer: impl Write + Send + 'static,
    ) -> Self {
        let (sender, incoming) = async_channel::unbounded();
        std::thread::spawn(move || {
            let mut buffer = [0; 1024];
            loop {
                let bytes = match reader.read(&mut buffer) {
                    Ok(0) => Err(std::io::ErrorKind::UnexpectedEof.into()),
                    Ok(len) => Ok(buffer[..len].to_vec()),
                    Err(error) if is_only_a_pause(&error) => continue,
                    Err(error) => Err(error),
                };
                let over = bytes.is_err();
                if sender.send_blocking(bytes).is_err() || over {
                    return;
                }
            }
        });
        Self { incoming, writer: Box::new(writer) }
    }
}

fn is_only_a_pause(error: &std::io::Error) -> bool {
    use std::io::ErrorKind;
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
