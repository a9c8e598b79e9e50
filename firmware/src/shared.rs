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
//! Generic over the mutex: a board whose control tasks preempt the others needs critical
//! sections, the simulator needs none.

use core::cell::{Cell, RefCell};
use core::future::poll_fn;
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::Poll;

use embassy_sync::blocking_mutex::{Mutex, raw::RawMutex};
use embassy_sync::channel::Channel;
use embassy_sync::waitqueue::WakerRegistration;
use fixed::types::{I8F24, I32F32};
use shared_proto::{
    Event, Fault, FaultReport, Hello, LinkStatistics, Reply, Request, Telemetry, Wheel, WheelPair,
    WheelTelemetry,
};

use crate::capture::{CaptureSettings, Measured};
use crate::pid::{Gains, PidState};
use crate::probe::Probe;
use crate::profile::{Plan, Profile, Setpoint};
use crate::protection::Thresholds;
use crate::units::{Duty, Speed, Travel};

/// Everything that crosses from one task to another.
pub struct Shared<M: RawMutex> {
    /// Capture to profile: the wheels at this tick.
    pub measured: Bell<M>,
    /// Profile to PID: what the wheels shall do at this tick.
    pub step: Bell<M>,
    /// The tick that the three work on; from outside, the one they worked on last.
    pub snapshot: TickCell<M>,
    /// Supervisor to capture: how to read the encoders.
    pub capture_settings: Mail<M, CaptureSettings>,
    /// Supervisor to PID: how to close the loop.
    pub loop_settings: Mail<M, LoopSettings>,
    /// Supervisor to profile: what to do from now on.
    pub order: Mail<M, Order>,
    /// Where the profile task walks; the supervisor puts the next plan in, see [`Shared::follow`].
    pub profile: Mutex<M, RefCell<Profile>>,
    /// Supervisor to PID: the check of an [`Order::Probe`].
    pub probe: Mail<M, Probe>,
    /// Control tasks to supervisor.
    pub control_events: Channel<M, ControlEvent, 4>,
    /// Link to supervisor.
    pub requests: Channel<M, Request, 1>,
    /// Anybody to the link.
    pub outgoing: Channel<M, Outgoing, 4>,
    /// PID to telemetry: this tick is due to be sent.
    pub telemetry_due: Bell<M>,
    /// Telemetry to link.
    pub telemetry: Channel<M, Telemetry, 2>,
    /// Telemetry to supervisor: what was sent last, should it have got lost.
    pub history: History<M>,
    /// Ticks between two telemetry frames, 0 for none.
    pub telemetry_period: Cells<M, u32>,
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
            measured: Bell::new(),
            step: Bell::new(),
            snapshot: TickCell::new(),
            capture_settings: Mail::new(),
            loop_settings: Mail::new(),
            order: Mail::new(),
            profile: Mutex::new(RefCell::new(Profile::ORIGIN)),
            probe: Mail::new(),
            control_events: Channel::new(),
            requests: Channel::new(),
            outgoing: Channel::new(),
            telemetry_due: Bell::new(),
            telemetry: Channel::new(),
            history: History::new(),
            telemetry_period: Cells::new(0),
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

    /// Has the control tasks follow a plan from its first tick on; ends in [`ControlEvent::Settled`].
    ///
    /// Copies the plan into its place, from where the control tick uses it.
    pub fn follow(&self, id: u32, plan: &Plan) {
        // Plan and order come together: none of the two is seen without the other.
        self.profile.lock(|profile| {
            profile.borrow_mut().replace(plan);
            self.order.put(Order::Follow { id });
        });
    }

