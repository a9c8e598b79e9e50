//! The ROS 2 messages that are read: what each has to say about a robot's wheels and its pose.
//!
//! | type | gives |
//! | --- | --- |
//! | `sensor_msgs/msg/JointState` | angles of joints, or their speeds |
//! | `nav_msgs/msg/Odometry` | a pose, and how fast it changes |
//! | `geometry_msgs/msg/PoseStamped`, `PoseWithCovarianceStamped`, `TransformStamped` | a pose |
//! | `sensor_msgs/msg/Imu` | rates of a gyro |
//! | `sensor_msgs/msg/BatteryState` | a voltage |
//! | `tf2_msgs/msg/TFMessage` | poses, each of a child frame in its parent |

use crate::cdr::{CdrError, CdrReader, CdrWriter};
use crate::log::Pose3;

/// A type of message that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageType {
    /// Joints.
    JointState,
    /// A pose by odometry.
    Odometry,
    /// A pose.
    PoseStamped,
    /// A pose with its covariance, which is not used.
    PoseWithCovarianceStamped,
    /// A pose of one frame in another.
    TransformStamped,
    /// Any number of them.
    TFMessage,
    /// A gyro; accelerations and orientation are not used.
    Imu,
    /// A battery.
    BatteryState,
}

impl MessageType {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::JointState,
        Self::Odometry,
        Self::PoseStamped,
        Self::PoseWithCovarianceStamped,
        Self::TransformStamped,
        Self::TFMessage,
        Self::Imu,
        Self::BatteryState,
    ];

    /// Its name, as a bag has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::JointState => "sensor_msgs/msg/JointState",
            Self::Odometry => "nav_msgs/msg/Odometry",
            Self::PoseStamped => "geometry_msgs/msg/PoseStamped",
            Self::PoseWithCovarianceStamped => "geometry_msgs/msg/PoseWithCovarianceStamped",
            Self::TransformStamped => "geometry_msgs/msg/TransformStamped",
            Self::TFMessage => "tf2_msgs/msg/TFMessage",
            Self::Imu => "sensor_msgs/msg/Imu",
            Self::BatteryState => "sensor_msgs/msg/BatteryState",
        }
    }

    /// The type of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|known| known.name() == name)
    }
}

/// The time of a header \[s\], and its frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Header<'a> {
    /// Zero if nobody set it.
    pub stamp_s: f64,
    /// The frame.
    pub frame: &'a str,
}

/// Joints at one time. Positions and speeds may be empty.
#[derive(Clone, Debug, PartialEq)]
pub struct JointState<'a> {
    /// When.
    pub header: Header<'a>,
    /// Their names.
    pub names: Vec<&'a str>,
    /// Their angles \[rad\].
    pub positions_rad: Vec<f64>,
    /// Their speeds \[rad/s\].
    pub speeds_rad_s: Vec<f64>,
}

/// A pose of a child frame in its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct FramedPose<'a> {
    /// The parent; empty if the message does not say.
    pub parent: &'a str,
    /// The child; empty if the message does not say.
    pub child: &'a str,
    /// The pose.
    pub pose: Pose3,
    /// How fast the child goes forwards, and turns to the left, if the message says \[m/s, rad/s\].
    pub speeds: Option<[f64; 2]>,
}

/// What a message says.
#[derive(Clone, Debug, PartialEq)]
pub enum Message<'a> {
    /// Joints.
    Joints(JointState<'a>),
    /// Poses.
    Poses(Vec<FramedPose<'a>>),
    /// Rates about the axes of a gyro.
    TurnRates {
        /// When \[s\].
        stamp: f64,
        /// About x, y and z \[rad/s\].
        rad_s: [f64; 3],
    },
    /// The voltage of a battery.
    Supply {
        /// When \[s\].
        stamp: f64,
        /// \[V\]
        volts: f64,
    },
}

/// The bytes of the shortest transform in a sequence: a stamp, two empty strings, seven numbers.
const TRANSFORM_BYTES_MIN: usize = 64;
/// The numbers of a covariance.
const COVARIANCE: usize = 36;

impl<'a> Message<'a> {
    /// Decodes a message.
    pub fn decode(kind: MessageType, bytes: &'a [u8]) -> Result<Self, CdrError> {
        let mut cdr = CdrReader::new(bytes)?;
        if kind == MessageType::TFMessage {
            let count = cdr.length(TRANSFORM_BYTES_MIN)?;
            let transforms = (0..count).map(|_| transform(&mut cdr));
            return transforms.collect::<Result<_, _>>().map(Message::Poses);
        }
        if kind == MessageType::TransformStamped {
            return Ok(Message::Poses(vec![transform(&mut cdr)?]));
        }
        let header = header(&mut cdr)?;
        if kind == MessageType::JointState {
            return joints(header, &mut cdr).map(Message::Joints);
        }
        if kind == MessageType::Imu {
            // An orientation and its covariance.
            cdr.f64s::<13>()?;
            return Ok(Message::TurnRates { stamp: header.stamp_s, rad_s: cdr.f64s()? });
        }
        if kind == MessageType::BatteryState {
            let volts = f64::from(cdr.f32()?);
            return Ok(Message::Supply { stamp: header.stamp_s, volts });
        }
        let child = if kind == MessageType::Odometry { cdr.string()? } else { "" };
        let pose = pose(header.stamp_s, &mut cdr)?;
        let speeds = match kind {
            MessageType::Odometry => Some(speeds(&mut cdr)?),
            _ => None,
        };
        Ok(Message::Poses(vec![FramedPose { parent: header.frame, child, pose, speeds }]))
    }
}

fn header<'a>(cdr: &mut CdrReader<'a>) -> Result<Header<'a>, CdrError> {
    let (seconds, nanoseconds) = (cdr.i32()?, cdr.u32()?);
    let stamp_s = f64::from(seconds) + f64::from(nanoseconds) * 1e-9;
    Ok(Header { stamp_s, frame: cdr.string()? })
}

