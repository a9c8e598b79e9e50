//! What was there before the last calibration of each robot, kept on the host.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use shared_proto::{ConfigOrigin, Identity};

use crate::error::{Context, Error, Result};
use crate::file::{check_writable, write_whole};
use crate::hex::hex;
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

    /// Makes sure that `folder` can remember a calibration, and leaves nothing behind.
    pub(super) fn check(folder: &Path, identity: &Identity) -> Result<()> {
        // What is not there yet is made in the nearest folder that is.
        let there = folder.ancestors().find(|folder| folder.exists()).unwrap_or(folder);
        let file =
            if there == folder { Self::file(folder, identity) } else { there.join("beeline") };
        check_writable(&file).map_err(|error| {
            Error::new(format_args!(
                "cannot remember a calibration, for --undo, in {}: {error}",
                folder.display()
            ))
            .hint("XDG_STATE_HOME names a folder that can be written")
        })
    }

    /// Remembers this calibration in `folder`.
    pub fn remember(&self, folder: &Path, identity: &Identity) -> Result<Remembered> {
        let text = toml::to_string(self).context("the calibration to remember")?;
        Remembered::write(Self::file(folder, identity), &text)
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

/// What is remembered so that it can be undone, and what was remembered before it.
#[derive(Debug)]
pub struct Remembered {
    file: PathBuf,
    older: Option<Vec<u8>>,
}

impl Remembered {
    /// Remembers `text` in `file`, whose folder is made if it is not there.
    pub(crate) fn write(file: PathBuf, text: &str) -> Result<Self> {
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder)
                .context(format_args!("cannot make {}", folder.display()))?;
        }
        let older = std::fs::read(&file).ok();
        write_whole(&file, text.as_bytes())
            .context(format_args!("cannot write {}", file.display()))?;
        Ok(Self { file, older })
    }

    /// Nothing was saved after all: remembers what was remembered before.
    pub(crate) fn take_back(self) -> Result<()> {
        let Self { file, older } = self;
        match older {
            Some(older) => write_whole(&file, &older).context(file.display()),
            None => std::fs::remove_file(&file).context(file.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNDO: Undo = Undo { robot: String::new(), before: 1.0, after: 0.99 };

    fn identity() -> Identity {
        Identity {
            name: Default::default(),
            board: Default::default(),
            uid: [7; 12],
            firmware: [0; 3],
            protocol: 0,
            control_period_us: 1000,
            limits: shared_proto::Config::default().limits,
            reset_cause: shared_proto::ResetCause::PowerOn,
            config_origin: ConfigOrigin::Factory,
            store_damaged: false,
            unsaved: false,
        }
    }

    #[test]
    fn what_is_taken_back_leaves_the_calibration_before_it() {
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().join("state/beeline");
        let identity = identity();
        Undo::check(&state, &identity).unwrap();
        assert!(!folder.path().join("state").exists(), "a check leaves nothing behind");

        UNDO.remember(&state, &identity).unwrap().take_back().unwrap();
        assert!(Undo::recall(&state, &identity).is_err(), "there was none before");
        UNDO.remember(&state, &identity).unwrap();
        let next = Undo { before: 0.99, after: 0.98, ..UNDO };
        next.remember(&state, &identity).unwrap().take_back().unwrap();
        assert_eq!(Undo::recall(&state, &identity).unwrap(), UNDO);
    }

    #[test]
    fn a_folder_that_cannot_remember_is_found_out_before() {
        let identity = identity();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("file"), "").unwrap();
        for folder in [Path::new("/proc/beeline"), &folder.path().join("file/beeline")] {
            let error = Undo::check(folder, &identity).unwrap_err().to_string();
            assert!(error.contains("for --undo"), "{error}");
        }
    }
}
