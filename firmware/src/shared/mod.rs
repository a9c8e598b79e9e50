//! What the tasks share: one static per robot.
//!
//! ```text
//!            measured           action             Duty
//! capture ------------> profile ------------> pid --------> motors        every control tick
//!    ^                     ^                   |
//!    | configuration       | orders            | snapshot, events, faults
//!    |                     |                   v
//!    +----------------- supervisor <-------------------+
//!                        ^      |
//!               requests |      | replies, events
//!                        |      v
//!                     link receive / transmit <--- telemetry
//! ```
//!
//! Generic over the mutex: a board's control tasks preempt the others, so it needs critical sections;
//! the simulator needs none.

mod dead_man;
mod fault_latch;
mod handoff;
mod in_place;
mod tick;

use core::sync::atomic::AtomicU32;

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::channel::Channel;
use shared_proto::{
    Access, Config, DriverConfig, Event, Fault, Greeting, LinkStatistics, MotionEnd, Reply,
    Request, State, Telemetry, WheelPair,
};

pub use dead_man::DeadMan;
pub use fault_latch::FaultLatch;
pub use handoff::{Mailbox, Notify, SharedCell};
pub use in_place::InPlace;
pub use tick::{Action, Snapshot, TelemetryHistory, Tick};

use crate::capture::CaptureSettings;
use crate::dead_reckoning::Geometry;
use crate::liveness::Liveness;
use crate::pid::Gains;
use crate::pose_covariance::Uncertainty;
use crate::probe::Probe;
use crate::profile::{Plan, Profile};
use crate::protection::Thresholds;
use crate::soft_float::truncate;
use crate::units::Travel;
use crate::voltage::VoltagePlan;

/// Everything that passes from one task to another.
///
/// In this order in memory: what each tick touches is first, near enough for an instruction to hold its distance.
#[repr(C)]
pub struct Shared<M: RawMutex> {
    /// Capture to profile: this tick's measurement is there.
    pub measurement_ready: Notify<M>,
    /// Profile to PID: this tick's action is there.
    pub action_ready: Notify<M>,
    /// The tick that the three control tasks work on; for the others, the last one.
    pub snapshot: InPlace<M, Tick>,
    /// Supervisor to capture: how to read the encoders.
    pub capture_settings: Mailbox<M, CaptureSettings>,
    /// Supervisor to PID: how to close the loop.
    pub loop_settings: Mailbox<M, LoopSettings>,
    /// Supervisor to profile: what to do from now on.
    pub order: Mailbox<M, ControlOrder>,
    /// The plan that the profile task follows; the supervisor adds the next one, see [`Shared::follow`].
    pub profile: InPlace<M, Profile>,
    /// Supervisor to PID: the check for an [`ControlOrder::Probe`].
    pub probe: InPlace<M, Option<Probe>>,
    /// Control tasks to supervisor.
    pub control_events: Channel<M, ControlEvent, 4>,
    /// Link to supervisor.
    pub requests: Channel<M, Request, 1>,
    /// Any task to the link.
    pub outgoing: Channel<M, Outgoing, 4>,
    /// Receiver to transmitter: answers to hosts that begin a session. They have a place of their own, so that no
    /// other host's flood keeps a new one out.
    pub greetings: Channel<M, Greeting, 1>,
    /// Supervisor to link: whom the robot obeys.
    pub access: SharedCell<M, Access>,
    /// Supervisor to telemetry: how to follow where the robot is.
    pub follow_wheels: Mailbox<M, OdometryOrder>,
    /// Telemetry to link.
    pub telemetry: Channel<M, Telemetry, 2>,
    /// Telemetry to supervisor: the last frames, in case one was lost on the line.
    pub history: TelemetryHistory<M>,
    /// Ticks between two telemetry frames, 0 for none.
    pub telemetry_period: AtomicU32,
    /// The latched fault.
    pub fault: FaultLatch<M>,
    /// The supervisor's state, for telemetry.
    pub state: SharedCell<M, State>,
    /// The session that drives the robot: the one that armed it.
    pub driver: SharedCell<M, Option<u32>>,
    /// When the driver was last heard; without a driver, any host \[us\].
    pub heard_us: SharedCell<M, u64>,
    /// Longest delay of a control tick so far \[us\].
    pub tick_delay_us_max: AtomicU32,
    /// Ticks of the control timer that were lost so far.
    pub ticks_lost: SharedCell<M, u32>,
    /// Supervisor to PID: how long the motors may be driven.
    pub dead_man: DeadMan,
    /// The safety tasks' signs of life.
    pub liveness: Liveness,
    /// Counters of the link.
    pub link: SharedCell<M, LinkStatistics>,
    /// Emergency stop and motor driver fault.
    pub safety_inputs: SharedCell<M, SafetyInputs>,
    /// The level of the motor driver's fault line at a fault; without one, the line is ignored.
    pub fault_line: SharedCell<M, FaultLine>,
}

