//! Motor drivers by name: how each is wired and what it does with its lines.
//!
//! A board has three lines for each wheel (A, B, C), an enable line and a fault line for both.
//! `docs/drivers.md` says which pin of a driver goes to which, and where each figure comes from.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// A motor driver, or a kind of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "snake_case")]
pub enum Driver {
    /// Any with a PWM and a direction input.
    #[default]
    PwmDir,
    /// Any with two inputs, both low between the pulses.
    In1In2,
    /// Any with a PWM and two direction inputs.
    PwmIn1In2,
    /// ST L298N.
    L298n,
    /// Toshiba TB6612FNG.
    Tb6612,
    /// TI DRV8833.
    Drv8833,
    /// TI DRV8871.
    Drv8871,
    /// Two Infineon BTS7960 for each motor, as on the IBT-2 module.
    Bts7960,
    /// ST VNH5019.
    Vnh5019,
    /// Cytron MD10C and MDD10A.
    Md10c,
}

/// What the lines of a wheel do. A and B come from the timer, C is a pin that is high or low.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inputs {
    /// A: PWM; B: low forward, high backward.
    PwmDirection,
    /// Forward: PWM on A and B low; backward the other way round.
    TwoPwmLow,
    /// Forward: A high and B low during the pulse, high between the pulses; backward the other way round.
    TwoPwmHigh,
    /// A: PWM; B high and C low forward, the other way round backward, both high at no duty.
    PwmTwoDirections,
}

/// What a driver does with a motor's terminals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Terminals {
    /// Open: the motor coasts.
    Open,
    /// Shorted: the motor brakes.
    Shorted,
    /// It differs from one driver of this kind to another.
    Unknown,
}

/// What the firmware has to know of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriverFacts {
    /// The lines of a wheel.
    pub inputs: Inputs,
    /// The terminals between the pulses: shorted is slow decay, open is fast decay.
    pub between_pulses: Terminals,
    /// The terminals of a motor that stands, with the driver enabled.
    pub standing: Terminals,
    /// The terminals with the driver disabled and all lines low.
    pub off: Terminals,
    /// It has an enable line; without one, low lines switch it off.
    pub has_enable: bool,
    /// It has a fault line, low at a fault unless inverted on the way.
    pub has_fault: bool,
    /// Highest PWM frequency that it bears \[Hz\].
    pub pwm_hz_max: u32,
}

impl Driver {
    /// Every driver, in the order of their numbers on the wire.
    pub const ALL: [Driver; 10] = [
        Driver::PwmDir,
        Driver::In1In2,
        Driver::PwmIn1In2,
        Driver::L298n,
        Driver::Tb6612,
        Driver::Drv8833,
        Driver::Drv8871,
        Driver::Bts7960,
        Driver::Vnh5019,
        Driver::Md10c,
    ];

    /// As in the configuration.
    pub const fn name(self) -> &'static str {
        match self {
            Driver::PwmDir => "pwm_dir",
            Driver::In1In2 => "in1_in2",
            Driver::PwmIn1In2 => "pwm_in1_in2",
            Driver::L298n => "l298n",
            Driver::Tb6612 => "tb6612",
            Driver::Drv8833 => "drv8833",
            Driver::Drv8871 => "drv8871",
            Driver::Bts7960 => "bts7960",
            Driver::Vnh5019 => "vnh5019",
            Driver::Md10c => "md10c",
        }
    }

    /// What the firmware has to know of it. The sources are in `docs/drivers.md`.
    pub const fn facts(self) -> DriverFacts {
        use Inputs::{PwmDirection, PwmTwoDirections, TwoPwmHigh, TwoPwmLow};
        use Terminals::{Open, Shorted, Unknown};
        /// Brakes between the pulses and at a standstill, coasts when it is off.
        const USUAL: DriverFacts = DriverFacts {
            inputs: TwoPwmLow,
            between_pulses: Shorted,
            standing: Shorted,
            off: Open,
            has_enable: true,
            has_fault: false,
            pwm_hz_max: PWM_HZ_MAX,
        };
        /// All that is not known of a kind.
        const ANY: DriverFacts = DriverFacts {
            between_pulses: Unknown,
            standing: Unknown,
            off: Unknown,
            has_fault: true,
            ..USUAL
        };
        match self {
            Driver::PwmDir => DriverFacts { inputs: PwmDirection, ..ANY },
            Driver::In1In2 => ANY,
            Driver::PwmIn1In2 => DriverFacts { inputs: PwmTwoDirections, standing: Shorted, ..ANY },
            Driver::L298n => DriverFacts { pwm_hz_max: 40_000, ..USUAL },
            Driver::Tb6612 => DriverFacts { inputs: PwmTwoDirections, ..USUAL },
            Driver::Drv8833 => DriverFacts { inputs: TwoPwmHigh, has_fault: true, ..USUAL },
            Driver::Drv8871 => DriverFacts { inputs: TwoPwmHigh, has_enable: false, ..USUAL },
            Driver::Bts7960 => DriverFacts { pwm_hz_max: 25_000, ..USUAL },
            Driver::Vnh5019 => DriverFacts { has_fault: true, pwm_hz_max: 20_000, ..USUAL },
            Driver::Md10c => DriverFacts {
                inputs: PwmDirection,
                off: Shorted,
                has_enable: false,
                pwm_hz_max: 20_000,
                ..USUAL
            },
        }
    }
}

/// Highest PWM frequency of any driver \[Hz\].
const PWM_HZ_MAX: u32 = 100_000;

/// What becomes of the motors at a fault that takes their duty away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "snake_case")]
pub enum AtFault {
    /// The driver is switched off, whatever the motors do then.
    #[default]
    Off,
    /// The motors coast.
    Coast,
    /// The motors brake, until the fault is cleared.
    Brake,
}

impl AtFault {
    /// Every choice, in the order of their numbers on the wire.
    pub const ALL: [AtFault; 3] = [AtFault::Off, AtFault::Coast, AtFault::Brake];

    /// As in the configuration.
    pub const fn name(self) -> &'static str {
        match self {
            AtFault::Off => "off",
            AtFault::Coast => "coast",
            AtFault::Brake => "brake",
        }
    }
}

/// Which motor driver there is, and how it is used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(default, deny_unknown_fields)]
pub struct DriverConfig {
    /// PWM frequency \[Hz\].
    pub pwm_hz: f64,
    /// True if the enable line is low when the driver is enabled.
    pub enable_inverted: bool,
    /// True if the fault line is high at a fault.
    pub fault_inverted: bool,
    /// Which one.
    pub name: Driver,
    /// What becomes of the motors at a fault.
    pub at_fault: AtFault,
}

impl Default for DriverConfig {
    /// A PWM and a direction line at 20 kHz: above the audible range, and every driver in the table bears it.
    fn default() -> Self {
        Self {
            pwm_hz: 20_000.0,
            enable_inverted: false,
            fault_inverted: false,
            name: Driver::PwmDir,
            at_fault: AtFault::Off,
        }
    }
}

impl DriverConfig {
    /// Whether the driver can do with the motors what is wanted at a fault.
    pub fn can_do_at_fault(&self) -> bool {
        let facts = self.name.facts();
        match self.at_fault {
            AtFault::Off => true,
            AtFault::Coast => facts.off != Terminals::Shorted,
            AtFault::Brake => facts.standing != Terminals::Open,
        }
    }
}
