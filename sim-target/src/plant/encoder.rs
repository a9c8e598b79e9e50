//! A quadrature encoder and its counter.

use core::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp};
use serde::{Deserialize, Serialize};

use super::angle_error::{AngleError, AngleErrorParameters};
use super::lost_lines::LostLines;
use super::range_check::{ParameterError, RangeCheck};

/// One wheel's encoder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EncoderParameters {
    /// Counts (all four edges) per turn of the encoder, N; may be fractional.
    pub counts_per_rev: f64,
    /// Turns of the encoder per turn of the wheel, r, the paper's 1/g; may be fractional.
    pub gear_reduction: f64,
    /// True if the count falls when the wheel rolls forward.
    pub reversed: bool,
    /// Position between two edges at the start, 0 to 1; drawn if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<f64>,
    /// Angle errors of disc, magnet and gear.
    pub error: AngleErrorParameters,
    /// Shortest level that the counter's input filter lets pass; 0 for no filter \[s\].
    pub filter_s: f64,
    /// Share of the disc's lines that are too thin.
    pub thin_line_share: f64,
}

impl Default for EncoderParameters {
    /// The paper's: 900 counts per turn, no gear.
    fn default() -> Self {
        Self {
            counts_per_rev: 900.0,
            gear_reduction: 1.0,
            reversed: false,
            phase: None,
            error: AngleErrorParameters::default(),
            filter_s: 0.0,
            thin_line_share: 0.0,
        }
    }
}

impl EncoderParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("counts_per_rev", self.counts_per_rev, 1.0, 1e6)?;
        check.within("gear_reduction", self.gear_reduction, 0.01, 1000.0)?;
        check.within("phase", self.phase.unwrap_or(0.0), 0.0, 1.0)?;
        self.error.check(&RangeCheck(&format!("{}error.", check.0)))?;
        check.within("filter_s", self.filter_s, 0.0, 1.0)?;
        check.within("thin_line_share", self.thin_line_share, 0.0, 1.0)
    }
}

/// The encoder's state.
///
/// ```text
/// position p = phi N r / 2 pi + phase             (1)  in counts, not quantised
/// count = offset + sign * floor(p)                (2)
/// ```
///
/// The offset starts so that the first count is 0, and takes up what plugs and swapped wires do later.
#[derive(Clone, Debug)]
pub(super) struct Encoder {
    counts_per_rad: f64,
    phase: f64,
    wired: i64,
    swapped: bool,
    unplugged: bool,
    noise: Option<FalseCounts>,
    angle_error: Option<AngleError>,
    lost_lines: Option<LostLines>,
    count: i64,
    offset: i64,
    step: EncoderStep,
}

/// False counts from interference on a wire, always in one direction.
#[derive(Clone, Copy, Debug)]
struct FalseCounts {
    per_us: Exp<f64>,
    direction: i64,
    next_us: f64,
}

impl Encoder {
    pub fn new(parameters: &EncoderParameters, rng: &mut ChaCha8Rng) -> Self {
        // Drawn in any case, so that setting one encoder's phase does not change the other's.
        let drawn: f64 = rng.random();
        let phase = parameters.phase.unwrap_or(drawn);
        let step = EncoderStep {
            start_us: 0,
            end_us: 0,
            count_before: 0,
            count_after: 0,
            position_before: phase,
            position_after: phase,
            offset: 0,
            sign: 1,
            false_counts: 0,
            connected: true,
        };
        let mut encoder = Self {
            counts_per_rad: parameters.counts_per_rev * parameters.gear_reduction / TAU,
            phase,
            wired: if parameters.reversed { -1 } else { 1 },
            swapped: false,
            unplugged: false,
            noise: None,
            angle_error: AngleError::new(&parameters.error, parameters.gear_reduction),
            lost_lines: LostLines::new(
                parameters.filter_s,
                parameters.thin_line_share,
                parameters.counts_per_rev,
            ),
            count: 0,
            offset: 0,
            step,
        };
        encoder.continue_count();
        encoder
    }

    #[inline]
    pub fn count(&self) -> i64 {
        self.count
    }

    pub fn step(&self) -> EncoderStep {
        self.step
    }

    fn sign(&self) -> i64 {
        if self.swapped { -self.wired } else { self.wired }
    }

    /// Continues from the present count with the present wiring.
    fn continue_count(&mut self) {
        self.offset = self.count - self.sign() * self.step.position_after.floor() as i64;
    }

