//! The state of one wheel, and the rules.

use shared_proto::{Fault, Wheel};

use super::runaway::Run;
use super::sample::{Positions, WheelSample, position};
use super::thresholds::{CHECKPOINTS_LEN, QuietBounds, WheelThresholds};

/// A kind of fault that needs a wheel.
pub type WheelFault = fn(Wheel) -> Fault;

/// A change of the count.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    tick: u32,
    counts: u32,
    positions: Positions,
}

/// Changes kept, so that 4 ticks are covered at one change a tick; a power of two.
const CHANGES_LEN: usize = 8;
/// Counts and ticks over which the rate before a standstill is taken.
///
/// Few, to see a wheel slow down over about 4 counts. At 2 ms per count, as at the paper's cruise, one tick
/// of quantisation is a quarter of the time; the factor of two thirds allows for that.
const LAST_COUNTS: u32 = 2;
const LAST_TICKS: u32 = 4;
/// Changes over which the speed of a wheel is taken that turns the wrong way.
const LATELY: usize = 4;
/// A count that goes back and forth this often comes from an encoder with one line, not from a wheel that stands.
const ONE_LINE: u32 = 2;
/// So often in a stall time a count turns round only if a line floats or is cut: a wheel has mass.
const FLAPS: u32 = 8;
/// So often it may do so once more than a wheel that starts or stops; told from it only where something else is wrong.
const SOME_FLAPS: u32 = 3;

/// The state of one wheel's monitor.
#[derive(Clone, Copy, Debug)]
pub struct WheelMonitor {
    tick: u32,
    /// The newest change that led to a new count; before the first one, the start.
    last: Change,
    /// The count, and what it was before it changed last.
    counts: (u32, u32),
    /// How often it has gone back; halved by each change that led to a new count.
    goings_back: u32,
    /// How often it has turned round in about the last stall time.
    flaps: u32,
    /// It rose when it changed last.
    rose: bool,
    /// The newest change is at `changed - 1`; before the first one, entry 0 is the start.
    changes: [Change; CHANGES_LEN],
    changed: usize,
    /// The present series of changes against the setpoint, or away from one at rest.
    run: Option<Run>,
    /// Where monitoring began stands in for those that are not taken yet.
    checkpoints: [Positions; CHECKPOINTS_LEN],
    /// The oldest one, which the next one replaces, is at `checkpoint % CHECKPOINTS_LEN`.
    checkpoint: usize,
    checkpoint_tick: u32,
}

impl WheelMonitor {
    pub const BLANK: Self = {
        const POSITIONS: Positions = Positions { setpoint: 0, travel: 0 };
        const CHANGE: Change = Change { tick: 0, counts: 0, positions: POSITIONS };
        Self {
            tick: 0,
            last: CHANGE,
            counts: (0, 0),
            goings_back: 0,
            flaps: 0,
            rose: false,
            changes: [CHANGE; CHANGES_LEN],
            changed: 0,
            run: None,
            checkpoints: [POSITIONS; CHECKPOINTS_LEN],
            checkpoint: 0,
            checkpoint_tick: 0,
        }
    };

    /// Resets only what will be read: this runs within a control tick.
    ///
    /// `since_checkpoint`: so many ticks are taken to have passed; not the same of both wheels, whose checkpoints would
    /// fall into one tick.
    pub fn begin(&mut self, view: &WheelSample<'_>, since_checkpoint: u32) {
        self.tick = 0;
        let start = view.positions();
        self.last = Change { tick: 0, counts: view.counts, positions: start };
        self.counts = (view.counts, view.counts);
        (self.goings_back, self.flaps) = (0, 0);
        self.changes[0] = self.last;
        self.changed = 1;
        self.run = None;
        self.checkpoints = [start; CHECKPOINTS_LEN];
        self.checkpoint = 0;
        self.checkpoint_tick = since_checkpoint.wrapping_neg();
    }

    /// One tick. A wheel that does as it should is compared with its setpoint only if that is `due`: every few ticks.
    #[inline(always)]
    pub fn step(
        &mut self,
        limits: &WheelThresholds,
        view: WheelSample<'_>,
        supply_scale: i32,
        due: bool,
    ) -> Option<WheelFault> {
        self.tick = self.tick.wrapping_add(1);
        let moved = view.counts.wrapping_sub(self.counts.0) as i32;
        if moved != 0 {
            if moved.unsigned_abs() > limits.counts_per_tick_max {
                return Some(Fault::CountRate);
            }
            let rises = moved > 0;
            let turns = rises != self.rose && self.turn();
            let goes_back = turns && view.counts == self.counts.1 && moved.unsigned_abs() == 1;
            self.counts = (view.counts, self.counts.0);
            if goes_back {
                self.goings_back += 1;
            } else {
                self.goings_back >>= 1;
                self.record(&view, rises);
            }
        }
        if !due && self.run.is_none() {
            return None;
        }
        if !self.is_quiet(&limits.quiet, &view) {
            // A copy, made here: whatever these are given by reference has to be in memory, and not at every tick.
            let view = WheelSample { ..view };
            self.examine(limits, &view, supply_scale)
        } else if self.checkpoint_is_due(limits) {
            self.examine_checkpoint(limits, view.positions())
        } else {
            None
        }
    }

