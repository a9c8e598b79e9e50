//! From both counters to signed counts, travel and speed, at each control tick.

use shared_proto::{Config, WheelPair};

use crate::encoder::{SpeedEstimator, SpeedScale};
use crate::odometry::Odometry;
use crate::units::{Speed, Travel};

/// The wheels at one control tick.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Control ticks since power-on.
    pub tick: u32,
    /// When the encoders were read \[us\].
    pub t_us: u64,
    /// Absolute counts, forward positive.
    pub counts: WheelPair<i64>,
    /// Travel on the ground.
    pub travel: WheelPair<Travel>,
    /// Speed on the ground.
    pub speed: WheelPair<Speed>,
}

/// How to read the encoders.
#[derive(Clone)]
pub struct CaptureSettings {
    /// Counts to travel.
    odometry: Odometry,
    /// Counts to speed.
    scales: WheelPair<SpeedScale>,
    /// -1 where a count falls when the wheel rolls forward, else 0.
    reversed: WheelPair<i32>,
}

impl CaptureSettings {
    /// The settings of a valid configuration.
    #[inline]
    pub fn new(config: &Config) -> Self {
        let odometry = Odometry::new(config);
        Self {
            scales: odometry.meters_per_count().map(SpeedScale::new),
            odometry,
            reversed: config.encoder.as_ref().map(|encoder| -i32::from(encoder.reversed)),
        }
    }

    /// Turns counts as wired into counts that are positive forward.
    #[inline(always)]
    fn forward(&self, counts: WheelPair<i64>) -> WheelPair<i64> {
        // Two's complement, without a branch: all bits turned over, and one added.
        let reversed = self.reversed.map(i64::from);
        counts.zip(reversed).map(|(count, reversed)| (count ^ reversed).wrapping_sub(reversed))
    }
}

/// Turns counts as wired into signed counts, travel and speed.
pub struct Capture {
    settings: CaptureSettings,
    estimators: WheelPair<SpeedEstimator>,
}

impl Capture {
    /// Starts with wheels that stand.
    pub fn new(settings: CaptureSettings) -> Self {
        let estimators = settings.scales.map(|scale| SpeedEstimator::with(scale, 0));
        Self { settings, estimators }
    }

    /// Adopts new settings. Wheels that roll are still known to roll, unless their counts now go the other way.
    #[inline(never)]
    pub fn adopt(&mut self, settings: &CaptureSettings) {
        self.estimators.left.adopt(settings.scales.left);
        self.estimators.right.adopt(settings.scales.right);
        if self.settings.reversed != settings.reversed {
            self.estimators.left.forget();
            self.estimators.right.forget();
        }
        self.settings.clone_from(settings);
    }

    /// Fills in counts, travel and speed of the tick whose number `measured` holds.
    #[inline(never)]
    pub fn step(&mut self, counts: &WheelPair<i64>, measured: &mut Measured) {
        let counts = self.settings.forward(*counts);
        measured.counts = counts;
        measured.travel = self.settings.odometry.travel(counts);
        measured.speed.left = self.estimators.left.step(measured.tick, counts.left);
        measured.speed.right = self.estimators.right.step(measured.tick, counts.right);
    }
}
