//! What a robot's geometry was before its last change, kept on the host.
//!
//! A calibration changes W_T alone, `apply` and UMBmark the whole geometry; each remembers what it
//! changed and how sure that was, and only that is put back.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use shared_proto::{Config, ConfigOrigin, GeometryConfig, Identity, OdometryConfig};

use crate::error::{Context, Error, Result};
use crate::hex::hex;
use campaign::file::{check_writable, write_whole};
use host_link::session::Session;

/// A part of a configuration that can be put back.
pub trait Restorable: Copy + PartialEq + Serialize + DeserializeOwned {
    /// The beginning of its file names; the robot's uid follows.
    const FILE: &'static str;
    /// The error and the advice if nothing is remembered.
    const NOTHING: (&'static str, &'static str);

    /// This part of a configuration.
    fn of(config: &Config) -> Self;

    /// Puts this part into a configuration.
    fn put_into(self, config: &mut Config);

    /// Puts into a configuration how sure this part was, if the odometry depends on it.
    fn put_deviations(_before: &OdometryConfig, _config: &mut Config) {}

    /// The error if the robot was changed since: an undo would undo that other change.
    fn changed_since(now: Self, undo: &Undo<Self>) -> Error;
}

/// W_T alone, which a calibration changes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct WheelWeight(pub f64);

impl Restorable for WheelWeight {
    const FILE: &'static str = "undo";
    const NOTHING: (&'static str, &'static str) = (
        "no calibration of this robot to undo",
        "only this computer's last W_T can be undone; `beeline apply --undo` undoes UMBmark, `beeline config set geometry.wheel_weight` sets any other",
    );

    fn of(config: &Config) -> Self {
        Self(config.geometry.wheel_weight)
    }

    fn put_into(self, config: &mut Config) {
        config.geometry.wheel_weight = self.0;
    }

    fn put_deviations(before: &OdometryConfig, config: &mut Config) {
        config.odometry.wheel_weight_sd = before.wheel_weight_sd;
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

impl Restorable for GeometryConfig {
    const FILE: &'static str = "undo-apply";
    const NOTHING: (&'static str, &'static str) = (
        "nothing that this computer applied to this robot can be undone",
        "only what this computer applied last can be undone; `beeline config set` sets any other",
    );

    fn of(config: &Config) -> Self {
        config.geometry
    }

    fn put_into(self, config: &mut Config) {
        config.geometry = self;
    }

    fn put_deviations(before: &OdometryConfig, config: &mut Config) {
        let noise_m_per_sqrt_m = config.odometry.noise_m_per_sqrt_m;
        config.odometry = OdometryConfig { noise_m_per_sqrt_m, ..*before };
    }

    fn changed_since(_now: Self, _undo: &Undo<Self>) -> Error {
        Error::new("the robot's geometry was changed after `beeline apply`")
            .hint("set the values that you want, for example with `beeline config set geometry.wheel_weight ...`")
    }
}

/// The last change of one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Undo<T> {
    /// The robot's name, for people who read the file.
    pub robot: String,
    /// The values before the change.
    pub before: T,
    /// The values after it.
    pub after: T,
    /// How sure the odometry was before it; none if it does not depend on the values, and in a file of an older version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub odometry: Option<OdometryConfig>,
}

/// The folder that remembers calibrations: `$XDG_STATE_HOME/beeline`, or `~/.local/state/beeline`.
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

/// Checks that `folder` can remember a change of this robot, and leaves nothing behind.
pub fn check<T: Restorable>(folder: &Path, identity: &Identity) -> Result<()> {
    // A folder that does not exist is created later, in the nearest one that does.
    let there = folder.ancestors().find(|folder| folder.exists()).unwrap_or(folder);
    let file = if there == folder { file::<T>(folder, identity) } else { there.join("beeline") };
    check_writable(&file).map_err(|error| {
        Error::new(format_args!(
            "cannot keep the old values for --undo in {}: {error}",
            folder.display()
        ))
        .hint(error.hint("set XDG_STATE_HOME to a folder that you may write"))
    })
}

fn file<T: Restorable>(folder: &Path, identity: &Identity) -> PathBuf {
    folder.join(format!("{}-{}.toml", T::FILE, hex(&identity.uid)))
}

impl<T: Restorable> Undo<T> {
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
                    .hint("the last change is kept there: check that you may read it"));
            }
        };
        toml::from_str(&text).map_err(|error| {
            let problem = error.message().replace('\n', " ");
            Error::new(format_args!("{}: {problem}", file.display()))
                .hint("delete this file, and restore the values yourself with `beeline config set geometry...`")
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
            // The save below must not save other changes.
            session.restore_config(ConfigOrigin::Saved).await?;
        }
        let config = session.read_config().await?;
        let now = T::of(&config);
        let mut old = config.clone();
        self.before.put_into(&mut old);
        if let Some(odometry) = &self.odometry {
            T::put_deviations(odometry, &mut old);
        }
        // An undo that was interrupted may have put it back already.
        if old != config {
            if now != self.before && now != self.after {
                return Err(T::changed_since(now, self));
            }
            session.write_config(&old).await?;
            session.save_config().await?;
        }
        let file = file::<T>(folder, identity);
        std::fs::remove_file(&file).context(file.display())
    }
}

/// A change that is remembered, and the one that was remembered before it.
#[derive(Debug)]
pub struct Remembered {
    file: PathBuf,
    older: Option<Vec<u8>>,
}

impl Remembered {
    /// Writes `text` to `file`, whose folder is created if it does not exist.
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

    /// Forgets this change, as it was not saved, and remembers the one before it again.
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

    /// As a version wrote it that knew nothing of how sure the odometry is.
    const UNDO: Undo<WheelWeight> = Undo {
        robot: String::new(),
        before: WheelWeight(1.0),
        after: WheelWeight(0.99),
        odometry: None,
    };

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
    fn each_kind_of_change_has_a_file_of_its_own_in_the_same_format_as_ever() {
        let folder = tempfile::tempdir().unwrap();
        let (state, identity) = (folder.path(), identity());
        let [before, mut after] = [Config::default().geometry; 2];
        after.track_width_m = 0.38;
        let odometry = Some(OdometryConfig { wheel_weight_sd: 0.001, ..OdometryConfig::default() });
        let geometry = Undo { robot: "a \"b\"".into(), before, after, odometry };
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
    fn only_the_deviations_of_what_was_changed_are_put_back() {
        let odometry = OdometryConfig {
            noise_m_per_sqrt_m: 0.001,
            wheel_weight_sd: 0.000_3,
            track_width_sd_m: 0.000_9,
        };
        let mut config = Config { odometry, ..Config::default() };
        let (before, mut calibrated) = (OdometryConfig::default(), config.clone());
        WheelWeight::put_deviations(&before, &mut calibrated);
        let expected =
            OdometryConfig { wheel_weight_sd: before.wheel_weight_sd, ..config.odometry };
        assert_eq!(calibrated.odometry, expected);
        GeometryConfig::put_deviations(&before, &mut config);
        assert_eq!(config.odometry, OdometryConfig { noise_m_per_sqrt_m: 0.001, ..before });
    }

    #[test]
    fn taking_back_leaves_the_calibration_before() {
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
    fn a_folder_that_cannot_be_written_is_refused_beforehand() {
        let identity = identity();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("file"), "").unwrap();
        for folder in [Path::new("/proc/beeline"), &folder.path().join("file/beeline")] {
            let error = check::<WheelWeight>(folder, &identity).unwrap_err().to_string();
            assert!(error.contains("for --undo"), "{error}");
        }
    }
}
