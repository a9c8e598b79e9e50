//! The numbers that a session gives to its motions.

use shared_proto::MotionId;

/// Numbers that count up, from a place that the session's own number decides.
///
/// A robot takes a command with the number of an earlier motion for a copy of it. Numbers of sessions may be alike or in
/// steps; those places are not, so that motions of two sessions do not meet.
pub(super) struct MotionIds(u32);

impl MotionIds {
    pub(super) fn of_session(number: u32) -> Self {
        Self(scattered(number))
    }

    pub(super) fn next(&mut self) -> MotionId {
        self.0 = self.0.wrapping_add(1);
        MotionId(self.0)
    }
}

/// No two numbers have the same result, and each bit of a number moves about half of its bits: `lowbias32` of
/// <https://nullprogram.com/blog/2018/07/31/>, which is in the public domain.
fn scattered(mut number: u32) -> u32 {
    number = (number ^ (number >> 16)).wrapping_mul(0x7feb_352d);
    number = (number ^ (number >> 15)).wrapping_mul(0x846c_a68b);
    number ^ (number >> 16)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn motions_of_sessions_whose_numbers_are_alike_or_in_steps_have_numbers_of_their_own() {
        for step in [1, 2, 0x0001_0000, 0x9e37_79b9_u32] {
            let mut seen = HashSet::new();
            for session in 1..=1_000 {
                let mut ids = MotionIds::of_session(step.wrapping_mul(session));
                assert!(
                    (0..20).all(|_| seen.insert(ids.next().0)),
                    "session {session} of {step:#x}"
                );
            }
        }
    }
}
