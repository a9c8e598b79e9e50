//! UMBmark: drives squares both ways, corrects radii and track by where they end, and tests the
//! correction.
//!
//! [`systematic`] has the equations, `square` drives one square.

mod square;
pub mod systematic;

pub use square::UmbmarkSettings;
pub use systematic::Systematic;

use campaign::{Campaign, Run};
use host_link::Session;
use shared_proto::{Config, ConfigOrigin, GeometryConfig};

use self::square::{Turning, square};
use super::readiness::{Checks, check};
use super::save;
use crate::campaign_recorder::samples::robot_file;
use crate::error::{Error, Result};
use crate::pose_source::{Mark, PoseSource};
use crate::undo::{self, Undo};

/// How far the procedure is, for the caller.
#[derive(Debug)]
pub enum UmbmarkStep<'a> {
    /// Link, supply and state are in order.
    Checked(&'a Checks),
    /// A square is under way: whether after the correction, its number from 1, the number of
    /// squares, and the share that is done.
    Driving(bool, u16, u16, f64),
    /// All squares of a set are measured: whether after the correction, and what they say.
    Measured(bool, &'a Systematic),
    /// The correction is in use and was read back.
    Written(&'a GeometryConfig),
    /// The correction survives power-off.
    Saved,
}

/// The result of UMBmark.
#[derive(Clone, Debug)]
pub struct UmbmarkOutcome {
    /// Before the correction.
    pub before: Systematic,
    /// The geometry before and as corrected; twice the same if nothing was.
    pub geometry: [GeometryConfig; 2],
    /// What was done about the error.
    pub decision: Decision,
    /// The first set as a campaign, if tracks were measured.
    pub campaign: Option<Campaign>,
}

/// What UMBmark did about the error.
#[derive(Clone, Debug)]
pub enum Decision {
    /// The correction is saved; these are the squares with it.
    Saved(Systematic),
    /// The correction did not reduce the error; the old geometry is in use again.
    NotBetter(Systematic),
    /// Neither radii nor track stand out from the scatter; nothing was written.
    AlreadySquare,
    /// Something else than radii and track moves the ends; nothing was written.
    Contradicted,
}

/// Drives squares both ways, corrects radii and track, drives them again, and keeps the better
/// geometry.
pub async fn umbmark(
    session: &mut Session,
    source: &mut dyn PoseSource,
    settings: &UmbmarkSettings,
    tell: &mut dyn FnMut(UmbmarkStep<'_>),
) -> Result<UmbmarkOutcome> {
    source.begin()?;
    let checks = check(session).await?;
    if let Some(folder) = &settings.undo_folder {
        undo::check::<GeometryConfig>(folder, &checks.identity)?;
    }
    tell(UmbmarkStep::Checked(&checks));
    let config = &checks.config;
    let outcome = experiment(session, source, settings, &checks, tell).await;
    let saved = matches!(&outcome, Ok(UmbmarkOutcome { decision: Decision::Saved(_), .. }));
    if !saved && session.read_config().await.is_ok_and(|now| now != *config) {
        // This fails without a link; the saved configuration is unchanged all the same.
        let _ = session.restore_config(ConfigOrigin::Saved).await;
    }
    outcome
}

async fn experiment(
    session: &mut Session,
    source: &mut dyn PoseSource,
    settings: &UmbmarkSettings,
    checks: &Checks,
    tell: &mut dyn FnMut(UmbmarkStep<'_>),
) -> Result<UmbmarkOutcome> {
    let config = &checks.config;
    let (before, runs) = squares(session, source, settings, config, false, tell).await?;
    tell(UmbmarkStep::Measured(false, &before));
    let robot = robot_file(config, source.noise().filter(|_| source.is_simulated()));
    let campaign = (!runs.is_empty()).then_some(Campaign {
        robot,
        runs,
        copies: Vec::new(),
        warnings: Vec::new(),
    });
    let (decision, geometry) = if before.is_contradicted() {
        (Decision::Contradicted, config.geometry)
    } else if before.is_square() {
        (Decision::AlreadySquare, config.geometry)
    } else {
        corrected(session, source, settings, checks, &before, tell).await?
    };
    let geometry = [config.geometry, geometry];
    Ok(UmbmarkOutcome { before, geometry, decision, campaign })
}

/// Corrects the geometry, drives the squares again, and saves the correction if the error is smaller.
async fn corrected(
    session: &mut Session,
    source: &mut dyn PoseSource,
    settings: &UmbmarkSettings,
    checks: &Checks,
    before: &Systematic,
    tell: &mut dyn FnMut(UmbmarkStep<'_>),
) -> Result<(Decision, GeometryConfig)> {
    let config = &checks.config;
    let mut new = config.clone();
    new.geometry = before.corrected(&config.geometry);
    new.validate().map_err(|error| {
        Error::new(format_args!("the measured geometry is implausible: {error}"))
            .hint("check the readings and their signs")
    })?;
    session.write_config(&new).await?;
    tell(UmbmarkStep::Written(&new.geometry));
    let (after, _) = squares(session, source, settings, &new, true, tell).await?;
    tell(UmbmarkStep::Measured(true, &after));
    if after.error_m >= before.error_m {
        return Ok((Decision::NotBetter(after), new.geometry));
    }
    new.odometry = before.deviations(&after, &config.odometry, &new.geometry, settings.side_m);
    session.write_config(&new).await?;
    let undo = Undo {
        robot: checks.identity.name.as_str().into(),
        before: config.geometry,
        after: new.geometry,
        odometry: Some(config.odometry),
    };
    save(session, settings.undo_folder.as_deref(), &checks.identity, &undo).await?;
    tell(UmbmarkStep::Saved);
    Ok((Decision::Saved(after), new.geometry))
}

async fn squares(
    session: &mut Session,
    source: &mut dyn PoseSource,
    settings: &UmbmarkSettings,
    config: &Config,
    again: bool,
    tell: &mut dyn FnMut(UmbmarkStep<'_>),
) -> Result<(Systematic, Vec<Run>)> {
    let (mut left_m, mut right_m, mut runs) = (Vec::new(), Vec::new(), Vec::new());
    let all = 2 * settings.runs;
    for number in 0..all {
        let way = if number < settings.runs { Turning::Left } else { Turning::Right };
        source.place(&session.clock(), Mark::Line("at its mark, along its line")).await?;
        let square = square(session, source, settings, config, way, &mut |share| {
            tell(UmbmarkStep::Driving(again, number + 1, all, share));
        })
        .await?;
        match way {
            Turning::Left => left_m.push(square.error_m),
            Turning::Right => right_m.push(square.error_m),
        }
        if let Some(mut run) = square.run {
            run.name = format!("{:02}_square_{way:?}", number + 1).to_lowercase();
            run.facts.name.clone_from(&run.name);
            runs.push(run);
        }
    }
    let track_m = config.geometry.track_width_m;
    Ok((Systematic::new(left_m, right_m, settings.side_m, track_m), runs))
}
