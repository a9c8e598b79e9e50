//! Bugs that are injected into the running program: a few instructions of the flashed image are replaced at
//! a chosen moment, so the image needs no test code.

use std::path::Path;

use object::{Object, ObjectSymbol};
use rigless::emulator::{Access, Host};
use rigless::soc::Width;

use crate::board::INSTRUCTION_NS;

/// Flash after the image, for instructions that do not fit at the bug's place.
const SPARE: u64 = 0x080F_0000;

/// The same for what stands in for a task.
const TASK_SPARE: u64 = SPARE + 0x100;

/// A task's storage begins with a header of less than this length \[bytes\].
const TASK_HEADER_LEN: u64 = 64;

/// A bug in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bug {
    /// Where the bug is.
    pub place: Place,
    /// What the program does there.
    pub effect: Effect,
}

/// Where a bug is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// At the beginning of a function.
    Function(&'static str),
    /// In this task, as `firmware/src/board/tasks.rs` names it; for [`Effect::Stop`] and [`Effect::Stall`].
    Task(&'static str),
    /// At the next instruction that accesses this register; takes effect the second time the program gets there.
    Register(u64),
}

/// What happens where the bug is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// The program hangs.
    Hang,
    /// The program panics.
    Panic,
    /// The core executes an invalid instruction.
    HardFault,
    /// The program calls itself without end, until the stack has no room.
    StackOverflow,
    /// The task never runs again, and everything else does: as if it waited for what never comes.
    Stop,
    /// The core stands still for this long, once, before the task runs: no interrupt is taken, and the
    /// ticks of the control timer merge.
    Stall {
        /// How long \[ms\].
        ms: u16,
    },
}

/// Injects bugs; knows the addresses of the image's functions.
#[derive(Debug)]
pub(crate) struct BugInjector {
    functions: Vec<(String, u64)>,
    /// Bugs that wait for an access to their register.
    waiting: Vec<(u64, Effect)>,
    /// Instructions to replace at the next stop.
    found: Vec<(u64, Effect)>,
    /// The replaced instructions, by address.
    replaced: Vec<(u64, u64)>,
}

impl BugInjector {
    pub fn new(image: &Path) -> Result<Self, Box<dyn std::error::Error>> {
        let bytes = std::fs::read(image)?;
        let file = object::File::parse(&*bytes)?;
        let functions = file.symbols().filter_map(|symbol| {
            // The lowest bit marks Thumb code.
            Some((symbol.name().ok()?.to_string(), symbol.address() & !1))
        });
        Ok(Self {
            functions: functions.collect(),
            waiting: Vec::new(),
            found: Vec::new(),
            replaced: Vec::new(),
        })
    }

    pub fn plant(&mut self, bug: Bug, host: &mut dyn Host) {
        match bug.place {
            Place::Function(name) => {
                let address = self.function(|function| function == name);
                self.replace(address.expect("the image has this function"), bug.effect, host);
            }
            Place::Task(name) => self.plant_in_task(name, bug.effect, host),
            Place::Register(address) => self.waiting.push((address, bug.effect)),
        }
    }

    /// The non-maskable interrupt, which the emulator cannot raise: the next interrupt of the control timer, the clock or
    /// the guard is a hard fault instead, whose handler does the same. On a chip it comes at once.
    pub fn raise_nmi(&mut self, host: &mut dyn Host) {
        for name in ["TIM2", "TIM5", "SysTick"] {
            self.plant(Bug { place: Place::Function(name), effect: Effect::HardFault }, host);
        }
    }

    pub fn on_access(&mut self, access: &Access) {
        if self.waiting.is_empty() {
            return;
        }
        let at = self.waiting.iter().position(|(address, _)| *address == access.address);
        if let (Some(at), Some(instruction)) = (at, access.program_counter) {
            let (_, effect) = self.waiting.swap_remove(at);
            self.found.push((instruction, effect));
        }
    }

    /// Replaces instructions that were found. Not at once: the program is about to execute the next one, which may
    /// be replaced too.
    pub fn on_stop(&mut self, host: &mut dyn Host) {
        for (instruction, effect) in std::mem::take(&mut self.found) {
            self.replace(instruction, effect, host);
        }
    }

    fn function(&self, is: impl Fn(&str) -> bool) -> Option<u64> {
        self.functions.iter().find(|(name, _)| is(name)).map(|(_, address)| *address)
    }

    /// Restores the replaced instructions.
    pub fn clean_up(&mut self, host: &mut dyn Host) {
        for (address, half) in self.replaced.drain(..).rev() {
            host.write(address, Width::W16, half).expect("the address is in flash");
        }
        self.waiting.clear();
        self.found.clear();
    }

