//! What the emulator has translated of an image, kept over resets and from one life of a board to the next.
//!
//! The emulator runs code that it has translated to the desktop's, and drops all translations at a reset and at the end of a
//! run. Translating an image anew takes it twenty times longer than a boot: most of what the board's tests took. What was
//! translated stays true as long as the bytes that it came from do, so it is enough to drop the translations of what changed.
//!
//! With an MPU the emulator drops all whenever the firmware sets the MPU up, which every boot does. Such a core is left alone.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use rigless::emulator::{
    Access, BitAlias, CoreBus, DataModel, Error, Exit, HaltReason, HostCall, Processor,
    ProcessorConstructor, Queued,
};
use rigless::soc::{Endian, Width};
use rigless::time::VirtualNanos;

use self::memory::Mapping;

mod memory;

/// So many cores are kept when no board uses them: as many as there are boards at once.
const KEPT_MAX: usize = 4;

/// Cores that no board uses, in the state of one that was just made, without watches.
static KEPT: Mutex<Vec<Core>> = Mutex::new(Vec::new());

/// Makes cores as `make` does, or takes one that another board has left; all of them must be of one kind.
pub(crate) fn kept(make: ProcessorConstructor) -> ProcessorConstructor {
    Arc::new(move |endian| {
        let left = KEPT.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let core = left.map_or_else(|| Core::made(&make, endian), Ok)?;
        Ok(Box::new(Used { core: Some(core), routed: Vec::new(), breakpoints: Vec::new() }))
    })
}

/// The next boards translate everything anew.
pub fn forget_translations() {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner).clear();
}

/// A core with what it has translated.
struct Core {
    processor: Box<dyn Processor>,
    /// Another one, without memory: what a reset does to a state is asked of it.
    twin: Box<dyn Processor>,
    /// Its state out of the factory.
    made: Vec<u8>,
    /// The memory, by its first address. Declared after the processor, and so dropped after it.
    memory: BTreeMap<u64, Mapping>,
    /// The memory may have changed without the processor's knowledge since it was last copied.
    may_differ: bool,
}

impl Core {
    fn made(make: &ProcessorConstructor, endian: Endian) -> Result<Self, Error> {
        let processor = make(endian)?;
        let (twin, made) = (make(endian)?, processor.save());
        Ok(Self { processor, twin, made, memory: BTreeMap::new(), may_differ: false })
    }

    /// Notes what the memory holds now, before it changes without the processor's knowledge.
    fn copy_memory(&mut self) {
        if !self.may_differ {
            self.memory.values_mut().for_each(Mapping::copy);
            self.may_differ = true;
        }
    }

    /// Drops what was translated from bytes that are others now.
    fn drop_what_differs(&mut self) {
        if std::mem::take(&mut self.may_differ) {
            for mapping in self.memory.values() {
                for page in mapping.pages_that_differ() {
                    self.processor.ask(Queued::Invalidate(page.start, page.end));
                }
            }
        }
    }

    /// As [`Processor::reset`], but for the translations; false if it cannot be done.
    fn reset(&mut self) -> bool {
        if self.twin.load(&self.processor.save()).is_err() {
            return false;
        }
        self.twin.reset();
        self.copy_memory();
        let done = self.processor.load(&self.twin.save()).is_ok();
        self.processor.take_reset_request();
        done
    }
}

/// A core of a board that runs.
struct Used {
    /// There until it is left.
    core: Option<Core>,
    /// Pages and instructions that are watched.
    routed: Vec<u64>,
    breakpoints: Vec<u64>,
}

impl Used {
    fn core(&mut self) -> &mut Core {
        self.core.as_mut().expect("there until it is dropped")
    }

    fn processor(&self) -> &dyn Processor {
        &*self.core.as_ref().expect("there until it is dropped").processor
    }

    fn processor_mut(&mut self) -> &mut dyn Processor {
        &mut *self.core().processor
    }
}

/// The board is switched off: its memory is freed after this, and its core waits for the next board.
impl Drop for Used {
    fn drop(&mut self) {
        let Some(mut core) = self.core.take() else { return };
        for page in self.routed.drain(..) {
            core.processor.ask(Queued::Unroute(page));
        }
        for address in self.breakpoints.drain(..) {
            core.processor.remove_breakpoint(address);
        }
        core.processor.take_reset_request();
        core.copy_memory();
        let Core { processor, memory, .. } = &mut core;
        memory.values_mut().for_each(|mapping| mapping.map_copy(&mut **processor));
        let as_new = core.processor.load(&core.made).is_ok();
        let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if as_new && !std::thread::panicking() && kept.len() < KEPT_MAX {
            kept.push(core);
        }
    }
}

impl fmt::Debug for Used {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.core.as_ref().map(|core| &core.processor), f)
    }
}

/// Notes what is asked of a processor.
fn note(routed: &mut Vec<u64>, queued: Queued) {
    match queued {
        Queued::Route(page) => routed.push(page),
        Queued::Unroute(page) => routed.retain(|other| *other != page),
        Queued::Line(..) | Queued::Invalidate(..) | Queued::Return => {}
    }
}

/// A run's bus; what it asks of the processor is noted.
struct NotingBus<'a> {
    bus: &'a mut dyn CoreBus,
    routed: &'a mut Vec<u64>,
}

