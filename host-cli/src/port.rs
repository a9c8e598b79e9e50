//! Where a robot is reached: a serial device, a TCP address, or the simulator in this process.

use std::fmt;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::{Duration, Instant};

use sim_target::{Lab, Options, Scenario, SimTarget};

use crate::campaign::Simulated;
use crate::error::{Error, Result};
use crate::file::{check_writable, is_special, target};
use crate::link::{Clock, ThreadedWire, Wire};
use crate::session::Session;
use crate::ui::warn;

/// The link's speed on a serial device unless the port says otherwise (`/dev/ttyACM0@115200`).
pub const BAUD: u32 = 921_600;

/// The slowest line that carries what keeps a motion alive, besides some telemetry. Of 12 simulated
/// robots each one is calibrated at 19200 baud and from there on; at 14400 none is.
pub const BAUD_MIN: u32 = 19_200;

/// Where a robot is reached, as the user wrote it.
#[derive(Clone, Debug, PartialEq)]
pub enum Port {
    /// `sim`, or `sim:scenario.toml`: in this process, in virtual time.
    Sim(Option<PathBuf>),
    /// `tcp:host:port`.
    Tcp(String),
    /// `/dev/ttyACM0`, `COM3`, with `@baud` if it is not [`BAUD`].
    Serial {
        /// The device.
        path: String,
        /// Bits per second.
        baud: u32,
    },
}

impl FromStr for Port {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text == "sim" {
            return Ok(Port::Sim(None));
        }
        if let Some(path) = text.strip_prefix("sim:") {
            return match path {
                "" => Err("after `sim:` the name of a scenario file is missing".into()),
                path => Ok(Port::Sim(Some(path.into()))),
            };
        }
        if let Some(address) = text.strip_prefix("tcp:") {
            return match address.rsplit_once(':') {
                Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => {
                    Ok(Port::Tcp(address.into()))
                }
                _ => {
                    Err(format!("`{text}` must read tcp:HOST:PORT, for example tcp:127.0.0.1:7700"))
                }
            };
        }
        let (path, baud) = match text.rsplit_once('@') {
            Some((path, baud)) => {
                let baud = baud.parse().map_err(|_| format!("`{baud}` is not a baud rate"))?;
                if baud < BAUD_MIN {
                    return Err(format!(
                        "{baud} baud is too slow to keep a motion alive: at least {BAUD_MIN}"
                    ));
                }
                (path, baud)
            }
            None => (text, BAUD),
        };
        if path.is_empty() {
            return Err("the name of a serial device is missing; `beeline ports` lists them".into());
        }
        Ok(Port::Serial { path: path.into(), baud })
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Port::Sim(None) => f.write_str("sim"),
            Port::Sim(Some(path)) => write!(f, "sim:{}", path.display()),
            Port::Tcp(address) => write!(f, "tcp:{address}"),
            Port::Serial { path, baud: BAUD } => f.write_str(path),
            Port::Serial { path, baud } => write!(f, "{path}@{baud}"),
        }
    }
}

impl Port {
    /// Whether this is the simulator in this process.
    pub fn is_sim(&self) -> bool {
        matches!(self, Port::Sim(_))
    }

    /// The scenario of a simulated robot.
    pub fn scenario(&self) -> Result<Scenario> {
        match self {
            Port::Sim(Some(path)) => Ok(Scenario::load(path)?),
            _ => Ok(Scenario::default()),
        }
    }
}

/// What only the simulator needs to know.
#[derive(Clone, Debug, Default)]
pub struct SimOptions {
    /// Replaces the scenario's seed.
    pub seed: Option<u64>,
    /// A file that stands for the robot's flash.
    pub flash: Option<PathBuf>,
}

impl SimOptions {
    /// What a campaign keeps of a simulated robot; nothing of a real one.
    pub fn kept(&self, port: &Port) -> Option<Simulated> {
        let Port::Sim(scenario) = port else { return None };
        let named = |path: &PathBuf| {
            // What another machine has elsewhere, or not at all, is left out.
            let file = if path.is_absolute() { path.file_name()?.as_ref() } else { path.as_path() };
            Some(file.to_string_lossy().into_owned())
        };
        Some(Simulated { scenario: scenario.as_ref().and_then(named), seed: self.seed })
    }

    /// The scenario of a port, with the seed that replaces its own.
    pub fn scenario(&self, port: &Port) -> Result<Scenario> {
        let scenario = port.scenario()?;
        Ok(Scenario { seed: self.seed.unwrap_or(scenario.seed), ..scenario })
    }

    /// The simulated robot of a scenario.
    pub fn target(&self, scenario: &Scenario) -> Result<SimTarget> {
        let cannot_use = |error: &dyn fmt::Display| {
            let flash = self.flash.as_deref().unwrap_or(Path::new("")).display();
            Error::new(format_args!("cannot use {flash} as the robot's flash: {error}")).hint(
                "--flash names a file in a folder that is there and can be written; the file is made",
            )
        };
        let flash = self.flash.as_deref().map(usable_flash).transpose();
        let flash = flash.map_err(|error| cannot_use(&error))?;
        SimTarget::new(scenario, Options { flash, ..Options::default() })
            .map_err(|error| cannot_use(&error))
    }
}

/// Makes sure, before anything moves, that a robot can save into this file; where it really is.
fn usable_flash(file: &Path) -> std::result::Result<PathBuf, String> {
    if is_special(file) {
        return Err("it is a device or a pipe, and remembers nothing".into());
    }
    let file = target(file);
    // The first save would fail, after the drive.
    if let Some(folder) = file.parent().filter(|it| !it.as_os_str().is_empty() && !it.is_dir()) {
        return Err(format!("there is no folder {}", folder.display()));
    }
    check_writable(&file).map_err(|error| error.to_string())?;
    Ok(file)
}

