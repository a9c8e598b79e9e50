//! Supervisor: the robot's state machine, and the only one that answers requests.
//!
//! ```text
//!  boot --> idle <--> armed <--> driving --> stopping --> armed, idle or faulted
//!             ^                                                        |
//!             +--------------------- clear fault ----------------------+      any state --> faulted
//! ```
//!
//! It plans motions (slow arithmetic, outside the control tick) and hands them to the profile task
//! a few ticks ahead, so that a new plan takes over exactly where the old one will be.

use embassy_futures::select::{Either3, select3};
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Duration, Instant, Timer};
use shared_proto::{
    Answer, Command, Config, ConfigOrigin, Drive, Event, Fault, Identity, MotionEnd, MotionError,
    MotionId, PROTOCOL_VERSION, Refusal, Reply, Request, State, Status, WheelPair,
};

use crate::hal::{BoardInfo, Store};
use crate::odometry::Odometry;
use crate::pid::Gains;
use crate::probe::{Direction, Probe};
use crate::profile::{Plan, ProfileState};
use crate::protection::Protection;
use crate::shared::{CaptureSettings, ControlEvent, LoopSettings, Order, Outgoing, Shared};
use crate::units::CONTROL_PERIOD_US;

/// A plan starts this many ticks after it was made: planning may take most of that on a slow MCU.
const PLAN_AHEAD_TICKS: u32 = 10;

/// An armed robot that stands still and hears nothing for this long switches its motors off.
const ARMED_SILENCE: Duration = Duration::from_secs(60);

/// Runs the robot, for ever.
pub async fn run<M: RawMutex>(shared: &Shared<M>, store: impl Store, board: BoardInfo) -> ! {
    let mut supervisor = Supervisor::boot(shared, store, board).await;
    loop {
        let deadline = supervisor.deadline();
        match select3(
            shared.control_events.receive(),
            shared.requests.receive(),
            Timer::at(deadline.unwrap_or(Instant::MAX)),
        )
        .await
        {
            Either3::First(event) => supervisor.on_control(event),
            Either3::Second(request) => supervisor.on_request(request).await,
            Either3::Third(()) => supervisor.on_deadline(),
        }
        supervisor.on_fault();
    }
}

/// The state, and what belongs to it.
struct Supervisor<'a, M: RawMutex, S> {
    shared: &'a Shared<M>,
    store: S,
    board: BoardInfo,
    config: Config,
    config_origin: ConfigOrigin,
    store_damaged: bool,
    /// What the store holds; the factory configuration if it holds none.
    saved: Config,
    state: State,
    /// The encoders' signs have been checked since the motors were switched on.
    probed: bool,
    /// The motion under way, or the last one.
    motion: Option<MotionId>,
    motion_end: Option<MotionEnd>,
    /// When the motion's time to live ends.
    alive_until: Instant,
    /// A motion that waits for the end of the encoder check, and where the wheels were before it.
    waiting: Option<(Drive, WheelPair<ProfileState>)>,
    /// The plan that the profile task follows.
    plan: Option<Plan>,
    /// The order given last.
    order_id: u32,
    /// Where a controlled stop ends.
    after_stop: State,
}

impl<'a, M: RawMutex, S: Store> Supervisor<'a, M, S> {
    /// Power-on to idle.
    async fn boot(shared: &'a Shared<M>, mut store: S, board: BoardInfo) -> Self {
        let loaded = store.load().await;
        // What is readable but unphysical was not written by this firmware.
        let loaded =
            loaded.ok().filter(|saved| saved.as_ref().is_none_or(|c| c.validate().is_ok()));
        let store_damaged = loaded.is_none();
        let saved = loaded.flatten();
        let config_origin =
            if saved.is_some() { ConfigOrigin::Saved } else { ConfigOrigin::Factory };
        let supervisor = Self {
            shared,
            store,
            board,
            config: saved.clone().unwrap_or_default(),
            config_origin,
            store_damaged,
            saved: saved.unwrap_or_default(),
            state: State::Idle,
            probed: false,
            motion: None,
            motion_end: None,
            alive_until: Instant::MIN,
            waiting: None,
            plan: None,
            order_id: 0,
            after_stop: State::Armed,
        };
        supervisor.configure_control().await;
        shared.state.set(State::Idle);
        supervisor
    }

