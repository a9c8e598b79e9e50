//! What else a bag has of the robot: the rates of its gyro, and the voltage of its battery. They are welcome and not needed.

use std::path::Path;

use campaign::CampaignError;

use super::offer::is_same;
use super::{Choice, Sources};
use crate::bag::{of_topic, stamp_s};
use crate::log::{GyroAndSupply, Note, error, ordered};
use crate::message::{Message, MessageType};

impl Sources {
    /// Topics of a type.
    pub(super) fn topics_of(&self, kind: MessageType) -> Vec<&str> {
        let topics = self.bags().flat_map(|(_, inventory)| &inventory.topics);
        let mut names: Vec<&str> = topics
            .filter(|(_, topic)| topic.kind() == Some(kind))
            .map(|(name, _)| name.as_str())
            .collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Reads the only gyro and the only battery, or the gyro that was chosen.
    pub(super) fn gyro_and_supply(
        &self,
        choice: &Choice,
    ) -> Result<(GyroAndSupply, Vec<Note>), CampaignError> {
        let mut notes = Vec::new();
        let mut only = |kind: MessageType, option: &str| match self.topics_of(kind)[..] {
            [] => None,
            [topic] => Some(topic),
            [first, ..] => {
                let all = self.topics_of(kind).join(", ");
                let file = self.with_topic(first).first().copied().unwrap_or(Path::new(""));
                notes.push(Note::new(file, format!("of {all} none is taken{option}")));
                None
            }
        };
        let battery = only(MessageType::BatteryState, "");
        let imu = match &choice.imu {
            None => only(MessageType::Imu, ": choose one with --imu"),
            Some(wanted) => {
                let there = self.topics_of(MessageType::Imu);
                let topic = there.iter().find(|topic| is_same(topic, wanted)).copied();
                if topic.is_none() {
                    let hint = match there.is_empty() {
                        true => format!("no topic is {}", MessageType::Imu.name()),
                        false => format!("choose one of {}", there.join(", ")),
                    };
                    return Err(error(self.first(), format!("no gyro is called `{wanted}`"), hint));
                }
                topic
            }
        };
        let mut gyro_and_supply = GyroAndSupply::default();
        for topic in battery.into_iter().chain(imu) {
            let read =
                of_topic(&self.with_topic(topic), topic, |message, log_time_s| match message {
                    Message::TurnRates { stamp, rad_s } => {
                        gyro_and_supply.turn_rates.push((stamp_s(stamp, log_time_s).0, rad_s));
                    }
                    Message::Supply { stamp, volts } => {
                        gyro_and_supply.supply_v.push((stamp_s(stamp, log_time_s).0, volts));
                    }
                    Message::Joints(_) | Message::Poses(_) => {}
                });
            // What is not whole in the bag is said with its wheels.
            read?;
        }
        let finite = |rates: &[f64; 3]| rates.iter().all(|rate| rate.is_finite());
        ordered(&mut gyro_and_supply.turn_rates, |sample| sample.0, |sample| finite(&sample.1));
        ordered(&mut gyro_and_supply.supply_v, |sample| sample.0, |sample| sample.1.is_finite());
        Ok((gyro_and_supply, notes))
    }
}
