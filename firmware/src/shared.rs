//! What the tasks share: one static per robot.
//!
//! ```text
//!            Measured          ControlStep          Duty
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
//! Generic over the mutex: a board whose control tasks preempt the others needs critical
//! sections, the simulator needs none.

use core::cell::Cell;

use embassy_sync::blocking_mutex::{Mutex, raw::RawMutex};
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use fixed::types::{I8F24, I32F32};
use shared_proto::{
    Event, Fault, FaultReport, Hello, LinkStatistics, Reply, Request, Telemetry, WheelPair,
    WheelTelemetry,
};

use crate::odometry::Odometry;
use crate::pid::Gains;
use crate::probe::Probe;
use crate::profile::{Plan, Setpoint};
use crate::protection::Protection;
use crate::units::{Speed, Travel};

/// Everything that crosses from one task to another.
pub struct Shared<M: RawMutex> {
    /// Capture to profile: the wheels at this tick.
    pub measured: Signal<M, Measured>,
    /// Profile to PID: what the wheels shall do at this tick.
    pub step: Signal<M, ControlStep>,
    /// Supervisor to capture: how to read the encoders.
    pub capture_settings: Signal<M, CaptureSettings>,
    /// Supervisor to PID: how to close the loop.
    pub loop_settings: Signal<M, LoopSettings>,
    /// Supervisor to profile: what to do from now on.
    pub order: Signal<M, Order>,
    /// Control tasks to supervisor.
    pub control_events: Channel<M, ControlEvent, 4>,
    /// Link to supervisor.
    pub requests: Channel<M, Request, 1>,
    /// Anybody to the link.
    pub outgoing: Channel<M, Outgoing, 4>,
    /// PID to telemetry: the snapshot of a tick that is due to be sent.
    pub telemetry_due: Signal<M, Telemetry>,
    /// Telemetry to link.
    pub telemetry: Channel<M, Telemetry, 2>,
    /// Ticks between two telemetry frames, 0 for none.
    pub telemetry_period: Cells<M, u32>,
    /// The wheels as PID saw them last.
    pub snapshot: Cells<M, Snapshot>,
    /// The latched fault.
    pub fault: FaultLatch<M>,
    /// The supervisor's state, for telemetry.
    pub state: Cells<M, shared_proto::State>,
    /// When a good frame of a running session came last \[us\].
    pub heard_us: Cells<M, u64>,
    /// Longest delay of a control tick so far \[us\].
    pub tick_delay_us_max: Cells<M, u32>,
    /// Counters of the link.
    pub link: Cells<M, LinkStatistics>,
    /// The emergency stop is pressed; the motor driver reports a fault.
    pub lines: Cells<M, Lines>,
}

impl<M: RawMutex> Shared<M> {
    /// Nothing has happened yet.
    pub const fn new() -> Self {
        Self {
            measured: Signal::new(),
            step: Signal::new(),
            capture_settings: Signal::new(),
            loop_settings: Signal::new(),
            order: Signal::new(),
            control_events: Channel::new(),
            requests: Channel::new(),
            outgoing: Channel::new(),
            telemetry_due: Signal::new(),
            telemetry: Channel::new(),
            telemetry_period: Cells::new(0),
            snapshot: Cells::new(Snapshot::ZERO),
            fault: FaultLatch::new(),
            state: Cells::new(shared_proto::State::Boot),
            heard_us: Cells::new(0),
            tick_delay_us_max: Cells::new(0),
            link: Cells::new(LinkStatistics {
                frames_received: 0,
                frames_damaged: 0,
                frames_lost: 0,
                frames_sent: 0,
                telemetry_dropped: 0,
            }),
            lines: Cells::new(Lines { emergency_stop: false, driver_fault: false }),
        }
    }

    /// Latches a fault, or counts it if one is latched already, and tells the supervisor.
    ///
    /// From the next control tick on the motors get zero duty, unless the fault allows a ramp.
    pub fn raise(&self, fault: Fault, t_us: u64) {
        if self.fault.latch(fault, t_us) {
            // A full queue is no loss: the supervisor looks at the latch after every event.
            let _ = self.control_events.try_send(ControlEvent::Faulted);
        }
    }
}

impl<M: RawMutex> Default for Shared<M> {
    fn default() -> Self {
        Self::new()
    }
}

/// A small value that several tasks read and write, whole.
pub struct Cells<M: RawMutex, T>(Mutex<M, Cell<T>>);

impl<M: RawMutex, T: Copy> Cells<M, T> {
    /// A cell with a first value.
    pub const fn new(value: T) -> Self {
        Self(Mutex::new(Cell::new(value)))
    }

    /// The value.
    pub fn get(&self) -> T {
        self.0.lock(Cell::get)
    }

    /// Puts a new value.
    pub fn set(&self, value: T) {
        self.0.lock(|cell| cell.set(value));
    }

    /// Changes the value in place; nobody sees it half changed.
    pub fn update(&self, change: impl FnOnce(&mut T)) {
        self.0.lock(|cell| {
            let mut value = cell.get();
            change(&mut value);
            cell.set(value);
        });
    }
}

/// The first fault since the last clearing, and whether the motors must be off for it.
pub struct FaultLatch<M: RawMutex>(Cells<M, Latched>);

#[derive(Clone, Copy)]
struct Latched {
    report: Option<FaultReport>,
    cut: bool,
    last_number: u32,
}

impl<M: RawMutex> FaultLatch<M> {
    const fn new() -> Self {
        Self(Cells::new(Latched { report: None, cut: false, last_number: 0 }))
    }

    /// The latched fault.
    pub fn report(&self) -> Option<FaultReport> {
        self.0.get().report
    }

