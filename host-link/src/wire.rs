//! The bytes to and from a robot. What they mean is a matter of `shared-proto` and
//! [`crate::session`].

use std::future::Future;
use std::io::{self, Read, Write};
use std::pin::Pin;

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
pub struct ThreadedWire {
    incoming: async_channel::Receiver<io::Result<Vec<u8>>>,
    writer: Box<dyn Write + Send>,
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
            match self.incoming.recv().await {
                Ok(bytes) => bytes,
                Err(_) => Err(io::ErrorKind::UnexpectedEof.into()),
            }
        })
    }
}

impl ThreadedWire {
    /// A wire over this device; a thread reads it until the process ends or the device is gone.
    pub fn new(
        mut reader: impl Read + Send + 'static,
        writer: impl Write + Send + 'static,
    ) -> Self {
        let (sender, incoming) = async_channel::unbounded();
        std::thread::spawn(move || {
            let mut buffer = [0; 1024];
            loop {
                let bytes = match reader.read(&mut buffer) {
                    Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
                    Ok(len) => Ok(buffer[..len].to_vec()),
                    Err(error) if is_pause(&error) => continue,
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

fn is_pause(error: &io::Error) -> bool {
    use io::ErrorKind;
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
