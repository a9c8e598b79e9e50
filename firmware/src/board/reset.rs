//! Why the board started, and what happens at a panic or a hard fault.

use core::arch::global_asm;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m::peripheral::{DCB, MPU, SCB};
use shared_proto::ResetCause;

/// The value of [`PANICKED`] after a panic; any other value is random content from power-on.
const MAGIC: u32 = 0x4250_414E;

/// Four bytes that keep their value over a reset.
#[unsafe(link_section = ".uninit.PANICKED")]
static mut PANICKED: MaybeUninit<u32> = MaybeUninit::uninit();

/// Why the board started. Call once: reading clears the cause.
pub fn cause() -> ResetCause {
    // SAFETY: called before any other task or interrupt could panic; every bit pattern is a u32.
    let panicked = unsafe {
        let word = &raw mut PANICKED;
        let panicked = word.cast::<u32>().read_volatile() == MAGIC;
        word.cast::<u32>().write_volatile(0);
        panicked
    };
    super::chip::reset_cause(panicked)
}

/// Motors off first, then the log, then a restart that reports the panic.
///
/// The panic's message is not used, so that the linker drops every message, location and formatter from
/// the image. A debugger, as `cargo run` starts one, stops here with the motors off and shows the call
/// stack, which says more.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    super::motors_off();
    remember();
    defmt::error!("panic");
    if DCB::is_debugger_attached() {
        cortex_m::asm::bkpt();
    }
    SCB::sys_reset()
}

/// Bytes below the stack that nothing may access; `firmware/memory/` leaves them free.
const GUARD_LEN: u32 = 256;

/// Guards the stack: whatever is pushed below its end is a memory fault, with a handler of its own. (A hard fault could
/// not push its frame there either, and the core would stop until the watchdog restarts it.)
pub(super) fn guard_stack() {
    unsafe extern "C" {
        static _stack_end: u8;
    }
    // Armv7-M manual: MEMFAULTENA, B3.2.13; the MPU's registers, B3.5.
    const MEMORY_FAULT: u32 = 1 << 16;
    const NEVER_EXECUTE_NO_ACCESS: u32 = 1 << 28;
    const VALID_REGION_0: u32 = 1 << 4;
    const DEFAULT_MAP: u32 = 1 << 2;
    const ENABLE: u32 = 1;
    let guard = (&raw const _stack_end).addr() as u32 - GUARD_LEN;
    // SAFETY: called once, before any task or interrupt that could use these registers. The guard's memory is nobody's.
    unsafe {
        (*SCB::PTR).shcsr.modify(|value| value | MEMORY_FAULT);
        (*MPU::PTR).rbar.write(guard | VALID_REGION_0);
        let size = (GUARD_LEN.ilog2() - 1) << 1;
        (*MPU::PTR).rasr.write(NEVER_EXECUTE_NO_ACCESS | size | ENABLE);
        (*MPU::PTR).ctrl.write(DEFAULT_MAP | ENABLE);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

// The handler of hard and memory faults. It empties the stack first, before anything is pushed: after an overflow there is no room,
// and a fault in this handler would stop the core. Nothing returns from here, so what was on the stack is not needed.
global_asm!(
    ".syntax unified",
    ".thumb",
    ".section .HardFault.user, \"ax\", %progbits",
    ".global HardFault",
    ".type HardFault, %function",
    ".global MemoryManagement",
    ".type MemoryManagement, %function",
    ".thumb_func",
    "MemoryManagement:",
    ".thumb_func",
    "HardFault:",
    "ldr r0, =_stack_start",
    "mov sp, r0",
    "b.w {handle}",
    ".ltorg",
    handle = sym hard_fault,
);

/// An invalid instruction or memory access, a stack overflow among them: handled like a panic.
extern "C" fn hard_fault() -> ! {
    super::motors_off();
    remember();
    SCB::sys_reset()
}

/// The external clock has stopped, and the chip runs on its own oscillator at a tenth of its speed (RM0090,
/// 6.2.7; RM0440, 7.2.9). TIM1's outputs are off already; the restart reports a panic, as the watchdog would be too late.
///
/// Or a chip whose flash corrects errors has read what a power cut left half written.
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() {
    if super::chip::was_unreadable_flash() {
        return;
    }
    super::motors_off();
    remember();
    SCB::sys_reset()
}

/// Tells the next start of the panic.
fn remember() {
    // SAFETY: no task or other interrupt runs any more, and nothing returns from here.
    unsafe { (&raw mut PANICKED).cast::<u32>().write_volatile(MAGIC) };
}
