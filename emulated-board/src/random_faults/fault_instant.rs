//! What the robot was doing when a fault happened, on which the fault's name and its bound depend.

use shared_proto::{Fault, Wheel, WheelPair};

use super::bound::{MotorsOff, Name};
use super::draw::{Case, Phase};
use super::observed::{Happened, Timeline};

/// What the robot was doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Situation {
    /// No motion has begun yet; the encoder check may be under way.
    Before,
    /// The wheels follow a motion, or brake.
    Moving,
    /// It is armed and stands.
    Rest,
    /// The host has disarmed it.
    Over,
    /// A fault is latched.
    Latched,
}

/// An instant of a case.
#[derive(Clone, Copy, Debug)]
pub struct FaultInstant {
    /// What the robot was doing.
    pub situation: Situation,
    at_us: u64,
    opened_us: u64,
    armed_us: u64,
    commanded_us: u64,
    /// A motion follows that starts from rest.
    moves_later: bool,
    /// The host has told the robot to stop.
    stopping: bool,
    /// Time until the slower wheel's setpoint has advanced by [`SHOWN_M`] or [`FEW_COUNTS`] \[ms\].
    shown_ms: Option<f64>,
    /// Time until the motion is over and has settled \[ms\].
    end_ms: f64,
    /// Time until the setpoint brakes, below zero once it does \[ms\].
    brakes_ms: f64,
    /// The wheels' setpoints \[m/s\].
    speed_mps: WheelPair<f64>,
    /// How far the wheels were from their setpoints at last \[um\].
    error_um: WheelPair<i32>,
    /// What drove them then \[1/32767\].
    duty: WheelPair<i16>,
    /// How far the wheels have turned since the motion began; not at all before it \[m\].
    turned_m: WheelPair<f64>,
    /// Travel in a count \[m\].
    count_m: f64,
    /// What the check takes friction for, as a multiple of what it is.
    ks_times: f64,
    /// The gains are not the factory's.
    is_soft: bool,
    /// How much faster than its setpoint a wheel turns whose count stands \[m/s\].
    creeps_mps: f64,
    /// Of the motion \[m/s^2\].
    acceleration_mps2: f64,
}

/// By then every rule about a moving setpoint has enough: 2 mm, and 15 % of the permitted following error with
/// a setpoint half as fast \[m\]; or four counts, and parts of two.
const SHOWN_M: f64 = 0.004;
/// Four counts and parts of two: so few do not tell what is at fault.
const FEW_COUNTS: f64 = 6.0;
/// A wheel as slow as this may stand within three counts of 0.25 mm when its motor loses a lead: 62 mm/s over the last three
/// counts, and what it speeds up meanwhile \[m/s\]. It grows with the root of a count.
const SLOW_MPS: f64 = 0.075;
const SLOW_COUNT_M: f64 = 0.25e-3;
/// What a wheel may turn without a count that can be trusted (`firmware/control/src/protection`), or six counts in the check
/// \[mm\].
const BLIND_MM: f64 = 10.0;
/// The check keeps it up to so many times the friction that the wheel has; docs/safety.md.
const KS_TIMES: f64 = 2.5;
/// In a drive, with counts longer than this, so far and nine counts (docs/safety.md, long counts) \[m, mm\].
const LONG_COUNT_M: f64 = 0.6e-3;
const LONG_COUNTS_MM: f64 = 14.0;
const LONG_COUNTS: f64 = 9.0;
/// The stall time, and a look at it \[ms\].
const STALL_MS: f64 = 70.0;
/// The times of the host's looks at the robot, ticks of planning, and a settled wheel's 250 ms \[ms\].
const END_MS: f64 = 290.0;
/// Shorter than this before the end of a motion a silent host may not be noticed any more, and may be still \[ms\].
const SILENCE_MS: f64 = 200.0;
/// What the host's view of an instant may be off by: a frame of telemetry, and ten ticks of planning \[ms\].
const VIEW_MS: f64 = 25.0;
/// A host that dies may still send what it has begun to write \[ms\].
const SENDS_MS: f64 = 1.0;
/// What the firmware takes for arrived after all, if no fault is to be raised \[um\].
const ARRIVED_UM: u32 = 2000;
/// The duty, 0.1 above ks, from which the firmware takes a wheel that stands off its target for stalled \[1/32767\].
const PUSHES: u16 = 4600;
/// The firmware's tasks look at their inputs from then on \[us\].
const STARTED_US: u64 = 40_000;

/// The firmware has read why it started by then \[us\].
const POWER_ON_US: u64 = 1_000;

/// The host says hello then \[us\].
pub const HELLO_US: u64 = 5_000;

