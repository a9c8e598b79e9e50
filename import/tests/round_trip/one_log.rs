//! A campaign as one long log: the robot stands and is carried between its runs, while everything is recorded on.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

use campaign::{Campaign, Column, Row};
use import::geometry::Geometry;
use import::log::Pose3;
use import::mcap::{BagWriter, ChannelId};
use import::message::{encode_battery, encode_imu, encode_joints, encode_odometry, encode_pose};

/// A campaign as one log, by the clocks of a robot and of a tracker.
pub struct OneLog {
    /// Time \[s\] and counts.
    pub wheels: Vec<(f64, [f64; 2])>,
    /// Poses in the tracker's frame.
    pub poses: Vec<Pose3>,
    /// Of a wheel.
    pub counts_per_rev: f64,
    /// Time \[s\] and rate of a gyro that the campaign has.
    pub yaw_rates: Vec<(f64, f64)>,
    /// The bag has a gyro that sits upside down, and a battery of 12.25 V.
    pub has_gyro_and_battery: bool,
}

/// A message: the recorder's time \[s\], its channel, its bytes.
type Recorded = (f64, ChannelId, Vec<u8>);

/// When the log began \[s\].
const EPOCH_S: f64 = 1_732_473_042.25;
/// Between two runs, where nobody knows better \[s\].
const BETWEEN_S: f64 = 20.0;
/// Between two samples while the robot stands \[s\].
const IDLE_S: f64 = 0.05;

/// How the tracker's axes are turned, and how the marker sits.
const TURNED_RAD: f64 = 0.7;
const MARKER_RAD: f64 = -1.5;

/// The nominal robot of the mystery, and how the radius of its wheels grows with their speed.
const NOMINAL: Geometry = Geometry {
    wheel_radius_m: 0.036,
    radius_multipliers: [1.0; 2],
    wheel_separation_m: 0.372,
    separation_multiplier: 1.0,
};
const GROWTH_S2_PER_M2: f64 = 0.0554;

/// A pose on the floor as the tracker sees it: its axes are turned and elsewhere, and the marker sits turned.
pub fn view(t_s: f64, [x_m, y_m]: [f64; 2], heading_rad: f64) -> Pose3 {
    let (sin, cos) = TURNED_RAD.sin_cos();
    let position_m = [5.0 + cos * x_m - sin * y_m, -2.0 + sin * x_m + cos * y_m, 0.31];
    let (sin, cos) = ((heading_rad + TURNED_RAD + MARKER_RAD) / 2.0).sin_cos();
    Pose3 { t_s, position_m, orientation: Some([0.0, 0.0, sin, cos]) }
}

impl OneLog {
    pub fn of(folder: &Path, late_s: f64) -> Self {
        Self::of_runs(folder, late_s, 0..usize::MAX)
    }

    /// Only some of the runs.
    pub fn of_runs(folder: &Path, late_s: f64, which: Range<usize>) -> Self {
        Self::of_campaign(&Campaign::read(folder).unwrap(), late_s, which)
    }

    /// Only some of the runs of a campaign. Where nobody knows when a run began, it did a while after the one before.
    pub fn of_campaign(campaign: &Campaign, late_s: f64, which: Range<usize>) -> Self {
        let mut log = Self {
            yaw_rates: Vec::new(),
            wheels: Vec::new(),
            poses: Vec::new(),
            counts_per_rev: campaign.robot.counts_per_rev * campaign.robot.gear_reduction,
            has_gyro_and_battery: false,
        };
        let mut counted = [0.0; 2];
        for run in
            campaign.runs.iter().enumerate().filter(|(k, _)| which.contains(k)).map(|(_, run)| run)
        {
            let after = log.wheels.last().map_or(EPOCH_S, |(t_s, _)| t_s + BETWEEN_S);
            let start_s = run.facts.started_s.map_or(after, |started_s| EPOCH_S + started_s);
            let seen = |row: &Row| {
                let position_m = [row.get(Column::X)?, row.get(Column::Y)?];
                let heading_rad = row.get(Column::Heading)?;
                Some(view(start_s + row.t_s + late_s, position_m, heading_rad))
            };
            log.stand_until(start_s, late_s, &run.rows.iter().find_map(seen).unwrap());
            let mut first = None;
            for row in &run.rows {
                let t_s = start_s + row.t_s;
                if let (Some(left), Some(right)) = (row.counts.left, row.counts.right) {
                    let first = *first.get_or_insert([left, right]);
                    let counts = [counted[0] + left - first[0], counted[1] + right - first[1]];
                    log.wheels.push((t_s, counts));
                }
                log.yaw_rates.extend(row.gyro_z_rad_s.map(|rate_rad_s| (t_s, rate_rad_s)));
                log.poses.extend(seen(row));
            }
            counted = log.wheels[log.wheels.len() - 1].1;
        }
        // The tracker began earlier, at no time that anything else has.
        let first = log.poses[0];
        log.poses.insert(0, Pose3 { t_s: first.t_s - 0.0271, ..first });
        log
    }

