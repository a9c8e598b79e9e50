//! The wiring of a robot with a NUCLEO-G474RE. See `docs/boards/nucleo-g474re.md` for the connectors.
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
        supply: PA0 channel 1,
        button: PC13 active_high,
        led: PA5 lit High,
        transmit: DMA1_CH1 DMA1_CHANNEL1,
        receive: DMA1_CH2 DMA1_CHANNEL2,
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is a board's image: see `cargo xtask firmware --board nucleo-g474re`");
}
