//! Voltages at both motors, open loop: ramps between them, their limits, and the duty for the supply at hand.
//!
//! ```text
//! V <- V + clamp(target - V, +-ramp dt)                  each tick                            (1)
//! u  = V / U, within +-duty_max                          U: the supply, measured at this tick (2)
//! sum <- sum + u U dt                                    the applied voltage, for telemetry   (3)
//! ```
//!
//! V in steps of 2^-24 V, to 128 V. A ramp of 0.01 V/s is 168 steps a tick. (3) is in steps of 2^-16 uV s, and the 64
//! bits hold a month at 60 V.

use fixed::types::I2F30;
use shared_proto::{MotionEnd, Voltage, WheelPair};

use crate::soft_float::{nearest, truncate};
use crate::units::{CONTROL_HZ, Duty, Speed, Travel, saturate_i32};

/// Fractional bits of a voltage.
const VOLT_BITS: u32 = 24;
/// Fractional bits of a duty.
const DUTY_BITS: u32 = 30;
/// Fractional bits of a travel.
const TRAVEL_BITS: u32 = 32;
/// Fractional bits of a speed.
const SPEED_BITS: u32 = 24;
/// Bits by which (3) is finer than 1 uV s.
const APPLIED_BITS: u32 = 16;

/// Wheels without a count for so long stand \[ticks\].
const STANDS_TICKS: u32 = 100;
/// A wheel that never comes to rest, on a slope for one, is left alone after this \[ticks\].
const ROLLS_TICKS_MAX: u32 = 5 * CONTROL_HZ;

/// One voltage at each motor, with its limits.
#[derive(Clone, Copy, Debug)]
pub struct VoltagePlan {
    target: WheelPair<i32>,
    ramp_dt: i32,
    ticks: u32,
    travel_max: i64,
    speed_max: i32,
}

impl VoltagePlan {
    /// Of a voltage that its [check](Voltage::check) admits.
    #[inline]
    pub fn new(voltage: &Voltage) -> Self {
        let hz = f64::from(CONTROL_HZ);
        Self {
            target: voltage.volts.map(|volts| saturate_i32(nearest(volts, VOLT_BITS))),
            ramp_dt: saturate_i32(nearest(voltage.ramp_v_per_s / hz, VOLT_BITS)).max(1),
            ticks: truncate(voltage.duration_s * hz, 0) as u32,
            travel_max: truncate(voltage.travel_m_max, TRAVEL_BITS),
            speed_max: saturate_i32(nearest(voltage.speed_mps_max, SPEED_BITS)),
        }
    }
}

/// Follows a [`VoltagePlan`], and then waits for the wheels to stand.
#[derive(Clone, Copy, Debug)]
pub struct OpenLoop {
    plan: VoltagePlan,
    start: WheelPair<Travel>,
    volts: WheelPair<i32>,
    ticks: u32,
    /// How it ended; the voltages are zero from then on.
    end: Option<MotionEnd>,
    last: WheelPair<Travel>,
    standing_ticks: u32,
}

/// What one tick of an [`OpenLoop`] gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpenLoopStep {
    /// These voltages \[2^-24 V\].
    Apply(WheelPair<i32>),
    /// None: the wheels roll out.
    Roll,
    /// None: the wheels stand.
    Ended(MotionEnd),
}

impl OpenLoop {
    /// Begins a plan with the wheels here, from no voltage.
    #[inline]
    pub fn new(plan: VoltagePlan, travel: WheelPair<Travel>) -> Self {
        let volts = WheelPair::both(0);
        let (start, last) = (travel, travel);
        Self { plan, start, volts, ticks: 0, end: None, last, standing_ticks: 0 }
    }

    /// Goes on with another plan, from the present voltages.
    #[inline]
    pub fn replace(&mut self, plan: VoltagePlan, travel: WheelPair<Travel>) {
        *self = Self { volts: self.volts, ..Self::new(plan, travel) };
    }