    fn replace(&mut self, at: u64, effect: Effect, host: &mut dyn Host) {
        for address in [at, at + 2] {
            let half = host.read(address, Width::W16).expect("the address is in flash");
            self.replaced.push((address, half));
        }
        match effect {
            // b . (to itself)
            Effect::Hang => write(host, at, &[0xE7FE]),
            // udf #0
            Effect::HardFault => write(host, at, &[0xDE00]),
            // push {r0-r7, lr}; b to it
            Effect::StackOverflow => write(host, at, &[0xB5FF, 0xE7FD]),
            Effect::Stop | Effect::Stall { .. } => {
                panic!("a task stops or stalls, not an instruction")
            }
            Effect::Panic => {
                let panics = self.function(|name| name.ends_with("option13unwrap_failed"));
                let panics = panics.expect("somewhere in the image an option is unwrapped");
                self.write_call(panics, host);
                write(host, at, &branch(at, SPARE));
            }
        }
    }

    /// Puts a routine of a few instructions in the place of a task's own: embassy keeps its address in RAM,
    /// in the task's storage.
    fn plant_in_task(&self, task: &str, effect: Effect, host: &mut dyn Host) {
        let pool = format!("5tasks{}{task}4POOL", task.len());
        let pool = self.function(|name| name.contains(&pool)).expect("the image has this task");
        let polls = |word: u64| {
            let is = |name: &str| name.contains("TaskStorage") && name.contains("4poll");
            self.functions.iter().any(|(name, at)| is(name) && at | 1 == word)
        };
        let (field, poll) = (pool..pool + TASK_HEADER_LEN)
            .step_by(4)
            .filter_map(|at| Some((at, host.read(at, Width::W32).ok()?)))
            .find(|(_, word)| polls(*word))
            .expect(
                "a task's storage begins with its header, which has the address of its routine",
            );
        match effect {
            // bx lr
            Effect::Stop => write(host, TASK_SPARE, &[0x4770]),
            Effect::Stall { ms } => write_stall(u64::from(ms), field, poll, host),
            other => panic!("{other:?} has a function or a register as its place"),
        }
        host.write(field, Width::W32, TASK_SPARE | 1).expect("the task's storage is in RAM");
    }

    /// Writes to [`SPARE`] a call of a function that takes a `core::panic::Location`.
    fn write_call(&self, function: u64, host: &mut dyn Host) {
        // ldr r0, [pc, #8]; mov r1, r0; ldr r3, [pc, #8]; mov r2, r0; bx r3; nop
        write(host, SPARE, &[0x4802, 0x4601, 0x4B02, 0x4602, 0x4718, 0xBF00]);
        let location = SPARE + 20;
        let name = SPARE + 36;
        let words =
            [location, function | 1, name, 3, 1, 1, u64::from(u32::from_le_bytes(*b"bug\0"))];
        for (index, word) in words.into_iter().enumerate() {
            host.write(SPARE + 12 + 4 * index as u64, Width::W32, word)
                .expect("the address is in flash");
        }
    }
}

/// Writes a routine that masks interrupts, counts down, puts the task's own routine back, and goes there.
fn write_stall(ms: u64, field: u64, poll: u64, host: &mut dyn Host) {
    // push {r0, lr}; cpsid i; ldr r1, count; 1: subs r1, #1; bne 1b; ldr r2, field; ldr r3, poll;
    // str r3, [r2]; cpsie i; pop {r0, r1}; mov lr, r1; bx r3
    const ROUTINE: [u16; 12] = [
        0xB501, 0xB672, 0x4904, 0x3901, 0xD1FD, 0x4A04, 0x4B04, 0x6013, 0xB662, 0xBC03, 0x468E,
        0x4718,
    ];
    write(host, TASK_SPARE, &ROUTINE);
    let count = ms * 1_000_000 / (2 * INSTRUCTION_NS);
    for (index, word) in [count, field, poll].into_iter().enumerate() {
        host.write(TASK_SPARE + 24 + 4 * index as u64, Width::W32, word)
            .expect("the address is in flash");
    }
}

fn write(host: &mut dyn Host, at: u64, halves: &[u16]) {
    for (index, &half) in halves.iter().enumerate() {
        host.write(at + 2 * index as u64, Width::W16, half.into())
            .expect("the address is in flash");
    }
}

/// `b.w`, encoding T4 of the Armv7-M manual (A7.7.12).
fn branch(from: u64, to: u64) -> [u16; 2] {
    let offset = to.wrapping_sub(from + 4);
    let bit = |number: u64| offset >> number & 1;
    let (s, i1, i2) = (bit(24), bit(23), bit(22));
    let (j1, j2) = (i1 ^ s ^ 1, i2 ^ s ^ 1);
    let high = 0xF000 | s << 10 | offset >> 12 & 0x3FF;
    let low = 0x9000 | j1 << 13 | j2 << 11 | offset >> 1 & 0x7FF;
    [high as u16, low as u16]
}

#[cfg(test)]
mod tests {
    use super::branch;

    #[test]
    fn a_branch_is_encoded_as_the_assembler_does() {
        // `b.w . + 0x1000` and `b.w . - 0x1000`, as GNU as has them.
        assert_eq!(branch(0x0800_0000, 0x0800_1000), [0xF000, 0xBFFE]);
        assert_eq!(branch(0x0800_1000, 0x0800_0000), [0xF7FE, 0xBFFE]);
    }
}
