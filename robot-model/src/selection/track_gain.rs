//! What do tracks of runs gain by an effect that was not fitted to them, and may that be chance?
//!
//! With d_r the displacement of the wheels' contact points in run r, root of the mean square \[m\], predicted from all other
//! runs:
//!
//! ```text
//! size^2 = mean of squared displacements without the effect - with it                     (1)
//! gains d_r(without) - d_r(with) of all runs, by Wilcoxon's signed ranks                  (2)
//! ```
//!
//! A likelihood sums over all poses, of which a tracker's wobble makes hundreds err alike. Runs err independently of each
//! other: so (2) counts runs, not poses.

use crate::estimation::errors::TrackErrors;
use crate::numeric::distributions::signed_rank;

/// Of fewer runs that an effect touches, all may come nearer by chance.
const TOUCHED_MIN: usize = 6;
/// More seldom than this chance brings as many runs nearer.
const BY_CHANCE: f64 = 0.1;

/// The gain of tracks by an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TrackGain {
    /// (1) \[m\].
    pub size_m: f64,
    /// (2): the probability of as much by chance.
    by_chance: f64,
}

impl TrackGain {
    /// That of cross-validated tracks `with` an effect over those `without` it.
    pub fn new(without: &TrackErrors, with: &TrackErrors, track_width_m: f64) -> Self {
        let square_m2 = |errors: &TrackErrors| errors.displacement_m2(track_width_m);
        let each = |errors: &TrackErrors| errors.displacements_m(track_width_m);
        let gains: Vec<f64> =
            each(without).iter().zip(each(with)).map(|(without, with)| without - with).collect();
        let size_m = (square_m2(without) - square_m2(with)).max(0.0).sqrt();
        Self { size_m, by_chance: signed_rank(&gains) }
    }

    /// Whether it brings more runs nearer than chance does, if it touches enough of them for that to be judged.
    pub fn nears_runs(&self, touched: usize) -> bool {
        touched < TOUCHED_MIN || self.by_chance < BY_CHANCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_few_runs_show_is_judged_by_the_likelihood_alone() {
        let of = |by_chance: f64| TrackGain { size_m: 1e-3, by_chance };
        assert!(of(0.02).nears_runs(12) && !of(0.4).nears_runs(12));
        assert!(of(0.4).nears_runs(3));
    }
}