    /// A shorter question than the rules: if the answer is yes, none of them applies but those of a checkpoint.
    #[inline(always)]
    fn is_quiet(&self, bounds: &QuietBounds, view: &WheelSample<'_>) -> bool {
        let error = view.controller.error().to_bits().unsigned_abs();
        let error_max = if view.rests() { bounds.resting_error } else { bounds.error };
        let advance = position(view.setpoint.travel).wrapping_sub(self.last.positions.setpoint);
        self.run.is_none() && error < error_max && advance.unsigned_abs() <= bounds.advance
    }

    /// The rules that may apply to a quiet wheel at a checkpoint.
    #[inline(never)]
    fn examine_checkpoint(
        &mut self,
        limits: &WheelThresholds,
        positions: Positions,
    ) -> Option<WheelFault> {
        if self.oscillates_off_setpoint(limits, positions) {
            Some(Fault::EncoderDead)
        } else if self.creeps_at_checkpoint(limits, positions) {
            Some(self.diagnose(limits))
        } else {
            None
        }
    }

    /// The count goes back and forth, and is off by more than that.
    fn oscillates_off_setpoint(&self, limits: &WheelThresholds, positions: Positions) -> bool {
        self.flaps >= FLAPS && positions.error().unsigned_abs() >= limits.reversed_run as u32
    }

    /// All rules.
    #[inline(never)]
    fn examine(
        &mut self,
        limits: &WheelThresholds,
        view: &WheelSample<'_>,
        supply_scale: i32,
    ) -> Option<WheelFault> {
        let positions = view.positions();
        let goes_on = self.run.as_mut().is_some_and(|run| run.goes_on(limits, view));
        let too_far = positions.error().unsigned_abs() > limits.error_max as u32;
        if self.oscillates_off_setpoint(limits, positions) {
            Some(Fault::EncoderDead)
        } else if goes_on && self.runs_against_motor(limits, view, supply_scale) {
            // By chance a line that floats counts the wrong way for a while.
            Some(if self.flaps >= SOME_FLAPS { Fault::EncoderDead } else { Fault::EncoderReversed })
        } else if self.is_stalled(limits, positions, too_far) || self.creeps(limits, positions) {
            Some(self.diagnose(limits))
        } else if self.is_stuck_at_rest(limits, view) {
            // A line that was stuck, too, may leave the wheel off its target.
            Some(if self.goings_back >= ONE_LINE { Fault::EncoderDead } else { Fault::Stall })
        } else if too_far {
            Some(Fault::FollowingError)
        } else {
            None
        }
    }

    /// The count changes the other way than before; always true.
    #[cold]
    #[inline(never)]
    fn turn(&mut self) -> bool {
        self.flaps += 1;
        self.rose = !self.rose;
        true
    }

    fn record(&mut self, view: &WheelSample<'_>, forward: bool) {
        let positions = view.positions();
        let advanced = positions.since(self.last.positions).setpoint;
        // Towards which the wheel should turn: with the setpoint, or back to one that rests.
        let wanted = match advanced {
            0 => positions.setpoint.wrapping_sub(self.last.positions.travel),
            _ => advanced,
        };
        if wanted != 0 && (wanted > 0) == forward {
            self.run = None;
        } else if self.run.is_none() {
            self.run = Some(Run::new(self.last.positions, self.tick));
        }
        // Twice from registers, not from one place to the other.
        let change = Change { tick: self.tick, counts: view.counts, positions };
        self.changes[self.changed % CHANGES_LEN] = change;
        self.last = change;
        self.changed = self.changed.wrapping_add(1);
    }

    /// The `age`-th newest change, from 1.
    fn change(&self, age: usize) -> Change {
        self.changes[self.changed.wrapping_sub(age) % CHANGES_LEN]
    }

    /// The travel over the newest changes, and its ticks.
    fn recent_travel(&self) -> (u32, u32) {
        let earlier = self.change(LATELY.min(self.changed));
        let turned = self.last.positions.since(earlier.positions).travel.unsigned_abs();
        (turned, self.last.tick.wrapping_sub(earlier.tick))
    }

