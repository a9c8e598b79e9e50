//! What really crossed the line, and when: all that hosts sent, that the robot heard, and that it answered.

use std::collections::BTreeMap;

use shared_proto::{
    Answer, Channel, Command, Config, Decoder, Event, MotionId, Reply, Request, State, Telemetry,
};
use sim_target::now_us;

/// The requests in these bytes that are whole.
pub(crate) fn requests(bytes: &[u8]) -> Vec<Request> {
    let mut decoder = Decoder::new();
    let whole = bytes.iter().filter_map(|byte| match decoder.push(*byte) {
        Some(Ok(frame)) if frame.channel == Channel::Request => frame.message::<Request>(),
        _ => None,
    });
    whole.collect()
}

/// Everything that the invariants need to know.
#[derive(Default)]
pub(crate) struct Witness {
    /// When a living host last wanted a motion.
    pub wanted_us: Option<u64>,
    /// What hosts wanted to be written.
    pub configs: Vec<Config>,
    /// Whose a motion is, by the session that first asked for it.
    owners: BTreeMap<u32, u32>,
    asked: BTreeMap<(u32, u32), Command>,
    /// When the robot last heard a session arm it: an answer that finds no room is dropped.
    armed_us: BTreeMap<u32, u64>,
    /// The session that the robot has told last that it drives, and since when, by its clock: here the same.
    driver: Option<(u32, u64)>,
    /// When the robot last heard each of these, whole.
    pub heard_arm_us: Option<u64>,
    pub heard_emergency_stop_us: Option<u64>,
    /// When the robot last heard each session, and when somebody or a fault last switched its motors off.
    heard_us: BTreeMap<u32, u64>,
    off_us: Option<u64>,
    heard_clear_us: Option<u64>,
    heard_subscribe_us: Option<u64>,
    /// When telemetry last showed no fault.
    sound_us: u64,
    /// When somebody last made the robot restart.
    pub restarted_us: Option<u64>,
    fault: Option<u32>,
    last: Option<(u32, u64, State)>,
    offset_us: i128,
    /// What was broken on the line itself.
    pub broken: Vec<String>,
}

impl Witness {
    /// The robot's clock, as its last frame showed it \[ms\].
    pub(crate) fn robot_ms(&self) -> u64 {
        u64::try_from((i128::from(now_us()) + self.offset_us) / 1000).unwrap_or(0)
    }

    /// The session that the robot has told last that it drives.
    pub(crate) fn driver(&self) -> Option<u32> {
        self.driver.map(|(session, _)| session)
    }

    /// The number of the fault that was reported last and is not cleared.
    pub(crate) fn fault(&self) -> Option<u32> {
        self.fault
    }

    /// Somebody makes the robot restart: its sessions, numbers and faults begin anew.
    pub(crate) fn restart(&mut self) {
        self.restarted_us = Some(now_us());
        (self.driver, self.fault, self.last) = (None, None, None);
    }

    pub(crate) fn host_sends(&mut self, bytes: &[u8]) {
        for Request { session, id, command, .. } in requests(bytes) {
            match &command {
                Command::Drive(drive) => self.wants(drive.motion, session),
                Command::Velocity(velocity) => self.wants(velocity.motion, session),
                Command::Renew { motion } => self.wants(*motion, session),
                Command::WriteConfig(config) => self.configs.push(config.clone()),
                _ => {}
            }
            self.asked.insert((session, id), command);
        }
    }

    fn wants(&mut self, motion: MotionId, session: u32) {
        self.wanted_us = Some(now_us());
        self.owners.entry(motion.0).or_insert(session);
    }

    pub(crate) fn robot_hears(&mut self, bytes: &[u8]) {
        for request in requests(bytes) {
            self.heard_us.insert(request.session, now_us());
            match request.command {
                Command::Disarm => self.off_us = Some(now_us()),
                Command::Arm { .. } => {
                    self.heard_arm_us = Some(now_us());
                    self.armed_us.insert(request.session, now_us());
                }
                Command::EmergencyStop => {
                    self.heard_emergency_stop_us = Some(now_us());
                    self.off_us = Some(now_us());
                }
                Command::ClearFault { .. } => self.heard_clear_us = Some(now_us()),
                Command::Subscribe { .. } => self.heard_subscribe_us = Some(now_us()),
                _ => {}
            }
        }
    }

