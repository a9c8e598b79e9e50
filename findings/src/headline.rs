//! The main finding of an answer, for the terminal, a page and programs alike.

use robot_model::compare::{Comparer, EffectWithValues};
use robot_model::effect::{Effect, Facts, FirmwareTerm};
use robot_model::estimation::Errors;
use robot_model::explain::{Answer, HeldOut, ParameterFound, StepFound};

use crate::words;

/// Effects of an answer at the values found; the catalogue has all candidates.
pub fn effects_with_values<'a>(
    steps: &[StepFound],
    catalogue: &[&'a dyn Effect],
) -> Vec<EffectWithValues<'a>> {
    let step = |step: &StepFound| {
        let values = step.parameters.iter().map(|parameter| parameter.value).collect();
        let effect = catalogue.iter().find(|effect| effect.facts().id == step.effect)?;
        Some(EffectWithValues { effect: *effect, values, up_to_mps: None })
    };
    steps.iter().filter_map(step).collect()
}

/// The net change by each of these effects in one number, where there is one.
pub fn net_changes(comparer: &Comparer, effects: &[EffectWithValues<'_>]) -> Vec<Option<String>> {
    let change = |effect| comparer.net_change(effect).as_ref().map(words::net_change);
    effects.iter().map(change).collect()
}

/// The name of what an answer's effects are added to.
pub fn before(answer: &Answer) -> &'static str {
    if answer.known.is_empty() { "nominal robot" } else { "the model" }
}

/// What was asked.
#[derive(Clone, Copy)]
pub struct Asked<'a> {
    /// How many runs a model is fitted to.
    pub runs: usize,
    /// All candidate effects.
    pub catalogue: &'a [&'a dyn Effect],
    /// Wheel radius and track width as `robot.toml` has them \[m\].
    pub nominal_m: [f64; 2],
}

impl<'a> Asked<'a> {
    /// The facts of an effect.
    pub fn facts(&self, id: &str) -> Option<Facts<'a>> {
        self.catalogue.iter().map(|effect| effect.facts()).find(|facts| facts.id == id)
    }

    /// The plain name of an effect.
    pub fn name<'b>(&self, id: &'b str) -> &'b str
    where
        'a: 'b,
    {
        self.facts(id).map_or(id, |facts| facts.name)
    }
}

/// The main finding, in a few sentences: first what is wrong in `robot.toml`, then the effects that matter.
pub fn headline(answer: &Answer, asked: &Asked<'_>) -> String {
    let runs = asked.runs.saturating_sub(answer.runs_set_aside());
    let before = &answer.baseline.cross_validated;
    let after = answer.steps.last().map_or(before, |step| &step.cross_validated);
    let error = format!("the {} {}", kind_of_error(runs), change(before, after));
    let more = if answer.unexplained.structure {
        format!(". The residuals still depend on {}", words::depends_on(&answer.unexplained))
    } else {
        String::new()
    };
    let (matter, slight): (Vec<&StepFound>, Vec<&StepFound>) =
        answer.steps.iter().partition(|step| step.matters);
    let (matter, unsure): (Vec<&StepFound>, Vec<&StepFound>) =
        matter.into_iter().partition(|step| step.is_missing());
    let may_be_chance =
        |step: &&StepFound| !step.nears_runs && step.effect_size_m > answer.tolerance_m;
    let (chance, small): (Vec<&StepFound>, Vec<&StepFound>) =
        slight.iter().copied().partition(may_be_chance);
    let (hidden, chance): (Vec<&StepFound>, Vec<&StepFound>) =
        chance.into_iter().partition(|step| step.p_value < BEYOND_DOUBT);
    let found = match matter.as_slice() {
        [] => nothing_missing(answer, &slight, &chance, runs),
        [one] if answer.known.is_empty() => {
            format!("One effect is missing: {}. With it {error}{more}.", effect_names(one, asked))
        }
        [one] => {
            format!(
                "One more effect is missing: {}. With it {error}{more}.",
                effect_names(one, asked)
            )
        }
        steps => {
            let names: Vec<String> = steps.iter().map(|step| effect_names(step, asked)).collect();
            format!(
                "{}{} effects are missing: {}. With them {error}{more}.",
                number_word(steps.len()),
                if answer.known.is_empty() { "" } else { " more" },
                names.join("; ")
            )
        }
    };
    let first = wrong_in_robot_toml(answer, asked.catalogue, asked.nominal_m);
    let scale = camera_scale(answer, asked.catalogue);
    let small = too_small_to_matter(&small, answer, asked);
    let unsure = smaller_than_the_rest(&unsure, asked);
    [
        first,
        scale,
        Some(found),
        words::set_aside(answer),
        unsure,
        small,
        no_more_than_chance(&chance, asked),
        hidden_by_others(&hidden, asked),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<_>>()
    .join(" ")
}

/// The main finding where no effect is missing. `chance` are those of the `slight` effects that may be chance.
fn nothing_missing(
    answer: &Answer,
    slight: &[&StepFound],
    chance: &[&StepFound],
    runs: usize,
) -> String {
    let sudden = &answer.unexplained.sudden;
    if answer.set_aside.is_none() && !sudden.is_empty() {
        let runs: Vec<String> = sudden.iter().map(|found| found.run.clone()).collect();
        let them = if runs.len() == 1 { "it" } else { "them" };
        return format!(
            "In {} the robot moved for a moment as its wheels did not, which may hide other effects: drive {them} again, or remove \
             {them}. No effect that matters stands out beside that.",
            words::listed(&runs)
        );
    }
    if answer.unexplained.only_outliers() {
        return format!(
            "Nothing is missing from the robot's model, but the measured poses of {} have more outliers than noise has: look \
             for wrong time stamps, frames that come twice, blur and reflections, and for wheels that slip or counts that are lost for \
             a moment.",
            these(runs)
        );
    }
    if answer.unexplained.structure {
        return format!(
            "No known effect explains {}, but the residuals depend on {}.",
            these(runs),
            words::depends_on(&answer.unexplained)
        );
    }
    format!(
        "Nothing{} is missing{}: the residuals of {} {}.",
        match (slight, chance) {
            ([], _) => "",
            (_, []) => " that matters",
            _ => " beyond chance",
        },
        if answer.known.is_empty() { "" } else { " from the model" },
        these(runs),
        match answer.unexplained.random_turn_rad {
            None => "are noise",
            Some(_) => "depend on nothing that was tested, but are large for noise",
        }
    )
}

/// By how much this number of the firmware is off, if that matters: what may be chance, or what another effect cancels, is no
/// number to write down.
fn number_found<'a>(
    answer: &'a Answer,
    catalogue: &[&dyn Effect],
    term: FirmwareTerm,
) -> Option<&'a ParameterFound> {
    let of = |id: &str| catalogue.iter().find(|effect| effect.facts().id == id);
    let is = |step: &&StepFound| {
        of(&step.effect).and_then(|effect| effect.facts().compensated_by) == Some(term)
    };
    answer.steps.iter().find(is).filter(|step| step.matters)?.parameters.first()
}

