//! What there is in a source to choose from, for a list and for hints.

use std::path::{Path, PathBuf};

use crate::bag::{PosePlace, Topic};
use crate::message::MessageType;
use crate::text;

/// Something that could be wheels or poses, for a list.
#[derive(Clone, Debug, PartialEq)]
pub struct Offer {
    /// The file.
    pub file: PathBuf,
    /// The option that chooses it, if one does: `--wheels left,right`.
    pub option: Option<String>,
    /// Its name in the file.
    pub name: String,
    /// Its type.
    pub schema: String,
    /// How many messages or rows.
    pub count: usize,
    /// What is special about it.
    pub remark: String,
}

/// Pairs of joints whose names differ by left and right alone.
pub(super) fn pairs_of_wheels(topic: &Topic) -> Vec<[String; 2]> {
    const SIDES: [(&str, &str); 6] = [
        ("left", "right"),
        ("Left", "Right"),
        ("LEFT", "RIGHT"),
        ("_l_", "_r_"),
        ("l_wheel", "r_wheel"),
        ("wheel_l", "wheel_r"),
    ];
    let mut pairs = Vec::new();
    for left in &topic.joints {
        let right = SIDES.iter().find_map(|(from, to)| {
            let right = left.replacen(from, to, 1);
            (right != *left && topic.joints.contains(&right)).then_some(right)
        });
        pairs.extend(right.map(|right| [left.clone(), right]));
    }
    // Arms have joints with sides as well.
    let of_wheels: Vec<[String; 2]> =
        pairs.iter().filter(|[left, _]| left.to_lowercase().contains("wheel")).cloned().collect();
    if of_wheels.is_empty() { pairs } else { of_wheels }
}

/// The wheels that a user named, if a topic has them and is the one meant.
pub(super) fn wheels_of_topic(
    wanted: &[String; 2],
    name: &str,
    topic: &Topic,
) -> Option<[String; 2]> {
    let [left, right] = wanted;
    let left = match left.split_once(':') {
        Some((of, left)) if is_same(of, name) => left,
        _ => left,
    };
    let wheels = [left.to_owned(), right.clone()];
    wheels.iter().all(|joint| topic.joints.contains(joint)).then_some(wheels)
}

/// The places of poses in a topic.
pub(super) fn of_poses(name: &str, topic: &Topic) -> Vec<PosePlace> {
    match topic.kind() {
        Some(MessageType::TFMessage) => topic
            .transforms
            .keys()
            .map(|(parent, child)| PosePlace::Transform {
                topic: name.into(),
                parent: parent.clone(),
                child: child.clone(),
            })
            .collect(),
        Some(MessageType::JointState | MessageType::Imu | MessageType::BatteryState) | None => {
            Vec::new()
        }
        Some(_) if topic.transforms.is_empty() => Vec::new(),
        Some(_) => vec![PosePlace::Topic(name.into())],
    }
}

impl Offer {
    /// In a few words.
    pub(super) fn short(&self) -> String {
        let remark =
            if self.remark.is_empty() { String::new() } else { format!(" ({})", self.remark) };
        match &self.option {
            Some(option) => format!("{option}{remark}"),
            None => format!("{}: {}{remark}", self.name, self.schema),
        }
    }
}

/// What a topic offers; `is_elsewhere`: whether wheels have the names of others.
pub(super) fn of_topic(
    file: &Path,
    name: &str,
    topic: &Topic,
    is_elsewhere: impl Fn(&[String; 2]) -> bool,
) -> Vec<Offer> {
    let offer = |option: Option<String>, name: &str, count: usize, remark: String| Offer {
        file: file.into(),
        option,
        name: name.into(),
        schema: topic.schema.clone(),
        count,
        remark,
    };
    if topic.kind().is_none() {
        return vec![offer(None, name, topic.messages, "not used".into())];
    }
    let mut offers = Vec::new();
    for pair in pairs_of_wheels(topic) {
        let of = if is_elsewhere(&pair) { format!("{name}:") } else { String::new() };
        let option = Some(format!("--wheels {of}{}", pair.join(",")));
        offers.push(offer(option, name, topic.messages, String::new()));
    }
    if topic.kind() == Some(MessageType::JointState) && offers.is_empty() && topic.unread.is_none()
    {
        let joints: Vec<&str> = topic.joints.iter().map(String::as_str).collect();
        offers.push(offer(None, name, topic.messages, format!("joints: {}", joints.join(", "))));
    }
    for place in of_poses(name, topic) {
        let remark = if topic.kind() == Some(MessageType::Odometry) {
            "unless it is computed from the wheels"
        } else {
            ""
        };
        let count = match &place {
            PosePlace::Transform { parent, child, .. } => {
                topic.transforms[&(parent.clone(), child.clone())]
            }
            PosePlace::Topic(_) => topic.messages,
        };
        offers.push(offer(Some(format!("--pose {place}")), name, count, remark.into()));
    }
    if topic.kind() == Some(MessageType::Odometry) && topic.unread.is_none() {
        let remark = "if it is computed from the wheels";
        let option = Some(format!("--odometry {name}"));
        offers.push(offer(option, name, topic.messages, remark.into()));
    }
    if topic.kind() == Some(MessageType::Imu) && topic.unread.is_none() {
        let option = Some(format!("--imu {name}"));
        offers.push(offer(option, name, topic.messages, "taken if it is the only one".into()));
    }
    if topic.kind() == Some(MessageType::BatteryState) && topic.unread.is_none() {
        offers.push(offer(None, name, topic.messages, "taken if it is the only one".into()));
    }
    if let Some((count, reason)) = &topic.unread {
        offers.push(offer(None, name, *count, format!("cannot be read: {reason}")));
    }
    offers
}

pub(super) fn of_text(file: &Path, logs: &text::TextLogs) -> Vec<Offer> {
    let offer = |name: &str, schema: &str, count: usize| Offer {
        file: file.into(),
        option: None,
        name: name.into(),
        schema: schema.into(),
        count,
        remark: String::new(),
    };
    let wheels = logs.wheels.as_ref().map(|log| offer(&log.what, "wheels", log.t_s.len()));
    let poses = logs.poses.as_ref().map(|log| offer(&log.what, "poses", log.poses.len()));
    wheels.into_iter().chain(poses).collect()
}

/// Whether two names of topics mean the same, with slashes before their parts or without.
pub(super) fn is_same(a: &str, b: &str) -> bool {
    let plain = |text: &str| text.replace('/', "");
    plain(a) == plain(b)
}
