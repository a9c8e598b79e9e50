//! CRC-32/ISO-HDLC, as in Ethernet and zlib, half a byte at a time.

/// The remainder of each half byte: 64 bytes of flash, where a table for whole bytes takes a kilobyte.
static HALF_BYTES: [u32; 16] = {
    /// The polynomial, lowest power first.
    const POLYNOMIAL: u32 = 0xEDB8_8320;
    let mut table = [0; 16];
    let mut i = 0;
    while i < table.len() {
        let mut rest = i as u32;
        let mut bit = 0;
        while bit < 4 {
            rest = if rest & 1 == 1 { rest >> 1 ^ POLYNOMIAL } else { rest >> 1 };
            bit += 1;
        }
        table[i] = rest;
        i += 1;
    }
    table
};

/// A checksum being computed.
#[derive(Clone, Copy, Debug)]
pub struct Crc32(u32);

impl Crc32 {
    /// The checksum before any byte.
    pub const fn new() -> Self {
        Self(u32::MAX)
    }

    /// Adds these bytes.
    #[inline(never)]
    #[must_use]
    pub fn over(self, bytes: &[u8]) -> Self {
        Self(bytes.iter().fold(self.0, |rest, &byte| {
            let rest = rest ^ u32::from(byte);
            let rest = rest >> 4 ^ HALF_BYTES[(rest & 0xF) as usize];
            rest >> 4 ^ HALF_BYTES[(rest & 0xF) as usize]
        }))
    }

    /// The checksum of all bytes so far.
    pub const fn value(self) -> u32 {
        !self.0
    }
}

impl Default for Crc32 {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::Crc32;

    #[test]
    fn the_checksum_is_the_librarys_in_one_piece_and_in_two() {
        let library = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
        let bytes: [u8; 300] = core::array::from_fn(|i| (i * i + 3 * i) as u8);
        for len in 0..bytes.len() {
            let (head, tail) = bytes[..len].split_at(len / 3);
            assert_eq!(Crc32::new().over(head).over(tail).value(), library.checksum(&bytes[..len]));
        }
        assert_eq!(Crc32::new().over(b"123456789").value(), 0xCBF4_3926);
    }
}
