//! What is in a bag, and the streams that are chosen from it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};

use campaign::CampaignError;

use crate::joints::JointLog;
use crate::log::{Note, Pose3, PoseLog, WheelLog, error, ordered};
use crate::mcap;
use crate::message::{FramedPose, JointState, Message, MessageType};
use crate::received::{Damage, Received};
use crate::sqlite;

/// What a bag has to offer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inventory {
    /// Every topic: its type, its messages, and why they are not read, if they are not.
    pub topics: BTreeMap<String, Topic>,
    /// What is not whole.
    pub notes: Vec<Note>,
}

/// A topic of a bag.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topic {
    /// Its type.
    pub schema: String,
    /// How many messages.
    pub messages: usize,
    /// Names of joints that it has had, if it is of joints.
    pub joints: BTreeSet<String>,
    /// Pairs of parent and child that it has had, if it is of transforms.
    pub transforms: BTreeMap<(String, String), usize>,
    /// Messages that are not what their type says, with the first reason.
    pub unread: Option<(usize, String)>,
}

/// More names are no robot, and would only fill the memory.
const NAMES_MAX: usize = 1000;

/// Where poses are in a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PosePlace {
    /// A topic of poses.
    Topic(String),
    /// Transforms of a child in its parent.
    Transform {
        /// The topic.
        topic: String,
        /// The parent frame.
        parent: String,
        /// The child frame.
        child: String,
    },
}

impl std::fmt::Display for PosePlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Topic(topic) => f.write_str(topic),
            Self::Transform { topic, parent, child } => write!(f, "{topic}:{parent}.{child}"),
        }
    }
}

/// Lists a bag.
pub fn inventory(file: &Path) -> Result<Inventory, CampaignError> {
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let notes = each_message(file, |received| {
        let channel = received.channel;
        if !topics.contains_key(&channel.topic) && topics.len() < NAMES_MAX {
            let topic = Topic { schema: channel.schema.clone(), ..Topic::default() };
            topics.insert(channel.topic.clone(), topic);
        }
        if let Some(topic) = topics.get_mut(&channel.topic) {
            topic.add(received);
        }
    })?;
    Ok(Inventory { topics, notes })
}

impl Topic {
    fn add(&mut self, received: Received<'_>) {
        self.messages += 1;
        match decode(received) {
            None => {}
            Some(Err(reason)) => self.unread.get_or_insert((0, reason)).0 += 1,
            Some(Ok(Message::Joints(state))) => {
                for name in state.names {
                    if !self.joints.contains(name) && self.joints.len() < NAMES_MAX {
                        self.joints.insert(name.to_owned());
                    }
                }
            }
            Some(Ok(Message::TurnRates { .. } | Message::Supply { .. })) => {}
            Some(Ok(Message::Poses(poses))) => {
                for pose in poses {
                    let pair = (pose.parent.to_owned(), pose.child.to_owned());
                    if let Some(count) = self.transforms.get_mut(&pair) {
                        *count += 1;
                    } else if self.transforms.len() < NAMES_MAX {
                        self.transforms.insert(pair, 1);
                    }
                }
            }
        }
    }

    /// Its type, if it is one that is read.
    pub fn kind(&self) -> Option<MessageType> {
        MessageType::from_name(&self.schema)
    }
}

