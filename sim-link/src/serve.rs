//! Serves a robot on a virtual clock in real time, behind TCP or a pseudo-terminal.
//!
//! The virtual clock follows real time. Any program that can talk to a serial port can talk to the
//! robot. [`serve`] serves the simulator; a program with another robot uses [`Server`] in a loop of
//! its own.

use std::fmt;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use host_link::cancel::Cancel;
use host_link::listen::{ClientEvent, Line, Listen};
use sim_target::{HostWire, SimTarget, Testbed};

use crate::remote::TestbedRequests;

/// The simulation catches up with real time this often.
const STEP: Duration = Duration::from_millis(1);

/// What to do besides serving.
#[derive(Default)]
pub struct ServeOptions<'a> {
    /// Write the camera's samples to this new file.
    pub camera: Option<&'a Path>,
    /// Put the robot back at its line when a client connects and it stands still.
    pub reset_on_connect: bool,
    /// Stop after this long.
    pub duration: Option<Duration>,
    /// What other threads ask of the testbed.
    pub requests: Option<TestbedRequests>,
}

/// What happens while a robot is served.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ServeEvent {
    /// The robot can be reached by this port.
    Listening(String),
    /// What has become of a client.
    Client(ClientEvent),
    /// The robot was not put back at its line, because it moves.
    NotPutBack,
}

/// Why a robot cannot be served.
#[derive(Debug)]
pub enum ServeError {
    /// The port cannot be opened.
    Link(host_link::Error),
    /// The robot cannot be put back when a client connects: a pseudo-terminal does not show that
    /// one does.
    ResetOnPty,
    /// The camera's file exists.
    CameraExists(PathBuf),
    /// The camera's file cannot be created.
    CameraNew(PathBuf, io::Error),
    /// The camera's file cannot be written any more.
    CameraWrite(PathBuf, io::Error),
}

impl std::error::Error for ServeError {}

impl fmt::Display for ServeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Link(error) => write!(f, "{error}"),
            Self::ResetOnPty => f.write_str(
                "--reset-on-connect does nothing here: a pseudo-terminal does not report connections",
            ),
            Self::CameraExists(path) => write!(f, "{} exists", path.display()),
            Self::CameraNew(path, error) | Self::CameraWrite(path, error) => {
                write!(f, "cannot write {}: {error}", path.display())
            }
        }
    }
}

/// Serves until `cancel` is requested; calls `tell` with what happens.
pub fn serve(
    target: &mut SimTarget,
    listen: &Listen,
    options: &ServeOptions<'_>,
    cancel: &Cancel,
    tell: &mut dyn FnMut(ServeEvent),
) -> Result<(), ServeError> {
    let mut server = Server::open(listen, options, target.host_wire(), target.testbed())?;
    tell(ServeEvent::Listening(server.address().into()));
    let start = Instant::now();
    let start_us = sim_target::now_us();
    while !cancel.is_requested() && options.duration.is_none_or(|end| start.elapsed() < end) {
        server.exchange(tell)?;
        if let Some(requests) = &options.requests {
            requests.carry_out(&server.testbed);
        }
        target.run_until_us(start_us + start.elapsed().as_micros() as u64);
        server.exchange(tell)?;
        std::thread::sleep(STEP);
    }
    server.close()
}

/// Whether the robot stands still with its motors off, so that it can be picked up.
fn stands_still(testbed: &Testbed) -> bool {
    /// A wheel at rest creeps at most this fast: a thousandth of the paper's cruise \[rad/s\].
    const STILL_RAD_S: f64 = 0.003;
    testbed.plant(|plant| {
        let turns = plant.wheel_speeds_rad_s().any(|speed| speed.abs() > STILL_RAD_S);
        let driven = plant.currents_a().any(|current_a| current_a != 0.0);
        !turns && !driven
    })
}

/// One robot behind a port. The owner calls [`exchange`](Self::exchange) every millisecond.
pub struct Server {
    line: Line,
    camera: Option<CameraFile>,
    reset_on_connect: bool,
    wire: HostWire,
    testbed: Testbed,
}

impl Server {
    /// Opens the port.
    pub fn open(
        listen: &Listen,
        options: &ServeOptions<'_>,
        wire: HostWire,
        testbed: Testbed,
    ) -> Result<Self, ServeError> {
        if options.reset_on_connect && *listen == Listen::Pty {
            return Err(ServeError::ResetOnPty);
        }
        let line = Line::open(listen).map_err(ServeError::Link)?;
        let camera =
            options.camera.map(|path| CameraFile::open(path, testbed.clone())).transpose()?;
        Ok(Self { line, camera, reset_on_connect: options.reset_on_connect, wire, testbed })
    }

    /// The port by which to reach the robot.
    pub fn address(&self) -> &str {
        self.line.address()
    }

    /// Passes on what client and robot have sent since the last call.
    pub fn exchange(&mut self, tell: &mut dyn FnMut(ServeEvent)) -> Result<(), ServeError> {
        let Self { line, wire, testbed, reset_on_connect, .. } = self;
        let mut news = |news| {
            tell(ServeEvent::Client(news));
            if *reset_on_connect && news == ClientEvent::Connected {
                if stands_still(testbed) {
                    testbed.place_at_start();
                } else {
                    tell(ServeEvent::NotPutBack);
                }
            }
        };
        line.pass_on(&|| wire.has_room(), &mut |bytes| wire.write_now(bytes), &mut news);
        let mut buffer = [0; 1024];
        loop {
            let len = wire.read_now(&mut buffer);
            // Without news, too: what a client did not take before may go out now.
            line.write(&buffer[..len], &mut news);
            if len == 0 {
                break;
            }
        }
        match &mut self.camera {
            Some(camera) => camera.append(),
            None => Ok(()),
        }
    }

    /// Syncs the camera's file to the disk, and closes the port.
    pub fn close(self) -> Result<(), ServeError> {
        match self.camera {
            Some(CameraFile { file, path, .. }) => {
                file.sync_all().map_err(|error| ServeError::CameraWrite(path, error))
            }
            None => Ok(()),
        }
    }
}

/// The camera's samples as a growing track file.
struct CameraFile {
    file: File,
    path: PathBuf,
    testbed: Testbed,
    written: usize,
}

impl CameraFile {
    fn open(path: &Path, testbed: Testbed) -> Result<Self, ServeError> {
        let mut file = File::create_new(path).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => ServeError::CameraExists(path.into()),
            _ => ServeError::CameraNew(path.into(), error),
        })?;
        writeln!(file, "t_s,x_m,y_m,heading_rad").map_err(|error| {
            // Empty, it would be in the way of the next one.
            let _ = std::fs::remove_file(path);
            ServeError::CameraWrite(path.into(), error)
        })?;
        Ok(Self { file, path: path.into(), testbed, written: 0 })
    }

    fn append(&mut self) -> Result<(), ServeError> {
        if self.testbed.camera_len() == self.written {
            return Ok(());
        }
        let samples = self.testbed.camera_samples_from(self.written);
        self.written += samples.len();
        let lines: String = samples
            .iter()
            .map(|s| format!("{:.6},{:.7},{:.7},{:.7}\n", s.t_s, s.x_m, s.y_m, s.heading_rad))
            .collect();
        self.file
            .write_all(lines.as_bytes())
            .map_err(|error| ServeError::CameraWrite(self.path.clone(), error))
    }
}
