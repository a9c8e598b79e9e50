//! Telemetry as it was sent: in order, each frame once, and what the line lost asked for again.

use std::collections::{BTreeMap, VecDeque};

use shared_proto::Telemetry;

/// A frame that has not come after this long is asked for again \[us\]: as a reply is.
const ASK_AGAIN_AFTER_US: u64 = 40_000;

/// Puts telemetry in order.
///
/// Frames behind a gap wait until the gap is filled, or until the robot can no longer fill it. One
/// frame is asked for at a time, so that a line that is too slow is not choked by the asking.
#[derive(Debug, Default)]
pub struct Stream {
    /// Number of the frame that is due next; `None` before the first.
    next: Option<u32>,
    /// Frames behind a gap, by number.
    waiting: BTreeMap<u32, Telemetry>,
    /// In order, and not yet taken.
    ready: VecDeque<Telemetry>,
    /// The request under way.
    asked: Option<Asked>,
    lost: u64,
    recalled: u64,
}

#[derive(Clone, Copy, Debug)]
struct Asked {
    number: u32,
    at_us: u64,
    ids: (u32, u32),
}

impl Stream {
    /// A new subscription: its numbers have nothing to do with those of the last one.
    pub fn restart(&mut self) {
        // What nobody waited for is not lost.
        let lost = self.lost;
        self.give_up();
        self.lost = lost;
        self.next = None;
    }

    /// A frame has come.
    pub fn take_in(&mut self, telemetry: Telemetry) {
        let number = telemetry.number;
        let next = *self.next.get_or_insert(number);
        // What lies behind wraps to a large number.
        if number.wrapping_sub(next) > u32::MAX / 2 {
            return;
        }
        self.waiting.insert(number, telemetry);
        self.move_on();
        // Whatever the robot no longer keeps is lost.
        while let Some(next) = self.next
            && self.newest().is_some_and(|newest| newest.wrapping_sub(next) >= Telemetry::KEPT)
        {
            self.skip(next);
        }
    }

    /// The number to ask for now, if any is missing and has not just been asked for.
    pub fn missing(&self, now_us: u64) -> Option<u32> {
        let next = self.next.filter(|_| !self.waiting.is_empty())?;
        let just_asked = self
            .asked
            .is_some_and(|asked| asked.number == next && now_us < asked.at_us + ASK_AGAIN_AFTER_US);
        (!just_asked).then_some(next)
    }

    /// The request for this number is on its way.
    pub fn has_asked(&mut self, number: u32, id: u32, now_us: u64) {
        let before = self.asked.filter(|asked| asked.number == number).map_or(id, |a| a.ids.1);
        self.asked = Some(Asked { number, at_us: now_us, ids: (before, id) });
    }

    /// Whether a request with this id was about a frame that is missing.
    pub fn has_asked_by(&self, id: u32) -> bool {
        self.asked.is_some_and(|asked| asked.ids.0 == id || asked.ids.1 == id)
    }

    /// The robot no longer has what this request asked for.
    pub fn forgotten(&mut self, id: u32) {
        if let Some(asked) = self.asked.filter(|_| self.has_asked_by(id))
            && self.next == Some(asked.number)
            && !self.waiting.is_empty()
        {
            self.skip(asked.number);
        }
    }

    /// A frame that had been asked for has come.
    pub fn recalled(&mut self, telemetry: Telemetry) {
        if self.next == Some(telemetry.number) && !self.waiting.is_empty() {
            self.recalled += 1;
            self.take_in(telemetry);
        }
    }

