//! What is truly wrong in each shipped scenario, and what `explain` says of its usual campaign.

use campaign::Campaign;
use campaign::plan::{CampaignPlan, PlanSettings};
use futures_lite::future;
use host_cli::pose_source::camera::Camera;
use host_cli::survey::{RecordSettings, RecordStep, record_campaign};
use robot_model::explain::{Answer, explain};
use sim_target::{Options, Scenario, SimTarget};

/// `beeline campaign record`, then `beeline explain`, in this process.
///
/// # Errors
/// The message that a user would read.
pub fn explained(scenario: &Scenario) -> Result<Answer, String> {
    let plan = CampaignPlan::usual(&PlanSettings::default()).map_err(|error| error.to_string())?;
    let temp = tempfile::tempdir().map_err(|error| error.to_string())?;
    let folder = temp.path().join("robot");
    let options = Options::default();
    let mut target = SimTarget::new(scenario, options).map_err(|error| error.to_string())?;
    let (lab, wire) = (target.lab(), target.host_wire());
    let mut session = sim_link::session(&wire, 1, "sim");
    let procedure = async {
        session.open().await.map_err(|error| error.to_string())?;
        let mut tell = |_: RecordStep<'_>| ();
        let (camera, settings) = (&mut Camera::new(lab), RecordSettings::default());
        let recorded =
            record_campaign(&mut session, camera, &plan, &folder, &settings, &mut tell).await;
        recorded.map(drop).map_err(|error| error.to_string())
    };
    target.run(future::or(procedure, std::future::pending()))?;
    let read = Campaign::read(&folder).map_err(|error| error.to_string())?;
    let campaign = read.to_model(&folder).map_err(|error| error.to_string())?;
    explain(&campaign).map_err(|error| error.to_string())
}
