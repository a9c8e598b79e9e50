//! The pose in the telemetry is where a robot without defects really is.

use beeline_tests::robot::{Robot, meters, on_robot};
use host_link::Motion;
use shared_proto::{Command, Pose};
use sim_target::Scenario;

/// A robot whose wheels and track are as configured, on a line that loses nothing.
fn sound() -> Scenario {
    let mut scenario = Scenario::default();
    let config = shared_proto::Config::default();
    scenario.plant.geometry.wheel_radius_m =
        shared_proto::WheelPair::both(config.geometry.wheel_radius_m);
    scenario.plant.geometry.track_width_m = config.geometry.track_width_m;
    scenario
}

async fn driven(robot: &mut Robot, motion: &Motion) {
    let id = robot.cruise(motion, 0.5).await;
    robot.finish(id).await;
    robot.listen(0.3).await;
}

async fn pose(robot: &mut Robot) -> Pose {
    robot.tell(Command::Subscribe { period_ms: 20 }).await;
    robot.listen(0.1).await;
    let pose = robot.session.take_telemetry().last().expect("telemetry").pose;
    robot.tell(Command::Subscribe { period_ms: 0 }).await;
    pose
}

#[test]
fn the_pose_follows_the_robot_whether_or_not_anybody_listens() {
    on_robot(&sound(), async |robot| {
        let start = robot.snapshot().pose;
        let turn_m = 0.5 * 0.372 * std::f64::consts::FRAC_PI_2;
        for motion in [
            meters(1.0, 1.0, 0.3, 0.5),
            meters(-turn_m, turn_m, 0.2, 0.5),
            meters(0.8, 1.4, 0.3, 0.5),
            meters(-0.5, -0.5, 0.3, 0.5),
            meters(1.2, 0.3, 0.3, 0.5),
        ] {
            driven(robot, &motion).await;
            let truth = robot.snapshot().pose.relative_to(start);
            let Pose { x_um, y_um, heading_urad } = pose(robot).await;
            let (x_m, y_m) = (x_um as f64 * 1e-6, y_um as f64 * 1e-6);
            let heading_rad = heading_urad as f64 * 1e-6;
            let off_m = (x_m - truth.x_m).hypot(y_m - truth.y_m);
            let turned = (heading_rad - truth.heading_rad).rem_euclid(std::f64::consts::TAU);
            let off_rad = turned.min(std::f64::consts::TAU - turned);
            println!("{motion:?}: {:.2} mm, {:.2} mrad off", off_m * 1e3, off_rad * 1e3);
            // A count is 0.25 mm: one of each wheel, at power-on and now, are 2.7 mrad, and over two metres 5 mm.
            assert!(off_m < 0.005 && off_rad < 0.0027, "{motion:?}: {off_m} m, {off_rad} rad");
        }
    });
}

#[test]
fn another_configuration_and_a_save_leave_the_pose_where_it_is() {
    on_robot(&sound(), async |robot| {
        driven(robot, &meters(0.5, 0.9, 0.3, 0.5)).await;
        let before = pose(robot).await;
        assert!(before.x_um > 300_000, "{before:?}");
        let mut config = robot.session.read_config().await.expect("it answers");
        config.geometry.wheel_weight = 0.97;
        config.geometry.wheel_radius_m = 0.04;
        robot.tell(Command::Disarm).await;
        robot.session.write_config(&config).await.expect("valid");
        assert_eq!(pose(robot).await, before);
    });
}
