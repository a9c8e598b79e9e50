//! The emulated board as a program of its own, and `beeline` on it.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use host_cli::calibrate::{Decision, Settings, calibrate};
use host_cli::port::{Port, SimOptions, with_robot};
use host_cli::pose_source::Sigma;
use host_cli::pose_source::track_file::TrackFile;
use host_link::address::Address;
use host_link::motion::Motion;
use shared_proto::{ConfigOrigin, WheelPair};

use super::image;

/// The program, ended however the test ends.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Wheels so unequal that one revolution shows it.
const SCENARIO: &str = include_str!("../../../tests/uneven.toml");

#[test]
fn a_host_calibrates_the_emulated_board_over_tcp() {
    let folder = std::env::temp_dir().join(format!("beeline-emulated-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("uneven.toml"), SCENARIO).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_emulate"))
        .args(["--listen", "127.0.0.1:0", "--scenario", "uneven.toml", "--camera", "track.csv"])
        .env("BEELINE_IMAGE", image())
        .current_dir(&folder)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    // Held open: the program goes on writing to it.
    let mut output = BufReader::new(child.stdout.take().unwrap());
    output.read_line(&mut line).unwrap();
    let _program = Program(child);
    let address = line.trim().rsplit("tcp:").next().expect("it says where it listens").to_string();

    let port = Port::At(Address::Tcp(address));
    let settings = Settings {
        motion: Motion {
            distance: WheelPair::both(1.0),
            cruise: 1.2,
            acceleration: 2.0,
            ..Motion::PAPER
        },
        ..Settings::default()
    };
    let (identity, outcome, config) =
        with_robot(&port, &SimOptions::default(), async |session, _| {
            let identity = session.identify().await?;
            let noise = Some(Sigma { position_m: 0.001, heading_rad: 0.002 });
            let mut track = TrackFile { path: folder.join("track.csv"), noise, confirm: false };
            let outcome = calibrate(session, &mut track, &settings, &mut |_| ()).await?;
            Ok((identity, outcome, session.read_config().await?))
        })
        .unwrap();
    drop(output);
    let _ = std::fs::remove_dir_all(&folder);
    assert_eq!(identity.board.as_str(), "NUCLEO-F429ZI");
    assert_eq!(identity.config_origin, ConfigOrigin::Factory);
    assert!(matches!(outcome.decision, Decision::Corrected(_)));
    // One revolution seen by a camera of 2 mrad: a sigma of 0.004 at most.
    let wheel_weight = config.geometry.wheel_weight;
    assert!((wheel_weight - 0.96).abs() < 0.016, "{wheel_weight}");
}
