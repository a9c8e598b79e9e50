//! `beeline sim --listen`: a robot in real time, in a process of its own.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command};

use serde_json::Value;

use crate::outcome::{Outcome, wait_for};
use crate::temp_folder::TempFolder;

/// Wheels so unequal that one revolution shows the difference.
const SCENARIO: &str = include_str!("../uneven.toml");

/// A motion that is over soon, within the limits of the standard robot.
const SHORT: &str = "--distance 1rev --cruise 1.2rev/s --acceleration 2rev/s^2";

/// How far it goes \[m\].
pub const SHORT_M: f64 = 0.226;

/// A simulated robot that listens.
pub struct Served<'a> {
    child: Child,
    temp: &'a TempFolder,
    port: String,
}

impl<'a> Served<'a> {
    /// Starts one that listens at this address, with a camera and a flash.
    pub fn start(temp: &'a TempFolder, listen: &str) -> Self {
        Self::start_with(temp, listen, "")
    }

    /// As [`start`](Self::start), with more options of `beeline sim`.
    pub fn start_with(temp: &'a TempFolder, listen: &str, options: &str) -> Self {
        temp.write("uneven.toml", SCENARIO);
        let arguments = format!(
            "sim --json --listen {listen} --port sim:uneven.toml --camera track.csv --flash flash {options}"
        );
        let mut child = temp.spawn(&arguments.split_whitespace().collect::<Vec<_>>());
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let value: Value = serde_json::from_str(&line).expect("one line with the port");
        let port = value["listening"].as_str().unwrap().to_owned();
        Self { child, temp, port }
    }

    /// Where it listens.
    pub fn port(&self) -> &str {
        &self.port
    }

    /// A command on this robot.
    pub fn run(&self, arguments: &str) -> Outcome {
        self.temp.run(&format!("{arguments} --port {}", self.port))
    }

    /// A calibration, started.
    pub fn calibrate(&self) -> Child {
        let arguments = self.calibration();
        self.temp.spawn(&arguments.split_whitespace().collect::<Vec<_>>())
    }

    /// A calibration, to its end.
    pub fn calibrated(&self) -> Outcome {
        self.temp.run(&self.calibration())
    }

    fn calibration(&self) -> String {
        let port = &self.port;
        format!("calibrate --port {port} --measure track:track.csv --yes {SHORT}")
    }

    /// A command on this robot, started.
    pub fn spawn(&self, arguments: &str) -> Child {
        let arguments = format!("{arguments} --port {}", self.port);
        self.temp.spawn(&arguments.split_whitespace().collect::<Vec<_>>())
    }

    /// The process in which the robot lives.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Distance between the camera's first and last position of the robot \[m\].
    pub fn travelled_m(&self) -> f64 {
        let places = self.places_m();
        match (places.first(), places.last()) {
            (Some(first), Some(last)) => (last.0 - first.0).hypot(last.1 - first.1),
            _ => 0.0,
        }
    }

    /// The camera's positions of the robot, (x, y) \[m\].
    pub fn places_m(&self) -> Vec<(f64, f64)> {
        let track = String::from_utf8(self.temp.read("track.csv")).unwrap();
        let place = |line: &str| -> Option<(f64, f64)> {
            let mut cells = line.split(',').skip(1).map(|cell| cell.parse().ok());
            Some((cells.next()??, cells.next()??))
        };
        // The last line may be incomplete.
        let whole = &track[..track.rfind('\n').unwrap_or(0)];
        whole.lines().filter_map(place).collect()
    }

    /// Waits until the robot is in the middle of its drive, this far from its start.
    pub fn wait_until_travelled(&self, travel_m: f64) {
        wait_for(&format!("the robot to drive {travel_m} m"), || {
            (self.travelled_m() > travel_m).then_some(())
        });
    }

    /// `beeline identify --json`.
    pub fn identify(&self) -> Value {
        self.run("identify --json").ok().json()
    }

    /// A field of the configuration in use.
    pub fn wheel_weight(&self) -> f64 {
        self.run("config get geometry.wheel_weight --json").ok().json().as_f64().unwrap()
    }

    /// The saved configuration, byte for byte.
    pub fn flash(&self) -> Vec<u8> {
        self.temp.read("flash")
    }

    /// Where the picture of a calibration goes.
    pub fn picture(&self) -> PathBuf {
        self.temp.path("beeline-calibration.html")
    }
}

impl Drop for Served<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What Ctrl-C sends.
pub fn interrupt(child: &Child) {
    signal(child.id(), "INT");
}

/// Sends a signal to a process.
pub fn signal(id: u32, name: &str) {
    let sent = Command::new("kill").args([&format!("-{name}"), &id.to_string()]).status();
    assert!(sent.expect("kill runs").success());
}
