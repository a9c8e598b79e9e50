//! What is exported says of a robot what is true of it, and other programs can do with it what they would.

use std::path::Path;

use campaign::RobotFile;
use campaign::model::ModelFile;
use import::bag::{PosePlace, inventory, poses, wheels};
use import::export::{Controller, Target, Telemetry, Trajectory, bag, table};
use import::geometry::Geometry;
use import::source::{Choice, Sources};
use import::text;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use robot_model::kinematics::WheelPair;
use robot_model::recording::{Campaign, PoseMeasurement, Recording, WheelSample};

/// What the robot is, and its data sheet does not say: both radii and the track width \[m\].
const RADII_M: [f64; 2] = [0.0363, 0.0357];
const TRACK_M: f64 = 0.380;
const SEED: u64 = 4;

fn nominal() -> RobotFile {
    RobotFile::parse(
        Path::new("robot.toml"),
        "name = \"a robot\"\nwheel_radius_m = 0.036\ntrack_width_m = 0.372\ncounts_per_rev = 900\n",
    )
    .unwrap()
}

/// Out and back, spins, arcs: speeds of both wheels \[rad/s\], for ten seconds. The last two are held out.
fn campaign() -> Campaign {
    campaign_with(|_| 1.0)
}

/// The same, with a share of the speed at each sample.
fn campaign_with(share: impl Fn(i32) -> f64) -> Campaign {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let speeds =
        [[6.0, 6.0], [-5.0, 5.0], [5.0, -5.0], [3.0, 6.0], [6.0, 3.0], [4.0, 4.0], [5.0, 2.0]];
    let runs = speeds.into_iter().enumerate().map(|(number, speeds)| {
        let (mut phi, mut pose) = ([0.0; 2], [0.0_f64; 3]);
        let mut run = Recording {
            name: format!("run_{number}"),
            started_s: Some(100.0 * number as f64),
            held_out: number >= 5,
            ..Recording::default()
        };
        for k in 0..200 {
            let t_s = f64::from(k) * 0.05;
            run.wheels.push(WheelSample { t_s, phi_rad: WheelPair::new(phi[0], phi[1]) });
            let mut noise =
                |size: f64| size * (rng.random_range(-1.0..1.0) + rng.random_range(-1.0..1.0));
            run.measured_poses.push(PoseMeasurement {
                t_s,
                position_m: Some([pose[0] + noise(1e-3), pose[1] + noise(1e-3)]),
                heading_rad: Some(pose[2] + noise(2e-3)),
            });
            // Spins and the runs held out go on; all else comes back, half as fast.
            let goes_on = k < 100 || speeds[0] == -speeds[1] || run.held_out;
            let back = if goes_on { 1.0 } else { -0.5 };
            let turned = speeds.map(|speed| 0.05 * speed * back * share(k));
            let rolled = [RADII_M[0] * turned[0], RADII_M[1] * turned[1]];
            let (travel, turn) = ((rolled[0] + rolled[1]) / 2.0, (rolled[1] - rolled[0]) / TRACK_M);
            let (sin, cos) = (pose[2] + turn / 2.0).sin_cos();
            pose = [pose[0] + travel * cos, pose[1] + travel * sin, pose[2] + turn];
            phi = [phi[0] + turned[0], phi[1] + turned[1]];
        }
        run
    });
    Campaign { robot: nominal().to_model(), runs: runs.collect() }
}

/// How far the odometry ends from the last measured pose, in the mean over these runs \[m\].
fn off_m(trajectories: &[Trajectory]) -> f64 {
    let off = trajectories.iter().map(|one| {
        let (_, [x, y, _]) = one.odometry[one.odometry.len() - 1];
        let (_, [measured_x, measured_y], _) = one.measured[one.measured.len() - 1];
        (x - measured_x).hypot(y - measured_y)
    });
    off.sum::<f64>() / trajectories.len() as f64
}

#[test]
fn a_controller_gets_the_radii_and_the_track_width_that_the_robot_has() {
    let campaign = campaign();
    let controller = Controller::of(
        Path::new("a"),
        &nominal(),
        &campaign,
        &ModelFile::default(),
        Target::DiffDrive,
    )
    .unwrap();
    for (found, is) in controller.geometry.radii_m().into_iter().zip(RADII_M) {
        assert!((found / is - 1.0).abs() < 1e-3, "{controller:?}");
    }
    assert!((controller.geometry.track_width_m() / TRACK_M - 1.0).abs() < 2e-3, "{controller:?}");
    assert_eq!(controller.cost, None);
    // On the runs that nothing was fitted to.
    let held_out = |radii_m, track_m| off_m(&Trajectory::all(&campaign, radii_m, track_m)[5..]);
    let before_m = held_out([0.036; 2], 0.372);
    let after_m = held_out(controller.geometry.radii_m(), controller.geometry.track_width_m());
    assert!(before_m > 0.02 && after_m < 0.005, "{before_m} {after_m}");
    let robot = RobotFile { name: "a robot\nwheel_radius: 7".into(), ..nominal() };
    let yaml = controller.file(&robot);
    for line in [
        "    wheel_separation: 0.372000",
        "    wheel_radius: 0.036000",
        "diff_drive_controller:",
        "  ros__parameters:",
    ] {
        assert!(yaml.lines().any(|own| own == line), "{line}: {yaml}");
    }
    for key in [
        "wheel_separation_multiplier",
        "left_wheel_radius_multiplier",
        "right_wheel_radius_multiplier",
        "pose_covariance_diagonal",
        "twist_covariance_diagonal",
    ] {
        assert_eq!(yaml.matches(key).count(), 1, "{key}: {yaml}");
    }
    let radii = yaml.lines().filter(|line| line.trim_start().starts_with("wheel_radius:"));
    assert_eq!(radii.count(), 1, "a name cannot add a parameter: {yaml}");
}

