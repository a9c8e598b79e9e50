//! The transitions between states, each a function with its name.

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::Instant;
use shared_proto::{MotionEnd, State, Voltage, WheelPair};

use super::motion_command::MotionCommand;
use super::{PLAN_AHEAD, Supervisor};
use crate::hal::Store;
use crate::probe::{Direction, Probe};
use crate::profile::{Plan, ProfileState};
use crate::shared::ControlOrder;
use crate::switching_on::rolls;
use crate::voltage::VoltagePlan;

impl<M: RawMutex, S: Store> Supervisor<'_, M, S> {
    /// Idle to armed.
    pub(super) fn arm(&mut self) {
        self.probed = WheelPair::both(false);
        self.shared.order.put(ControlOrder::Rest);
        self.enter(State::Armed);
    }

    /// Armed to idle.
    pub(super) fn disarm(&mut self) {
        self.shared.order.put(ControlOrder::Off);
        self.enter(State::Idle);
    }

    /// Armed to driving; the encoder check comes first.
    pub(super) fn begin_probe(&mut self, wanted: MotionCommand, from: WheelPair<ProfileState>) {
        let id = self.next_order();
        let measured = self.shared.snapshot.get().measured;
        let directions = wanted.directions(&self.config);
        let probe = Probe::new(&self.config, measured.counts, directions, rolls(&measured));
        self.probing = directions.map(|direction| direction != Direction::Still);
        self.waiting = Some((wanted, from));
        self.start_at = None;
        self.plan = None;
        self.shared.check(id, probe);
        self.enter(State::Driving);
    }

    /// Armed to driving; the wheels rest until the start time.
    pub(super) fn begin_wait(
        &mut self,
        wanted: MotionCommand,
        from: WheelPair<ProfileState>,
        start_at: Instant,
    ) {
        self.waiting = Some((wanted, from));
        self.start_at = Some(start_at);
        self.enter(State::Driving);
    }

    /// Driving to driving: the start time has come.
    pub(super) fn end_wait(&mut self) {
        self.start_at = None;
        let Some((wanted, from)) = self.waiting.take() else { return };
        // Nothing holds the wheels in between: somebody may have pushed the robot.
        let from = if self.holds() { from } else { self.standing(self.travel()) };
        if self.is_probed(&wanted) {
            self.begin(&wanted, from);
        } else {
            self.begin_probe(wanted, from);
        }
    }

    /// Driving to driving: the encoder check or the wait is over.
    pub(super) fn begin(&mut self, wanted: &MotionCommand, from: WheelPair<ProfileState>) {
        if let MotionCommand::Voltage(voltage) = wanted {
            return self.begin_voltage(voltage);
        }
        match wanted.plan(self.plan_start_tick(), from, &self.config) {
            Ok(plan) => self.follow(plan),
            // The same motion was planned when the command came; the configuration has not changed.
            Err(_) => self.begin_stop(State::Armed),
        }
    }

    /// Armed or driving to driving, with the loop open.
    pub(super) fn begin_voltage(&mut self, voltage: &Voltage) {
        let id = self.next_order();
        self.waiting = None;
        self.plan = None;
        self.open_loop = true;
        self.shared.order.put(ControlOrder::Voltage { id, plan: VoltagePlan::new(voltage) });
        self.enter(State::Driving);
    }

    /// Armed or driving to driving.
    pub(super) fn follow(&mut self, plan: Plan) {
        let id = self.next_order();
        self.waiting = None;
        self.start_at = None;
        self.shared.follow(id, &plan, self.hold_ticks());
        self.plan_starts = Instant::now() + PLAN_AHEAD;
        self.plan = Some(plan);
        self.enter(State::Driving);
    }

    /// Driving to stopping; `then` is the state after the stop.
    pub(super) fn begin_stop(&mut self, then: State) {
        self.after_stop = then;
        self.velocity = None;
        self.next_velocity = None;
        match self.plan.take() {
            Some(plan) => {
                let start = self.plan_start_tick();
                let deceleration = self.config.limits.stop_deceleration_mps2;
                let stop = Plan::stop(start, plan.at(start), deceleration);
                let id = self.next_order();
                self.shared.follow(id, &stop, self.hold_ticks());
                self.plan = Some(stop);
                self.enter(State::Stopping);
            }
            // The voltages are zero at once, and the wheels roll out.
            None if self.open_loop => {
                let id = self.next_order();
                self.shared.order.put(ControlOrder::Halt { id });
                self.enter(State::Stopping);
            }
            // Only the encoder check or a wait was under way: no wheel needs a ramp to stop.
            None => {
                self.waiting = None;
                self.start_at = None;
                self.shared.order.put(ControlOrder::Rest);
                self.enter(State::Stopping);
                self.end_stop();
            }
        }
    }

    /// Stopping to armed, idle or faulted.
    pub(super) fn end_stop(&mut self) {
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
    pub(super) fn complete(&mut self, end: MotionEnd) {
        self.end_motion(end);
        self.enter(State::Armed);
    }

    /// Any state to faulted.
    pub(super) fn fault(&mut self) {
        self.shared.order.put(ControlOrder::Off);
        if self.motion_end.is_none() && self.motion.is_some() {
            self.end_motion(MotionEnd::Faulted);
        }
        self.plan = None;
        self.waiting = None;
        self.start_at = None;
        self.open_loop = false;
        self.enter(State::Faulted);
    }

    /// Faulted to idle.
    pub(super) fn clear_fault(&mut self) {
        self.shared.fault.clear();
        self.shared.order.put(ControlOrder::Off);
        self.enter(State::Idle);
    }
}
