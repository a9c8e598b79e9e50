//! The cheapest run that would tell rivals apart.
//!
//! Candidate runs are driven by the model as it is, and their evidence is added to that of the campaign:
//!
//! ```text
//! d^2 = min over rival's and model's parameters of | J_e v_e - J_f v_f - J_m v_m |^2   (1)
//! ```
//!
//! over all rows of both, e the chosen effect with its fitted value and f the rival: the gain in -2 log
//! likelihood that is to be expected of the truth over the rival.

use core::f64::consts::{FRAC_PI_2, TAU};

use crate::answer::NextRun;
use crate::campaign::{Campaign, Prepared};
use crate::classes::Class;
use crate::evidence::{Evidence, amplitudes};
use crate::fit::Fitted;
use crate::increment::Term;
use crate::judge::Judgement;
use crate::path::Pose;
use crate::plan::{Drive, Piece, drive};
use crate::predict::open_loop_from;
use crate::recording::{Recording, Sight};

/// To be told apart for sure, rivals are to differ by this in -2 log likelihood: five sigma; by more where runs
/// scatter more than their noise.
const TOLD_APART: f64 = 25.0;

/// Runs that could be made: what they are called, and the pieces of each.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What they are called together.
    pub kind: &'static str,
    /// Heading at the start \[rad\], load \[kg\], pieces.
    pub runs: Vec<(f64, f64, Vec<Piece>)>,
    /// Seconds after the campaign at which they start.
    pub later_s: f64,
}

/// Everything that may be suggested, cheapest first, for a robot that drives at most this fast.
pub fn plans(speed_mps: f64) -> Vec<Plan> {
    let slow = 0.4 * speed_mps;
    let straight = |travel_m: f64, speed_mps: f64| Piece::Straight { travel_m, speed_mps };
    let back = |speed: f64| vec![straight(1.5, speed), straight(-1.5, speed)];
    let spin = |turns: f64, speed_mps| vec![Piece::Spin { turn_rad: turns * TAU, speed_mps }];
    let arc = |radius_m: f64, turns: f64, speed_mps: f64| {
        vec![Piece::Arc { radius_m, turn_rad: turns * TAU, speed_mps }]
    };
    let square = |turn_rad: f64| {
        [straight(1.0, 0.7 * speed_mps), Piece::Spin { turn_rad, speed_mps: slow }].repeat(4)
    };
    let plan = |kind, runs| Plan { kind, runs, later_s: 60.0 };
    let at = |runs: Vec<Vec<Piece>>| runs.into_iter().map(|it| (0.0, 0.0, it)).collect();
    vec![
        plan("straight", at(vec![vec![straight(1.5, 0.7 * speed_mps)]])),
        plan("out-and-back", at(vec![back(0.7 * speed_mps)])),
        plan("spins both ways", at(vec![spin(2.0, slow), spin(-2.0, slow)])),
        plan("arcs both ways", at(vec![arc(0.6, 0.9, slow), arc(0.6, -0.9, slow)])),
        plan(
            "straights at three speeds",
            at(vec![back(0.3 * speed_mps), back(0.6 * speed_mps), back(speed_mps)]),
        ),
        plan(
            "arcs of two radii",
            at(vec![
                arc(0.3, 0.9, slow),
                arc(0.3, -0.9, slow),
                arc(0.9, 0.9, slow),
                arc(0.9, -0.9, slow),
            ]),
        ),
        plan(
            "arcs at two speeds",
            at(vec![
                arc(0.6, 0.9, slow),
                arc(0.6, -0.9, slow),
                arc(0.6, 0.9, speed_mps),
                arc(0.6, -0.9, speed_mps),
            ]),
        ),
        plan("square both ways", at(vec![square(FRAC_PI_2), square(-FRAC_PI_2)])),
        plan(
            "out-and-back in four headings",
            (0..4).map(|k| (f64::from(k) * FRAC_PI_2, 0.0, back(0.7 * speed_mps))).collect(),
        ),
        plan(
            "out-and-back with and without a load",
            vec![(0.0, 0.0, back(0.7 * speed_mps)), (0.0, 5.0, back(0.7 * speed_mps))],
        ),
        Plan {
            kind: "out-and-back, an hour later",
            runs: at(vec![back(0.7 * speed_mps)]),
            later_s: 3600.0,
        },
    ]
}

