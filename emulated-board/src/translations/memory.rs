//! A stretch of a board's memory, and a copy of what it held.

use std::ops::Range;

use rigless::emulator::Processor;

/// The emulator's pages \[B\].
const PAGE: usize = 4096;

#[derive(Clone)]
#[repr(C, align(4096))]
struct Page([u8; PAGE]);

/// Memory of the run that a processor has mapped.
pub(super) struct Mapping {
    start: u64,
    /// The run's bytes. They are read only in the methods of the processor that has mapped them, between its own calls.
    host: *mut u8,
    writable: bool,
    copy: Vec<Page>,
    /// The copy is what the memory held when the processor last knew it.
    is_copied: bool,
}

// SAFETY: the pointer is used only through a processor that is sent along, under the promise of `Processor::map`.
unsafe impl Send for Mapping {}

impl Mapping {
    /// # Safety
    ///
    /// As [`Processor::map`], until [`Mapping::map_copy`] or the mapping is dropped.
    pub(super) unsafe fn of(start: u64, length: u64, host: *mut u8, writable: bool) -> Self {
        let pages = usize::try_from(length).expect("it is in memory") / PAGE;
        let copy = vec![Page([0; PAGE]); pages];
        Self { start, host, writable, copy, is_copied: false }
    }

    /// This memory in place of what was there before, whose copy is kept if it is as long.
    pub(super) fn after(mut self, before: Option<Self>) -> Self {
        if let Some(before) = before
            && before.copy.len() == self.copy.len()
        {
            (self.copy, self.is_copied) = (before.copy, before.is_copied);
        }
        self
    }

    fn page(&self, index: usize) -> &[u8; PAGE] {
        // SAFETY: the page lies in the mapped memory, which lives; nobody writes it while a method of the processor runs.
        unsafe { &*self.host.add(index * PAGE).cast() }
    }

    pub(super) fn copy(&mut self) {
        for index in 0..self.copy.len() {
            let page = *self.page(index);
            self.copy[index].0 = page;
        }
        self.is_copied = true;
    }

    /// Where memory and copy differ; everywhere, if there is no copy.
    pub(super) fn pages_that_differ(&self) -> impl Iterator<Item = Range<u64>> {
        let differs = |index: usize| !self.is_copied || self.copy[index].0 != *self.page(index);
        (0..self.copy.len()).filter(move |index| differs(*index)).map(|index| {
            let start = self.start + (index * PAGE) as u64;
            start..start + PAGE as u64
        })
    }

    /// Maps the copy in place of the memory, which may be freed then.
    pub(super) fn map_copy(&mut self, processor: &mut dyn Processor) {
        self.host = self.copy.as_mut_ptr().cast();
        let length = (self.copy.len() * PAGE) as u64;
        // SAFETY: the copy's pages are whole and aligned, it is dropped after the processor, and nothing runs meanwhile.
        unsafe { processor.map(self.start, length, self.host, self.writable) };
    }
}
