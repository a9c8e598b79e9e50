//! What is made sure of everything that a robot sends: it may be broken, or no robot at all.

use std::collections::VecDeque;

use shared_proto::{Config, Name};

use crate::error::{Error, Result};

/// A robot answers one request at a time, and its events are few: more than this is no robot's.
pub const KEPT_MAX: usize = 1024;

/// Adds to what was received and not taken yet; beyond [`KEPT_MAX`] the oldest goes.
pub(crate) fn keep_latest<T>(queue: &mut VecDeque<T>, received: T) {
    if queue.len() >= KEPT_MAX {
        queue.pop_front();
    }
    queue.push_back(received);
}

/// A configuration, checked as one from a file is.
pub(crate) fn valid_config(config: Config) -> Result<Config> {
    match config.validate() {
        Ok(()) => Ok(with_plain_name(config)),
        Err(problem) => Err(Error::InvalidConfig { problem }),
    }
}

/// A configuration whose name holds no control characters.
pub(crate) fn with_plain_name(config: Config) -> Config {
    Config { name: plain(&config.name), ..config }
}

/// A name with a question mark in the place of each control character: who prints it sends no codes to a terminal. A robot with
/// such a name is not refused, so that it can be given another.
pub(crate) fn plain(name: &Name) -> Name {
    let plain = name.as_str().replace(char::is_control, "?");
    // No control character is shorter than a question mark.
    Name::new(&plain).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configuration_that_no_robot_can_have_is_refused() {
        assert!(valid_config(Config::default()).is_ok());
        let mut config = Config::default();
        config.encoder.left.counts_per_rev = f64::NAN;
        let error = valid_config(config).unwrap_err().to_string();
        assert!(error.contains("invalid: encoder.left.counts_per_rev"), "{error}");
    }

    #[test]
    fn a_name_that_a_robot_sends_holds_no_control_characters() {
        let evil = Name::new("\u{1b}]0;x\u{7}\u{9b}2J\r\né").unwrap();
        assert_eq!(plain(&evil).as_str(), "?]0;x??2J??é");
        let config = Config { name: evil, ..Config::default() };
        assert_eq!(valid_config(config).unwrap().name.as_str(), "?]0;x??2J??é");
        let longest = Name::new(&"\u{1b}".repeat(shared_proto::NAME_LEN_MAX)).unwrap();
        assert_eq!(plain(&longest).as_str(), "?".repeat(shared_proto::NAME_LEN_MAX));
    }

    #[test]
    fn what_nobody_takes_is_bounded_and_the_latest_stays() {
        let mut queue = VecDeque::new();
        (0..3 * KEPT_MAX).for_each(|number| keep_latest(&mut queue, number));
        assert_eq!((queue.len(), queue.back()), (KEPT_MAX, Some(&(3 * KEPT_MAX - 1))));
    }
}
