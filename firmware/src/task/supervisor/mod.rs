//! Supervisor: the robot's state machine. Only this task executes requests.
//!
//! ```text
//!  boot --> idle <--> armed <--> driving --> stopping --> armed, idle or faulted
//!             ^                                                        |
//!             +--------------------- clear fault ----------------------+      any state --> faulted
//! ```
//!
//! The supervisor plans motions outside the control tick, because planning is slow, and hands a plan to the
//! profile task a few ticks ahead: the new plan starts exactly where the old one will be then.
//!
//! It never waits for the link: a reply or an event that does not fit in the queue is dropped. It does wait
//! for the store, at boot and when a configuration is saved (once a second at most), and for two control ticks
//! after a change of configuration; the motors stand still then.

mod access;
mod motion_command;
mod motions;
mod requests;
mod transitions;

use embassy_futures::select::{Either3, select3};
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Duration, Instant, Timer};
use shared_proto::{
    Config, ConfigOrigin, Event, Fault, MotionEnd, MotionId, State, Velocity, Wheel, WheelPair,
};

use crate::capture::CaptureSettings;
use crate::dead_reckoning::Geometry;
use crate::hal::{BoardInfo, Store};
use crate::liveness::SafetyTask;
use crate::pid::Gains;
use crate::pose_covariance::Uncertainty;
use crate::profile::{Plan, ProfileState};
use crate::protection::Thresholds;
use crate::shared::{
    ControlEvent, FaultLine, LoopSettings, OdometryOrder, Outgoing, Shared, SupplyLimits,
};
use crate::soft_float::truncate;
use crate::units::CONTROL_PERIOD_US;
use motion_command::{EARLIER_MOTIONS, MotionCommand};

/// A plan starts this many ticks ahead: planning may take most of that time on a slow MCU.
const PLAN_AHEAD_TICKS: u32 = 10;

/// After this time a new plan is under way.
const PLAN_AHEAD: Duration =
    Duration::from_micros((PLAN_AHEAD_TICKS as u64 + 1) * CONTROL_PERIOD_US as u64);

/// An armed robot that stands still and receives nothing for this long switches its motors off.
const ARMED_SILENCE: Duration = Duration::from_secs(60);

/// This late the supervisor may act on a host's silence before the control tick does.
const SUPERVISOR_DELAY_MAX: Duration = Duration::from_millis(20);

/// Zero duty at the latest after this silence, if the supervisor does not act: two ticks before 250 ms.
const SILENCE_MAX: Duration = Duration::from_millis(248);

/// Runs the robot, for ever.
pub async fn run<M: RawMutex>(shared: &Shared<M>, store: impl Store, board: BoardInfo) -> ! {
    let mut supervisor = Supervisor::new(shared, store, board);
    supervisor.boot().await;
    loop {
        supervisor.grant();
        let deadline = supervisor.deadline();
        let news = select3(
            shared.control_events.receive(),
            shared.requests.ready_to_receive(),
            Timer::at(deadline.unwrap_or(Instant::MAX)),
        );
        match shared.liveness.while_waiting(SafetyTask::Supervisor, news).await {
            Either3::First(event) => supervisor.on_control(event),
            Either3::Second(()) => {
                if let Ok(request) = shared.requests.try_receive() {
                    supervisor.on_request(request).await;
                }
            }
            Either3::Third(()) => supervisor.on_deadline(),
        }
        supervisor.on_fault();
    }
}

/// The state machine's state.
struct Supervisor<'a, M: RawMutex, S> {
    shared: &'a Shared<M>,
    store: S,
    board: BoardInfo,
    config: Config,
    config_origin: ConfigOrigin,
    store_damaged: bool,
    /// The saved configuration; the factory configuration if none was saved.
    saved: Config,
    /// The store holds a configuration.
    is_saved: bool,
    /// When the next save may begin.
    may_save: Instant,
    state: State,
    /// Whose encoder's sign has been checked since the motors were switched on.
    probed: WheelPair<bool>,
    /// The motion under way, or the last one.
    motion: Option<MotionId>,
    motion_end: Option<MotionEnd>,
    /// The motions before that: an old command that arrives late must not start a motion.
    earlier_motions: [Option<MotionId>; EARLIER_MOTIONS],
    /// How many motions there have been: the index of the next one.
    motions: usize,
    /// When the lease of the request in hand ends.
    lease: Instant,
    /// When the motion's lease ends.
    alive_until: Instant,
    /// When that lease was given.
    renewed: Instant,
    /// The velocity, while the motion under way is one.
    velocity: Option<Velocity>,
    /// A velocity that came before the last plan had begun: it is planned as soon as that has.
    next_velocity: Option<Velocity>,
    /// The session that asked for telemetry last.
    subscriber: u32,
    /// When the last plan begins.
    plan_starts: Instant,
    /// A motion that waits for its start time or for the encoder check, and the wheels' state before it.
    waiting: Option<(MotionCommand, WheelPair<ProfileState>)>,
    /// When that motion starts, unless it starts at once.
    start_at: Option<Instant>,
    /// A voltage is under way: there is no plan, and the loop is open.
    open_loop: bool,
    /// The plan that the profile task follows.
    plan: Option<Plan>,
    /// Whose encoder the check under way is checking.
    probing: WheelPair<bool>,
    /// The id of the last order.
    order_id: u32,
    /// The state that follows a controlled stop.
    after_stop: State,
}

