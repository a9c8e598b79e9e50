//! The check on a wheel that follows the feedforward model.

use super::*;

const Q_M: f64 = core::f64::consts::TAU * 0.036 / 900.0;

/// What is connected wrongly.
#[derive(Clone, Copy, PartialEq)]
enum Wiring {
    Sound,
    Unplugged,
    Reversed,
    Blocked,
    BlockedAfterOneCount,
    /// The other line counts up and down by one.
    LineStuck,
    /// A line has a level by chance at every look.
    LineFloats,
    /// Interference counts forwards, or backwards, by more than a wheel can turn.
    Noisy(i64),
}

/// A wheel that takes the speed of the feedforward model at once: as far as any gets.
struct Bench {
    wiring: Wiring,
    travel_m: f64,
    looks: i64,
}

impl Bench {
    fn counts(&mut self) -> i64 {
        self.looks += 1;
        let counts = (self.travel_m / Q_M).round() as i64;
        match self.wiring {
            Wiring::Sound => counts,
            Wiring::Unplugged | Wiring::Blocked => 0,
            Wiring::Reversed => -counts,
            Wiring::BlockedAfterOneCount => counts.clamp(-1, 1),
            Wiring::LineStuck => counts >> 1 & 1,
            // A walk in both directions that gets away from where it began.
            Wiring::LineFloats => [0, -1, 0, -1, -2, -1, -2, -3, -2, -4][self.looks as usize % 10],
            Wiring::Noisy(rate) => counts + rate * self.looks,
        }
    }

    fn drive(&mut self, duty: f64) {
        if self.wiring != Wiring::Blocked {
            self.travel_m += duty.signum() * (duty.abs() - 0.04).max(0.0) / 2.0 / 1000.0;
        }
    }
}

/// Runs a probe; also tells its time in ticks and the farthest that a wheel got.
fn probe(
    config: &Config,
    directions: WheelPair<Direction>,
    wirings: WheelPair<Wiring>,
) -> (ProbeOutcome, u32, f64) {
    let mut bench = wirings.map(|wiring| Bench { wiring, travel_m: 0.0, looks: 0 });
    let mut probe = Probe::new(config, WheelPair::both(0), directions, false);
    for tick in 0.. {
        let counts = WheelPair::new(bench.left.counts(), bench.right.counts());
        let outcome = probe.step(counts);
        let ProbeOutcome::Running(duty) = outcome else {
            let farthest_m = bench.left.travel_m.abs().max(bench.right.travel_m.abs());
            return (outcome, tick, farthest_m);
        };
        assert!(duty.all(|d| d.to_si().abs() <= config.protection.probe_duty_max));
        bench.left.drive(duty.left.to_si());
        bench.right.drive(duty.right.to_si());
    }
    unreachable!()
}

const AHEAD: WheelPair<Direction> = WheelPair::both(Direction::Forward);

#[test]
fn sound_encoders_pass_in_every_direction_within_a_millimetre_or_two() {
    use Direction::{Backward, Forward, Still};
    for (left, right) in
        [(Forward, Forward), (Backward, Backward), (Forward, Backward), (Still, Forward)]
    {
        let (outcome, ticks, farthest_m) =
            probe(&Config::default(), WheelPair::new(left, right), WheelPair::both(Wiring::Sound));
        assert_eq!(outcome, ProbeOutcome::Done);
        // Edges lie half a count off the start: the third one at 2.5 counts, 0.6 mm.
        assert!((2.5 * Q_M..3.0 * Q_M).contains(&farthest_m), "{farthest_m}");
        assert!(ticks < 400, "{ticks}");
    }
}

#[test]
fn a_wheel_that_will_stand_still_is_neither_pushed_nor_judged() {
    let (outcome, ticks, _) =
        probe(&Config::default(), WheelPair::default(), WheelPair::both(Wiring::Unplugged));
    assert_eq!((outcome, ticks), (ProbeOutcome::Done, 0));
}

#[test]
fn each_wrong_wiring_is_named_before_10_mm_and_1500_ms_at_any_probe_duty() {
    for probe_duty_max in [0.02, 0.05, 0.1, 0.25, 0.5] {
        for stall_time_s in [0.01, 0.06, 0.09] {
            let mut config = Config::default();
            config.protection.probe_duty_max = probe_duty_max;
            config.protection.stall_time_s = stall_time_s;
            for (wiring, fault) in [
                (Wiring::Unplugged, Fault::NoResponse(Wheel::Right)),
                (Wiring::Reversed, Fault::EncoderReversed(Wheel::Right)),
                (Wiring::Blocked, Fault::NoResponse(Wheel::Right)),
                (Wiring::BlockedAfterOneCount, Fault::NoResponse(Wheel::Right)),
                (Wiring::LineStuck, Fault::EncoderDead(Wheel::Right)),
                (Wiring::LineFloats, Fault::EncoderDead(Wheel::Right)),
                (Wiring::Noisy(20), Fault::CountRate(Wheel::Right)),
                (Wiring::Noisy(-20), Fault::CountRate(Wheel::Right)),
            ] {
                // A probe this weak hardly turns the wheel, or not at all.
                let weak = probe_duty_max < 0.1;
                let moves = [Wiring::Reversed, Wiring::BlockedAfterOneCount, Wiring::LineStuck];
                if weak && moves.contains(&wiring) {
                    continue;
                }
                let wirings = WheelPair::new(Wiring::Sound, wiring);
                let directions = WheelPair::new(Direction::Still, Direction::Forward);
                let (outcome, ticks, farthest_m) = probe(&config, directions, wirings);
                assert_eq!(outcome, ProbeOutcome::Failed(fault), "{probe_duty_max} {stall_time_s}");
                // 7 mm by the model, at once at full speed; the plant lags behind and moves less.
                assert!(farthest_m < 0.0071 && ticks <= 1500, "{farthest_m} {ticks}");
            }
        }
    }
}

