//! Why the board started, and what a panic or a hard fault leaves behind.

use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m::peripheral::{DCB, SCB};
use embassy_stm32::pac;
use shared_proto::ResetCause;

/// What [`PANICKED`] holds after a panic; any other value is what was in the memory at power-on.
const MAGIC: u32 = 0x4250_414E;

/// Four bytes that a reset leaves alone.
#[unsafe(link_section = ".uninit.PANICKED")]
static mut PANICKED: MaybeUninit<u32> = MaybeUninit::uninit();

/// Why the board started. Asked once: it forgets.
pub fn cause() -> ResetCause {
    // SAFETY: called before any other task or interrupt could panic; every bit pattern is a u32.
    let panicked = unsafe {
        let word = &raw mut PANICKED;
        let panicked = word.cast::<u32>().read_volatile() == MAGIC;
        word.cast::<u32>().write_volatile(0);
        panicked
    };
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    // Power-on sets the flags of pin and brown-out too, and every reset that of the pin.
    if flags.porrstf() {
        ResetCause::PowerOn
    } else if panicked {
        ResetCause::Panic
    } else if flags.wdgrstf() || flags.wwdgrstf() {
        ResetCause::Watchdog
    } else if flags.sftrstf() {
        ResetCause::Software
    } else if flags.borrstf() {
        ResetCause::BrownOut
    } else {
        ResetCause::Pin
    }
}

/// Motors off first, then the log, then a restart that reports it.
///
/// What the panic says is not looked at, so that the linker drops every message, place and formatter from
/// the image. A debugger stops here with the motors off and shows the whole way that led to it, which says
/// more; `cargo run` does so.
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

/// What the core cannot carry out, an instruction or an access that is none: as a panic.
#[cortex_m_rt::exception(trampoline = false)]
unsafe fn HardFault() -> ! {
    super::motors_off();
    remember();
    SCB::sys_reset()
}

/// Leaves word for the next start.
fn remember() {
    // SAFETY: no task or other interrupt runs any more, and nobody returns from here.
    unsafe { (&raw mut PANICKED).cast::<u32>().write_volatile(MAGIC) };
}
