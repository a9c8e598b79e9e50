//! The handshake. Its bytes never change, so that two ends of any age can name each other's version.

use postcard_schema::key::Key;

use crate::config::Config;
use crate::message::{Event, Reply, Request};
use crate::name::NAME_LEN_MAX;
use crate::telemetry::Telemetry;

/// The version of the protocol that this crate speaks; raised when the meaning of a message changes.
pub const PROTOCOL_VERSION: u16 = 2;

/// A hash of the layout of every message: field names, types and order, the length of a name, and
/// the numbers of the configuration's fields.
///
/// So a change of layout is noticed even if nobody raised [`PROTOCOL_VERSION`].
pub const SCHEMA_HASH: u64 = {
    let mut hash = FNV_BASIS;
    hash = fnv1a(hash, &Key::for_path::<Request>("request").to_bytes());
    hash = fnv1a(hash, &Key::for_path::<Reply>("reply").to_bytes());
    hash = fnv1a(hash, &Key::for_path::<Telemetry>("telemetry").to_bytes());
    hash = fnv1a(hash, &Key::for_path::<Event>("event").to_bytes());
    // What the schemas do not contain.
    hash = fnv1a(hash, &[NAME_LEN_MAX as u8]);
    let mut i = 0;
    while i < Config::FIELDS.len() {
        hash = fnv1a(hash, Config::FIELDS[i].path.as_bytes());
        i += 1;
    }
    hash
};

// FNV-1a, 64 bit: offset basis and prime as published by Fowler, Noll and Vo.
const FNV_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

const fn fnv1a(mut hash: u64, bytes: &[u8]) -> u64 {
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(FNV_PRIME);
        i += 1;
    }
    hash
}

/// The first message in each direction, on [`Channel::Hello`](crate::Channel::Hello).
///
/// ```text
/// "BEEL" | protocol u16 LE | schema u64 LE | session u32 LE      18 bytes, for ever
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Hello {
    /// The sender's [`PROTOCOL_VERSION`].
    pub protocol: u16,
    /// The sender's [`SCHEMA_HASH`].
    pub schema: u64,
    /// Drawn by the host for each session; the robot answers with the same one.
    pub session: u32,
}

impl Hello {
    const MAGIC: [u8; 4] = *b"BEEL";
    /// Length in bytes.
    pub const LEN: usize = 18;

    /// This build's hello.
    pub const fn of_this_build(session: u32) -> Self {
        Self { protocol: PROTOCOL_VERSION, schema: SCHEMA_HASH, session }
    }

    /// Whether the two ends understand each other's messages.
    pub const fn agrees_with(&self, other: &Hello) -> bool {
        self.protocol == other.protocol && self.schema == other.schema
    }

    /// The bytes on the wire.
    pub fn to_bytes(self) -> [u8; Self::LEN] {
        let mut bytes = [0; Self::LEN];
        bytes[0..4].copy_from_slice(&Self::MAGIC);
        bytes[4..6].copy_from_slice(&self.protocol.to_le_bytes());
        bytes[6..14].copy_from_slice(&self.schema.to_le_bytes());
        bytes[14..18].copy_from_slice(&self.session.to_le_bytes());
        bytes
    }

    /// Reads a hello; `None` if these bytes are not a hello.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        // A later version may append fields; the first 18 bytes keep their meaning.
        let bytes: &[u8; Self::LEN] = bytes.first_chunk()?;
        if bytes[0..4] != Self::MAGIC {
            return None;
        }
        Some(Self {
            protocol: u16::from_le_bytes(bytes[4..6].try_into().ok()?),
            schema: u64::from_le_bytes(bytes[6..14].try_into().ok()?),
            session: u32::from_le_bytes(bytes[14..18].try_into().ok()?),
        })
    }
}
