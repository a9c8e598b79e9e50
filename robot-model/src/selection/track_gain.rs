//! What do tracks of runs gain by an effect that was not fitted to them, and may that be chance?
//!
//! With d_r the displacement of the wheels' contact points in run r, root of the mean square \[m\], predicted from all other
//! runs:
//!
//! ```text
//! size^2 = mean of squared displacements without the effect - with it                     (1)
//! gains d_r(without) - d_r(with) of runs, by Wilcoxon's signed ranks     (2)
//! ```
//!
//! A likelihood sums over all poses, of which a tracker's wobble makes hundreds err alike. Runs err independently of each
//! other: so (2) counts runs, not poses. A run that the effect hardly moves comes nearer or not by what is fitted along,
//! which says nothing about the effect: where only some runs show it, these alone are asked. What it does to many runs, to
//! each by less than noise, all of them may tell.

use crate::estimation::errors::TrackErrors;
use crate::numeric::distributions::signed_rank;

/// More seldom than this chance brings as many runs nearer.
const BY_CHANCE: f64 = 0.1;

/// The gain of tracks by an effect.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TrackGain {
    /// (1) \[m\].
    pub size_m: f64,
    /// By how much the effect brings the track of each run nearer \[m\].
    gains_m: Vec<f64>,
}

impl TrackGain {
    /// That of cross-validated tracks `with` an effect over those `without` it.
    pub fn new(without: &TrackErrors, with: &TrackErrors, track_width_m: f64) -> Self {
        let square_m2 = |errors: &TrackErrors| errors.displacement_m2(track_width_m);
        let each = |errors: &TrackErrors| errors.displacements_m(track_width_m);
        let both = each(without).into_iter().zip(each(with));
        let gains_m = both.map(|(without, with)| without - with).collect();
        let size_m = (square_m2(without) - square_m2(with)).max(0.0).sqrt();
        Self { size_m, gains_m }
    }

    /// Whether it brings more runs nearer than chance does, by (2): of those that show it, or of all. So few that chance may
    /// bring all of them nearer must all come nearer.
    pub fn nears_runs(&self, shown_by: &[usize]) -> bool {
        let shown_m: Vec<f64> = shown_by.iter().map(|run| self.gains_m[*run]).collect();
        let by_chance = signed_rank(&shown_m).min(signed_rank(&self.gains_m));
        shown_m.iter().all(|gain_m| *gain_m > 0.0) || by_chance < BY_CHANCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gains of some runs [mm].
    fn gain(each_mm: &[f64]) -> TrackGain {
        TrackGain { size_m: 1e-3, gains_m: each_mm.iter().map(|mm| 1e-3 * mm).collect() }
    }

    #[test]
    fn runs_that_do_not_show_an_effect_have_no_vote() {
        // Five of six runs in turns come nearer, by less than what is fitted along moves straight ones either way.
        let turns = [0.11, 0.3, 0.22, -0.05, 0.14, 0.27];
        let straight =
            [-0.9, 0.8, -0.7, 0.6, -0.5, 0.4, -0.95, 0.85, -0.75, 0.65, -0.55, 0.45, -0.6];
        let gain = gain(&[&turns[..], &straight].concat());
        assert!(gain.nears_runs(&[0, 1, 2, 3, 4, 5]));
        assert!(!gain.nears_runs(&(0..19).collect::<Vec<_>>()));
        assert!(!gain.nears_runs(&(6..19).collect::<Vec<_>>()));
    }

    #[test]
    fn many_runs_may_tell_what_each_of_them_hardly_shows() {
        // Three of five that it moves most come nearer, and twelve of fourteen others.
        let others = [0.2, 0.3, 0.1, 0.4, 0.25, -0.05, 0.15, 0.35, 0.3, 0.2, -0.1, 0.3, 0.4, 0.2];
        assert!(
            gain(&[&[0.5, -0.45, 0.6, -0.4, 0.5][..], &others].concat())
                .nears_runs(&[0, 1, 2, 3, 4])
        );
    }

    #[test]
    fn few_runs_must_all_come_nearer() {
        let gain = gain(&[0.2, 0.1, -0.3, 0.3, 0.1, 0.2]);
        assert!(gain.nears_runs(&[0, 1]) && gain.nears_runs(&[3]));
        assert!(!gain.nears_runs(&[1, 2]) && !gain.nears_runs(&[0, 1, 2, 3, 4]));
        assert!(gain.nears_runs(&[]), "nothing speaks against it");
    }
}