    /// Ends it now.
    #[inline]
    pub fn halt(&mut self) {
        if self.end.is_none() {
            self.finish(MotionEnd::Stopped);
        }
    }

    #[inline]
    fn finish(&mut self, end: MotionEnd) {
        self.end = Some(end);
        self.ticks = 0;
        self.volts = WheelPair::both(0);
    }

    /// One tick, with both wheels' travel and speed.
    #[inline]
    pub fn step(&mut self, travel: &WheelPair<Travel>, speed: &WheelPair<Speed>) -> OpenLoopStep {
        self.ticks = self.ticks.saturating_add(1);
        let limit = |found: bool, end| found.then_some(end);
        let plan = &self.plan;
        if self.end.is_none() {
            let too_far = travel.zip(self.start).any(|(now, start)| {
                now.0.to_bits().wrapping_sub(start.0.to_bits()).saturating_abs() >= plan.travel_max
            });
            let too_fast = speed.any(|speed| speed.0.to_bits().saturating_abs() >= plan.speed_max);
            let end = limit(too_far, MotionEnd::TravelLimit)
                .or(limit(too_fast, MotionEnd::SpeedLimit))
                .or(limit(self.ticks > plan.ticks, MotionEnd::Completed));
            if let Some(end) = end {
                self.finish(end);
            }
        }
        let Some(end) = self.end else {
            let WheelPair { left, right } = self.plan.target;
            let ramp = self.plan.ramp_dt;
            // (1)
            let toward = |present: i32, target: i32| {
                present + target.saturating_sub(present).max(-ramp).min(ramp)
            };
            self.volts.left = toward(self.volts.left, left);
            self.volts.right = toward(self.volts.right, right);
            return OpenLoopStep::Apply(self.volts);
        };
        self.standing_ticks = if *travel == self.last { self.standing_ticks + 1 } else { 0 };
        self.last = *travel;
        if self.standing_ticks >= STANDS_TICKS || self.ticks >= ROLLS_TICKS_MAX {
            OpenLoopStep::Ended(end)
        } else {
            OpenLoopStep::Roll
        }
    }
}

/// (2): the duty for these voltages \[2^-24 V\] on this supply, within +-`duty_max`.
#[inline]
pub fn duty_of(volts: WheelPair<i32>, supply_mv: u16, duty_max: Duty) -> WheelPair<Duty> {
    let max = duty_max.0.to_bits();
    let per_mv = 1000 << (DUTY_BITS - VOLT_BITS);
    volts.map(|volts| {
        let wanted = i64::from(volts) * per_mv / i64::from(supply_mv.max(1));
        Duty(I2F30::from_bits(saturate_i32(wanted).max(-max).min(max)))
    })
}

/// Both motors' applied voltage, summed over time, as (3).
#[derive(Clone, Copy, Debug, Default)]
pub struct AppliedVoltage(WheelPair<i64>);

impl AppliedVoltage {
    /// Nothing yet.
    pub const ZERO: Self = Self(WheelPair::both(0));

    /// Adds one tick at this duty and supply.
    #[inline(always)]
    pub fn add(&mut self, duty: WheelPair<Duty>, supply_mv: u16) {
        // A tick is 1 ms: mV ms are uV s.
        let add = |sum: &mut i64, duty: Duty| {
            let share = duty.0.to_bits() >> (DUTY_BITS - APPLIED_BITS);
            *sum = sum.wrapping_add(i64::from(share) * i64::from(supply_mv));
        };
        add(&mut self.0.left, duty.left);
        add(&mut self.0.right, duty.right);
    }

    /// In microvolt-seconds, as telemetry sends it.
    #[inline]
    pub fn to_uvs(self) -> WheelPair<i64> {
        self.0.map(|sum| sum >> APPLIED_BITS)
    }
}

const _: () = assert!(CONTROL_HZ == 1000, "a tick is a millisecond in (3)");