    pub fn set_swapped(&mut self, swapped: bool) {
        self.swapped = swapped;
        self.continue_count();
    }

    pub fn set_unplugged(&mut self, unplugged: bool) {
        self.unplugged = unplugged;
        self.continue_count();
    }

    /// Sets the mean rate of false counts, upwards if positive; zero ends them.
    pub fn set_noise(&mut self, counts_per_s: f64, now_us: u64, rng: &mut ChaCha8Rng) {
        self.noise = Exp::new(counts_per_s.abs() * 1e-6)
            .ok()
            .filter(|_| counts_per_s.is_finite() && counts_per_s != 0.0)
            .map(|per_us| FalseCounts {
                per_us,
                direction: if counts_per_s > 0.0 { 1 } else { -1 },
                next_us: now_us as f64 + per_us.sample(rng),
            });
    }

    /// Reads the wheel's angle at the end of a step.
    #[inline]
    pub fn advance(&mut self, angle_rad: f64, start_us: u64, end_us: u64, rng: &mut ChaCha8Rng) {
        let seen_rad = match &self.angle_error {
            None => angle_rad,
            Some(error) => angle_rad + error.at(angle_rad),
        };
        let position = seen_rad * self.counts_per_rad + self.phase; // (1)
        let count_before = self.count;
        let sign = self.sign();
        if !self.unplugged {
            self.count = self.offset + sign * position.floor() as i64; // (2)
        }
        let offset = self.offset;
        let mut false_counts = self.false_counts(end_us, rng);
        if let Some(lost) = &self.lost_lines
            && !self.unplugged
        {
            // Counts that the filter drops are missing in the direction of travel.
            let span_s = (end_us - start_us) as f64 * 1e-6;
            false_counts -= sign * lost.between(self.step.position_after, position, span_s);
        }
        self.count += false_counts;
        self.offset += false_counts;
        self.step = EncoderStep {
            start_us,
            end_us,
            count_before,
            count_after: self.count,
            position_before: self.step.position_after,
            position_after: position,
            offset,
            sign,
            false_counts,
            connected: !self.unplugged,
        };
    }

    #[inline]
    fn false_counts(&mut self, now_us: u64, rng: &mut ChaCha8Rng) -> i64 {
        let Some(noise) = &mut self.noise else { return 0 };
        let mut counts = 0;
        while noise.next_us <= now_us as f64 {
            counts += noise.direction;
            noise.next_us += noise.per_us.sample(rng);
        }
        counts
    }
}

/// What one encoder did during the last [`advance_to`](super::Plant::advance_to).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderStep {
    /// When the step began \[us\].
    pub start_us: u64,
    /// When the step ended \[us\].
    pub end_us: u64,
    /// The count at its beginning.
    pub count_before: i64,
    /// The count at its end.
    pub count_after: i64,
    position_before: f64,
    position_after: f64,
    offset: i64,
    sign: i64,
    false_counts: i64,
    connected: bool,
}

/// One edge: when, and the count from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderEdge {
    /// When \[us\], not rounded.
    pub t_us: f64,
    /// The count after the edge.
    pub count: i64,
}

impl EncoderStep {
    /// The step's edges in order of time, the wheel taken to turn evenly between its ends.
    ///
    /// That is as good as the step is short: for exact instants advance by no more than the
    /// integration step. A wheel that turned back within the step shows only the difference. False
    /// counts stand at the end.
    pub fn edges(&self) -> impl Iterator<Item = EncoderEdge> + use<> {
        let step = *self;
        let (from, to) = (step.position_before, step.position_after);
        let (first, last) = (from.floor() as i64, to.floor() as i64);
        let made = if step.connected { last.abs_diff(first) } else { 0 };
        let span_us = (step.end_us - step.start_us) as f64;
        let direction = (last - first).signum();
        let wheel = (1..=made as i64).map(move |i| {
            let cell = first + direction * i;
            // Going up, the edge into a cell is its lower end; going down, its upper one.
            let edge = if direction > 0 { cell } else { cell + 1 } as f64;
            EncoderEdge {
                t_us: step.start_us as f64
                    + span_us * ((edge - from) / (to - from)).clamp(0.0, 1.0),
                count: step.offset + step.sign * cell,
            }
        });
        let base = step.count_after - step.false_counts;
        let false_ones = (1..=step.false_counts.abs()).map(move |i| EncoderEdge {
            t_us: step.end_us as f64,
            count: base + step.false_counts.signum() * i,
        });
        wheel.chain(false_ones)
    }
}
