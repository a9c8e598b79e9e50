//! How long a message can get, computed from its schema while compiling.

use postcard_schema::schema::{DataModelType, DataModelVariant, NamedType, NamedValue};

use crate::{
    Channel, Event, FRAME_LEN_MAX, Hello, Message, NAME_LEN_MAX, PAYLOAD_LEN_MAX, Reply, Request,
    Telemetry, frame_len_max,
};

/// Longest postcard encoding of a type \[bytes\]. No message is longer, and some message is as long.
///
/// Does not compile for a type without a bound. Every string is taken for a [`Name`](crate::Name).
pub(crate) const fn postcard_len_max(ty: &NamedType) -> usize {
    match ty.ty {
        DataModelType::Unit | DataModelType::UnitStruct => 0,
        DataModelType::Bool | DataModelType::I8 | DataModelType::U8 => 1,
        DataModelType::I16 | DataModelType::U16 => varint_len(u16::MAX as u64),
        DataModelType::I32 | DataModelType::U32 => varint_len(u32::MAX as u64),
        DataModelType::I64 | DataModelType::U64 => varint_len(u64::MAX),
        DataModelType::F32 => 4,
        DataModelType::F64 => 8,
        DataModelType::String => varint_len(NAME_LEN_MAX as u64) + NAME_LEN_MAX,
        DataModelType::Option(inner) => 1 + postcard_len_max(inner),
        DataModelType::NewtypeStruct(inner) => postcard_len_max(inner),
        DataModelType::Tuple(items) | DataModelType::TupleStruct(items) => items_len_max(items),
        DataModelType::Struct(fields) => fields_len_max(fields),
        DataModelType::Enum(variants) => {
            let mut longest = 0;
            let mut i = 0;
            while i < variants.len() {
                let len = varint_len(i as u64)
                    + match variants[i].ty {
                        DataModelVariant::UnitVariant => 0,
                        DataModelVariant::NewtypeVariant(inner) => postcard_len_max(inner),
                        DataModelVariant::TupleVariant(items) => items_len_max(items),
                        DataModelVariant::StructVariant(fields) => fields_len_max(fields),
                    };
                longest = if len > longest { len } else { longest };
                i += 1;
            }
            longest
        }
        _ => panic!("a type on the wire has no bound on its length"),
    }
}

const fn items_len_max(items: &[&NamedType]) -> usize {
    let mut len = 0;
    let mut i = 0;
    while i < items.len() {
        len += postcard_len_max(items[i]);
        i += 1;
    }
    len
}

const fn fields_len_max(fields: &[&NamedValue]) -> usize {
    let mut len = 0;
    let mut i = 0;
    while i < fields.len() {
        len += postcard_len_max(fields[i].ty);
        i += 1;
    }
    len
}

/// Seven bits a byte.
const fn varint_len(value: u64) -> usize {
    let bits = (u64::BITS - value.leading_zeros()) as usize;
    if bits == 0 { 1 } else { bits.div_ceil(7) }
}

/// How long one kind of message can get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bound {
    /// The kind.
    pub channel: Channel,
    /// Longest payload \[bytes\].
    pub payload_len: usize,
    /// Longest frame on the wire, the final zero included \[bytes\].
    pub frame_len: usize,
}

impl Bound {
    /// Every kind of message, in the order of the channels' numbers.
    pub const ALL: [Bound; 5] = [
        Bound::new(Channel::Hello, Hello::LEN),
        Bound::new(Channel::Request, Request::LEN_MAX),
        Bound::new(Channel::Reply, Reply::LEN_MAX),
        Bound::new(Channel::Telemetry, Telemetry::LEN_MAX),
        Bound::new(Channel::Event, Event::LEN_MAX),
    ];

    const fn new(channel: Channel, payload_len: usize) -> Self {
        Self { channel, payload_len, frame_len: frame_len_max(payload_len) }
    }
}

// Every message fits into a frame.
const _: () = {
    let mut i = 0;
    while i < Bound::ALL.len() {
        assert!(Bound::ALL[i].channel as usize == i);
        assert!(Bound::ALL[i].payload_len <= PAYLOAD_LEN_MAX);
        assert!(Bound::ALL[i].frame_len <= FRAME_LEN_MAX);
        i += 1;
    }
};
