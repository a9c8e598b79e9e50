//! The pre-shared key: who may talk to a robot, and how a frame shows that its sender may.
//!
//! ```text
//! host                                             robot
//!   hello                               ---->
//!                                       <----      hello, challenge C (16 bytes)
//!   Open: session, nonce N, seal by S   ---->
//!                                       <----      Opened: session, boot B, seal by S
//!   requests, sealed by S               ---->
//!                                       <----      replies, telemetry, events, sealed by R
//! ```
//!
//! Everything is made of one function, SipHash-2-4 with 64 bits of result:
//!
//! ```text
//! derive(K, label, data) = SipHash(K, 2*label | data) | SipHash(K, 2*label + 1 | data)        16 bytes
//! S = derive(K, 1, hello of the host (18 bytes) | N | C)                                      one session
//! R = derive(K, 2, B)                                                  the robot since its last start
//! seal = counter u64 LE | SipHash(S or R, channel + 0x80 | payload | counter u64 LE) u64 LE    16 bytes
//! ```
//!
//! A sealed frame has 0x80 added to its channel, and the seal after its payload. Counters rise strictly: `Open`
//! has 0, the host's requests follow from 1; the robot counts all of its frames together, and `Opened` has the
//! counter of the last one before it. Nothing is encrypted.

use core::fmt;
use core::hash::Hasher;

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};
use siphasher::sip::SipHasher24;
use subtle::ConstantTimeEq;

/// A number that is used once.
pub type Nonce = [u8; 16];

/// What a derived key is for.
#[derive(Clone, Copy)]
#[repr(u8)]
enum Label {
    Session = 1,
    Robot = 2,
    Challenge = 3,
    Boot = 4,
    Mask = 5,
    HostNonce = 6,
}

/// A key of 128 bits: a pre-shared one, or one derived from it. Nothing prints its bytes.
#[derive(Clone, Copy, Serialize, Deserialize, Schema)]
pub struct Key([u8; Key::LEN]);

impl Key {
    /// Length in bytes.
    pub const LEN: usize = 16;

    /// The key of these bytes.
    pub const fn new(bytes: [u8; Self::LEN]) -> Self {
        Self(bytes)
    }

    /// The key of 32 hexadecimal digits, as in a file.
    pub fn from_hex(digits: &str) -> Option<Self> {
        let digits: &[u8; 2 * Self::LEN] = digits.as_bytes().try_into().ok()?;
        let mut bytes = [0; Self::LEN];
        for (byte, pair) in bytes.iter_mut().zip(digits.as_chunks::<2>().0) {
            let [high, low] = pair.map(|digit| char::from(digit).to_digit(16));
            *byte = (high? << 4 | low?) as u8;
        }
        Some(Self(bytes))
    }

    /// Its bytes, for whoever stores them.
    pub const fn expose(&self) -> &[u8; Self::LEN] {
        &self.0
    }

    /// The key of a session, from the pre-shared one; the hello is the host's, in bytes.
    #[inline(never)]
    pub fn of_session(&self, hello: &[u8], nonce: &Nonce, challenge: &Nonce) -> Self {
        self.derive(Label::Session, &[hello, nonce, challenge])
    }

    /// The key by which a robot seals what it sends, from the pre-shared one.
    #[inline(never)]
    pub fn of_robot(&self, boot: &Nonce) -> Self {
        self.derive(Label::Robot, &[boot])
    }

    /// A robot's challenge with this number since its start.
    #[inline(never)]
    pub fn challenge(&self, boot: &Nonce, number: u64) -> Nonce {
        self.derive(Label::Challenge, &[boot, &number.to_le_bytes()]).0
    }

    /// What distinguishes a robot's start from all others of that robot, and of all other robots: nobody
    /// without the key can tell it in advance.
    ///
    /// One of `number` and `random` must differ from start to start.
    #[inline(never)]
    pub fn boot(&self, uid: &[u8; 12], number: u64, random: &Nonce) -> Nonce {
        self.derive(Label::Boot, &[uid, &number.to_le_bytes(), random]).0
    }

    /// A host's nonce with this number. The key must be random, and used for nothing else.
    pub fn host_nonce(&self, number: u64) -> Nonce {
        self.derive(Label::HostNonce, &[&number.to_le_bytes()]).0
    }

    /// A new pre-shared key as it travels in the request with this id, if this is the session's key. Masked
    /// twice it is itself.
    #[inline(never)]
    pub fn masked(&self, new: &Key, id: u32) -> Key {
        let mut masked = self.derive(Label::Mask, &[&id.to_le_bytes()]);
        masked.0.iter_mut().zip(new.0).for_each(|(byte, new)| *byte ^= new);
        masked
    }

    #[inline(never)]
    fn derive(&self, label: Label, data: &[&[u8]]) -> Self {
        let mut bytes = [0; Self::LEN];
        for (half, bytes) in bytes.as_chunks_mut().0.iter_mut().enumerate() {
            *bytes = self.hash(2 * label as u8 + half as u8, data);
        }
        Self(bytes)
    }

