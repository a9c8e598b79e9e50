//! The clock from outside the chip: whether it starts. The registers are the same on every chip here.

use embassy_stm32::pac::RCC;

/// Turns of a loop of four to ten cycles at 16 MHz: 4 to 9 ms. A crystal takes 2, and the watchdog waits for 21.
const CRYSTAL_TURNS_MAX: u32 = 15_000;

/// Whether the external clock starts. Without it the chip runs from its own oscillator, 1 % exact: times
/// and speeds are off by that much, distances are not.
pub(super) fn starts(bypass: bool) -> bool {
    RCC.cr().modify(|w| w.set_hsebyp(bypass));
    RCC.cr().modify(|w| w.set_hseon(true));
    (0..CRYSTAL_TURNS_MAX).any(|_| RCC.cr().read().hserdy())
}
