//! Cases by chance: the same seed and index give the same case.

use host_link::motion::Motion;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Config, Driver, TravelUnit, Wheel, WheelPair};
use sim_target::Scenario;

use super::fault_kind::{CORE_STANDS_MS_MAX, FaultKind, OTHER_TASKS, PROGRAM, SAFETY_TASKS};
use super::other_gains::other_gains;
use crate::lines::{Line, LineFault};

/// When something happens: a delay after this.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// Power-on.
    Boot,
    /// The host says hello.
    Hello,
    /// The robot is idle.
    Idle,
    /// The host arms it.
    Arming,
    /// The host has commanded a motion that begins later.
    Waiting,
    /// The encoder check begins.
    Check,
    /// The wheels accelerate.
    Acceleration,
    /// They cruise.
    Cruise,
    /// They decelerate.
    Deceleration,
    /// The motion has ended, and the robot is armed.
    Standing,
    /// The host has told it to stop.
    Stopping,
    /// The host's emergency stop has been latched.
    Latched,
}

impl Phase {
    /// All, in order.
    pub const ALL: [Phase; 12] = [
        Phase::Boot,
        Phase::Hello,
        Phase::Idle,
        Phase::Arming,
        Phase::Waiting,
        Phase::Check,
        Phase::Acceleration,
        Phase::Cruise,
        Phase::Deceleration,
        Phase::Standing,
        Phase::Stopping,
        Phase::Latched,
    ];
}

/// A random case.
#[derive(Clone, Debug)]
pub struct Case {
    /// The seed of all cases.
    pub seed: u64,
    /// The case's number.
    pub index: u64,
    /// The robot.
    pub scenario: Scenario,
    /// Its configuration, where it is not the factory's.
    pub config: Option<Config>,
    /// Of both encoders, a turn of the wheel.
    pub counts_per_rev: f64,
    /// The motor driver, as it is configured.
    pub driver: Driver,
    /// What the host commands.
    pub motion: Motion,
    /// The cruise lasts this long \[s\].
    pub cruise_s: f64,
    /// When the first fault happens.
    pub phase: Phase,
    /// How long after that phase's beginning \[us\].
    pub delay_us: u64,
    /// What happens first.
    pub first: FaultKind,
    /// What happens then, and how much later \[us\].
    pub second: Option<(FaultKind, u64)>,
}

/// The cruise lasts this long, and that of a robot that crawls: it has to get somewhere \[s\].
const CRUISE_S: f64 = 0.25;
const CRAWLS_S: f64 = 0.8;
/// Of so many cases the robot crawls in one: its wheels then stand within a count or two, whatever stops them.
const CRAWLS: u64 = 4;

/// Of so many cases two have other encoders; one of them crawls.
const OTHER_ENCODERS: u64 = 8;
/// Of the paper's robot, and of those, as many finer as coarser ones \[counts a turn\].
const COUNTS_PER_REV: f64 = 900.0;
const COUNTS_MIN: f64 = 48.0;
const COUNTS_MAX: f64 = 20_000.0;
/// The emulated pins show twenty counts a millisecond at most: no wheel counts faster \[counts/s\].
const COUNTS_PER_S_MAX: f64 = 15e3;

/// Of so many cases as above two have other gains and a slope; one of them crawls.
const OTHER_GAINS: [u64; 2] = [1, CRAWLS / 2];

/// Of so many cases as above one has another motor driver.
const OTHER_DRIVER: u64 = 3;

/// The supply's limits of the factory configuration \[V\], and the lower one of a robot with a weak battery.
const SUPPLY_V_MAX: f64 = 18.5;
const WEAK_SUPPLY_V_MIN: f64 = 8.0;