    /// The robot stands where it is, is carried in the middle of the time, and stands at its next mark.
    fn stand_until(&mut self, until_s: f64, late_s: f64, there: &Pose3) {
        let (Some((from_s, counts)), Some(here)) =
            (self.wheels.last().copied(), self.poses.last().copied())
        else {
            return;
        };
        let steps = ((until_s - from_s) / IDLE_S).floor() as usize;
        for step in 1..steps {
            let t_s = from_s + step as f64 * IDLE_S;
            self.wheels.push((t_s, counts));
            // Of a run whose tracker has a clock of its own, poses may begin before the wheels do, and end after them.
            let seen_s = t_s + late_s;
            if step % 2 == 0 && seen_s > here.t_s && seen_s < there.t_s - 0.2 {
                let seen = if 2 * step < steps { here } else { *there };
                self.poses.push(Pose3 { t_s: seen_s, ..seen });
            }
        }
    }

    /// Somebody pushes the robot backwards by hand, unevenly and not quite straight, for so long.
    pub fn push_backwards(&mut self, late_s: f64, for_s: f64) {
        const STEP_S: f64 = 0.05;
        let (from_s, mut counts) = self.wheels[self.wheels.len() - 1];
        let Pose3 { position_m: [mut x_m, mut y_m, z_m], orientation, .. } =
            self.poses[self.poses.len() - 1];
        let [_, _, z, w] = orientation.unwrap();
        let mut seen_rad = 2.0 * z.atan2(w);
        // It stands for a while, before and after.
        let steps = ((for_s + 8.0) / STEP_S) as usize;
        for step in 1..steps {
            let t_s = from_s + step as f64 * STEP_S;
            let pushed_s = t_s - from_s - 4.0;
            let speeds = match (0.0..for_s).contains(&pushed_s) {
                true => [-0.15 - 0.1 * (2.3 * pushed_s).sin(), 0.3 * (1.1 * pushed_s).sin()],
                false => [0.0; 2],
            };
            let turned_rad = NOMINAL.wheels_turned_rad(STEP_S * speeds[0], STEP_S * speeds[1]);
            counts = [0, 1].map(|side| counts[side] + turned_rad[side] * self.counts_per_rev / TAU);
            let rolled_m = turned_rad.map(|rad| {
                let step_m = rad * NOMINAL.wheel_radius_m;
                step_m * (1.0 + GROWTH_S2_PER_M2 * (step_m / STEP_S).powi(2))
            });
            let turn_rad = (rolled_m[1] - rolled_m[0]) / NOMINAL.wheel_separation_m;
            let (sin, cos) = (seen_rad - MARKER_RAD + turn_rad / 2.0).sin_cos();
            let travel_m = (rolled_m[0] + rolled_m[1]) / 2.0;
            (x_m, y_m) = (x_m + travel_m * cos, y_m + travel_m * sin);
            seen_rad += turn_rad;
            self.wheels.push((t_s, counts));
            if step % 2 == 0 {
                let (sin, cos) = (seen_rad / 2.0).sin_cos();
                let orientation = Some([0.0, 0.0, sin, cos]);
                let position_m = [x_m, y_m, z_m];
                self.poses.push(Pose3 { t_s: t_s + late_s, position_m, orientation });
            }
        }
    }

