//! What was there before the last calibration of each robot, kept on the host.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use shared_proto::{ConfigOrigin, Identity};

use crate::command::hex;
use crate::error::{Context, Error, Result};
use crate::file::write_whole;
use crate::session::Session;

/// The last calibration of one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Undo {
    /// The robot's name, for whoever reads the file.
    pub robot: String,
    /// W_T before.
    pub before: f64,
    /// W_T after.
    pub after: f64,
}

/// The folder where calibrations are remembered: `$XDG_STATE_HOME/beeline`, or `~/.local/state/beeline`.
pub fn state_folder() -> Result<PathBuf> {
    let set =
        |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    set("XDG_STATE_HOME")
        .or_else(|| set("LOCALAPPDATA"))
        .or_else(|| set("HOME").map(|home| home.join(".local/state")))
        .map(|state| state.join("beeline"))
        .ok_or_else(|| {
            Error::new("no folder to remember calibrations in").hint("set HOME or XDG_STATE_HOME")
        })
}

impl Undo {
    fn file(folder: &Path, identity: &Identity) -> PathBuf {
        folder.join(format!("undo-{}.toml", hex(&identity.uid)))
    }

    /// Remembers this calibration in `folder`.
    pub fn remember(&self, folder: &Path, identity: &Identity) -> Result<()> {
        std::fs::create_dir_all(folder)
            .context(format_args!("cannot make {}", folder.display()))?;
        let text = toml::to_string(self).context("the calibration to remember")?;
        let file = Self::file(folder, identity);
        write_whole(&file, text.as_bytes()).context(format_args!("cannot write {}", file.display()))
    }

    /// The last calibration of this robot.
    pub fn recall(folder: &Path, identity: &Identity) -> Result<Self> {
        let file = Self::file(folder, identity);
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(Error::new("no calibration of this robot to undo")
                    .hint("only this computer's last calibration can be undone; `beeline config set geometry.wheel_weight` sets any other"));
            }
            Err(error) => return Err(Error::new(format_args!("{}: {error}", file.display()))),
        };
        toml::from_str(&text).map_err(|error| {
            Error::new(format_args!("{}: {}", file.display(), error.to_string().trim_end())).hint(
                "delete this file; `beeline config set geometry.wheel_weight` does what it did",
            )
        })
    }

    /// Puts back what was there, saves it, and forgets the calibration.
    pub async fn carry_out(
        &self,
        session: &mut Session,
        folder: &Path,
        identity: &Identity,
    ) -> Result<()> {
        if identity.unsaved {
            // Only the calibration is undone: nothing else gets saved on the way.
            session.restore_config(ConfigOrigin::Saved).await?;
        }
        let mut config = session.read_config().await?;
        if config.geometry.wheel_weight != self.after {
            return Err(Error::new(format_args!(
                "W_T is {} now, not the {} of the last calibration: it was changed since",
                config.geometry.wheel_weight, self.after
            ))
            .hint(format_args!(
                "`beeline config set geometry.wheel_weight {} --save` puts the older one back",
                self.before
            )));
        }
        config.geometry.wheel_weight = self.before;
        session.write_config(&config).await?;
        session.save_config().await?;
        let file = Self::file(folder, identity);
        std::fs::remove_file(&file).context(file.display())
    }
}
