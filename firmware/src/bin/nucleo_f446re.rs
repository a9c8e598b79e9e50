//! The wiring of a robot with a NUCLEO-F446RE. See `docs/boards/nucleo-f446re.md` for the connectors.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "wiring/nucleo_64.rs"]
mod nucleo_64;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is a board's image: see `cargo xtask firmware --board nucleo-f446re`");
}