impl FaultInstant {
    pub(super) fn new(case: &Case, timeline: &Timeline, happened: &Happened) -> Self {
        let at_us = happened.at_us;
        let before = |t: Option<u64>| t.is_some_and(|t| t <= at_us);
        let begun = timeline.tracks_us.iter().rfind(|begin| **begin <= at_us).copied();
        let moves_later = timeline.tracks_us.iter().any(|begin| *begin > at_us);
        let stopping = before(timeline.stop_us);
        let motion = Progress::new(case, begun.unwrap_or(0), timeline.stop_us);
        let end_us = motion.end_us() + END_MS * 1000.0;
        let situation = if before(timeline.latched_us) {
            Situation::Latched
        } else if before(timeline.over_us) {
            Situation::Over
        } else if begun.is_none() {
            Situation::Before
        } else if (at_us as f64) < end_us {
            Situation::Moving
        } else {
            Situation::Rest
        };
        Self {
            situation,
            at_us,
            opened_us: timeline.opened_us.unwrap_or(u64::MAX),
            armed_us: timeline.armed_us.unwrap_or(u64::MAX),
            commanded_us: timeline.commanded_us.unwrap_or(u64::MAX),
            moves_later: moves_later || case.phase == Phase::Standing,
            stopping,
            shown_ms: motion
                .shown_us(at_us, SHOWN_M.max(FEW_COUNTS * case.count_m()))
                .map(|us| (us - at_us as f64) / 1000.0),
            end_ms: (end_us - at_us as f64) / 1000.0,
            brakes_ms: (motion.brakes_us() - at_us as f64) / 1000.0,
            speed_mps: motion.wheels_mps(at_us as f64),
            error_um: timeline.error_um,
            duty: timeline.duty,
            turned_m: turned_m(timeline, happened),
            count_m: case.count_m(),
            ks_times: case.ks_times(),
            is_soft: case.has_other_gains(),
            creeps_mps: case.creeps_mps(),
            acceleration_mps2: case.motion.acceleration,
        }
    }

    /// For a wheel that may turn freely from here on: its setpoint's speed, if that brakes within this time or brakes already
    /// \[m/s\].
    pub fn rolls_out(&self, wheel: Wheel, within_ms: f64) -> Option<f64> {
        let brakes = self.situation == Situation::Moving && self.brakes_ms < within_ms;
        brakes.then(|| *self.speed_mps.get(wheel))
    }

    /// Whether the wheel ended so near its setpoint that nothing was missing, or ahead of it, and was not pushed back: then
    /// the integral of before still holds against it.
    pub fn arrived(&self, wheel: Wheel) -> bool {
        let error_um = *self.error_um.get(wheel);
        let near = error_um.unsigned_abs() < ARRIVED_UM;
        // A soft loop may not push a wheel that stands behind either, as friction holds it too.
        let ahead = self.is_soft || f64::from(error_um) * self.speed_mps.get(wheel) < 0.0;
        let pushed = self.duty.get(wheel).unsigned_abs() >= PUSHES;
        self.situation == Situation::Moving && (near || (ahead && !pushed))
    }

    /// Whether the robot had answered no hello yet, and the host armed it later: what restarts it now, the host never knows of.
    pub fn is_before_the_host(&self) -> bool {
        self.at_us < self.opened_us && self.armed_us != u64::MAX
    }

    /// Whether the motors were off, so that the core could stand as long as it liked.
    pub fn motors_are_off(&self) -> bool {
        self.situation == Situation::Over
            || self.situation == Situation::Before && self.at_us < self.armed_us
    }

    /// Whether what began before, and lasts so long \[ms\], is still there when the host arms the robot.
    pub fn lasts_when_armed(&self, ms: f64) -> bool {
        let at_ms = self.at_us as f64 / 1000.0;
        (at_ms..=at_ms + ms).contains(&(self.armed_us as f64 / 1000.0))
    }

    /// Whether the program has hardly begun to run.
    pub fn is_at_power_on(&self) -> bool {
        self.at_us < POWER_ON_US
    }

