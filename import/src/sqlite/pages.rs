//! The pages of an SQLite file, and the rows of a table in them.
//!
//! ```text
//! page 1: head of the file (100 bytes), then as every page
//! leaf of a table       0x0d | .. | count | .. | place of each cell ... | cells: size, row id, record, overflow page
//! page above leaves     0x05 | .. | count | .. | last page | places ... | cells: page, row id
//! overflow page         next page | more of a record
//! ```
//!
//! Every page belongs to one place in one table. So a walk may read as many pages as the file has: a file whose pages point
//! at each other ends a walk, and does not keep it for ever.

use std::io::{self, Read, Seek, SeekFrom};

use super::row::varint;
use crate::received::Damage;

/// What a file begins with.
pub const MAGIC: &[u8; 16] = b"SQLite format 3\0";

/// The file's own head.
const HEAD: usize = 100;
const LEAF: u8 = 0x0d;
const ABOVE_LEAVES: u8 = 0x05;
/// A table of 2^64 rows has no more levels.
const DEPTH_MAX: usize = 20;
/// A longer record is none of a robot's \[bytes\].
const RECORD_BYTES_MAX: u64 = 256 << 20;

/// A file, page by page.
#[derive(Debug)]
pub(super) struct Pages<F> {
    file: F,
    page_bytes: usize,
    /// Without what each page keeps for others.
    usable: usize,
    /// Whole pages of the file.
    count: u64,
    /// So many may still be read in this walk.
    left: u64,
    /// What was found to be wrong.
    pub damage: Vec<Damage>,
    /// The file has fewer pages than it says: what is missing then is no corruption.
    pub is_cut_off: bool,
}

impl<F: Read + Seek> Pages<F> {
    /// The pages of a file; `None` if it is no SQLite file.
    pub fn open(mut file: F) -> io::Result<Option<Self>> {
        let bytes = file.seek(SeekFrom::End(0))?;
        file.rewind()?;
        let mut head = Vec::new();
        (&mut file).take(HEAD as u64).read_to_end(&mut head)?;
        if head.len() < HEAD || !head.starts_with(MAGIC) {
            return Ok(None);
        }
        // 1 stands for 65536.
        let page_bytes = match usize::from(u16::from_be_bytes([head[16], head[17]])) {
            1 => 1 << 16,
            bytes => bytes,
        };
        let usable = page_bytes.saturating_sub(usize::from(head[20]));
        if !page_bytes.is_power_of_two() || page_bytes < 512 || usable < 480 {
            return Ok(None);
        }
        let count = bytes / page_bytes as u64;
        let said = u64::from(u32::from_be_bytes([head[28], head[29], head[30], head[31]]));
        // The file says its size only if its last writer did.
        let is_cut_off = said > count && head[24..28] == head[92..96];
        let damage = if is_cut_off { vec![Damage::CutOff { at: bytes }] } else { Vec::new() };
        Ok(Some(Self { file, page_bytes, usable, count, left: 0, damage, is_cut_off }))
    }

    /// Reads a page, 1 is the first; `false` if it is not in the file, or more pages were read than there are.
    fn read(&mut self, number: u32, page: &mut Vec<u8>) -> io::Result<bool> {
        let number = u64::from(number);
        if number == 0 || number > self.count || self.left == 0 {
            return Ok(false);
        }
        self.left -= 1;
        page.resize(self.page_bytes, 0);
        self.file.seek(SeekFrom::Start((number - 1) * self.page_bytes as u64))?;
        self.file.read_exact(page)?;
        Ok(true)
    }

    /// Notes that a page, or something on it, contradicts itself.
    fn contradicts(&mut self, number: u32) {
        if !self.is_cut_off {
            let at = u64::from(number).saturating_sub(1) * self.page_bytes as u64;
            self.damage.push(Damage::Record { at });
        }
    }

    /// Gives every row of a table to `each`: its id, and its record.
    pub fn rows(&mut self, root: u32, each: &mut impl FnMut(i64, &[u8])) -> io::Result<()> {
        self.left = self.count;
        self.below(root, 0, each)
    }

