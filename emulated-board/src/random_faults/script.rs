//! The host's part: it arms the robot, drives, and looks what became of it.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use host_link::error::Error;
use host_link::motion::Motion;
use host_link::session::Session;
use shared_proto::{Command, Drive, Event, MotionId, State};
use sim_target::{now_us, sleep_until_us};

use super::draw::{Case, Phase};
use super::fault_injection::{Host, World};
use super::fault_instant::HELLO_US;
use super::observed::Timeline;

/// Between two frames of telemetry \[ms\].
const TELEMETRY_MS: u16 = 5;
/// The host looks this often \[us\].
const LOOK_US: u64 = 5_000;
/// It renews a motion this often \[us\], as `beeline` does.
const RENEW_US: u64 = 30_000;
/// A motion begins this long before its first tick \[us\]: ten ticks ahead.
const AHEAD_US: u64 = 10_000;
/// Both wheels' encoder checks, at most, after wheels that roll have come to rest \[us\].
const CHECK_US_MAX: u64 = 6_000_000;
/// After what happened the host drives on at most this long \[us\].
const AFTER_US_MAX: u64 = 2_500_000;
/// The time for a stop, after the cruise has begun \[us\].
const INTO_CRUISE_US: u64 = 50_000;

/// The host during the drive in which something happens.
pub(super) struct Script<'a> {
    pub session: &'a mut Session,
    pub case: &'a Case,
    pub world: World,
    /// When the first fault is due \[us\].
    pub due_us: Rc<Cell<Option<u64>>>,
    /// When it happened \[us\].
    pub happened_us: Rc<Cell<Option<u64>>>,
    pub timeline: Timeline,
}