    /// For what shows when a wheel has to move: `bound` makes a bound of a time, and of the way that the wheel may
    /// turn if its setpoint does not move yet \[mm\].
    pub fn of_wheel(
        &self,
        within_ms: f64,
        bound: fn(f64, Option<f64>) -> MotorsOff,
        mut names: Vec<Name>,
    ) -> (MotorsOff, Vec<Name>) {
        match (self.situation, self.shown_ms) {
            (Situation::Moving, Some(shown_ms)) => {
                let ms = within_ms.max(shown_ms + STALL_MS);
                // A motion about to end, or from rest, is seen by the way.
                let way_mm = self.blind_mm() + self.creeps_mps * ms;
                (bound(ms, (shown_ms >= within_ms).then_some(way_mm)), names)
            }
            // The setpoint advances no more, or not far enough.
            (Situation::Moving, None) if !self.moves_later => {
                names.push(Name::Harmless);
                let ms = self.end_ms + VIEW_MS;
                (MotorsOff::WithinOrTravel(ms, self.blind_mm() + self.creeps_mps * ms), names)
            }
            (Situation::Rest, _) if !self.moves_later => {
                (MotorsOff::NotNeeded, vec![Name::Harmless])
            }
            (Situation::Over, _) => (MotorsOff::NotNeeded, vec![Name::Harmless]),
            // No motion was ever commanded, because the host could not.
            _ if self.commanded_us == u64::MAX => (MotorsOff::NotNeeded, vec![Name::Harmless]),
            // From rest, until the setpoint has gone far enough.
            _ => {
                let shown_ms = 1000.0 * (2.0 * SHOWN_M / self.acceleration_mps2).sqrt();
                let moving = self.situation == Situation::Moving;
                let creeps_mps = if moving { self.creeps_mps } else { 0.0 };
                let way_mm = self.blind_mm() + creeps_mps * (shown_ms + STALL_MS);
                (bound(within_ms, Some(way_mm)), names)
            }
        }
    }

    /// Whether the setpoint is about to rest, and advances no more by as much as tells what a wheel does.
    pub fn comes_to_rest(&self) -> bool {
        self.situation == Situation::Moving && self.shown_ms.is_none()
    }

    /// What a wheel may turn without a count that can be trusted \[mm\].
    fn blind_mm(&self) -> f64 {
        let count_mm = 1000.0 * self.count_m;
        match self.situation {
            // The check did not name it: it had passed already.
            Situation::Before if !self.moves_later => BLIND_MM.max(FEW_COUNTS * count_mm),
            // A check that takes friction for more than it is lets the wheel turn as much sooner.
            Situation::Before if self.count_m <= LONG_COUNT_M => {
                BLIND_MM * (self.ks_times / KS_TIMES).max(1.0)
            }
            _ if self.count_m > LONG_COUNT_M => LONG_COUNTS_MM + LONG_COUNTS * count_mm,
            _ => BLIND_MM,
        }
    }

    /// Whether its counts do not tell why they end: the wheel stands, and is driven from rest next; or its count has changed
    /// only by a few since it was; or it is slow.
    pub fn counts_tell_nothing(&self, wheel: Wheel) -> bool {
        let stands = self.moves_later && self.shown_ms.is_none();
        let turns = self.situation == Situation::Moving && !stands;
        !turns
            || *self.turned_m.get(wheel) < FEW_COUNTS * self.count_m
            || self.reached_mps(wheel) < SLOW_MPS * (self.count_m / SLOW_COUNT_M).sqrt()
    }

    /// The wheel's speed: its setpoint's, but no more than it can have reached on its way, as it lags behind \[m/s\].
    fn reached_mps(&self, wheel: Wheel) -> f64 {
        let by_way = (2.0 * self.acceleration_mps2 * self.turned_m.get(wheel)).sqrt();
        self.speed_mps.get(wheel).min(by_way)
    }

    /// For what is looked at while the robot is armed.
    pub fn if_armed(&self, fault: Fault) -> Vec<Name> {
        match self.situation {
            Situation::Over => vec![Name::Harmless, Name::Fault(fault)],
            // The host died, or its commands never arrived.
            _ if self.armed_us == u64::MAX => vec![Name::Harmless],
            _ => vec![Name::Fault(fault)],
        }
    }

    /// For what is named unless it is over before the program has started.
    pub fn unless_over(&self, fault: Fault, lasts_ms: f64) -> Vec<Name> {
        let mut names = vec![Name::Fault(fault)];
        if self.at_us as f64 + lasts_ms * 1000.0 < STARTED_US as f64 {
            names.push(Name::Harmless);
        }
        names
    }

    /// For a silent host: only a motion needs one.
    pub fn if_host_is_needed(&self, fault: Fault) -> Vec<Name> {
        let mut names = self.if_renewals_are_needed(fault);
        let commanded_ms = (self.at_us as f64 - self.commanded_us as f64) / 1000.0;
        if self.situation == Situation::Before && commanded_ms < -SENDS_MS {
            names = vec![Name::Harmless];
        } else if self.situation == Situation::Before && commanded_ms < VIEW_MS {
            // The command is on its way, or goes out yet.
            names.push(Name::Harmless);
        } else if self.situation == Situation::Rest {
            names = vec![Name::Harmless];
        }
        names
    }

