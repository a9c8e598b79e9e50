//! The state of one wheel, and the rules.

use super::last_changes::{Change, LastChanges};
use super::runaway::Run;
use super::sample::{Positions, WheelSample, position};
use super::thresholds::{CHECKPOINTS_LEN, PUSH_SHIFT, QuietBounds, WheelThresholds};
use super::wheel_fault::WheelFault;

/// A count that goes back and forth this often comes from an encoder with one line, not from a wheel that stands.
const ONE_LINE: u32 = 2;
/// So often a wheel turns round that starts or stops; told from it only where something else is wrong.
const SOME_TURNS: u32 = 3;
/// So often no count turns round to somewhere else than where it came from: a wheel that trembles on an edge counts up and
/// down, between the same two.
const FLOATS: u32 = 5;
/// So often it turns round in a few millimetres, and not the wheel, which may shake slowly by half of one.
const TREMBLES: u32 = 16;
/// So long the count of a line that floats goes one way only rarely \[ticks\].
const STEADY: u32 = 16;
/// A push takes at least so many looks, every other tick, to be in vain: the wheel of a heavy robot starts slowly.
const LOOKS: i32 = 64;
/// So far no wheel turns within a tick the other way than before: 0.2 mm \[2^-24 m\].
const JUMP: u32 = 3355;

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
    /// It rose when it changed last.
    rose: bool,
    /// How often it has turned round, each time within a stall time of the last; how often of these it jumped, and not
    /// back to the count before; and when last.
    turns: u32,
    jumps: u32,
    turn_tick: u32,
    /// How often it has turned round since then; halved when it came along with its setpoint.
    strays: u32,
    strays_since: Positions,
    /// Sum over the ticks since the last count of the duty, either way, beyond what friction takes \[2^-18\].
    push: i32,
    /// The loop's integral when the wheel was last seen to turn, at the nominal supply: what a slope takes.
    bias: i32,
    changes: LastChanges,
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
        Self {
            tick: 0,
            last: Change::BLANK,
            counts: (0, 0),
            goings_back: 0,
            rose: false,
            turns: 0,
            jumps: 0,
            turn_tick: 0,
            strays: 0,
            strays_since: POSITIONS,
            push: 0,
            bias: 0,
            changes: LastChanges::BLANK,
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
    #[inline(never)]
    pub fn begin(&mut self, view: &WheelSample<'_>, since_checkpoint: u32) {
        self.tick = 0;
        let start = view.positions();
        self.last = Change { tick: 0, positions: start };
        self.counts = (view.counts, view.counts);
        (self.goings_back, self.turns, self.jumps, self.strays) = (0, 0, 0, 0);
        self.strays_since = start;
        (self.push, self.bias) = (0, 0);
        self.changes.begin(self.last);
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
                return Some(WheelFault::CountRate);
            }
            let rises = moved > 0;
            let turns = rises != self.rose;
            let goes_back = turns && view.counts == self.counts.1 && moved.unsigned_abs() == 1;
            if turns {
                self.turn(limits, moved, goes_back);
            }
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
        } else if self.creeps(limits, &view) {
            Some(self.unless_line(self.diagnose(limits), limits))
        } else if view.nearly_rests() && self.is_stuck_at_rest(limits, &view, supply_scale) {
            // Quiet by the bounds of a setpoint that moves; those of one at rest are narrower.
            Some(self.unless_line(WheelFault::Stall, limits))
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
        self.add_push(limits, view, supply_scale);
        let found = if goes_on && self.runs_against_motor(limits, view, supply_scale) {
            WheelFault::EncoderReversed
        } else if self.is_stuck_at_rest(limits, view, supply_scale) {
            WheelFault::Stall
        } else if self.is_stalled(limits, view, supply_scale) || self.creeps(limits, view) {
            self.diagnose(limits)
        } else if too_far {
            WheelFault::FollowingError
        } else {
            return None;
        };
        Some(self.unless_line(found, limits))
    }

    /// The count changes the other way than before.
    #[cold]
    #[inline(never)]
    fn turn(&mut self, limits: &WheelThresholds, moved: i32, goes_back: bool) {
        self.rose = !self.rose;
        if self.tick.wrapping_sub(self.turn_tick) > limits.stall_ticks {
            (self.turns, self.jumps, self.strays) = (0, 0, 0);
            self.strays_since = self.last.positions;
        }
        self.turns = self.turns.wrapping_add(1);
        let far = moved.unsigned_abs() * limits.resting_error as u32 >= 4 * JUMP;
        self.jumps = self.jumps.wrapping_add(u32::from(far && !goes_back));
        self.strays = self.strays.wrapping_add(u32::from(limits.counts_are_short() || !goes_back));
        self.turn_tick = self.tick;
    }

    /// What was found, unless the count goes back and forth, or did so not long ago: then a line of the encoder is at
    /// fault, which by chance counts the wrong way for a while, or leaves the wheel off its target.
    #[cold]
    #[inline(never)]
    fn unless_line(&self, found: WheelFault, limits: &WheelThresholds) -> WheelFault {
        let lately = self.tick.wrapping_sub(self.turn_tick) <= 2 * limits.stall_ticks;
        let line = lately && self.turns >= SOME_TURNS || self.goings_back >= ONE_LINE;
        if line { WheelFault::EncoderDead } else { found }
    }

    #[cold]
    #[inline(never)]
    fn begin_run(&mut self) {
        let speed = self.changes.mean_speed(self.tick);
        self.run = Some(Run::new(self.last.positions, self.tick, speed));
    }

    #[inline(always)]
    fn record(&mut self, view: &WheelSample<'_>, forward: bool) {
        let positions = view.positions();
        let advanced = positions.since(self.last.positions).setpoint;
        // Towards which the wheel should turn: with the setpoint, or back to one that rests.
        let wanted = match advanced {
            0 => positions.setpoint.wrapping_sub(self.last.positions.travel),
            _ => advanced,
        };
        let along = |way: i32| way != 0 && (way > 0) == forward;
        // A wheel that is ahead, as after the encoder check, is driven back.
        if along(wanted) || along(positions.error()) {
            self.run = None;
        } else if self.run.is_none() {
            self.begin_run();
        }
        // Twice from registers, not from one place to the other.
        let change = Change { tick: self.tick, positions };
        self.changes.push(change);
        self.last = change;
        self.push = 0;
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
        let (tick, lately) = (self.tick, self.changes.recent_travel(self.last.tick));
        let sample = (view, supply_scale);
        let against = |run: &mut Run| run.runs_against_motor(limits, sample, (tick, lately));
        self.run.as_mut().is_some_and(against) && self.is_steady(limits, view)
    }

    /// The count has gone one way for so long that it is not by chance that of a line that floats; or there is no time to wait,
    /// so far is the wheel from its setpoint.
    #[cold]
    #[inline(never)]
    fn is_steady(&self, limits: &WheelThresholds, view: &WheelSample<'_>) -> bool {
        let least = if self.turns > 1 { 2 * STEADY } else { STEADY };
        let error = view.positions().error().unsigned_abs();
        self.tick.wrapping_sub(self.turn_tick) >= least || error >= limits.error_max as u32 / 4 * 3
    }

    /// Adds the duty of this tick to the push since the last count; while the wheel is quiet, nothing is added.
    #[inline(always)]
    fn add_push(&mut self, limits: &WheelThresholds, view: &WheelSample<'_>, supply_scale: i32) {
        let stands = self.standing_ticks() >= 2 * limits.stall_ticks;
        if self.run.is_none() || stands || self.goings_back != 0 {
            let excess = view.excess(limits.push_duty, self.bias, supply_scale) >> PUSH_SHIFT;
            self.push += excess.clamp(0, limits.push_max / LOOKS);
        }
    }

    fn standing_ticks(&self) -> u32 {
        self.tick.wrapping_sub(self.last.tick)
    }

    /// The count stands still while the setpoint advances, or while the motor pushes as much as takes a wheel four counts far.
    ///
    /// A setpoint that only catches up with the wheel tells nothing: after the encoder check the wheel is
    /// ahead of its motion, and the loop has held it back, so that its motor may not push it on yet: half as far again it
    /// is given time.
    fn is_stalled(&self, limits: &WheelThresholds, view: &WheelSample<'_>, scale: i32) -> bool {
        let positions = view.positions();
        let since = positions.since(self.last.positions).setpoint;
        let (advance, error) = (since.saturating_abs(), positions.error());
        let ahead = if since < 0 { error.wrapping_neg() } else { error };
        let missing = advance.min(ahead) - limits.standing_advance;
        // So far from its setpoint there is no time to wait.
        let too_far = error.unsigned_abs() > limits.error_max as u32;
        (missing >= 0
            && self.standing_ticks() >= limits.stall_ticks
            && (view.excess(limits.resting_duty, 0, scale) >= 0
                || missing >= limits.standing_advance >> 1))
            || self.push > limits.push_max
            || (too_far && advance >= limits.error_max - (limits.error_max >> 2))
    }

    /// The count stands still although the motor pushes the wheel towards a setpoint at rest, or nearly.
    fn is_stuck_at_rest(
        &self,
        limits: &WheelThresholds,
        view: &WheelSample<'_>,
        supply_scale: i32,
    ) -> bool {
        let error = view.positions().error().unsigned_abs();
        error >= limits.rest_band
            && view.nearly_rests()
            && self.is_stuck(limits, view, supply_scale)
    }

    #[cold]
    #[inline(never)]
    fn is_stuck(
        &self,
        limits: &WheelThresholds,
        view: &WheelSample<'_>,
        supply_scale: i32,
    ) -> bool {
        if self.push > limits.push_max / 2 {
            return true;
        }
        if self.standing_ticks() < 2 * limits.stall_ticks {
            return false;
        }
        let error = view.positions().error().unsigned_abs();
        let stall_times = if error >= limits.standing_advance as u32 { 2 } else { 10 };
        let enough = stall_times * limits.stall_ticks;
        // A loop with long counts drives a sound wheel to and fro across an edge.
        let near = error < limits.resting_error as u32 && !limits.counts_are_short();
        let to_and_fro = near && self.tick.wrapping_sub(self.turn_tick) < enough;
        !to_and_fro
            && self.standing_ticks() >= enough
            && view.excess(limits.resting_duty, self.bias, supply_scale) >= 0
    }

    #[inline(always)]
    fn checkpoint_is_due(&self, limits: &WheelThresholds) -> bool {
        self.tick.wrapping_sub(self.checkpoint_tick) >= limits.checkpoint_ticks
    }

    /// At a checkpoint: the wheel falls far behind although its count still changes now and then, or its count floats.
    #[inline(always)]
    fn creeps(&mut self, limits: &WheelThresholds, view: &WheelSample<'_>) -> bool {
        self.checkpoint_is_due(limits) && self.creeps_at_checkpoint(limits, view)
    }

    #[inline(never)]
    fn creeps_at_checkpoint(&mut self, limits: &WheelThresholds, view: &WheelSample<'_>) -> bool {
        let positions = view.positions();
        self.checkpoint_tick = self.tick;
        let slot = &mut self.checkpoints[self.checkpoint % CHECKPOINTS_LEN];
        let moved = positions.since(core::mem::replace(slot, positions));
        if self.standing_ticks() < limits.checkpoint_ticks {
            self.bias = view.controller.integral();
        }
        self.checkpoint = self.checkpoint.wrapping_add(1);
        let (advance, along) = moved.along_setpoint();
        // `EncoderReversed` has its own rule.
        let creeps =
            advance >= limits.creeping_advance && along < advance >> 3 && self.run.is_none();
        creeps || self.jumps >= FLOATS || (self.strays >= FLOATS && self.strays(limits, positions))
    }

    /// The count has turned round and round while its setpoint advanced, and did not come along.
    #[cold]
    #[inline(never)]
    fn strays(&mut self, limits: &WheelThresholds, positions: Positions) -> bool {
        let (advance, along) = positions.since(self.strays_since).along_setpoint();
        let (some, more) = (limits.standing_advance, limits.creeping_advance);
        if advance < some {
            return false;
        }
        let sure = self.strays >= TREMBLES || advance >= more - some / 2;
        let least = advance >> if sure { 1 } else { 2 };
        if advance >= more {
            self.strays >>= 1;
            self.strays_since = positions.midway(self.strays_since);
        }
        along < least
    }

    /// Whether the wheel or the encoder is at fault when a count stands still or creeps.
    fn diagnose(&self, limits: &WheelThresholds) -> WheelFault {
        if self.changes.are_few() {
            return WheelFault::NoResponse;
        }
        // A count that still changes now and then comes from a live encoder.
        let stands = self.standing_ticks() >= limits.stall_ticks / 2;
        if !stands || !self.changes.end_abruptly() {
            WheelFault::Stall
        } else if self.changes.were_slow(limits.resting_error) {
            WheelFault::NoResponse
        } else {
            WheelFault::EncoderDead
        }
    }
}
