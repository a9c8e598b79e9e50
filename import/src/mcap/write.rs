//! Bags of our own: chunks without compression or with lz4, and no index, which readers make do without.

use std::io::{self, Write};

use super::fields::{record, string};
use super::read::checksum;
use super::{MAGIC, opcode};

/// A chunk is written when its records have this size \[bytes\].
const CHUNK_BYTES: usize = 1 << 20;

/// Writes a bag into memory or a file.
#[derive(Debug)]
pub struct BagWriter<W: Write> {
    file: W,
    chunk: Vec<u8>,
    /// Of the chunk's messages \[ns\].
    times: Option<(u64, u64)>,
    channels: u16,
    sequence: u32,
}

/// A channel of a bag that is being written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelId(u16);

impl<W: Write> BagWriter<W> {
    /// Begins a bag.
    pub fn new(mut file: W) -> io::Result<Self> {
        file.write_all(&MAGIC)?;
        file.write_all(&record(opcode::HEADER, &[&string("ros2"), &string("beeline")]))?;
        Ok(Self { file, chunk: Vec::new(), times: None, channels: 0, sequence: 0 })
    }

    /// A channel for CDR messages of a type, with its definition as ROS 2 has it.
    pub fn channel(&mut self, topic: &str, schema: &str, definition: &str) -> ChannelId {
        self.channels += 1;
        let id = self.channels.to_le_bytes();
        let fields: [&[u8]; 4] = [&id, &string(schema), &string("ros2msg"), &string(definition)];
        self.chunk.extend(record(opcode::SCHEMA, &fields));
        let no_metadata = 0u32.to_le_bytes();
        let fields: [&[u8]; 5] = [&id, &id, &string(topic), &string("cdr"), &no_metadata];
        self.chunk.extend(record(opcode::CHANNEL, &fields));
        ChannelId(self.channels)
    }

    /// Adds a message that was received at a time \[s\].
    pub fn message(&mut self, channel: ChannelId, log_time_s: f64, bytes: &[u8]) -> io::Result<()> {
        let time = (log_time_s.max(0.0) * 1e9).round() as u64;
        self.sequence = self.sequence.wrapping_add(1);
        let (id, sequence, stamp) =
            (channel.0.to_le_bytes(), self.sequence.to_le_bytes(), time.to_le_bytes());
        self.chunk.extend(record(opcode::MESSAGE, &[&id, &sequence, &stamp, &stamp, bytes]));
        let (first, last) = self.times.unwrap_or((time, time));
        self.times = Some((first.min(time), last.max(time)));
        if self.chunk.len() >= CHUNK_BYTES { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.chunk.is_empty() {
            return Ok(());
        }
        let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
        packed.write_all(&self.chunk)?;
        let packed = packed.finish().map_err(io::Error::from)?;
        let (first, last) = self.times.take().unwrap_or_default();
        let fields: [&[u8]; 7] = [
            &first.to_le_bytes(),
            &last.to_le_bytes(),
            &(self.chunk.len() as u64).to_le_bytes(),
            &checksum(&self.chunk).to_le_bytes(),
            &string("lz4"),
            &(packed.len() as u64).to_le_bytes(),
            &packed,
        ];
        self.file.write_all(&record(opcode::CHUNK, &fields))?;
        self.chunk.clear();
        Ok(())
    }

    /// Ends the bag, and gives the file back.
    pub fn finish(mut self) -> io::Result<W> {
        self.flush()?;
        // No checksum of the data, no summary, no checksum of that.
        self.file.write_all(&record(opcode::DATA_END, &[&[0; 4]]))?;
        self.file.write_all(&record(opcode::FOOTER, &[&[0; 20]]))?;
        self.file.write_all(&MAGIC)?;
        Ok(self.file)
    }
}