impl Case {
    /// Draws a case.
    pub fn draw(seed: u64, index: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index);
        let rng = &mut rng;
        let (mut scenario, mut config) = robot(rng);
        let supply_v = scenario.plant.supply.open_circuit_v;
        let crawls = index % CRAWLS == CRAWLS / 2;
        let cruise_s = if crawls { CRAWLS_S } else { CRUISE_S };
        let motion = motion(rng, supply_v, crawls);
        let counts_per_rev = counts_per_rev(seed, index, motion.cruise);
        if counts_per_rev != COUNTS_PER_REV {
            scenario.plant.encoder.left.counts_per_rev = counts_per_rev;
            scenario.plant.encoder.right.counts_per_rev = counts_per_rev;
            let configured = &mut config.get_or_insert_default().encoder;
            configured.left.counts_per_rev = counts_per_rev;
            configured.right.counts_per_rev = counts_per_rev;
        }
        if OTHER_GAINS.contains(&(index % OTHER_ENCODERS)) {
            let others = other_gains(seed, index, &mut scenario, &motion);
            let config = config.get_or_insert_default();
            (config.pid, config.feedforward) = (others.pid, others.feedforward);
            config.limits.duty_max = others.duty_max;
        }
        let (driver, soldered) = drivers(seed, index);
        if driver != Driver::default() {
            config.get_or_insert_default().driver.name = driver;
        }
        let mut phase = Phase::ALL[rng.random_range(0..Phase::ALL.len())];
        if soldered != driver {
            // Nobody exchanges a driver that is on.
            phase = phase.min(Phase::Idle);
        }
        let delay_us = delay_us(rng, phase, &motion, cruise_s);
        let supply_v_min = config.as_ref().unwrap_or(&Config::default()).protection.supply_v_min;
        let supply = (supply_v, supply_v_min);
        let shown = |kind: FaultKind| match kind {
            FaultKind::EncoderNoise(..) if counts_per_rev > COUNTS_PER_REV => kind.without_noise(),
            FaultKind::Driver if !driver.facts().has_fault => FaultKind::StopLine,
            _ => kind,
        };
        let first = shown(kind(rng, phase, supply));
        let first = if soldered != driver { FaultKind::WrongName(soldered) } else { first };
        let second = rng
            .random_bool(0.25)
            .then(|| (shown(kind(rng, phase, supply)), rng.random_range(0..60_000)))
            .filter(|(second, _)| soldered == driver && may_follow(*second, first));
        Self {
            seed,
            index,
            scenario,
            config,
            counts_per_rev,
            driver,
            motion,
            cruise_s,
            phase,
            delay_us,
            first,
            second,
        }
    }

    /// Travel of a wheel in a count, by the configuration \[m\].
    pub fn count_m(&self) -> f64 {
        let radius_m = Config::default().geometry.wheel_radius_m;
        std::f64::consts::TAU * radius_m / self.counts_per_rev
    }

    /// The command that runs this case alone.
    pub fn command(&self) -> String {
        format!("cargo xtask bench faults --seed {} --case {}", self.seed, self.index)
    }
}

/// By a stream of its own, so that a case is what it was before there were other encoders.
fn counts_per_rev(seed: u64, index: u64, cruise_mps: f64) -> f64 {
    if ![OTHER_ENCODERS / 2, CRAWLS + CRAWLS / 2].contains(&(index % OTHER_ENCODERS)) {
        return COUNTS_PER_REV;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::MAX - index);
    let turn_m = std::f64::consts::TAU * Config::default().geometry.wheel_radius_m;
    let counts = rng.random_range(COUNTS_MIN.ln()..COUNTS_MAX.ln()).exp();
    counts.min(COUNTS_PER_S_MAX * turn_m / cruise_mps).round()
}

/// Which driver the robot is configured for, and which one it has; by a stream of its own, too.
fn drivers(seed: u64, index: u64) -> (Driver, Driver) {
    if index % OTHER_ENCODERS != OTHER_DRIVER {
        return (Driver::default(), Driver::default());
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::MAX / 4 - index);
    let mut any = || Driver::ALL[rng.random_range(0..Driver::ALL.len())];
    let (driver, other) = (any(), any());
    (driver, if rng.random_bool(0.5) { other } else { driver })
}

/// The paper's robot with another battery, load, friction and driver.
fn robot(rng: &mut ChaCha8Rng) -> (Scenario, Option<Config>) {
    let mut scenario = Scenario { seed: rng.next_u64(), ..Scenario::default() };
    let plant = &mut scenario.plant;
    plant.supply.open_circuit_v = rng.random_range(9.0..18.0);
    if rng.random_bool(0.5) {
        plant.body.payload_kg = rng.random_range(0.5..4.0);
    }
    for motor in [&mut plant.motor.left, &mut plant.motor.right] {
        motor.coulomb_torque_nm *= rng.random_range(0.6..2.0);
    }
    plant.bridge.shorts_when_off = rng.random_bool(0.5);
    let weak = plant.supply.open_circuit_v < 10.0;
    let config = weak.then(|| {
        let mut config = Config::default();
        config.protection.supply_v_min = WEAK_SUPPLY_V_MIN;
        config
    });
    (scenario, config)
}

/// Ahead, back, on the spot, or along an arc; within what the supply allows.
fn motion(rng: &mut ChaCha8Rng, supply_v: f64, crawls: bool) -> Motion {
    let mut cruise = rng.random_range(0.05..if supply_v < 11.0 { 0.22 } else { 0.35 });
    let mut acceleration = rng.random_range(0.4..1.0);
    let mut cruise_s = CRUISE_S;
    if crawls {
        // 8 to 60 mm/s, reached in 0.25 to 1.5 s.
        cruise = rng.random_range(0.008..0.06);
        acceleration = cruise / rng.random_range(0.25..1.5);
        cruise_s = CRAWLS_S;
    }
    let distance = cruise * cruise / acceleration + cruise * cruise_s;
    let inner = rng.random_range(0.6..1.0) * distance;
    let distance = match rng.random_range(0..8) {
        0..4 => WheelPair::both(distance),
        4 => WheelPair::both(-distance),
        5 => WheelPair { left: -distance, right: distance },
        6 => WheelPair { left: inner, right: distance },
        _ => WheelPair { left: distance, right: inner },
    };
    Motion { unit: TravelUnit::Meter, distance, cruise, acceleration }
}

