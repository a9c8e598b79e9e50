//! What do tracks of runs gain by an effect that was not fitted to them, and may that be chance?
//!
//! With d_r the displacement of the wheels' contact points in run r, root of the mean square \[m\], predicted from all other
//! runs:
//!
//! ```text
//! size^2 = mean of squared displacements without the effect - with it                     (1)
//! the runs that show the effect: how many have d_r(without) > d_r(with)?                  (2)
//! ```
//!
//! A likelihood sums over all poses, of which a tracker's wobble makes hundreds err alike. Runs err independently of each
//! other: so (2) counts runs, not poses. A run that the effect hardly moves comes nearer or not by what is fitted along,
//! which says nothing about the effect: it has no vote.

use crate::estimation::errors::TrackErrors;
use crate::numeric::distributions::sign_test;

/// More seldom than this chance brings as many runs nearer.
const BY_CHANCE: f64 = 0.1;

/// The gain of tracks by an effect.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TrackGain {
    /// (1) \[m\].
    pub size_m: f64,
    /// Of each run, whether the effect brings its track nearer.
    nearer: Vec<bool>,
}

impl TrackGain {
    /// That of cross-validated tracks `with` an effect over those `without` it.
    pub fn new(without: &TrackErrors, with: &TrackErrors, track_width_m: f64) -> Self {
        let square_m2 = |errors: &TrackErrors| errors.displacement_m2(track_width_m);
        let each = |errors: &TrackErrors| errors.displacements_m(track_width_m);
        let both = each(without).into_iter().zip(each(with));
        let nearer = both.map(|(without, with)| without > with).collect();
        let size_m = (square_m2(without) - square_m2(with)).max(0.0).sqrt();
        Self { size_m, nearer }
    }

    /// Whether it brings more of the runs that show it nearer than chance does, by (2). So few that chance may bring all of
    /// them nearer must all come nearer.
    pub fn nears_runs(&self, shown_by: &[usize]) -> bool {
        let nearer = shown_by.iter().filter(|run| self.nearer[**run]).count();
        nearer == shown_by.len() || sign_test(nearer, shown_by.len()) < BY_CHANCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nearer(runs: &[u8]) -> TrackGain {
        TrackGain { size_m: 1e-3, nearer: runs.iter().map(|nearer| *nearer == 1).collect() }
    }

    #[test]
    fn runs_that_do_not_show_an_effect_have_no_vote() {
        // Eight runs in turns all come nearer; twelve straight ones do as chance wants.
        let gain = nearer(&[1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0]);
        let turns: Vec<usize> = (0..8).collect();
        assert!(gain.nears_runs(&turns));
        assert!(!gain.nears_runs(&(0..20).collect::<Vec<_>>()));
        assert!(!gain.nears_runs(&(8..20).collect::<Vec<_>>()));
    }

    #[test]
    fn few_runs_must_all_come_nearer() {
        let gain = nearer(&[1, 1, 0, 1, 1, 1]);
        assert!(gain.nears_runs(&[0, 1]) && gain.nears_runs(&[3]));
        assert!(!gain.nears_runs(&[1, 2]) && !gain.nears_runs(&[0, 1, 2, 3, 4]));
        assert!(gain.nears_runs(&[]), "nothing speaks against it");
    }
}
