//! The host's requests, and how each is answered.

use core::sync::atomic::Ordering;

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Duration, Instant, Timer};
use shared_proto::{
    Answer, Command, Config, ConfigOrigin, Fault, Identity, PROTOCOL_VERSION, Refusal, Reply,
    Request, State, Status,
};

use super::Supervisor;
use crate::hal::Store;
use crate::liveness::SafetyTask;
use crate::shared::Outgoing;
use crate::units::CONTROL_PERIOD_US;

/// A save waits this long after the one before: a flash sector stands 10,000 erasures, and a host that has gone mad
/// must not wear it out in an hour.
pub(super) const SAVE_EVERY: Duration = Duration::from_secs(1);

/// The driver of an armed robot that stands may be silent for this long.
const DRIVER_SILENCE: Duration = Duration::from_secs(1);

/// Version: major, minor, patch.
const FIRMWARE: [u16; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

/// Parses a version number at compile time.
const fn number(digits: &str) -> u16 {
    match u16::from_str_radix(digits, 10) {
        Ok(number) => number,
        Err(_) => panic!("a version is three numbers"),
    }
}

impl<M: RawMutex, S: Store> Supervisor<'_, M, S> {
    pub(super) async fn on_request(&mut self, request: Request) {
        let permitted = self.permit(&request);
        // A host that repeats a request, because erasing takes long, must not wear out the flash.
        let writes = match request.command {
            Command::SaveConfig => !self.is_saved || self.saved != self.config,
            Command::SetKey { key } => self.key() != Some(key),
            _ => false,
        };
        if writes && permitted.is_ok() && self.motors_off().is_ok() {
            let pause = Timer::at(self.may_save);
            self.shared.liveness.while_waiting(SafetyTask::Supervisor, pause).await;
        }
        let waited = match (permitted, &request.command) {
            (Err(refusal), _) => Err(refusal),
            (Ok(()), Command::WriteConfig(config)) => self.write_config(config).await,
            (Ok(()), Command::SaveConfig | Command::SetKey { .. }) if !writes => self.motors_off(),
            (Ok(()), Command::SaveConfig) => self.save().await,
            (Ok(()), Command::RestoreConfig(origin)) => self.restore(*origin).await,
            (Ok(()), Command::SetKey { key }) => self.open_link(Some(*key)).await,
            (Ok(()), _) => Ok(()),
        };
        self.reply(&request, waited);
    }

    /// Whether this session may do this now: only the driver changes anything, and nothing after its lease.
    fn permit(&mut self, request: &Request) -> Result<(), Refusal> {
        if !request.command.needs_lease() {
            return Ok(());
        }
        let takes = match request.command {
            Command::Arm { take } => take,
            // The driver has not asked for telemetry itself.
            Command::Subscribe { .. } => {
                self.shared.telemetry_period.load(Ordering::Relaxed) == 0
                    || self.driver() != Some(self.subscriber)
            }
            _ => false,
        };
        if self.driver().is_some_and(|driver| driver != request.session) && !takes {
            return Err(Refusal::Driven);
        }
        let now_ms = Instant::now().as_millis();
        if request.until_ms <= now_ms {
            return Err(Refusal::Late);
        }
        if request.until_ms - now_ms > Request::LEASE_MS_MAX {
            return Err(Refusal::Lease);
        }
        self.lease = Instant::from_millis(request.until_ms);
        Ok(())
    }

    /// The session that drives. A robot that stands is nobody's any more once its driver has been silent for a while.
    fn driver(&self) -> Option<u32> {
        let silent = Instant::now() >= self.last_heard() + DRIVER_SILENCE;
        self.shared.driver.get().filter(|_| self.state != State::Armed || !silent)
    }

    /// Executes what needs no waiting, and replies.
    #[inline(never)]
    fn reply(&mut self, request: &Request, waited: Result<(), Refusal>) {
        let outcome = waited.and_then(|()| self.execute(request));
        // Never waits for the line. A host that floods the line, or does not read, must not stop the robot
        // from receiving a renewal, or from noticing that one is missing. The host repeats a request that
        // got no reply.
        let Request { session, id, .. } = *request;
        let reply = Reply { session, id, t_us: Instant::now().as_micros(), outcome };
        let _ = self.shared.outgoing.try_send(Outgoing::Reply(reply));
    }

    fn execute(&mut self, request: &Request) -> Result<Answer, Refusal> {
        match request.command {
            Command::Identify => Ok(Answer::Identity(self.identity())),
            Command::Status => Ok(Answer::Status(self.status())),
            // `on_request` has done this already.
            Command::WriteConfig(_) | Command::SaveConfig | Command::SetKey { .. } => {
                Ok(Answer::Done)
            }
            Command::ReadConfig | Command::RestoreConfig(_) => {
                Ok(Answer::Config(self.config.clone()))
            }
            Command::Arm { .. } => self.execute_arm(request.session),
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
            Command::Drive(ref drive) => self.execute_drive(drive),
            Command::Velocity(ref velocity) => self.execute_velocity(velocity),
            Command::Voltage(ref voltage) => self.execute_voltage(voltage),
            Command::Renew { motion } => {
                if self.motion != Some(motion) {
                    return Err(Refusal::NoSuchMotion);
                }
                self.renew();
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
            Command::ClearFault { number } => self.execute_clear(number),
            Command::Subscribe { period_ms } => {
                if period_ms > 1000 {
                    return Err(Refusal::Period);
                }
                self.subscriber = request.session;
                let ticks = u32::from(period_ms) * 1000 / CONTROL_PERIOD_US;
                self.shared.telemetry_period.store(ticks, Ordering::Relaxed);
                Ok(Answer::Done)
            }
            Command::Recall { number } => {
                self.shared.history.recall(number).map(Answer::Telemetry).ok_or(Refusal::Forgotten)
            }
        }
    }

    fn execute_arm(&mut self, session: u32) -> Result<Answer, Refusal> {
        self.not_faulted()?;
        if self.state == State::Idle {
            let now_us = Instant::now().as_micros();
            let inputs = self.shared.safety_inputs.get();
            if inputs.emergency_stop || inputs.stop_line {
                self.shared.raise(Fault::EmergencyStop, now_us);
            } else if inputs.driver_fault {
                self.shared.raise(Fault::Driver, now_us);
            } else if let Some(fault) = self.supply_fault() {
                self.shared.raise(fault, now_us);
            }
            self.not_faulted()?;
            self.arm();
        }
        self.shared.driver.set(Some(session));
        // The link's task has noted frames of the driver before: this one was heard just now.
        self.shared.heard_us.set(Instant::now().as_micros());
        Ok(Answer::Done)
    }

    pub(super) fn execute_clear(&mut self, number: u32) -> Result<Answer, Refusal> {
        match self.shared.fault.report() {
            None if number == self.shared.fault.last_number() => Ok(Answer::Done),
            None => Err(Refusal::NoSuchFault),
            Some(report) if report.number != number => Err(Refusal::NoSuchFault),
            Some(_) if self.state != State::Faulted => Err(Refusal::State(self.state)),
            Some(report) => {
                let inputs = self.shared.safety_inputs.get();
                if inputs.emergency_stop
                    || inputs.stop_line
                    || inputs.driver_fault
                    || self.supply_fault() == Some(report.fault)
                {
                    return Err(Refusal::CauseRemains);
                }
                self.clear_fault();
                Ok(Answer::Done)
            }
        }
    }

    async fn write_config(&mut self, config: &Config) -> Result<(), Refusal> {
        config.validate().map_err(Refusal::Config)?;
        self.may_take(config)?;
        self.config.clone_from(config);
        self.configure().await;
        Ok(())
    }

    async fn restore(&mut self, origin: ConfigOrigin) -> Result<(), Refusal> {
        let config = match origin {
            ConfigOrigin::Factory => Config::default(),
            ConfigOrigin::Saved => self.saved.clone(),
        };
        self.may_take(&config)?;
        self.config = config;
        self.configure().await;
        Ok(())
    }

    async fn save(&mut self) -> Result<(), Refusal> {
        self.motors_off()?;
        let save = self.store.save(&self.config);
        let saved = self.shared.liveness.while_waiting(SafetyTask::Supervisor, save).await;
        self.may_save = Instant::now() + SAVE_EVERY;
        saved.map_err(|_| Refusal::Store)?;
        self.saved.clone_from(&self.config);
        self.is_saved = true;
        self.config_origin = ConfigOrigin::Saved;
        self.store_damaged = false;
        Ok(())
    }

    pub(super) fn not_faulted(&self) -> Result<(), Refusal> {
        self.shared.fault.report().map_or(Ok(()), |report| Err(Refusal::Faulted(report)))
    }

    /// Erasing flash can stall the CPU.
    pub(super) fn motors_off(&self) -> Result<(), Refusal> {
        match self.state {
            State::Idle | State::Faulted => Ok(()),
            state => Err(Refusal::State(state)),
        }
    }

    /// Whether this configuration may be taken on now: another one not while the wheels move, and another driver
    /// only while the driver is off.
    fn may_take(&self, config: &Config) -> Result<(), Refusal> {
        match self.state {
            State::Idle | State::Faulted => Ok(()),
            State::Armed if config.driver == self.config.driver => Ok(()),
            state => Err(Refusal::State(state)),
        }
    }

    fn identity(&self) -> Identity {
        Identity {
            name: self.config.name.clone(),
            board: self.board.board.clone(),
            uid: self.board.uid,
            firmware: FIRMWARE,
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
            tick_delay_us_max: self.shared.tick_delay_us_max.load(Ordering::Relaxed),
            ticks_lost: self.shared.ticks_lost.get(),
        }
    }
}