/// Where a marker sits, and how late a pose comes, are no errors of the odometry.
#[test]
fn a_marker_off_the_middle_and_a_late_camera_change_no_parameter_and_no_covariance() {
    const LATE_S: f64 = 0.06;
    const MARKER_M: [f64; 2] = [0.08, -0.03];
    // From standstill to standstill: else nothing shows a delay.
    let share = |k: i32| f64::from((k % 100).min(100 - k % 100) - 5).clamp(0.0, 20.0) / 20.0;
    let plain = campaign_with(share);
    let mut campaign = plain.clone();
    for run in &mut campaign.runs {
        for pose in &mut run.measured_poses {
            let (sin, cos) = pose.heading_rad.unwrap().sin_cos();
            pose.position_m = pose.position_m.map(|[x, y]| {
                let [ahead, left] = MARKER_M;
                [x + ahead * cos - left * sin, y + ahead * sin + left * cos]
            });
            pose.t_s += LATE_S;
        }
    }
    let of = |campaign: &Campaign| {
        let model = ModelFile::default();
        Controller::of(Path::new("a"), &nominal(), campaign, &model, Target::DiffDrive).unwrap()
    };
    let (plain, found) = (of(&plain), of(&campaign));
    for (found, is) in found.geometry.radii_m().into_iter().zip(RADII_M) {
        assert!((found / is - 1.0).abs() < 1e-3, "{found} {is}");
    }
    for (a, b) in [
        (found.pose_variances, plain.pose_variances),
        (found.twist_variances, plain.twist_variances),
    ] {
        for (a, b) in a.into_iter().zip(b) {
            assert!(a < 2.0 * b.max(1e-9), "{found:?} {plain:?}");
        }
    }
    assert_eq!(found.cost, None);
}

/// The number after a name in a file, whatever stands between.
fn number_after(file: &str, name: &str) -> f64 {
    let line =
        file.lines().find(|line| line.contains(name)).unwrap_or_else(|| panic!("{name}: {file}"));
    let rest = line.split(name).nth(1).unwrap();
    rest.trim_matches(|c: char| !c.is_ascii_digit()).parse().unwrap()
}

#[test]
fn a_program_that_has_one_radius_gets_the_mean_and_is_told_what_that_costs() {
    let campaign = campaign();
    let of = |target| {
        Controller::of(Path::new("a"), &nominal(), &campaign, &ModelFile::default(), target)
            .unwrap()
    };
    let controller = of(Target::TurtleBot3);
    let yaml = controller.file(&nominal());
    let radius_m = number_after(&yaml, " radius:");
    assert!((radius_m / (RADII_M[0] + RADII_M[1]) * 2.0 - 1.0).abs() < 2e-3, "{yaml}");
    assert!((number_after(&yaml, " separation:") / TRACK_M - 1.0).abs() < 0.02, "{yaml}");
    assert!(yaml.contains("turtlebot3_node:\n  ros__parameters:\n    wheels:\n"), "{yaml}");
    // What it cannot say is what it is wrong by: radii that differ by 1.7 %.
    let cost = controller.cost.unwrap();
    assert_eq!(cost.effects, ["unequal wheel radii"]);
    let [own_m, whole_m] = cost.position_m;
    assert!(own_m > 1.4 * whole_m && whole_m < 2e-3, "{own_m} {whole_m}");
    let held_out = |geometry: &Geometry| {
        off_m(&Trajectory::all(&campaign, geometry.radii_m(), geometry.track_width_m())[5..])
    };
    let (one, both) = (held_out(&controller.geometry), held_out(&of(Target::DiffDrive).geometry));
    assert!(one > both + 0.005, "{one} {both}");
}

