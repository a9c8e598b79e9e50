//! Encoder capture: reads both counters at every control tick.
//!
//! This task waits for the control timer, turns absolute counts into travel and speed, and hands them to
//! the profile task. A tick that comes too late is a fault while the motors are on. Ticks of the timer that
//! a stalled core lost are counted, and the ticks after them are on time again.

use core::sync::atomic::Ordering;

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::Instant;
use shared_proto::{Fault, State};

use crate::capture::Capture;
use crate::hal::{ControlTimer, Encoders};
use crate::shared::Shared;
use crate::ticks::{ControlTicks, LateTick};
use crate::units::CONTROL_PERIOD_US;

/// Latest start of a control tick \[us\]: half a period, so that two ticks never run into each other.
pub const TICK_DELAY_US_MAX: u64 = CONTROL_PERIOD_US as u64 / 2;

/// Reads the encoders, for ever.
pub async fn run<M: RawMutex>(
    shared: &Shared<M>,
    mut timer: impl ControlTimer,
    mut encoders: impl Encoders,
) -> ! {
    let mut capture = Capture::new(shared.capture_settings.next().await);
    let mut ticks = ControlTicks::START;
    let mut tick = 0_u32;
    loop {
        timer.next().await;
        let t_us = Instant::now().as_micros();
        if let Some(tick) = ticks.take(t_us) {
            note_late(shared, tick, t_us);
        }
        let counts = encoders.counts();
        shared.capture_settings.if_new(|settings| capture.adopt(settings));
        tick = tick.wrapping_add(1);
        shared.snapshot.with(|now| {
            now.measured.tick = tick;
            now.measured.t_us = t_us;
            capture.step(&counts, &mut now.measured);
        });
        shared.measurement_ready.notify();
    }
}

#[cold]
fn note_late<M: RawMutex>(shared: &Shared<M>, tick: LateTick, t_us: u64) {
    let delay = u32::try_from(tick.delay_us).unwrap_or(u32::MAX);
    // Nobody else writes it.
    if delay > shared.tick_delay_us_max.load(Ordering::Relaxed) {
        shared.tick_delay_us_max.store(delay, Ordering::Relaxed);
    }
    if tick.lost > 0 {
        shared.ticks_lost.update(|lost| *lost = lost.saturating_add(tick.lost));
    }
    // Only with the motors on: erasing the flash, with the motors off, may stop the core that long.
    if tick.delay_us > TICK_DELAY_US_MAX
        && matches!(shared.state.get(), State::Armed | State::Driving | State::Stopping)
    {
        shared.raise(Fault::DeadlineMissed, t_us);
    }
}
