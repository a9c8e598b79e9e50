//! The boards: what [`crate::hal`] asks for, on real STM32 timers, converters and pins.
//!
//! A board's binary (`src/bin/`) is its wiring diagram: it names the pins and puts the parts of this
//! module together. What differs between boards in registers rather than pins is in one file each.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`control_timer`] | the timer that the control tick goes by |
//! | [`encoders`] | two timers in encoder mode |
//! | [`bridge`] | PWM, direction and enable of a two-channel motor driver |
//! | [`supply`] | the supply voltage, by way of a divider and the converter |
//! | [`input`] | emergency stop and driver fault |
//! | [`guard`] | which task met its deadline; watchdog; motors off if one did not |
//! | [`leds`] | what the lights say |
//! | `memory` | copying and clearing, small |
//! | [`flash`] | the part of the flash where the configuration lives |
//! | [`reset`] | why the board started; what a panic leaves behind |
//! | `usb` | the link on the board's own USB connector |
//! | [`tasks`] | the tasks with concrete types, and their statics |

pub mod bridge;
pub mod control_timer;
pub mod encoders;
pub mod flash;
pub mod guard;
pub mod input;
pub mod leds;
mod memory;
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

#[cfg(all(feature = "usb", feature = "board-nucleo-f446re"))]
compile_error!("the NUCLEO-F446RE has no USB connector of its own");

#[cfg(all(feature = "board-nucleo-f429zi", feature = "board-nucleo-f446re"))]
compile_error!(
    "an image is for one board: with another board's feature, add --no-default-features"
);

/// Both motors without drive, at once and whatever the tasks are doing: the last thing before a
/// restart. Only registers, no lock and no allocation: it may interrupt anything.
pub fn motors_off() {
    let pwm = embassy_stm32::pac::TIM1;
    for channel in 0..4 {
        pwm.ccr(channel).write(|w| w.set_ccr(0));
    }
    driver_disable();
}
