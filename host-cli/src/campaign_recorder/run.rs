//! Drives one run of a plan, piece by piece, and has it measured.

use std::path::PathBuf;
use std::time::Duration;

use campaign::plan::{CampaignPlan, PAUSE_S, PlannedRun};
use campaign::{CampaignWriter, Row, RunFacts};
use host_link::Session;
use host_link::motion::{self, RecordOptions};
use robot_model::recording::Piece;
use shared_proto::{Command, Config, Telemetry};

use super::piece;
use super::resumed::planned_facts;
use super::samples::{columns, on_one_encoder, rows};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::pose_source::align::reckoned;
use crate::pose_source::{PoseSource, RunMeasurement};

/// One run as recorded.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// Its samples.
    pub rows: Vec<Row>,
    /// When it began, on the session's clock \[us\].
    pub started_us: u64,
    /// Samples that were dropped because the line was too slow.
    pub dropped: u32,
}

impl RecordedRun {
    /// Samples with a measured pose.
    pub fn poses(&self) -> usize {
        self.rows.iter().filter(|row| row.x_m.is_some()).count()
    }

    /// Whether a yaw rate was measured.
    pub fn has_gyro(&self) -> bool {
        self.rows.iter().any(|row| row.gyro_z_rad_s.is_some())
    }

    /// Writes the run with its facts; `started_s` is its start on the campaign's clock \[s\].
    pub fn write(
        &self,
        writer: &CampaignWriter,
        run: &PlannedRun,
        started_s: f64,
    ) -> Result<PathBuf> {
        let mut file = writer.start_run(&run.name, &columns(self.poses() > 0, self.has_gyro()))?;
        self.rows.iter().try_for_each(|row| file.push(row))?;
        let started_s = Some((started_s * 1e3).round() / 1e3);
        Ok(file.finish(RunFacts { started_s, ..planned_facts(run) })?)
    }
}

/// The result of one run.
#[derive(Clone, Debug)]
pub enum RunOutcome {
    /// It was recorded.
    Recorded(RecordedRun),
    /// It is to be driven again.
    Repeat,
    /// It is to be skipped.
    Skip,
}

/// Drives one run, has it measured, and leaves the robot at standstill with its motors off.
pub async fn record_run(
    session: &mut Session,
    source: &mut dyn PoseSource,
    config: &Config,
    plan: &CampaignPlan,
    run: &PlannedRun,
    period_ms: u16,
    progress: &mut dyn FnMut(f64),
) -> Result<RunOutcome> {
    let dropped_before = session.status().await?.link.telemetry_dropped;
    source.check()?;
    let first = source.begin()?;
    let started_us = session.clock().now_us();
    let track_m = config.geometry.track_width_m;
    let options = RecordOptions {
        period_ms,
        rest: Duration::from_secs_f64(PAUSE_S),
        // A camera records the pauses between the pieces as well.
        trigger: None,
    };
    let whole_s = run.duration_s(track_m, plan.acceleration_mps2);
    let mut telemetry = Vec::new();
    let mut done_s = 0.0;
    for piece in &run.pieces {
        let piece_s = piece.duration_s(track_m, plan.acceleration_mps2);
        let mut at = |share: f64| progress(((done_s + share * piece_s) / whole_s).min(1.0));
        match (piece, piece::motion(piece, track_m, plan.acceleration_mps2)) {
            (Piece::Rest { duration_s }, _) => {
                rest(session, *duration_s, period_ms, &mut telemetry, &mut at).await?;
            }
            (_, Some(motion)) => {
                motion::drive_into(session, &motion, options.clone(), &mut telemetry, &mut at)
                    .await?;
            }
            (_, None) => {}
        }
        done_s += piece_s + 2.0 * PAUSE_S;
    }
    telemetry.sort_by_key(|frame| frame.t_us);
    let reckoned = reckoned(config, &telemetry);
    let track = match source.measure(&session.clock(), first, run, &reckoned).await? {
        RunMeasurement::Track(track) => track,
        RunMeasurement::Repeat => return Ok(RunOutcome::Repeat),
        RunMeasurement::Skip => return Ok(RunOutcome::Skip),
    };
    let rows = rows(&telemetry, &track, &source.yaw_rates(&run.name, &reckoned)?);
    if rows.len() < 2 {
        return Err(Error::new("the robot sent no telemetry during the run")
            .hint("`beeline watch` shows whether it sends any"));
    }
    let dropped = session.status().await?.link.telemetry_dropped.wrapping_sub(dropped_before);
    let rows = rows.iter().map(|row| on_one_encoder(row, config)).collect();
    Ok(RunOutcome::Recorded(RecordedRun { rows, started_us, dropped }))
}

/// Records the robot standing still.
async fn rest(
    session: &mut Session,
    duration_s: f64,
    period_ms: u16,
    telemetry: &mut Vec<Telemetry>,
    progress: &mut dyn FnMut(f64),
) -> Result<()> {
    const LISTEN_FOR: Duration = Duration::from_millis(100);
    let _stale = session.take_telemetry().count();
    session.request(Command::Subscribe { period_ms }).await?;
    let start_us = session.clock().now_us();
    loop {
        session.listen(LISTEN_FOR).await?;
        telemetry.extend(session.take_telemetry());
        let rested_s = (session.clock().now_us() - start_us) as f64 * 1e-6;
        progress((rested_s / duration_s).min(1.0));
        if session.is_cancelled() {
            let _ = session.ask(Command::Subscribe { period_ms: 0 }).await;
            return Err(Error::interrupted(format_args!(
                "{}; the robot stands still",
                interrupt::words()
            )));
        }
        if rested_s >= duration_s {
            break;
        }
    }
    session.request(Command::Subscribe { period_ms: 0 }).await?;
    match session.status().await?.fault {
        Some(report) => Err(host_link::Error::Faulted(report).into()),
        None => Ok(()),
    }
}