/// The recordings of a plan, as the model predicts them, with a pose at every sight.
fn predicted(prepared: &Prepared, plan: &Plan, terms: &[Term<'_>]) -> Option<Prepared> {
    let settings = Drive { sample_s: 0.02, samples_per_sight: 2, ..Drive::USUAL };
    let mut runs: Vec<Recording> = Vec::new();
    let mut clock_s = prepared.survey.span_s + plan.later_s;
    // The campaign's own beginning, so that its clock and not this plan's counts.
    for (heading_rad, payload_kg, pieces) in &plan.runs {
        let mut run = drive(&prepared.robot, plan.kind, pieces, &settings);
        run.payload_kg = *payload_kg;
        let motion = crate::motion::Motion::new(&prepared.robot, &run, Some(clock_s));
        let start = Pose::new(0.0, 0.0, *heading_rad);
        let track = open_loop_from(start, &motion, &run.sights, terms);
        run.sights = track
            .measured
            .iter()
            .zip(&track.predicted)
            .map(|(sight, pose)| Sight {
                t_s: sight.t_s,
                position_m: Some([pose.x_m, pose.y_m]),
                heading_rad: Some(pose.heading_rad),
            })
            .collect();
        run.started_s = Some(clock_s);
        clock_s += run.duration_s() + 30.0;
        runs.push(run);
    }
    let mut planned = Campaign { robot: prepared.robot, runs }.prepare().ok()?;
    let began_s = prepared.survey.span_s + plan.later_s;
    for run in &mut planned.runs {
        run.motion.steps.iter_mut().for_each(|step| step.clock_s += began_s);
    }
    planned.survey = prepared.survey;
    Some(planned)
}

/// The run to make next, if any class has rivals that some run would tell apart: of the class with most
/// rivals, if there is one for it.
pub(crate) fn next_run(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    classes: &[Class<'_>],
    kept: &[Judgement],
) -> Option<NextRun> {
    let mut order: Vec<usize> =
        (0..classes.len()).filter(|it| !classes[*it].rivals.is_empty()).collect();
    order.sort_by_key(|it| core::cmp::Reverse(classes[*it].rivals.len()));
    order.into_iter().find_map(|index| {
        let told_apart = TOLD_APART * kept[index].dispersion;
        separating(prepared, fitted, (index, &classes[index]), told_apart)
    })
}

/// The cheapest run that tells most of a class apart, if any does.
fn separating(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    (index, class): (usize, &Class<'_>),
    told_apart: f64,
) -> Option<NextRun> {
    let mut terms = fitted.terms.clone();
    let in_model = terms.len();
    terms.extend(class.rivals.iter().map(|it| it.term.clone()));
    let here = Evidence::gather(prepared, &mut terms, &fitted.noise);
    let chosen = terms[index].clone();
    let own = amplitudes(chosen.effect, chosen.column?);
    let parameters = chosen.effect.facts().parameters.iter().zip(&chosen.values);
    let values: Vec<f64> = parameters
        .filter(|(it, _)| it.role == crate::effect::Role::Amplitude)
        .map(|(_, value)| *value)
        .collect();
    let rest: Vec<usize> = terms[..in_model]
        .iter()
        .enumerate()
        .filter(|(i, _)| *i != index)
        .flat_map(|(_, it)| amplitudes(it.effect, it.column.unwrap_or(0)))
        .collect();
    let rivals: Vec<(String, Vec<usize>)> = terms[in_model..]
        .iter()
        .map(|it| (it.effect.facts().id.to_owned(), amplitudes(it.effect, it.column.unwrap_or(0))))
        .collect();
    let speed_mps = prepared.survey.wheel_rate_max_rad_s * prepared.robot.wheel_radius_m;
    let mut best: Option<(usize, f64, &'static str, Vec<String>)> = None;
    for plan in plans(speed_mps.max(0.05)) {
        let Some(planned) = predicted(prepared, &plan, &fitted.terms) else { continue };
        let there = Evidence::gather(&planned, &mut terms, &fitted.noise);
        let mut sums = here.total.clone();
        sums.add(&there.total, 1.0);
        let told: Vec<f64> = rivals
            .iter()
            .map(|(_, columns)| {
                let others: Vec<usize> = rest.iter().chain(columns).copied().collect();
                here.separation(&sums, &own, &values, &others)
            })
            .collect();
        let apart = told.iter().filter(|it| **it >= told_apart).count();
        let least = told.iter().copied().fold(f64::INFINITY, f64::min);
        // Plans come cheapest first: a later one has to tell more apart.
        if apart > 0 && best.as_ref().is_none_or(|(most, ..)| apart > *most) {
            let names = rivals.iter().zip(&told).filter(|(_, it)| **it >= told_apart);
            let names = names.map(|((id, _), _)| id.clone()).collect();
            best = Some((apart, least, plan.kind, names));
        }
    }
    let (apart, _, kind, mut separates) = best?;
    let id = chosen.effect.facts().id;
    separates.insert(0, id.to_owned());
    let why = if apart == rivals.len() {
        format!("there {} and its rivals predict tracks at least five sigma apart", id)
    } else {
        format!(
            "there {} of {} rivals of {} predict tracks five sigma apart",
            apart,
            rivals.len(),
            id
        )
    };
    Some(NextRun { kind: kind.to_owned(), separates, why })
}
