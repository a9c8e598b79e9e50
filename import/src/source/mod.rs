//! Which sources there are, and which of what they hold is taken for wheels and poses.
//!
//! What is certain is chosen; what is not is asked for, with what there is to choose from.

mod checks;
mod file;
mod gyro_and_supply;
mod offer;

pub use offer::Offer;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use campaign::CampaignError;

use crate::bag::{self, Inventory, PosePlace};
use crate::geometry::Geometry;
use crate::log::{Note, PoseLog, WheelLog, error};
use crate::message::MessageType;
use crate::odometry;
use crate::text::{self, Mapping};
use crate::wpilog::{self, is_wpilog};
use file::{files, is_bag};
use offer::{is_same, of_poses, of_text, of_topic, pairs_of_wheels, wheels_of_topic};

/// Parts of hints.
const BACK: &str = "computed from the wheels alone, they can be computed back: add";
const NUMBERS: &str =
    "and the numbers that it used by --controller FILE.yaml or --wheel-radius and --track-width";
/// What is said of poses that a user chose all the same.
const OF_WHEELS: &str = "if these poses are computed from the wheels, or by a filter from the wheels and others, they agree with the wheels where these are wrong";

/// Which parts of the sources are meant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// The joints of the left and the right wheel, if they are in a bag; with a topic before the left one where several have
    /// them: `/robot1/joint_states:left`.
    pub wheels: Option<[String; 2]>,
    /// A topic of odometry to be turned back into wheels, with the numbers that it used.
    pub odometry: Option<(String, Geometry)>,
    /// A topic, or `/tf:parent.child`.
    pub pose: Option<String>,
    /// A topic of a gyro, if there are several.
    pub imu: Option<String>,
    /// Columns of text files.
    pub mappings: Vec<Mapping>,
}

/// A file, with what is in it.
#[derive(Clone, Debug)]
enum Source {
    Bag(PathBuf, Inventory),
    Text(PathBuf, Box<text::TextLogs>),
}

/// All sources, looked into.
#[derive(Clone, Debug)]
pub struct Sources {
    each: Vec<Source>,
}

/// Wheels and poses, chosen and read.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// The wheels.
    pub wheels: WheelLog,
    /// The poses.
    pub poses: PoseLog,
    /// What is not whole, and what else was done.
    pub notes: Vec<Note>,
    /// Both are of one recorder.
    pub same_clock: bool,
}

impl Sources {
    /// Looks into files, and into folders for the bags in them.
    pub fn open(paths: &[PathBuf], mappings: &[Mapping]) -> Result<Self, CampaignError> {
        let mut each = Vec::new();
        for path in paths {
            for file in files(path)? {
                each.push(match is_bag(&file)? {
                    true => Source::Bag(file.clone(), bag::inventory(&file)?),
                    false if is_wpilog(&file) => {
                        Source::Text(file.clone(), Box::new(wpilog::read(&file, mappings)?))
                    }
                    false => Source::Text(file.clone(), Box::new(text::read(&file, mappings)?)),
                });
            }
        }
        let sources = Self { each };
        sources.check_times()?;
        sources.check_mappings(mappings)?;
        Ok(sources)
    }

    /// What there is to choose from.
    pub fn offers(&self) -> Vec<Offer> {
        let mut offers = Vec::new();
        for source in &self.each {
            match source {
                Source::Bag(file, inventory) => {
                    for (name, topic) in &inventory.topics {
                        let is_elsewhere = |pair: &[String; 2]| self.have_joints(pair) > 1;
                        offers.extend(of_topic(file, name, topic, is_elsewhere));
                    }
                }
                Source::Text(file, logs) => offers.extend(of_text(file, logs)),
            }
        }
        offers
    }

    /// What is not whole in the sources.
    pub fn notes(&self) -> Vec<Note> {
        let notes = |source: &Source| match source {
            Source::Bag(_, inventory) => inventory.notes.clone(),
            Source::Text(_, logs) => logs.notes.clone(),
        };
        self.each.iter().flat_map(notes).collect()
    }

    fn bags(&self) -> impl Iterator<Item = (&Path, &Inventory)> {
        self.each.iter().filter_map(|source| match source {
            Source::Bag(file, inventory) => Some((file.as_path(), inventory)),
            Source::Text(..) => None,
        })
    }

    /// Bags that have a topic.
    fn with_topic(&self, topic: &str) -> Vec<&Path> {
        let has = |inventory: &Inventory| inventory.topics.contains_key(topic);
        self.bags().filter(|(_, inventory)| has(inventory)).map(|(file, _)| file).collect()
    }

