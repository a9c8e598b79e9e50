//! The flashed image on an emulated STM32F4, closed round the simulator's plant.
//!
//! ```text
//!            image's bytes on the emulated chip
//!  TIM1 PWM, direction, enable |  ^ TIM3, TIM4 edges, ADC, button, fault line
//!                              v  |
//!                     sim-target's plant            USART3 <-> host's session
//! ```
//!
//! Everything runs on one virtual clock: the same image, scenario and procedure give the same bytes.
//!
//! # What the emulator does not model
//!
//! - Time: each instruction takes 8 ns, a fair mean for a Cortex-M4 at 168 MHz with its flash
//!   accelerator. Counts of instructions are exact, times of short stretches of code are not.
//! - The analog side: PWM reaches the plant as its mean, the supply as a voltage on the converter's
//!   pin. No ringing, and no noise except the plant's.
//! - Bounce, slow edges and cross-talk on the encoder lines.
//! - The time to program a word of flash; an erasure takes the data sheet's time.
//! - External interrupts of pins (EXTI); the firmware polls its inputs.
//! - The debug probe: logs go nowhere.
//!
//! Without the feature `emulator` this crate is empty.
#![cfg(feature = "emulator")]

mod board;
mod bug;
mod by_function;
mod chip;
mod control_ticks;
mod cost;
pub mod dead_host;
mod emulation;
mod flash_array;
mod lines;
mod monitor;
mod motor_driver;
mod plant_and_host;
mod random;
pub mod random_faults;
mod stack;
mod translations;
mod uart_peer;

pub use board::{INSTRUCTION_NS, Nucleo};
pub use bug::{Bug, Effect, Place};
pub use by_function::FunctionCost;
pub use chip::{REVISION, RegisterAccess, Revision};
pub use control_ticks::TickTimes;
pub use cost::{Spread, TickCost};
pub use emulation::{Emulation, RunResult};
pub use flash_array::{Flash, Operation, blank};
pub use lines::{Line, LineFault};
pub use monitor::{Bench, BoardMonitor, Powered};
pub use motor_driver::{BoardLines, Effect as MotorEffect, WheelLines, Wiring};
pub use stack::StackDepth;
pub use translations::forget_translations;
