//! When a run began, on one clock for the whole campaign, even over interruptions.
//!
//! `started_s` of the first run is zero. A campaign that is continued, perhaps on another day and
//! with a robot that was switched off meanwhile, takes the clock from its last run: the file was
//! written when the run ended.

use std::path::Path;
use std::time::{Duration, SystemTime};

use campaign::Campaign;
use host_link::Session;

use crate::error::{Error, Result};
use crate::pose_source::PoseSource;

/// The clock of a campaign.
#[derive(Clone, Copy, Debug)]
pub struct CampaignClock {
    /// The time that it shows at `since_us` of the session's clock \[s\].
    shown_s: f64,
    since_us: u64,
}

/// When the last run of a campaign ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LastRun {
    /// When it ended, on the campaign's clock \[s\].
    pub ended_s: f64,
    /// How long ago that was, by the time of its file \[s\].
    pub ago_s: f64,
}

impl LastRun {
    /// The last run of a folder, of those that have a start time.
    pub fn of(folder: &Path, campaign: &Campaign) -> Option<Self> {
        let ended = campaign.runs.iter().filter_map(|run| {
            let (first, last) = (run.rows.first()?, run.rows.last()?);
            Some((run, run.facts.started_s? + last.t_s - first.t_s))
        });
        let (run, ended_s) = ended.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let file = folder.join("runs").join(format!("{}.csv", run.name));
        let written = std::fs::metadata(file).and_then(|metadata| metadata.modified());
        let ago = written.ok().and_then(|written| SystemTime::now().duration_since(written).ok());
        Some(Self { ended_s, ago_s: ago.unwrap_or_default().as_secs_f64() })
    }
}

impl CampaignClock {
    /// A clock that shows `shown_s` when the session's clock shows `since_us`.
    pub fn new(shown_s: f64, since_us: u64) -> Self {
        Self { shown_s, since_us }
    }

    /// The campaign's time at a time of the session's clock \[s\].
    pub fn at(&self, t_us: u64) -> f64 {
        self.shown_s + (t_us as f64 - self.since_us as f64) * 1e-6
    }
}

/// Waits until the campaign's clock shows this time, if it is more than a second away \[s\].
pub(super) async fn wait_for(session: &Session, clock: &CampaignClock, until_s: f64) {
    /// `started_s` in a file is rounded; a second is less than it takes to carry a robot to its mark.
    const NEAR_S: f64 = 1.0;
    let missing_s = until_s - clock.at(session.clock().now_us());
    if missing_s > NEAR_S {
        session.clock().sleep(Duration::from_secs_f64(missing_s)).await;
    }
}

/// A run that is to start at most this long after another may start at once \[s\]: putting the
/// robot back at its mark takes a while anyway.
const SOON_S: f64 = 300.0;

/// The clock of a campaign, continued after its last run.
///
/// A simulated robot is new in each process, with its clock at zero: it waits until its clock shows
/// the campaign's time.
pub(super) async fn start_clock(
    session: &mut Session,
    source: &dyn PoseSource,
    last: Option<LastRun>,
    later_s: f64,
) -> Result<CampaignClock> {
    let clock = session.clock();
    let Some(last) = last else { return Ok(CampaignClock::new(0.0, clock.now_us())) };
    if source.is_simulated() {
        let until_us = ((last.ended_s + later_s) * 1e6) as u64;
        clock.sleep_until_us(until_us.max(clock.now_us())).await;
        return Ok(CampaignClock::new(last.ended_s + later_s, clock.now_us()));
    }
    let missing_s = later_s - last.ago_s;
    if later_s > SOON_S && missing_s > 0.0 {
        return Err(Error::new(format_args!(
            "this run must start {:.0} minutes after the campaign's last one, which ended {:.0} minutes ago",
            later_s / 60.0,
            last.ago_s / 60.0
        ))
        .hint(format_args!("come back in {:.0} minutes", (missing_s / 60.0).ceil())));
    }
    Ok(CampaignClock::new(last.ended_s + last.ago_s, clock.now_us()))
}
