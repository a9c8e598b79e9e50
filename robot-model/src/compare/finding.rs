//! The main finding: how far off, how much of it is not noise, and what it depends on.

use super::regime::{Grouping, RegimeError};
use super::rms::Rms;
use super::stretch::Drift;

/// A systematic error smaller than this many standard errors is not called one.
const SURE_SIGMAS: f64 = 3.0;

/// The main finding of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Whether it is about the nominal robot: the model has no effects.
    pub nominal: bool,
    /// How far off.
    pub error_level: ErrorLevel,
    /// Where it is worst.
    pub worst: Option<WorstGroup>,
}

/// How far off a model is, measured by what noise alone would give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ErrorLevel {
    /// It predicts no track that ends anywhere.
    NotFinite,
    /// No places were measured.
    NoPositions,
    /// As far as noise alone would give, over whole runs.
    WithinNoise,
    /// So many times as far as noise would give.
    TimesNoise(f64),
}

/// The group that is furthest beyond noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstGroup {
    /// Index of its [`Grouping`].
    pub grouping: usize,
    /// Its index among the grouping's groups.
    pub group: usize,
    /// What is the same in all its stretches, if that is sure.
    pub drift: Option<Drift>,
    /// Another group of the grouping has it the other way round, and is as sure.
    pub flips: bool,
}

pub(super) fn finding(
    nominal: bool,
    position_m: &Rms,
    heading_rad: &Rms,
    groupings: &[Grouping],
) -> Finding {
    let error_level = if !(position_m.rms.is_finite() && heading_rad.rms.is_finite()) {
        ErrorLevel::NotFinite
    } else if position_m.rms <= 0.0 {
        ErrorLevel::NoPositions
    } else if position_m.beyond_noise() {
        ErrorLevel::TimesNoise(position_m.rms / position_m.noise)
    } else if heading_rad.beyond_noise() {
        ErrorLevel::TimesNoise(heading_rad.rms / heading_rad.noise)
    } else {
        ErrorLevel::WithinNoise
    };
    Finding { nominal, error_level, worst: worst(groupings) }
}

/// The group that is furthest beyond noise; of a grouping with a single group only where there is no other.
fn worst(groupings: &[Grouping]) -> Option<WorstGroup> {
    let key =
        |(grouping, group): &(&Grouping, &RegimeError)| (grouping.groups.len() > 1, group.chi);
    let all = groupings.iter().enumerate().flat_map(|(k, grouping)| {
        grouping.groups.iter().enumerate().map(move |(i, group)| ((k, i), (grouping, group)))
    });
    let ((index, place), (grouping, group)) = all
        .filter(|(_, (_, group))| group.beyond_noise)
        .max_by(|(_, a), (_, b)| key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1)))?;
    let drift = Some(group.main_drift()).filter(|drift| drift.sigmas() >= SURE_SIGMAS);
    let flips = drift.is_some_and(|drift| {
        grouping.groups.iter().any(|other| {
            let there = other.drifts[drift.component as usize];
            there.sigmas() > SURE_SIGMAS && there.per_m * drift.per_m < 0.0
        })
    });
    Some(WorstGroup { grouping: index, group: place, drift, flips })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_is_no_number_is_not_taken_for_places_that_were_not_measured() {
        let rms = |rms: f64| Rms { rms, noise: 1e-3, noise_high: 2e-3 };
        for bad in [f64::NAN, f64::INFINITY] {
            for [position_m, heading_rad] in [[rms(bad), rms(1e-3)], [rms(1e-3), rms(bad)]] {
                let found = finding(false, &position_m, &heading_rad, &[]);
                assert_eq!(found.error_level, ErrorLevel::NotFinite);
            }
        }
        assert_eq!(finding(true, &rms(0.0), &rms(0.0), &[]).error_level, ErrorLevel::NoPositions);
    }
}