    /// Whether a latched fault forbids any duty at all.
    pub fn cuts_motors(&self) -> bool {
        self.0.get().cut
    }

    /// The number of the fault that was latched last, 0 before the first.
    pub fn last_number(&self) -> u32 {
        self.0.get().last_number
    }

    /// Returns true if this is news to the supervisor.
    fn latch(&self, fault: Fault, t_us: u64) -> bool {
        let mut news = false;
        self.0.update(|latched| {
            let cut = !fault.allows_ramp();
            news = latched.report.is_none() || (cut && !latched.cut);
            latched.cut |= cut;
            match &mut latched.report {
                // The same fault over and over is one fault.
                Some(report) if report.fault == fault => {}
                Some(report) => report.followed_by = report.followed_by.saturating_add(1),
                None => {
                    latched.last_number = latched.last_number.wrapping_add(1);
                    let number = latched.last_number;
                    latched.report = Some(FaultReport { fault, number, t_us, followed_by: 0 });
                }
            }
        });
        news
    }

    /// Forgets the latched fault. Only the supervisor does this, and only when it is told to.
    pub(crate) fn clear(&self) {
        self.0.update(|latched| {
            latched.report = None;
            latched.cut = false;
        });
    }
}

/// The wheels at one control tick.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Control ticks since power-on.
    pub tick: u32,
    /// When the encoders were read \[us\].
    pub t_us: u64,
    /// Absolute counts, forward positive.
    pub counts: WheelPair<i64>,
    /// Travel on the ground.
    pub travel: WheelPair<Travel>,
    /// Speed on the ground.
    pub speed: WheelPair<Speed>,
}

/// What the wheels shall do at one control tick.
#[derive(Clone)]
pub struct ControlStep {
    /// The wheels as measured.
    pub measured: Measured,
    /// What to do with them.
    pub action: Action,
}

/// What to do with the wheels.
#[derive(Clone)]
#[allow(clippy::large_enum_variant, reason = "no allocator on the board; one lives at a time")]
pub enum Action {
    /// Zero duty, drivers off.
    Off,
    /// Zero duty, drivers on: the motors brake.
    Rest,
    /// Check the encoders' signs, open loop.
    Probe {
        /// Comes back in the event.
        id: u32,
        /// The check to make, at its first tick.
        start: Option<Probe>,
    },
    /// Follow the setpoints, closed loop.
    Track(WheelPair<Setpoint>),
}

/// What the supervisor wants of the control tasks.
#[derive(Clone)]
#[allow(clippy::large_enum_variant, reason = "no allocator on the board; one lives at a time")]
pub enum Order {
    /// Zero duty, drivers off.
    Off,
    /// Zero duty, drivers on.
    Rest,
    /// Check the encoders' signs; ends in [`ControlEvent::Probed`] or a fault.
    Probe {
        /// Comes back in the event.
        id: u32,
        /// The check to make.
        probe: Probe,
    },
    /// Follow this plan from its first tick on; ends in [`ControlEvent::Settled`].
    Follow {
        /// Comes back in the event.
        id: u32,
        /// The motion.
        plan: Plan,
    },
}

/// What the control tasks tell the supervisor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlEvent {
    /// Both encoders run with their motors: the order with this id is done.
    Probed(u32),
    /// The plan is at its end, and so are the wheels: the order with this id is done.
    Settled(u32),
    /// A fault was latched.
    Faulted,
    /// The emergency stop's button was held: its fault is to be cleared.
    ClearAsked,
}

/// How to read the encoders.
#[derive(Clone)]
pub struct CaptureSettings {
    /// Counts to travel.
    pub odometry: Odometry,
    /// Whether a count falls when the wheel rolls forward.
    pub reversed: WheelPair<bool>,
}

/// How to close the loop.
#[derive(Clone)]
pub struct LoopSettings {
    /// The controller's gains and limits.
    pub gains: Gains,
    /// What is watched, and its bounds.
    pub protection: Protection,
    /// Whether positive duty turns a wheel backwards.
    pub reversed: WheelPair<bool>,
    /// Smallest supply with the motors on \[mV\].
    pub supply_mv_min: u16,
}

/// Something for the link to send, in order. Telemetry has its own queue, behind this one.
#[allow(clippy::large_enum_variant, reason = "no allocator on the board; one lives at a time")]
pub enum Outgoing {
    /// The robot's half of the handshake.
    Hello(Hello),
    /// The answer to a request.
    Reply(Reply),
    /// News.
    Event(Event),
}

/// The wheels, the loop and the supply, at one control tick.
#[derive(Clone, Copy)]
pub struct Snapshot {
    /// The wheels as measured.
    pub measured: Measured,
    /// Each wheel's part of a telemetry frame.
    pub wheels: WheelPair<WheelTelemetry>,
    /// Supply \[mV\].
    pub supply_mv: u16,
}

impl Snapshot {
    const ZERO: Self = Self {
        measured: Measured {
            tick: 0,
            t_us: 0,
            counts: WheelPair::both(0),
            travel: WheelPair::both(Travel(I32F32::ZERO)),
            speed: WheelPair::both(Speed(I8F24::ZERO)),
        },
        wheels: WheelPair::both(WheelTelemetry {
            counts: 0,
            setpoint_um: 0,
            error_um: 0,
            speed_um_s: 0,
            terms: shared_proto::PidTerms {
                feedforward: 0,
                proportional: 0,
                integral: 0,
                derivative: 0,
            },
            duty: 0,
        }),
        supply_mv: 0,
    };
}

/// Inputs that stop the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    /// The emergency stop is pressed.
    pub emergency_stop: bool,
    /// The motor driver reports a fault.
    pub driver_fault: bool,
}