    // ---- transitions -------------------------------------------------------------------------

    /// Idle to armed.
    fn arm(&mut self) {
        self.probed = false;
        self.shared.order.signal(Order::Rest);
        self.enter(State::Armed);
    }

    /// Armed to idle.
    fn disarm(&mut self) {
        self.shared.order.signal(Order::Off);
        self.enter(State::Idle);
    }

    /// Armed to driving, by way of the encoder check.
    fn begin_probe(&mut self, drive: Drive, from: WheelPair<ProfileState>) {
        let id = self.next_order();
        let counts = self.shared.snapshot.get().measured.counts;
        let probe = Probe::new(&self.config, counts, drive.distance.map(Direction::of));
        self.waiting = Some((drive, from));
        self.plan = None;
        self.shared.order.signal(Order::Probe { id, probe });
        self.enter(State::Driving);
    }

    /// Armed or driving to driving.
    fn follow(&mut self, plan: Plan) {
        let id = self.next_order();
        self.waiting = None;
        self.plan = Some(plan.clone());
        self.shared.order.signal(Order::Follow { id, plan });
        self.enter(State::Driving);
    }

    /// Driving to stopping; `then` is where it ends.
    fn begin_stop(&mut self, then: State) {
        self.after_stop = then;
        match self.plan.take() {
            Some(plan) => {
                let start = self.ahead();
                let deceleration = self.config.limits.stop_deceleration_mps2;
                let stop = Plan::stop(start, plan.at(start), deceleration);
                let id = self.next_order();
                self.plan = Some(stop.clone());
                self.shared.order.signal(Order::Follow { id, plan: stop });
                self.enter(State::Stopping);
            }
            // Only the encoder check was under way: nothing moves that needs a ramp.
            None => {
                self.shared.order.signal(Order::Rest);
                self.enter(State::Stopping);
                self.end_stop();
            }
        }
    }

    /// Stopping to armed, idle or faulted.
    fn end_stop(&mut self) {
        match self.after_stop {
            State::Idle => {
                self.end_motion(MotionEnd::Stopped);
                self.disarm();
            }
            State::Faulted => self.fault(),
            _ => {
                self.end_motion(MotionEnd::Stopped);
                self.enter(State::Armed);
            }
        }
    }

    /// Driving to armed.
    fn complete(&mut self) {
        self.end_motion(MotionEnd::Completed);
        self.enter(State::Armed);
    }

    /// Any state to faulted.
    fn fault(&mut self) {
        self.shared.order.signal(Order::Off);
        if self.motion_end.is_none() && self.motion.is_some() {
            self.end_motion(MotionEnd::Faulted);
        }
        self.plan = None;
        self.waiting = None;
        self.enter(State::Faulted);
    }

    /// Faulted to idle.
    fn clear_fault(&mut self) {
        self.shared.fault.clear();
        self.shared.order.signal(Order::Off);
        self.enter(State::Idle);
    }

    // ---- what makes them happen --------------------------------------------------------------

    fn on_control(&mut self, event: ControlEvent) {
        match event {
            ControlEvent::Probed(id) if id == self.order_id => {
                let Some((drive, from)) = self.waiting.take() else { return };
                self.probed = true;
                // Where the wheels were before the check moved them: the motion includes it.
                match Plan::drive(self.ahead(), from, &drive, &self.config) {
                    Ok(plan) => self.follow(plan),
                    // It was planned once before the check; the configuration is the same.
                    Err(_) => self.begin_stop(State::Armed),
                }
            }
            ControlEvent::Settled(id) if id == self.order_id => {
                self.plan = None;
                match self.state {
                    State::Stopping => self.end_stop(),
                    State::Driving => self.complete(),
                    _ => {}
                }
            }
            // Of an order that another has replaced; faults are looked at below, every time.
            ControlEvent::Probed(_) | ControlEvent::Settled(_) | ControlEvent::Faulted => {}
        }
    }

