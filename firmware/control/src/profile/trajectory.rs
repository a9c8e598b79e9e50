//! One wheel's motion, sampled at ticks, and a cursor that moves along the samples.

use fixed::types::{I0F64, I8F24, I32F32, I64F64};

use super::state::{Position, ProfileState, Setpoint, Velocity};
use crate::units::{Acceleration, CONTROL_HZ, Speed, Travel};

/// A phase of constant acceleration, from its first tick on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Phase {
    /// Ticks from the plan's start.
    first_tick: u32,
    /// The first tick of the next phase; the last phase never ends.
    end_tick: u32,
    /// At the first tick [2^-64 m].
    position: i128,
    /// At the first tick [2^-64 m/tick].
    velocity: i64,
    /// Half the acceleration [2^-64 m/tick^2].
    half: i64,
    acceleration: Acceleration,
}

impl Phase {
    const ORIGIN: Self = Self {
        first_tick: 0,
        end_tick: u32::MAX,
        position: 0,
        velocity: 0,
        half: 0,
        acceleration: Acceleration(I8F24::ZERO),
    };

    #[inline]
    pub fn new(first_tick: u32, position: i128, velocity: i64, half: i64) -> Self {
        // 2 half [2^-64 m/tick^2] in 2^-24 m/s^2; 100 m/s^2 are 2^50 steps of half.
        let per_second_squared = i64::from(CONTROL_HZ * CONTROL_HZ);
        let bits = (((half >> 10) * per_second_squared) + (1 << 28)) >> 29;
        let acceleration = Acceleration(I8F24::from_bits(crate::units::saturate_i32(bits)));
        Self { first_tick, end_tick: u32::MAX, position, velocity, half, acceleration }
    }

    /// (1) of [`profile`](super).
    #[cold]
    #[inline(never)]
    fn at(&self, elapsed: u32) -> Point {
        let n = i128::from(elapsed - self.first_tick);
        let gained = i128::from(self.half) * n;
        Point {
            position: self.position + n * (i128::from(self.velocity) + gained),
            velocity: self.velocity + 2 * gained as i64,
        }
    }
}

/// Position and velocity as raw steps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    position: i128,
    velocity: i64,
}

impl Point {
    #[inline]
    pub fn state(self) -> ProfileState {
        ProfileState {
            position: Position(I64F64::from_bits(self.position)),
            velocity: Velocity(I0F64::from_bits(self.velocity)),
        }
    }
}

const PHASES_LEN: usize = 4;

/// Up to three phases of motion, then standing still.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trajectory {
    phases: [Phase; PHASES_LEN],
}

impl Trajectory {
    /// Stands still at the origin.
    pub const ORIGIN: Self = Self { phases: [Phase::ORIGIN; PHASES_LEN] };

    /// Phases in the order of their first ticks, the first one's being 0.
    #[inline]
    pub fn new(mut phases: [Phase; PHASES_LEN]) -> Self {
        for phase in 1..PHASES_LEN {
            phases[phase - 1].end_tick = phases[phase].first_tick;
        }
        debug_assert!(
            phases[0].first_tick == 0 && phases.is_sorted_by_key(|phase| phase.first_tick)
        );
        Self { phases }
    }

    /// Stands still at a position [2^-64 m].
    #[inline]
    pub fn hold(position: i128) -> Self {
        Self::new([Phase::new(0, position, 0, 0); PHASES_LEN])
    }

    /// From the start to the end of a ramp, and then still at `target`.
    #[inline]
    pub fn brake(ramp: Phase, end: u32, target: i128) -> Self {
        let still = Phase::new(end, target, 0, 0);
        Self::new([ramp, still, still, still])
    }

    /// Ticks from the start to standing at the target.
    pub fn len_ticks(&self) -> u32 {
        self.phases[PHASES_LEN - 1].first_tick
    }

    #[inline]
    pub fn target(&self) -> Position {
        Position(I64F64::from_bits(self.phases[PHASES_LEN - 1].position))
    }

    /// The wheel's point `elapsed` ticks after the start.
    #[inline]
    pub fn at(&self, elapsed: u32) -> Point {
        self.phase(self.phase_at(elapsed, 0)).at(elapsed)
    }

    /// The phase that holds at `elapsed`, below 2^31, at or after phase `from`.
    fn phase_at(&self, elapsed: u32, from: usize) -> usize {
        let mut phase = from;
        while self.phase(phase).end_tick <= elapsed {
            phase += 1;
        }
        phase
    }

    /// A phase; its index is below 4, which is cheaper to ensure than to check.
    #[inline(always)]
    fn phase(&self, index: usize) -> &Phase {
        &self.phases[index % PHASES_LEN]
    }
}

/// A wheel's present point on its trajectory.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cursor {
    phase: usize,
    /// The first tick of the next phase.
    ends: u32,
    elapsed: u32,
    point: Point,
    /// The phase's own; here so that a tick need not look the phase up.
    half: i64,
    acceleration: Acceleration,
}

impl Cursor {
    /// At the origin.
    pub const ORIGIN: Self = Self {
        phase: 0,
        ends: 0,
        elapsed: 0,
        point: Point { position: 0, velocity: 0 },
        half: 0,
        acceleration: Acceleration(I8F24::ZERO),
    };

    /// At the start of a trajectory.
    pub fn new(trajectory: &Trajectory) -> Self {
        let mut cursor = Self::ORIGIN;
        cursor.enter(trajectory, trajectory.phase_at(0, 0));
        let Phase { position, velocity, .. } = *trajectory.phase(cursor.phase);
        cursor.point = Point { position, velocity };
        cursor
    }

    fn enter(&mut self, trajectory: &Trajectory, phase: usize) {
        self.phase = phase;
        let Phase { end_tick, half, acceleration, .. } = *trajectory.phase(phase);
        (self.ends, self.half, self.acceleration) = (end_tick, half, acceleration);
    }

    /// Moves on to `elapsed`, which never decreases.
    #[inline(always)]
    pub fn advance_to(&mut self, trajectory: &Trajectory, elapsed: u32) {
        let ticks = elapsed.wrapping_sub(self.elapsed);
        if ticks == 1 && elapsed < self.ends {
            // (2) of `profile`
            self.point.position += i128::from(self.point.velocity + self.half);
            self.point.velocity += 2 * self.half;
            self.elapsed = elapsed;
        } else if ticks != 0 {
            self.jump_to(trajectory, elapsed);
        }
    }

    /// Moves on into another phase, or over ticks that were missed.
    #[cold]
    #[inline(never)]
    fn jump_to(&mut self, trajectory: &Trajectory, elapsed: u32) {
        self.enter(trajectory, trajectory.phase_at(elapsed, self.phase));
        let phase = trajectory.phase(self.phase);
        self.point = if elapsed == phase.first_tick {
            Point { position: phase.position, velocity: phase.velocity }
        } else {
            phase.at(elapsed)
        };
        self.elapsed = elapsed;
    }

    /// The setpoint at this point.
    #[inline(always)]
    pub fn setpoint(&self) -> Setpoint {
        // 2^-64 m to 2^-32 m, and 2^-64 m/tick to 2^-24 m/s, each to the nearest step. No configuration permits 128 m/s,
        // from which on this would not fit.
        let travel = (self.point.position + (1 << 31)) >> 32;
        let speed = ((self.point.velocity >> 20) * i64::from(CONTROL_HZ) + (1 << 19)) >> 20;
        Setpoint {
            travel: Travel(I32F32::from_bits(travel as i64)),
            speed: Speed(I8F24::from_bits(speed as i32)),
            acceleration: self.acceleration,
        }
    }
}
