//! Every procedure that saves a number, and the next straight with that number and without.

use std::f64::consts::TAU;

use host_cli::calibrate::umbmark::{Decision as Squares, UmbmarkSettings, umbmark};
use host_cli::calibrate::{Decision, Settings, calibrate};
use host_cli::error::Error;
use host_cli::pose_source::PoseSource;
use host_cli::pose_source::camera::Camera;
use host_cli::pose_source::ruler::Ruler;
use host_link::motion::{self, Motion, RecordOptions};
use shared_proto::{Config, ConfigOrigin};
use sim_target::Scenario;

use crate::calibration::Instrument;
use crate::robot::{Robot, on_robot};

/// A procedure that may save a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Procedure {
    /// `beeline calibrate`
    Straight(Instrument),
    /// `beeline calibrate --out-and-back`
    OutAndBack(Instrument),
    /// `beeline calibrate --method umbmark`
    Umbmark(Instrument),
}

impl Procedure {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Straight(Instrument::Camera),
        Self::Straight(Instrument::Ruler),
        Self::OutAndBack(Instrument::Camera),
        Self::OutAndBack(Instrument::Ruler),
        Self::Umbmark(Instrument::Camera),
        Self::Umbmark(Instrument::Ruler),
    ];

    /// Its name in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Straight(Instrument::Camera) => "straight, camera",
            Self::Straight(Instrument::Ruler) => "straight, ruler",
            Self::OutAndBack(Instrument::Camera) => "out-and-back, camera",
            Self::OutAndBack(Instrument::Ruler) => "out-and-back, ruler",
            Self::Umbmark(Instrument::Camera) => "umbmark, camera",
            Self::Umbmark(Instrument::Ruler) => "umbmark, ruler",
        }
    }

    fn instrument(self) -> Instrument {
        match self {
            Self::Straight(with) | Self::OutAndBack(with) | Self::Umbmark(with) => with,
        }
    }
}

/// What a procedure did, and what it did to the next straight.
#[derive(Clone, Debug)]
pub struct Saved {
    /// What it decided, in a word or two.
    pub decision: String,
    /// Whether the robot's saved configuration is another one.
    pub saved: bool,
    /// W_T that is saved now.
    pub wheel_weight: f64,
    /// True lateral error of the next straight with the configuration of before \[m\].
    pub before_m: f64,
    /// The same with the saved configuration \[m\].
    pub after_m: f64,
}

impl Saved {
    /// Whether a number was saved that makes the next straight worse.
    pub fn is_worse(&self) -> bool {
        self.saved && self.after_m.abs() > self.before_m.abs()
    }
}

/// Runs a procedure on the robot of a scenario, then drives a straight with the saved numbers; and the same again, with
/// the numbers of before. The same seed gives the same bytes, so nothing else differs between the two straights.
///
/// # Errors
/// The message of a robot that cannot drive afterwards.
pub fn saved_by(scenario: &Scenario, procedure: Procedure) -> Result<Saved, String> {
    let with_saved = next_straight(scenario, procedure, true)?;
    if !with_saved.saved {
        return Ok(with_saved);
    }
    let with_old = next_straight(scenario, procedure, false)?;
    Ok(Saved { before_m: with_old.after_m, ..with_saved })
}

/// One of the two: with the saved numbers or with those of before.
fn next_straight(
    scenario: &Scenario,
    procedure: Procedure,
    with_saved: bool,
) -> Result<Saved, String> {
    on_robot(scenario, async |robot| {
        let before = robot.session.read_config().await.map_err(|error| error.to_string())?;
        let decision = run(robot, procedure).await.unwrap_or_else(|error| error.to_string());
        let restored = robot.session.restore_config(ConfigOrigin::Saved).await;
        let now = restored.map_err(|error| error.to_string())?;
        let (saved, wheel_weight) = (now != before, now.geometry.wheel_weight);
        let mut after_m = f64::NAN;
        if saved {
            after_m = straight(robot, if with_saved { &now } else { &before }).await?;
        }
        Ok(Saved { decision, saved, wheel_weight, before_m: f64::NAN, after_m })
    })
}

async fn run(robot: &mut Robot, procedure: Procedure) -> Result<String, Error> {
    let testbed = robot.testbed.clone();
    let source: &mut dyn PoseSource = match procedure.instrument() {
        Instrument::Camera => &mut Camera::new(testbed),
        Instrument::Ruler => &mut Ruler::new(testbed),
    };
    let session = &mut robot.session;
    if let Procedure::Umbmark(_) = procedure {
        let m_per_rev = TAU * 0.036;
        let settings = UmbmarkSettings {
            side_m: 1.0,
            runs: 5,
            speed_mps: Motion::PAPER.cruise * m_per_rev,
            acceleration_mps2: Motion::PAPER.acceleration * m_per_rev,
            undo_folder: None,
        };
        let outcome = umbmark(session, source, &settings, &mut |_| ()).await?;
        let words = match outcome.decision {
            Squares::Saved(_) => "saved",
            Squares::NotBetter(_) => "not better",
            Squares::AlreadySquare => "already square",
            Squares::Contradicted => "contradicted",
        };
        return Ok(words.to_string());
    }
    let out_and_back = matches!(procedure, Procedure::OutAndBack(_));
    let settings = Settings { out_and_back, ..Settings::default() };
    let outcome = calibrate(session, source, &settings, &mut |_| ()).await?;
    let verdict = outcome.out_and_back.map(|both| format!("{:?}: ", both.verdict).to_lowercase());
    let decision = match outcome.decision {
        Decision::Corrected(_) => "corrected",
        Decision::NotBetter(_) => "not better",
        Decision::NotRepeatable(..) => "not repeatable",
        Decision::AlreadyStraight => "already straight",
        Decision::CannotTell => "cannot tell",
        Decision::NotARadius => "not a radius",
    };
    Ok(verdict.unwrap_or_default() + decision)
}

/// The true lateral error at the end of the paper's straight, from its true start \[m\].
async fn straight(robot: &mut Robot, config: &Config) -> Result<f64, String> {
    let words = |error: host_link::error::Error| error.to_string();
    robot.session.write_config(config).await.map_err(words)?;
    robot.testbed.place_at_start();
    let start = robot.testbed.pose();
    motion::drive(&mut robot.session, &Motion::PAPER, RecordOptions::default(), &mut |_| ())
        .await
        .map_err(words)?;
    Ok(robot.testbed.pose().relative_to(start).y_m)
}