/// Opens the port, shakes hands with the robot and carries the procedure out.
///
/// On the simulator the procedure runs in virtual time together with the robot and is given the
/// laboratory round it; elsewhere it runs in real time.
pub fn with_robot<T>(
    port: &Port,
    sim: &SimOptions,
    procedure: impl AsyncFnOnce(&mut Session, Option<Lab>) -> Result<T>,
) -> Result<T> {
    match port {
        Port::Sim(_) => {
            let mut target = sim.target(&sim.scenario(port)?)?;
            let lab = target.lab();
            let wire = Wire::Sim(target.host_wire());
            // Each command has a simulator of its own: the session number need not differ.
            let mut session = Session::new(wire, Clock::Virtual, 1, port.to_string());
            target.run(async {
                session.open().await?;
                procedure(&mut session, Some(lab)).await
            })
        }
        Port::Tcp(_) | Port::Serial { .. } => {
            if sim.flash.is_some() || sim.seed.is_some() {
                warn(format_args!(
                    "--flash and --seed are of the simulator in this process: {port} has its own"
                ));
            }
            let wire = Wire::Threaded(open_device(port)?);
            let start = Instant::now();
            let number = session_number();
            let mut session = Session::new(wire, Clock::Real(start), number, port.to_string());
            async_io::block_on(async {
                session.open().await?;
                procedure(&mut session, None).await
            })
        }
    }
}

/// A number that the last session most likely did not have.
fn session_number() -> u32 {
    let now =
        std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    (now.as_micros() as u32).rotate_left(7) ^ std::process::id()
}

fn open_device(port: &Port) -> Result<ThreadedWire> {
    match port {
        Port::Tcp(address) => {
            let hint = "is the robot, or `beeline sim --listen tcp:...`, running there?";
            let failed = |error: &dyn fmt::Display| {
                Error::new(format_args!("cannot connect to tcp:{address}: {error}")).hint(hint)
            };
            let resolved = address.to_socket_addrs().map_err(|error| failed(&error))?;
            let stream = connect(resolved).map_err(|error| failed(&error))?;
            // Renewals are small and urgent.
            stream.set_nodelay(true).map_err(|error| failed(&error))?;
            let reader = stream.try_clone().map_err(|error| failed(&error))?;
            Ok(ThreadedWire::new(reader, stream))
        }
        Port::Serial { path, baud } => {
            let failed = |error: &dyn fmt::Display| {
                // Another program holds it, perhaps one that drives.
                let hint = match error.to_string() {
                    text if text.contains("exclusive lock") => "another program has it open; to stop the robot, press Ctrl-C there, or its stop button".into(),
                    _ => serial_hint(path),
                };
                Error::new(format_args!("cannot open the serial port {path}: {error}")).hint(hint)
            };
            let writer = serialport::new(path, *baud)
                .timeout(Duration::from_millis(100))
                .open()
                .map_err(|error| failed(&error))?;
            let reader = writer.try_clone().map_err(|error| failed(&error))?;
            Ok(ThreadedWire::new(reader, writer))
        }
        Port::Sim(_) => unreachable!("the simulator is not a device"),
    }
}

/// Connects to the first address that answers: `localhost` has one of IPv6 and one of IPv4.
fn connect(addresses: impl Iterator<Item = SocketAddr>) -> std::io::Result<TcpStream> {
    let mut failure = std::io::Error::new(std::io::ErrorKind::NotFound, "no such host");
    for address in addresses {
        match TcpStream::connect_timeout(&address, Duration::from_secs(3)) {
            Ok(stream) => return Ok(stream),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

fn serial_hint(path: &str) -> String {
    let ports = serialport::available_ports().unwrap_or_default();
    match ports.as_slice() {
        [] => "no serial port is plugged in; `--port sim` drives the simulator".into(),
        ports if ports.iter().any(|port| port.port_name == path) => {
            "it exists: is another program using it, or are you not allowed to (group dialout)?"
                .into()
        }
        ports => {
            let names: Vec<_> = ports.iter().map(|port| port.port_name.as_str()).collect();
            format!("there is: {}", names.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, TcpListener};

    use super::*;

    #[test]
    fn a_campaign_keeps_which_robot_was_simulated_and_no_folder_of_a_machine() {
        let kept =
            |port: &str| SimOptions { seed: Some(7), flash: None }.kept(&port.parse().unwrap());
        let named = |port: &str| kept(port).unwrap().scenario;
        assert_eq!(kept("sim"), Some(Simulated { scenario: None, seed: Some(7) }));
        assert_eq!(named("sim:robots/wide.toml").as_deref(), Some("robots/wide.toml"));
        assert_eq!(named("sim:/robots/wide.toml").as_deref(), Some("wide.toml"));
        assert_eq!(kept("/dev/ttyACM0"), None);
    }

    #[test]
    fn a_host_that_answers_on_its_second_address_is_reached() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let there = listener.local_addr().unwrap();
        // Nobody listens on port 1.
        let nobody = SocketAddr::from((Ipv4Addr::LOCALHOST, 1));
        assert_eq!(connect([nobody, there].into_iter()).unwrap().peer_addr().unwrap(), there);
        assert!(connect([nobody].into_iter()).is_err());
        assert!(connect([].into_iter()).unwrap_err().to_string().contains("no such host"));
    }
}
