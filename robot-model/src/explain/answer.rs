//! The answer of [`super::explain`]: verdicts and numbers.
//!
//! Sentences and JSON are made by the command.

use serde::{Deserialize, Serialize};

use crate::clocks::ClockFound;
use crate::effect::definition::Need;
use crate::estimation::errors::{ErrorPair, Errors};
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run_kind::RunKind;
use crate::residuals::unexplained::Unexplained;

/// The whole answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// Effects that the user's model has already and these runs confirm.
    pub known: Vec<StepFound>,
    /// Errors of the nominal robot, with the known effects if there are any.
    pub baseline: ErrorPair,
    /// Effects found, in order of evidence; each with the errors of a model of it and all before it.
    pub steps: Vec<StepFound>,
    /// Radii or track width that are no finding of their own, and are fitted along with those that are.
    pub fitted_along: Vec<Averaged>,
    /// Effects tested and not accepted.
    pub rejected: Vec<Rejected>,
    /// What no effect explains.
    pub unexplained: Unexplained,
    /// The cheapest run that would tell effects apart.
    pub next_run: Option<NextRun>,
    /// Errors on the held-out runs, if there are any.
    pub held_out: Option<HeldOut>,
    /// Cross-validated errors of a flexible model that knows nothing of the catalogue: what any model could reach on
    /// these runs. What lies above it is physics that is missing, what lies below is noise.
    pub reachable: Errors,
    /// Clocks of poses and wheels that do not agree, run by run; empty if all agree.
    pub clocks: Vec<ClockFound>,
    /// Plain least squares of whole tracks, or radii and track width alone (`true`), predict runs better than the choice
    /// of effects does, and are used.
    pub alternative_fit: Option<bool>,
    /// An effect that moves the robot less than this is not worth correcting \[m\].
    pub tolerance_m: f64,
    /// The model that predicts other runs: all steps that are used to predict, each class by all its members at their shares.
    pub predicts_with: Vec<Averaged>,
    /// Its errors on these runs.
    pub predicts_by: ErrorPair,
    /// The noise that goes with it.
    pub noise: OdometryNoise,
    /// The noise that [`crate::compare::Comparer::new`] estimates with these effects: it needs no fit of its own. (Of more than
    /// 500 runs that takes a share to choose the effects, and finds the same within a few percent.)
    pub compared_by: OdometryNoise,
    /// How far off the model that predicts other runs those of `unexplained.runs_off` are, if nothing else here is about them:
    /// they hid what the others show.
    #[serde(default)]
    pub set_aside: Option<Errors>,
}

/// One effect of the model that predicts other runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Averaged {
    /// Its id.
    pub effect: String,
    /// Its parameters; where the runs cannot tell effects apart, amplitudes are shares of what the effect alone would
    /// be, and their intervals reach from nothing to all of it.
    pub parameters: Vec<ParameterFound>,
    /// Where the runs cannot tell effects apart, and this one depends on speed: the mean speed of these runs. Faster, it does
    /// what it does at that speed \[m/s\].
    pub up_to_mps: Option<f64>,
}

impl Answer {
    /// How many runs are set aside.
    pub fn runs_set_aside(&self) -> usize {
        self.set_aside.map_or(0, |_| self.unexplained.runs_off.len())
    }

    /// The same answer, judged by another tolerance: what matters moves the robot beyond doubt by more than that \[m\], and
    /// brings runs nearer that it was not fitted to. What moves no track at all, such as the bias of a yaw rate sensor,
    /// matters if a robot that goes by the sensor's heading is off by more.
    pub fn with_tolerance(mut self, tolerance_m: f64) -> Self {
        self.tolerance_m = tolerance_m;
        for step in self.known.iter_mut().chain(&mut self.steps) {
            step.matters = step.matters_at(tolerance_m);
        }
        self
    }
}

/// Errors on held-out runs: nothing was fitted to them, and nothing was selected by them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// How many runs.
    pub runs: usize,
    /// Their kinds, each once, in the order of the campaign.
    pub kinds: Vec<RunKind>,
    /// Of the nominal robot, with the known effects if there are any.
    pub baseline: Errors,
    /// Of the model, fitted to all other runs.
    pub model: Errors,
}

