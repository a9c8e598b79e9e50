//! Two wheels on the closed loop, one of which something happens to.

use firmware::capture::Measured;
use firmware::encoder::SpeedEstimator;
use firmware::odometry::Odometry;
use firmware::pid::{self, Gains, PidState};
use firmware::profile::{Plan, Profile};
use firmware::protection::Protection;
use firmware::supply::UNSCALED;
use shared_proto::{Config, Drive, Fault, Wheel, WheelPair};

/// What happens to the left wheel at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mishap {
    None,
    /// The count stays what it is.
    EncoderUnplugged,
    /// The first line is high or low from here on: the other one counts up and down by one.
    LineStuck(bool),
    /// The first line has a level by chance at every look: the count trembles, and each edge of the other one counts a way by
    /// chance.
    LineFloats,
    /// The first line changes by chance, so often a second on average \[Hz\].
    LineChangesAt(f64),
    /// The first line follows the mains, with a level by chance where it is near the threshold.
    LineHums,
    /// Both lines have a level by chance at every look.
    BothLinesFloat,
    /// Both lines change by chance, each so often a second on average \[Hz\].
    BothLinesChangeAt(f64),
    /// The count runs backwards from here on.
    EncoderReversed,
    /// Brakes take this much speed a second, until the wheel stands for good \[m/s^2\].
    Blocked(f64),
    /// The wheel is held to this share of its speed.
    Creeping(f64),
    /// Somebody pushes it, with what would give it this acceleration \[m/s^2\], for so long \[ms\].
    Shoved(f64, u32),
    /// The count jumps.
    Glitch(i64),
    /// A sound wheel on a sound encoder shakes by so much, so often a second \[m, Hz\].
    Shakes(f64, f64),
    /// No current reaches the motor: friction alone slows it down.
    LeadCut,
}

/// What a wheel and its motor are like.
#[derive(Clone, Copy, Debug)]
pub struct Motor {
    /// Duty to overcome friction.
    pub friction: f64,
    /// Duty per speed \[s/m\].
    pub duty_per_mps: f64,
    pub time_constant_s: f64,
}

/// A wheel on the closed loop: first-order motor with friction, quantised encoder.
struct Bench {
    travel_m: f64,
    speed_mps: f64,
    counts: i64,
    offset: f64,
    sign: f64,
    /// The levels of two lines of which the first one floats; and chance.
    lines: [bool; 2],
    noise: u64,
    /// Of a hand that pushes.
    shoved_ms: u32,
    /// So long a wheel has shaken, and a line has picked up the mains.
    shaken_s: f64,
    hummed_s: f64,
    motor: Motor,
    pid: PidState,
    estimator: SpeedEstimator,
}

/// A tenth off the configured feedforward.
pub const MOTOR: Motor = Motor { friction: 0.044, duty_per_mps: 1.85, time_constant_s: 0.06 };

impl Bench {
    fn physics(&mut self, duty: f64, mishap: Mishap) {
        let Motor { friction: friction_max, duty_per_mps, time_constant_s } = self.motor;
        let hand = match mishap {
            Mishap::Shoved(mps2, ms) if self.shoved_ms < ms => {
                self.shoved_ms += 1;
                mps2 * duty_per_mps * time_constant_s
            }
            _ => 0.0,
        };
        // Ten steps a tick.
        for _ in 0..10 {
            let push = match mishap {
                Mishap::LeadCut => 0.0,
                _ => duty + hand - duty_per_mps * self.speed_mps,
            };
            let friction = if self.speed_mps == 0.0 {
                push.clamp(-friction_max, friction_max)
            } else {
                friction_max * self.speed_mps.signum()
            };
            let mut next =
                self.speed_mps + (push - friction) / duty_per_mps / time_constant_s * 1e-4;
            if next * self.speed_mps < 0.0 {
                next = 0.0
            }
            match mishap {
                Mishap::Blocked(deceleration) => {
                    next = self.speed_mps.signum()
                        * (self.speed_mps.abs() - deceleration * 1e-4).max(0.0);
                }
                Mishap::Creeping(limit_mps) => next = next.clamp(-limit_mps, limit_mps),
                _ => {}
            }
            self.speed_mps = next;
            self.travel_m += next * 1e-4;
        }
    }

