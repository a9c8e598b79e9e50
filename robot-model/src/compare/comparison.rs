//! The comparison of a campaign with a model, given the campaign's noise.
//!
//! The noise is found by `selection`; the parts of the comparison are in the files beside this one.

use super::curve::{self, Curve};
use super::finding::{Finding, finding};
use super::regime::{self, Grouping};
use super::rms::Rms;
use super::whole_runs::{self, Path, RunCompared, RunPredicted};

use crate::clocks;
use crate::effect::catalogue::CATALOGUE;
use crate::effect::composition::Term;
use crate::effect::definition::Effect;
use crate::effect::net_change::{NetChange, net_change};
use crate::estimation::fit::fit_noise;
use crate::estimation::most_likely_noise::Search;
use crate::explain::held_out;
use crate::recording::campaign::{Campaign, Prepared, PreparedRun};
use crate::recording::condense::WheelSamples;
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::RecordingError;
use crate::selection::select::select;

/// An effect with given values of its parameters: one part of a model that is taken as it is.
#[derive(Clone, Debug)]
pub struct EffectWithValues<'a> {
    /// The effect.
    pub effect: &'a dyn Effect,
    /// Its parameters' values.
    pub values: Vec<f64>,
    /// Faster than this it does what it does at this speed of the faster wheel \[m/s\].
    pub up_to_mps: Option<f64>,
}

/// The whole comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The main finding.
    pub finding: Finding,
    /// Distance between predicted and measured places, over all runs but those held out \[m\].
    pub position_m: Rms,
    /// Between headings \[rad\].
    pub heading_rad: Rms,
    /// Distance and heading on the held-out runs \[m\], \[rad\]; `None` if there are none.
    pub held_out: Option<[Rms; 2]>,
    /// Each run; those held out come last.
    pub runs: Vec<RunCompared>,
    /// What the error may depend on, each grouping with its groups.
    pub regimes: Vec<Grouping>,
}

/// A campaign with its noise, ready to be compared with any model.
#[derive(Debug)]
pub struct Comparer {
    prepared: Prepared,
    /// The runs held out.
    held_out: Prepared,
    noise: OdometryNoise,
}

impl Comparer {
    /// Estimates the noise: the residual with those effects of the catalogue and of `more` that `explain` accepts. Of
    /// more than `CHOOSING_RUNS_MAX` runs a share chooses the effects, and all tell the noise.
    pub fn new(campaign: &Campaign, more: &[&dyn Effect]) -> Result<Self, RecordingError> {
        let aligned = clocks::align(campaign)?.0;
        let mut effects: Vec<&dyn Effect> = CATALOGUE.to_vec();
        effects.extend(more);
        let lighter = aligned.prepare_lighter(WheelSamples::AtPoses)?;
        let noise = match share(&aligned) {
            None => select(&lighter, &effects).fitted.noise,
            Some(share) => {
                let chosen =
                    select(&share.prepare_lighter(WheelSamples::AtPoses)?, &effects).fitted;
                fit_noise(&lighter, &chosen.terms, chosen.noise, Search::Near)
            }
        };
        let noise = noise.of_one_pose(lighter.poses_in_one);
        Ok(Self::of(aligned.prepare()?, noise))
    }

    /// With a known noise.
    pub fn with_noise(campaign: &Campaign, noise: OdometryNoise) -> Result<Self, RecordingError> {
        Ok(Self::of(clocks::align(campaign)?.0.prepare()?, noise))
    }

    fn of(mut prepared: Prepared, noise: OdometryNoise) -> Self {
        let mut held_out = held_out::only(&prepared);
        prepared.runs.iter_mut().chain(&mut held_out.runs).for_each(set_headings);
        Self { prepared, held_out, noise }
    }

    /// The noise.
    pub fn noise(&self) -> &OdometryNoise {
        &self.noise
    }

