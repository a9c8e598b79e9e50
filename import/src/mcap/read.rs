//! Every message of a bag, in the order of the file; of a damaged bag, what is whole.

use std::collections::HashMap;
use std::io::{self, Read};

use lz4_flex::frame::FrameDecoder;
use ruzstd::decoding::StreamingDecoder;

use super::fields::Fields;
use super::{MAGIC, opcode};
use crate::received::{Channel, Damage, Received};

/// The longest record, and the longest content of a chunk: recorders write chunks of a few megabytes \[bytes\].
const RECORD_BYTES_MAX: u64 = 256 << 20;

/// A chunk may unpack to this many times its size, and so much more: logs compress by ten, pictures of nothing by more.
const PACKED_TIMES_MAX: u64 = 1000;
const UNPACKED_BYTES: u64 = 16 << 20;

/// Why nothing at all can be read.
#[derive(Debug)]
pub enum ReadError {
    /// The system refused.
    Io(io::Error),
    /// It does not begin as an MCAP file does.
    NotMcap,
}

/// Gives every message of a bag to `each`; what is damaged is the result.
pub fn read(
    mut file: impl Read,
    mut each: impl FnMut(Received<'_>),
) -> Result<Vec<Damage>, ReadError> {
    let mut magic = [0; MAGIC.len()];
    match file.read_exact(&mut magic) {
        Ok(()) if magic == MAGIC => {}
        Ok(()) => return Err(ReadError::NotMcap),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            return Err(ReadError::NotMcap);
        }
        Err(error) => return Err(ReadError::Io(error)),
    }
    let mut bag = Bag::default();
    let mut at = MAGIC.len() as u64;
    let mut content = Vec::new();
    loop {
        let Some((opcode, length)) = head(&mut file).map_err(ReadError::Io)? else {
            bag.damage.push(Damage::CutOff { at });
            break;
        };
        if opcode == opcode::FOOTER || opcode == opcode::DATA_END {
            break;
        }
        // Nothing is reserved for what a length promises: the buffer grows with what is there.
        content.clear();
        let known = length <= RECORD_BYTES_MAX;
        let got = match known {
            true => (&mut file).take(length).read_to_end(&mut content).map(|got| got as u64),
            false => io::copy(&mut (&mut file).take(length), &mut io::sink()),
        };
        if got.map_err(ReadError::Io)? < length {
            bag.damage.push(Damage::CutOff { at });
            break;
        }
        if known {
            bag.record(at, opcode, &content, &mut each);
        } else {
            bag.damage.push(Damage::Record { at });
        }
        at = at.saturating_add(9).saturating_add(length);
    }
    Ok(bag.damage)
}

/// Opcode and length of the next record; `None` at the end of the file, also within them.
fn head(file: &mut impl Read) -> io::Result<Option<(u8, u64)>> {
    let mut bytes = [0; 9];
    match file.read_exact(&mut bytes) {
        Ok(()) => {
            let [opcode, length @ ..] = bytes;
            Ok(Some((opcode, u64::from_le_bytes(length))))
        }
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(error),
    }
}

/// What is known so far.
#[derive(Default)]
struct Bag {
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Channel>,
    damage: Vec<Damage>,
}

impl Bag {
    fn record(&mut self, at: u64, opcode: u8, content: &[u8], each: &mut impl FnMut(Received<'_>)) {
        if opcode == opcode::CHUNK {
            self.chunk(at, content, each);
        } else if self.plain(opcode, content, each).is_none() {
            self.damage.push(Damage::Record { at });
        }
    }

    /// A record that is not a chunk; `None` if it contradicts itself.
    fn plain(
        &mut self,
        opcode: u8,
        content: &[u8],
        each: &mut impl FnMut(Received<'_>),
    ) -> Option<()> {
        let mut fields = Fields(content);
        match opcode {
            opcode::SCHEMA => {
                let (id, name) = (fields.u16()?, fields.string()?);
                self.schemas.insert(id, name);
            }
            opcode::CHANNEL => {
                let (id, schema) = (fields.u16()?, fields.u16()?);
                let (topic, encoding) = (fields.string()?, fields.string()?);
                let schema = self.schemas.get(&schema).cloned().unwrap_or_default();
                self.channels.insert(id, Channel { topic, schema, encoding });
            }
            opcode::MESSAGE => {
                let (id, _sequence) = (fields.u16()?, fields.u32()?);
                let (log_time, _publish_time) = (fields.u64()?, fields.u64()?);
                let channel = self.channels.get(&id)?;
                each(Received { channel, log_time_s: log_time as f64 * 1e-9, bytes: fields.0 });
            }
            _ => {}
        }
        Some(())
    }

    fn chunk(&mut self, at: u64, content: &[u8], each: &mut impl FnMut(Received<'_>)) {
        let mut fields = Fields(content);
        let head = || -> Option<(u64, u32, String, u64)> {
            fields.bytes(16)?;
            Some((fields.u64()?, fields.u32()?, fields.string()?, fields.u64()?))
        }();
        let Some((size, crc, compression, length)) = head else {
            return self.damage.push(Damage::Chunk { at });
        };
        let Some(records) = fields.bytes(length) else {
            return self.damage.push(Damage::Chunk { at });
        };
        if size > RECORD_BYTES_MAX.min(UNPACKED_BYTES + PACKED_TIMES_MAX * length) {
            return self.damage.push(Damage::Chunk { at });
        }
        let mut unpacked = Vec::new();
        let records = match compression.as_str() {
            "" => Some(records),
            "zstd" => StreamingDecoder::new(records)
                .ok()
                .and_then(|decoder| unpack(decoder, size, &mut unpacked)),
            "lz4" => unpack(FrameDecoder::new(records), size, &mut unpacked),
            _ => {
                let damage = Damage::Compression { name: compression };
                if !self.damage.contains(&damage) {
                    self.damage.push(damage);
                }
                return;
            }
        };
        let sound = |records: &&[u8]| crc == 0 || crc == checksum(records);
        let Some(records) = records.filter(sound) else {
            return self.damage.push(Damage::Chunk { at });
        };
        let mut fields = Fields(records);
        while !fields.0.is_empty() {
            let Some((opcode, content)) = fields.record() else {
                return self.damage.push(Damage::Chunk { at });
            };
            if self.plain(opcode, content, each).is_none() {
                self.damage.push(Damage::Record { at });
            }
        }
    }
}

/// What a chunk unpacks to, if that has the size that the chunk says.
fn unpack(decoder: impl Read, size: u64, unpacked: &mut Vec<u8>) -> Option<&[u8]> {
    // One byte more, to notice a chunk that goes on.
    decoder.take(size + 1).read_to_end(unpacked).ok()?;
    (unpacked.len() as u64 == size).then_some(unpacked)
}

/// CRC-32 as in zip files.
pub(super) fn checksum(bytes: &[u8]) -> u32 {
    static CRC: crc::Crc<u32, crc::Table<16>> =
        crc::Crc::<u32, crc::Table<16>>::new(&crc::CRC_32_ISO_HDLC);
    CRC.checksum(bytes)
}