    fn read(&mut self, q_m: f64, mishap: Mishap, began: bool) {
        if mishap == Mishap::EncoderReversed && began {
            // Continues from the same count.
            self.offset += 2.0 * self.travel_m / q_m;
            self.sign = -1.0;
        }
        match mishap {
            Mishap::EncoderUnplugged => {}
            Mishap::LineStuck(high) => self.decode(q_m, began, |_, [_, b]| [high, b]),
            Mishap::LineFloats => self.decode(q_m, began, |bench, [_, b]| [bench.toss(), b]),
            Mishap::LineChangesAt(hz) => self.decode(q_m, began, |bench, [_, b]| {
                let [a, _] = bench.lines;
                [a != bench.chance(hz), b]
            }),
            Mishap::LineHums => self.decode(q_m, began, |bench, [_, b]| [bench.hum(), b]),
            Mishap::BothLinesFloat => {
                self.decode(q_m, began, |bench, _| [bench.toss(), bench.toss()]);
            }
            Mishap::BothLinesChangeAt(hz) => self.decode(q_m, began, |bench, _| {
                let [a, b] = bench.lines;
                [a != bench.chance(hz), b != bench.chance(hz)]
            }),
            Mishap::Shakes(by_m, hz) => {
                // Out of step with the ticks.
                self.shaken_s += 1e-3;
                let shake_m = by_m * (std::f64::consts::TAU * hz * self.shaken_s).sin();
                self.counts = ((self.travel_m + shake_m) / q_m + self.offset).round() as i64;
            }
            Mishap::Glitch(counts) if began => self.counts += counts,
            _ => self.counts = (self.sign * self.travel_m / q_m + self.offset).round() as i64,
        }
    }

    /// A level by chance.
    fn toss(&mut self) -> bool {
        self.uniform() < 0.5
    }

    /// Whether it happens at this look, if it happens so often a second.
    fn chance(&mut self, hz: f64) -> bool {
        self.uniform() < hz * 1e-3 / f64::from(LOOKS)
    }

    /// A line that picks up the mains, and a tenth as much noise.
    fn hum(&mut self) -> bool {
        self.hummed_s += 1e-3 / f64::from(LOOKS);
        let noise = 0.2 * (self.uniform() - 0.5);
        (std::f64::consts::TAU * 50.0 * self.hummed_s).sin() + noise > 0.0
    }

    /// A number by chance, from 0 to 1 (SplitMix64).
    fn uniform(&mut self) -> f64 {
        self.noise = self.noise.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.noise ^ (self.noise >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) as f64 / 2f64.powi(64)
    }

    /// Counts as a decoder does. `seen`: the levels, of those that the wheel makes.
    fn decode(&mut self, q_m: f64, began: bool, seen: impl Fn(&mut Self, [bool; 2]) -> [bool; 2]) {
        let place = |travel_m: f64| travel_m / q_m + self.offset;
        let (from, to) = (place(self.travel_m - self.speed_mps * 1e-3), place(self.travel_m));
        if began {
            self.lines = levels(self.counts);
            // Another one for every place.
            self.noise = self.travel_m.to_bits();
        }
        for look in 1..=LOOKS {
            let at = from + (to - from) * f64::from(look) / f64::from(LOOKS);
            let levels = seen(self, levels(at.round() as i64));
            for (line, level) in levels.into_iter().enumerate() {
                if self.lines[line] != level {
                    self.lines[line] = level;
                    self.counts += decoded(self.lines, line == 0);
                }
            }
        }
    }
}

/// Looks at the levels in a tick, between which a line that floats may change.
const LOOKS: u32 = 20;

/// The levels at a count; the first line leads while it rises.
fn levels(count: i64) -> [bool; 2] {
    let quarter = count.rem_euclid(4);
    [quarter == 1 || quarter == 2, quarter >= 2]
}

/// The count of a decoder that sees one line change: which way, the other one tells.
fn decoded([a, b]: [bool; 2], first: bool) -> i64 {
    if (a != b) == first { 1 } else { -1 }
}

/// Drives; answers the fault and its time after the mishap [ms], which comes at `mishap_ms`.
pub fn run(
    config: &Config,
    drives: &[Drive],
    mishap: Mishap,
    mishap_ms: u32,
    after_ms: u32,
) -> Option<(Fault, u32)> {
    run_motor(MOTOR, config, drives, mishap, mishap_ms, after_ms)
}

/// The same with other motors.
pub fn run_motor(
    motor: Motor,
    config: &Config,
    drives: &[Drive],
    mishap: Mishap,
    mishap_ms: u32,
    after_ms: u32,
) -> Option<(Fault, u32)> {
    let found = run_and_measure(motor, config, drives, mishap, mishap_ms, after_ms);
    found.map(|(fault, named_ms, _)| (fault, named_ms))
}

