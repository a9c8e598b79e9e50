//! What is truly wrong in each shipped scenario, and what `explain` says of its usual campaign.

use campaign::Campaign;
use campaign::plan::{CampaignPlan, PlanSettings};
use futures_lite::future;
use host_cli::campaign_recorder::{RecordSettings, RecordStep, record_campaign};
use host_cli::pose_source::camera::Camera;
use robot_model::explain::{Answer, StepFound, explain};
use sim_target::{Options, Scenario, SimTarget};

/// What is wrong in a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The robot stops with this fault.
    Fault(&'static str),
    /// These effects of the catalogue.
    Effects(&'static [&'static str]),
    /// Something that is no effect of the catalogue, or nothing.
    NoEffect,
}

/// What the simulator's standard tyres do to any robot: effects too, of every scenario.
const OF_STANDARD_TYRES: [&str; 3] = ["wheel_radius_scale", "traction_slip", "side_slip"];

impl Cause {
    /// What is wrong in the scenario of this name; `None` for one that nobody has described here.
    pub fn of(scenario: &str) -> Option<Self> {
        Some(match scenario {
            "battery_low" => Self::Fault("supply_low"),
            "encoder_cut_at_cruise" => Self::Fault("encoder_dead"),
            "grippy_floor" | "lossy_link" | "paper" | "slippery_floor" => {
                Self::Effects(&["wheel_radius_ratio"])
            }
            "crooked_caster" => Self::Effects(&["caster_kick"]),
            "hanging_caster" | "unequal_motors" => Self::NoEffect,
            "worn_gears" => {
                Self::Effects(&["backlash", "carpet_drift", "marker_offset", "wheel_radius_ratio"])
            }
            super::PLAY_ALONE => Self::Effects(&["backlash"]),
            _ => return None,
        })
    }

    fn effects(self) -> &'static [&'static str] {
        match self {
            Self::Effects(effects) => effects,
            Self::Fault(_) | Self::NoEffect => &[],
        }
    }
}

/// What was said about the cause of a scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Named {
    /// Causes that were not named.
    pub missing: Vec<String>,
    /// What else was named that matters, with its size \[mm\].
    pub besides: Vec<(String, f64)>,
    /// Whether a cause is the first step that matters, in order of evidence.
    pub is_first: bool,
    /// Whether a cause is worth most of all that matters.
    pub is_largest: bool,
    /// Everything that matters, for a table.
    pub said: String,
}

/// Compares what is said about a scenario with its cause; the standard tyres' own effects count for nothing.
///
/// # Errors
/// What went wrong, for a person to read.
pub fn named(scenario: &Scenario, cause: Cause) -> Result<Named, String> {
    let answer = match (explained(scenario), cause) {
        (Err(why), Cause::Fault(fault)) => {
            let is_named = why.contains(fault);
            let missing = if is_named { Vec::new() } else { vec![fault.to_string()] };
            let (is_first, is_largest) = (is_named, is_named);
            return Ok(Named { missing, is_first, is_largest, said: why, ..Named::default() });
        }
        (Ok(_), Cause::Fault(fault)) => return Err(format!("it drives in spite of {fault}")),
        (answer, _) => answer?,
    };
    let causes = cause.effects();
    let is_of =
        |step: &StepFound, ids: &[&str]| ids.iter().any(|id| step.class.contains(&id.to_string()));
    let matter: Vec<&StepFound> = answer.steps.iter().filter(|step| step.matters).collect();
    let others =
        matter.iter().filter(|step| is_of(step, causes) || !is_of(step, &OF_STANDARD_TYRES));
    let others: Vec<&StepFound> = others.copied().collect();
    let largest = others.iter().max_by(|a, b| a.effect_size_m.total_cmp(&b.effect_size_m));
    let names = |id: &&&str| !matter.iter().any(|step| is_of(step, &[id]));
    let besides = others.iter().filter(|step| !is_of(step, causes));
    let in_mm = |step: &StepFound| (step.class.join("|"), 1e3 * step.effect_size_m);
    let said = matter.iter().map(|step| in_mm(step)).map(|(id, mm)| format!("{id} {mm:.2}"));
    let none = causes.is_empty();
    Ok(Named {
        missing: causes.iter().filter(names).map(|id| id.to_string()).collect(),
        besides: besides.map(|step| in_mm(step)).collect(),
        is_first: others.first().map_or(none, |step| is_of(step, causes)),
        is_largest: largest.map_or(none, |step| is_of(step, causes)),
        said: said.collect::<Vec<_>>().join(", "),
    })
}

/// `beeline campaign record`, then `beeline explain`, in this process.
fn explained(scenario: &Scenario) -> Result<Answer, String> {
    let plan = CampaignPlan::usual(&PlanSettings::default()).map_err(|error| error.to_string())?;
    let temp = tempfile::tempdir().map_err(|error| error.to_string())?;
    let folder = temp.path().join("robot");
    let options = Options::default();
    let mut target = SimTarget::new(scenario, options).map_err(|error| error.to_string())?;
    let (testbed, wire) = (target.testbed(), target.host_wire());
    let mut session = sim_link::session(&wire, 1, "sim");
    let procedure = async {
        session.open().await.map_err(|error| error.to_string())?;
        let mut tell = |_: RecordStep<'_>| ();
        let (camera, settings) = (&mut Camera::new(testbed), RecordSettings::default());
        let recorded =
            record_campaign(&mut session, camera, &plan, &folder, &settings, &mut tell).await;
        recorded.map(drop).map_err(|error| error.to_string())
    };
    target.run(future::or(procedure, std::future::pending()))?;
    let read = Campaign::read(&folder).map_err(|error| error.to_string())?;
    let campaign = read.to_model(&folder).map_err(|error| error.to_string())?;
    explain(&campaign).map_err(|error| error.to_string())
}