impl CoreBus for NotingBus<'_> {
    fn access(&mut self, access: Access, from_code: bool) -> Option<u64> {
        self.bus.access(access, from_code)
    }

    fn time(&self, instructions: u64) -> VirtualNanos {
        self.bus.time(instructions)
    }

    fn queued(&mut self) -> Vec<Queued> {
        let queued = self.bus.queued();
        queued.iter().for_each(|queued| note(self.routed, *queued));
        queued
    }

    fn carry_on(&mut self, instructions: u64, event: Option<VirtualNanos>) -> Option<u32> {
        self.bus.carry_on(instructions, event)
    }

    fn stops_before(&mut self, access: &Access) -> bool {
        self.bus.stops_before(access)
    }

    fn send_trace(&mut self, bytes: &[u8]) {
        self.bus.send_trace(bytes);
    }
}

/// Everything but `run`, `ask`, `map`, `reset` and the breakpoints is the processor's own.
impl Processor for Used {
    fn run(&mut self, budget: u32, bus: &mut dyn CoreBus) -> (Exit, u64) {
        let core = self.core.as_mut().expect("there until it is dropped");
        core.drop_what_differs();
        core.processor.run(budget, &mut NotingBus { bus, routed: &mut self.routed })
    }

    fn ask(&mut self, queued: Queued) {
        note(&mut self.routed, queued);
        self.processor_mut().ask(queued);
    }

    unsafe fn map(&mut self, start: u64, length: u64, host: *mut u8, writable: bool) {
        let core = self.core();
        // SAFETY: the caller promises that the memory outlives this value, and `drop` maps other memory in its place.
        unsafe { core.processor.map(start, length, host, writable) };
        // SAFETY: as above.
        let mapping = unsafe { Mapping::of(start, length, host, writable) };
        let before = core.memory.remove(&start);
        core.memory.insert(start, mapping.after(before));
        core.may_differ = true;
    }

    fn reset(&mut self) {
        if !self.core().reset() {
            self.processor_mut().reset();
        }
    }

    fn add_breakpoint(&mut self, address: u64) -> bool {
        let added = self.processor_mut().add_breakpoint(address);
        if added {
            self.breakpoints.push(address);
        }
        added
    }

    fn remove_breakpoint(&mut self, address: u64) {
        if let Some(place) = self.breakpoints.iter().position(|other| *other == address) {
            self.breakpoints.swap_remove(place);
        }
        self.processor_mut().remove_breakpoint(address);
    }

    fn retired(&self) -> u64 {
        self.processor().retired()
    }

    fn maps(&self, start: u64, length: u64) -> bool {
        self.processor().maps(start, length)
    }

    fn page_size(&self) -> u64 {
        self.processor().page_size()
    }

    fn boot(&mut self, table: u64, read: &dyn Fn(u64, Width) -> Option<u64>) {
        self.processor_mut().boot(table, read);
    }

    fn take_reset_request(&mut self) -> bool {
        self.processor_mut().take_reset_request()
    }

    fn next_event(&self) -> Option<VirtualNanos> {
        self.processor().next_event()
    }

    fn on_event(&mut self, now: VirtualNanos) {
        self.processor_mut().on_event(now);
    }

    fn waiting(&self) -> bool {
        self.processor().waiting()
    }

    fn pc(&self) -> u64 {
        self.processor().pc()
    }

    fn pass_breakpoint(&mut self, address: u64) {
        self.processor_mut().pass_breakpoint(address);
    }

    fn attach_debugger(&mut self, attached: bool) {
        self.processor_mut().attach_debugger(attached);
    }

    fn hold_interrupts(&mut self, held: bool) {
        self.processor_mut().hold_interrupts(held);
    }

    fn gdb_register(&self, number: usize) -> Option<Vec<u8>> {
        self.processor().gdb_register(number)
    }

    fn set_gdb_register(&mut self, number: usize, bytes: &[u8]) -> bool {
        self.processor_mut().set_gdb_register(number, bytes)
    }

    fn debugger_access(
        &mut self,
        write: Option<u64>,
        address: u64,
        width: Width,
        now: VirtualNanos,
    ) -> Option<u64> {
        self.processor_mut().debugger_access(write, address, width, now)
    }

    fn take_debugger_trace(&mut self) -> Vec<u8> {
        self.processor_mut().take_debugger_trace()
    }

    fn target_xml(&self) -> &'static str {
        self.processor().target_xml()
    }

    fn data_model(&self) -> DataModel {
        self.processor().data_model()
    }

    fn byte_order(&self, address: u64) -> Endian {
        self.processor().byte_order(address)
    }

    fn save(&self) -> Vec<u8> {
        self.processor().save()
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.processor_mut().load(bytes)
    }

    fn monitor_command(&mut self, command: &str) -> Option<String> {
        self.processor_mut().monitor_command(command)
    }

    fn debugger_halted(&mut self, why: HaltReason) -> bool {
        self.processor_mut().debugger_halted(why)
    }

    fn bit_alias(&self, address: u64, width: Width) -> Option<BitAlias> {
        self.processor().bit_alias(address, width)
    }

    fn own_ranges(&self) -> Vec<std::ops::Range<u64>> {
        self.processor().own_ranges()
    }

    fn host_call(&self, read: &mut dyn FnMut(u64, Width) -> Option<u64>) -> Option<HostCall> {
        self.processor().host_call(read)
    }

    fn answer_host_call(&mut self, answer: Option<u64>) {
        self.processor_mut().answer_host_call(answer);
    }
}