    /// Compares this model with the campaign.
    pub fn compare(&self, model: &[EffectWithValues<'_>]) -> Comparison {
        let terms = terms(model);
        let mut runs = whole_runs::runs(0, &self.prepared, &terms, &self.noise);
        let [position_m, heading_rad] = whole_runs::overall(&runs);
        let apart = whole_runs::runs(runs.len(), &self.held_out, &terms, &self.noise);
        let held_out = (!apart.is_empty()).then(|| whole_runs::overall(&apart));
        runs.extend(apart);
        let regimes = regime::groupings(&self.prepared, &terms, &self.noise);
        let finding = finding(model.is_empty(), &position_m, &heading_rad, &regimes);
        Comparison { finding, position_m, heading_rad, held_out, runs, regimes }
    }

    /// The predicted path of each run beside the measured one; those held out last.
    pub fn paths(&self, model: &[EffectWithValues<'_>]) -> Vec<Path> {
        let paths = |of: &Prepared| whole_runs::paths(of, &terms(model), &self.noise);
        [paths(&self.prepared), paths(&self.held_out)].concat()
    }

    /// The poses that the model predicts for each run beside those measured; the runs held out come last.
    pub fn predicted(&self, model: &[EffectWithValues<'_>]) -> Vec<RunPredicted> {
        let runs = |of: &Prepared| whole_runs::predicted(of, &terms(model), &self.noise);
        [runs(&self.prepared), runs(&self.held_out)].concat()
    }

    /// The residual of the model against everything it might depend on.
    pub fn curves(&self, model: &[EffectWithValues<'_>]) -> Vec<Curve> {
        curve::curves(&self.prepared, &terms(model), &self.noise)
    }

    /// What an effect does in these runs in all, in one plain number, if one says most of it.
    pub fn net_change(&self, effect: &EffectWithValues<'_>) -> Option<NetChange> {
        net_change(&self.prepared, &terms(std::slice::from_ref(effect))[0])
    }
}

/// About so many runs at most choose the effects without which the noise is measured: what these do not show moves no pose by
/// much of its noise.
pub(super) const CHOOSING_RUNS_MAX: usize = 500;

/// Runs of a campaign that has many: evenly spread, but with no period, as the kinds of runs in a plan often have one.
pub(super) fn share(campaign: &Campaign) -> Option<Campaign> {
    /// Its multiples fall evenly between whole numbers.
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let share = CHOOSING_RUNS_MAX as f64 / campaign.runs.len() as f64;
    (share < 1.0).then(|| {
        let chosen = |index: usize| (index as f64 * GOLDEN).fract() < share;
        let runs = campaign.runs.iter().enumerate().filter(|(index, _)| chosen(*index));
        Campaign { robot: campaign.robot, runs: runs.map(|(_, run)| run.clone()).collect() }
    })
}

/// Sets the heading of each step: the last one measured before it, carried on by the wheels.
fn set_headings(run: &mut PreparedRun) {
    let mut measurements = run
        .recording
        .measured_poses
        .iter()
        .filter_map(|measurement| Some((measurement.t_s, measurement.heading_rad?)));
    let mut next = measurements.next();
    let mut heading_rad = next.map_or(0.0, |(_, heading_rad)| heading_rad);
    let mut now_s = run.motion.start_s;
    for step in &mut run.motion.steps {
        while let Some((_, measured)) = next.filter(|(t_s, _)| *t_s <= now_s) {
            heading_rad = measured;
            next = measurements.next();
        }
        let turn_rad = step.turn_rad();
        step.heading_rad = heading_rad + turn_rad / 2.0;
        heading_rad += turn_rad;
        now_s += step.dt_s;
    }
}

fn terms<'a>(model: &[EffectWithValues<'a>]) -> Vec<Term<'a>> {
    let term = |effect: &EffectWithValues<'a>| Term {
        up_to_mps: effect.up_to_mps,
        ..Term::new(effect.effect, effect.values.clone())
    };
    model.iter().map(term).collect()
}