    /// For a host that talks and renews no motion.
    pub fn if_renewals_are_needed(&self, fault: Fault) -> Vec<Name> {
        match self.situation {
            // The last word was up to 30 ms before; and a stop brings itself to its end.
            Situation::Moving if self.stopping => vec![Name::Harmless],
            Situation::Moving if self.end_ms < SILENCE_MS + END_MS + VIEW_MS => {
                vec![Name::Fault(fault), Name::Harmless]
            }
            Situation::Rest if !self.moves_later => vec![Name::Harmless],
            Situation::Over => vec![Name::Harmless],
            _ => vec![Name::Fault(fault)],
        }
    }

    /// For a late control tick, which is a fault while the motors are on.
    pub fn if_motors_are_on(&self, fault: Fault) -> Vec<Name> {
        let armed_ms = (self.at_us as f64 - self.armed_us as f64) / 1000.0;
        match self.situation {
            Situation::Over => vec![Name::Harmless, Name::Fault(fault)],
            Situation::Before if armed_ms < -VIEW_MS => vec![Name::Harmless],
            Situation::Before if armed_ms < VIEW_MS => vec![Name::Harmless, Name::Fault(fault)],
            _ => vec![Name::Fault(fault)],
        }
    }
}

fn turned_m(timeline: &Timeline, happened: &Happened) -> WheelPair<f64> {
    // The robot takes both wheels for equal.
    let radius_m = shared_proto::Config::default().geometry.wheel_radius_m;
    let begun = timeline.tracks_us.iter().rposition(|begin| *begin <= happened.at_us);
    let Some(begun_rad) = begun.map(|i| timeline.tracks_rad[i]) else {
        return WheelPair::both(0.0);
    };
    happened.angles_rad.zip(begun_rad).map(|(now, then)| (now - then).abs() * radius_m)
}

/// Where the slower wheel's setpoint is, by time: a ramp, the cruise, a ramp; or a stop along a steeper ramp.
struct Progress {
    begin_us: f64,
    cruise_mps: f64,
    ramp_s: f64,
    cruise_s: f64,
    /// The wheels' shares of the speed.
    shares: WheelPair<f64>,
    stop_us: Option<f64>,
}

/// Deceleration of a controlled stop \[m/s^2\].
const STOP_MPS2: f64 = 0.5;
/// Steps in which the setpoint is followed \[us\].
const STEP_US: f64 = 1000.0;

impl Progress {
    fn new(case: &Case, begin_us: u64, stop_us: Option<u64>) -> Self {
        let distance = case.motion.distance.map(f64::abs);
        let longest = distance.left.max(distance.right);
        Self {
            begin_us: begin_us as f64,
            cruise_mps: case.motion.cruise,
            ramp_s: case.motion.ramp_s(),
            cruise_s: case.cruise_s,
            shares: distance.map(|m| m / longest),
            stop_us: stop_us.map(|us| us as f64),
        }
    }

    fn end_us(&self) -> f64 {
        match self.stop_us {
            Some(us) => us + self.cruise_mps / STOP_MPS2 * 1e6,
            None => self.begin_us + (2.0 * self.ramp_s + self.cruise_s) * 1e6,
        }
    }

    fn brakes_us(&self) -> f64 {
        self.stop_us.unwrap_or(self.begin_us + (self.ramp_s + self.cruise_s) * 1e6)
    }

    fn wheels_mps(&self, at_us: f64) -> WheelPair<f64> {
        let s = (at_us - self.begin_us) * 1e-6;
        let left_s = (self.end_us() - at_us) * 1e-6;
        let ramp_s = self.stop_us.map_or(self.ramp_s, |_| self.cruise_mps / STOP_MPS2);
        let ramp = (s / self.ramp_s).min(left_s / ramp_s).clamp(0.0, 1.0);
        self.shares.map(|share| share * self.cruise_mps * ramp)
    }

    /// The slower wheel's.
    fn speed_mps(&self, at_us: f64) -> f64 {
        let WheelPair { left, right } = self.wheels_mps(at_us);
        left.min(right)
    }

    /// When the setpoint will have advanced by so much \[m\].
    fn shown_us(&self, at_us: u64, shown_m: f64) -> Option<f64> {
        let (mut t_us, mut advanced_m) = (at_us as f64, 0.0);
        while t_us < self.end_us() {
            advanced_m += self.speed_mps(t_us) * STEP_US * 1e-6;
            t_us += STEP_US;
            if advanced_m >= shown_m {
                return Some(t_us);
            }
        }
        None
    }
}
