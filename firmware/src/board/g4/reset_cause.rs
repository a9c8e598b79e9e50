//! Why the chip was reset. It has one flag for power-on and brown-out (7.4.28), so memory has to tell the two apart: a
//! supply that only dips leaves it as it was.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use embassy_stm32::pac::RCC;
use shared_proto::ResetCause;

/// The value of [`RAN`] from the first start after power-on; any other value is random content from power-on.
const MAGIC: u32 = 0x4245_5552;

/// Four bytes that keep their value over a reset, and over a dip of the supply.
#[unsafe(link_section = ".uninit.RAN")]
static mut RAN: MaybeUninit<u32> = MaybeUninit::uninit();

/// The reset was to load the option bytes.
static LOADED_OPTIONS: AtomicBool = AtomicBool::new(false);

/// Why the chip was reset, if not by a panic. Clears the cause.
///
/// A supply that was off too briefly for memory to lose its content counts as dipped.
pub(in crate::board) fn reset_cause(panicked: bool) -> ResetCause {
    let flags = RCC.csr().read();
    RCC.csr().modify(|w| w.set_rmvf(true));
    LOADED_OPTIONS.store(flags.oblrstf(), Ordering::Relaxed);
    let ran = has_run();
    // Every reset sets the pin flag.
    if flags.borrstf() {
        if ran { ResetCause::BrownOut } else { ResetCause::PowerOn }
    } else if panicked {
        ResetCause::Panic
    } else if flags.iwdgrstf() || flags.wwdgrstf() {
        ResetCause::Watchdog
    } else if flags.sftrstf() || flags.oblrstf() {
        ResetCause::Software
    } else {
        ResetCause::Pin
    }
}

/// Whether the reset was to load the option bytes. Of [`reset_cause`], which comes first.
pub(super) fn has_loaded_options() -> bool {
    LOADED_OPTIONS.load(Ordering::Relaxed)
}

/// Whether memory still knows of a start before this one.
fn has_run() -> bool {
    // SAFETY: called once, before any other task or interrupt; every bit pattern is a u32.
    unsafe {
        let word = (&raw mut RAN).cast::<u32>();
        let ran = word.read_volatile() == MAGIC;
        word.write_volatile(MAGIC);
        ran
    }
}
