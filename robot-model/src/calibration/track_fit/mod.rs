//! What does a whole measured track say about W_T?
//!
//! The path that the wheel angles predict (exact arcs, radius and track width as given) is fitted to the measured
//! points by weighted least squares. Unknown are W_T and some nuisance parameters: the pose at the first sample, a
//! common scale of both radii and, on request, the delay of the track's clock. Without the scale, the length of
//! the track would count as evidence of W_T, though it shows the tolerance of R just as much.
//!
//! **How sure.** The points of a track are not independent evidence of W_T: a disturbance that bends the real path
//! stays in every later point. So the heading may also walk at random, by as much as the track shows. The equations (1) to
//! (9) and what they achieve are in `docs/how-sure-is-w-t.md`.
//!
//! Whether the robot turns because of its radii at all is left to [`super::out_and_back`].
//!
//! | file | what it holds |
//! | --- | --- |
//! | `fit.rs` | [`fit_track`] |
//! | `result.rs` | [`FitOptions`], [`TrackFit`] |
//! | `track.rs` | [`Track`], [`WheelAngles`]: the data |
//! | `run.rs` | the predicted path, and the least-squares solution |
//! | `heading_random_walk.rs`, `average_over_variance.rs`, `residuals.rs`, `scatter.rs` | the random walk of the heading, how noisy the track is |
//! | `end_sigma.rs`, `uncertainty.rs` | the end of the run, and W_T with its whole uncertainty |

mod average_over_variance;
mod end_sigma;
mod error;
mod fit;
mod heading_random_walk;
mod residuals;
mod result;
mod run;
mod scatter;
#[cfg(test)]
mod tests;
mod track;
mod uncertainty;

pub use error::TrackFitError;
pub use fit::fit_track;
pub use result::{Estimate, FitOptions, TrackFit};
pub use track::{Track, TrackSample, WheelAngles};
