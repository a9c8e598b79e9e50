//! Bags as people have them: of two robots, of odometry, of joints in messages of their own.

use std::path::PathBuf;

use import::mcap::BagWriter;
use import::message::{encode_joints, encode_odometry, encode_pose};
use import::source::{Choice, Sources};

use crate::odd_logs::{drive, of_one_clock};

/// A bag of two robots, each under a name of its own, with odometry and where it is on a map.
fn two_robots(folder: &std::path::Path) -> PathBuf {
    let mut bag = BagWriter::new(Vec::new()).unwrap();
    let (wheels, poses) = drive();
    for (robot, until) in [("/robot1", 400), ("/robot2", 1000)] {
        let joints =
            bag.channel(&format!("{robot}/joint_states"), "sensor_msgs/msg/JointState", "");
        let measured = bag.channel(&format!("{robot}/pose"), "geometry_msgs/msg/PoseStamped", "");
        let odometry = bag.channel(&format!("{robot}/odom"), "nav_msgs/msg/Odometry", "");
        for k in 0..until {
            let (t_s, [left, right], pose) = (wheels.t_s[k], wheels.turned[k], poses.poses[k]);
            // In another order in each message.
            let mut names = [("wheel_left_joint", left), ("wheel_right_joint", right)];
            if k % 2 == 1 {
                names.reverse();
            }
            bag.message(joints, t_s, &encode_joints(t_s, &names)).unwrap();
            bag.message(measured, t_s, &encode_pose("map", &pose)).unwrap();
            let bytes = encode_odometry(["odom", "base"], &pose, [0.0; 2]);
            bag.message(odometry, t_s, &bytes).unwrap();
        }
    }
    let file = folder.join("two.mcap");
    std::fs::write(&file, bag.finish().unwrap()).unwrap();
    file
}

/// As drivers write it that have a node for each motor.
#[test]
fn each_joint_may_come_in_messages_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let (wheels, poses) = drive();
    let mut bag = BagWriter::new(Vec::new()).unwrap();
    let joints = bag.channel("/joint_states", "sensor_msgs/msg/JointState", "");
    let measured = bag.channel("/pose", "geometry_msgs/msg/PoseStamped", "");
    let again = bag.channel("/odom_pose", "geometry_msgs/msg/PoseStamped", "");
    for k in 1..wheels.t_s.len() {
        let (t_s, later_s) = (wheels.t_s[k], wheels.t_s[k] - 0.01);
        let [left, right] = wheels.turned[k];
        let between = (wheels.turned[k - 1][1] + right) / 2.0;
        for (t_s, joint) in
            [(later_s, ("wheel_right_joint", between)), (t_s, ("wheel_left_joint", left))]
        {
            bag.message(joints, t_s, &encode_joints(t_s, &[joint])).unwrap();
        }
        bag.message(measured, t_s, &encode_pose("map", &poses.poses[k])).unwrap();
        // Odometry that is published again as poses is no measurement, and not asked about.
        bag.message(again, t_s, &encode_pose("odom", &poses.poses[k])).unwrap();
    }
    let file = folder.path().join("alone.mcap");
    std::fs::write(&file, bag.finish().unwrap()).unwrap();
    let chosen = Sources::open(&[file], &[]).unwrap().choose(&Choice::default()).unwrap();
    assert_eq!(chosen.poses.what, "/pose");
    let said: Vec<&str> = chosen.notes.iter().map(|note| note.text.as_str()).collect();
    assert!(said.iter().any(|said| said.contains("in messages of their own")), "{said:?}");
    let [alone, together] = [chosen.wheels, wheels].map(|wheels| of_one_clock(wheels, &poses));
    assert_eq!(alone.runs.len(), together.runs.len());
    for (a, b) in alone.runs.iter().zip(&together.runs) {
        let [a, b] = [a, b].map(|run| run.recording.wheels.last().unwrap().phi_rad);
        assert!((a.right - b.right).abs() < 0.01, "{a:?} {b:?}");
    }
}

#[test]
fn of_two_robots_with_the_same_joints_one_is_chosen_by_its_topic() {
    let folder = tempfile::tempdir().unwrap();
    let sources = Sources::open(&[two_robots(folder.path())], &[]).unwrap();
    let named = |left: &str| Some([left.to_owned(), "wheel_right_joint".to_owned()]);
    let pose = Some("/robot2/pose".to_owned());
    let both =
        Choice { wheels: named("wheel_left_joint"), pose: pose.clone(), ..Choice::default() };
    for choice in [&both, &Choice::default()] {
        let error = sources.choose(choice).unwrap_err().to_string();
        let option = "--wheels /robot2/joint_states:wheel_left_joint,wheel_right_joint";
        assert!(error.contains("more than one thing") && error.contains(option), "{error}");
    }
    let one = named("/robot2/joint_states:wheel_left_joint");
    let chosen = sources.choose(&Choice { wheels: one, pose, ..Choice::default() }).unwrap();
    assert_eq!((chosen.wheels.t_s.len(), chosen.poses.poses.len()), (1000, 1000));
    assert_eq!(chosen.wheels.turned, drive().0.turned[..1000]);
}

#[test]
fn poses_that_may_come_from_the_wheels_are_taken_with_a_warning_and_only_if_they_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let sources = Sources::open(&[two_robots(folder.path())], &[]).unwrap();
    let wheels =
        Some(["/robot1/joint_states:wheel_left_joint", "wheel_right_joint"].map(String::from));
    let of = |pose: &str| Choice {
        pose: Some(pose.into()),
        wheels: wheels.clone(),
        ..Choice::default()
    };
    let warned = |pose: &str| {
        let notes = sources.choose(&of(pose)).unwrap().notes;
        notes
            .iter()
            .any(|note| note.text.contains("they agree with the wheels where these are wrong"))
    };
    assert!(warned("/robot1/odom"));
    assert!(!warned("/robot1/pose"));
}