/// One effect found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepFound {
    /// Its id.
    pub effect: String,
    /// All effects that this campaign cannot tell from it, itself included.
    pub class: Vec<String>,
    /// Its parameters, fitted with those of all steps.
    pub parameters: Vec<ParameterFound>,
    /// Errors on the runs fitted to.
    pub fitted: Errors,
    /// Cross-validated errors.
    pub cross_validated: Errors,
    /// Probability of at least as much gain by chance, given all other effects.
    pub p_value: f64,
    /// Why it is accepted.
    pub evidence: Evidence,
    /// The cross-validated error that it removes, all other effects fitted with it and without: the root of the mean
    /// squared displacement of the wheels' contact points over the user's runs. Of an effect that moves no track: how far the
    /// heading that the sensor tells would displace them \[m\].
    pub effect_size_m: f64,
    /// The lower end of its 95 % interval, with allowance for all effects that were asked for \[m\].
    pub least_size_m: f64,
    /// It acts on a sensor and moves no track.
    pub moves_no_track: bool,
    /// Of the runs that show it, or of all, more come nearer to where a fit to the others says than chance explains; where so
    /// few show it that chance may bring all of these nearer, all do.
    pub nears_runs: bool,
    /// Whether it predicts other runs: it is of radii or track width, or of a sensor, or it matters and removes more than what is
    /// left unexplained. Otherwise it is in no saved model.
    pub used_to_predict: bool,
    /// Whether it moves them by more than the tolerance, beyond doubt, and not by chance: otherwise it is there, and not worth
    /// correcting.
    pub matters: bool,
}

impl StepFound {
    /// Whether it is called missing: it matters, and removes more than what is left unexplained.
    pub fn is_missing(&self) -> bool {
        self.matters && self.used_to_predict
    }

    /// Whether it moves runs by more than a tolerance \[m\], beyond doubt, and not by chance.
    pub(crate) fn matters_at(&self, tolerance_m: f64) -> bool {
        self.least_size_m > tolerance_m && self.nears_runs
    }

    /// The errors of a model of it and all before it.
    pub(crate) fn errors(&self) -> ErrorPair {
        ErrorPair { fitted: self.fitted, cross_validated: self.cross_validated }
    }
}

/// Why an effect is accepted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// How it shows in the residuals of a model without it, from its facts.
    pub signature: String,
    /// Cross-validated: by how much -2 log likelihood falls. Where only one run shows it: on that run.
    pub gain: f64,
    /// Only one run shows it.
    pub one_run_alone: bool,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterFound {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Best value.
    pub value: f64,
    /// Standard error.
    pub sigma: f64,
    /// Lower end of the 95 % interval.
    pub low95: f64,
    /// Upper end of the 95 % interval.
    pub high95: f64,
}

impl ParameterFound {
    /// Whether its numbers are finite, and its standard error is more than zero.
    pub(crate) fn is_finite(&self) -> bool {
        let numbers = [self.value, self.sigma, self.low95, self.high95];
        numbers.into_iter().all(f64::is_finite) && self.sigma > 0.0
    }
}

/// One effect not accepted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rejected {
    /// Its id.
    pub effect: String,
    /// Why not.
    pub reason: Reason,
    /// Cross-validated errors of the model with this effect added.
    pub cross_validated: Errors,
}