/// The same, and how far the wheel rolled from the mishap until the fault \[m\].
pub fn run_and_measure(
    motor: Motor,
    config: &Config,
    drives: &[Drive],
    mishap: Mishap,
    mishap_ms: u32,
    after_ms: u32,
) -> Option<(Fault, u32, f64)> {
    run_from(0.3, motor, config, drives, (mishap, mishap_ms), after_ms)
}

/// The same from so many counts ahead of the setpoint.
pub fn run_from(
    ahead_counts: f64,
    motor: Motor,
    config: &Config,
    drives: &[Drive],
    mishap: (Mishap, u32),
    after_ms: u32,
) -> Option<(Fault, u32, f64)> {
    let (fault, rolled_m) = drive_out(ahead_counts, motor, config, drives, mishap, after_ms);
    fault.map(|(fault, named_ms)| (fault, named_ms, rolled_m))
}

/// The same; how far the wheel rolled from the mishap until a fault, or, without one, until the end \[m\].
pub fn drive_out(
    ahead_counts: f64,
    motor: Motor,
    config: &Config,
    drives: &[Drive],
    (mishap, mishap_ms): (Mishap, u32),
    after_ms: u32,
) -> (Option<(Fault, u32)>, f64) {
    let odometry = Odometry::new(config);
    let gains = Gains::new(config, Wheel::Left);
    let mut benches = odometry.meters_per_count().map(|q| Bench {
        travel_m: 0.0,
        speed_mps: 0.0,
        counts: ahead_counts.round() as i64,
        offset: ahead_counts,
        sign: 1.0,
        lines: [false; 2],
        noise: 1,
        shoved_ms: 0,
        shaken_s: 0.0,
        hummed_s: 0.0,
        motor,
        pid: PidState::default(),
        estimator: SpeedEstimator::new(q, ahead_counts.round() as i64),
    });
    let mut profile = Profile::new(Plan::hold(WheelPair::default()));
    let mut protection = Protection::new(config);
    let mut coming = drives.iter();
    let mut rest_until = 0;
    let mut mishap_m = 0.0;
    for tick in 0.. {
        if profile.finished(tick) && tick >= rest_until {
            match coming.next() {
                Some(drive) => {
                    let plan = Plan::drive(tick, profile.at(tick), drive, config).unwrap();
                    rest_until = plan.end_tick() + after_ms;
                    profile.replace(&plan);
                }
                None => return (None, (benches.left.travel_m - mishap_m).abs()),
            }
        }
        let setpoints = profile.setpoints(tick);
        let counts = WheelPair::new(benches.left.counts, benches.right.counts);
        let travel = odometry.travel(counts);
        let q = odometry.meters_per_count();
        let step = |bench: &mut Bench, setpoint, travel, q_m, mishap| {
            let speed = bench.estimator.step(tick, bench.counts);
            let duty = pid::step(&gains, &mut bench.pid, &setpoint, travel, speed, UNSCALED);
            bench.physics(duty.to_si(), mishap);
            bench.read(q_m, mishap, tick == mishap_ms);
        };
        if tick == mishap_ms {
            mishap_m = benches.left.travel_m;
        }
        let now = if tick >= mishap_ms { mishap } else { Mishap::None };
        step(&mut benches.left, setpoints.left, travel.left, q.left.to_si(), now);
        let none = Mishap::None;
        step(&mut benches.right, setpoints.right, travel.right, q.right.to_si(), none);
        let loops = WheelPair::new(benches.left.pid, benches.right.pid);
        let speed = WheelPair::default();
        let measured = Measured { tick, t_us: u64::from(tick) * 1000, counts, travel, speed };
        if let Some(fault) = protection.step(&setpoints, &measured, &loops, UNSCALED) {
            let rolled_m = (benches.left.travel_m - mishap_m).abs();
            return (Some((fault, tick.wrapping_sub(mishap_ms))), rolled_m);
        }
    }
    unreachable!()
}

/// How far wheels rolled \[mm\], in the middle of the cases and in the worst one, is less than this.
pub fn assert_rolled_less(what: &str, mut rolled_mm: Vec<f64>, (median, most): (f64, f64)) {
    rolled_mm.sort_by(f64::total_cmp);
    let (median_mm, farthest_mm) = (rolled_mm[rolled_mm.len() / 2], rolled_mm[rolled_mm.len() - 1]);
    println!("{what}: {median_mm:.1} mm, at most {farthest_mm:.1} mm");
    assert!(median_mm < median, "{what}: {median_mm}");
    assert!(farthest_mm < most, "{what}: {farthest_mm}");
}
