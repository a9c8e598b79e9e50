//! What every kind of bag gives: messages of channels, and what of it is not whole.

/// A stream of messages of one type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its topic.
    pub topic: String,
    /// The type of its messages, `sensor_msgs/msg/JointState`.
    pub schema: String,
    /// How they are encoded: `cdr` in ROS 2.
    pub encoding: String,
}

/// One message.
#[derive(Clone, Copy, Debug)]
pub struct Received<'a> {
    /// Its channel.
    pub channel: &'a Channel,
    /// When the recorder got it \[s\].
    pub log_time_s: f64,
    /// Its bytes.
    pub bytes: &'a [u8],
}

/// What is not whole in a bag, and where \[bytes from its beginning\].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Damage {
    /// The file ends within a record, or without an end.
    CutOff {
        /// Up to here it is whole.
        at: u64,
    },
    /// A chunk cannot be decompressed, or its checksum is wrong; its messages are left out.
    Chunk {
        /// Where it begins.
        at: u64,
    },
    /// A record contradicts itself, and is left out.
    Record {
        /// Where it begins.
        at: u64,
    },
    /// Rows of a table that contradict themselves, and are left out.
    Rows {
        /// How many.
        count: usize,
    },
    /// Chunks are compressed in a way that is not known; their messages are left out.
    Compression {
        /// Its name.
        name: String,
    },
}
