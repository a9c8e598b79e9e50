//! Faults and their times.

use serde::{Deserialize, Serialize};
use shared_proto::Wheel;

use crate::plant::{ParameterError, PlantFault, RangeCheck};

/// Which clock a fault's times are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultClock {
    /// Simulated time, from power-on.
    Simulated,
    /// From the first time the motors are driven.
    Motion,
}

/// A fault and its times, one `[[fault]]` of a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Raw", into = "Raw")]
pub struct ScheduledFault {
    /// The fault.
    pub fault: PlantFault,
    /// Which clock the times are on.
    pub clock: FaultClock,
    /// When \[s\].
    pub at_s: f64,
    /// When the fault ends, if ever \[s\].
    pub until_s: Option<f64>,
}

impl ScheduledFault {
    /// Refuses a negative time, or an end before the beginning, and names the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("");
        let at = match self.clock {
            FaultClock::Simulated => "at_s",
            FaultClock::Motion => "at_motion_s",
        };
        check.within(at, self.at_s, 0.0, TIME_S_MAX)?;
        if let Some(until_s) = self.until_s {
            check.within("until_s", until_s, self.at_s, TIME_S_MAX)?;
        }
        match self.fault {
            PlantFault::EncoderNoise(_, rate) => check.within("counts_per_s", rate, -1e6, 1e6),
            PlantFault::SupplyDip { volts } => check.within("volts", volts, -100.0, 100.0),
            _ => Ok(()),
        }
    }
}

/// A year: longer than any simulation, and exact in microseconds.
const TIME_S_MAX: f64 = 3.2e7;

/// A fault as in the file: flat, with the fields that its kind needs.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    kind: Kind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wheel: Option<Wheel>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    counts_per_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    volts: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    at_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    at_motion_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    until_s: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    EncoderUnplugged,
    EncoderReversed,
    EncoderNoise,
    WheelBlocked,
    WheelJammed,
    MotorUnplugged,
    MotorReversed,
    EncodersExchanged,
    MotorsExchanged,
    SupplyDip,
    DriverFault,
    #[default]
    EmergencyStop,
}

impl TryFrom<Raw> for ScheduledFault {
    type Error = String;

    fn try_from(raw: Raw) -> Result<Self, String> {
        let (clock, at_s) = match (raw.at_s, raw.at_motion_s) {
            (Some(at_s), None) => (FaultClock::Simulated, at_s),
            (None, Some(at_s)) => (FaultClock::Motion, at_s),
            (None, None) => return Err("missing field `at_s` or `at_motion_s`".into()),
            (Some(_), Some(_)) => return Err("both `at_s` and `at_motion_s`: keep one".into()),
        };
        Ok(Self { fault: raw.fault()?, clock, at_s, until_s: raw.until_s })
    }
}

impl Raw {
    /// The fault; refuses a field that its kind needs and lacks, or has no use for.
    fn fault(&self) -> Result<PlantFault, String> {
        let Self { kind, wheel, counts_per_s, volts, .. } = *self;
        let of_wheel = !matches!(
            kind,
            Kind::EncodersExchanged
                | Kind::MotorsExchanged
                | Kind::DriverFault
                | Kind::SupplyDip
                | Kind::EmergencyStop
        );
        check_presence("wheel", wheel.is_some(), of_wheel, kind)?;
        check_presence("counts_per_s", counts_per_s.is_some(), kind == Kind::EncoderNoise, kind)?;
        check_presence("volts", volts.is_some(), kind == Kind::SupplyDip, kind)?;
        let wheel = wheel.unwrap_or(Wheel::Left);
        Ok(match kind {
            Kind::EncoderUnplugged => PlantFault::EncoderUnplugged(wheel),
            Kind::EncoderReversed => PlantFault::EncoderReversed(wheel),
            Kind::EncoderNoise => PlantFault::EncoderNoise(wheel, counts_per_s.unwrap_or(0.0)),
            Kind::WheelBlocked => PlantFault::WheelBlocked(wheel),
            Kind::WheelJammed => PlantFault::WheelJammed(wheel),
            Kind::MotorUnplugged => PlantFault::MotorUnplugged(wheel),
            Kind::MotorReversed => PlantFault::MotorReversed(wheel),
            Kind::EncodersExchanged => PlantFault::EncodersExchanged,
            Kind::MotorsExchanged => PlantFault::MotorsExchanged,
            Kind::DriverFault => PlantFault::DriverFault,
            Kind::SupplyDip => PlantFault::SupplyDip { volts: volts.unwrap_or(0.0) },
            Kind::EmergencyStop => PlantFault::EmergencyStop,
        })
    }
}

fn check_presence(field: &str, present: bool, wanted: bool, kind: Kind) -> Result<(), String> {
    // As the file spells it.
    let kind = toml::Value::try_from(kind).map_err(|error| error.to_string())?;
    match (present, wanted) {
        (false, true) => Err(format!("missing field `{field}`, which kind = {kind} needs")),
        (true, false) => Err(format!("unknown field `{field}`: kind = {kind} has none")),
        _ => Ok(()),
    }
}

impl From<ScheduledFault> for Raw {
    fn from(scheduled: ScheduledFault) -> Self {
        let mut raw = Raw { until_s: scheduled.until_s, ..Raw::default() };
        match scheduled.clock {
            FaultClock::Simulated => raw.at_s = Some(scheduled.at_s),
            FaultClock::Motion => raw.at_motion_s = Some(scheduled.at_s),
        }
        let (kind, wheel) = match scheduled.fault {
            PlantFault::EncoderUnplugged(w) => (Kind::EncoderUnplugged, Some(w)),
            PlantFault::EncoderReversed(w) => (Kind::EncoderReversed, Some(w)),
            PlantFault::EncoderNoise(w, _) => (Kind::EncoderNoise, Some(w)),
            PlantFault::WheelBlocked(w) => (Kind::WheelBlocked, Some(w)),
            PlantFault::WheelJammed(w) => (Kind::WheelJammed, Some(w)),
            PlantFault::MotorUnplugged(w) => (Kind::MotorUnplugged, Some(w)),
            PlantFault::MotorReversed(w) => (Kind::MotorReversed, Some(w)),
            PlantFault::EncodersExchanged => (Kind::EncodersExchanged, None),
            PlantFault::MotorsExchanged => (Kind::MotorsExchanged, None),
            PlantFault::DriverFault => (Kind::DriverFault, None),
            PlantFault::SupplyDip { .. } => (Kind::SupplyDip, None),
            PlantFault::EmergencyStop => (Kind::EmergencyStop, None),
        };
        (raw.kind, raw.wheel) = (kind, wheel);
        match scheduled.fault {
            PlantFault::EncoderNoise(_, rate) => raw.counts_per_s = Some(rate),
            PlantFault::SupplyDip { volts } => raw.volts = Some(volts),
            _ => {}
        }
        raw
    }
}