    /// The count goes the other way than the motor drives the wheel.
    #[cold]
    #[inline(never)]
    fn runs_against_motor(
        &mut self,
        limits: &WheelThresholds,
        view: &WheelSample<'_>,
        supply_scale: i32,
    ) -> bool {
        let (tick, lately) = (self.tick, self.recent_travel());
        let sample = (view, supply_scale);
        self.run.as_mut().is_some_and(|run| run.runs_against_motor(limits, sample, (tick, lately)))
    }

    fn standing_ticks(&self) -> u32 {
        self.tick.wrapping_sub(self.last.tick)
    }

    /// The count stands still while the setpoint advances.
    ///
    /// A setpoint that only catches up with the wheel tells nothing: after the encoder check the wheel is
    /// ahead of its motion.
    ///
    /// `too_far`: the error is above its limit already, so there is no time to wait.
    fn is_stalled(&self, limits: &WheelThresholds, positions: Positions, too_far: bool) -> bool {
        let since = positions.since(self.last.positions).setpoint;
        let advance = since.saturating_abs();
        let error = positions.error();
        let ahead = if since < 0 { error.wrapping_neg() } else { error };
        (advance.min(ahead) >= limits.standing_advance
            && self.standing_ticks() >= limits.stall_ticks)
            || (too_far && advance >= limits.error_max - (limits.error_max >> 2))
    }

    /// The count stands still although a high duty pushes the wheel towards a setpoint at rest.
    fn is_stuck_at_rest(&self, limits: &WheelThresholds, view: &WheelSample<'_>) -> bool {
        let error = view.positions().error().unsigned_abs();
        let stall_times = if error >= limits.standing_advance as u32 { 2 } else { 10 };
        view.rests()
            && self.standing_ticks() >= stall_times * limits.stall_ticks
            && view.duty().0.to_bits().unsigned_abs() >= limits.resting_duty
            && error >= limits.resting_error as u32
    }

    #[inline(always)]
    fn checkpoint_is_due(&self, limits: &WheelThresholds) -> bool {
        self.tick.wrapping_sub(self.checkpoint_tick) >= limits.checkpoint_ticks
    }

    /// The wheel falls far behind although its count still changes now and then.
    fn creeps(&mut self, limits: &WheelThresholds, positions: Positions) -> bool {
        self.checkpoint_is_due(limits) && self.creeps_at_checkpoint(limits, positions)
    }

    #[inline(always)]
    fn creeps_at_checkpoint(&mut self, limits: &WheelThresholds, positions: Positions) -> bool {
        self.checkpoint_tick = self.tick;
        self.flaps -= self.flaps.div_ceil(CHECKPOINTS_LEN as u32);
        let slot = &mut self.checkpoints[self.checkpoint % CHECKPOINTS_LEN];
        let moved = positions.since(core::mem::replace(slot, positions));
        self.checkpoint = self.checkpoint.wrapping_add(1);
        let (advance, along) = match moved.setpoint {
            0.. => (moved.setpoint, moved.travel),
            _ => (moved.setpoint.wrapping_neg(), moved.travel.wrapping_neg()),
        };
        // `EncoderReversed` has its own rule.
        advance >= limits.creeping_advance && along < advance >> 3 && self.run.is_none()
    }

    /// Whether the wheel or the encoder is at fault when a count stands still or creeps.
    #[cold]
    fn diagnose(&self, limits: &WheelThresholds) -> WheelFault {
        let last = self.last;
        if self.changed == 1 || self.goings_back >= ONE_LINE || self.flaps >= SOME_FLAPS {
            return Fault::EncoderDead;
        }
        // A count that still changes now and then comes from a live encoder.
        if self.standing_ticks() < limits.stall_ticks / 2 {
            return Fault::Stall;
        }
        let known = self.changed.min(CHANGES_LEN);
        let mut age = 2;
        while age < known && !self.covers(age) {
            age += 1;
        }
        let moved = last.positions.since(self.change(age).positions);
        let along = if moved.setpoint < 0 { moved.travel.wrapping_neg() } else { moved.travel };
        // Two thirds.
        if along > 0 && 3 * i64::from(along) >= 2 * i64::from(moved.setpoint).abs() {
            Fault::EncoderDead
        } else {
            Fault::Stall
        }
    }

    /// Whether the time from the `age`-th newest change to the newest is long enough to tell the rate.
    fn covers(&self, age: usize) -> bool {
        let (last, earlier) = (self.change(1), self.change(age));
        (last.counts.wrapping_sub(earlier.counts) as i32).unsigned_abs() >= LAST_COUNTS
            && last.tick.wrapping_sub(earlier.tick) >= LAST_TICKS
    }
}
