//! The next run: what to drive, what it takes, and the command that does it.

use std::path::Path;

use findings::words;
use robot_model::effect::{ActsOn, find};
use robot_model::explain::{Answer, NextRun};

use super::context::AnswerContext;
use crate::cli::Common;
use crate::escape::{shell, shell_path};
use crate::port::Port;
use campaign::plan::run_kinds::once_more;
use campaign::plan::{CampaignPlan, plan_path};
use campaign::{Campaign, RobotFile};

/// What is said where no run tells effects apart, and the command if a run is to be driven again.
pub(crate) fn no_next_run(
    answer: &Answer,
    context: &AnswerContext<'_>,
) -> (String, Option<String>) {
    match words::drive_again(&answer.unexplained, &context.runs, &context.motions) {
        Some(again) => (again.words, drive_again_command(&again.runs, context)),
        None => (no_run(answer), None),
    }
}

/// The sentence where no run is suggested.
fn no_run(answer: &Answer) -> String {
    let open = answer.steps.iter().filter(|step| step.class.len() > 1);
    let open: Vec<String> = open
        .map(|step| {
            let others = step.class.iter().filter(|id| **id != step.effect).cloned();
            format!("{} from {}", step.effect, others.collect::<Vec<_>>().join(" or "))
        })
        .collect();
    if open.is_empty() && answer.unexplained.structure {
        let shape = "No run can be suggested for what is still unexplained: no effect of the catalogue has that shape.";
        return match words::driven_again(&answer.unexplained) {
            Some(_) => shape.to_owned(),
            None => {
                format!("{shape} Drive one of these runs twice more: what comes back is no noise.")
            }
        };
    }
    if open.is_empty() {
        return "No further run is needed to tell effects apart.".into();
    }
    format!("No run that beeline can plan distinguishes {}.", open.join(", nor "))
}

/// What a next run needs besides driving: one about the gyro needs its log.
pub(crate) fn gyro_words(next: &NextRun) -> Option<&'static str> {
    let of_gyro =
        |id: &String| find(id).is_some_and(|effect| effect.facts().acts_on == ActsOn::Gyro);
    next.separates.iter().any(of_gyro).then_some(
        "Log the gyro in this run: --gyro names the CSV file (t_s,gyro_z_rad_s) that its logger appends to; \
         a simulated robot has a gyro if its scenario has a section [gyro].",
    )
}

/// The options that reach a campaign's robot: the port in use, unless it is the simulator because none
/// was given; then the robot that was simulated, or a word in place of a real one's port.
pub fn robot_options(port: &Port, robot: &RobotFile) -> String {
    match (port, &robot.simulated) {
        (Port::Sim(None), None) => "--port PORT".into(),
        (Port::Sim(None), Some(simulated)) => {
            let scenario =
                simulated.scenario.as_deref().map_or_else(String::new, |file| format!(":{file}"));
            let seed = simulated.seed.map_or_else(String::new, |seed| format!(" --seed {seed}"));
            format!("--port {}{seed}", shell(&format!("sim{scenario}")))
        }
        (port, _) => format!("--port {}", shell(&port.to_string())),
    }
}

/// The option that gives a simulated robot its memory again.
pub fn flash_option(common: &Common) -> String {
    let flash = common.flash.as_ref();
    flash.map_or_else(String::new, |file| format!(" --flash {}", shell_path(file)))
}

/// The same, with the robot's memory, and with a track if a tape is too little for what is to be told.
pub fn next_run_options(common: &Common, campaign: &Campaign) -> String {
    let mut words = robot_options(&common.port, &campaign.robot) + &flash_option(common);
    if campaign.is_measured_at_ends() && !words.starts_with("--port sim") {
        words += " --measure track:FILE";
    }
    words
}

/// The command line that records the next run.
pub fn next_run_command(next: &NextRun, context: &AnswerContext<'_>) -> String {
    let simulated = context.robot_options.starts_with("--port sim");
    let gyro = if gyro_words(next).is_some() && !simulated { " --gyro FILE" } else { "" };
    record_command(next.kind.name(), context) + gyro
}

/// The command line that drives the run of these once more that is the first in the plan of the campaign's folder, if any is.
fn drive_again_command(runs: &[String], context: &AnswerContext<'_>) -> Option<String> {
    let plan = CampaignPlan::read(&plan_path(Path::new(&context.campaign))).ok()?;
    let run = runs.iter().find(|run| once_more(run, &plan, &[]).is_some())?;
    Some(record_command(run, context))
}

/// The command line that records this run, or this kind of run, besides those of the campaign.
fn record_command(run: &str, context: &AnswerContext<'_>) -> String {
    format!(
        "beeline campaign record {} --run {} {}",
        shell_path(Path::new(&context.campaign)),
        shell(run),
        context.robot_options
    )
}

