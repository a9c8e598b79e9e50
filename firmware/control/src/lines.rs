//! What the lines of a wheel's motor driver do at a duty.

use shared_proto::{Inputs, WheelPair};

use crate::units::Duty;

/// One wheel's lines during a PWM period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    /// How long line A is high, from the period's begin \[timer ticks\].
    pub a: u32,
    /// How long line B is high, from the period's begin \[timer ticks\].
    pub b: u32,
    /// Whether line C is high.
    pub c: bool,
}

impl Lines {
    /// All low, as without a driver that is enabled.
    pub const LOW: Self = Self { a: 0, b: 0, c: false };

    /// Both wheels' lines at their duties, with a period of so many timer ticks.
    #[inline(never)]
    pub fn at_both(inputs: Inputs, duty: WheelPair<Duty>, period: u32) -> WheelPair<Self> {
        duty.map(|duty| Self::at(inputs, duty, period))
    }

    /// The lines at a duty, with a period of so many timer ticks. At no duty the motor brakes, if the driver can.
    #[inline(always)]
    fn at(inputs: Inputs, Duty(duty): Duty, period: u32) -> Self {
        let bits = duty.to_bits();
        // Steps of 2^-30 to timer ticks, to the nearest; a duty is 1 at most.
        // The product's upper word is that shifted by 32, which takes no instruction.
        let pulse = (u64::from(bits.unsigned_abs()) * u64::from(period << 2) + (1 << 31)) >> 32;
        let pulse = (pulse as u32).min(period);
        let backward = bits < 0;
        let (forward, other) = match inputs {
            Inputs::PwmDirection => {
                return Self { a: pulse, b: if backward { period } else { 0 }, c: false };
            }
            Inputs::PwmTwoDirections => {
                return if pulse == 0 {
                    Self { a: period, b: period, c: true }
                } else {
                    Self { a: pulse, b: if backward { 0 } else { period }, c: backward }
                };
            }
            Inputs::TwoPwmLow => (pulse, 0),
            Inputs::TwoPwmHigh => (period, period - pulse),
        };
        let (a, b) = if backward { (other, forward) } else { (forward, other) };
        Self { a, b, c: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: u32 = 8400;

    /// `duty` in eighths, as A, B in ticks and C.
    fn at(inputs: Inputs, eighths: i32) -> (u32, u32, bool) {
        let Lines { a, b, c } =
            Lines::at(inputs, Duty(fixed::FixedI32::from_bits(eighths << 27)), PERIOD);
        (a, b, c)
    }

    #[test]
    fn a_duty_of_three_eighths_forward_and_back_is_these_pulses() {
        use Inputs::{PwmDirection, PwmTwoDirections, TwoPwmHigh, TwoPwmLow};
        let (on, off) = (3150, 5250);
        assert_eq!(at(PwmDirection, 3), (on, 0, false));
        assert_eq!(at(PwmDirection, -3), (on, PERIOD, false));
        assert_eq!(at(TwoPwmLow, 3), (on, 0, false));
        assert_eq!(at(TwoPwmLow, -3), (0, on, false));
        assert_eq!(at(TwoPwmHigh, 3), (PERIOD, off, false));
        assert_eq!(at(TwoPwmHigh, -3), (off, PERIOD, false));
        assert_eq!(at(PwmTwoDirections, 3), (on, PERIOD, false));
        assert_eq!(at(PwmTwoDirections, -3), (on, 0, true));
    }

    #[test]
    fn at_no_duty_both_inputs_are_alike_and_at_full_duty_nothing_pulses() {
        use Inputs::{PwmDirection, PwmTwoDirections, TwoPwmHigh, TwoPwmLow};
        for inputs in [TwoPwmLow, TwoPwmHigh] {
            let (a, b, _) = at(inputs, 0);
            assert_eq!(a, b, "{inputs:?}");
        }
        assert_eq!(at(PwmTwoDirections, 0), (PERIOD, PERIOD, true), "IN1 and IN2 are alike");
        assert_eq!(at(PwmDirection, 0).0, 0);
        for inputs in [PwmDirection, PwmTwoDirections, TwoPwmHigh, TwoPwmLow] {
            for full in [8, -8] {
                let (a, b, _) = at(inputs, full);
                assert!([a, b].iter().all(|&on| on == 0 || on == PERIOD), "{inputs:?}: {a} {b}");
            }
        }
    }
}
