//! Which is the cheapest run that would tell rivals apart?
//!
//! The model as it is predicts each candidate run, and the information of that run is added to that of the
//! campaign:
//!
//! ```text
//! d^2 = min over rival's and model's parameters of | J_e v_e - J_f v_f - J_m v_m |^2   (1)
//! ```
//!
//! over all rows of both, with e the true effect, v_e its fitted value, f the rival and m the rest of the model.
//! d^2 is the expected gain in -2 log likelihood of the true effect over the rival. Each member of a class may
//! be the true one.

use core::f64::consts::{FRAC_PI_2, TAU};

use crate::effect::composition::{PlacedTerm, Term, Terms};
use crate::effect::definition::Role;
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::fit::Fitted;
use crate::estimation::normal_equations::NormalEquations;
use crate::estimation::predict::open_loop_from;
use crate::explain::answer::{CandidateKind, NextRun, PredictedSeparation};
use crate::kinematics::pose::Pose;
use crate::recording::campaign::{Campaign, Prepared};
use crate::recording::motion::Motion;
use crate::recording::nominal_run::{Piece, Sampling, nominal_run};
use crate::recording::run::{PoseMeasurement, Recording};
use crate::selection::classes::Class;
use crate::selection::effect_test::{EffectTest, OWN_SHARE_MIN};

/// Rivals count as told apart if they differ by the first number of standard errors, d of (1) over the root of
/// the dispersion. Where no run achieves that, the second one will do: a class ends there.
const SIGMAS_APART: [f64; 2] = [5.0, 3.0];

/// They must also differ by this share of what the effect itself does: a millimetre between two large effects
/// may come from anything else that is wrong with a robot. Five times what a class asks for.
const SHARE_APART: f64 = 5.0 * OWN_SHARE_MIN;

/// Runs that could be driven: their name, and the pieces of each.
#[derive(Clone, Debug, PartialEq)]
pub struct CandidateRun {
    /// Their common name.
    pub kind: CandidateKind,
    /// Heading at the start \[rad\], load \[kg\], pieces.
    pub runs: Vec<(f64, f64, Vec<Piece>)>,
    /// Seconds after the campaign at which they start.
    pub later_s: f64,
}

/// All candidates that may be suggested, cheapest first, for a robot with this top speed.
pub fn candidate_runs(speed_mps: f64) -> Vec<CandidateRun> {
    let slow = 0.4 * speed_mps;
    let straight = |travel_m: f64, speed_mps: f64| Piece::Straight { travel_m, speed_mps };
    let back = |speed: f64| vec![straight(1.5, speed), straight(-1.5, speed)];
    let spin = |turns: f64, speed_mps| vec![Piece::Spin { turn_rad: turns * TAU, speed_mps }];
    let arcs = |radius_m: f64, speed_mps: f64| {
        [0.9, -0.9].map(|turns| vec![Piece::Arc { radius_m, turn_rad: turns * TAU, speed_mps }])
    };
    let square = |turn_rad: f64| {
        [straight(1.0, 0.7 * speed_mps), Piece::Spin { turn_rad, speed_mps: slow }].repeat(4)
    };
    let candidate = |kind, runs| CandidateRun { kind, runs, later_s: 60.0 };
    let at = |runs: Vec<Vec<Piece>>| runs.into_iter().map(|run| (0.0, 0.0, run)).collect();
    vec![
        candidate(CandidateKind::Straight, at(vec![vec![straight(1.5, 0.7 * speed_mps)]])),
        candidate(CandidateKind::OutAndBack, at(vec![back(0.7 * speed_mps)])),
        candidate(CandidateKind::SpinsBothWays, at(vec![spin(2.0, slow), spin(-2.0, slow)])),
        candidate(
            CandidateKind::ShortOutAndBacks,
            at(vec![[straight(0.5, 0.7 * speed_mps), straight(-0.5, 0.7 * speed_mps)].repeat(6)]),
        ),
        candidate(CandidateKind::ArcsBothWays, at(arcs(0.6, slow).to_vec())),
        candidate(
            CandidateKind::StraightsAtThreeSpeeds,
            at(vec![back(0.3 * speed_mps), back(0.6 * speed_mps), back(speed_mps)]),
        ),
        candidate(CandidateKind::ArcsOfTwoRadii, at([arcs(0.3, slow), arcs(0.9, slow)].concat())),
        candidate(
            CandidateKind::ArcsAtTwoSpeeds,
            at([arcs(0.6, slow), arcs(0.6, speed_mps)].concat()),
        ),
        candidate(CandidateKind::SquareBothWays, at(vec![square(FRAC_PI_2), square(-FRAC_PI_2)])),
        candidate(
            CandidateKind::OutAndBackInFourHeadings,
            (0..4).map(|k| (f64::from(k) * FRAC_PI_2, 0.0, back(0.7 * speed_mps))).collect(),
        ),
        candidate(
            CandidateKind::OutAndBackWithAndWithoutLoad,
            vec![(0.0, 0.0, back(0.7 * speed_mps)), (0.0, 5.0, back(0.7 * speed_mps))],
        ),
        CandidateRun {
            kind: CandidateKind::OutAndBackLater,
            runs: at(vec![back(0.7 * speed_mps)]),
            later_s: 3600.0,
        },
    ]
}

