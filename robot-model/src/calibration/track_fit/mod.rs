//! W_T from a whole measured track.
//!
//! The path that the wheel angles predict (exact arcs, radius and track width as given) is laid on
//! the measured points by weighted least squares. Unknown are W_T, the pose at the first sample
//! (always a nuisance, never evidence), a common scale of both radii (a nuisance too: else the length
//! of the track, which says as much of the tolerance of R as of W_T, would pass for evidence) and, if
//! asked for, the delay of the track's clock.
//!
//! **How sure.** Points of a track are not independent evidence of W_T: what bends the real path,
//! beyond the wheels, stays in every later point. So the path is also allowed to wander, by as much
//! as the track itself tells. The equations, numbered (1) to (9), and what they achieve stand in
//! `docs/how-sure-is-w-t.md`.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `fit.rs` | [`fit_track`] |
//! | `result.rs` | [`FitOptions`], [`TrackFit`] |
//! | `track.rs` | [`Track`], [`WheelAngles`]: the data |
//! | `run.rs` | the path that they predict, and the least-squares solution |
//! | `wander.rs`, `average.rs`, `residuals.rs`, `scatter.rs` | how much the path wanders, how noisy the track is |
//! | `end.rs`, `uncertainty.rs` | the end of the run, and W_T with its whole uncertainty |

mod average;
mod end;
mod error;
mod fit;
mod residuals;
mod result;
mod run;
mod scatter;
#[cfg(test)]
mod tests;
mod track;
mod uncertainty;
mod wander;

pub use error::TrackFitError;
pub use fit::fit_track;
pub use result::{Estimate, FitOptions, TrackFit};
pub use track::{Track, TrackSample, WheelAngles};
