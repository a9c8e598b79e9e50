//! The longest encoding of a type, computed from its schema at compile time.

use postcard_schema::schema::{DataModelType, DataModelVariant, NamedType, NamedValue};

use crate::name::NAME_LEN_MAX;

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