    /// Adds the poses to these messages, and writes all as a recorder gets them.
    fn finish(
        &self,
        mut bag: BagWriter<Vec<u8>>,
        poses: ChannelId,
        mut messages: Vec<Recorded>,
    ) -> Vec<u8> {
        // Nearly at once by the recorder's clock, whatever the tracker's is.
        let late_s = self.poses[0].t_s - self.wheels[0].0;
        let recorded = |pose: &Pose3| (pose.t_s - late_s + 0.2, poses, encode_pose("mocap", pose));
        messages.extend(self.poses.iter().map(recorded));
        messages.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (t_s, channel, bytes) in messages {
            bag.message(channel, t_s, &bytes).unwrap();
        }
        bag.finish().unwrap()
    }

    /// As a ROS 2 bag without joints: odometry by these numbers, and poses.
    pub fn odometry_bag(&self, geometry: &Geometry) -> Vec<u8> {
        let mut bag = BagWriter::new(Vec::new()).unwrap();
        let odometry = bag.channel("/odom", "nav_msgs/msg/Odometry", "");
        let poses = bag.channel("/tracker/pose", "geometry_msgs/msg/PoseStamped", "");
        let ([left_m, right_m], rad) = (geometry.radii_m(), TAU / self.counts_per_rev);
        let ([mut x_m, mut y_m], mut heading_rad) = ([1.0, 2.0], 0.3_f64);
        let mut before = self.wheels[0];
        let mut messages: Vec<Recorded> = Vec::new();
        for (t_s, counts) in &self.wheels {
            let rolled_m = [left_m, right_m];
            let rolled_m =
                [0, 1].map(|side| rolled_m[side] * rad * (counts[side] - before.1[side]));
            let travel_m = (rolled_m[0] + rolled_m[1]) / 2.0;
            let turn_rad = (rolled_m[1] - rolled_m[0]) / geometry.track_width_m();
            let (sin, cos) = (heading_rad + turn_rad / 2.0).sin_cos();
            (x_m, y_m) = (x_m + travel_m * cos, y_m + travel_m * sin);
            heading_rad += turn_rad;
            let dt_s = (t_s - before.0).max(1e-3);
            before = (*t_s, *counts);
            let (sin, cos) = (heading_rad / 2.0).sin_cos();
            let orientation = Some([0.0, 0.0, sin, cos]);
            let pose = Pose3 { t_s: *t_s, position_m: [x_m, y_m, 0.0], orientation };
            let speeds = [travel_m / dt_s, turn_rad / dt_s];
            messages.push((*t_s, odometry, encode_odometry(["odom", "base"], &pose, speeds)));
        }
        self.finish(bag, poses, messages)
    }

    /// As a ROS 2 bag: angles of joints in radians, poses, and something else.
    pub fn bag(&self) -> Vec<u8> {
        let mut bag = BagWriter::new(Vec::new()).unwrap();
        let joints = bag.channel("/joint_states", "sensor_msgs/msg/JointState", "");
        let poses = bag.channel("/tracker/pose", "geometry_msgs/msg/PoseStamped", "");
        let other = bag.channel("/rosout", "rcl_interfaces/msg/Log", "");
        bag.message(other, EPOCH_S, b"hello").unwrap();
        let rad = TAU / self.counts_per_rev;
        let mut messages: Vec<Recorded> = Vec::new();
        for (t_s, [left, right]) in &self.wheels {
            let joint = [
                ("wheel_left_joint", left * rad),
                ("camera_pan", 0.1),
                ("wheel_right_joint", right * rad),
            ];
            // Received some time after it was measured.
            messages.push((t_s + 0.013, joints, encode_joints(*t_s, &joint)));
        }
        if !self.yaw_rates.is_empty() {
            let imu = bag.channel("/imu", "sensor_msgs/msg/Imu", "");
            let message =
                |(t_s, rate): &(f64, f64)| (*t_s, imu, encode_imu(*t_s, [0.0, 0.0, *rate]));
            messages.extend(self.yaw_rates.iter().map(message));
        }
        if self.has_gyro_and_battery {
            let imu = bag.channel("/imu", "sensor_msgs/msg/Imu", "");
            let battery = bag.channel("/battery", "sensor_msgs/msg/BatteryState", "");
            for pair in self.wheels.windows(2) {
                let ((from_s, from), (t_s, to)) = (pair[0], pair[1]);
                let turned_rad = [0, 1].map(|side| rad * (to[side] - from[side]));
                let rolled_m = NOMINAL.wheel_radius_m * (turned_rad[1] - turned_rad[0]);
                let rate_rad_s = rolled_m / NOMINAL.wheel_separation_m / (t_s - from_s);
                let middle_s = (t_s + from_s) / 2.0;
                messages.push((t_s, imu, encode_imu(middle_s, [0.1, 0.0, -rate_rad_s])));
                messages.push((t_s, battery, encode_battery(t_s, 12.25)));
            }
        }
        self.finish(bag, poses, messages)
    }