impl<M: RawMutex> Shared<M> {
    /// The state at power-on.
    pub const fn new() -> Self {
        Self {
            measurement_ready: Notify::new(),
            action_ready: Notify::new(),
            snapshot: InPlace::new(Tick::FIRST),
            capture_settings: Mailbox::new(),
            loop_settings: Mailbox::new(),
            order: Mailbox::new(),
            profile: InPlace::new(Profile::ORIGIN),
            probe: InPlace::new(None),
            control_events: Channel::new(),
            requests: Channel::new(),
            outgoing: Channel::new(),
            greetings: Channel::new(),
            access: SharedCell::new(Access::Nobody),
            follow_wheels: Mailbox::new(),
            telemetry: Channel::new(),
            history: TelemetryHistory::new(),
            telemetry_period: AtomicU32::new(0),
            fault: FaultLatch::new(),
            state: SharedCell::new(State::Boot),
            driver: SharedCell::new(None),
            heard_us: SharedCell::new(0),
            tick_delay_us_max: AtomicU32::new(0),
            ticks_lost: SharedCell::new(0),
            dead_man: DeadMan::new(),
            liveness: Liveness::new(),
            link: SharedCell::new(LinkStatistics {
                frames_received: 0,
                frames_damaged: 0,
                frames_lost: 0,
                frames_sent: 0,
                telemetry_dropped: 0,
                frames_refused: 0,
            }),
            fault_line: SharedCell::new(FaultLine::None),
            safety_inputs: SharedCell::new(SafetyInputs {
                emergency_stop: false,
                stop_line: false,
                driver_fault: false,
            }),
        }
    }

    /// Makes the control tasks follow a plan from its first tick; [`ControlEvent::Settled`] marks the end.
    ///
    /// The wheels then hold their place for `hold_ticks`. The plan is copied once, to where the control tick uses it.
    pub fn follow(&self, id: u32, plan: &Plan, hold_ticks: u32) {
        // Under one lock: the profile task never sees the plan without the order, or the reverse.
        self.profile.with(|profile| {
            profile.replace(plan);
            self.order.put(ControlOrder::Follow { id, hold_ticks });
        });
    }

    /// Makes the control tasks check the encoders' signs; ends in [`ControlEvent::Probed`] or a fault.
    pub fn check(&self, id: u32, probe: Probe) {
        self.probe.with(|slot| *slot = Some(probe));
        self.order.put(ControlOrder::Probe { id });
    }

    /// Latches a fault, or counts it if one is latched already, and informs the supervisor.
    ///
    /// From the next control tick on the motors get zero duty, unless the fault allows a ramp. Not for the control
    /// tasks while they work on the tick: they have `raise_in_tick`.
    pub fn raise(&self, fault: Fault, t_us: u64) {
        self.raise_in_tick(fault, t_us);
        self.snapshot.with(|tick| self.fault.note(tick));
    }

    /// As [`raise`](Self::raise), from within the control tick; how the wheels are is noted at the tick's end.
    #[cold]
    #[inline(never)]
    pub(crate) fn raise_in_tick(&self, fault: Fault, t_us: u64) {
        if self.fault.latch(fault, t_us) {
            // A full queue loses nothing: the supervisor reads the latch after every event.
            let _ = self.control_events.try_send(ControlEvent::Faulted);
        }
    }
}

impl<M: RawMutex> Default for Shared<M> {
    fn default() -> Self {
        Self::new()
    }
}

