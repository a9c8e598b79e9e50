//! The LEDs show the robot's state, one pattern for each; changes of state are logged.
//!
//! ```text
//! boot      all on
//! idle      green, a short flash each second
//! armed     green, steady
//! driving   green steady, blue steady
//! stopping  blue, fast
//! faulted   red, fast
//! ```
//! A board with a single LED shows every pattern on that LED.

use embassy_stm32::gpio::{Level, Output};
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Duration, Ticker};
use shared_proto::State;

use crate::shared::Shared;

/// Twenty steps a second.
const STEP: Duration = Duration::from_millis(50);

/// A pattern has one bit for each step.
const STEPS: u32 = 20;
const STEADY: u32 = 0xF_FFFF;
const FLASH: u32 = 0b1;
const FAST: u32 = 0b0011_0011_0011_0011_0011;
const DARK: u32 = 0;

/// The board's LEDs. A board with one LED has only the green one.
pub struct Leds {
    /// No fault.
    pub green: Output<'static>,
    /// The robot moves.
    pub blue: Option<Output<'static>>,
    /// A fault is latched.
    pub red: Option<Output<'static>>,
    /// The level that lights them.
    pub lit: Level,
}

/// Patterns of green, blue and red.
const fn patterns(state: State) -> [u32; 3] {
    match state {
        State::Boot => [STEADY, STEADY, STEADY],
        State::Idle => [FLASH, DARK, DARK],
        State::Armed => [STEADY, DARK, DARK],
        State::Driving => [STEADY, STEADY, DARK],
        State::Stopping => [DARK, FAST, DARK],
        State::Faulted => [DARK, DARK, FAST],
    }
}

/// Shows the state and logs its changes, for ever.
pub async fn run<M: RawMutex>(shared: &Shared<M>, mut leds: Leds) -> ! {
    let mut ticker = Ticker::every(STEP);
    let mut logged = (State::Boot, 0);
    for step in (0..STEPS).cycle() {
        let state = shared.state.get();
        let now = (state, shared.fault.last_number());
        if now != logged {
            logged = now;
            defmt::info!("{}, fault {}", state, shared.fault.report());
        }
        let on = patterns(state).map(|pattern| pattern >> step & 1 != 0);
        match (&mut leds.blue, &mut leds.red) {
            (Some(blue), Some(red)) => {
                set(&mut leds.green, leds.lit, on[0]);
                set(blue, leds.lit, on[1]);
                set(red, leds.lit, on[2]);
            }
            _ => set(&mut leds.green, leds.lit, on.contains(&true)),
        }
        ticker.next().await;
    }
    unreachable!("a cycle does not end")
}

fn set(led: &mut Output<'static>, lit: Level, on: bool) {
    let lit = lit == Level::High;
    led.set_level((on == lit).into());
}
