//! The boards: [`crate::hal`] on STM32 timers, converters and pins.
//!
//! A board's binary (`src/bin/`) is its wiring diagram: the binary names the pins and connects the parts
//! of this module. Each board has a file here for what differs in registers rather than pins.
//!
//! | module | contents |
//! | --- | --- |
//! | [`control_timer`] | the timer behind the control tick |
//! | `clocks`, `external_clock` | the clock tree; whether the external clock starts |
//! | `f4`, `g4` | what a family of chips has of its own; `g4` also has its own `clocks`, `flash` and `supply` |
//! | `one_bank` | the store in a flash of one bank |
//! | `random` | random numbers, where the chip has a generator |
//! | [`encoders`] | two timers in encoder mode |
//! | [`bridge`] | the motor drivers' lines, and the stop line |
//! | [`supply`], `divider` | the supply voltage, through a divider and an ADC |
//! | [`input`] | emergency stop and driver fault |
//! | [`guard`] | feeds the watchdog while every task meets its deadline; otherwise motors off |
//! | [`check_in`] | where the tasks check in with the guard |
//! | [`leds`] | the state on the LEDs |
//! | `memory` | small routines that copy and clear memory |
//! | [`power_on`] | watchdog, flash accelerator, brown-out level, clock security, debugger |
//! | [`flash`] | the part of the flash that holds the configuration |
//! | [`reset`] | why the board started; what happens at a panic |
//! | `usb` | the link on the board's own USB connector |
//! | [`tasks`] | the tasks with concrete types, and their statics |

pub mod bridge;
pub mod check_in;
pub mod control_timer;
mod divider;
pub mod encoders;
mod external_clock;
pub mod guard;
pub mod input;
pub mod leds;
mod memory;
pub mod power_on;
#[cfg(any(feature = "board-nucleo-f429zi", feature = "board-nucleo-g474re"))]
mod random;
pub mod reset;
pub mod tasks;
#[cfg(feature = "usb")]
pub mod usb;

#[cfg(not(feature = "board-nucleo-g474re"))]
mod clocks;
#[cfg(not(feature = "board-nucleo-g474re"))]
mod f4;
#[cfg(not(feature = "board-nucleo-g474re"))]
use f4 as chip;
#[cfg(not(feature = "board-nucleo-g474re"))]
pub mod flash;
#[cfg(not(feature = "board-nucleo-g474re"))]
pub mod supply;

#[cfg(feature = "board-nucleo-g474re")]
mod g4;
#[cfg(feature = "board-nucleo-g474re")]
use g4 as chip;
#[cfg(feature = "board-nucleo-g474re")]
pub use g4::{flash, supply};

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

#[cfg(feature = "board-nucleo-g474re")]
mod nucleo_g474re;
#[cfg(feature = "board-nucleo-g474re")]
pub use nucleo_g474re::*;

#[cfg(not(any(feature = "board-nucleo-f429zi", feature = "board-nucleo-g474re")))]
mod one_bank;

#[cfg(all(feature = "usb", not(feature = "board-nucleo-f429zi")))]
compile_error!("only the NUCLEO-F429ZI has an image with the link on its own USB connector");

/// `cargo build --features board-...` leaves the default board's feature on.
#[cfg(all(
    feature = "board-nucleo-f429zi",
    any(
        feature = "board-nucleo-f446re",
        feature = "board-nucleo-f411re",
        feature = "board-black-pill-f411",
        feature = "board-nucleo-g474re"
    )
))]
compile_error!(
    "an image is for one board: with another board's feature, add --no-default-features"
);

/// Switches both motors off at once, whatever the tasks are doing: the last action before a restart.
pub fn motors_off() {
    bridge::off();
}