fn joints<'a>(header: Header<'a>, cdr: &mut CdrReader<'a>) -> Result<JointState<'a>, CdrError> {
    // A name has at least its length.
    let count = cdr.length(4)?;
    let names = (0..count).map(|_| cdr.string()).collect::<Result<_, _>>()?;
    let (positions_rad, speeds_rad_s) = (cdr.f64_sequence()?, cdr.f64_sequence()?);
    Ok(JointState { header, names, positions_rad, speeds_rad_s })
}

fn pose(t_s: f64, cdr: &mut CdrReader<'_>) -> Result<Pose3, CdrError> {
    let position_m = cdr.f64s()?;
    Ok(Pose3 { t_s, position_m, orientation: Some(cdr.f64s()?) })
}

/// The speeds of an odometry, after the covariance of its pose.
fn speeds(cdr: &mut CdrReader<'_>) -> Result<[f64; 2], CdrError> {
    cdr.f64s::<COVARIANCE>()?;
    let [forwards_mps, _, _, _, _, turn_rad_s] = cdr.f64s()?;
    Ok([forwards_mps, turn_rad_s])
}

fn transform<'a>(cdr: &mut CdrReader<'a>) -> Result<FramedPose<'a>, CdrError> {
    let header = header(cdr)?;
    let child = cdr.string()?;
    let pose = pose(header.stamp_s, cdr)?;
    Ok(FramedPose { parent: header.frame, child, pose, speeds: None })
}

/// A header, to be written.
fn write_header(cdr: &mut CdrWriter, t_s: f64, frame: &str) {
    let seconds = t_s.floor();
    let nanoseconds = ((t_s - seconds) * 1e9).round().min(999_999_999.0);
    cdr.u32(seconds as i32 as u32);
    cdr.u32(nanoseconds as u32);
    cdr.string(frame);
}

/// The bytes of a JointState with angles alone.
pub fn encode_joints(t_s: f64, joints: &[(&str, f64)]) -> Vec<u8> {
    let mut cdr = CdrWriter::default();
    write_header(&mut cdr, t_s, "");
    cdr.u32(joints.len() as u32);
    joints.iter().for_each(|(name, _)| cdr.string(name));
    let angles: Vec<f64> = joints.iter().map(|(_, angle)| *angle).collect();
    cdr.f64_sequence(&angles);
    cdr.f64_sequence(&[]);
    cdr.f64_sequence(&[]);
    cdr.finish()
}

/// The bytes of a DynamicJointState: one number of each joint, by the name of an interface of theirs.
pub fn encode_interface(t_s: f64, interface: &str, joints: &[(&str, f64)]) -> Vec<u8> {
    let mut cdr = CdrWriter::default();
    write_header(&mut cdr, t_s, "");
    cdr.u32(joints.len() as u32);
    joints.iter().for_each(|(name, _)| cdr.string(name));
    cdr.u32(joints.len() as u32);
    for (_, value) in joints {
        cdr.u32(1);
        cdr.string(interface);
        cdr.f64_sequence(&[*value]);
    }
    cdr.finish()
}

/// The bytes of an Imu with rates alone. A covariance that begins with -1 says that the rest was not measured.
pub fn encode_imu(t_s: f64, rad_s: [f64; 3]) -> Vec<u8> {
    let mut cdr = CdrWriter::default();
    write_header(&mut cdr, t_s, "imu_link");
    let unknown = |cdr: &mut CdrWriter| {
        cdr.f64(-1.0);
        (1..9).for_each(|_| cdr.f64(0.0));
    };
    [0.0, 0.0, 0.0, 1.0].iter().for_each(|part| cdr.f64(*part));
    unknown(&mut cdr);
    rad_s.iter().for_each(|rate| cdr.f64(*rate));
    (0..9 + 3).for_each(|_| cdr.f64(0.0));
    unknown(&mut cdr);
    cdr.finish()
}

