//! The motor driver on the board's lines: from the levels at its pins to what it does with a motor.
//!
//! Each driver is the table of inputs and outputs of its data sheet, as `docs/drivers.md` wires it. The
//! firmware's table is not used: whichever of the two is wrong shows.

use shared_proto::{Driver, WheelPair};

/// Which driver is soldered to the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wiring {
    /// The part.
    pub driver: Driver,
    /// An inverter in the enable line.
    pub enable_inverted: bool,
    /// An inverter in the fault line.
    pub fault_inverted: bool,
}

impl Default for Wiring {
    /// A PWM and a direction line: what the image drives with its factory configuration.
    fn default() -> Self {
        Self { driver: Driver::PwmDir, enable_inverted: false, fault_inverted: false }
    }
}

/// What a bridge does with its motor at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Output {
    Forward,
    Backward,
    Brake,
    Coast,
}

/// A wheel's lines over a period of the PWM, and the drivers' enable line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelLines {
    /// Share of the period, from its begin, for which line A is high.
    pub a: f64,
    /// The same of line B.
    pub b: f64,
    /// Line C is high.
    pub c: bool,
}

/// What a bridge does with its motor over a period of the PWM: shares of the period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effect {
    /// The supply on the motor, forward.
    pub forward: f64,
    /// The supply on the motor, backward.
    pub backward: f64,
    /// The motor shorted.
    pub brake: f64,
    /// The motor open.
    pub coast: f64,
}

impl Effect {
    /// The mean voltage, as a share of the supply.
    pub fn duty(&self) -> f64 {
        self.forward - self.backward
    }
}

/// The lines of both wheels and what they have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoardLines {
    /// Lines A, B and C.
    pub wheels: WheelPair<WheelLines>,
    /// The enable line is high.
    pub enable: bool,
}

impl Wiring {
    /// What the driver does with both motors.
    pub fn effect(&self, lines: &BoardLines) -> WheelPair<Effect> {
        let enable = lines.enable != self.enable_inverted;
        lines.wheels.map(|wheel| self.over_a_period(&wheel, enable))
    }

    /// The level of the fault line.
    pub fn fault_line_high(&self, fault: bool) -> bool {
        fault == self.fault_inverted
    }

    fn over_a_period(&self, lines: &WheelLines, enable: bool) -> Effect {
        let mut ends = [lines.a, lines.b, 1.0];
        ends.sort_by(f64::total_cmp);
        let (mut effect, mut from) = (Effect::default(), 0.0);
        for to in ends {
            let middle = (from + to) / 2.0;
            let share = match self.output(middle < lines.a, middle < lines.b, lines.c, enable) {
                Output::Forward => &mut effect.forward,
                Output::Backward => &mut effect.backward,
                Output::Brake => &mut effect.brake,
                Output::Coast => &mut effect.coast,
            };
            *share += to - from;
            from = to;
        }
        effect
    }

    /// The data sheets' tables.
    fn output(&self, a: bool, b: bool, c: bool, enable: bool) -> Output {
        use Output::{Backward, Brake, Coast, Forward};
        match self.driver {
            // A: PWM, B: DIR.
            Driver::PwmDir => match (enable, a, b) {
                (false, ..) => Coast,
                (_, false, _) => Brake,
                (.., false) => Forward,
                (.., true) => Backward,
            },
            // The same without an enable input.
            Driver::Md10c => match (a, b) {
                (false, _) => Brake,
                (_, false) => Forward,
                (_, true) => Backward,
            },
            // L298N: ENA or ENB, IN1, IN2. BTS7960: both INH, RPWM, LPWM.
            Driver::L298n | Driver::Bts7960 => match (enable, a, b) {
                (false, ..) => Coast,
                (_, true, false) => Forward,
                (_, false, true) => Backward,
                _ => Brake,
            },
            // PWM on the enable line, INA, INB. Without PWM both low sides are off; a high side alone drives
            // nothing.
            Driver::Vnh5019 => match (enable, a, b) {
                (_, true, true) => Brake,
                (false, ..) => Coast,
                (_, true, false) => Forward,
                (_, false, true) => Backward,
                (_, false, false) => Brake,
            },
            // A: PWM, B: IN1, C: IN2, STBY on the enable line.
            Driver::Tb6612 | Driver::PwmIn1In2 => match (enable, b, c, a) {
                (false, ..) => Coast,
                (_, true, true, _) => Brake,
                (_, false, false, _) => Coast,
                (.., false) => Brake,
                (_, true, false, true) => Forward,
                (_, false, true, true) => Backward,
            },
            // nSLEEP on the enable line, xIN1, xIN2. The generic one is as an MX1508.
            Driver::Drv8833 | Driver::In1In2 => match (enable, a, b) {
                (false, ..) | (_, false, false) => Coast,
                (_, true, false) => Forward,
                (_, false, true) => Backward,
                (_, true, true) => Brake,
            },
            // IN1, IN2; nothing else.
            Driver::Drv8871 => match (a, b) {
                (false, false) => Coast,
                (true, false) => Forward,
                (false, true) => Backward,
                (true, true) => Brake,
            },
        }
    }
}
