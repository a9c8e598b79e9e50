//! The boards: [`crate::hal`] on STM32 timers, converters and pins.
//!
//! A board's binary (`src/bin/`) is its wiring diagram: the binary names the pins and connects the parts
//! of this module. Each board has a file here for what differs in registers rather than pins.
//!
//! | module | contents |
//! | --- | --- |
//! | [`control_timer`] | the timer behind the control tick |
//! | `clocks` | the clock tree |
//! | `one_bank` | the store in a flash of one bank |
//! | [`encoders`] | two timers in encoder mode |
//! | [`bridge`] | the motor drivers' lines, and the stop line |
//! | [`supply`] | the supply voltage, through a divider and an ADC |
//! | [`input`] | emergency stop and driver fault |
//! | [`guard`] | feeds the watchdog while every task meets its deadline; otherwise motors off |
//! | [`check_in`] | where the tasks check in with the guard |
//! | [`leds`] | the state on the LEDs |
//! | `memory` | small routines that copy and clear memory |
//! | [`power_on`] | watchdog, flash accelerator, brown-out level, clock security, debugger |
//! | [`flash`] | the flash sectors that hold the configuration |
//! | [`reset`] | why the board started; what happens at a panic |
//! | `usb` | the link on the board's own USB connector |
//! | [`tasks`] | the tasks with concrete types, and their statics |

pub mod bridge;
pub mod check_in;
mod clocks;
pub mod control_timer;
pub mod encoders;
pub mod flash;
pub mod guard;
pub mod input;
pub mod leds;
mod memory;
pub mod power_on;
pub mod reset;
pub mod supply;
pub mod tasks;
#[cfg(feature = "usb")]
pub mod usb;

#[cfg(feature = "board-nucleo-f429zi")]
mod nucleo_f429zi;
#[cfg(feature = "board-nucleo-f429zi")]
pub use nucleo_f429zi::*;

#[cfg(feature = "board-nucleo-f446re")]
mod nucleo_f446re;
#[cfg(feature = "board-nucleo-f446re")]
pub use nucleo_f446re::*;

#[cfg(feature = "board-nucleo-f411re")]
mod nucleo_f411re;
#[cfg(feature = "board-nucleo-f411re")]
pub use nucleo_f411re::*;

#[cfg(feature = "board-black-pill-f411")]
mod black_pill_f411;
#[cfg(feature = "board-black-pill-f411")]
pub use black_pill_f411::*;

#[cfg(not(feature = "board-nucleo-f429zi"))]
mod one_bank;

#[cfg(all(feature = "usb", not(feature = "board-nucleo-f429zi")))]
compile_error!("only the NUCLEO-F429ZI has an image with the link on its own USB connector");

/// `cargo build --features board-...` leaves the default board's feature on.
#[cfg(all(
    feature = "board-nucleo-f429zi",
    any(
        feature = "board-nucleo-f446re",
        feature = "board-nucleo-f411re",
        feature = "board-black-pill-f411"
    )
))]
compile_error!(
    "an image is for one board: with another board's feature, add --no-default-features"
);

/// Switches both motors off at once, whatever the tasks are doing: the last action before a restart.
pub fn motors_off() {
    bridge::off();
}
