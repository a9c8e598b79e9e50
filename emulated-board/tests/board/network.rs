//! The emulated board as a program of its own, and `beeline` on it.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use beeline_tests::tuning::robots::constants;
use host_cli::calibrate::{Decision, Settings, calibrate};
use host_cli::port::{Port, SimOptions, with_robot};
use host_cli::pose_source::Sigma;
use host_cli::pose_source::track_file::TrackFile;
use host_cli::tune::{self, DriveOutcome, tune};
use host_link::address::Address;
use host_link::motion::Motion;
use shared_proto::{ConfigOrigin, WheelPair};
use sim_target::Scenario;

use super::image;

/// The program, ended however the test ends.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Program {
    /// Listens on a free port of this machine, in this folder; says which.
    fn listen(folder: &Path, scenario: &str, more: &[&str]) -> (Self, Port, impl Sized) {
        std::fs::create_dir_all(folder).unwrap();
        std::fs::write(folder.join("scenario.toml"), scenario).unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_emulate"))
            .args(["--listen", "127.0.0.1:0", "--scenario", "scenario.toml"])
            .args(more)
            .env("BEELINE_IMAGE", image())
            .current_dir(folder)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        // Held open: the program goes on writing to it.
        let mut output = BufReader::new(child.stdout.take().unwrap());
        output.read_line(&mut line).unwrap();
        let address =
            line.trim().rsplit("tcp:").next().expect("it says where it listens").to_string();
        (Self(child), Port::At(Address::Tcp(address)), output)
    }
}

/// Wheels so unequal that one revolution shows it.
const SCENARIO: &str = include_str!("../../../tests/uneven.toml");

#[test]
fn a_host_calibrates_the_emulated_board_over_tcp() {
    let folder = std::env::temp_dir().join(format!("beeline-emulated-{}", std::process::id()));
    let (_program, port, output) = Program::listen(&folder, SCENARIO, &["--camera", "track.csv"]);
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

/// The paper's robot with motors that nobody told it of: weaker, and with more friction.
const UNTUNED: &str = "\
name = \"untuned\"
[plant.motor.left]
resistance_ohm = 9.0
coulomb_torque_nm = 0.09
[plant.motor.right]
resistance_ohm = 9.0
coulomb_torque_nm = 0.09
";

#[test]
fn a_host_tunes_the_emulated_board_over_tcp() {
    let folder = std::env::temp_dir().join(format!("beeline-untuned-{}", std::process::id()));
    let (_program, port, output) = Program::listen(&folder, UNTUNED, &[]);
    let settings = tune::Settings {
        floor_m: 1.5,
        wheels_up: false,
        stiffness: 1.0,
        record: false,
        undo_folder: None,
    };
    let tuned = |port: &Port| {
        with_robot(port, &SimOptions::default(), async |session, _| {
            let tuned = tune(session, &settings, &mut |_| {}).await?;
            Ok((tuned, session.read_config().await?))
        })
        .unwrap()
    };
    let scenario = Scenario::load(&folder.join("scenario.toml")).unwrap();
    let (emulated, config) = tuned(&port);
    let simulated = tuned(&Port::Sim(Some(folder.join("scenario.toml")))).0;
    drop(output);
    let _ = std::fs::remove_dir_all(&folder);

    // Both against the plant's own parts. From one tuning over TCP to the next kA differs by 1 %: the motions do not begin at the
    // same noise.
    let expected = constants(&scenario.plant);
    for tuned in [&emulated, &simulated] {
        let value = &tuned.fit.constants.value;
        let left = value.wheels.left;
        let found = [left.ks_forward_v, left.kv_v_s_per_m, value.ka_of_robot(&left).0];
        println!("kS, kV, kA: {found:?}, of {expected:?}; {} m rms", tuned.after.rms_m);
        for ((found, expected), share) in found.into_iter().zip(expected).zip([0.02, 0.01, 0.05]) {
            assert!((found / expected - 1.0).abs() < share, "{found} {expected}");
        }
        // A count of 0.25 mm: twice what it hides.
        assert!(tuned.after.rms_m < 1.45e-4, "{} m", tuned.after.rms_m);
    }
    let DriveOutcome::Followed(before) = emulated.before else { panic!("{:?}", emulated.before) };
    assert!(emulated.after.rms_m < 0.5 * before.rms_m, "{before:?} {:?}", emulated.after);
    assert_eq!(config.feedforward, emulated.change.1.feedforward);
}