impl Script<'_> {
    /// Everything from power-on to a disarmed robot; ends early where the robot does not go along.
    pub async fn run(&mut self) -> Result<(), Error> {
        self.mark(Phase::Boot);
        sleep_until_us(HELLO_US).await;
        self.mark(Phase::Hello);
        self.session.open().await?;
        self.timeline.opened_us = Some(now_us());
        self.mark(Phase::Idle);
        self.session.listen(Duration::from_millis(60)).await?;
        if let Some(config) = &self.case.config {
            self.session.write_config(config).await?;
        }
        self.session.request(Command::Subscribe { period_ms: TELEMETRY_MS }).await?;
        self.mark(Phase::Arming);
        self.timeline.armed_us = Some(now_us());
        self.session.request(Command::Arm { take: false }).await?;
        self.drive(&self.case.motion.clone()).await?;
        self.mark(Phase::Standing);
        if self.case.phase == Phase::Standing {
            // What happens to a robot that stands shows at its next motion.
            self.session.listen(Duration::from_millis(150)).await?;
            self.drive(&self.case.motion.reversed()).await?;
        }
        self.timeline.over_us = Some(now_us());
        self.session.request(Command::Disarm).await?;
        Ok(())
    }

    /// A phase begins.
    fn mark(&self, phase: Phase) {
        if self.case.phase == phase && self.due_us.get().is_none() {
            self.due_us.set(Some(now_us() + self.case.delay_us));
        }
    }

    /// Drives a motion to its end, or until the robot does something else.
    async fn drive(&mut self, motion: &Motion) -> Result<(), Error> {
        let id = self.session.new_motion();
        let mut drive = motion.drive_now(id);
        if self.case.phase == Phase::Waiting {
            let robot_us = self.session.status().await?.t_us;
            drive = Drive { start_us: Some(robot_us + 250_000), ..drive };
        }
        self.timeline.commanded_us.get_or_insert(now_us());
        let drive = Command::Drive(drive);
        // A host that hangs repeats nothing: each repetition would keep the motion alive.
        match self.world.host.get() {
            Host::Hangs => self.session.post(drive).await?,
            Host::Well | Host::Dead => drop(self.session.request(drive).await?),
        }
        self.mark(Phase::Waiting);
        self.session.take_events().for_each(drop);
        self.session.take_telemetry().for_each(drop);
        self.follow(id, motion).await
    }

    /// The wheels follow a motion from then on.
    fn tracks_from(&mut self, begin_us: u64) -> u64 {
        self.timeline.tracks_us.push(begin_us);
        let angles_rad = self.world.testbed.plant(|plant| plant.wheel_angles_rad());
        self.timeline.tracks_rad.push(angles_rad);
        begin_us
    }

    /// Renews a motion, and marks its phases.
    async fn follow(&mut self, id: MotionId, motion: &Motion) -> Result<(), Error> {
        self.timeline.followed = Some(id);
        let begin_us = now_us();
        let limit_us = begin_us + 250_000 + CHECK_US_MAX + (motion.duration_s() * 1e6) as u64;
        let resets = self.world.monitor.resets_us().len();
        // The second motion of a robot that is armed needs no check.
        let mut checked = !self.timeline.tracks_us.is_empty();
        let mut tracked_us = checked.then(|| self.tracks_from(begin_us + AHEAD_US));
        let mut renewed_us = 0;
        while now_us() < limit_us
            && self.happened_us.get().is_none_or(|at_us| now_us() < at_us + AFTER_US_MAX)
            && self.world.monitor.resets_us().len() == resets
        {
            self.keep_alive(id, &mut renewed_us).await?;
            self.session.listen(Duration::from_micros(LOOK_US)).await?;
            for frame in self.session.take_all_telemetry().collect::<Vec<_>>() {
                if matches!(frame.state, State::Driving | State::Stopping) && !frame.probing {
                    self.timeline.error_um = frame.wheels.map(|wheel| wheel.error_um);
                    self.timeline.duty = frame.wheels.map(|wheel| wheel.duty);
                }
                if frame.probing && !checked {
                    checked = true;
                    self.mark(Phase::Check);
                } else if checked && !frame.probing && tracked_us.is_none() {
                    tracked_us = Some(self.tracks_from(now_us() + AHEAD_US));
                    self.mark(Phase::Acceleration);
                }
            }
            if let Some(tracked_us) = tracked_us {
                self.pass_phases(tracked_us, motion).await?;
            }
            if self.session.take_events().any(|event| ends(&event, id)) {
                break;
            }
        }
        Ok(())
    }

    /// What keeps the motion alive, as far as the host is well.
    async fn keep_alive(&mut self, id: MotionId, renewed_us: &mut u64) -> Result<(), Error> {
        if now_us() < *renewed_us + RENEW_US {
            return Ok(());
        }
        *renewed_us = now_us();
        match self.world.host.get() {
            Host::Well => {
                let renew = Command::Renew { motion: id };
                self.session.post(renew).await
            }
            Host::Hangs => self.session.post(Command::Status).await,
            Host::Dead => Ok(()),
        }
    }

    /// Marks the phases of a motion, and does what belongs to them.
    async fn pass_phases(&mut self, tracked_us: u64, motion: &Motion) -> Result<(), Error> {
        let cruise_us = tracked_us + (motion.ramp_s() * 1e6) as u64;
        if now_us() >= cruise_us {
            self.mark(Phase::Cruise);
        }
        if now_us() >= cruise_us + (self.case.cruise_s * 1e6) as u64 {
            self.mark(Phase::Deceleration);
        }
        if now_us() < cruise_us + INTO_CRUISE_US || self.due_us.get().is_some() {
            return Ok(());
        }
        if self.case.phase == Phase::Stopping {
            self.session.request(Command::Stop).await?;
            self.timeline.stop_us = Some(now_us());
            self.mark(Phase::Stopping);
        } else if self.case.phase == Phase::Latched {
            self.session.request(Command::EmergencyStop).await?;
            self.timeline.latched_us = Some(now_us());
            self.mark(Phase::Latched);
            self.session.listen(Duration::from_millis(120)).await?;
        }
        Ok(())
    }
}

/// Whether an event says that this motion is over.
fn ends(event: &Event, id: MotionId) -> bool {
    match event {
        Event::MotionEnded { motion, .. } => *motion == id,
        Event::State { state, .. } => matches!(state, State::Faulted | State::Armed),
        Event::Fault(_) => false,
    }
}