/// The bytes of a BatteryState with a voltage alone.
pub fn encode_battery(t_s: f64, volts: f64) -> Vec<u8> {
    let mut cdr = CdrWriter::default();
    write_header(&mut cdr, t_s, "");
    cdr.f32(volts as f32);
    // Temperature, current, charge, capacities, percentage; status, health, kind and presence; cells and texts.
    (0..6).for_each(|_| cdr.f32(f32::NAN));
    cdr.u32(u32::from_le_bytes([0, 0, 0, 1]));
    (0..2).for_each(|_| cdr.u32(0));
    (0..2).for_each(|_| cdr.string(""));
    cdr.finish()
}

/// The bytes of a PoseStamped.
pub fn encode_pose(frame: &str, pose: &Pose3) -> Vec<u8> {
    let mut cdr = CdrWriter::default();
    write_pose(&mut cdr, frame, pose);
    cdr.finish()
}

/// A PoseStamped, to be written.
fn write_pose(cdr: &mut CdrWriter, frame: &str, pose: &Pose3) {
    write_header(cdr, pose.t_s, frame);
    let orientation = pose.orientation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    pose.position_m.iter().chain(&orientation).for_each(|number| cdr.f64(*number));
}

/// The bytes of a Path.
pub fn encode_path(t_s: f64, frame: &str, poses: &[Pose3]) -> Vec<u8> {
    let mut cdr = CdrWriter::default();
    write_header(&mut cdr, t_s, frame);
    cdr.u32(poses.len() as u32);
    poses.iter().for_each(|pose| write_pose(&mut cdr, frame, pose));
    cdr.finish()
}

/// The bytes of a Vector3Stamped.
pub fn encode_vector(t_s: f64, frame: &str, vector: [f64; 3]) -> Vec<u8> {
    let mut cdr = CdrWriter::default();
    write_header(&mut cdr, t_s, frame);
    vector.iter().for_each(|number| cdr.f64(*number));
    cdr.finish()
}

/// The bytes of an Odometry without covariances: a pose, and speeds as [`FramedPose::speeds`].
pub fn encode_odometry(
    [frame, child]: [&str; 2],
    pose: &Pose3,
    [forwards_mps, turn_rad_s]: [f64; 2],
) -> Vec<u8> {
    let mut cdr = CdrWriter::default();
    write_header(&mut cdr, pose.t_s, frame);
    cdr.string(child);
    let orientation = pose.orientation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    pose.position_m.iter().chain(&orientation).for_each(|number| cdr.f64(*number));
    (0..COVARIANCE).for_each(|_| cdr.f64(0.0));
    [forwards_mps, 0.0, 0.0, 0.0, 0.0, turn_rad_s].iter().for_each(|number| cdr.f64(*number));
    (0..COVARIANCE).for_each(|_| cdr.f64(0.0));
    cdr.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let bytes = encode_joints(1_732_473_042.25, &[("left", 1.5), ("right", -2.0)]);
        let Ok(Message::Joints(read)) = Message::decode(MessageType::JointState, &bytes) else {
            panic!("these are joints");
        };
        assert_eq!(read.header.stamp_s, 1_732_473_042.25);
        assert_eq!((read.names, read.positions_rad), (vec!["left", "right"], vec![1.5, -2.0]));
        let pose = Pose3 {
            t_s: -0.5,
            position_m: [1.0, 2.0, 3.0],
            orientation: Some([0.0, 0.0, 0.6, 0.8]),
        };
        let bytes = encode_pose("map", &pose);
        let read = Message::decode(MessageType::PoseStamped, &bytes).unwrap();
        let framed = FramedPose { parent: "map", child: "", pose, speeds: None };
        assert_eq!(read, Message::Poses(vec![framed]));
        let bytes = encode_odometry(["odom", "base_link"], &pose, [0.25, -1.5]);
        let read = Message::decode(MessageType::Odometry, &bytes).unwrap();
        let speeds = Some([0.25, -1.5]);
        let framed = FramedPose { parent: "odom", child: "base_link", pose, speeds };
        assert_eq!(read, Message::Poses(vec![framed]));
    }

    #[test]
    fn a_message_of_another_type_is_an_error_and_no_panic() {
        let bytes = encode_joints(1.0, &[("left", 1.5)]);
        for end in 0..bytes.len() {
            let results = MessageType::ALL.map(|kind| Message::decode(kind, &bytes[..end]));
            // Of joints, efforts are at the end, and are not read.
            assert!(results[0].is_err() || end + 4 >= bytes.len(), "{end}: {results:?}");
            assert!(results[5].is_err(), "{end}: {results:?}");
        }
    }
}