    /// SipHash-2-4 of a byte and what follows.
    #[inline(never)]
    fn hash(&self, first: u8, data: &[&[u8]]) -> [u8; 8] {
        let mut hasher = SipHasher24::new_with_key(&self.0);
        hasher.write(&[first]);
        data.iter().for_each(|part| hasher.write(part));
        hasher.finish().to_le_bytes()
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(not shown)")
    }
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        self.0.ct_eq(&other.0).into()
    }
}

impl Eq for Key {}

/// What shows that a holder of a key has sent a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seal {
    /// Rises from frame to frame of one sender.
    pub counter: u64,
    /// Over channel, payload and counter.
    pub tag: [u8; 8],
}

impl Seal {
    /// Length in bytes.
    pub const LEN: usize = 16;

    /// The seal of a payload; `channel` as on the wire.
    pub(crate) fn new(key: &Key, channel: u8, payload: &[u8], counter: u64) -> Self {
        Self { counter, tag: key.hash(channel, &[payload, &counter.to_le_bytes()]) }
    }

    /// Whether both are equal, in a time that does not tell where they differ.
    pub(crate) fn is(&self, other: &Seal) -> bool {
        self.tag.ct_eq(&other.tag).into()
    }

    pub(crate) fn to_bytes(self) -> [u8; Self::LEN] {
        let mut bytes = [0; Self::LEN];
        bytes[..8].copy_from_slice(&self.counter.to_le_bytes());
        bytes[8..].copy_from_slice(&self.tag);
        bytes
    }

    pub(crate) fn from_bytes(bytes: &[u8; Self::LEN]) -> Self {
        let [counter, tag] = [0, 8].map(|at| core::array::from_fn(|i| bytes[at + i]));
        Self { counter: u64::from_le_bytes(counter), tag }
    }
}

/// A host's answer to a robot's challenge, on [`Channel::Open`](crate::Channel::Open).
///
/// ```text
/// session u32 LE | nonce 16 bytes | seal by the session's key, counter 0
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Open {
    /// The session of the host's hello.
    pub session: u32,
    /// The host's own.
    pub nonce: Nonce,
}

impl Open {
    /// Length in bytes, without the seal.
    pub const LEN: usize = 20;
}

/// A robot's answer to [`Open`], on [`Channel::Opened`](crate::Channel::Opened): the robot holds the key as well.
///
/// ```text
/// session u32 LE | boot 16 bytes | seal by the session's key, counter of the robot's last frame
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Opened {
    /// The host's session.
    pub session: u32,
    /// From which the robot's own key is derived.
    pub boot: Nonce,
    /// Every later frame of the robot has a higher one.
    pub counter: u64,
}

impl Opened {
    /// Length in bytes, without the seal.
    pub const LEN: usize = 20;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_its_authors() {
        // Aumasson and Bernstein, SipHash, 2012, appendix A.
        let key = Key::new(core::array::from_fn(|i| i as u8));
        let message: [u8; 14] = core::array::from_fn(|i| i as u8 + 1);
        let expected = 0xa129_ca61_49be_45e5_u64.to_le_bytes();
        for at in 0..=message.len() {
            let (head, tail) = message.split_at(at);
            assert_eq!(key.hash(0, &[head, tail]), expected, "in two pieces at {at}");
        }
    }

    #[test]
    fn keys_for_different_ends_and_data_differ_and_a_mask_comes_off() {
        let key = Key::new([7; 16]);
        let (a, b) = ([1; 16], [2; 16]);
        let (hello, other) = (b"a hello".as_slice(), b"another".as_slice());
        let all = [
            key.0,
            key.of_session(hello, &a, &b).0,
            key.of_session(hello, &b, &a).0,
            key.of_session(other, &a, &b).0,
            key.of_robot(&a).0,
            key.of_robot(&b).0,
            key.challenge(&a, 0),
            key.challenge(&a, 1),
            key.boot(&[0; 12], 0, &a),
            key.boot(&[0; 12], 1, &a),
            key.boot(&[1; 12], 0, &a),
            key.boot(&[0; 12], 0, &b),
            key.host_nonce(0),
            key.host_nonce(1),
            key.masked(&Key::new([0; 16]), 1).0,
            key.masked(&Key::new([0; 16]), 2).0,
        ];
        for (i, one) in all.iter().enumerate() {
            assert!(!all[i + 1..].contains(one), "{i}");
        }
        let new = Key::new(a);
        assert_ne!(key.masked(&new, 9), new);
        assert_eq!(key.masked(&key.masked(&new, 9), 9), new);
    }

    #[test]
    fn a_key_is_read_from_its_digits_only() {
        let key = Key::new(core::array::from_fn(|i| (0x0F + 16 * i) as u8));
        let digits = "0f1f2f3f4f5f6f7f8f9fafbfcfdfefff";
        assert_eq!(Key::from_hex(digits), Some(key));
        assert_eq!(Key::from_hex(&digits.to_uppercase()), Some(key));
        for wrong in ["", &digits[1..], &digits.replace('f', "g"), &digits.replacen("0f", "+f", 1)]
        {
            assert_eq!(Key::from_hex(wrong), None, "{wrong}");
        }
    }
}
