//! The wiring of a robot with a NUCLEO-64: the F446RE and the F411RE have the same connectors.

#[macro_use]
#[path = "usart2.rs"]
mod usart2;

robot! {
    left_encoder: PC6 PC7,
    lines_c: PA6 PA7,
    supply: PA0 channel 0,
    button: PC13 active_low,
    led: PA5 lit High,
    transmit: DMA1_CH6 DMA1_STREAM6,
    receive: DMA1_CH5 DMA1_STREAM5,
}
