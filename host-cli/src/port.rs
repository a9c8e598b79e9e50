//! Where a robot is reached: a serial device, a TCP address, or the simulator in this process.
//!
//! What is done with the robot is left to the caller's procedure.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use campaign::Simulated;
use campaign::bounded_read::read_keys;
use campaign::file::{check_writable, is_special, target};
use host_link::address::{Address, AddressError};
use host_link::{Session, key_file};
use shared_proto::Key;
use sim_link::RemoteTestbed;
use sim_target::scenario::ScenarioError;
use sim_target::{Options, Scenario, SimTarget};

use crate::dialogue;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::pose_source::bench::Bench;
use crate::ui::warn;

/// Where a robot is reached, as the user wrote it.
#[derive(Clone, Debug, PartialEq)]
pub enum Port {
    /// `sim`, or `sim:scenario.toml`: in this process, in virtual time.
    Sim(Option<PathBuf>),
    /// A real robot, or one that another process simulates.
    At(Address),
    /// A robot that another thread of this program simulates.
    Served(Address, RemoteTestbed),
}

impl FromStr for Port {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text.is_empty() {
            return Err("it is empty: name a port, or unset BEELINE_PORT".into());
        }
        if text == "sim" {
            return Ok(Port::Sim(None));
        }
        if let Some(path) = text.strip_prefix("sim:") {
            return match path {
                "" => Err("after `sim:` the name of a scenario file is missing".into()),
                path => Ok(Port::Sim(Some(path.into()))),
            };
        }
        text.parse().map(Port::At).map_err(|error| match error {
            AddressError::NoDevice => format!("{error}; `beeline ports` lists them"),
            error => error.to_string(),
        })
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Port::Sim(None) => f.write_str("sim"),
            Port::Sim(Some(path)) => write!(f, "sim:{}", path.display()),
            Port::At(address) | Port::Served(address, _) => write!(f, "{address}"),
        }
    }
}

impl Port {
    /// Whether this is the simulator in this process.
    pub fn is_sim(&self) -> bool {
        matches!(self, Port::Sim(_))
    }

    /// Whether a command at this port has the robot's testbed at hand.
    pub fn has_testbed(&self) -> bool {
        matches!(self, Port::Sim(_) | Port::Served(..))
    }

    /// The scenario of a simulated robot.
    pub fn scenario(&self) -> Result<Scenario> {
        match self {
            Port::Sim(Some(path)) => {
                let origin = path.display().to_string();
                // A pipe would be waited for without end, and a device may never end.
                let text =
                    read_keys(path).map_err(|error| ScenarioError::unreadable(&origin, &error))?;
                Ok(Scenario::parse(&origin, &text)?)
            }
            _ => Ok(Scenario::default()),
        }
    }
}

/// The options of the simulator, and the key of whatever robot it is.
#[derive(Clone, Debug, Default)]
pub struct SimOptions {
    /// Replaces the scenario's seed.
    pub seed: Option<u64>,
    /// A file that stands for the robot's flash.
    pub flash: Option<PathBuf>,
    /// The file of the robot's key.
    pub key_file: Option<PathBuf>,
    /// A robot that has no key will do as well.
    pub key_optional: bool,
}

impl SimOptions {
    /// How a campaign names a simulated robot; `None` for a real one.
    pub fn simulated_robot(&self, port: &Port) -> Option<Simulated> {
        let Port::Sim(scenario) = port else { return None };
        let named = |path: &PathBuf| {
            // An absolute path would not exist on another computer: only the name is kept.
            let file = if path.is_absolute() { path.file_name()?.as_ref() } else { path.as_path() };
            Some(file.to_string_lossy().into_owned())
        };
        Some(Simulated { scenario: scenario.as_ref().and_then(named), seed: self.seed })
    }

