//! Trajectories as a ROS 2 bag in MCAP: topics as a robot under ros2_control has them.

use std::io;

use super::Trajectory;
use super::definitions::{
    BATTERY_STATE, DYNAMIC_JOINT_STATE, IMU, JOINT_STATE, ODOMETRY, PATH, POSE_STAMPED,
    VECTOR3_STAMPED,
};
use crate::log::Pose3;
use crate::mcap::{BagWriter, ChannelId};
use crate::message::{
    encode_battery, encode_imu, encode_interface, encode_joints, encode_odometry, encode_path,
    encode_pose, encode_vector,
};

/// What the wheels are called.
const JOINTS: [&str; 2] = ["left_wheel_joint", "right_wheel_joint"];

/// Every topic: its name, its type, its definition.
const TOPICS: [[&str; 3]; 8] = [
    ["/joint_states", "sensor_msgs/msg/JointState", JOINT_STATE],
    ["/measured", "geometry_msgs/msg/PoseStamped", POSE_STAMPED],
    ["/odom", "nav_msgs/msg/Odometry", ODOMETRY],
    ["/dynamic_joint_states", "control_msgs/msg/DynamicJointState", DYNAMIC_JOINT_STATE],
    ["/battery_state", "sensor_msgs/msg/BatteryState", BATTERY_STATE],
    ["/imu", "sensor_msgs/msg/Imu", IMU],
    // A path is no source of poses for an import: it was not measured.
    ["/predicted", "nav_msgs/msg/Path", PATH],
    ["/residual", "geometry_msgs/msg/Vector3Stamped", VECTOR3_STAMPED],
];

/// All runs in one bag; topics of which there is nothing are left out.
pub fn bag(trajectories: &[Trajectory]) -> io::Result<Vec<u8>> {
    let mut bag = BagWriter::new(Vec::new())?;
    let is_there = |of: fn(&Trajectory) -> bool| trajectories.iter().any(of);
    let is_predicted = is_there(|one| one.predicted.iter().any(Option::is_some));
    // Wheels, poses and odometry are what a bag is read for: they are always there.
    let there = [
        true,
        true,
        true,
        is_there(|one| !one.telemetry.duty.is_empty()),
        is_there(|one| !one.telemetry.supply_v.is_empty()),
        is_there(|one| !one.telemetry.yaw_rates.is_empty()),
        is_predicted,
        is_predicted,
    ];
    let mut channels = [None; TOPICS.len()];
    for ((channel, [topic, schema, definition]), is_there) in
        channels.iter_mut().zip(TOPICS).zip(there)
    {
        *channel = is_there.then(|| bag.channel(topic, schema, definition));
    }
    let any_heading = is_there(|one| one.measured.iter().any(|(_, _, heading)| heading.is_some()));
    for one in trajectories {
        let mut messages = messages(one, &channels, any_heading);
        messages.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (t_s, channel, bytes) in messages {
            bag.message(channel, t_s, &bytes)?;
        }
    }
    bag.finish()
}

/// A message: its time \[s\], its channel, its bytes.
type Timed = (f64, ChannelId, Vec<u8>);

fn messages(one: &Trajectory, channels: &[Option<ChannelId>], any_heading: bool) -> Vec<Timed> {
    let mut messages: Vec<Timed> = Vec::new();
    let mut add = |topic: usize, t_s: f64, encode: &dyn Fn(f64) -> Vec<u8>| {
        let t_s = one.started_s + t_s;
        messages.extend(channels[topic].map(|channel| (t_s, channel, encode(t_s))));
    };
    let both = |[left, right]: [f64; 2]| [(JOINTS[0], left), (JOINTS[1], right)];
    let pose = |t_s: f64, [x, y, heading]: [f64; 3]| {
        let (sin, cos) = (heading / 2.0).sin_cos();
        Pose3 { t_s, position_m: [x, y, 0.0], orientation: Some([0.0, 0.0, sin, cos]) }
    };
    for (t_s, turned_rad) in &one.wheels {
        add(0, *t_s, &|t_s| encode_joints(t_s, &both(*turned_rad)));
    }
    for (t_s, [x, y], heading) in &one.measured {
        let unknown = heading.is_none() && any_heading;
        add(1, *t_s, &|t_s| {
            let pose = pose(t_s, [*x, *y, heading.unwrap_or(0.0)]);
            // No rotation at all: readers see that this one was not measured.
            let orientation = if unknown { Some([0.0; 4]) } else { pose.orientation };
            encode_pose("map", &Pose3 { orientation, ..pose })
        });
    }
    for ((t_s, at), speeds) in one.odometry.iter().zip(&one.speeds) {
        add(2, *t_s, &|t_s| encode_odometry(["odom", "base_link"], &pose(t_s, *at), *speeds));
    }
    for (t_s, duty) in &one.telemetry.duty {
        add(3, *t_s, &|t_s| encode_interface(t_s, "duty", &both(*duty)));
    }
    for (t_s, volts) in &one.telemetry.supply_v {
        add(4, *t_s, &|t_s| encode_battery(t_s, *volts));
    }
    for (t_s, rate) in &one.telemetry.yaw_rates {
        add(5, *t_s, &|t_s| encode_imu(t_s, [0.0, 0.0, *rate]));
    }
    let predicted = one.measured.iter().zip(&one.predicted);
    let path: Vec<Pose3> = predicted
        .filter_map(|((t_s, ..), predicted)| Some(pose(one.started_s + t_s, (*predicted)?.1)))
        .collect();
    if !path.is_empty() {
        add(6, 0.0, &|t_s| encode_path(t_s, "map", &path));
    }
    for (t_s, residual) in one.residuals() {
        add(7, t_s, &|t_s| encode_vector(t_s, "predicted", residual));
    }
    messages
}
