//! Tries a configuration: fast, until its feedforward is as good as its drives can make it, and then slowly back.

use shared_proto::{Config, Fault};

use super::following::{Drive, Drives, Outcome, TraceSample};
use super::{Progress, Tuner, experiments, settings};
use crate::error::Result;

/// So many fast drives forwards.
const ROUNDS: usize = 3;

const FAST: Drive = Drive { is_fast: true, forwards: true };
const FAST_BACK: Drive = Drive { is_fast: true, forwards: false };
const SLOW_BACK: Drive = Drive { is_fast: false, forwards: false };

/// One drive.
type Trace = Vec<TraceSample>;

impl Tuner<'_> {
    /// The fast profile forwards and back.
    pub(super) async fn drive_fast(&mut self, config: &Config) -> Result<(Outcome, Trace)> {
        let mut drives = Drives::default();
        for drive in [FAST, FAST_BACK] {
            if let Some(fault) = self.drive(&mut drives, config, drive).await? {
                return Ok((Outcome::Faulted(fault), drives.trace));
            }
        }
        Ok((Outcome::Followed(drives.following()), drives.trace))
    }

    /// Drives fast forwards with these settings. Where the robot does not follow as closely as its encoders can tell, it drives
    /// back as fast, and forwards once more with the feedforward that these drives have shown to be missing. With what drove
    /// best, it drives slowly back. Returns that; the robot has it. `pushed`: a slope or a cable pushes it.
    pub(super) async fn try_settings(
        &mut self,
        tuned: Config,
        pushed: bool,
        meters_per_count: f64,
        progress: &mut dyn FnMut(Progress<'_>),
    ) -> Result<(Config, Outcome, Trace)> {
        self.session.write_config(&tuned).await?;
        let motors_known = meters_per_count <= experiments::COARSE_M;
        let new_drives = || Drives::for_identified_motors(motors_known);
        let (mut config, mut drives) = (tuned, new_drives());
        if let Some(fault) = self.drive(&mut drives, &config, FAST).await? {
            let after = Outcome::Faulted(fault);
            progress(Progress::After(&after));
            return Ok((config, after, drives.trace));
        }
        for _ in 1..ROUNDS {
            let following = drives.following();
            if !following.is_loose(meters_per_count) {
                break;
            }
            let mut both = drives.clone();
            if self.drive(&mut both, &config, FAST_BACK).await?.is_some() {
                break;
            }
            progress(Progress::Doing("the same with a better feedforward"));
            let refined = settings::refined(&config, &both.shortfall, pushed);
            self.session.write_config(&refined).await?;
            let mut again = new_drives();
            let fault = self.drive(&mut again, &refined, FAST).await?;
            if fault.is_some() || again.following().fast_rms_m >= following.fast_rms_m {
                self.session.write_config(&config).await?;
                break;
            }
            (config, drives) = (refined, again);
        }
        let after = match self.drive(&mut drives, &config, SLOW_BACK).await? {
            None => Outcome::Followed(drives.following()),
            Some(fault) => Outcome::Faulted(fault),
        };
        progress(Progress::After(&after));
        Ok((config, after, drives.trace))
    }

    async fn drive(
        &mut self,
        drives: &mut Drives,
        config: &Config,
        drive: Drive,
    ) -> Result<Option<Fault>> {
        drives.drive(self.session, config, &mut self.floor, drive).await
    }
}