impl<'a, M: RawMutex, S: Store> Supervisor<'a, M, S> {
    /// The state at power-on, with the factory configuration.
    fn new(shared: &'a Shared<M>, store: S, board: BoardInfo) -> Self {
        Self {
            shared,
            store,
            board,
            config: Config::default(),
            config_origin: ConfigOrigin::Factory,
            store_damaged: false,
            is_saved: false,
            may_save: Instant::MIN,
            saved: Config::default(),
            state: State::Idle,
            probed: WheelPair::both(false),
            motion: None,
            motion_end: None,
            earlier_motions: [None; EARLIER_MOTIONS],
            motions: 0,
            lease: Instant::MIN,
            alive_until: Instant::MIN,
            renewed: Instant::MIN,
            velocity: None,
            next_velocity: None,
            subscriber: 0,
            plan_starts: Instant::MIN,
            waiting: None,
            start_at: None,
            open_loop: false,
            plan: None,
            probing: WheelPair::both(false),
            order_id: 0,
            after_stop: State::Armed,
        }
    }

    /// Power-on to idle.
    async fn boot(&mut self) {
        let load = self.store.load();
        match self.shared.liveness.while_waiting(SafetyTask::Supervisor, load).await {
            Ok(None) => {}
            Ok(Some(saved)) if saved.validate().is_ok() => {
                self.saved = saved;
                self.is_saved = true;
                self.config_origin = ConfigOrigin::Saved;
                self.config.clone_from(&self.saved);
            }
            // This firmware does not save an invalid configuration.
            Ok(Some(_)) | Err(_) => self.store_damaged = true,
        }
        self.configure().await;
        let _ = self.open_link(None).await;
        self.shared.state.set(State::Idle);
    }

    fn on_control(&mut self, event: ControlEvent) {
        match event {
            ControlEvent::Probed(id, stood) if id == self.order_id => {
                let Some((wanted, _)) = self.waiting.take() else { return };
                self.probed = self.probed.zip(self.probing).map(|(before, now)| before || now);
                // Planned from before the check: the motion includes the check's travel.
                self.begin(&wanted, self.standing(stood));
            }
            ControlEvent::Settled(id) if id == self.order_id => {
                self.plan = None;
                self.next_velocity = None;
                match self.state {
                    State::Stopping => self.end_stop(),
                    State::Driving => self.complete(MotionEnd::Completed),
                    _ => {}
                }
            }
            ControlEvent::Rolled(id, end) if id == self.order_id => {
                self.open_loop = false;
                match self.state {
                    State::Stopping => self.end_stop(),
                    State::Driving => self.complete(end),
                    _ => {}
                }
            }
            ControlEvent::ClearRequested => {
                if let Some(report) = self.shared.fault.report()
                    && report.fault == Fault::EmergencyStop
                {
                    // The same conditions apply as to a host's command.
                    let _ = self.execute_clear(report.number);
                }
            }
            // These belong to a replaced order; `on_fault` runs after every event.
            ControlEvent::Probed(..)
            | ControlEvent::Settled(_)
            | ControlEvent::Rolled(..)
            | ControlEvent::Faulted => {}
        }
    }

    fn on_deadline(&mut self) {
        let now = Instant::now();
        match self.state {
            State::Driving => {
                if self.velocity.is_some() && now >= self.silence() {
                    // Whichever ends first, its time to live or the permitted silence: a velocity just ends.
                    self.begin_stop(State::Armed);
                } else if now >= self.last_heard() + self.link_timeout() {
                    self.shared.raise(Fault::LinkLost, now.as_micros());
                } else if now >= self.alive_until {
                    let silent = self.last_heard() <= self.renewed;
                    let fault = if silent { Fault::LinkLost } else { Fault::TimeToLive };
                    self.shared.raise(fault, now.as_micros());
                } else if self.start_at.is_some_and(|start_at| now >= start_at) {
                    self.end_wait();
                } else if now >= self.plan_starts
                    && let Some(velocity) = self.next_velocity.take()
                {
                    self.change_velocity(velocity);
                }
            }
            State::Armed if now >= self.last_heard() + ARMED_SILENCE => self.disarm(),
            _ => {}
        }
    }

    /// When `on_deadline` is due, if no event comes first.
    fn deadline(&self) -> Option<Instant> {
        match self.state {
            State::Driving => {
                let change = self.next_velocity.and(Some(self.plan_starts));
                [self.start_at, change].into_iter().flatten().chain([self.silence()]).min()
            }
            State::Armed => Some(self.last_heard() + ARMED_SILENCE),
            _ => None,
        }
    }

