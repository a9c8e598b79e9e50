//! What a robot's geometry was before a campaign was applied to it, kept on the host.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use shared_proto::{ConfigOrigin, GeometryConfig, Identity};

use crate::calibrate::Remembered;
use crate::error::{Context, Error, Result};
use crate::hex::hex;
use crate::session::Session;

/// The geometry before and after.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Undo {
    /// The robot's name, for whoever reads the file.
    pub robot: String,
    /// Before.
    pub before: GeometryConfig,
    /// After.
    pub after: GeometryConfig,
}

impl Undo {
    fn file(folder: &Path, identity: &Identity) -> PathBuf {
        folder.join(format!("undo-apply-{}.toml", hex(&identity.uid)))
    }

    /// Remembers it in `folder`.
    pub fn remember(&self, folder: &Path, identity: &Identity) -> Result<Remembered> {
        let text = toml::to_string(self).context("the geometry to remember")?;
        Remembered::write(Self::file(folder, identity), &text)
    }

    /// What was last applied to this robot.
    pub fn recall(folder: &Path, identity: &Identity) -> Result<Self> {
        let file = Self::file(folder, identity);
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(Error::new("nothing was applied to this robot that could be undone")
                    .hint("only what this computer applied last can be undone; `beeline config set` sets any other"));
            }
            Err(error) => return Err(Error::new(format_args!("{}: {error}", file.display()))),
        };
        toml::from_str(&text).map_err(|error| {
            Error::new(format_args!("{}: {}", file.display(), error.to_string().trim_end()))
                .hint("delete this file; `beeline config set geometry...` does what it did")
        })
    }

    /// Puts back what was there, saves it, and forgets it.
    pub async fn carry_out(
        &self,
        session: &mut Session,
        folder: &Path,
        identity: &Identity,
    ) -> Result<()> {
        if identity.unsaved {
            // Only this is undone: nothing else gets saved on the way.
            session.restore_config(ConfigOrigin::Saved).await?;
        }
        let mut config = session.read_config().await?;
        if config.geometry != self.after {
            return Err(Error::new("the robot's geometry was changed since it was applied")
                .hint("`beeline config set geometry.wheel_weight ...` sets what it should be"));
        }
        config.geometry = self.before;
        session.write_config(&config).await?;
        session.save_config().await?;
        let file = Self::file(folder, identity);
        std::fs::remove_file(&file).context(file.display())
    }
}