    fn below(
        &mut self,
        number: u32,
        depth: usize,
        each: &mut impl FnMut(i64, &[u8]),
    ) -> io::Result<()> {
        let mut page = Vec::new();
        if depth > DEPTH_MAX || !self.read(number, &mut page)? {
            self.contradicts(number);
            return Ok(());
        }
        let head = if number == 1 { HEAD } else { 0 };
        let (kind, count) = (page[head], u16_at(&page, head + 3).map_or(0, usize::from));
        let first = match kind {
            LEAF => head + 8,
            ABOVE_LEAVES => head + 12,
            _ => {
                self.contradicts(number);
                return Ok(());
            }
        };
        let mut record = Vec::new();
        for index in 0..count {
            let cell = self.cell(&page, first, count, index);
            let child = cell.and_then(u32_of).filter(|_| kind == ABOVE_LEAVES);
            match (cell, child) {
                (Some(_), Some(child)) => self.below(child, depth + 1, each)?,
                (Some(cell), None) if kind == LEAF => match self.record(cell, &mut record)? {
                    Some(id) => each(id, &record),
                    None => self.contradicts(number),
                },
                _ => self.contradicts(number),
            }
        }
        if kind == ABOVE_LEAVES
            && let Some(last) = page.get(head + 8..).and_then(u32_of)
        {
            self.below(last, depth + 1, each)?;
        }
        Ok(())
    }

    /// The cell of this number of a page whose first of so many places is there.
    fn cell<'p>(
        &self,
        page: &'p [u8],
        first: usize,
        count: usize,
        index: usize,
    ) -> Option<&'p [u8]> {
        let at = usize::from(u16_at(page, first + 2 * index)?);
        let cell = page.get(at..self.usable)?;
        (at >= first + 2 * count).then_some(cell)
    }

    /// Gives every row of every table to `each` that is whole, page by page: of a file that is cut off, the pages above the leaves
    /// may be missing.
    pub fn all_rows(&mut self, each: &mut impl FnMut(i64, &[u8])) -> io::Result<()> {
        let (mut page, mut record) = (Vec::new(), Vec::new());
        // Each page once as a leaf, and once as a part of a record.
        self.left = 2 * self.count;
        for number in 2..=self.count.min(u64::from(u32::MAX)) {
            if !self.read(number as u32, &mut page)? {
                break;
            }
            let count = u16_at(&page, 3).filter(|_| page[0] == LEAF).map_or(0, usize::from);
            for index in 0..count {
                let Some(cell) = self.cell(&page, 8, count, index) else { break };
                if let Some(id) = self.record(cell, &mut record)? {
                    each(id, &record);
                }
            }
        }
        Ok(())
    }

    /// The id of a leaf's cell, and its record with what of it is on overflow pages; `None` if it is not whole.
    fn record(&mut self, cell: &[u8], record: &mut Vec<u8>) -> io::Result<Option<i64>> {
        record.clear();
        let Some((size, id, rest)) = varint(cell).and_then(|(size, rest)| {
            let (id, rest) = varint(rest)?;
            Some((size, id, rest))
        }) else {
            return Ok(None);
        };
        if size > RECORD_BYTES_MAX.min(self.count * self.page_bytes as u64) {
            return Ok(None);
        }
        let size = size as usize;
        let local = self.local(size);
        let Some((here, after)) = rest.split_at_checked(local) else { return Ok(None) };
        record.extend_from_slice(here);
        let mut next = if local < size { u32_of(after) } else { None };
        let mut page = Vec::new();
        while record.len() < size {
            let Some(number) = next else { return Ok(None) };
            if !self.read(number, &mut page)? {
                return Ok(None);
            }
            next = u32_of(&page);
            let more = (size - record.len()).min(self.usable - 4);
            record.extend_from_slice(&page[4..4 + more]);
        }
        Ok(Some(id as i64))
    }

    /// So many bytes of a record of this size are on its leaf. The rule is the format's own.
    fn local(&self, size: usize) -> usize {
        let most = self.usable - 35;
        if size <= most {
            return size;
        }
        let least = (self.usable - 12) * 32 / 255 - 23;
        let filled = least + (size - least) % (self.usable - 4);
        if filled <= most { filled } else { least }
    }
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|bytes| u16::from_be_bytes(*bytes))
}

fn u32_of(bytes: &[u8]) -> Option<u32> {
    bytes.first_chunk().map(|bytes| u32::from_be_bytes(*bytes))
}
