//! What was applied to both motors, and how far the wheels went.

use crate::kinematics::WheelPair;

/// Both wheels at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When \[s\].
    pub t_s: f64,
    /// How far the wheels have gone since any origin, forward positive \[m\].
    pub travel_m: WheelPair<f64>,
    /// The motors' voltages, summed over time since any origin \[V s\].
    pub applied_vs: WheelPair<f64>,
}

/// One experiment: it begins with both wheels at rest and no voltage applied.
#[derive(Clone, Debug, PartialEq)]
pub struct VoltageRecording {
    samples: Vec<Sample>,
    count_m: WheelPair<f64>,
}

impl VoltageRecording {
    /// The samples in the order of their times; those that are no later than the one before are left out, and those with
    /// a number that is none. None if fewer than three remain.
    pub fn new(samples: impl IntoIterator<Item = Sample>) -> Option<Self> {
        let mut kept: Vec<Sample> = Vec::new();
        for sample in samples {
            let Sample { t_s, travel_m, applied_vs } = sample;
            let numbers = [t_s, travel_m.left, travel_m.right, applied_vs.left, applied_vs.right];
            let later = kept.last().is_none_or(|last| t_s > last.t_s);
            if later && numbers.into_iter().all(f64::is_finite) {
                kept.push(sample);
            }
        }
        (kept.len() >= 3).then_some(Self { samples: kept, count_m: WheelPair::both(0.0) })
    }

    /// The same from encoders with these distances per count \[m\]. Where within a count the wheels stood at the beginning
    /// is then unknown; as made by [`VoltageRecording::new`], travel begins at zero exactly.
    pub fn with_counts_of(self, count_m: WheelPair<f64>) -> Self {
        Self { count_m, ..self }
    }

    /// Distance per count \[m\]; zero for travel that is not counted.
    pub(super) fn count_m(&self) -> WheelPair<f64> {
        self.count_m
    }

    /// The samples.
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// Applied voltage up to a time, between the samples in proportion; before the first and after the last as there.
    pub(super) fn applied_vs_at(&self, t_s: f64, cursor: &mut usize) -> WheelPair<f64> {
        let samples = &self.samples;
        while *cursor + 2 < samples.len() && samples[*cursor + 1].t_s <= t_s {
            *cursor += 1;
        }
        let (before, after) = (&samples[*cursor], &samples[*cursor + 1]);
        let share = ((t_s - before.t_s) / (after.t_s - before.t_s)).clamp(0.0, 1.0);
        before.applied_vs.toward(after.applied_vs, share)
    }
}
