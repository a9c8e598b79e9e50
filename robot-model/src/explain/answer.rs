//! What `explain` answers: verdicts and numbers.

use crate::effect::definition::Need;
use crate::estimation::errors::{ErrorPair, Errors};
use crate::recording::run_kind::RunKind;
use crate::residuals::unexplained::Unexplained;

/// The whole answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Effects that the user's model has already and these runs bear out.
    pub known: Vec<StepFound>,
    /// The nominal robot; with the known effects, where there are any.
    pub baseline: ErrorPair,
    /// Effects found, in order of evidence; each with the errors once it and those before it are in.
    pub steps: Vec<StepFound>,
    /// Effects tested and not believed.
    pub rejected: Vec<Rejected>,
    /// What is left over.
    pub unexplained: Unexplained,
    /// The cheapest run that would tell more.
    pub next_run: Option<NextRun>,
    /// What it comes to on the runs kept aside, if there are any.
    pub held_out: Option<HeldOut>,
}

/// Errors on runs that were kept aside: nothing was fitted to them, and nothing chosen by them.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// How many runs.
    pub runs: usize,
    /// Their kinds, each once, in the order of the campaign.
    pub kinds: Vec<RunKind>,
    /// Of the nominal robot; with the known effects, where there are any.
    pub baseline: Errors,
    /// Of the model, fitted to all other runs.
    pub model: Errors,
}

/// One effect found.
#[derive(Clone, Debug, PartialEq)]
pub struct StepFound {
    /// Its id.
    pub effect: String,
    /// All that this campaign cannot tell from it, itself included.
    pub class: Vec<String>,
    /// Its parameters, fitted with those of all steps.
    pub parameters: Vec<ParameterFound>,
    /// Errors on the runs fitted to.
    pub train: Errors,
    /// Errors on runs that were predicted by a fit to the others.
    pub cross_validated: Errors,
    /// By chance at least as much gain, given all other effects.
    pub p_value: f64,
    /// Why it is believed.
    pub why: Why,
}

/// Why an effect is believed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Why {
    /// What it looks like in what is left over without it, from its facts.
    pub signature: String,
    /// By how much -2 log likelihood falls on runs that were predicted by a fit to the others; where one run alone
    /// shows it, on that run.
    pub gain: f64,
    /// One run alone shows it.
    pub one_run_alone: bool,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq)]
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

/// One effect not believed.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    /// Its id.
    pub effect: String,
    /// Why not.
    pub reason: Reason,
    /// Errors on runs that were predicted by a fit to the others, were it added.
    pub cross_validated: Errors,
}

/// Why an effect is not believed.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// The runs lack what would show it.
    Lacking(Need),
    /// The runs have what it takes and do not show it.
    NotShown {
        /// The run that would, from its facts.
        shown_by: String,
    },
    /// No robot has such a value.
    Implausible {
        /// Of its first parameter.
        value: f64,
    },
    /// Fitted to other kinds of runs it makes a kind worse.
    WorseKind {
        /// Which.
        kind: RunKind,
        /// By how much in -2 log likelihood.
        loss: f64,
    },
    /// What it does is nearly all in what the model has already.
    InModel,
    /// One run alone shows it, and that by no more than chance.
    OneRunByChance {
        /// The gain, less what chance gives.
        gain: f64,
    },
    /// Runs are predicted worse with it by a fit to the others.
    PredictsWorse {
        /// By how much in -2 log likelihood.
        loss: f64,
    },
    /// Of the runs that it touches, fewer get better than worse.
    FewGetBetter {
        /// How many it touches.
        touched: usize,
        /// How many of these get better.
        better: usize,
    },
    /// Runs disagree about it.
    RunsDisagree {
        /// So many times more than their noise, in variance.
        times: f64,
        /// By chance as much gain.
        p_value: f64,
    },
    /// No more than chance gives where so many effects are tested.
    Chance {
        /// How many.
        tested: usize,
        /// By chance as much gain.
        p_value: f64,
    },
    /// Beside the model it makes tracks no better.
    TracksNoBetter {
        /// By chance as much gain.
        p_value: f64,
    },
    /// Beside the model that was found it does not hold.
    DoesNotHold {
        /// By chance as much gain.
        p_value: f64,
    },
}

/// A run worth making.
#[derive(Clone, Debug, PartialEq)]
pub struct NextRun {
    /// What to drive.
    pub kind: PlanKind,
    /// The effects that it tells apart.
    pub separates: Vec<String>,
    /// What it would show.
    pub promise: Promise,
}

/// What a run would show about effects that nothing tells apart yet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Promise {
    /// The effects.
    pub class: Vec<String>,
    /// How many pairs of them predict tracks that lie so many sigma apart.
    pub pairs_apart: usize,
    /// So many.
    pub sigmas: f64,
    /// It takes poses along the way: so far only ends were measured.
    pub needs_poses_along_the_way: bool,
}

impl Promise {
    /// How many pairs there are.
    pub fn pairs(&self) -> usize {
        self.class.len() * self.class.len().saturating_sub(1) / 2
    }
}

/// Runs that may be suggested, cheapest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PlanKind {
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

impl PlanKind {
    /// Its stable name, as in files, in JSON and on the command line.
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
