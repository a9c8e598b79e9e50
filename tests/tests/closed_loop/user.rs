//! A user with a robot and a folder, who records, calls `explain`, and drives the run that it suggests.

use std::path::PathBuf;

use beeline_tests::blind::sim_target_robot::PERIOD_MS;
use campaign::plan::run_kinds::{fastest_mps, runs_of};
use campaign::plan::{CampaignPlan, PlanSettings};
use campaign::{Campaign, CampaignWriter, Run};
use futures_lite::future;
use host_cli::calibrate::umbmark::{UmbmarkSettings, umbmark};
use host_cli::campaign_recorder::samples::columns;
use host_cli::campaign_recorder::{RecordSettings, RecordStep, record_campaign};
use host_cli::error::Result;
use host_cli::pose_source::camera::Camera;
use host_link::session::Session;
use robot_model::explain::Answer;
use robot_model::explain::explain;
use sim_target::{Options, Scenario, SimTarget, Testbed};
use tempfile::TempDir;

/// A user with a robot and a campaign folder.
pub struct User {
    session: Session,
    testbed: Testbed,
    target: SimTarget,
    temp: TempDir,
}

impl User {
    /// With this robot, switched on, and an empty folder.
    pub fn with(scenario: &Scenario) -> Self {
        scenario.validate().expect("a physical robot");
        let mut target = SimTarget::new(scenario, Options::default()).expect("no flash file");
        let testbed = target.testbed();
        let mut session = sim_link::session(&target.host_wire(), 1, "sim");
        let opened = target.run(future::or(session.open(), std::future::pending()));
        opened.expect("the simulated robot answers");
        let temp = tempfile::tempdir().expect("a folder for the campaign");
        Self { session, testbed, target, temp }
    }

    fn folder(&self) -> PathBuf {
        self.temp.path().join("robot")
    }

    /// `beeline campaign record --plan PLAN`
    pub fn record(&mut self, plan: &CampaignPlan) {
        self.drive(plan, true, 0.0);
    }

    /// `beeline campaign record --run KIND`
    pub fn follow(&mut self, kind: &str) {
        let campaign = self.campaign();
        let mut settings = PlanSettings::default();
        let fastest = fastest_mps(&self.folder(), &campaign).expect("a wheel has turned");
        settings.speeds_mps[1] = fastest.max(0.05);
        let extra = runs_of(kind, &settings, &campaign.plain_names()).expect("what it suggests");
        self.drive(&extra.plan, false, extra.later_s);
    }

    fn drive(&mut self, plan: &CampaignPlan, whole: bool, later_s: f64) {
        let settings =
            RecordSettings { period_ms: PERIOD_MS, whole, later_s, ..RecordSettings::default() };
        let (session, folder) = (&mut self.session, self.temp.path().join("robot"));
        let mut camera = Camera::new(self.testbed.clone());
        let mut tell = |_: RecordStep<'_>| ();
        let procedure = record_campaign(session, &mut camera, plan, &folder, &settings, &mut tell);
        let summary = self.target.run(future::or(procedure, std::future::pending()));
        assert_eq!(summary.expect("it drives").recorded.len(), plan.runs.len());
    }

    /// `beeline calibrate --method umbmark`; the end poses of its first squares are kept as a campaign. The correction
    /// is undone: the campaign is that of the robot as it was.
    pub fn umbmark(&mut self, squares_each_way: u16) {
        let settings = UmbmarkSettings {
            side_m: 1.0,
            runs: squares_each_way,
            speed_mps: 0.25,
            acceleration_mps2: 0.3,
            undo_folder: None,
        };
        let session = &mut self.session;
        let mut camera = Camera::new(self.testbed.clone());
        let procedure = async {
            let before = session.read_config().await?;
            let outcome = umbmark(session, &mut camera, &settings, &mut |_| ()).await?;
            session.write_config(&before).await?;
            session.save_config().await?;
            Result::Ok(outcome)
        };
        let outcome = self.target.run(future::or(procedure, std::future::pending()));
        let campaign = outcome.expect("it drives").campaign.expect("a camera saw it");
        assert_eq!(campaign.runs.len(), 2 * usize::from(squares_each_way));
        self.keep_ends(&campaign).expect("the folder can be written");
    }

    /// Writes runs to the folder, each with its first and its last measured pose.
    fn keep_ends(&self, campaign: &Campaign) -> Result<()> {
        let writer = CampaignWriter::open(&self.folder(), &campaign.robot)?;
        for run in &campaign.runs {
            let name = run.name.trim_start_matches(|c: char| c.is_ascii_digit() || c == '_');
            let mut file = writer.start_run(name, &columns(true, false))?;
            ends_only(run).rows.iter().try_for_each(|row| file.push(row))?;
            file.finish(run.facts.clone())?;
        }
        Ok(())
    }

    fn campaign(&self) -> Campaign {
        Campaign::read(&self.folder()).expect("what was recorded can be read")
    }

    /// `beeline explain`
    pub fn explain(&self) -> Answer {
        let campaign = self.campaign().to_model(&self.folder()).expect("its runs are sound");
        explain(&campaign).expect("it can be explained")
    }
}

/// A run with only its first and its last pose measured.
fn ends_only(run: &Run) -> Run {
    let seen = || (0..run.rows.len()).filter(|row| run.rows[*row].x_m.is_some());
    let ends = [seen().next(), seen().next_back()];
    let mut run = run.clone();
    for (index, row) in run.rows.iter_mut().enumerate() {
        row.gyro_z_rad_s = None;
        if !ends.contains(&Some(index)) {
            (row.x_m, row.y_m, row.heading_rad) = (None, None, None);
        }
    }
    run
}