/// A delay within the phase.
fn delay_us(rng: &mut ChaCha8Rng, phase: Phase, motion: &Motion, cruise_s: f64) -> u64 {
    let ramp_us = (motion.ramp_s() * 1e6) as u64;
    let most_us = match phase {
        Phase::Boot => 25_000,
        Phase::Hello => 20_000,
        Phase::Idle => 50_000,
        Phase::Arming => 4_000,
        Phase::Waiting => 200_000,
        Phase::Check => 400_000,
        Phase::Acceleration | Phase::Deceleration => ramp_us,
        Phase::Cruise => (cruise_s * 1e6) as u64,
        Phase::Standing | Phase::Latched => 100_000,
        Phase::Stopping => ramp_us.min(200_000),
    };
    rng.random_range(0..most_us)
}

/// What happens; every kind is as likely as the next one, as far as the phase allows it.
fn kind(rng: &mut ChaCha8Rng, phase: Phase, supply: (f64, f64)) -> FaultKind {
    loop {
        let kind = any_kind(rng, supply);
        let too_early = kind.needs_tasks() && phase < Phase::Idle;
        let too_late = kind.is_miswired() && phase > Phase::Idle;
        if !too_early && !too_late {
            return kind;
        }
    }
}

/// Whether a second thing can be put into a robot in which the first has happened.
fn may_follow(second: FaultKind, first: FaultKind) -> bool {
    // Of a program that restarts nothing can be changed, and one change is enough.
    let restarts =
        matches!(first, FaultKind::ClockFails | FaultKind::PowerCut | FaultKind::ResetPin);
    let both = second.is_of_the_program() && (restarts || first.is_of_the_program());
    second.name() != first.name() && !both
}

fn any_kind(rng: &mut ChaCha8Rng, (supply_v, supply_v_min): (f64, f64)) -> FaultKind {
    let wheel = if rng.random_bool(0.5) { Wheel::Left } else { Wheel::Right };
    let line = if rng.random_bool(0.5) { Line::A } else { Line::B };
    // Below the limit by more than the measurement's noise.
    let below_v = supply_v - supply_v_min + rng.random_range(0.3..supply_v_min);
    match rng.random_range(0..35) {
        0 => FaultKind::Nothing,
        1 => FaultKind::EncoderUnplugged(wheel),
        2..5 => {
            FaultKind::EncoderLine(wheel, LineFault::Stuck { line, high: rng.random_bool(0.5) })
        }
        5 => FaultKind::EncoderLine(wheel, LineFault::Floats(line)),
        6 => FaultKind::EncoderSwapped(wheel),
        7 => {
            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            // More than the wheel can turn: a slower one cannot be told from travel.
            FaultKind::EncoderNoise(wheel, sign * rng.random_range(1.6e4..1e5))
        }
        8 => FaultKind::EncodersExchanged,
        9 => FaultKind::MotorsExchanged,
        10 => FaultKind::MotorReversed(wheel),
        11 => FaultKind::MotorCut(wheel),
        12 => FaultKind::WheelBlocked(wheel),
        13 => FaultKind::WheelJammed(wheel),
        14 => FaultKind::SupplyCut,
        15 => FaultKind::SupplyLow(below_v),
        16 => FaultKind::SupplyDip(below_v, rng.random_range(1..16)),
        17 => FaultKind::SupplyHigh(SUPPLY_V_MAX - supply_v + rng.random_range(0.3..5.0)),
        18 => FaultKind::Driver,
        19 => FaultKind::StopButton(rng.random_range(10..500)),
        20 => FaultKind::StopLine,
        21 => FaultKind::StopLineBounce(rng.random_range(100..5_000)),
        22 => FaultKind::LinkCut,
        23 => FaultKind::LinkToRobotCut,
        24 => FaultKind::LinkToHostCut,
        25 => FaultKind::HostDies,
        26 => FaultKind::HostHangs,
        27 => FaultKind::Garbage(rng.random_range(20..300)),
        28 => FaultKind::TaskStops(SAFETY_TASKS[rng.random_range(0..SAFETY_TASKS.len())]),
        29 => FaultKind::TaskStops(OTHER_TASKS[rng.random_range(0..OTHER_TASKS.len())]),
        30 if rng.random_bool(0.5) => {
            FaultKind::CoreStands(rng.random_range(2..=CORE_STANDS_MS_MAX))
        }
        30 => FaultKind::CoreStands(rng.random_range(45..100)),
        31 => PROGRAM[rng.random_range(0..PROGRAM.len())],
        32 => FaultKind::ClockFails,
        33 => FaultKind::PowerCut,
        _ => FaultKind::ResetPin,
    }
}