    /// As a data log of WPILib, on a clock of its own: angles of wheels, each logged when it changes, and poses as structs.
    pub fn wpilog(&self) -> Vec<u8> {
        let mut bytes = b"WPILOG\x00\x01\x05\x00\x00\x00extra".to_vec();
        let mut record = |entry: u32, t_s: f64, payload: &[u8]| {
            let t_us = ((t_s - self.wheels[0].0) * 1e6).round().max(0.0) as u64;
            // One byte for the entry, two for the size, five for the time.
            bytes.push(4 | 4 << 4);
            bytes.push(entry as u8);
            bytes.extend_from_slice(&(payload.len() as u16).to_le_bytes());
            bytes.extend_from_slice(&t_us.to_le_bytes()[..5]);
            bytes.extend_from_slice(payload);
        };
        let entries = [
            ("NT:/drive/left_rad", "double"),
            ("NT:/drive/right_rad", "double"),
            ("/vision/pose", "struct:Pose2d"),
            ("messages", "string"),
        ];
        for (entry, (name, kind)) in (1_u32..).zip(entries) {
            let mut start = vec![0];
            start.extend_from_slice(&entry.to_le_bytes());
            for text in [name, kind, "{}"] {
                start.extend_from_slice(&(text.len() as u32).to_le_bytes());
                start.extend_from_slice(text.as_bytes());
            }
            // By the clock of the day, as WPILib does it before it has set its own.
            record(0, self.wheels[0].0 + 1e6, &start);
        }
        record(4, self.wheels[0].0, b"hello");
        // Records come in the order of time.
        let mut all: Vec<(f64, u32, Vec<u8>)> = Vec::new();
        let rad = TAU / self.counts_per_rev;
        let mut logged = [f64::NAN; 2];
        for (t_s, counts) in &self.wheels {
            for side in 0..2 {
                if counts[side] != logged[side] {
                    logged[side] = counts[side];
                    // A program takes a little from one to the next.
                    let at_s = t_s + 4e-4 * side as f64;
                    all.push((at_s, side as u32 + 1, (counts[side] * rad).to_le_bytes().to_vec()));
                }
            }
        }
        for Pose3 { t_s, position_m: [x, y, _], orientation } in &self.poses {
            let [_, _, z, w] = orientation.unwrap();
            let pose = [*x, *y, 2.0 * z.atan2(w)].map(f64::to_le_bytes).concat();
            all.push((*t_s, 3, pose));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.iter().for_each(|(t_s, entry, payload)| record(*entry, *t_s, payload));
        bytes
    }

    /// The wheels as a table in nanoseconds.
    pub fn table(&self) -> String {
        let mut text = "stamp,battery,enc_l,enc_r\n".to_owned();
        for (t_s, [left, right]) in &self.wheels {
            let nanoseconds = ((t_s - EPOCH_S) * 1e9).round() as i64 + (EPOCH_S * 1e9) as i64;
            let _ = writeln!(text, "{nanoseconds},12.1,{left},{right}");
        }
        text
    }

    /// The poses as a TUM trajectory.
    pub fn trajectory(&self) -> String {
        let mut text = "# timestamp tx ty tz qx qy qz qw\n".to_owned();
        for Pose3 { t_s, position_m: [x, y, z], orientation } in &self.poses {
            let [qx, qy, qz, qw] = orientation.unwrap();
            let _ = writeln!(text, "{t_s:.6} {x:.7} {y:.7} {z} {qx} {qy} {qz:.9} {qw:.9}");
        }
        text
    }
}