    pub(crate) fn robot_sends(&mut self, bytes: &[u8]) {
        let mut decoder = Decoder::new();
        for byte in bytes {
            let Some(Ok(frame)) = decoder.push(*byte) else { continue };
            match frame.channel {
                Channel::Reply => frame.message().into_iter().for_each(|reply| self.reply(&reply)),
                Channel::Telemetry => {
                    frame.message().into_iter().for_each(|telemetry| self.telemetry(&telemetry));
                }
                Channel::Event => frame.message().into_iter().for_each(|event| self.event(&event)),
                _ => {}
            }
        }
    }

    fn reply(&mut self, reply: &Reply) {
        /// What is heard is obeyed within this \[us\].
        const LINE_US: u64 = 20_000;
        self.offset_us = i128::from(reply.t_us) - i128::from(now_us());
        let Ok(answer) = &reply.outcome else { return };
        if let Answer::Status(status) = answer {
            if status.fault.is_some() {
                self.off_us = Some(now_us());
            }
            self.fault = status.fault.map(|report| report.number);
        }
        match self.asked.get(&(reply.session, reply.id)) {
            Some(Command::Arm { take }) => {
                let take = *take;
                self.arms(reply, take);
            }
            Some(command @ (Command::Drive(_) | Command::Velocity(_) | Command::Renew { .. })) => {
                let since_us = self.armed_us.get(&reply.session).copied();
                if let Some((driver, told_us)) = self.driver
                    && driver != reply.session
                    && since_us.is_none_or(|since_us| since_us + LINE_US < told_us)
                {
                    let name = match command {
                        Command::Renew { .. } => "renews its motion",
                        _ => "drives it",
                    };
                    let (session, ms) = (reply.session, now_us() / 1000);
                    self.broken.push(format!(
                        "session {session} {name} at {ms} ms, and {driver} armed it at {} ms",
                        told_us / 1000
                    ));
                }
            }
            _ => {}
        }
    }

    /// The robot has told a session that it drives.
    fn arms(&mut self, reply: &Reply, take: bool) {
        /// A driver that was heard so shortly before still drives: its silence is a second \[us\].
        const ALIVE_US: u64 = 800_000;
        if let Some((driver, told_us)) = self.driver.replace((reply.session, reply.t_us)) {
            let alive =
                self.heard_us.get(&driver).is_some_and(|heard_us| heard_us + ALIVE_US > reply.t_us);
            let off = self.off_us.is_some_and(|off_us| off_us + 20_000 > told_us);
            if driver != reply.session && !take && alive && !off {
                let session = reply.session;
                self.broken.push(format!("session {session} arms it, and {driver} drives"));
            }
        }
    }

    fn event(&mut self, event: &Event) {
        match event {
            Event::Fault(report) => {
                self.fault = Some(report.number);
                self.off_us = Some(now_us());
            }
            Event::MotionEnded { motion, .. } => {
                if let Some(owner) = self.owners.get(&motion.0)
                    && !self.armed_us.contains_key(owner)
                {
                    self.broken.push(format!("a motion of session {owner}, which never drove"));
                }
            }
            Event::State { .. } => {}
        }
    }

    fn telemetry(&mut self, now: &Telemetry) {
        /// A command that is heard takes effect, and shows in telemetry, within this \[us\].
        const EFFECT_US: u64 = 50_000;
        let since = |heard_us: Option<u64>, from_us: u64| {
            heard_us.is_some_and(|heard_us| heard_us + EFFECT_US > from_us)
        };
        if let Some((number, t_us, state)) = self.last.replace((now.number, now.t_us, now.state)) {
            if now.t_us <= t_us {
                self.broken.push(format!("telemetry of {} us after {t_us} us", now.t_us));
            }
            let ahead = now.number.wrapping_sub(number);
            let subscribed = since(self.heard_subscribe_us, now_us());
            if !subscribed && (ahead == 0 || ahead > u32::MAX / 2) {
                self.broken.push(format!("telemetry number {} after {number}", now.number));
            }
            let ended = state == State::Faulted && now.state != State::Faulted;
            if ended && !since(self.heard_clear_us, self.sound_us) {
                self.broken.push(format!("{} after a fault that nobody cleared", now.state.name()));
            }
        }
        if now.state == State::Faulted {
            self.off_us = Some(now_us());
        } else {
            self.sound_us = now_us();
        }
    }
}