    /// The same robot for the run of this number in a campaign, from 1: with noise of its own, as it is simulated anew for
    /// each recorded run. The first has that of the seed itself.
    pub fn for_run(&self, port: &Port, number: u64) -> Result<Self> {
        if !port.is_sim() || number <= 1 {
            return Ok(self.clone());
        }
        // Steele's SplitMix64: numbers and seeds that differ in a bit give seeds that differ in half of them.
        let mut seed = self.scenario(port)?.seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        seed = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        seed = (seed ^ (seed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Ok(Self { seed: Some(seed ^ (seed >> 31)), ..self.clone() })
    }

    /// The scenario of a port, with the seed of these options.
    pub fn scenario(&self, port: &Port) -> Result<Scenario> {
        let scenario = port.scenario()?;
        Ok(Scenario { seed: self.seed.unwrap_or(scenario.seed), ..scenario })
    }

    /// The key, if one is given.
    pub fn key(&self) -> Result<Option<Key>> {
        Ok(self.key_file.as_deref().map(key_file::read).transpose()?)
    }

    /// The simulated robot of a scenario, in this process.
    pub fn target(&self, scenario: &Scenario) -> Result<SimTarget> {
        self.target_with(scenario, Options::default())
    }

    /// The simulated robot of a scenario, for other processes: it has the key, and on a network none can be set.
    pub fn served(&self, scenario: &Scenario, network: bool) -> Result<SimTarget> {
        let (key, random) = (self.key()?, Some(key_file::random_seed()?));
        self.target_with(
            scenario,
            Options { key, key_locked: network, random, ..Options::default() },
        )
    }

    fn target_with(&self, scenario: &Scenario, options: Options) -> Result<SimTarget> {
        let cannot_use = |error: &dyn fmt::Display| {
            let flash = self.flash.as_deref().unwrap_or(Path::new("")).display();
            Error::new(format_args!("cannot use {flash} as the robot's flash: {error}")).hint(
                "give --flash a file in a folder that exists and that you may write; the file is created",
            )
        };
        let flash = self.flash.as_deref().map(usable_flash).transpose();
        let flash = flash.map_err(|error| cannot_use(&error))?;
        SimTarget::new(scenario, Options { flash, ..options }).map_err(|error| cannot_use(&error))
    }
}

/// Checks, before anything moves, that a robot can save into this file; returns its path behind
/// links.
fn usable_flash(file: &Path) -> std::result::Result<PathBuf, String> {
    if is_special(file) {
        return Err("it is a device or a pipe, and remembers nothing".into());
    }
    let file = target(file);
    // Without its folder, the first save would fail, and only after the drive.
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.is_dir();
    if let Some(folder) = file.parent().filter(is_missing) {
        return Err(format!("there is no folder {}", folder.display()));
    }
    check_writable(&file).map_err(|error| error.to_string())?;
    Ok(file)
}

/// Opens the port, shakes hands with the robot and carries the procedure out.
///
/// With the simulator the procedure runs in virtual time, and is given the robot's testbed;
/// otherwise it runs in real time.
pub fn with_robot<T>(
    port: &Port,
    sim: &SimOptions,
    procedure: impl AsyncFnOnce(&mut Session, Option<Bench>) -> Result<T>,
) -> Result<T> {
    with_session(port, sim, async |session, testbed| {
        session.open().await?;
        procedure(session, testbed).await
    })
}

/// As [`with_robot`], with a session that is not open yet.
pub fn with_session<T>(
    port: &Port,
    sim: &SimOptions,
    procedure: impl AsyncFnOnce(&mut Session, Option<Bench>) -> Result<T>,
) -> Result<T> {
    match port {
        Port::Sim(_) => {
            let mut target = sim.target(&sim.scenario(port)?)?;
            let testbed = target.testbed();
            // Each command has a new simulator, so the session number may always be the same.
            let mut session = sim_link::session(&target.host_wire(), 1, port.to_string());
            session.cancel_by(&interrupt::cancel());
            if let Some(key) = sim.key()? {
                // Nobody else reaches this robot, and its results are the same each time.
                session.offer_key(key, Key::new([0; Key::LEN]));
            }
            target.run(async { procedure(&mut session, Some(Bench::Here(testbed))).await })
        }
        Port::At(address) | Port::Served(address, _) => {
            if sim.flash.is_some() || sim.seed.is_some() {
                warn(format_args!(
                    "--flash and --seed are for a robot that this command simulates; they do nothing on {port}"
                ));
            }
            let key = sim.key()?;
            let mut session = host_link::connect(address)?;
            session.cancel_by(&interrupt::cancel());
            if let Some(key) = key {
                let secret = key_file::random()?;
                match sim.key_optional {
                    true => session.offer_key(key, secret),
                    false => session.use_key(key, secret),
                }
            }
            let bench = match port {
                Port::Served(_, testbed) => Some(Bench::Served(testbed.clone())),
                _ => None,
            };
            if let Some(dialogue) = dialogue::current() {
                session.hold_by(dialogue.holder());
            }
            host_link::block_on(async { procedure(&mut session, bench).await })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_campaign_keeps_which_robot_was_simulated_and_no_folder_of_a_machine() {
        let kept = |port: &str| {
            SimOptions { seed: Some(7), ..SimOptions::default() }
                .simulated_robot(&port.parse().unwrap())
        };
        let named = |port: &str| kept(port).unwrap().scenario;
        assert_eq!(kept("sim"), Some(Simulated { scenario: None, seed: Some(7) }));
        assert_eq!(named("sim:robots/wide.toml").as_deref(), Some("robots/wide.toml"));
        assert_eq!(named("sim:/robots/wide.toml").as_deref(), Some("wide.toml"));
        assert_eq!(kept("/dev/ttyACM0"), None);
    }
}
