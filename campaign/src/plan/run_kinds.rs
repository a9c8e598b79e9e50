//! Which runs a user can add to a campaign, by their kind: those that `explain` suggests as the
//! next run, as it planned them, and the kinds into which it sorts runs.

use std::f64::consts::TAU;
use std::path::Path;

use robot_model::explain::candidate_runs;
use robot_model::recording::Piece;

use super::default_plan::PlanSettings;
use super::file::plan_path;
use super::floor::Floor;
use super::{CampaignPlan, PlanError, PlannedRun};
use crate::recorded::plain;
use crate::{Campaign, Row};

/// Runs to add to a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtraRuns {
    /// The runs.
    pub plan: CampaignPlan,
    /// They start at least this long after the campaign's last run \[s\].
    pub later_s: f64,
}

/// Every kind that can be asked for.
pub fn kinds() -> Vec<&'static str> {
    let mut kinds = vec!["rest", "spin", "arc", "square"];
    kinds.extend(candidate_runs(1.0).into_iter().map(|candidate| candidate.kind.name()));
    kinds
}

/// The greatest wheel speed of the campaign in a folder \[m/s\]: by its plan, or as recorded.
///
/// `explain` plans the next run for this speed.
pub fn fastest_mps(folder: &Path, campaign: &Campaign) -> Option<f64> {
    let robot = &campaign.robot;
    if let Ok(plan) = CampaignPlan::read(&plan_path(folder)) {
        let all = plan.runs.iter().flat_map(|run| &run.pieces);
        let driven = all.filter(|piece| !matches!(piece, Piece::Rest { .. }));
        let wheel_mps = driven.map(|piece| piece.wheels(robot.track_width_m).1);
        let fastest = wheel_mps.reduce(f64::max);
        if fastest.is_some() {
            return fastest;
        }
    }
    let each = campaign.runs.iter().filter_map(|run| fastest_counts_s(&run.rows));
    let m_per_count = TAU * robot.wheel_radius_m / (robot.counts_per_rev * robot.gear_reduction);
    // In whole millimetres per second: a recording is not more exact.
    each.reduce(f64::max).map(|counts_s| (counts_s * m_per_count * 1e3).round() / 1e3)
}

/// The greatest mean speed of a wheel over a fifth of a second \[counts/s\].
fn fastest_counts_s(rows: &[Row]) -> Option<f64> {
    const WINDOW_S: f64 = 0.2;
    let wheels: Vec<(f64, [f64; 2])> = rows
        .iter()
        .filter_map(|row| Some((row.t_s, [row.counts.left?, row.counts.right?])))
        .collect();
    let mut first = 0;
    let mut fastest: Option<f64> = None;
    for (t_s, counts) in &wheels {
        while wheels.get(first + 1).is_some_and(|next| t_s - next.0 >= WINDOW_S) {
            first += 1;
        }
        let (before_s, before) = wheels[first];
        if t_s - before_s >= WINDOW_S {
            for (now, then) in counts.iter().zip(before) {
                let rate = (now - then).abs() / (t_s - before_s);
                fastest = Some(fastest.map_or(rate, |fastest| fastest.max(rate)));
            }
        }
    }
    fastest
}

/// Refuses a run that needs more floor than there is, whichever way it is turned.
fn check_floor(run: &PlannedRun, settings: &PlanSettings) -> Result<(), PlanError> {
    let sorted = |[a, b]: [f64; 2]| if a <= b { [a, b] } else { [b, a] };
    let size_m = Floor::of(&run.pieces, settings.track_width_m).size_m();
    let (needed, there) = (sorted(size_m), sorted(settings.floor_m));
    // Equal up to rounding.
    if needed.iter().zip(there).all(|(needed, there)| *needed <= there + 1e-6) {
        return Ok(());
    }
    let up = |m: f64| (m * 10.0).ceil() / 10.0;
    Err(PlanError::RunTooLarge { kind: run.kind.clone(), needed_m: needed.map(up), floor_m: there })
}

/// Names that no run has yet.
struct FreeNames(Vec<String>);

impl FreeNames {
    /// This name, with a number behind it if it is taken.
    fn of(&mut self, name: &str) -> String {
        let numbered = (1..).map(|n| if n == 1 { name.into() } else { format!("{name}_{n}") });
        let free: String =
            numbered.into_iter().find(|name| !self.0.contains(name)).unwrap_or_default();
        self.0.push(free.clone());
        free
    }
}

/// A run of the campaign's plan once more, by its name there or as it was recorded. `taken` are the names that the
/// campaign has already.
pub fn once_more(name: &str, plan: &CampaignPlan, taken: &[String]) -> Option<ExtraRuns> {
    let run = plan.runs.iter().find(|run| run.name == name || run.name == plain(name))?;
    let name = FreeNames(taken.to_vec()).of(&run.name);
    let runs = vec![PlannedRun { name, ..run.clone() }];
    Some(ExtraRuns { plan: CampaignPlan { runs, ..*plan }, later_s: 0.0 })
}