/// Why an effect is not accepted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reason {
    /// The runs lack what would show it.
    Lacking(Need),
    /// The runs lack nothing and still do not show it.
    NotShown {
        /// The run that would show it, from its facts.
        shown_by: String,
    },
    /// Its value lies outside the plausible range.
    Implausible {
        /// Of its first parameter.
        value: f64,
    },
    /// Fitted to all other kinds of runs, it predicts one kind worse.
    WorseKind {
        /// Which.
        kind: RunKind,
        /// By how much in -2 log likelihood.
        loss: f64,
    },
    /// The effects of the model do nearly all that it does.
    InModel,
    /// These runs can hardly tell it from radii and track width.
    BlursGeometry {
        /// By how much more uncertain these are beside it.
        times: f64,
    },
    /// Only one run shows it, by no more than chance gives.
    OneRunByChance {
        /// The gain, minus what chance gives.
        gain: f64,
    },
    /// Cross-validated, runs are predicted worse with it.
    PredictsWorse {
        /// By how much in -2 log likelihood.
        loss: f64,
    },
    /// Of the runs that it changes, fewer get better than worse.
    FewGetBetter {
        /// How many it changes.
        touched: usize,
        /// How many of these get better.
        better: usize,
    },
    /// Runs disagree about its value.
    RunsDisagree {
        /// Variance among runs over what their noise explains.
        times: f64,
        /// Probability of as much gain by chance.
        p_value: f64,
    },
    /// Its gain is no more than chance gives when this many effects are tested.
    Chance {
        /// How many.
        tested: usize,
        /// Probability of as much gain by chance.
        p_value: f64,
    },
    /// Added to the model, it makes cross-validated tracks no better.
    TracksNoBetter {
        /// Probability of as much gain by chance.
        p_value: f64,
    },
    /// Radii and track width alone predict runs better than with it.
    SimplerPredictsBetter,
    /// Added to the final model, it fails the tests.
    DoesNotHold {
        /// Probability of as much gain by chance.
        p_value: f64,
    },
}

/// A run worth driving.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextRun {
    /// What to drive.
    pub kind: CandidateKind,
    /// The effects that it tells apart.
    pub separates: Vec<String>,
    /// What it is expected to show.
    pub predicted: PredictedSeparation,
}

/// What a run is expected to show about effects that the campaign cannot tell apart.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PredictedSeparation {
    /// The effects.
    pub class: Vec<String>,
    /// How many pairs of them predict tracks at least [`PredictedSeparation::sigmas`] apart.
    pub pairs_apart: usize,
    /// The separation, in standard errors.
    pub sigmas: f64,
    /// Whether it needs poses along the way: so far only end poses were measured.
    pub needs_poses_along_the_way: bool,
}

impl PredictedSeparation {
    /// How many pairs there are.
    pub fn pairs(&self) -> usize {
        self.class.len() * self.class.len().saturating_sub(1) / 2
    }
}

/// Runs that may be suggested, cheapest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum CandidateKind {
    /// One straight.
    Straight,
    /// Out and back.
    OutAndBack,
    /// A spin to the left and one to the right.
    SpinsBothWays,
    /// Six times out and back, short.
    ShortOutAndBacks,
    /// An arc to the left and one to the right.
    ArcsBothWays,
    /// Out and back, slow, faster, fast.
    StraightsAtThreeSpeeds,
    /// Arcs of two radii, both ways.
    ArcsOfTwoRadii,
    /// Arcs at two speeds, both ways.
    ArcsAtTwoSpeeds,
    /// A square to the left and one to the right.
    SquareBothWays,
    /// Out and back, in four headings.
    OutAndBackInFourHeadings,
    /// Out and back, empty and loaded.
    OutAndBackWithAndWithoutLoad,
    /// Out and back, an hour later.
    OutAndBackLater,
}

impl CandidateKind {
    /// Its stable name, as in files, JSON and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Straight => "straight",
            Self::OutAndBack => "out-and-back",
            Self::SpinsBothWays => "spins both ways",
            Self::ShortOutAndBacks => "six short out-and-backs",
            Self::ArcsBothWays => "arcs both ways",
            Self::StraightsAtThreeSpeeds => "straights at three speeds",
            Self::ArcsOfTwoRadii => "arcs of two radii",
            Self::ArcsAtTwoSpeeds => "arcs at two speeds",
            Self::SquareBothWays => "square both ways",
            Self::OutAndBackInFourHeadings => "out-and-back in four headings",
            Self::OutAndBackWithAndWithoutLoad => "out-and-back with and without a load",
            Self::OutAndBackLater => "out-and-back, an hour later",
        }
    }
}