    /// Has the control tasks check the encoders' signs; ends in [`ControlEvent::Probed`] or a fault.
    pub fn check(&self, id: u32, probe: Probe) {
        self.probe.put(probe);
        self.order.put(Order::Probe { id });
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

/// Wakes the one task that waits for it; rung twice it is heard once.
pub struct Bell<M: RawMutex> {
    rung: AtomicBool,
    waiter: Mutex<M, RefCell<WakerRegistration>>,
}

impl<M: RawMutex> Bell<M> {
    /// Not rung yet.
    pub const fn new() -> Self {
        Self {
            rung: AtomicBool::new(false),
            waiter: Mutex::new(RefCell::new(WakerRegistration::new())),
        }
    }

    /// Rings.
    pub fn ring(&self) {
        self.rung.store(true, Ordering::Relaxed);
        // Whoever is woken waits no longer: a task that only looks in now and then is let alone.
        self.waiter.lock(|waiter| waiter.borrow_mut().wake());
    }

    /// True if it was rung since it was heard last.
    #[inline(always)]
    pub fn heard(&self) -> bool {
        let rung = self.rung.load(Ordering::Relaxed);
        if rung {
            self.rung.store(false, Ordering::Relaxed);
        }
        rung
    }

    /// Waits until it is rung.
    pub async fn wait(&self) {
        poll_fn(|context| {
            if self.heard() {
                return Poll::Ready(());
            }
            self.waiter.lock(|waiter| waiter.borrow_mut().register(context.waker()));
            // It may have been rung in between, with nobody to wake.
            if self.heard() { Poll::Ready(()) } else { Poll::Pending }
        })
        .await;
    }
}

impl<M: RawMutex> Default for Bell<M> {
    fn default() -> Self {
        Self::new()
    }
}

/// The latest value of something for the one task that waits for it.
///
/// As a `Signal`; but that one moves its whole value at every look, be there one or not. Here a look that
/// finds nothing only looks at a bell.
pub struct Mail<M: RawMutex, T> {
    bell: Bell<M>,
    value: Mutex<M, Cell<Option<T>>>,
}

impl<M: RawMutex, T> Mail<M, T> {
    /// Nothing has come yet.
    pub const fn new() -> Self {
        Self { bell: Bell::new(), value: Mutex::new(Cell::new(None)) }
    }

    /// Puts a value, in place of one that nobody has taken.
    pub fn put(&self, value: T) {
        self.value.lock(|cell| cell.set(Some(value)));
        self.bell.ring();
    }

    /// Waits for a value.
    pub async fn next(&self) -> T {
        loop {
            self.bell.wait().await;
            if let Some(value) = self.value.lock(Cell::take) {
                return value;
            }
        }
    }

    /// The value, if one has come.
    pub fn try_take(&self) -> Option<T> {
        if self.bell.heard() { self.value.lock(Cell::take) } else { None }
    }
}

impl<M: RawMutex, T> Default for Mail<M, T> {
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

/// The telemetry that was sent last, each in the slot of its number.
pub struct History<M: RawMutex>(Mutex<M, [Cell<Option<Telemetry>>; Telemetry::KEPT as usize]>);

impl<M: RawMutex> History<M> {
    const fn new() -> Self {
        Self(Mutex::new([const { Cell::new(None) }; Telemetry::KEPT as usize]))
    }

    /// Keeps this one, and forgets the one that is [`Telemetry::KEPT`] older.
    pub fn keep(&self, telemetry: Telemetry) {
        self.0.lock(|slots| Self::slot(slots, telemetry.number).set(Some(telemetry)));
    }

    /// The one with this number, if it is still there.
    pub fn recall(&self, number: u32) -> Option<Telemetry> {
        self.0.lock(|slots| Self::slot(slots, number).get()).filter(|kept| kept.number == number)
    }

    fn slot(slots: &[Cell<Option<Telemetry>>], number: u32) -> &Cell<Option<Telemetry>> {
        &slots[(number % Telemetry::KEPT) as usize]
    }
}

/// The first fault since the last clearing, and whether the motors must be off for it.
pub struct FaultLatch<M: RawMutex> {
    latched: Cells<M, Latched>,
    /// Beside the rest: every control tick asks.
    cut: AtomicBool,
}

#[derive(Clone, Copy)]
struct Latched {
    report: Option<FaultReport>,
    last_number: u32,
}

impl<M: RawMutex> FaultLatch<M> {
    const fn new() -> Self {
        Self {
            latched: Cells::new(Latched { report: None, last_number: 0 }),
            cut: AtomicBool::new(false),
        }
    }

    /// The latched fault.
    pub fn report(&self) -> Option<FaultReport> {
        self.latched.get().report
    }

    /// Whether a latched fault forbids any duty at all.
    pub fn cuts_motors(&self) -> bool {
        self.cut.load(Ordering::Relaxed)
    }

    /// The number of the fault that was latched last, 0 before the first.
    pub fn last_number(&self) -> u32 {
        self.latched.get().last_number
    }

    /// Returns true if this is news to the supervisor.
    fn latch(&self, fault: Fault, t_us: u64) -> bool {
        let mut news = false;
        self.latched.update(|latched| {
            let cut = !fault.allows_ramp();
            news = latched.report.is_none() || (cut && !self.cuts_motors());
            if cut {
                self.cut.store(true, Ordering::Relaxed);
            }
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
        self.latched.update(|latched| {
            latched.report = None;
            self.cut.store(false, Ordering::Relaxed);
        });
    }
}

/// One control tick, as far as it has come. It stays in its place: capture, profile and PID add to it in
/// turn and copy nothing.
#[derive(Clone, Copy)]
pub struct Tick {
    /// The wheels as measured.
    pub measured: Measured,
    /// What to do with them.
    pub action: Action,
    /// Supply \[mV\].
    pub supply_mv: u16,
    /// The loops and their terms, all zero while they are open.
    pub loops: WheelPair<PidState>,
    /// What the motors get, forward positive.
    pub duty: WheelPair<Duty>,
    /// The encoders' signs are being checked.
    pub probing: bool,
}

/// The place of the [`Tick`].
pub struct TickCell<M: RawMutex>(Mutex<M, RefCell<Tick>>);

impl<M: RawMutex> TickCell<M> {
    const fn new() -> Self {
        Self(Mutex::new(RefCell::new(Tick {
            measured: Measured {
                tick: 0,
                t_us: 0,
                counts: WheelPair::both(0),
                travel: WheelPair::both(Travel(I32F32::ZERO)),
                speed: WheelPair::both(Speed(I8F24::ZERO)),
            },
            action: Action::Off,
            supply_mv: 0,
            loops: WheelPair::both(PidState::ZERO),
            duty: WheelPair::both(Duty::ZERO),
            probing: false,
        })))
    }

    /// Works on it.
    #[inline(always)]
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut Tick) -> R) -> R {
        self.0.lock(|tick| work(&mut tick.borrow_mut()))
    }

    /// A telemetry frame of it, one of those that come every `period` ticks; none if that is zero.
    ///
    /// Putting it in the wire's units is not the control tick's work.
    pub fn telemetry(&self, state: shared_proto::State, period: u32) -> Option<Telemetry> {
        let tick = self.with(|tick| *tick);
        let number = tick.measured.tick.checked_div(period)?;
        Some(tick.telemetry(number, state))
    }

    /// The wheels and the supply as they are in it.
    #[inline(never)]
    pub fn get(&self) -> Snapshot {
        self.with(|tick| Snapshot { measured: tick.measured, supply_mv: tick.supply_mv })
    }
}

/// What to do with the wheels.
#[derive(Clone, Copy)]
pub enum Action {
    /// Zero duty, drivers off.
    Off,
    /// Zero duty, drivers on: the motors brake.
    Rest,
    /// Check the encoders' signs, open loop.
    Probe {
        /// Names the check; comes back in the event.
        id: u32,
    },
    /// Follow the setpoints, closed loop.
    Track(WheelPair<Setpoint>),
}

/// What the supervisor wants of the control tasks.
#[derive(Clone, Copy)]
pub enum Order {
    /// Zero duty, drivers off.
    Off,
    /// Zero duty, drivers on.
    Rest,
    /// Check the encoders' signs, see [`Shared::check`].
    Probe {
        /// Comes back in the event.
        id: u32,
    },
    /// Follow the plan that waits, see [`Shared::follow`].
    Follow {
        /// Comes back in the event.
        id: u32,
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

/// How to close the loop.
#[derive(Clone)]
pub struct LoopSettings {
    /// The controller's gains and limits.
    pub gains: Gains,
    /// What is watched, and its bounds.
    pub thresholds: Thresholds,
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

/// The wheels and the supply, at one control tick.
#[derive(Clone, Copy)]
pub struct Snapshot {
    /// The wheels as measured.
    pub measured: Measured,
    /// Supply \[mV\].
    pub supply_mv: u16,
}

impl Tick {
    fn telemetry(&self, number: u32, state: shared_proto::State) -> Telemetry {
        Telemetry {
            number,
            t_us: self.measured.t_us,
            state,
            probing: self.probing,
            wheels: WheelPair { left: self.wheel(Wheel::Left), right: self.wheel(Wheel::Right) },
            supply_mv: self.supply_mv,
        }
    }

    fn wheel(&self, wheel: Wheel) -> WheelTelemetry {
        let travel = *self.measured.travel.get(wheel);
        let setpoint = match &self.action {
            Action::Track(setpoints) => setpoints.get(wheel).travel,
            _ => travel,
        };
        WheelTelemetry {
            counts: *self.measured.counts.get(wheel),
            setpoint_um: setpoint.to_um(),
            error_um: setpoint.error_um_from(travel),
            speed_um_s: self.measured.speed.get(wheel).to_um_s(),
            terms: self.loops.get(wheel).terms(),
            duty: self.duty.get(wheel).to_i16(),
        }
    }
}

/// Inputs that stop the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    /// The emergency stop is pressed.
    pub emergency_stop: bool,
    /// The motor driver reports a fault.
    pub driver_fault: bool,
}