#[test]
fn one_unplugged_encoder_is_found_although_the_other_one_passes() {
    let wirings = WheelPair::new(Wiring::Unplugged, Wiring::Sound);
    let (outcome, ticks, _) = probe(&Config::default(), AHEAD, wirings);
    assert_eq!(outcome, ProbeOutcome::Failed(Fault::NoResponse(Wheel::Left)));
    assert!((100..600).contains(&ticks), "{ticks}");
}

#[test]
fn interference_on_the_wheel_that_is_not_pushed_is_not_taken_for_exchanged_encoders() {
    for rate in [20, -20, 60] {
        let wirings = WheelPair::new(Wiring::Sound, Wiring::Noisy(rate));
        let (outcome, ticks, _) = probe(&Config::default(), AHEAD, wirings);
        assert_eq!(outcome, ProbeOutcome::Failed(Fault::CountRate(Wheel::Right)), "{rate}");
        assert!(ticks < 5, "{ticks}");
    }
}

#[test]
fn one_loose_edge_is_not_taken_for_a_movement() {
    let left = WheelPair::new(Direction::Forward, Direction::Still);
    let mut probe = Probe::new(&Config::default(), WheelPair::both(0), left, false);
    // One jump of many counts: a single change, and none that a wheel made.
    for counts in [[40; 50], [41; 50], [42; 50]].concat() {
        assert!(matches!(probe.step(WheelPair::both(counts)), ProbeOutcome::Running(_)));
    }
    assert_eq!(probe.step(WheelPair::both(43)), ProbeOutcome::Done);
}

#[test]
fn interference_that_begins_between_two_ticks_is_not_taken_for_a_reversed_encoder() {
    for first in [0, -3, -4, -6, -10] {
        let mut probe = Probe::new(&Config::default(), WheelPair::both(0), AHEAD, false);
        let counts = (1..).map(|tick| WheelPair::new(first - 20 * tick, 0));
        // Two counts of the wheel itself before.
        let outcome = [0, 1, 2, 2 + first]
            .map(|left| WheelPair::new(left, 0))
            .into_iter()
            .chain(counts)
            .map(|counts| probe.step(counts))
            .find(|outcome| !matches!(outcome, ProbeOutcome::Running(_)));
        assert_eq!(outcome, Some(ProbeOutcome::Failed(Fault::CountRate(Wheel::Left))), "{first}");
    }
}

#[test]
fn wheels_that_roll_back_are_waited_for_and_not_called_reversed() {
    let counts_of = |tick: i64| -(tick.min(120) / 5);
    for rolling in [false, true] {
        let mut probe = Probe::new(&Config::default(), WheelPair::both(0), AHEAD, rolling);
        let outcome = (0..150)
            .map(|tick| probe.step(WheelPair::both(counts_of(tick))))
            .find(|outcome| matches!(outcome, ProbeOutcome::Failed(_)));
        assert_eq!(outcome.is_none(), rolling, "{outcome:?}");
    }
}

/// A push of the left motor moves the right count: the check of two wheels whose encoders are exchanged.
fn exchanged(interference: i64) -> (ProbeOutcome, f64) {
    let mut bench =
        WheelPair::both(()).map(|()| Bench { wiring: Wiring::Sound, travel_m: 0.0, looks: 0 });
    let mut probe = Probe::new(&Config::default(), WheelPair::both(0), AHEAD, false);
    for tick in 0.. {
        let counts =
            WheelPair::new(bench.right.counts(), bench.left.counts() + tick * interference);
        let outcome = probe.step(counts);
        let ProbeOutcome::Running(duty) = outcome else {
            return (outcome, bench.left.travel_m);
        };
        bench.left.drive(duty.left.to_si());
        bench.right.drive(duty.right.to_si());
    }
    unreachable!()
}

#[test]
fn counts_of_the_other_wheel_are_exchanged_encoders_unless_they_are_interference() {
    let (outcome, moved_m) = exchanged(0);
    assert_eq!(outcome, ProbeOutcome::Failed(Fault::EncodersExchanged(Wheel::Left)));
    assert!(moved_m < 0.001, "{moved_m}");
    // 50,000 counts a second: no wheel does that.
    let (outcome, moved_m) = exchanged(50);
    assert_eq!(outcome, ProbeOutcome::Failed(Fault::CountRate(Wheel::Right)));
    assert_eq!(moved_m, 0.0, "before any push");
}