/// The recordings of a candidate as the model predicts them, with a pose at every measurement.
fn predicted(
    prepared: &Prepared,
    candidate: &CandidateRun,
    terms: &[Term<'_>],
) -> Option<Prepared> {
    let settings = Sampling { sample_s: 0.02, samples_per_pose: 2, ..Sampling::USUAL };
    let mut runs: Vec<Recording> = Vec::new();
    let mut clock_s = prepared.excitation.span_s + candidate.later_s;
    for (heading_rad, payload_kg, pieces) in &candidate.runs {
        let mut run = nominal_run(&prepared.robot, candidate.kind.name(), pieces, &settings);
        run.payload_kg = *payload_kg;
        let motion = Motion::new(&prepared.robot, &run, Some(clock_s));
        let start = Pose::new(0.0, 0.0, *heading_rad);
        let track = open_loop_from(start, &motion, &run.measured_poses, Terms::Fixed(terms));
        run.measured_poses = track
            .measured
            .iter()
            .zip(&track.predicted)
            .map(|(measurement, pose)| PoseMeasurement {
                t_s: measurement.t_s,
                position_m: Some([pose.x_m, pose.y_m]),
                heading_rad: Some(pose.heading_rad),
            })
            .collect();
        run.started_s = Some(clock_s);
        clock_s += run.duration_s() + 30.0;
        runs.push(run);
    }
    let mut planned = Campaign { robot: prepared.robot, runs }.prepare().ok()?;
    // The clock runs from the start of the campaign, not from that of the candidate.
    let began_s = prepared.excitation.span_s + candidate.later_s;
    for run in &mut planned.runs {
        run.motion.steps.iter_mut().for_each(|step| step.clock_s += began_s);
    }
    planned.excitation = prepared.excitation;
    Some(planned)
}

/// The run to drive next, if some run would tell the rivals of a class apart. The class with most rivals comes
/// first. If only end poses were measured so far, the result says that poses along the way are needed.
pub(crate) fn next_run(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    classes: &[Class<'_>],
    kept: &[EffectTest],
) -> Option<NextRun> {
    let mut order: Vec<usize> =
        (0..classes.len()).filter(|index| !classes[*index].rivals.is_empty()).collect();
    order.sort_by_key(|index| core::cmp::Reverse(classes[*index].rivals.len()));
    let next = order.into_iter().find_map(|index| {
        separating(prepared, fitted, (index, &classes[index]), kept[index].dispersion)
    })?;
    if prepared.runs.iter().any(|run| run.recording.measured_poses.len() > 2) {
        return Some(next);
    }
    let predicted = PredictedSeparation { needs_poses_along_the_way: true, ..next.predicted };
    Some(NextRun { predicted, ..next })
}

/// One effect of a class: any of them may be the true one.
struct Member {
    id: String,
    /// The columns of its amplitudes.
    columns: Vec<usize>,
    /// Their values if it is the true one.
    values: Vec<f64>,
}

/// By how many sigma each pair of members differs: `[i][j]` for i < j, the smaller one of i true and j true; zero
/// where they differ by less than [`SHARE_APART`].
struct Sigmas(Vec<Vec<f64>>);

impl Sigmas {
    fn at_least(&self, sigmas: f64) -> usize {
        self.0.iter().flatten().filter(|pair| **pair >= sigmas).count()
    }

    fn is_apart(&self, i: usize, j: usize, sigmas: f64) -> bool {
        i != j && self.0[i.min(j)][i.max(j)] >= sigmas
    }
}

/// How well a candidate tells the members of a class apart.
struct Separation {
    kind: CandidateKind,
    /// Together with the campaign.
    with_campaign: Sigmas,
    /// On its own.
    alone: Sigmas,
}

impl Separation {
    /// Candidates are compared by how many pairs they tell apart together with the campaign, then by how many on
    /// their own. A pair of which one effect does nothing in the candidate's runs is not safely told apart: anything
    /// else that those runs show would be taken for the other effect.
    fn merit(&self, sigmas: f64) -> (usize, usize) {
        (self.with_campaign.at_least(sigmas), self.alone.at_least(sigmas))
    }
}

/// The chosen effect and its rivals; `terms` are those of the model, then the rivals', with columns.
fn members(terms: &[PlacedTerm<'_>], index: usize, class: &Class<'_>) -> Vec<Member> {
    let chosen = &terms[index];
    let parameters = chosen.effect.facts().parameters.iter().zip(&chosen.values);
    let values = parameters
        .filter(|(parameter, _)| parameter.role == Role::Amplitude)
        .map(|(_, value)| *value)
        .collect();
    let member = |term: &PlacedTerm<'_>, values| {
        let (id, columns) = (term.effect.facts().id.to_owned(), term.amplitudes());
        Member { id, columns, values }
    };
    let rivals = terms[terms.len() - class.rivals.len()..].iter().zip(&class.rivals);
    let rivals = rivals.map(|(term, rival)| member(term, rival.test.values.clone()));
    core::iter::once(member(chosen, values)).chain(rivals).collect()
}

/// The cheapest run that tells most pairs of a class apart, if any does. Nobody knows which member is the true
/// one, so all pairs count.
fn separating(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    (index, class): (usize, &Class<'_>),
    dispersion: f64,
) -> Option<NextRun> {
    let mut terms = fitted.terms.clone();
    let in_model = terms.len();
    terms.extend(class.rivals.iter().map(|rival| rival.term.fixed()));
    let terms = PlacedTerm::place(&terms);
    let campaign = CampaignEquations::gather(prepared, &terms, &fitted.noise);
    let members = members(&terms, index, class);
    let rest: Vec<usize> = terms[..in_model]
        .iter()
        .enumerate()
        .filter(|(i, _)| *i != index)
        .flat_map(|(_, term)| term.amplitudes())
        .collect();
    let speed_mps = prepared.excitation.wheel_rate_max_rad_s * prepared.robot.wheel_radius_m;
    let pairs = |sums: &NormalEquations| {
        let separation = |truth: &Member, others: &[usize]| {
            campaign.separation(sums, &truth.columns, &truth.values, others)
        };
        let one_way = |truth: &Member, rival: &Member| {
            let others: Vec<usize> = rest.iter().chain(&rival.columns).copied().collect();
            let apart = separation(truth, &others);
            let is_share = apart >= SHARE_APART * separation(truth, &rest);
            if is_share { (apart / dispersion).sqrt() } else { 0.0 }
        };
        let both_ways = |i: usize, j: usize| match i < j {
            true => one_way(&members[i], &members[j]).min(one_way(&members[j], &members[i])),
            false => 0.0,
        };
        let row = |i: usize| (0..members.len()).map(|j| both_ways(i, j)).collect();
        Sigmas((0..members.len()).map(row).collect())
    };
    let mut separations = Vec::new();
    for candidate in candidate_runs(speed_mps.max(0.05)) {
        let Some(planned) = predicted(prepared, &candidate, &fitted.terms) else { continue };
        let planned = CampaignEquations::gather(&planned, &terms, &fitted.noise);
        let mut both = campaign.total.clone();
        both.add(&planned.total);
        let (with_campaign, alone) = (pairs(&both), pairs(&planned.total));
        separations.push(Separation { kind: candidate.kind, with_campaign, alone });
    }
    SIGMAS_APART.into_iter().find_map(|sigmas| {
        // Candidates come cheapest first: a later one has to tell more pairs apart.
        let best = separations.iter().rev().max_by_key(|separation| separation.merit(sigmas))?;
        (best.merit(sigmas).0 > 0).then(|| suggestion(&members, best, sigmas))
    })
}

/// A candidate as a suggestion, with what it is expected to show.
fn suggestion(members: &[Member], separation: &Separation, sigmas: f64) -> NextRun {
    let count = members.len();
    let apart = |i: usize, j: usize| separation.with_campaign.is_apart(i, j, sigmas);
    let of_chosen = (1..count).any(|j| apart(0, j));
    let separates = (0..count).filter(|i| match of_chosen {
        true => *i == 0 || apart(0, *i),
        false => (0..count).any(|j| apart(*i, j)),
    });
    let separates = separates.map(|i| members[i].id.clone()).collect();
    let predicted = PredictedSeparation {
        class: members.iter().map(|member| member.id.clone()).collect(),
        pairs_apart: separation.merit(sigmas).0,
        sigmas,
        needs_poses_along_the_way: false,
    };
    NextRun { kind: separation.kind, separates, predicted }
}
