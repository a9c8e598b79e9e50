//! Telemetry as it was sent: in order, each frame once; frames that the line lost are requested
//! again.
//!
//! The stream says which frame to request; [`crate::session`] sends the request.

use std::collections::{BTreeMap, VecDeque};

use shared_proto::Telemetry;

/// A request for a frame is repeated after this long \[us\], as other requests are.
const REQUEST_AGAIN_AFTER_US: u64 = 40_000;

/// Frames that nobody takes are kept up to this many, which is a minute of the fastest telemetry; then the oldest are lost.
const READY_MAX: usize = 60_000;

/// Puts telemetry in order.
///
/// Frames after a gap wait until the gap is filled, or until the robot can no longer fill it. One
/// frame is requested at a time, so that requests do not choke a slow line.
#[derive(Debug, Default)]
pub struct Stream {
    /// Number of the next frame; `None` before the first.
    next: Option<u32>,
    /// Number and time \[us\] of the newest frame.
    newest_frame: Option<(u32, u64)>,
    /// From frame to frame of this subscription \[us\]; `None` before the second.
    period_us: Option<u64>,
    /// The time of the last frame of this subscription that was delivered \[us\].
    delivered_us: Option<u64>,
    /// Frames after a gap, by number.
    waiting: BTreeMap<u32, Telemetry>,
    /// Frames in order that were not taken yet.
    ready: VecDeque<Telemetry>,
    /// The request under way.
    request: Option<GapRequest>,
    lost: u64,
    recalled: u64,
}

#[derive(Clone, Copy, Debug)]
struct GapRequest {
    number: u32,
    at_us: u64,
    /// The ids of the last two requests for this number: an answer to either fills the gap.
    ids: (u32, u32),
}

impl Stream {
    /// Never more frames wait: those that are in order, and those behind a gap that the robot can still fill.
    pub const WAITING_MAX: usize = READY_MAX + Telemetry::KEPT as usize + 1;

    /// How many frames were received and not taken yet.
    pub fn waiting(&self) -> usize {
        self.ready.len() + self.waiting.len()
    }

    /// Begins a new subscription, whose numbers are not those of the last one.
    pub fn restart(&mut self) {
        // Frames of an old subscription do not count as lost.
        let lost = self.lost;
        self.give_up();
        self.lost = lost;
        self.next = None;
        self.delivered_us = None;
        self.period_us = None;
    }

    /// Adds a frame that was received.
    pub fn push(&mut self, telemetry: Telemetry) {
        let number = telemetry.number;
        self.keep_pace(&telemetry);
        let next = *self.next.get_or_insert(number);
        // For a frame before the next one the difference wraps to a large number.
        if number.wrapping_sub(next) > u32::MAX / 2 {
            return;
        }
        self.waiting.insert(number, telemetry);
        self.release();
        // A frame that the robot no longer keeps is lost.
        if let (Some(next), Some(newest)) = (self.next, self.newest())
            && newest.wrapping_sub(next) >= Telemetry::KEPT
        {
            self.skip_to(newest.wrapping_sub(Telemetry::KEPT - 1));
        }
    }

    /// Begins anew if another host has asked for another period: a later frame has an earlier number, or one that this
    /// period could not have reached by now.
    fn keep_pace(&mut self, telemetry: &Telemetry) {
        let Telemetry { number, t_us, .. } = *telemetry;
        let Some((newest, newest_us)) = self.newest_frame else {
            self.newest_frame = Some((number, t_us));
            return;
        };
        if t_us <= newest_us {
            return;
        }
        self.newest_frame = Some((number, t_us));
        let is_behind = |of: u32| number.wrapping_sub(of) > u32::MAX / 2;
        let (steps, passed_us) = (number.wrapping_sub(newest), t_us - newest_us);
        // To half a period: the time of a tick is not exact.
        let is_too_early = |period_us: u64| {
            // The times are the robot's word, and may be any.
            let due_us = u64::from(steps).saturating_mul(period_us);
            steps > 1 && passed_us < due_us.saturating_sub(period_us / 2)
        };
        if self.next.is_some_and(is_behind) || self.period_us.is_some_and(is_too_early) {
            self.restart();
        } else if steps > 0 && !is_behind(newest) {
            self.period_us = Some(passed_us / u64::from(steps));
        }
    }

    /// The number to request now, if a frame is missing and was not requested just before.
    pub fn missing(&self, now_us: u64) -> Option<u32> {
        let next = self.next.filter(|_| !self.waiting.is_empty())?;
        let just_requested = self.request.is_some_and(|request| {
            request.number == next && now_us < request.at_us + REQUEST_AGAIN_AFTER_US
        });
        (!just_requested).then_some(next)
    }

    /// Notes that this number was requested.
    pub fn mark_requested(&mut self, number: u32, id: u32, now_us: u64) {
        let earlier = self.request.filter(|request| request.number == number);
        let before = earlier.map_or(id, |request| request.ids.1);
        self.request = Some(GapRequest { number, at_us: now_us, ids: (before, id) });
    }

