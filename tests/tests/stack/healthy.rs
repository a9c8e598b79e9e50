//! Does a healthy robot drive every kind of motion without a fault?

use beeline_tests::robot::{meters, on_robot};
use host_link::motion::Motion;
use shared_proto::{Command, Config, MotionEnd, TravelUnit, Wheel, WheelPair};
use sim_target::Scenario;

/// The motions of an ordinary day, up to the limits of the configuration.
fn motions() -> Vec<(&'static str, Motion)> {
    let limits = Config::default().limits;
    vec![
        ("straight", Motion { distance: WheelPair::both(2.0), acceleration: 0.3, ..Motion::PAPER }),
        ("reverse", Motion { distance: WheelPair::both(-1.0), acceleration: 0.3, ..Motion::PAPER }),
        ("spin", meters(-0.3, 0.3, 0.2, 0.5)),
        ("arc", meters(0.15, 0.4, 0.3, 0.5)),
        ("one wheel", meters(0.0, 0.2, 0.2, 0.5)),
        ("short", meters(0.004, 0.004, 0.1, 0.5)),
        ("crawl", meters(0.01, -0.01, 0.005, 0.05)),
        ("limits", meters(0.9, 0.9, limits.speed_mps_max, limits.acceleration_mps2_max)),
    ]
}

#[test]
fn fifty_drawn_robots_drive_every_kind_of_motion_without_a_fault() {
    for seed in 1000..1050 {
        on_robot(&Scenario::draw(seed), async |robot| {
            for (name, motion) in motions() {
                let before = robot.snapshot();
                let id = robot.cruise(&motion, 0.1).await;
                robot.finish(id).await;
                let status = robot.session.status().await.expect("it answers");
                assert_eq!(status.fault, None, "seed {seed}: {name}");
                assert_eq!(status.motion_end, Some(MotionEnd::Completed), "seed {seed}: {name}");
                let after = robot.snapshot();
                for wheel in Wheel::BOTH {
                    let rolled_m = after.rolled_m.get(wheel) - before.rolled_m.get(wheel);
                    let scale = match motion.unit {
                        TravelUnit::Meter => 1.0,
                        TravelUnit::WheelRevolution => 0.036 * std::f64::consts::TAU,
                    };
                    let told_m = motion.distance.get(wheel) * scale;
                    // Radii are drawn within 1.8 % of the robot's configuration; a few counts of
                    // 0.25 mm are lost to settling and quantisation.
                    let allowed_m = 0.019 * told_m.abs() + 0.001;
                    assert!(
                        (rolled_m - told_m).abs() < allowed_m,
                        "seed {seed}: {name}, {} wheel: {rolled_m} of {told_m} m",
                        wheel.name()
                    );
                }
                robot.tell(Command::Disarm).await;
            }
        });
    }
}
