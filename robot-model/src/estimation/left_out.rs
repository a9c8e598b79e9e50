//! By what is a run predicted that is left out of the fit?
//!
//! By a fit to all other runs. What no other run shows, such as the influence of a load in the only loaded run, they cannot
//! tell: that alone is fitted to the rest of the run itself, block by block.
//!
//! ```text
//! block k of run r:   what other runs show by a fit to them,                              (1)
//!                     what r alone shows by a fit to everything but block k                (2)
//! ```

use nalgebra::DVector;

use crate::estimation::campaign_equations::{CampaignEquations, Fold};
use crate::estimation::normal_equations::{EquationsWithout, Moved, Sums};

/// Values of some columns, as steps from the point of linearisation, that predict a run which was left out.
#[derive(Clone, Debug)]
pub(crate) struct LeftOut {
    /// By all other runs.
    pub by_others: DVector<f64>,
    /// For each block of the run, by (1) and (2); empty if the run alone shows none of the columns.
    pub by_block: Vec<DVector<f64>>,
}

impl CampaignEquations {
    /// What predicts a fold that is left out.
    pub fn left_out(&self, fold: &Fold, columns: &[usize]) -> LeftOut {
        let others = EquationsWithout::new(&self.total, vec![&fold.sums]);
        let by_others = self.best(&others, columns);
        let is_alone: Vec<bool> =
            columns.iter().map(|column| fold.alone_shows(&self.total, *column)).collect();
        if fold.blocks.is_empty() || !is_alone.contains(&true) {
            return LeftOut { by_others, by_block: Vec::new() };
        }
        let shown = |(value, alone): (&f64, &bool)| if *alone { 0.0 } else { *value };
        let delta =
            DVector::from_iterator(columns.len(), by_others.iter().zip(&is_alone).map(shown));
        let places = is_alone.iter().enumerate().filter(|(_, alone)| **alone);
        let places: Vec<usize> = places.map(|(place, _)| place).collect();
        let own: Vec<usize> = places.iter().map(|place| columns[*place]).collect();
        let by_block = fold.blocks.iter().map(|block| {
            let rest = EquationsWithout::new(&self.total, vec![block]);
            let rest = Moved { sums: &rest, columns, delta: &delta };
            let mut values = delta.clone();
            for (place, value) in places.iter().zip(&self.best(&rest, &own)) {
                values[*place] = *value;
            }
            values
        });
        LeftOut { by_block: by_block.collect(), by_others }
    }

    /// chi^2 of a fold that is left out.
    pub fn chi_squared_left_out(&self, fold: &Fold, columns: &[usize]) -> f64 {
        let LeftOut { by_others, by_block } = self.left_out(fold, columns);
        if by_block.is_empty() {
            return fold.sums.chi_squared(columns, &by_others);
        }
        let blocks = fold.blocks.iter().zip(&by_block);
        blocks.map(|(block, values)| block.chi_squared(columns, values)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::composition::{PlacedTerm, Term};
    use crate::estimation::errors::cross_validated;
    use crate::recording::campaign::Prepared;
    use crate::tests::synthetic::{NOISE, campaign, part_of_plan, term};

    /// Four runs, of which the last is loaded.
    fn one_loaded_run(truth: &[Term<'_>]) -> Prepared {
        let prepared = campaign(&part_of_plan(&["out_and_back"]), truth, 5).prepare().unwrap();
        let loaded = prepared.runs.iter().filter(|run| run.recording.payload_kg > 0.0).count();
        assert_eq!(loaded, 1);
        prepared
    }

    #[test]
    fn what_one_run_alone_shows_lowers_its_cross_validated_error() {
        let prepared = one_loaded_run(&[term("payload", &[0.003])]);
        let terms = PlacedTerm::place(&[term("payload", &[0.0])]);
        let equations = CampaignEquations::gather(&prepared, &terms, &NOISE);
        let errors =
            |columns: &[usize]| cross_validated(&prepared, (&equations, &terms), columns, &NOISE);
        let (without, with) = (errors(&[]), errors(&[0]));
        assert!(with.position_rms_m < 0.7 * without.position_rms_m, "{with:?}, {without:?}");
        assert!(with.chi < 0.95 * without.chi, "{with:?}, {without:?}");
    }

    #[test]
    fn of_a_load_that_does_nothing_chance_makes_it_no_better() {
        let prepared = one_loaded_run(&[]);
        let terms = PlacedTerm::place(&[term("payload", &[0.0])]);
        let equations = CampaignEquations::gather(&prepared, &terms, &NOISE);
        let chi_squared = |columns: &[usize]| -> f64 {
            equations.folds.iter().map(|fold| equations.chi_squared_left_out(fold, columns)).sum()
        };
        // A sigma or two of chance, less or more.
        assert!((chi_squared(&[0]) - chi_squared(&[])).abs() < 6.0);
    }

    #[test]
    fn what_other_runs_show_as_well_is_left_to_them() {
        let prepared = one_loaded_run(&[]);
        let terms = PlacedTerm::place(&[term("wheel_radius_scale", &[0.0])]);
        let equations = CampaignEquations::gather(&prepared, &terms, &NOISE);
        for fold in &equations.folds {
            let LeftOut { by_others, by_block } = equations.left_out(fold, &[0]);
            assert!(by_block.is_empty());
            let others = EquationsWithout::new(&equations.total, vec![&fold.sums]);
            assert_eq!(by_others, equations.best(&others, &[0]));
        }
    }
}