    /// What is ready, oldest first.
    pub fn drain(&mut self) -> impl Iterator<Item = Telemetry> + '_ {
        self.ready.drain(..)
    }

    /// Waits for nothing more: the gaps stay.
    pub fn give_up(&mut self) {
        while let Some(next) = self.next.filter(|_| !self.waiting.is_empty()) {
            self.skip(next);
        }
    }

    /// Frames that are missing for good.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Frames that were missing and were had again.
    pub fn had_again(&self) -> u64 {
        self.recalled
    }

    /// The number that came farthest; numbers in waiting are less than half the circle apart.
    fn newest(&self) -> Option<u32> {
        let next = self.next?;
        self.waiting.keys().copied().max_by_key(|number| number.wrapping_sub(next))
    }

    fn skip(&mut self, number: u32) {
        self.lost += 1;
        self.next = Some(number.wrapping_add(1));
        self.move_on();
    }

    fn move_on(&mut self) {
        while let Some(next) = self.next
            && let Some(telemetry) = self.waiting.remove(&next)
        {
            self.ready.push_back(telemetry);
            self.next = Some(next.wrapping_add(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use shared_proto::{PidTerms, State, WheelPair, WheelTelemetry};

    use super::*;

    fn frame(number: u32) -> Telemetry {
        let terms = PidTerms::default();
        let wheel = WheelTelemetry { terms, ..WheelTelemetry::default() };
        let wheels = WheelPair::both(wheel);
        let t_us = u64::from(number) * 10_000;
        Telemetry { number, t_us, state: State::Idle, probing: false, wheels, supply_mv: 0 }
    }

    fn numbers(stream: &mut Stream) -> Vec<u32> {
        stream.drain().map(|frame| frame.number).collect()
    }

    #[test]
    fn a_frame_that_was_lost_comes_in_its_place() {
        let mut stream = Stream::default();
        for number in [5, 6, 8, 9] {
            stream.take_in(frame(number));
        }
        assert_eq!(numbers(&mut stream), [5, 6]);
        assert_eq!(stream.missing(0), Some(7));
        stream.has_asked(7, 1, 0);
        assert_eq!((stream.missing(39_999), stream.missing(40_000)), (None, Some(7)));
        stream.recalled(frame(7));
        stream.recalled(frame(7));
        assert_eq!(numbers(&mut stream), [7, 8, 9]);
        assert_eq!((stream.missing(0), stream.lost(), stream.had_again()), (None, 0, 1));
    }

    #[test]
    fn a_frame_that_came_already_is_dropped() {
        let mut stream = Stream::default();
        for number in [5, 5, 7, 7, 6, 6, 5] {
            stream.take_in(frame(number));
        }
        assert_eq!(numbers(&mut stream), [5, 6, 7]);
    }

    #[test]
    fn what_the_robot_has_forgotten_is_counted_and_holds_nothing_up() {
        let mut stream = Stream::default();
        for number in [1, 4] {
            stream.take_in(frame(number));
        }
        stream.has_asked(2, 10, 0);
        stream.has_asked(2, 11, 40_000);
        stream.forgotten(10);
        stream.forgotten(11); // The second answer to the same question.
        assert_eq!((stream.missing(40_000), stream.lost()), (Some(3), 1));
        stream.has_asked(3, 12, 40_000);
        stream.forgotten(12);
        assert_eq!((numbers(&mut stream), stream.lost()), (vec![1, 4], 2));
    }

    #[test]
    fn a_gap_older_than_the_robots_memory_is_not_asked_for() {
        let mut stream = Stream::default();
        stream.take_in(frame(0));
        stream.take_in(frame(100));
        // 100 - 31 is the oldest that the robot still has.
        assert_eq!((stream.missing(0), stream.lost()), (Some(69), 68));
        stream.restart();
        assert_eq!((numbers(&mut stream), stream.lost()), (vec![0, 100], 68));
    }

    #[test]
    fn numbers_may_wrap() {
        let mut stream = Stream::default();
        for number in [u32::MAX - 1, 0, 2, 1, u32::MAX] {
            stream.take_in(frame(number));
        }
        assert_eq!(numbers(&mut stream), [u32::MAX - 1, u32::MAX, 0, 1, 2]);
    }
}