/// What a message says, or why it cannot be read; `None` if its type is none of ours.
fn decode(received: Received<'_>) -> Option<Result<Message<'_>, String>> {
    let kind = MessageType::from_name(&received.channel.schema)?;
    if received.channel.encoding != "cdr" {
        return Some(Err(format!(
            "they are encoded as `{}`, not as cdr",
            received.channel.encoding
        )));
    }
    Some(Message::decode(kind, received.bytes).map_err(|error| error.to_string()))
}

fn each_message(file: &Path, each: impl FnMut(Received<'_>)) -> Result<Vec<Note>, CampaignError> {
    // Opening a pipe would wait for its writer.
    let there =
        std::fs::metadata(file).map_err(|cause| CampaignError::io(file, "read it", cause))?;
    if !there.is_file() {
        return Err(error(file, "this is not a file", "name a bag, FILE.mcap"));
    }
    let cannot = |cause| CampaignError::io(file, "read it", cause);
    let mut open = File::open(file).map_err(cannot)?;
    let mut first = Vec::new();
    (&mut open).take(sqlite::MAGIC.len() as u64).read_to_end(&mut first).map_err(cannot)?;
    open.rewind().map_err(cannot)?;
    if first == sqlite::MAGIC {
        return each_row(file, open, each);
    }
    match mcap::read(BufReader::with_capacity(1 << 18, open), each) {
        Ok(damage) => Ok(notes(file, &damage)),
        Err(mcap::ReadError::Io(cause)) => Err(cannot(cause)),
        Err(mcap::ReadError::NotMcap) => {
            Err(error(file, "this is neither an MCAP nor an SQLite file", "give a ROS 2 bag"))
        }
    }
}

/// The messages of a bag in SQLite.
fn each_row(
    file: &Path,
    open: File,
    each: impl FnMut(Received<'_>),
) -> Result<Vec<Note>, CampaignError> {
    let damage = sqlite::read(open, each).map_err(|why| match why {
        sqlite::ReadError::Io(cause) => CampaignError::io(file, "read it", cause),
        sqlite::ReadError::NotSqlite => {
            error(file, "the head of this SQLite file is corrupt", "give another bag of ROS 2")
        }
        sqlite::ReadError::NoBag => error(
            file,
            "this SQLite file is not a ROS 2 bag: it has no tables `topics` and `messages`",
            "give a ROS 2 bag",
        ),
    })?;
    let mut notes = notes(file, &damage);
    let beside = PathBuf::from(format!("{}-wal", file.display()));
    if std::fs::metadata(&beside).is_ok_and(|beside| beside.len() > 0) {
        let text = format!(
            "{} has messages that its recorder has not put into the bag: they are missing; `ros2 bag info` or any SQLite program puts them there",
            beside.display()
        );
        notes.push(Note::new(file, text));
    }
    Ok(notes)
}

/// What is damaged, in words: each kind once.
fn notes(file: &Path, damage: &[Damage]) -> Vec<Note> {
    let mut notes = Vec::new();
    let first_of = |is: fn(&Damage) -> Option<u64>| {
        let mut places = damage.iter().filter_map(is);
        let first = places.next()?;
        Some((first, 1 + places.count()))
    };
    let chunk = |damage: &Damage| if let Damage::Chunk { at } = damage { Some(*at) } else { None };
    let record =
        |damage: &Damage| if let Damage::Record { at } = damage { Some(*at) } else { None };
    if let Some((at, count)) = first_of(chunk) {
        let text = match count {
            1 => format!("a chunk is corrupt, at byte {at}: its messages are missing"),
            _ => format!(
                "{count} chunks are corrupt, the first at byte {at}: their messages are missing"
            ),
        };
        notes.push(Note::new(file, text));
    }
    if let Some((at, count)) = first_of(record) {
        let text = match count {
            1 => format!("a record is corrupt, at byte {at}: it was left out"),
            _ => format!("{count} records are corrupt, the first at byte {at}: they were left out"),
        };
        notes.push(Note::new(file, text));
    }
    for damage in damage {
        match damage {
            Damage::CutOff { at } => {
                let text = format!(
                    "the bag is cut off at byte {at}, as by a crash: what was recorded after that is missing"
                );
                notes.push(Note::new(file, text));
            }
            Damage::Rows { count } => {
                let text = format!("{count} rows contradict themselves: they were left out");
                notes.push(Note::new(file, text));
            }
            Damage::Compression { name } => {
                let text = format!(
                    "chunks are compressed by `{name}`, which is unknown: their messages are missing"
                );
                notes.push(Note::new(file, text));
            }
            Damage::Chunk { .. } | Damage::Record { .. } => {}
        }
    }
    notes
}

/// Gives every message of a topic that can be read to `each`, with the recorder's time \[s\].
pub(crate) fn of_topic(
    files: &[&Path],
    topic: &str,
    mut each: impl FnMut(Message<'_>, f64),
) -> Result<Vec<Note>, CampaignError> {
    let mut notes = Vec::new();
    for file in files {
        notes.extend(each_message(file, |received| {
            if received.channel.topic == topic
                && let Some(Ok(message)) = decode(received)
            {
                each(message, received.log_time_s);
            }
        })?);
    }
    Ok(notes)
}

/// The stamp of a message \[s\]: that of its header, and the recorder's time where nobody set it.
pub(crate) fn stamp_s(header_s: f64, log_time_s: f64) -> (f64, bool) {
    if header_s == 0.0 { (log_time_s, true) } else { (header_s, false) }
}

/// Reads two joints of a topic as wheels.
pub fn wheels(
    files: &[&Path],
    topic: &str,
    [left, right]: [&str; 2],
) -> Result<(WheelLog, Vec<Note>), CampaignError> {
    let (mut angles, mut rates) = (JointLog::default(), JointLog::default());
    let (mut unstamped, mut unsound) = (0, 0);
    let mut notes = of_topic(files, topic, |message, log_time_s| {
        let Message::Joints(state) = message else { return };
        let (t_s, is_unstamped) = stamp_s(state.header.stamp_s, log_time_s);
        unstamped += usize::from(is_unstamped);
        let found = of_joints(&state, &state.positions_rad, [left, right]);
        // Where speeds are all that is known, some write angles that are no numbers.
        let sound = found.map(|number| number.filter(|number| number.is_finite()));
        unsound += usize::from(sound != found);
        if !angles.add(t_s, sound) {
            rates.add(t_s, of_joints(&state, &state.speeds_rad_s, [left, right]));
        }
    })?;
    let file = files.first().copied().unwrap_or(Path::new(""));
    let is_of_speeds = !angles.has_both() && rates.has_both();
    let joints = if is_of_speeds { rates } else { angles };
    if unsound > 0 && !is_of_speeds {
        let text = format!("{topic}: {unsound} samples are not numbers and were left out");
        notes.push(Note::new(file, text));
    }
    let is_apart = joints.both.is_empty();
    let mut samples = joints.joined();
    if is_apart && !samples.is_empty() {
        let text = format!(
            "{topic}: {left} and {right} come in messages of their own; {right} was interpolated at the times of {left}"
        );
        notes.push(Note::new(file, text));
    }
    let said = ordered(
        &mut samples,
        |sample| sample.0,
        |sample| sample.1.iter().all(|phi| phi.is_finite()),
    );
    notes.extend(said.into_iter().map(|said| Note::new(file, format!("{topic}: {said}"))));
    notes.extend(of_stamps(file, topic, unstamped));
    if is_of_speeds {
        integrate(&mut samples);
        let text =
            format!("{topic} has no positions: the speeds were added up, which is less exact");
        notes.push(Note::new(file, text));
    }
    let (t_s, turned) = samples.into_iter().unzip();
    let what = format!("{topic} ({left}, {right})");
    Ok((WheelLog { file: file.into(), what, t_s, turned, ..WheelLog::default() }, notes))
}

/// The numbers of two joints, as far as a message has them.
fn of_joints(state: &JointState<'_>, numbers: &[f64], wanted: [&str; 2]) -> [Option<f64>; 2] {
    wanted.map(|wanted| {
        let index = state.names.iter().position(|name| *name == wanted)?;
        numbers.get(index).copied()
    })
}

/// Speeds become angles, by trapezia.
fn integrate(samples: &mut [(f64, [f64; 2])]) {
    let mut turned = [0.0; 2];
    let mut before: Option<(f64, [f64; 2])> = None;
    for (t_s, numbers) in samples.iter_mut() {
        let speeds = *numbers;
        if let Some((before_s, speeds_before)) = before.replace((*t_s, speeds)) {
            for side in 0..2 {
                turned[side] += (speeds[side] + speeds_before[side]) / 2.0 * (*t_s - before_s);
            }
        }
        *numbers = turned;
    }
}

pub(crate) fn of_stamps(file: &Path, topic: &str, unstamped: usize) -> Option<Note> {
    let text = format!(
        "{topic}: {unstamped} message{} no stamp in {} header; the recorder's time was taken, which is less exact",
        if unstamped == 1 { " has" } else { "s have" },
        if unstamped == 1 { "its" } else { "their" }
    );
    (unstamped > 0).then(|| Note::new(file, text))
}

/// Reads the poses of a place.
pub fn poses(files: &[&Path], place: &PosePlace) -> Result<(PoseLog, Vec<Note>), CampaignError> {
    let (topic, frames) = match place {
        PosePlace::Topic(topic) => (topic, None),
        PosePlace::Transform { topic, parent, child } => (topic, Some((parent, child))),
    };
    let mut poses: Vec<Pose3> = Vec::new();
    let mut unstamped = 0;
    let is_meant = |framed: &FramedPose<'_>| {
        frames.is_none_or(|(parent, child)| framed.parent == *parent && framed.child == *child)
    };
    let mut notes = of_topic(files, topic, |message, log_time_s| {
        let Message::Poses(framed) = message else { return };
        for framed in framed.into_iter().filter(is_meant) {
            let (t_s, is_unstamped) = stamp_s(framed.pose.t_s, log_time_s);
            unstamped += usize::from(is_unstamped);
            poses.push(Pose3 { t_s, ..framed.pose });
        }
    })?;
    let file = files.first().copied().unwrap_or(Path::new(""));
    let finite = |pose: &Pose3| {
        let orientation = pose.orientation.unwrap_or_default();
        pose.position_m.iter().chain(&orientation).all(|number| number.is_finite())
    };
    let said = ordered(&mut poses, |pose| pose.t_s, finite);
    notes.extend(said.into_iter().map(|said| Note::new(file, format!("{place}: {said}"))));
    notes.extend(of_stamps(file, topic, unstamped));
    Ok((PoseLog { file: file.into(), what: place.to_string(), poses }, notes))
}
