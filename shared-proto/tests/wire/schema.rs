//! Reads postcard by its schema alone, knowing nothing of the Rust types: as another language would.

use std::collections::BTreeSet;

use postcard_schema::Schema;
use postcard_schema::schema::{DataModelType, DataModelVariant, NamedType};
use shared_proto::{Channel, Event, Reply, Request, Telemetry};

/// The schema of a channel; the hello has none.
pub fn of_channel(channel: Channel) -> Option<&'static NamedType> {
    match channel {
        Channel::Hello | Channel::Open | Channel::Opened => None,
        Channel::Request => Some(Request::SCHEMA),
        Channel::Reply => Some(Reply::SCHEMA),
        Channel::Telemetry => Some(Telemetry::SCHEMA),
        Channel::Event => Some(Event::SCHEMA),
    }
}

/// Every variant of every enum below a type, `State::Idle`.
pub fn variants(ty: &NamedType, found: &mut BTreeSet<String>) {
    match ty.ty {
        DataModelType::Option(inner) => {
            found.insert(format!("Option<{}>::None", inner.name));
            found.insert(format!("Option<{}>::Some", inner.name));
            variants(inner, found);
        }
        DataModelType::NewtypeStruct(inner) => variants(inner, found),
        DataModelType::Tuple(items) | DataModelType::TupleStruct(items) => {
            items.iter().for_each(|item| variants(item, found));
        }
        DataModelType::Struct(fields) => fields.iter().for_each(|f| variants(f.ty, found)),
        DataModelType::Enum(all) => {
            for variant in *all {
                found.insert(format!("{}::{}", ty.name, variant.name));
                match variant.ty {
                    DataModelVariant::UnitVariant => {}
                    DataModelVariant::NewtypeVariant(inner) => variants(inner, found),
                    DataModelVariant::TupleVariant(items) => {
                        items.iter().for_each(|item| variants(item, found));
                    }
                    DataModelVariant::StructVariant(fields) => {
                        fields.iter().for_each(|f| variants(f.ty, found));
                    }
                }
            }
        }
        _ => {}
    }
}

/// Reads one value, notes the variants that it meets, and returns the bytes behind it.
pub fn walk<'b>(ty: &NamedType, bytes: &'b [u8], met: &mut BTreeSet<String>) -> &'b [u8] {
    match ty.ty {
        DataModelType::Bool => {
            assert!(bytes[0] <= 1, "a bool of {}", bytes[0]);
            &bytes[1..]
        }
        DataModelType::U8 | DataModelType::I8 => &bytes[1..],
        DataModelType::U16 | DataModelType::I16 => varint(bytes, 16).1,
        DataModelType::U32 | DataModelType::I32 => varint(bytes, 32).1,
        DataModelType::U64 | DataModelType::I64 => varint(bytes, 64).1,
        DataModelType::F64 => &bytes[8..],
        DataModelType::String => {
            let (len, rest) = varint(bytes, 64);
            let (text, rest) = rest.split_at(len as usize);
            std::str::from_utf8(text).expect("UTF-8");
            rest
        }
        DataModelType::Option(inner) => match bytes[0] {
            0 => {
                met.insert(format!("Option<{}>::None", inner.name));
                &bytes[1..]
            }
            1 => {
                met.insert(format!("Option<{}>::Some", inner.name));
                walk(inner, &bytes[1..], met)
            }
            tag => panic!("an option of {tag}"),
        },
        DataModelType::NewtypeStruct(inner) => walk(inner, bytes, met),
        DataModelType::Tuple(items) | DataModelType::TupleStruct(items) => {
            items.iter().fold(bytes, |rest, item| walk(item, rest, met))
        }
        DataModelType::Struct(fields) => {
            fields.iter().fold(bytes, |rest, field| walk(field.ty, rest, met))
        }
        DataModelType::Enum(all) => {
            let (tag, rest) = varint(bytes, 32);
            let variant = all[tag as usize];
            met.insert(format!("{}::{}", ty.name, variant.name));
            match variant.ty {
                DataModelVariant::UnitVariant => rest,
                DataModelVariant::NewtypeVariant(inner) => walk(inner, rest, met),
                DataModelVariant::TupleVariant(items) => {
                    items.iter().fold(rest, |rest, item| walk(item, rest, met))
                }
                DataModelVariant::StructVariant(fields) => {
                    fields.iter().fold(rest, |rest, field| walk(field.ty, rest, met))
                }
            }
        }
        other => panic!("{other:?} is not used on the wire"),
    }
}

/// Seven bits a byte, least significant first, the top bit set on all but the last.
fn varint(bytes: &[u8], bits: u32) -> (u64, &[u8]) {
    let mut value = 0_u64;
    for (i, byte) in bytes.iter().enumerate() {
        value |= u64::from(byte & 0x7F) << (7 * i);
        if byte & 0x80 == 0 {
            assert!(bits == 64 || value >> bits == 0, "{value} has more than {bits} bits");
            return (value, &bytes[i + 1..]);
        }
    }
    panic!("the bytes end inside a number");
}
