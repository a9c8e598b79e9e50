//! CDR, the encoding of ROS 2 messages: numbers aligned to their size, strings and sequences with their length before
//! them.
//!
//! ```text
//! 0x00, kind, 0x00, 0x00 | body        kind 0: big endian, 1: little endian; alignment counts from the body's start
//! ```
//!
//! A length is never trusted: what is read is at most what is there.

/// Why bytes are not the message that they should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CdrError {
    /// The bytes end before the message does.
    TooShort,
    /// The first four bytes name another encoding.
    OtherEncoding,
    /// A string is not UTF-8.
    NotText,
}

impl std::fmt::Display for CdrError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::TooShort => "it ends before its last field",
            Self::OtherEncoding => "its encoding is not plain CDR",
            Self::NotText => "a string in it is not UTF-8",
        })
    }
}

/// Reads the fields of a message one after the other.
#[derive(Clone, Debug)]
pub struct CdrReader<'a> {
    body: &'a [u8],
    at: usize,
    is_little_endian: bool,
}

impl<'a> CdrReader<'a> {
    /// A reader of a whole message.
    pub fn new(bytes: &'a [u8]) -> Result<Self, CdrError> {
        let (head, body) = bytes.split_at_checked(4).ok_or(CdrError::TooShort)?;
        let is_little_endian = match head[..2] {
            [0, 0] => false,
            [0, 1] => true,
            _ => return Err(CdrError::OtherEncoding),
        };
        Ok(Self { body, at: 0, is_little_endian })
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], CdrError> {
        let end = self.at.checked_add(count).ok_or(CdrError::TooShort)?;
        let taken = self.body.get(self.at..end).ok_or(CdrError::TooShort)?;
        self.at = end;
        Ok(taken)
    }

    /// A number of so many bytes, aligned to its size, little endian.
    fn number<const SIZE: usize>(&mut self) -> Result<[u8; SIZE], CdrError> {
        self.at = self.at.next_multiple_of(SIZE);
        let mut bytes = [0; SIZE];
        bytes.copy_from_slice(self.take(SIZE)?);
        if !self.is_little_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// A number of 32 bits without a sign.
    pub fn u32(&mut self) -> Result<u32, CdrError> {
        self.number().map(u32::from_le_bytes)
    }

    /// A number of 32 bits.
    pub fn i32(&mut self) -> Result<i32, CdrError> {
        self.number().map(i32::from_le_bytes)
    }

    /// A floating point number of 32 bits.
    pub fn f32(&mut self) -> Result<f32, CdrError> {
        self.number().map(f32::from_le_bytes)
    }

    /// A floating point number of 64 bits.
    pub fn f64(&mut self) -> Result<f64, CdrError> {
        self.number().map(f64::from_le_bytes)
    }

    /// So many of them.
    pub fn f64s<const COUNT: usize>(&mut self) -> Result<[f64; COUNT], CdrError> {
        let mut numbers = [0.0; COUNT];
        for number in &mut numbers {
            *number = self.f64()?;
        }
        Ok(numbers)
    }

    /// A string; its length counts the zero at its end.
    pub fn string(&mut self) -> Result<&'a str, CdrError> {
        let length = self.u32()? as usize;
        let bytes = self.take(length)?;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        std::str::from_utf8(text).map_err(|_| CdrError::NotText)
    }

    /// The length of a sequence whose elements have at least so many bytes each.
    pub fn length(&mut self, element_bytes: usize) -> Result<usize, CdrError> {
        let length = self.u32()? as usize;
        let left = self.body.len().saturating_sub(self.at);
        if length > left / element_bytes.max(1) { Err(CdrError::TooShort) } else { Ok(length) }
    }

    /// A sequence of numbers.
    pub fn f64_sequence(&mut self) -> Result<Vec<f64>, CdrError> {
        let length = self.length(8)?;
        (0..length).map(|_| self.f64()).collect()
    }
}

/// Writes the fields of a message, little endian.
#[derive(Clone, Debug)]
pub struct CdrWriter {
    bytes: Vec<u8>,
}

/// The bytes before the body.
const HEAD: usize = 4;

impl Default for CdrWriter {
    fn default() -> Self {
        Self { bytes: vec![0, 1, 0, 0] }
    }
}

impl CdrWriter {
    fn number(&mut self, bytes: &[u8]) {
        let body = self.bytes.len() - HEAD;
        self.bytes.resize(HEAD + body.next_multiple_of(bytes.len()), 0);
        self.bytes.extend_from_slice(bytes);
    }

    /// A number of 32 bits without a sign, as lengths are.
    pub fn u32(&mut self, value: u32) {
        self.number(&value.to_le_bytes());
    }

    /// A floating point number of 32 bits.
    pub fn f32(&mut self, value: f32) {
        self.number(&value.to_le_bytes());
    }

    /// A floating point number of 64 bits.
    pub fn f64(&mut self, value: f64) {
        self.number(&value.to_le_bytes());
    }

    /// A string.
    pub fn string(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(0);
    }

    /// A sequence of numbers.
    pub fn f64_sequence(&mut self, numbers: &[f64]) {
        self.u32(numbers.len() as u32);
        numbers.iter().for_each(|number| self.f64(*number));
    }

    /// The whole message.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_from_the_body_on_in_both_byte_orders() {
        let mut writer = CdrWriter::default();
        writer.u32(7);
        writer.f64(-1.5);
        writer.string("ab");
        writer.f64_sequence(&[2.0]);
        let bytes = writer.finish();
        // 4 of the head, 4 of the number, 4 to align, 8; 4 + 3 of the string; 1 to align, 4; 4 to align, 8.
        assert_eq!(bytes.len(), 4 + 4 + 4 + 8 + 4 + 3 + 1 + 4 + 4 + 8);
        let mut reader = CdrReader::new(&bytes).unwrap();
        assert_eq!((reader.u32(), reader.f64(), reader.string()), (Ok(7), Ok(-1.5), Ok("ab")));
        assert_eq!(reader.f64_sequence(), Ok(vec![2.0]));
        assert_eq!(reader.u32(), Err(CdrError::TooShort));
        let mut reader = CdrReader::new(&[0, 0, 0, 0, 0, 0, 1, 2]).unwrap();
        assert_eq!(reader.i32(), Ok(258));
    }

    #[test]
    fn a_length_beyond_the_end_reserves_nothing() {
        let mut reader = CdrReader::new(&[0, 1, 0, 0, 255, 255, 255, 255, 0, 0, 0, 0]).unwrap();
        assert_eq!(reader.clone().f64_sequence(), Err(CdrError::TooShort));
        assert_eq!(reader.string(), Err(CdrError::TooShort));
        assert_eq!(CdrReader::new(&[0, 7, 0, 0]).unwrap_err(), CdrError::OtherEncoding);
    }
}
