//! Do the clocks of wheels and poses agree? Offset and rate of each run, found from the motion, before anything is
//! fitted.
//!
//! ```text
//! time of the wheels = time of the poses - offset - rate / (1 + rate) (time of the poses - middle of the run)   (1)
//! ```
//!
//! with the start of the run instead of its middle where all runs have one rate.
//!
//! An offset above zero says that the poses come late. What all runs share, up to a few tenths of a second, is left as
//! it is: that is the delay of a camera, and an effect of the catalogue. So are small differences between runs, which
//! the filter of [`crate::estimation`] has as a nuisance. What neither can absorb is corrected: offsets of seconds,
//! offsets of runs that differ by more than that, and clocks that run at different rates.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `clock_found.rs` | [`ClockFound`]: offset and rate of one run |
//! | `coarse.rs` | offsets of up to half a minute: the lag at which speeds and turn rates agree |
//! | `common_rate.rs` | one rate for all runs, where each alone is too short to tell it |
//! | `corrections.rs` | which offset and rate is taken out of each run |
//! | `drift.rs` | [`drift()`]: two clocks that drift apart over the runs of one log |
//! | `fine.rs` | offset and rate from the filter, window by window of a run |

mod clock_found;
mod coarse;
mod common_rate;
mod corrections;
mod drift;
mod fine;
mod line;
#[cfg(test)]
mod tests;

pub use clock_found::ClockFound;
pub use drift::{Drift, drift};

use crate::recording::campaign::{Campaign, Prepared};
use crate::recording::condense::WheelSamples;
use crate::recording::run::RecordingError;

/// A campaign with the times of its poses by the clock of its wheels, prepared for a fit.
pub(crate) fn prepare(campaign: &Campaign) -> Result<(Prepared, Vec<ClockFound>), RecordingError> {
    let (aligned, clocks) = align(campaign)?;
    Ok((aligned.prepare_lighter(WheelSamples::AtPoses)?, clocks))
}

/// The same campaign with clocks that are far apart brought together to a twentieth of a second: for checks of the data,
/// which come before any fit.
pub fn align_roughly(campaign: &Campaign) -> Campaign {
    let mut aligned = campaign.clone();
    match coarse::align(&mut aligned) {
        Ok(_) => aligned,
        Err(_) => campaign.clone(),
    }
}

/// The same campaign with the times of its poses by the clock of its wheels, and the runs of which they were corrected.
pub fn align(campaign: &Campaign) -> Result<(Campaign, Vec<ClockFound>), RecordingError> {
    align_all(campaign, false)
}

/// The same for two clocks that have no zero in common, but were brought together roughly: all of the offset is taken
/// out, also what could be the delay of a camera, which cannot be told from it.
pub fn align_unrelated(campaign: &Campaign) -> Result<(Campaign, Vec<ClockFound>), RecordingError> {
    align_all(campaign, true)
}

fn align_all(
    campaign: &Campaign,
    are_unrelated: bool,
) -> Result<(Campaign, Vec<ClockFound>), RecordingError> {
    let mut aligned = campaign.clone();
    let coarse_s = coarse::align(&mut aligned)?;
    // Held-out runs have clocks as well.
    let mut all = aligned.clone();
    all.runs.iter_mut().for_each(|run| run.held_out = false);
    let mut prepared = all.prepare_lighter(WheelSamples::Even)?;
    let is_shifted = |name: &str| are_unrelated || coarse_s.iter().any(|(run, _)| run == name);
    // Of two clocks with no zero in common, the drift is that of the whole log, and told from it.
    let mut clocks = fine::align(&mut prepared, &mut aligned, is_shifted, !are_unrelated);
    for clock in &mut clocks {
        if let Some((_, offset_s)) = coarse_s.iter().find(|(run, _)| *run == clock.run) {
            clock.offset_s += offset_s;
            if clock.offset_sigma_s == 0.0 {
                clock.offset_sigma_s = coarse::GRID_S;
            }
        }
    }
    clocks.retain(fine::is_reported);
    Ok((aligned, clocks))
}
