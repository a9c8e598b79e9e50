//! The fields of a record: numbers little endian, strings and bytes with their length before them.

/// Reads the fields of a record one after the other; `None` where the record ends too early.
#[derive(Clone, Debug)]
pub(super) struct Fields<'a>(pub &'a [u8]);

impl<'a> Fields<'a> {
    pub fn bytes(&mut self, count: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(count).ok()?)?;
        self.0 = rest;
        Some(taken)
    }

    fn number<const SIZE: usize>(&mut self) -> Option<[u8; SIZE]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    pub fn u16(&mut self) -> Option<u16> {
        self.number().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Option<u64> {
        self.number().map(u64::from_le_bytes)
    }

    pub fn string(&mut self) -> Option<String> {
        let length = self.u32()?;
        let bytes = self.bytes(u64::from(length))?;
        Some(String::from_utf8_lossy(bytes).into_owned())
    }

    /// An opcode and the content of its record.
    pub fn record(&mut self) -> Option<(u8, &'a [u8])> {
        let [opcode] = self.number()?;
        let length = self.u64()?;
        Some((opcode, self.bytes(length)?))
    }
}

/// A record to be written.
pub(super) fn record(opcode: u8, fields: &[&[u8]]) -> Vec<u8> {
    let length: usize = fields.iter().map(|field| field.len()).sum();
    let mut bytes = Vec::with_capacity(9 + length);
    bytes.push(opcode);
    bytes.extend_from_slice(&(length as u64).to_le_bytes());
    fields.iter().for_each(|field| bytes.extend_from_slice(field));
    bytes
}

/// A string as a field.
pub(super) fn string(text: &str) -> Vec<u8> {
    let mut bytes = (text.len() as u32).to_le_bytes().to_vec();
    bytes.extend_from_slice(text.as_bytes());
    bytes
}
