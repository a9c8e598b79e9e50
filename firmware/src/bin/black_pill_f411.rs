//! The wiring of a robot with a WeAct Black Pill F411. See `docs/boards/black-pill-f411.md` for the connectors.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[macro_use]
#[path = "wiring/usart2.rs"]
mod usart2;

#[cfg(target_os = "none")]
mod wiring {
    robot! {
        left_encoder: PA6 PA7,
        lines_c: PB13 PB14,
        supply: PA1 channel 1,
        button: PA0 active_low,
        led: PC13 lit Low,
        transmit: DMA1_CH6 DMA1_STREAM6,
        receive: DMA1_CH5 DMA1_STREAM5,
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is a board's image: see `cargo xtask firmware --board black-pill-f411`");
}
