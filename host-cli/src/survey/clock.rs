//! One clock for all runs of a campaign, over interruptions.
//!
//! `started_s` of the first run is zero. Whoever goes on with a campaign, perhaps on another day and with
//! a robot that was switched off meanwhile, finds the clock by the last run that is there: its file was
//! finished when the run was.

use std::path::Path;
use std::time::SystemTime;

use campaign::Campaign;

/// The clock of a campaign.
#[derive(Clone, Copy, Debug)]
pub struct CampaignClock {
    /// What it shows at `since_us` of the session's clock \[s\].
    shown_s: f64,
    since_us: u64,
}

/// What is known of a campaign's runs so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LastRun {
    /// When it ended, on the campaign's clock \[s\].
    pub ended_s: f64,
    /// How long ago that was, by its file \[s\].
    pub ago_s: f64,
}

impl LastRun {
    /// The last run of a folder whose runs have times.
    pub fn of(folder: &Path, campaign: &Campaign) -> Option<Self> {
        let ended = campaign.runs.iter().filter_map(|run| {
            let (first, last) = (run.rows.first()?, run.rows.last()?);
            Some((run, run.facts.started_s? + last.t_s - first.t_s))
        });
        let (run, ended_s) = ended.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let file = folder.join("runs").join(format!("{}.csv", run.name));
        let written = std::fs::metadata(file).and_then(|it| it.modified());
        let ago = written.ok().and_then(|it| SystemTime::now().duration_since(it).ok());
        Some(Self { ended_s, ago_s: ago.unwrap_or_default().as_secs_f64() })
    }
}

impl CampaignClock {
    /// A clock that shows `shown_s` when the session's clock shows `since_us`.
    pub fn new(shown_s: f64, since_us: u64) -> Self {
        Self { shown_s, since_us }
    }

    /// What it shows at a time of the session's clock \[s\].
    pub fn at(&self, t_us: u64) -> f64 {
        self.shown_s + (t_us as f64 - self.since_us as f64) * 1e-6
    }
}
