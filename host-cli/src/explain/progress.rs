//! What a terminal shows while a campaign is explained: data, clocks, geometry, each effect.

use robot_model::effect::Effect;
use robot_model::explain::{Answer, Observer, Progress, explain_observed};
use robot_model::recording::RecordingError;

use crate::fit_cache::{FitCache, Question};
use crate::ui::{Steps, runs};

/// Explains a campaign whose data were checked; shows on a terminal what was found so far, unless `quiet`.
///
/// What is known already is not computed again.
pub fn explained(
    question: &Question<'_>,
    cache: &FitCache,
    quiet: bool,
) -> Result<Answer, RecordingError> {
    cache.answer(question, || explained_afresh(question, quiet))
}

fn explained_afresh(question: &Question<'_>, quiet: bool) -> Result<Answer, RecordingError> {
    let Question { campaign, catalogue, in_model } = question;
    let steps = Steps::new(quiet);
    steps.found(&format!("data of {} checked", runs(campaign.runs.len())));
    steps.now("bringing clocks together");
    let mut observer = |progress: Progress<'_>| {
        steps.found(&progress_line(&progress, catalogue));
        steps.now(match progress {
            Progress::Clocks(_) => "fitting radii and track width",
            Progress::Geometry { .. } => "searching for effects",
            Progress::Effect(_) => "fitting effects",
        });
    };
    // What is only shown is computed only if somebody sees it.
    let observer: Option<Observer<'_>> = if steps.are_seen() { Some(&mut observer) } else { None };
    explain_observed(campaign, catalogue, in_model, observer)
}

/// What was found, in a line.
pub(crate) fn progress_line(progress: &Progress<'_>, catalogue: &[&dyn Effect]) -> String {
    let name = |id: &str| {
        let effect = catalogue.iter().find(|effect| effect.facts().id == id);
        effect.map_or_else(|| id.to_owned(), |effect| effect.facts().name.to_string())
    };
    match progress {
        Progress::Clocks([]) => "clocks of poses and wheels agree".to_owned(),
        Progress::Clocks(clocks) => format!("clocks of {} corrected", runs(clocks.len())),
        Progress::Geometry { before, after } => format!(
            "radius, ratio, track: {:.1} \u{2192} {:.1} mm",
            1e3 * before.position_rms_m,
            1e3 * after.position_rms_m
        ),
        Progress::Effect(step) => {
            let mm = 1e3 * step.cross_validated.position_rms_m;
            format!("{}: {mm:.1} mm", name(&step.effect))
        }
    }
}

#[cfg(test)]
mod tests {
    use robot_model::estimation::Errors;

    use super::*;

    #[test]
    fn what_was_found_is_a_short_line() {
        let errors = |mm: f64| Errors { position_rms_m: 1e-3 * mm, ..Errors::default() };
        let geometry = Progress::Geometry { before: errors(35.1), after: errors(8.0) };
        for (progress, text) in [
            (Progress::Clocks(&[]), "clocks of poses and wheels agree"),
            (geometry, "radius, ratio, track: 35.1 \u{2192} 8.0 mm"),
        ] {
            assert_eq!(progress_line(&progress, &[]), text);
        }
    }
}