/// A radius and a track width that are off by shares within so many sigma of each other are off by the same.
const SAME_SIGMAS: f64 = 2.0;
/// And by so many sigma from nothing.
const CLEAR_SIGMAS: f64 = 5.0;

/// That radius and track width are off by the same share, if they are: so they seem where the camera's scale is wrong.
fn camera_scale(answer: &Answer, catalogue: &[&dyn Effect]) -> Option<String> {
    let [radius, track] = [FirmwareTerm::MeanRadius, FirmwareTerm::TrackWidth]
        .map(|term| number_found(answer, catalogue, term));
    let (radius, track) = (radius?, track?);
    let apart = (radius.value - track.value).abs();
    let same = apart < SAME_SIGMAS * radius.sigma.hypot(track.sigma);
    let clear = [radius, track].iter().all(|found| found.value.abs() > CLEAR_SIGMAS * found.sigma);
    (same && clear).then(|| {
        format!(
            "Wheel radius and track width are off by the same {:.1} %: so they seem where the camera's scale is wrong. Measure a \
             distance on the floor by tape and by camera before you change robot.toml.",
            100.0 * radius.value
        )
    })
}

/// A radius or track width further off than this share is a wrong number in `robot.toml`, not a property of the robot.
const WRONG_SHARE: f64 = 0.03;

/// What `robot.toml` should say, where a number in it is far from what the runs show.
pub fn wrong_in_robot_toml(
    answer: &Answer,
    catalogue: &[&dyn Effect],
    [radius_m, track_m]: [f64; 2],
) -> Option<String> {
    let share = |term: FirmwareTerm| {
        let value = number_found(answer, catalogue, term)?.value;
        (value.abs() > WRONG_SHARE).then_some(value)
    };
    let numbers = [
        ("wheel_radius_m", radius_m, share(FirmwareTerm::MeanRadius)),
        ("track_width_m", track_m, share(FirmwareTerm::TrackWidth)),
    ];
    let wrong: Vec<String> = numbers
        .into_iter()
        .filter_map(|(key, says_m, share)| {
            Some(format!("{key} = {:.4} (now {says_m:.4})", says_m * (1.0 + share?)))
        })
        .collect();
    (!wrong.is_empty()).then(|| format!("Set {} in robot.toml.", words::listed(&wrong)))
}

/// `One effect is slight: side_slip.`, or the same of several; nothing of none.
fn effects_that(
    steps: &[&StepFound],
    asked: &Asked<'_>,
    [one, several]: [&str; 2],
) -> Option<String> {
    let names: Vec<String> = steps.iter().map(|step| effect_names(step, asked)).collect();
    let (number, names) = (number_word(steps.len()), names.join("; "));
    match steps {
        [] => None,
        [_] => Some(format!("One effect {one}: {names}.")),
        _ => Some(format!("{number} effects {several}: {names}.")),
    }
}

