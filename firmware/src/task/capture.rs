//! Encoder capture: reads both counters at every control tick.
//!
//! This task sets the beat. It turns absolute counts into travel and speed and hands them to the
//! profile task; a tick that comes too late is a fault.

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Duration, Instant, Ticker};
use shared_proto::{Fault, State};

use crate::encoder::SpeedEstimator;
use crate::hal::Encoders;
use crate::shared::{Measured, Shared};
use crate::units::CONTROL_PERIOD_US;

/// A control tick may start this late \[us\]: half a period, so that two never meet.
pub const TICK_DELAY_US_MAX: u64 = CONTROL_PERIOD_US as u64 / 2;

/// Reads the encoders, for ever.
pub async fn run<M: RawMutex>(shared: &Shared<M>, mut encoders: impl Encoders) -> ! {
    let mut settings = shared.capture_settings.wait().await;
    let mut estimators = None;
    let mut ticker = Ticker::every(Duration::from_micros(CONTROL_PERIOD_US as u64));
    let mut due_us = Instant::now().as_micros();
    let mut tick = 0_u32;
    loop {
        ticker.next().await;
        due_us += CONTROL_PERIOD_US as u64;
        let t_us = Instant::now().as_micros();
        note_delay(shared, t_us.saturating_sub(due_us), t_us);

        if let Some(new) = shared.capture_settings.try_take() {
            settings = new;
            estimators = None;
        }
        tick = tick.wrapping_add(1);
        let counts = encoders
            .counts()
            .zip(settings.reversed)
            .map(|(count, reversed)| if reversed { -count } else { count });
        let travel = settings.odometry.travel(counts);
        let speed = estimators
            .get_or_insert_with(|| {
                settings
                    .odometry
                    .meters_per_count()
                    .zip(counts)
                    .map(|(q, counts)| SpeedEstimator::new(q, counts))
            })
            .as_mut()
            .zip(counts)
            .map(|(estimator, counts)| estimator.step(tick, counts));
        shared.measured.signal(Measured { tick, t_us, counts, travel, speed });
    }
}

fn note_delay<M: RawMutex>(shared: &Shared<M>, delay_us: u64, t_us: u64) {
    if delay_us == 0 {
        return;
    }
    let delay = u32::try_from(delay_us).unwrap_or(u32::MAX);
    shared.tick_delay_us_max.update(|max| *max = delay.max(*max));
    // With the motors off nobody is hurt: an erasure of the flash may hold the core that long.
    let motors_on = matches!(shared.state.get(), State::Armed | State::Driving | State::Stopping);
    if delay_us > TICK_DELAY_US_MAX && motors_on {
        shared.raise(Fault::DeadlineMissed, t_us);
    }
}
