//! Which offset and rate is taken out of each run, and what is left to the effects.

use super::common_rate::CommonRate;
use super::line::{Line, SIGMAS};

/// What all runs share, up to this, is the delay of a camera and left to the effects, as long as no clock is wrong \[s\].
const DELAY_MAX_S: f64 = 0.25;
/// An offset of a run that differs from the common one is corrected from this on \[s\], and beyond chance.
const OFFSET_MIN_S: f64 = 0.015;

/// What is taken out of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Correction {
    pub(super) offset_s: f64,
    pub(super) offset_sigma_s: f64,
    pub(super) rate: f64,
}

/// The offset and rate to be taken out of each run.
pub(super) fn corrections(
    lines: &[Option<Line>],
    shifted: &[bool],
    common_rate: Option<CommonRate>,
) -> Vec<Option<Correction>> {
    let mut offsets: Vec<f64> = lines.iter().flatten().map(|line| line.offset_s).collect();
    offsets.sort_by(f64::total_cmp);
    let Some(median_s) = offsets.get(offsets.len() / 2).copied() else {
        return vec![None; lines.len()];
    };
    let most_shifted = 2 * shifted.iter().filter(|shifted| **shifted).count() > lines.len();
    let differs = |line: &Line| {
        let off_s = (line.offset_s - median_s).abs();
        off_s > OFFSET_MIN_S && off_s > SIGMAS * line.offset_sigma_s
    };
    let (centre_s, spread_s2) = scatter(lines);
    // If one run has an offset of its own, all may have. Otherwise all have the same, also those that cannot tell.
    let any = lines.iter().flatten().any(differs);
    let stays_s =
        if median_s.abs() < DELAY_MAX_S && !most_shifted && !any { median_s } else { 0.0 };
    let common = (most_shifted && !any).then(|| mean(lines));
    lines
        .iter()
        .zip(shifted)
        .map(|(line, shifted)| {
            if let (Some((offset_s, offset_sigma_s)), true) = (common, *shifted) {
                let rate = common_rate.and(*line).map_or(0.0, |line| line.rate);
                return Some(Correction { offset_s, offset_sigma_s, rate });
            }
            let line = (*line)?;
            let sure = spread_s2 / (spread_s2 + line.offset_sigma_s.powi(2));
            let offset_s = match (shifted, any) {
                (true, _) => line.offset_s - stays_s,
                (false, true) if differs(&line) => line.offset_s,
                // What a run hardly tells is taken for what runs differ by.
                (false, true) => centre_s + sure * (line.offset_s - centre_s),
                (false, false) => 0.0,
            };
            let has_rate = common_rate.is_some() || line.tells_rate();
            let rate = if has_rate { line.rate } else { 0.0 };
            let offset_sigma_s = line.offset_sigma_s;
            let found = Correction { offset_s, offset_sigma_s, rate };
            (offset_s != 0.0 || rate != 0.0).then_some(found)
        })
        .collect()
}

/// The mean and the variance of the true offsets of these runs \[s, s^2\].
fn scatter(lines: &[Option<Line>]) -> (f64, f64) {
    let mut known: Vec<&Line> = lines.iter().flatten().collect();
    known.sort_by(|a, b| a.offset_sigma_s.total_cmp(&b.offset_sigma_s));
    // Those that tell it best, as the others add their own errors.
    known.truncate(known.len().div_ceil(2).max(3));
    let n = known.len().max(1) as f64;
    let mean_s = known.iter().map(|line| line.offset_s).sum::<f64>() / n;
    let excess = |line: &&Line| (line.offset_s - mean_s).powi(2) - line.offset_sigma_s.powi(2);
    (mean_s, (known.iter().map(excess).sum::<f64>() / n).max(1e-8))
}

/// The mean offset of these runs, by their standard errors, and its own \[s\].
fn mean(lines: &[Option<Line>]) -> (f64, f64) {
    let weight = |line: &Line| line.offset_sigma_s.max(1e-4).powi(-2);
    let (sum, weights) = lines.iter().flatten().fold((0.0, 0.0), |(sum, weights), line| {
        (sum + weight(line) * line.offset_s, weights + weight(line))
    });
    let weights = weights.max(f64::MIN_POSITIVE);
    (sum / weights, weights.sqrt().recip())
}
