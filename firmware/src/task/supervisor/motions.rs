//! Motions: what a host wants, and when the robot does it.

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::Instant;
use shared_proto::{
    Answer, Drive, MotionEnd, MotionError, MotionId, Refusal, State, Velocity, Voltage, WheelPair,
};

use super::Supervisor;
use super::motion_command::{EARLIER_MOTIONS, MotionCommand};
use crate::hal::Store;
use crate::probe::Direction;
use crate::profile::{Plan, ProfileState};
use crate::shared::Action;
use crate::units::{CONTROL_PERIOD_US, Travel};

impl<M: RawMutex, S: Store> Supervisor<'_, M, S> {
    pub(super) fn execute_drive(&mut self, drive: &Drive) -> Result<Answer, Refusal> {
        self.not_faulted()?;
        if self.motion == Some(drive.motion) {
            // A repeated command. If the motion is still under way, this renews it.
            if self.motion_end.is_none() {
                self.renew();
            }
            return Ok(Answer::Done);
        }
        if self.earlier_motions.contains(&Some(drive.motion)) {
            return Ok(Answer::Done);
        }
        self.may_move()?;
        let start_at = drive.start_us.map(|start_us| self.start_instant(start_us)).transpose()?;
        self.start_motion(MotionCommand::Drive(*drive), start_at)
    }

    pub(super) fn execute_velocity(&mut self, velocity: &Velocity) -> Result<Answer, Refusal> {
        self.not_faulted()?;
        velocity.wheels_mps(&self.config).map_err(Refusal::Motion)?;
        if self.earlier_motions.contains(&Some(velocity.motion)) {
            return Err(Refusal::NoSuchMotion);
        }
        if self.motion != Some(velocity.motion) {
            self.may_move()?;
            self.start_motion(MotionCommand::Velocity(*velocity), None)?;
            self.velocity = Some(*velocity);
            return Ok(Answer::Done);
        }
        // The motion has ended, or it is no velocity.
        let Some(before) = self.velocity else { return Err(Refusal::NoSuchMotion) };
        if self.lease < self.alive_until {
            // A later command came first.
            return Err(Refusal::Late);
        }
        self.renew();
        if before == *velocity {
            return Ok(Answer::Done);
        }
        self.velocity = Some(*velocity);
        if let Some((wanted, _)) = &mut self.waiting {
            // The encoder check is under way; this is driven afterwards.
            *wanted = MotionCommand::Velocity(*velocity);
        } else if Instant::now() < self.plan_starts {
            self.next_velocity = Some(*velocity);
        } else {
            self.change_velocity(*velocity);
        }
        Ok(Answer::Done)
    }

    pub(super) fn execute_voltage(&mut self, voltage: &Voltage) -> Result<Answer, Refusal> {
        self.not_faulted()?;
        voltage.check(&self.config).map_err(Refusal::Motion)?;
        if self.motion == Some(voltage.motion) {
            // A repeated command.
            if self.motion_end.is_none() {
                self.renew();
            }
            return Ok(Answer::Done);
        }
        if self.earlier_motions.contains(&Some(voltage.motion)) {
            return Ok(Answer::Done);
        }
        // From a standstill, or in place of another voltage.
        if self.state != State::Armed && !(self.state == State::Driving && self.open_loop) {
            return Err(Refusal::State(self.state));
        }
        self.register(voltage.motion);
        if self.is_probed(&MotionCommand::Voltage(*voltage)) {
            self.begin_voltage(voltage);
        } else {
            self.begin_probe(MotionCommand::Voltage(*voltage), self.standing(self.travel()));
        }
        Ok(Answer::Done)
    }

    /// Driving to driving, at another velocity.
    pub(super) fn change_velocity(&mut self, velocity: Velocity) {
        let Some(plan) = &self.plan else { return };
        let start = self.plan_start_tick();
        let from = plan.at(start);
        self.begin(&MotionCommand::Velocity(velocity), from);
    }

    /// Whether the wheels that this turns have been checked.
    pub(super) fn is_probed(&self, wanted: &MotionCommand) -> bool {
        let directions = wanted.directions(&self.config);
        directions
            .zip(self.probed)
            .all(|(direction, probed)| direction == Direction::Still || probed)
    }

    /// An error unless a motion may begin in this state.
    fn may_move(&self) -> Result<(), Refusal> {
        let stopping_to_armed = self.state == State::Stopping && self.after_stop == State::Armed;
        match self.state {
            State::Armed | State::Driving => Ok(()),
            _ if stopping_to_armed => Ok(()),
            state => Err(Refusal::State(state)),
        }
    }

    /// A new motion, in place of the one under way.
    fn start_motion(
        &mut self,
        wanted: MotionCommand,
        start_at: Option<Instant>,
    ) -> Result<Answer, Refusal> {
        if self.open_loop {
            // Wheels without setpoints have nothing that a plan could begin from.
            return Err(Refusal::State(self.state));
        }
        let probed = self.is_probed(&wanted);
        let start = self.plan_start_tick();
        let from = match (&self.plan, &self.waiting) {
            // A wheel that has not been checked is checked from a standstill only.
            (Some(_), _) if !probed => return Err(Refusal::State(self.state)),
            (Some(plan), _) => plan.at(start),
            (None, Some((_, from))) => *from,
            (None, None) if self.holds() => self.shared.profile.with(|profile| profile.at(start)),
            (None, None) => self.standing(self.travel()),
        };
        let plan = wanted.plan(start, from, &self.config).map_err(Refusal::Motion)?;
        self.register(wanted.motion());
        if let Some(start_at) = start_at {
            self.begin_wait(wanted, from, start_at);
        } else if probed {
            self.follow(plan);
        } else {
            self.begin_probe(wanted, from);
        }
        Ok(Answer::Done)
    }

    /// Another motion is under way from now on.
    fn register(&mut self, motion: MotionId) {
        if self.motion.is_some() && self.motion_end.is_none() {
            self.end_motion(MotionEnd::Replaced);
        }
        self.earlier_motions[self.motions % EARLIER_MOTIONS] = self.motion;
        self.motions = self.motions.wrapping_add(1);
        self.motion = Some(motion);
        self.motion_end = None;
        self.alive_until = self.lease;
        self.renewed = Instant::now();
    }

    /// Whether the wheels hold their place after a motion.
    pub(super) fn holds(&self) -> bool {
        matches!(self.shared.snapshot.copy().action, Action::Track)
    }

    /// Where the wheels are now.
    pub(super) fn travel(&self) -> WheelPair<Travel> {
        self.shared.snapshot.get().measured.travel
    }

    /// Wheels that stand there.
    pub(super) fn standing(&self, travel: WheelPair<Travel>) -> WheelPair<ProfileState> {
        Plan::hold(travel).at(self.plan_start_tick())
    }

    /// When to start a motion so that `start_us` is its first control tick: half a tick before.
    fn start_instant(&self, start_us: u64) -> Result<Instant, Refusal> {
        if self.state != State::Armed {
            return Err(Refusal::State(self.state));
        }
        let at = Instant::from_micros(start_us.saturating_sub(u64::from(CONTROL_PERIOD_US) / 2));
        let now = Instant::now();
        if at <= now || start_us - now.as_micros() > Drive::START_AHEAD_US_MAX {
            return Err(Refusal::Motion(MotionError::Start));
        }
        Ok(at)
    }

    /// The motion under way lives as long as this request's lease, if that ends later than its own.
    pub(super) fn renew(&mut self) {
        // A copy of an earlier request is no sign of life.
        if self.lease > self.alive_until {
            self.alive_until = self.lease;
            self.renewed = Instant::now();
        }
    }
}