/// The root of the sum of their squared sizes \[m\].
fn together_m(steps: &[&StepFound]) -> f64 {
    steps.iter().map(|step| step.effect_size_m.powi(2)).sum::<f64>().sqrt()
}

/// What is there and too small to matter.
fn too_small_to_matter(steps: &[&StepFound], answer: &Answer, asked: &Asked<'_>) -> Option<String> {
    let moves_mm = at_least(1e3 * together_m(steps).max(answer.tolerance_m));
    let one = format!("is present, but moves the robot by less than {moves_mm} mm");
    let several = format!("are present, but together move the robot by less than {moves_mm} mm");
    effects_that(steps, asked, [&one, &several])
}

/// What explains less than is left unexplained.
fn smaller_than_the_rest(steps: &[&StepFound], asked: &Asked<'_>) -> Option<String> {
    let one = "explains less than is left unexplained, and may be something else";
    let several = "explain less than is left unexplained, and may be something else";
    effects_that(steps, asked, [one, several])
}

/// What the likelihood speaks for, while the runs come no nearer by it than chance explains.
fn no_more_than_chance(steps: &[&StepFound], asked: &Asked<'_>) -> Option<String> {
    let size_mm = 1e3 * together_m(steps);
    let one = format!("may be present, but the {size_mm:.1} mm that it explains may be chance");
    let several =
        format!("may be present, but the {size_mm:.1} mm that they explain together may be chance");
    effects_that(steps, asked, [&one, &several])
}

/// An effect that chance gives more seldom is there, whether or not whole runs come nearer by it.
const BEYOND_DOUBT: f64 = 1e-9;

/// What is there beyond doubt, while whole runs come no nearer by it than chance explains.
fn hidden_by_others(steps: &[&StepFound], asked: &Asked<'_>) -> Option<String> {
    let one = "is there, but other errors are so large that whole runs come no nearer by it";
    let several = "are there, but other errors are so large that whole runs come no nearer by them";
    effects_that(steps, asked, [one, several])
}

/// A number rounded up to one significant digit.
fn at_least(number: f64) -> String {
    let digit = 10.0_f64.powf(number.max(1e-3).log10().floor());
    let decimals = (-digit.log10()).max(0.0) as usize;
    format!("{:.decimals$}", (number / digit).ceil() * digit)
}

/// `cross-validated error`; of one run there is only that of the fit to it.
pub fn kind_of_error(runs: usize) -> &'static str {
    if runs == 1 { "error on the fitted run" } else { "cross-validated error" }
}

/// `this run`, `these 21 runs`.
fn these(runs: usize) -> String {
    if runs == 1 { "this run".into() } else { format!("these {runs} runs") }
}

/// `falls from 25.8 mm, 61.2 mrad to 5.0 mm, 9.1 mrad`; or rises or stays, as far as the printed digits show.
fn change(from: &Errors, to: &Errors) -> String {
    let (before, after) = (errors_text(from), errors_text(to));
    let tenths = |value: f64| (value * 1e4).round();
    let position = tenths(to.position_rms_m) - tenths(from.position_rms_m);
    let heading = tenths(to.heading_rms_rad) - tenths(from.heading_rms_rad);
    let verb = match (position, heading) {
        _ if before == after => return format!("stays at {before}"),
        (p, h) if p <= 0.0 && h <= 0.0 => "falls",
        (p, h) if p >= 0.0 && h >= 0.0 => "rises",
        _ => "changes",
    };
    format!("{verb} from {before} to {after}")
}

/// A small number in words.
pub fn number_word(n: usize) -> String {
    let words = ["Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine"];
    words.get(n).map_or_else(|| n.to_string(), |word| (*word).to_owned())
}

/// The name of an effect, with those of all that the runs cannot tell from it.
pub fn effect_names(step: &StepFound, asked: &Asked<'_>) -> String {
    let names: Vec<&str> = step.class.iter().map(|id| asked.name(id)).collect();
    names.join(" or ")
}

/// `25.8 mm, 61.2 mrad`.
pub fn errors_text(errors: &Errors) -> String {
    if errors.heading_rms_rad > 0.0 {
        format!("{:.1} mm, {:.1} mrad", errors.position_rms_m * 1e3, errors.heading_rms_rad * 1e3)
    } else {
        format!("{:.1} mm", errors.position_rms_m * 1e3)
    }
}

/// `on the 2 held-out runs (square)`.
pub fn on_held_out(held_out: &HeldOut) -> String {
    let kinds: Vec<&str> = held_out.kinds.iter().map(|kind| kind.name()).collect();
    let kinds = kinds.join(", ");
    match held_out.runs {
        1 => format!("on the held-out run ({kinds})"),
        runs => format!("on the {runs} held-out runs ({kinds})"),
    }
}

#[cfg(test)]
mod tests;
