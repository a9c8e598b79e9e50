//! Single kinds of runs, to add to a campaign: those that `explain` suggests as the next run, driven
//! as it planned them, and the kinds that it sorts runs into.

use robot_model::next_run::plans;
use robot_model::plan::Piece;

use super::piece::capped;
use super::plan::{Plan, PlanSettings, PlannedRun};
use crate::error::{Error, Result};

/// Runs to add to a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Extra {
    /// The runs.
    pub plan: Plan,
    /// They are to start at least this long after the campaign's last run \[s\].
    pub later_s: f64,
}

/// Every kind that can be asked for.
pub fn kinds() -> Vec<&'static str> {
    let mut kinds = vec!["rest", "spin", "arc", "square"];
    kinds.extend(plans(1.0).into_iter().map(|plan| plan.kind));
    kinds
}

/// The runs of a kind. `taken` are names that the campaign has already.
pub fn runs_of(kind: &str, settings: &PlanSettings, taken: &[String]) -> Result<Extra> {
    let fast_mps = settings.speeds_mps[1];
    let (later_s, runs) = match kind {
        "rest" => (0.0, vec![(0.0, 0.0, vec![Piece::Rest { duration_s: 10.0 }])]),
        // One of the two that are suggested together.
        "spin" | "arc" | "square" => {
            let both = match kind {
                "square" => "square both ways".to_owned(),
                one => format!("{one}s both ways"),
            };
            let plan = plans(fast_mps).into_iter().find(|plan| plan.kind == both);
            (0.0, plan.map_or_else(Vec::new, |plan| plan.runs[..1].to_vec()))
        }
        kind => match plans(fast_mps).into_iter().find(|plan| plan.kind == kind) {
            Some(plan) => (plan.later_s, plan.runs),
            None => {
                return Err(Error::new(format_args!("`{kind}` is not a kind of run"))
                    .hint(format_args!("one of: {}", kinds().join("; "))));
            }
        },
    };
    let slug: String =
        kind.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let slug = slug.replace("__", "_");
    let mut taken = taken.to_vec();
    let mut free = |slug: &str| {
        let numbered = (1..).map(|n| if n == 1 { slug.into() } else { format!("{slug}_{n}") });
        let name: String = numbered.into_iter().find(|it| !taken.contains(it)).unwrap_or_default();
        taken.push(name.clone());
        name
    };
    let runs = runs.into_iter().map(|(heading_rad, payload_kg, pieces)| PlannedRun {
        name: free(&slug),
        kind: kind.into(),
        heading_rad,
        payload_kg,
        shows: String::new(),
        pieces: pieces.into_iter().map(|it| capped(it, settings.track_width_m, fast_mps)).collect(),
    });
    let plan = Plan { acceleration_mps2: settings.acceleration_mps2, runs: runs.collect() };
    Ok(Extra { plan, later_s })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::piece;

    #[test]
    fn whatever_may_be_suggested_can_be_driven_by_its_name_within_the_speed_asked_for() {
        let settings = PlanSettings::default();
        assert!(kinds().len() > 11);
        for kind in kinds() {
            let extra = runs_of(kind, &settings, &[]).unwrap();
            assert!(!extra.plan.runs.is_empty(), "{kind}");
            for run in &extra.plan.runs {
                for it in &run.pieces {
                    let motion = piece::motion(it, settings.track_width_m, 0.3);
                    assert!(motion.is_none_or(|it| it.cruise <= 0.35 + 1e-12), "{kind}");
                }
            }
        }
    }

    #[test]
    fn a_kind_driven_again_gets_names_of_its_own() {
        let taken = ["spins_both_ways".to_owned(), "spins_both_ways_2".to_owned()];
        let extra = runs_of("spins both ways", &PlanSettings::default(), &taken).unwrap();
        let names: Vec<_> = extra.plan.runs.iter().map(|run| run.name.as_str()).collect();
        assert_eq!(names, ["spins_both_ways_3", "spins_both_ways_4"]);
        let hour = runs_of("out-and-back, an hour later", &PlanSettings::default(), &[]).unwrap();
        assert_eq!(
            (hour.later_s, hour.plan.runs[0].name.as_str()),
            (3600.0, "out_and_back_an_hour_later")
        );
    }

    #[test]
    fn another_kind_is_refused_with_the_list() {
        let error = runs_of("loop", &PlanSettings::default(), &[]).unwrap_err();
        assert!(error.hint_text().unwrap().contains("arcs of two radii"), "{error:?}");
    }
}