    /// How many topics have these joints.
    fn have_joints(&self, pair: &[String; 2]) -> usize {
        let all = self.bags().flat_map(|(_, inventory)| &inventory.topics);
        let with = all.filter(|(_, topic)| pair.iter().all(|joint| topic.joints.contains(joint)));
        with.map(|(name, _)| name).collect::<BTreeSet<_>>().len()
    }

    /// Any file, to name in errors.
    fn first(&self) -> &Path {
        match self.each.first() {
            Some(Source::Bag(file, _) | Source::Text(file, _)) => file,
            None => Path::new("."),
        }
    }

    /// What there is, in words, for the hint of an error.
    fn what_there_is(&self) -> String {
        let offers: Vec<String> = self.offers().iter().map(Offer::short).collect();
        let shown: Vec<&str> = offers.iter().take(12).map(String::as_str).collect();
        if shown.is_empty() {
            return "there is nothing in it that can be read".into();
        }
        let more = offers.len().saturating_sub(shown.len());
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("there is {}{more}", shown.join("; "))
    }

    /// Chooses and reads wheels and poses.
    pub fn choose(&self, choice: &Choice) -> Result<Chosen, CampaignError> {
        let (mut wheels, mut notes) = self.wheels(choice)?;
        let (poses, of_poses) = self.poses(choice)?;
        if choice.odometry.as_ref().is_some_and(|(topic, _)| is_same(topic, &poses.what)) {
            let problem = format!("{} was chosen for both wheels and poses", poses.what);
            let hint =
                "poses must be measured by something else than the wheels: a tracker, a camera";
            return Err(error(&poses.file, problem, hint));
        }
        // A gyro in another file than the wheels is on a clock of its own.
        if self.bags().any(|(bag, _)| bag == wheels.file) {
            let (gyro_and_supply, more_notes) = self.gyro_and_supply(choice)?;
            wheels.gyro_and_supply = gyro_and_supply;
            notes.extend(more_notes);
        }
        notes.extend(of_poses);
        notes.extend(self.notes());
        let mut told: Vec<Note> = Vec::new();
        for note in notes {
            if !told.contains(&note) {
                told.push(note);
            }
        }
        let is_bag = |file: &Path| self.bags().any(|(bag, _)| bag == file);
        let same_clock = wheels.file == poses.file || is_bag(&wheels.file) && is_bag(&poses.file);
        Ok(Chosen { wheels, poses, notes: told, same_clock })
    }

    fn of_odometry(
        &self,
        wanted: &str,
        geometry: &Geometry,
    ) -> Result<(WheelLog, Vec<Note>), CampaignError> {
        let there = self.topics_of(MessageType::Odometry);
        let Some(topic) = there.iter().find(|topic| is_same(topic, wanted)) else {
            let hint = match there.is_empty() {
                true => format!("no topic is nav_msgs/msg/Odometry; {}", self.what_there_is()),
                false => format!("choose one of {}", there.join(", ")),
            };
            return Err(error(self.first(), format!("no odometry is called `{wanted}`"), hint));
        };
        odometry::wheels(&self.with_topic(topic), topic, geometry)
    }

    fn wheels(&self, choice: &Choice) -> Result<(WheelLog, Vec<Note>), CampaignError> {
        if let Some((topic, geometry)) = &choice.odometry {
            return self.of_odometry(topic, geometry);
        }
        let texts: Vec<&WheelLog> = self.each.iter().filter_map(Source::wheels).collect();
        if let (None, [log]) = (&choice.wheels, texts.as_slice()) {
            return Ok(((*log).clone(), Vec::new()));
        }
        let mut candidates: Vec<(String, [String; 2])> = Vec::new();
        for (name, topic) in self.bags().flat_map(|(_, inventory)| &inventory.topics) {
            let pairs = match &choice.wheels {
                Some(wanted) => wheels_of_topic(wanted, name, topic).into_iter().collect(),
                None => pairs_of_wheels(topic),
            };
            candidates.extend(pairs.into_iter().map(|pair| (name.clone(), pair)));
        }
        candidates.sort();
        candidates.dedup();
        match candidates.as_slice() {
            [(topic, [left, right])] if texts.is_empty() || choice.wheels.is_some() => {
                bag::wheels(&self.with_topic(topic), topic, [left.as_str(), right.as_str()])
            }
            [] if choice.wheels.is_some() => {
                let wanted =
                    choice.wheels.as_ref().map_or_else(String::new, |wheels| wheels.join(" and "));
                Err(error(
                    self.first(),
                    format!("no topic has the joints {wanted}"),
                    self.what_there_is(),
                ))
            }
            [] if texts.is_empty() => {
                let problem = "nothing in it is known to be the wheels";
                let hint = match self.topics_of(MessageType::Odometry)[..] {
                    [topic] => format!("if {topic} is {BACK} --odometry {topic}, {NUMBERS}"),
                    [_, ..] => {
                        let all = self.topics_of(MessageType::Odometry).join(", ");
                        format!("if one of {all} is {BACK} --odometry TOPIC, {NUMBERS}")
                    }
                    [] => format!(
                        "choose two joints with --wheels LEFT,RIGHT, or columns with --map; {}",
                        self.what_there_is()
                    ),
                };
                Err(error(self.first(), problem, hint))
            }
            _ => {
                let problem = "more than one thing in it may be the wheels";
                let hint = format!(
                    "choose with --wheels LEFT,RIGHT or --wheels /topic:LEFT,RIGHT, or give fewer files; {}",
                    self.what_there_is()
                );
                Err(error(self.first(), problem, hint))
            }
        }
    }