/// The runs of a kind. `taken` are the names that the campaign has already.
pub fn runs_of(
    kind: &str,
    settings: &PlanSettings,
    taken: &[String],
) -> Result<ExtraRuns, PlanError> {
    let fast_mps = settings.speeds_mps[1];
    let (later_s, runs) = match kind {
        "rest" => (0.0, vec![(0.0, 0.0, vec![Piece::Rest { duration_s: 10.0 }])]),
        // `explain` suggests both ways together; this is one of them.
        "spin" | "arc" | "square" => {
            let both = match kind {
                "square" => "square both ways".to_owned(),
                one => format!("{one}s both ways"),
            };
            let candidate = candidate_runs(fast_mps)
                .into_iter()
                .find(|candidate| candidate.kind.name() == both);
            (0.0, candidate.map_or_else(Vec::new, |candidate| candidate.runs[..1].to_vec()))
        }
        kind => match candidate_runs(fast_mps)
            .into_iter()
            .find(|candidate| candidate.kind.name() == kind)
        {
            Some(candidate) => (candidate.later_s, candidate.runs),
            None => return Err(PlanError::UnknownKind(kind.into())),
        },
    };
    let slug: String =
        kind.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let slug = slug.replace("__", "_");
    let mut names = FreeNames(taken.to_vec());
    let runs: Vec<_> = runs
        .into_iter()
        .map(|(heading_rad, payload_kg, pieces)| PlannedRun {
            name: names.of(&slug),
            kind: kind.into(),
            heading_rad,
            payload_kg,
            // The run is driven to tell effects apart, so the model must be fitted to it.
            held_out: false,
            shows: String::new(),
            pieces: pieces
                .into_iter()
                .map(|piece| piece.capped(settings.track_width_m, fast_mps))
                .collect(),
        })
        .collect();
    runs.iter().try_for_each(|run| check_floor(run, settings))?;
    let plan = CampaignPlan { acceleration_mps2: settings.acceleration_mps2, runs };
    Ok(ExtraRuns { plan, later_s })
}

#[cfg(test)]
mod tests {
    use shared_proto::WheelPair;

    use super::*;
    use crate::{RobotFile, Run, RunFacts};

    #[test]
    fn whatever_may_be_suggested_can_be_driven_by_its_name_within_the_speed_asked_for() {
        let settings = PlanSettings::default();
        assert!(kinds().len() > 11);
        for kind in kinds() {
            let extra = runs_of(kind, &settings, &[]).unwrap();
            assert!(!extra.plan.runs.is_empty(), "{kind}");
            assert!(extra.plan.runs.iter().all(|run| !run.held_out), "{kind}");
            for run in &extra.plan.runs {
                for piece in &run.pieces {
                    let (_, wheel_mps) = piece.wheels(settings.track_width_m);
                    assert!(wheel_mps <= 0.35 + 1e-12, "{kind}");
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
    fn a_run_of_the_plan_is_driven_once_more_by_its_name_or_its_recordings() {
        let plan = CampaignPlan::usual(&PlanSettings::default()).unwrap();
        let planned = plan.runs.last().unwrap();
        let taken: Vec<String> = plan.runs.iter().map(|run| run.name.clone()).collect();
        for name in [planned.name.clone(), format!("21_{}", planned.name)] {
            let again = once_more(&name, &plan, &taken).unwrap();
            let named = format!("{}_2", planned.name);
            assert_eq!(again.plan.runs, [PlannedRun { name: named, ..planned.clone() }]);
            assert_eq!(again.plan.acceleration_mps2, plan.acceleration_mps2);
        }
        assert_eq!(once_more("21_loop", &plan, &taken), None);
    }

    #[test]
    fn another_kind_is_refused_with_the_list() {
        let error = runs_of("loop", &PlanSettings::default(), &[]).unwrap_err();
        assert_eq!(error, PlanError::UnknownKind("loop".into()));
        assert!(kinds().contains(&"arcs of two radii"));
    }

    #[test]
    fn a_run_that_does_not_fit_on_the_floor_is_refused_with_what_it_needs() {
        let floor_m = |floor_m: [f64; 2]| PlanSettings { floor_m, ..PlanSettings::default() };
        let error = runs_of("arcs of two radii", &floor_m([2.0, 2.0]), &[]).unwrap_err();
        // Two radii of 0.9 m and a track width on each side.
        assert!(error.to_string().contains("needs a floor of 2.6 m by 2.6 m"), "{error}");
        assert!(runs_of("arcs of two radii", &floor_m([2.6, 2.6]), &[]).is_ok());
        // A straight fits lengthwise, whichever side of the floor is named first.
        for room_m in [[2.3, 0.8], [0.8, 2.3]] {
            assert!(runs_of("straight", &floor_m(room_m), &[]).is_ok());
            assert!(runs_of("square", &floor_m(room_m), &[]).is_err());
        }
    }

    #[test]
    fn a_campaigns_speed_is_its_plans_or_as_recorded() {
        let folder = tempfile::tempdir().unwrap();
        // 900 counts are a turn of 36 mm: 1000 counts a second on the right are 0.251 m/s.
        let row = |t_s: f64| Row {
            t_s,
            counts: WheelPair::new(Some(100.0 * t_s), Some(-(1000.0 * t_s).round())),
            ..Row::default()
        };
        let rows = (0..100).map(|k| row(0.02 * f64::from(k))).collect();
        let run = Run { name: "01_a".into(), facts: RunFacts::default(), rows };
        let robot = RobotFile::of(&shared_proto::Config::default());
        let mut campaign =
            Campaign { robot, runs: vec![run], copies: Vec::new(), warnings: Vec::new() };
        let expected = (1000.0 * TAU * 0.036 / 900.0 * 1e3).round() / 1e3;
        assert_eq!(fastest_mps(folder.path(), &campaign), Some(expected));
        campaign.runs.clear();
        assert_eq!(fastest_mps(folder.path(), &campaign), None);
        let plan = CampaignPlan::usual(&PlanSettings {
            speeds_mps: [0.1, 0.21],
            ..PlanSettings::default()
        });
        std::fs::write(plan_path(folder.path()), plan.unwrap().to_toml()).unwrap();
        let planned = fastest_mps(folder.path(), &campaign).unwrap();
        assert!((planned - 0.21).abs() < 1e-5, "{planned}");
    }
}
