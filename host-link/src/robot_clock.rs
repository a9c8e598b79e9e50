//! The robot's clock as the host knows it, and the leases that it gives by it.

use std::collections::VecDeque;
use std::time::Duration;

/// What is known widens by one part in this many: ten times as much as two crystals differ.
const DRIFT: u64 = 1000;

/// A frame arrives at most so long after it was made \[us\].
const DELAY_US_MAX: i64 = 1_000_000;

/// So many requests are remembered, to know when one was sent whose reply arrives.
const SENT_MAX: usize = 32;

/// Between what the robot's clock minus ours lies, as heard at a time of ours \[us\].
#[derive(Clone, Copy, Debug)]
struct Offset {
    least_us: i64,
    most_us: i64,
    at_us: u64,
}

/// What the robot's clock shows, from the times in its frames.
///
/// A frame was made before it arrived, and a reply after its request was sent: each bounds the difference of the
/// clocks from one side. A lease is given by the lower bound, so it ends rather too early than too late, by the
/// time that the quickest frame took. Where the bounds contradict each other, the robot's clock does not run as
/// ours does (an emulated robot's may crawl), and the newest reply alone counts.
#[derive(Clone, Debug, Default)]
pub(crate) struct RobotClock {
    offset: Option<Offset>,
    /// Requests by id, and when each was sent first \[us\].
    sent: VecDeque<(u32, u64)>,
}

impl RobotClock {
    /// A request is sent now; copies that follow do not count.
    pub fn send(&mut self, id: u32, now_us: u64) {
        if self.sent.iter().any(|(sent, _)| *sent == id) {
            return;
        }
        if self.sent.len() == SENT_MAX {
            self.sent.pop_front();
        }
        self.sent.push_back((id, now_us));
    }

    /// A frame of this time of the robot's clock arrives now; for a reply, with its request's id.
    pub fn hear(&mut self, robot_us: u64, reply_to: Option<u32>, now_us: u64) {
        let minus = |us: u64| (robot_us as i64).wrapping_sub(us as i64);
        let sent = reply_to.and_then(|id| self.sent.iter().find(|(sent, _)| *sent == id));
        let most_us = sent.map_or(i64::MAX, |(_, sent_us)| minus(*sent_us));
        let new = Offset { least_us: minus(now_us), most_us, at_us: now_us };
        let both = self.offset_at(now_us).map(|known| Offset {
            least_us: known.least_us.max(new.least_us),
            most_us: known.most_us.min(new.most_us),
            at_us: now_us,
        });
        self.offset = Some(both.filter(|both| both.least_us <= both.most_us).unwrap_or(new));
    }

    /// Whether a time of the robot's clock that arrives now is that of the clock that was heard before: a restart sets it
    /// to zero.
    pub fn goes_on(&self, robot_us: u64, now_us: u64) -> bool {
        let offset_us = (robot_us as i64).wrapping_sub(now_us as i64);
        self.offset_at(now_us)
            .is_some_and(|known| offset_us >= known.least_us.saturating_sub(DELAY_US_MAX))
    }

    /// When a lease of this length ends that is given now, on the robot's clock \[ms\]. Before the robot was heard
    /// that is too early for any robot, which then refuses and tells its time.
    pub fn lease_end_ms(&self, lease: Duration, now_us: u64) -> u64 {
        let Some(offset) = self.offset_at(now_us) else { return 0 };
        let given_us = (now_us as i64).wrapping_add(offset.least_us);
        u64::try_from(given_us.wrapping_add(lease.as_micros() as i64)).unwrap_or(0) / 1000
    }

    fn offset_at(&self, now_us: u64) -> Option<Offset> {
        self.offset.map(|Offset { least_us, most_us, at_us }| {
            let drift_us = (now_us.saturating_sub(at_us) / DRIFT) as i64;
            Offset {
                least_us: least_us.saturating_sub(drift_us),
                most_us: most_us.saturating_add(drift_us),
                at_us,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEASE: Duration = Duration::from_millis(200);

    /// How much too late the leases of a minute end at most, and too early \[ms\], where the robot's clock runs at this
    /// rate. Telemetry takes up to 180 ms, as on a line that it fills, and a request and its reply up to 20 and 150 ms.
    fn errors_ms(rate: f64) -> (f64, f64) {
        let robot_us = |us: u64| (us as f64 * rate) as u64 + 7_000_000;
        let mut frames = Vec::new();
        for step in 0..12_000_u64 {
            let now_us = 100_000 + step * 5000;
            let random = step.wrapping_mul(2_654_435_761) >> 7;
            frames.push((now_us + 90_000 + random % 90_000, robot_us(now_us), None));
            if step % 6 == 0 {
                let replied_us = now_us + 2000 + random % 18_000;
                let arrives_us = replied_us + 5000 + random % 145_000;
                frames.push((arrives_us, robot_us(replied_us), Some((step as u32, now_us))));
            }
        }
        frames.sort_unstable();
        let mut clock = RobotClock::default();
        let (mut late_ms, mut early_ms) = (f64::MIN, f64::MIN);
        for (arrives_us, time_us, reply) in frames {
            // Sent earlier, but nothing is asked of the clock in between.
            if let Some((id, sent_us)) = reply {
                clock.send(id, sent_us);
            }
            clock.hear(time_us, reply.map(|(id, _)| id), arrives_us);
            let end_ms = clock.lease_end_ms(LEASE, arrives_us) as f64;
            let error_ms = end_ms - (robot_us(arrives_us) + 200_000) as f64 * 1e-3;
            (late_ms, early_ms) = (late_ms.max(error_ms), early_ms.max(-error_ms));
        }
        (late_ms, early_ms)
    }

    #[test]
    fn a_lease_ends_no_later_than_its_length_after_it_was_given_and_not_much_earlier() {
        for rate in [0.9995, 0.9999, 1.0, 1.0001, 1.0005] {
            let (late_ms, early_ms) = errors_ms(rate);
            println!("rate {rate}: {late_ms:.1} ms late, {early_ms:.1} ms early at most");
            // Early at first, before a quick reply has been heard.
            assert!(late_ms <= 0.0 && early_ms <= 200.0, "{rate}: {late_ms} {early_ms}");
        }
    }

    #[test]
    fn a_clock_that_runs_at_another_rate_makes_a_lease_late_by_no_more_than_an_exchange_takes() {
        for rate in [0.1, 0.3, 0.9, 0.99, 1.01, 1.5] {
            let (late_ms, _) = errors_ms(rate);
            println!("rate {rate}: {late_ms:.1} ms late at most");
            assert!(late_ms <= 170.0, "{rate}: {late_ms}");
        }
    }

    #[test]
    fn a_clock_that_goes_on_is_told_from_one_that_began_anew() {
        let mut clock = RobotClock::default();
        assert!(!clock.goes_on(5_000_000, 90_000_000), "nothing is known");
        clock.send(1, 89_999_000);
        clock.hear(5_000_000, Some(1), 90_000_000);
        assert!(clock.goes_on(7_000_000, 92_000_000));
        assert!(clock.goes_on(6_600_000, 92_000_000), "a frame that was held back");
        assert!(!clock.goes_on(300_000, 92_000_000), "a restart");
    }

    #[test]
    fn before_the_robot_was_heard_every_lease_has_ended() {
        assert_eq!(RobotClock::default().lease_end_ms(LEASE, 5_000_000), 0);
    }
}