    fn poses(&self, choice: &Choice) -> Result<(PoseLog, Vec<Note>), CampaignError> {
        let places = self.pose_places();
        if let Some(wanted) = &choice.pose {
            let place = places.iter().find(|(place, _)| {
                place.to_string() == *wanted || is_same(&place.to_string(), wanted)
            });
            let Some((place, is_odometry)) = place else {
                let all: Vec<String> = places.iter().map(|(place, _)| place.to_string()).collect();
                let hint = match all.is_empty() {
                    true => format!("no topic has poses; {}", self.what_there_is()),
                    false => format!("choose one of {}", all.join(", ")),
                };
                return Err(error(self.first(), format!("no poses are called `{wanted}`"), hint));
            };
            let (log, mut notes) = bag::poses(&self.with_topic(topic_of(place)), place)?;
            if *is_odometry {
                notes.push(Note::new(&log.file, format!("{place}: {OF_WHEELS}")));
            }
            return Ok((log, notes));
        }
        let texts: Vec<&PoseLog> = self.each.iter().filter_map(Source::poses).collect();
        // Odometry is computed from the wheels, and shows nothing that they do not.
        let independent: Vec<&PosePlace> =
            places.iter().filter(|(_, is_odometry)| !is_odometry).map(|(place, _)| place).collect();
        match (independent.as_slice(), texts.as_slice()) {
            ([place], []) => bag::poses(&self.with_topic(topic_of(place)), place),
            ([], [log]) => Ok(((*log).clone(), Vec::new())),
            ([], []) if !places.is_empty() => {
                let all: Vec<String> = places.iter().map(|(place, _)| place.to_string()).collect();
                let problem = format!(
                    "the only poses are {}, which may be computed from the wheels",
                    all.join(", ")
                );
                let hint = "poses must be measured by something else: a tracker, a camera; if these are, choose them with --pose";
                Err(error(self.first(), problem, hint))
            }
            ([], []) => {
                let problem = "nothing in it is known to be measured poses";
                let hint = format!(
                    "add a file with them, for example a TUM trajectory; {}",
                    self.what_there_is()
                );
                Err(error(self.first(), problem, hint))
            }
            _ => {
                let problem = "more than one thing in it may be the measured poses";
                let hint =
                    format!("choose with --pose, or give fewer files; {}", self.what_there_is());
                Err(error(self.first(), problem, hint))
            }
        }
    }

    /// Where poses are in the bags, and whether they are odometry.
    fn pose_places(&self) -> Vec<(PosePlace, bool)> {
        let mut places = Vec::new();
        for (name, topic) in self.bags().flat_map(|(_, inventory)| &inventory.topics) {
            for place in of_poses(name, topic) {
                // What places the frame of odometry on a map is no pose of the robot either.
                // Nor is odometry that is published again as poses, which gives its frame away.
                let odometry = match &place {
                    PosePlace::Transform { parent, child, .. } => is_odom(parent) || is_odom(child),
                    PosePlace::Topic(_) => {
                        topic.transforms.keys().any(|(parent, _)| is_odom(parent))
                    }
                };
                let is_odometry = odometry || topic.kind() == Some(MessageType::Odometry);
                places.push((place, is_odometry));
            }
        }
        places.sort_by_key(|(place, _)| place.to_string());
        places.dedup();
        places
    }
}

impl Source {
    fn wheels(&self) -> Option<&WheelLog> {
        match self {
            Self::Text(_, logs) => logs.wheels.as_ref(),
            Self::Bag(..) => None,
        }
    }

    fn poses(&self) -> Option<&PoseLog> {
        match self {
            Self::Text(_, logs) => logs.poses.as_ref(),
            Self::Bag(..) => None,
        }
    }
}

/// Whether a frame is that of odometry: `odom`, `robot1/odom`.
fn is_odom(frame: &str) -> bool {
    frame.rsplit('/').next().is_some_and(|name| name.starts_with("odom"))
}

fn topic_of(place: &PosePlace) -> &str {
    match place {
        PosePlace::Topic(topic) | PosePlace::Transform { topic, .. } => topic,
    }
}