/// What the supervisor wants the control tasks to do.
#[derive(Clone, Copy)]
pub enum ControlOrder {
    /// Zero duty, drivers off.
    Off,
    /// Zero duty, drivers on.
    Rest,
    /// Check the encoders' signs, see [`Shared::check`].
    Probe {
        /// Returned in the event.
        id: u32,
    },
    /// Follow the new plan, see [`Shared::follow`].
    Follow {
        /// Returned in the event.
        id: u32,
        /// How long to hold the place afterwards \[ticks\].
        hold_ticks: u32,
    },
    /// Apply voltages, in place of those under way; [`ControlEvent::Rolled`] marks the end.
    Voltage {
        /// Returned in the event.
        id: u32,
        /// The voltages and their limits.
        plan: VoltagePlan,
    },
    /// End the voltages under way now; [`ControlEvent::Rolled`] follows when the wheels stand.
    Halt {
        /// Returned in the event.
        id: u32,
    },
}

/// What the control tasks report to the supervisor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlEvent {
    /// Both encoders count the way their motors push: the order with this id is done. And where the wheels stood before it.
    Probed(u32, WheelPair<Travel>),
    /// The plan has ended and the wheels have settled: the order with this id is done.
    Settled(u32),
    /// The voltages are over and the wheels stand: the order with this id is done.
    Rolled(u32, MotionEnd),
    /// A fault was latched.
    Faulted,
    /// The emergency stop's button was held to clear its fault.
    ClearRequested,
}

/// How to follow where the robot is.
pub enum OdometryOrder {
    /// Not at all: the wheels' travel is about to have another scale.
    Pause,
    /// With this geometry, known to this, from the same place.
    With(Geometry, Uncertainty),
}

/// How to close the loop.
#[derive(Clone)]
pub struct LoopSettings {
    /// The controller's gains and limits.
    pub gains: WheelPair<Gains>,
    /// The protection's thresholds.
    pub thresholds: Thresholds,
    /// Whether positive duty turns a wheel backwards.
    pub reversed: WheelPair<bool>,
    /// The supply \[mV\].
    pub supply_mv: SupplyLimits,
    /// The motor driver.
    pub driver: DriverConfig,
}

/// Which supply the motors may have, and at which one the gains hold \[mV\].
#[derive(Clone, Copy, Debug)]
pub struct SupplyLimits {
    /// The lowest.
    pub min: u32,
    /// The highest.
    pub max: u32,
    /// Where the gains hold; 0 for any, and where the supply is not measured.
    pub nominal: u16,
    /// Taken for the supply where it is not measured; 0 where it is.
    pub assumed: u32,
}

impl SupplyLimits {
    /// Those of a configuration.
    pub fn new(config: &Config) -> Self {
        let millivolts = |volts: f64| truncate(volts * 1000.0, 0) as u32;
        let min = millivolts(config.protection.supply_v_min);
        let max = millivolts(config.protection.supply_v_max);
        Self {
            min,
            max: if max == 0 { u32::MAX } else { max },
            // Without a divider there is nothing to scale by.
            nominal: if min == 0 { 0 } else { millivolts(config.feedforward.supply_v) as u16 },
            assumed: if min == 0 { millivolts(config.feedforward.nominal_v()) } else { 0 },
        }
    }

    /// The supply as measured, or what it is taken for.
    #[inline(always)]
    pub fn known(self, measured_mv: u16) -> u16 {
        if self.assumed == 0 { measured_mv } else { self.assumed as u16 }
    }

    /// Whether the motors may have this supply.
    #[inline(always)]
    pub fn admits(self, supply_mv: u16) -> bool {
        (self.min..=self.max).contains(&u32::from(supply_mv))
    }
}

/// A message for the link to send, in order. Telemetry has its own queue, of lower priority.
#[allow(clippy::large_enum_variant, reason = "no allocator on the board; one lives at a time")]
pub enum Outgoing {
    /// The answer to a request.
    Reply(Reply),
    /// An event.
    Event(Event),
}

/// How the motor driver's fault line shows a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultLine {
    /// The driver has none, or is not known yet.
    None,
    /// Low at a fault.
    ActiveLow,
    /// High at a fault.
    ActiveHigh,
}

impl FaultLine {
    /// That of a configured driver.
    pub fn new(driver: &DriverConfig) -> Self {
        match (driver.name.facts().has_fault, driver.fault_inverted) {
            (false, _) => Self::None,
            (true, false) => Self::ActiveLow,
            (true, true) => Self::ActiveHigh,
        }
    }
}

/// Inputs that stop the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SafetyInputs {
    /// The emergency stop is pressed.
    pub emergency_stop: bool,
    /// The stop line is open.
    pub stop_line: bool,
    /// The motor driver reports a fault.
    pub driver_fault: bool,
}
