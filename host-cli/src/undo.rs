//! What a robot's geometry was before it was last changed, kept on the host.
//!
//! A calibration changes W_T alone, a campaign or UMBmark all of the geometry; each remembers what it
//! changed, and only that is put back.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use shared_proto::{Config, ConfigOrigin, GeometryConfig, Identity};

use crate::error::{Context, Error, Result};
use crate::hex::hex;
use campaign::file::{check_writable, write_whole};
use host_link::session::Session;

/// A part of a configuration that can be put back.
pub trait Undoable: Copy + PartialEq + Serialize + DeserializeOwned {
    /// What the names of its files begin with; the robot's uid follows.
    const FILE: &'static str;
    /// Nothing is remembered: what is missing, and what sets it otherwise.
    const NOTHING: (&'static str, &'static str);

    /// What a configuration has.
    fn of(config: &Config) -> Self;

    /// Puts it into a configuration.
    fn put_into(self, config: &mut Config);

    /// The robot has something else than it was left with: `undo` would undo somebody else's change.
    fn changed_since(now: Self, undo: &Undo<Self>) -> Error;
}

/// W_T alone, which a calibration changes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct WheelWeight(pub f64);

impl Undoable for WheelWeight {
    const FILE: &'static str = "undo";
    const NOTHING: (&'static str, &'static str) = (
        "no calibration of this robot to undo",
        "only this computer's last calibration can be undone; `beeline config set geometry.wheel_weight` sets any other",
    );

    fn of(config: &Config) -> Self {
        Self(config.geometry.wheel_weight)
    }

    fn put_into(self, config: &mut Config) {
        config.geometry.wheel_weight = self.0;
    }

    fn changed_since(now: Self, undo: &Undo<Self>) -> Error {
        Error::new(format_args!(
            "W_T is {} now, not the {} of the last calibration: it was changed afterwards",
            now.0, undo.after.0
        ))
        .hint(format_args!(
            "`beeline config set geometry.wheel_weight {} --save` puts the older one back",
            undo.before.0
        ))
    }
}

impl Undoable for GeometryConfig {
    const FILE: &'static str = "undo-apply";
    const NOTHING: (&'static str, &'static str) = (
        "this computer has applied nothing to this robot that could be undone",
        "only what this computer applied last can be undone; `beeline config set` sets any other",
    );

    fn of(config: &Config) -> Self {
        config.geometry
    }

    fn put_into(self, config: &mut Config) {
        config.geometry = self;
    }

    fn changed_since(_now: Self, _undo: &Undo<Self>) -> Error {
        Error::new("the robot's geometry was changed after `beeline apply`")
            .hint("`beeline config set geometry.wheel_weight ...` sets what it should be")
    }
}

/// The last change of one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Undo<T> {
    /// The robot's name, for whoever reads the file.
    pub robot: String,
    /// Before.
    pub before: T,
    /// After.
    pub after: T,
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

/// Makes sure that `folder` can remember a change of this robot, and leaves nothing behind.
pub fn check<T: Undoable>(folder: &Path, identity: &Identity) -> Result<()> {
    // What is not there yet is made in the nearest folder that is.
    let there = folder.ancestors().find(|folder| folder.exists()).unwrap_or(folder);
    let file = if there == folder { file::<T>(folder, identity) } else { there.join("beeline") };
    check_writable(&file).map_err(|error| {
        Error::new(format_args!(
            "cannot remember what is changed, for --undo, in {}: {error}",
            folder.display()
        ))
        .hint("XDG_STATE_HOME names a folder that can be written")
    })
}

fn file<T: Undoable>(folder: &Path, identity: &Identity) -> PathBuf {
    folder.join(format!("{}-{}.toml", T::FILE, hex(&identity.uid)))
}

impl<T: Undoable> Undo<T> {
    /// Remembers this change in `folder`.
    pub fn remember(&self, folder: &Path, identity: &Identity) -> Result<Remembered> {
        let text = toml::to_string(self).context("the change to remember")?;
        Remembered::write(file::<T>(folder, identity), &text)
    }

    /// The last change of this robot.
    pub fn recall(folder: &Path, identity: &Identity) -> Result<Self> {
        let file = file::<T>(folder, identity);
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                let (what, hint) = T::NOTHING;
                return Err(Error::new(what).hint(hint));
            }
            Err(error) => {
                return Err(Error::new(format_args!("{}: {error}", file.display()))
                    .hint("the last change is remembered there: may you read it?"));
            }
        };
        toml::from_str(&text).map_err(|error| {
            let problem = error.message().replace('\n', " ");
            Error::new(format_args!("{}: {problem}", file.display()))
                .hint("delete this file; `beeline config set geometry...` does what it did")
        })
    }

    /// Puts back what was there, saves it, and forgets the change.
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
        let now = T::of(&config);
        if now != self.after {
            return Err(T::changed_since(now, self));
        }
        self.before.put_into(&mut config);
        session.write_config(&config).await?;
        session.save_config().await?;
        let file = file::<T>(folder, identity);
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
    fn write(file: PathBuf, text: &str) -> Result<Self> {
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

    const UNDO: Undo<WheelWeight> =
        Undo { robot: String::new(), before: WheelWeight(1.0), after: WheelWeight(0.99) };

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

    fn recalled(folder: &Path) -> Result<Undo<WheelWeight>> {
        Undo::recall(folder, &identity())
    }

    #[test]
    fn what_each_change_remembers_is_apart_and_reads_as_it_always_did() {
        let folder = tempfile::tempdir().unwrap();
        let (state, identity) = (folder.path(), identity());
        let [before, mut after] = [Config::default().geometry; 2];
        after.track_width_m = 0.38;
        let geometry = Undo { robot: "a \"b\"".into(), before, after };
        geometry.remember(state, &identity).unwrap();
        UNDO.remember(state, &identity).unwrap();
        assert_eq!(Undo::<GeometryConfig>::recall(state, &identity).unwrap(), geometry);
        assert_eq!(recalled(state).unwrap(), UNDO);
        let uid = hex(&identity.uid);
        let text = std::fs::read_to_string(state.join(format!("undo-{uid}.toml"))).unwrap();
        assert_eq!(text, "robot = \"\"\nbefore = 1.0\nafter = 0.99\n");
        assert!(state.join(format!("undo-apply-{uid}.toml")).exists());
    }

    #[test]
    fn what_is_taken_back_leaves_the_calibration_before_it() {
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().join("state/beeline");
        let identity = identity();
        check::<WheelWeight>(&state, &identity).unwrap();
        assert!(!folder.path().join("state").exists(), "a check leaves nothing behind");

        UNDO.remember(&state, &identity).unwrap().take_back().unwrap();
        assert!(recalled(&state).is_err(), "there was none before");
        UNDO.remember(&state, &identity).unwrap();
        let next = Undo { before: WheelWeight(0.99), after: WheelWeight(0.98), ..UNDO };
        next.remember(&state, &identity).unwrap().take_back().unwrap();
        assert_eq!(recalled(&state).unwrap(), UNDO);
    }

    #[test]
    fn a_folder_that_cannot_remember_is_found_out_before() {
        let identity = identity();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("file"), "").unwrap();
        for folder in [Path::new("/proc/beeline"), &folder.path().join("file/beeline")] {
            let error = check::<WheelWeight>(folder, &identity).unwrap_err().to_string();
            assert!(error.contains("for --undo"), "{error}");
        }
    }
}
