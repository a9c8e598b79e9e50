//! What is made sure of everything that a robot sends: it may be broken, or no robot at all.

use std::collections::VecDeque;

use shared_proto::Config;

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
        Ok(()) => Ok(config),
        Err(problem) => Err(Error::InvalidConfig { problem }),
    }
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
    fn what_nobody_takes_is_bounded_and_the_latest_stays() {
        let mut queue = VecDeque::new();
        (0..3 * KEPT_MAX).for_each(|number| keep_latest(&mut queue, number));
        assert_eq!((queue.len(), queue.back()), (KEPT_MAX, Some(&(3 * KEPT_MAX - 1))));
    }
}
