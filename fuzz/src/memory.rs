//! How much memory an input takes: an allocator that counts, and a bound in proportion to the input.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static LIVE: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

struct Counting;

fn note(change: isize) {
    LIVE.set(LIVE.get() + change);
    PEAK.set(PEAK.get().max(LIVE.get()));
}

// SAFETY: the system's allocator does the work, with the same arguments; counting does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size() as isize);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        note(-(layout.size() as isize));
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size as isize - layout.size() as isize);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// Whatever the input: the parsers' tables, and messages of errors \[bytes\].
const BASE: usize = 1 << 20;

/// At most this many bytes for each byte of an input: the tree of a TOML file takes the most.
const PER_BYTE: usize = 2000;

/// Runs a target on an input of this length, and holds what it takes at a time to a bound in proportion.
///
/// # Panics
/// If it takes more.
pub fn in_proportion(len: usize, run: impl FnOnce()) {
    let before = LIVE.get();
    PEAK.set(before);
    run();
    let took = usize::try_from(PEAK.get() - before).unwrap_or(0);
    let most = BASE + PER_BYTE * len;
    assert!(took <= most, "{len} bytes of input took {took} bytes of memory, more than {most}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_out_of_proportion_is_found() {
        in_proportion(1000, || drop(vec![0_u8; 2_000_000]));
        let too_much = || in_proportion(10, || drop(vec![0_u8; 2_000_000]));
        assert!(std::panic::catch_unwind(too_much).is_err());
    }
}