    fn on_deadline(&mut self) {
        let now = Instant::now();
        match self.state {
            State::Driving => {
                if now >= self.heard() + self.link_timeout() {
                    self.shared.raise(Fault::LinkLost, now.as_micros());
                } else if now >= self.alive_until {
                    self.shared.raise(Fault::TimeToLive, now.as_micros());
                }
            }
            State::Armed if now >= self.heard() + ARMED_SILENCE => self.disarm(),
            _ => {}
        }
    }

    /// When to look again although nothing happened.
    fn deadline(&self) -> Option<Instant> {
        match self.state {
            State::Driving => Some(self.alive_until.min(self.heard() + self.link_timeout())),
            State::Armed => Some(self.heard() + ARMED_SILENCE),
            _ => None,
        }
    }

    fn on_fault(&mut self) {
        let Some(report) = self.shared.fault.report() else { return };
        let cut = self.shared.fault.cuts_motors();
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

    async fn on_request(&mut self, request: Request) {
        let Request { id, command } = request;
        let outcome = self.obey(command).await;
        self.shared.outgoing.send(Outgoing::Reply(Reply { id, outcome })).await;
    }

    async fn obey(&mut self, command: Command) -> Result<Answer, Refusal> {
        match command {
            Command::Identify => Ok(Answer::Identity(self.identity())),
            Command::Status => Ok(Answer::Status(self.status())),
            Command::ReadConfig => Ok(Answer::Config(self.config.clone())),
            Command::WriteConfig(config) => {
                config.validate().map_err(Refusal::Config)?;
                self.standing_still()?;
                self.configure(config).await;
                Ok(Answer::Done)
            }
            Command::SaveConfig => self.save().await,
            Command::RestoreConfig(origin) => self.restore(origin).await,
            Command::Arm => self.obey_arm(),
            Command::Disarm => {
                match self.state {
                    State::Armed => self.disarm(),
                    State::Driving => self.begin_stop(State::Idle),
                    State::Stopping if self.after_stop == State::Armed => {
                        self.after_stop = State::Idle;
                    }
                    _ => {}
                }
                Ok(Answer::Done)
            }
            Command::Drive(drive) => self.obey_drive(drive),
            Command::Renew { motion, ttl_ms } => {
                if self.motion != Some(motion) {
                    return Err(Refusal::NoSuchMotion);
                }
                self.renew(ttl_ms)?;
                Ok(Answer::Done)
            }
            Command::Stop => {
                if self.state == State::Driving {
                    self.begin_stop(State::Armed);
                }
                Ok(Answer::Done)
            }
            Command::EmergencyStop => {
                self.shared.raise(Fault::EmergencyStop, Instant::now().as_micros());
                Ok(Answer::Done)
            }
            Command::ClearFault { number } => self.obey_clear(number),
            Command::Subscribe { period_ms } => {
                if period_ms > 1000 {
                    return Err(Refusal::Period);
                }
                let ticks = u32::from(period_ms) * 1000 / CONTROL_PERIOD_US;
                self.shared.telemetry_period.set(ticks);
                Ok(Answer::Done)
            }
        }
    }

    fn obey_arm(&mut self) -> Result<Answer, Refusal> {
        self.not_faulted()?;
        if self.state == State::Idle {
            let now_us = Instant::now().as_micros();
            let lines = self.shared.lines.get();
            let supply_mv = self.shared.snapshot.get().supply_mv;
            if lines.emergency_stop {
                self.shared.raise(Fault::EmergencyStop, now_us);
            } else if lines.driver_fault {
                self.shared.raise(Fault::Driver, now_us);
            } else if supply_mv < self.supply_mv_min() {
                self.shared.raise(Fault::SupplyLow, now_us);
            }
            self.not_faulted()?;
            self.arm();
        }
        Ok(Answer::Done)
    }

    fn obey_drive(&mut self, drive: Drive) -> Result<Answer, Refusal> {
        self.not_faulted()?;
        if self.motion == Some(drive.motion) {
            // Heard before. If it still drives, this counts as a renewal.
            if self.motion_end.is_none() {
                self.renew(drive.ttl_ms)?;
            }
            return Ok(Answer::Done);
        }
        let stopping_to_armed = self.state == State::Stopping && self.after_stop == State::Armed;
        if !(matches!(self.state, State::Armed | State::Driving) || stopping_to_armed) {
            return Err(Refusal::State(self.state));
        }
        if !Drive::TTL_MS.contains(&drive.ttl_ms) {
            return Err(Refusal::Motion(MotionError::TimeToLive));
        }
        let start = self.ahead();
        let from = match (&self.plan, &self.waiting) {
            (Some(plan), _) => plan.at(start),
            (None, Some((_, from))) => *from,
            (None, None) => Plan::hold(self.shared.snapshot.get().measured.travel).at(start),
        };
        let plan = Plan::drive(start, from, &drive, &self.config).map_err(Refusal::Motion)?;
        if self.motion.is_some() && self.motion_end.is_none() {
            self.end_motion(MotionEnd::Replaced);
        }
        self.motion = Some(drive.motion);
        self.motion_end = None;
        self.renew(drive.ttl_ms)?;
        if self.probed {
            self.follow(plan);
        } else {
            self.begin_probe(drive, from);
        }
        Ok(Answer::Done)
    }

    fn obey_clear(&mut self, number: u32) -> Result<Answer, Refusal> {
        match self.shared.fault.report() {
            None if number == self.shared.fault.last_number() => Ok(Answer::Done),
            None => Err(Refusal::NoSuchFault),
            Some(report) if report.number != number => Err(Refusal::NoSuchFault),
            Some(_) if self.state != State::Faulted => Err(Refusal::State(self.state)),
            Some(report) => {
                let lines = self.shared.lines.get();
                let supply_low = self.shared.snapshot.get().supply_mv < self.supply_mv_min();
                if lines.emergency_stop
                    || lines.driver_fault
                    || (supply_low && report.fault == Fault::SupplyLow)
                {
                    return Err(Refusal::CauseRemains);
                }
                self.clear_fault();
                Ok(Answer::Done)
            }
        }
    }

    async fn save(&mut self) -> Result<Answer, Refusal> {
        // Erasing flash can stall the CPU; the motors are off then.
        if !matches!(self.state, State::Idle | State::Faulted) {
            return Err(Refusal::State(self.state));
        }
        self.store.save(&self.config).await.map_err(|_| Refusal::Store)?;
        self.saved = self.config.clone();
        self.store_damaged = false;
        Ok(Answer::Done)
    }

    async fn restore(&mut self, origin: ConfigOrigin) -> Result<Answer, Refusal> {
        self.standing_still()?;
        let config = match origin {
            ConfigOrigin::Factory => Config::default(),
            ConfigOrigin::Saved => self.saved.clone(),
        };
        self.configure(config).await;
        Ok(Answer::Config(self.config.clone()))
    }

    // ---- small parts -------------------------------------------------------------------------

    fn enter(&mut self, state: State) {
        if self.state != state {
            self.state = state;
            self.shared.state.set(state);
            self.tell(Event::State { t_us: Instant::now().as_micros(), state });
        }
    }

    fn end_motion(&mut self, end: MotionEnd) {
        self.motion_end = Some(end);
        self.plan = None;
        if let Some(motion) = self.motion {
            self.tell(Event::MotionEnded { t_us: Instant::now().as_micros(), motion, end });
        }
    }

    /// Tells the host, if the line is not busy: events repeat what [`Status`] says.
    fn tell(&self, event: Event) {
        let _ = self.shared.outgoing.try_send(Outgoing::Event(event));
    }

    fn next_order(&mut self) -> u32 {
        self.order_id = self.order_id.wrapping_add(1);
        self.order_id
    }

    fn ahead(&self) -> u32 {
        self.shared.snapshot.get().measured.tick.wrapping_add(PLAN_AHEAD_TICKS)
    }

    fn heard(&self) -> Instant {
        Instant::from_micros(self.shared.heard_us.get())
    }

    fn link_timeout(&self) -> Duration {
        Duration::from_micros((self.config.protection.link_timeout_s * 1e6) as u64)
    }

    fn supply_mv_min(&self) -> u16 {
        (self.config.protection.supply_v_min * 1000.0) as u16
    }

    fn renew(&mut self, ttl_ms: u16) -> Result<(), Refusal> {
        if !Drive::TTL_MS.contains(&ttl_ms) {
            return Err(Refusal::Motion(MotionError::TimeToLive));
        }
        self.alive_until = Instant::now() + Duration::from_millis(u64::from(ttl_ms));
        Ok(())
    }

    fn not_faulted(&self) -> Result<(), Refusal> {
        self.shared.fault.report().map_or(Ok(()), |report| Err(Refusal::Faulted(report)))
    }

    fn standing_still(&self) -> Result<(), Refusal> {
        match self.state {
            State::Idle | State::Armed | State::Faulted => Ok(()),
            state => Err(Refusal::State(state)),
        }
    }

    async fn configure(&mut self, config: Config) {
        self.config = config;
        self.probed = false;
        self.configure_control().await;
    }

    /// Hands the configuration to the control tasks, and waits until they have measured with it:
    /// nothing is armed before the supply is known, nor planned from travel in the old scale.
    async fn configure_control(&self) {
        let config = &self.config;
        self.shared.capture_settings.signal(CaptureSettings {
            odometry: Odometry::new(config),
            reversed: config.encoder.as_ref().map(|encoder| encoder.reversed),
        });
        self.shared.loop_settings.signal(LoopSettings {
            gains: Gains::new(config),
            protection: Protection::new(config),
            reversed: config.motor.as_ref().map(|motor| motor.reversed),
            supply_mv_min: self.supply_mv_min(),
        });
        // The tick that is under way may still be one of before.
        let before = self.shared.snapshot.get().measured.tick;
        while self.shared.snapshot.get().measured.tick.wrapping_sub(before) < 2 {
            Timer::after_micros(CONTROL_PERIOD_US.into()).await;
        }
    }

    fn identity(&self) -> Identity {
        let part = |text: &str| text.parse().unwrap_or(0);
        Identity {
            name: self.config.name.clone(),
            board: self.board.board.clone(),
            uid: self.board.uid,
            firmware: [
                part(env!("CARGO_PKG_VERSION_MAJOR")),
                part(env!("CARGO_PKG_VERSION_MINOR")),
                part(env!("CARGO_PKG_VERSION_PATCH")),
            ],
            protocol: PROTOCOL_VERSION,
            control_period_us: CONTROL_PERIOD_US,
            limits: self.config.limits,
            reset_cause: self.board.reset_cause,
            config_origin: self.config_origin,
            store_damaged: self.store_damaged,
            unsaved: self.config != self.saved,
        }
    }

    fn status(&self) -> Status {
        let snapshot = self.shared.snapshot.get();
        Status {
            t_us: Instant::now().as_micros(),
            state: self.state,
            motion: self.motion,
            motion_end: self.motion_end,
            fault: self.shared.fault.report(),
            supply_mv: snapshot.supply_mv,
            link: self.shared.link.get(),
            ticks: snapshot.measured.tick,
            tick_delay_us_max: self.shared.tick_delay_us_max.get(),
        }
    }
}
