//! The wiring of a robot with a NUCLEO-F411RE. See `docs/boards.md` for the connectors.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[macro_use]
#[path = "wiring/usart2.rs"]
mod usart2;

#[cfg(target_os = "none")]
mod wiring {
    robot! {
        left_encoder: PC6 PC7,
        lines_c: PA6 PA7,
        supply: PA0 channel 0,
        button: PC13,
        led: PA5 lit High,
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is a board's image: see `cargo xtask firmware --board nucleo-f411re`");
}