/// linorobot2 computes v = rpm pi D, and rpm = counts / COUNTS_PER_REV; its own arithmetic gives the radii back.
#[test]
fn whole_counts_of_each_wheel_are_as_good_as_its_encoders_have_lines() {
    let campaign = campaign();
    for counts in [900.0, 36_000.0] {
        let robot = RobotFile { counts_per_rev: counts, ..nominal() };
        let controller = Controller::of(
            Path::new("a"),
            &robot,
            &campaign,
            &ModelFile::default(),
            Target::Linorobot2,
        )
        .unwrap();
        let header = controller.file(&robot);
        let diameter_m = number_after(&header, "#define WHEEL_DIAMETER");
        for (side, name) in
            ["#define COUNTS_PER_REV1", "#define COUNTS_PER_REV2"].into_iter().enumerate()
        {
            let own = number_after(&header, name);
            assert_eq!(own, own.round());
            let radius_m = diameter_m / 2.0 * counts / own;
            let off = radius_m / RADII_M[side] - 1.0;
            assert!(off.abs() < 0.5 / counts + 3e-4, "{counts}, {side}: {off}");
            assert!((radius_m / controller.geometry.radii_m()[side] - 1.0).abs() < 1e-5);
        }
        assert!((number_after(&header, "LR_WHEELS_DISTANCE") / TRACK_M - 1.0).abs() < 2e-3);
        let cost = controller.cost.unwrap();
        assert_eq!(cost.effects, ["fractions of a count"]);
        let costs_m = cost.position_m[0] - cost.position_m[1];
        assert!(costs_m.abs() < 0.5 / counts, "{costs_m}");
    }
}

#[test]
fn wpilib_gets_the_distance_of_a_pulse_which_is_four_counts() {
    let campaign = campaign();
    let of = |robot: &RobotFile| {
        let model = ModelFile::default();
        let controller =
            Controller::of(Path::new("a"), robot, &campaign, &model, Target::Wpilib).unwrap();
        assert_eq!(controller.cost, None);
        controller.file(robot)
    };
    let robot = RobotFile { gear_reduction: 2.0, ..nominal() };
    let java = of(&robot);
    for (side, radius_m) in ["Left", "Right"].into_iter().zip(RADII_M) {
        let per_pulse_m = number_after(&java, &format!("k{side}EncoderDistancePerPulse"));
        // 225 pulses a turn of the encoder, two of which make one of the wheel.
        let radius = per_pulse_m * 450.0 / std::f64::consts::TAU;
        assert!((radius / radius_m - 1.0).abs() < 1e-3, "{java}");
    }
    // From angles: nobody knows the counts.
    let java = of(&RobotFile { counts_per_rev: std::f64::consts::TAU, ..nominal() });
    let turn_m = number_after(&java, "kLeftMetersPerWheelTurn");
    assert!((turn_m / RADII_M[0] / std::f64::consts::TAU - 1.0).abs() < 1e-3, "{java}");
    assert!(!java.contains("DistancePerPulse ="), "{java}");
}

#[test]
fn trajectories_tables_and_bags_are_read_again() {
    let campaign = campaign();
    let trajectories = Trajectory::all(&campaign, RADII_M, TRACK_M);
    let read =
        text::parse(Path::new("a.tum"), trajectories[1].measured_tum().as_bytes(), &[]).unwrap();
    let track = read.poses.unwrap().poses;
    assert_eq!(track.len(), 200);
    assert!((track[199].t_s - 109.95).abs() < 1e-6);
    // One table holds all runs, so only its first one is looked at.
    let rows = table(&trajectories[..1]);
    let read = text::parse(Path::new("a.csv"), rows.as_bytes(), &[]).unwrap();
    assert_eq!(read.wheels.unwrap().t_s.len(), 200);
    assert_eq!(read.poses.unwrap().poses.len(), 200);
    let mut trajectories = trajectories;
    // A heading that one pose lacks is not read as 0.
    trajectories[1].measured[5].2 = None;
    trajectories[1].telemetry = Telemetry {
        duty: vec![(0.5, [0.25, -0.75])],
        supply_v: vec![(0.5, 11.5), (1.0, 11.25)],
        yaw_rates: vec![(0.5, -0.125)],
    };
    let file = tempfile::Builder::new().suffix(".mcap").tempfile().unwrap();
    std::fs::write(file.path(), bag(&trajectories).unwrap()).unwrap();
    let found = inventory(file.path()).unwrap();
    assert!(found.notes.is_empty(), "{:?}", found.notes);
    let (log, _) =
        wheels(&[file.path()], "/joint_states", ["left_wheel_joint", "right_wheel_joint"]).unwrap();
    assert_eq!(log.t_s.len(), 1400);
    for topic in ["/measured", "/odom"] {
        let (log, _) = poses(&[file.path()], &PosePlace::Topic(topic.into())).unwrap();
        assert_eq!(log.poses.len(), 1400, "{topic}");
        let unknown = log.poses.iter().filter(|pose| pose.orientation == Some([0.0; 4]));
        assert_eq!(unknown.count(), usize::from(topic == "/measured"));
    }
    let counted = |topic: &str| found.topics[topic].messages;
    assert_eq!(["/dynamic_joint_states", "/battery_state", "/imu"].map(counted), [1, 2, 1]);
    let sources = Sources::open(&[file.path().into()], &[]).unwrap();
    let gyro_and_supply = sources.choose(&Choice::default()).unwrap().wheels.gyro_and_supply;
    let at_s = trajectories[1].started_s + 0.5;
    assert_eq!(gyro_and_supply.turn_rates, [(at_s, [0.0, 0.0, -0.125])]);
    assert_eq!(gyro_and_supply.supply_v, [(at_s, 11.5), (at_s + 0.5, 11.25)]);
}
