//! Encoder capture: reads both counters at every control tick.
//!
//! This task answers the beat. It turns absolute counts into travel and speed and hands them to the
//! profile task; a tick that comes too late is a fault.

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::Instant;
use shared_proto::{Fault, WheelPair};

use crate::encoder::SpeedEstimator;
use crate::hal::{Beat, Encoders};
use crate::shared::{CaptureSettings, Measured, Shared};
use crate::units::{CONTROL_PERIOD_US, Speed, Travel};

/// A control tick may start this late \[us\]: half a period, so that two never meet.
pub const TICK_DELAY_US_MAX: u64 = CONTROL_PERIOD_US as u64 / 2;

/// Reads the encoders, for ever.
pub async fn run<M: RawMutex>(
    shared: &Shared<M>,
    mut beat: impl Beat,
    mut encoders: impl Encoders,
) -> ! {
    let mut capture = Capture::new(shared.capture_settings.next().await, encoders.counts());
    beat.next().await;
    let mut due_us = Instant::now().as_micros();
    let mut tick = 0_u32;
    loop {
        let t_us = Instant::now().as_micros();
        if t_us > due_us {
            note_delay(shared, t_us - due_us, t_us);
        }
        let counts = encoders.counts();
        if let Some(settings) = shared.capture_settings.try_take() {
            capture.restart(settings, counts);
        }
        tick = tick.wrapping_add(1);
        let (counts, travel, speed) = capture.step(tick, counts);
        shared.measured.put(Measured { tick, t_us, counts, travel, speed });
        beat.next().await;
        due_us += CONTROL_PERIOD_US as u64;
    }
}

/// Counts as wired to counts forward, travel and speed.
struct Capture {
    settings: CaptureSettings,
    estimators: WheelPair<SpeedEstimator>,
}

impl Capture {
    fn new(settings: CaptureSettings, counts: WheelPair<i64>) -> Self {
        let q = settings.odometry.meters_per_count();
        let forward = settings.forward(counts);
        Self {
            estimators: WheelPair {
                left: SpeedEstimator::new(q.left, forward.left),
                right: SpeedEstimator::new(q.right, forward.right),
            },
            settings,
        }
    }

    fn restart(&mut self, settings: CaptureSettings, counts: WheelPair<i64>) {
        let forward = settings.forward(counts);
        self.estimators.left.restart(settings.scales.left, forward.left);
        self.estimators.right.restart(settings.scales.right, forward.right);
        self.settings = settings;
    }

    #[inline(never)]
    fn step(
        &mut self,
        tick: u32,
        counts: WheelPair<i64>,
    ) -> (WheelPair<i64>, WheelPair<Travel>, WheelPair<Speed>) {
        let counts = self.settings.forward(counts);
        let speed = WheelPair {
            left: self.estimators.left.step(tick, counts.left),
            right: self.estimators.right.step(tick, counts.right),
        };
        (counts, self.settings.odometry.travel(counts), speed)
    }
}

#[cold]
fn note_delay<M: RawMutex>(shared: &Shared<M>, delay_us: u64, t_us: u64) {
    let delay = u32::try_from(delay_us).unwrap_or(u32::MAX);
    shared.tick_delay_us_max.update(|max| *max = delay.max(*max));
    if delay_us > TICK_DELAY_US_MAX {
        shared.raise(Fault::DeadlineMissed, t_us);
    }
}
