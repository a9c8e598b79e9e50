//! The rows of a table: a record has the types of its values first, then the values.
//!
//! ```text
//! length of the head | type | type | ... | value | value | ...      lengths and types are varints
//! ```

/// A value of a row; other types are in no bag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value<'a> {
    Null,
    Integer(i64),
    Text(&'a [u8]),
    Blob(&'a [u8]),
}

/// A number in one to nine bytes, seven bits each, the high bit says that it goes on; what is left.
pub(super) fn varint(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let mut number = 0;
    for (index, byte) in bytes.iter().take(9).enumerate() {
        // The ninth byte has all its bits.
        if index == 8 {
            return Some((number << 8 | u64::from(*byte), &bytes[9..]));
        }
        number = number << 7 | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            return Some((number, &bytes[index + 1..]));
        }
    }
    None
}

/// The values of a record; `None` if it contradicts itself.
pub(super) fn values(record: &[u8]) -> Option<Vec<Value<'_>>> {
    let (head_len, after) = varint(record)?;
    let head_len = usize::try_from(head_len).ok()?;
    let mut types = record.get(record.len() - after.len()..head_len)?;
    let mut body = &record[head_len..];
    let mut values = Vec::new();
    while !types.is_empty() {
        let (kind, rest) = varint(types)?;
        types = rest;
        let length = match kind {
            0 | 8 | 9 => 0,
            1..=4 => kind,
            5 => 6,
            6 | 7 => 8,
            10 | 11 => return None,
            _ => (kind - 12) / 2,
        };
        let (bytes, rest) = body.split_at_checked(usize::try_from(length).ok()?)?;
        body = rest;
        values.push(match kind {
            // A floating point number is in no table of a bag.
            0 | 7 => Value::Null,
            8 => Value::Integer(0),
            9 => Value::Integer(1),
            1..=6 => Value::Integer(integer(bytes)),
            _ if kind % 2 == 0 => Value::Blob(bytes),
            _ => Value::Text(bytes),
        });
    }
    Some(values)
}

/// A number with a sign, big endian, of one to eight bytes.
fn integer(bytes: &[u8]) -> i64 {
    let sign = if bytes.first().is_some_and(|byte| byte & 0x80 != 0) { -1 } else { 0 };
    bytes.iter().fold(sign, |number, byte| number << 8 | i64::from(*byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_length_are_read_with_their_signs() {
        assert_eq!(varint(&[0x7f, 1]), Some((127, &[1][..])));
        assert_eq!(varint(&[0x81, 0x00]), Some((128, &[][..])));
        assert_eq!(varint(&[0xff; 9]), Some((u64::MAX, &[][..])));
        assert_eq!(varint(&[0x80; 8]), None);
        // A head of 8 bytes: null, 1 byte, 2, 3, 6, one, text of 2, blob of 1 byte.
        let record = [
            9, 0, 1, 2, 3, 5, 9, 17, 14, 0xff, 0x01, 0x00, 0x80, 0, 0, 0, 0, 0, 0, 1, 0, b'a',
            b'b', 7,
        ];
        let expected = [
            Value::Null,
            Value::Integer(-1),
            Value::Integer(256),
            Value::Integer(-(1 << 23)),
            Value::Integer(256),
            Value::Integer(1),
            Value::Text(b"ab"),
            Value::Blob(&[7]),
        ];
        assert_eq!(values(&record).unwrap(), expected);
        for end in 0..record.len() {
            assert_eq!(values(&record[..end]), None, "{end}");
        }
    }
}
