//! MCAP, the file format of ROS 2 bags: records one after the other, most of them in compressed chunks.
//!
//! ```text
//! magic | record | record | ... | magic          record: opcode (1 byte), length (8 bytes), content
//! chunk: ..., compression, content               content: channel and message records, compressed by zstd, lz4 or not
//! ```
//!
//! A bag is read from its beginning to its end, chunk by chunk, so that one that a crash cut off is read as far as it is
//! whole; the index at its end is not needed. zstd and lz4 are decoded without C, so that nobody needs a C compiler.
//!
//! | file | what it is |
//! | --- | --- |
//! | `fields.rs` | the fields of a record |
//! | `read.rs` | [`read`]: every message of a bag |
//! | `write.rs` | [`BagWriter`]: bags of our own |

mod fields;
mod read;
mod write;

pub use read::{ReadError, read};
pub use write::{BagWriter, ChannelId};

/// What a bag begins and ends with.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// Records that are read or written.
mod opcode {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const DATA_END: u8 = 0x0f;
}