    /// When the host has been silent for too long, unless more is heard.
    fn silence(&self) -> Instant {
        self.alive_until.min(self.last_heard() + self.link_timeout())
    }

    /// Tells the control tick how long the motors may be driven. This task acts on a silent host first,
    /// along a ramp; the control tick acts a little later, at once, if this task did not.
    fn grant(&self) {
        if self.state != State::Driving {
            self.shared.dead_man.rest();
            return;
        }
        let latest = self.last_heard() + SILENCE_MAX;
        let until = (self.silence() + SUPERVISOR_DELAY_MAX).min(latest);
        let left_us = until.saturating_duration_since(Instant::now()).as_micros();
        let ticks = left_us / u64::from(CONTROL_PERIOD_US);
        self.shared.dead_man.grant(u32::try_from(ticks).unwrap_or(u32::MAX));
    }

    fn on_fault(&mut self) {
        let Some(report) = self.shared.fault.report() else { return };
        let cut = self.shared.fault.forces_motors_off();
        match self.state {
            State::Faulted => {}
            State::Driving if !cut => {
                self.tell(Event::Fault(report));
                self.begin_stop(State::Faulted);
            }
            State::Stopping if !cut => self.after_stop = State::Faulted,
            _ => {
                self.tell(Event::Fault(report));
                self.fault();
            }
        }
    }

    fn enter(&mut self, state: State) {
        if matches!(state, State::Idle | State::Faulted) {
            self.shared.driver.set(None);
        }
        if self.state != state {
            self.state = state;
            self.shared.state.set(state);
            self.tell(Event::State { t_us: Instant::now().as_micros(), state });
        }
    }

    fn end_motion(&mut self, end: MotionEnd) {
        self.motion_end = Some(end);
        self.plan = None;
        self.velocity = None;
        self.next_velocity = None;
        if let Some(motion) = self.motion {
            self.tell(Event::MotionEnded { t_us: Instant::now().as_micros(), motion, end });
        }
    }

    /// Sends an event, unless the line is busy: [`Status`](shared_proto::Status) gives the same information.
    fn tell(&self, event: Event) {
        let _ = self.shared.outgoing.try_send(Outgoing::Event(event));
    }

    fn next_order(&mut self) -> u32 {
        self.order_id = self.order_id.wrapping_add(1);
        self.order_id
    }

    fn plan_start_tick(&self) -> u32 {
        self.shared.snapshot.get().measured.tick.wrapping_add(PLAN_AHEAD_TICKS)
    }

    fn last_heard(&self) -> Instant {
        Instant::from_micros(self.shared.heard_us.get())
    }

    fn link_timeout(&self) -> Duration {
        Duration::from_micros(truncate(self.config.protection.link_timeout_s * 1e6, 0) as u64)
    }

    /// How long the wheels hold their place after a motion.
    fn hold_ticks(&self) -> u32 {
        truncate(self.config.limits.hold_s * 1e6, 0) as u32 / CONTROL_PERIOD_US
    }

    /// What is wrong with the supply as it was at the last tick.
    fn supply_fault(&self) -> Option<Fault> {
        let (limits, supply_mv) =
            (SupplyLimits::new(&self.config), self.shared.snapshot.get().supply_mv);
        match limits.admits(supply_mv) {
            true => None,
            false if u32::from(supply_mv) < limits.min => Some(Fault::SupplyLow),
            false => Some(Fault::SupplyHigh),
        }
    }

    /// Hands the configuration to the control tasks and waits for their first measurement with it. So the
    /// supply is known before arming, and no motion is planned from travel in the old scale.
    async fn configure(&mut self) {
        self.probed = WheelPair::both(false);
        self.shared.follow_wheels.put(OdometryOrder::Pause);
        self.publish_settings();
        // The present tick may still use the old configuration.
        let before = self.shared.snapshot.get().measured.tick;
        while self.shared.snapshot.get().measured.tick.wrapping_sub(before) < 2 {
            Timer::after_micros(CONTROL_PERIOD_US.into()).await;
        }
        let (geometry, known) = (Geometry::new(&self.config), Uncertainty::new(&self.config));
        self.shared.follow_wheels.put(OdometryOrder::With(geometry, known));
    }

    #[inline(never)]
    fn publish_settings(&self) {
        let config = &self.config;
        self.shared.capture_settings.put(CaptureSettings::new(config));
        self.shared.loop_settings.put(LoopSettings {
            gains: WheelPair {
                left: Gains::new(config, Wheel::Left),
                right: Gains::new(config, Wheel::Right),
            },
            thresholds: Thresholds::new(config),
            reversed: config.motor.as_ref().map(|motor| motor.reversed),
            supply_mv: SupplyLimits::new(config),
            driver: config.driver,
        });
        self.shared.fault_line.set(FaultLine::new(&config.driver));
    }
}