#[cfg(test)]
mod tests {
    use campaign::plan::PlanSettings;
    use findings::empty_answer::{nothing_found, step_of};
    use robot_model::explain::{CandidateKind, PredictedSeparation};

    use super::*;

    fn context(campaign: &str, robot_options: &str) -> AnswerContext<'static> {
        AnswerContext {
            robot: "r",
            campaign: campaign.into(),
            robot_options: robot_options.into(),
            runs: Vec::new(),
            motions: Vec::new(),
            catalogue: &[],
            combinations: Vec::new(),
            in_model: &[],
            nominal_m: [0.036, 0.372],
        }
    }

    #[test]
    fn a_run_that_is_off_is_driven_again_if_the_plan_has_it() {
        let folder = tempfile::tempdir().unwrap();
        let context = context(folder.path().to_str().unwrap(), "--port PORT");
        let mut answer = Answer { steps: vec![step_of(&["scrub", "slope"])], ..nothing_found() };
        answer.unexplained.runs_off = vec!["22_spin_2".into(), "07_spin_slow_right".into()];
        let (said, command) = no_next_run(&answer, &context);
        assert!(said.starts_with("Drive 22_spin_2 and 07_spin_slow_right again"), "{said}");
        assert_eq!(command, None, "there is no plan");
        let plan = CampaignPlan::usual(&PlanSettings::default()).unwrap();
        std::fs::write(plan_path(folder.path()), plan.to_toml()).unwrap();
        let command = no_next_run(&answer, &context).1.unwrap();
        assert!(command.starts_with("beeline campaign record "), "{command}");
        assert!(command.ends_with(" --run 07_spin_slow_right --port PORT"), "{command}");
        answer.unexplained.runs_off.clear();
        assert_eq!(no_next_run(&answer, &context).1, None);
    }

    #[test]
    fn the_next_run_goes_to_the_robot_that_was_recorded_or_to_the_port_that_was_given() {
        let text =
            "name = \"r\"\nwheel_radius_m = 0.036\ntrack_width_m = 0.4\ncounts_per_rev = 900\n";
        let robot = |more: &str| toml::from_str::<RobotFile>(&format!("{text}{more}")).unwrap();
        for (port, more, expected) in [
            ("sim", "", "--port PORT"),
            ("sim", "[simulated]\n", "--port sim"),
            ("sim", "[simulated]\nscenario = \"a b.toml\"\n", "--port 'sim:a b.toml'"),
            (
                "sim",
                "[simulated]\nscenario = '$(touch x)\".toml'\n",
                "--port 'sim:$(touch x)\".toml'",
            ),
            ("sim", "[simulated]\nscenario = \"a.toml\"\nseed = 7", "--port sim:a.toml --seed 7"),
            ("tcp:robot:7700", "[simulated]\n", "--port tcp:robot:7700"),
        ] {
            assert_eq!(robot_options(&port.parse().unwrap(), &robot(more)), expected);
        }
    }

    #[test]
    fn a_next_run_about_the_gyro_asks_for_its_log() {
        let next = |separates: &[&str]| NextRun {
            kind: CandidateKind::Straight,
            separates: separates.iter().map(|id| (*id).to_owned()).collect(),
            predicted: PredictedSeparation::default(),
        };
        let context = |robot_options: &str| context("my robot", robot_options);
        let gyro = next(&["gyro_bias", "gyro_scale"]);
        let command = next_run_command(&gyro, &context("--port PORT"));
        assert_eq!(
            command,
            "beeline campaign record 'my robot' --run straight --port PORT --gyro FILE"
        );
        assert!(gyro_words(&gyro).unwrap().contains("[gyro]"));
        // The simulator has a gyro of its own, and refuses a file.
        assert!(next_run_command(&gyro, &context("--port sim")).ends_with("--port sim"));
        assert!(gyro_words(&next(&["slope", "heading_pull"])).is_none());
    }

    #[test]
    fn effects_that_no_run_tells_apart_are_named() {
        let no_next = |answer: &Answer| no_next_run(answer, &context("r", "--port sim")).0;
        let answer = |class: &[&str]| Answer { steps: vec![step_of(class)], ..nothing_found() };
        assert!(no_next(&answer(&["scrub"])).contains("No further run"));
        let mut unexplained = answer(&["scrub"]);
        unexplained.unexplained.structure = true;
        let said = no_next(&unexplained);
        assert!(said.contains("still unexplained") && !said.contains("No further run"), "{said}");
        unexplained.unexplained.runs_off = vec!["loaded".to_owned()];
        assert!(no_next(&unexplained).starts_with("Drive loaded again"));
        let said = no_next(&answer(&["scrub", "slope", "side_slip"]));
        assert_eq!(
            said,
            "No run that beeline can plan distinguishes scrub from slope or side_slip."
        );
    }
}