    /// Whether the request with this id was for a missing frame.
    pub fn is_request(&self, id: u32) -> bool {
        self.request.is_some_and(|request| request.ids.0 == id || request.ids.1 == id)
    }

    /// Notes that the robot no longer has the frame of this request.
    pub fn unavailable(&mut self, id: u32) {
        if let Some(request) = self.request.filter(|_| self.is_request(id))
            && self.next == Some(request.number)
            && !self.waiting.is_empty()
        {
            self.skip_to(request.number.wrapping_add(1));
        }
    }

    /// Adds a frame that was requested.
    pub fn fill_gap(&mut self, telemetry: Telemetry) {
        if self.next == Some(telemetry.number) && !self.waiting.is_empty() {
            self.recalled += 1;
            self.push(telemetry);
        }
    }

    /// Takes the frames that are in order, oldest first.
    pub fn drain(&mut self) -> impl Iterator<Item = Telemetry> + '_ {
        self.ready.drain(..)
    }

    /// Stops waiting for missing frames: the gaps stay.
    pub fn give_up(&mut self) {
        if let Some(newest) = self.newest() {
            self.skip_to(newest);
        }
    }

    /// How many frames are lost for good.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// How many missing frames were received on request.
    pub fn recalled(&self) -> u64 {
        self.recalled
    }

    /// The newest number that waits; waiting numbers are less than half the range of `u32` apart.
    fn newest(&self) -> Option<u32> {
        let next = self.next?;
        self.waiting.keys().copied().max_by_key(|number| number.wrapping_sub(next))
    }

    /// Gives up the frames before this number that are missing; those that wait are in order then. Takes as long as there are
    /// frames that wait, however far the numbers jump.
    fn skip_to(&mut self, number: u32) {
        let Some(next) = self.next else { return };
        let skipped = number.wrapping_sub(next);
        let mut before: Vec<u32> = self.waiting.keys().copied().collect();
        before.retain(|waits| waits.wrapping_sub(next) < skipped);
        before.sort_unstable_by_key(|waits| waits.wrapping_sub(next));
        self.lost += u64::from(skipped) - before.len() as u64;
        for waits in before {
            if let Some(telemetry) = self.waiting.remove(&waits) {
                self.deliver(telemetry);
            }
        }
        self.next = Some(number);
        self.release();
    }

    /// A frame that is older than the one before it came late, and its number is of another subscription.
    fn deliver(&mut self, telemetry: Telemetry) {
        if self.delivered_us.is_some_and(|before_us| telemetry.t_us <= before_us) {
            self.lost += 1;
            return;
        }
        self.delivered_us = Some(telemetry.t_us);
        self.ready.push_back(telemetry);
    }

    fn release(&mut self) {
        while let Some(next) = self.next
            && let Some(telemetry) = self.waiting.remove(&next)
        {
            self.deliver(telemetry);
            self.next = Some(next.wrapping_add(1));
        }
        while self.ready.len() > READY_MAX {
            self.ready.pop_front();
            self.lost += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use shared_proto::{PidTerms, Pose, PoseDeviation, State, WheelPair, WheelTelemetry};

    use super::*;

    fn frame(number: u32) -> Telemetry {
        let terms = PidTerms::default();
        let wheel = WheelTelemetry { terms, ..WheelTelemetry::default() };
        let wheels = WheelPair::both(wheel);
        // Rises where the numbers wrap.
        let t_us = u64::from(number.wrapping_add(1 << 31)) * 10_000;
        let pose = Pose::default();
        let (state, deviation) = (State::Idle, PoseDeviation::default());
        Telemetry { number, t_us, state, probing: false, wheels, supply_mv: 0, pose, deviation }
    }

    fn numbers(stream: &mut Stream) -> Vec<u32> {
        stream.drain().map(|frame| frame.number).collect()
    }

    #[test]
    fn a_frame_that_was_lost_comes_in_its_place() {
        let mut stream = Stream::default();
        for number in [5, 6, 8, 9] {
            stream.push(frame(number));
        }
        assert_eq!(numbers(&mut stream), [5, 6]);
        assert_eq!(stream.missing(0), Some(7));
        stream.mark_requested(7, 1, 0);
        assert_eq!((stream.missing(39_999), stream.missing(40_000)), (None, Some(7)));
        stream.fill_gap(frame(7));
        stream.fill_gap(frame(7));
        assert_eq!(numbers(&mut stream), [7, 8, 9]);
        assert_eq!((stream.missing(0), stream.lost(), stream.recalled()), (None, 0, 1));
    }

    #[test]
    fn a_frame_that_came_already_is_dropped() {
        let mut stream = Stream::default();
        for number in [5, 5, 7, 7, 6, 6, 5] {
            stream.push(frame(number));
        }
        assert_eq!(numbers(&mut stream), [5, 6, 7]);
    }

    #[test]
    fn what_the_robot_has_forgotten_is_counted_and_holds_nothing_up() {
        let mut stream = Stream::default();
        for number in [1, 4] {
            stream.push(frame(number));
        }
        stream.mark_requested(2, 10, 0);
        stream.mark_requested(2, 11, 40_000);
        stream.unavailable(10);
        stream.unavailable(11); // The second answer to the same request.
        assert_eq!((stream.missing(40_000), stream.lost()), (Some(3), 1));
        stream.mark_requested(3, 12, 40_000);
        stream.unavailable(12);
        assert_eq!((numbers(&mut stream), stream.lost()), (vec![1, 4], 2));
    }

    #[test]
    fn a_gap_older_than_the_robots_memory_is_not_asked_for() {
        let mut stream = Stream::default();
        stream.push(frame(0));
        stream.push(frame(100));
        // 100 - 31 is the oldest frame that the robot still has.
        assert_eq!((stream.missing(0), stream.lost()), (Some(69), 68));
        stream.restart();
        assert_eq!((numbers(&mut stream), stream.lost()), (vec![0, 100], 68));
    }

    /// Counting them one by one took two minutes for half the numbers.
    #[test]
    fn a_jump_of_the_numbers_takes_no_longer_than_a_step_and_loses_what_is_between() {
        let mut stream = Stream::default();
        let half = u32::MAX / 2;
        let mut number = 0_u32;
        stream.push(frame(number));
        for step in 1..=10_000 {
            number = number.wrapping_add(half);
            stream.push(Telemetry { t_us: step << 45, ..frame(number) });
            stream.give_up();
        }
        assert_eq!(stream.drain().count(), 10_001);
        assert_eq!(stream.lost(), 10_000 * u64::from(half - 1));
    }

    #[test]
    fn times_that_no_clock_shows_are_frames_like_any_other() {
        let mut stream = Stream::default();
        for (number, t_us) in [(0, 0), (1, u64::MAX - 9), (3, u64::MAX - 1), (4, u64::MAX)] {
            stream.push(Telemetry { t_us, ..frame(number) });
        }
        stream.give_up();
        assert_eq!(numbers(&mut stream), [0, 1, 3, 4]);
    }

    #[test]
    fn frames_that_waited_at_a_jump_come_in_order_and_are_not_lost() {
        let mut stream = Stream::default();
        for number in [u32::MAX - 4, u32::MAX - 1, 1, u32::MAX, 1000] {
            stream.push(frame(number));
        }
        assert_eq!(numbers(&mut stream), [u32::MAX - 4, u32::MAX - 1, u32::MAX, 1]);
        // 1000 - 31 is the oldest frame that the robot still has: two, 0 and 2 to 968 are lost.
        assert_eq!((stream.missing(0), stream.lost()), (Some(969), 2 + 1 + 967));
    }

    #[test]
    fn frames_that_nobody_takes_are_bounded_and_counted() {
        let mut stream = Stream::default();
        let most = READY_MAX as u32;
        (0..most + 100).for_each(|number| stream.push(frame(number)));
        assert_eq!(stream.lost(), 100);
        assert_eq!(stream.drain().next().unwrap().number, 100);
    }

    #[test]
    fn another_period_begins_the_numbers_anew() {
        let mut stream = Stream::default();
        let at = |number: u32, t_us: u64| Telemetry { t_us, ..frame(number) };
        // 10 ms, then 100 ms: the number is the time over the period.
        for t_us in [1_000_000, 1_010_000, 1_020_000] {
            stream.push(at((t_us / 10_000) as u32, t_us));
        }
        for t_us in [1_100_000, 1_200_000] {
            stream.push(at((t_us / 100_000) as u32, t_us));
        }
        // And back: no frame of the slow ones is missing.
        for t_us in [1_210_000, 1_220_000] {
            stream.push(at((t_us / 10_000) as u32, t_us));
        }
        assert_eq!(numbers(&mut stream), [100, 101, 102, 11, 12, 121, 122]);
        assert_eq!((stream.missing(0), stream.lost()), (None, 0));
    }

    #[test]
    fn a_tick_that_is_early_or_late_is_no_other_period() {
        let mut stream = Stream::default();
        // The control tick is 5 ms; each of these is up to 4 ms from where it should be, and two are lost.
        for (number, off_us) in [(1, 0), (2, 4_000), (3, -4_000), (6, -2_000), (7, 4_000)] {
            let t_us = (i64::from(number) * 10_000 + off_us) as u64;
            stream.push(Telemetry { t_us, ..frame(number as u32) });
        }
        assert_eq!(numbers(&mut stream), [1, 2, 3]);
        assert_eq!((stream.missing(0), stream.lost()), (Some(4), 0));
    }

    #[test]
    fn a_late_frame_of_an_earlier_subscription_is_dropped() {
        let mut stream = Stream::default();
        stream.restart();
        for (number, t_us) in [(3, 5_551_000), (20, 5_360_000), (4, 5_561_000)] {
            stream.push(Telemetry { t_us, ..frame(number) });
        }
        stream.give_up();
        assert_eq!(numbers(&mut stream), [3, 4]);
    }

    #[test]
    fn numbers_may_wrap() {
        let mut stream = Stream::default();
        for number in [u32::MAX - 1, 0, 2, 1, u32::MAX] {
            stream.push(frame(number));
        }
        assert_eq!(numbers(&mut stream), [u32::MAX - 1, u32::MAX, 0, 1, 2]);
    }
}
