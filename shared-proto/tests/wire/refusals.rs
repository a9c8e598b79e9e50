//! Every reason for which a robot refuses a request, by name.

use shared_proto::*;

/// A refusal of every kind.
pub fn refusals() -> Vec<(String, Refusal)> {
    let out_of_range = ConfigError::OutOfRange { field: 2, value: 1.5 };
    let per_count = ConfigError::DistancePerCount { wheel: Wheel::Right, meters: 0.25 };
    let pwm = |driver| Refusal::Config(ConfigError::PwmFrequency { driver, hz: 25_000.0 });
    let at_fault =
        |at_fault| Refusal::Config(ConfigError::AtFault { driver: Driver::Md10c, at_fault });
    let drivers =
        Driver::ALL.map(|driver| (format!("config.pwm_frequency.{}", driver.name()), pwm(driver)));
    let at_faults =
        AtFault::ALL.map(|what| (format!("config.at_fault.{}", what.name()), at_fault(what)));
    let others = vec![
        ("state", Refusal::State(State::Driving)),
        ("faulted", Refusal::Faulted(report(Fault::SupplyLow))),
        ("config.out_of_range", Refusal::Config(out_of_range)),
        ("config.distance_per_count", Refusal::Config(per_count)),
        ("motion.not_positive", Refusal::Motion(MotionError::NotPositive)),
        ("motion.no_distance", Refusal::Motion(MotionError::NoDistance)),
        ("motion.too_far", Refusal::Motion(MotionError::TooFar)),
        ("motion.too_fast", Refusal::Motion(MotionError::TooFast)),
        ("motion.too_steep", Refusal::Motion(MotionError::TooSteep)),
        ("motion.too_long", Refusal::Motion(MotionError::TooLong)),
        ("motion.start", Refusal::Motion(MotionError::Start)),
        ("motion.too_high", Refusal::Motion(MotionError::TooHigh)),
        ("no_such_motion", Refusal::NoSuchMotion),
        ("no_such_fault", Refusal::NoSuchFault),
        ("cause_remains", Refusal::CauseRemains),
        ("period", Refusal::Period),
        ("store", Refusal::Store),
        ("hello_first", Refusal::HelloFirst),
        ("unreadable", Refusal::Unreadable),
        ("late", Refusal::Late),
        ("lease", Refusal::Lease),
        ("driven", Refusal::Driven),
        ("forgotten", Refusal::Forgotten),
        ("key", Refusal::Key),
        ("wrong_key", Refusal::WrongKey),
    ];
    let others = others.into_iter().map(|(name, refusal)| (name.to_string(), refusal));
    others.chain(drivers).chain(at_faults).collect()
}

/// A fault with numbers of which no two are alike.
pub fn report(fault: Fault) -> FaultReport {
    let wheels = WheelPair {
        left: WheelAtFault { error_um: 20_400, speed_um_s: 1200, duty: 31_000 },
        right: WheelAtFault { error_um: -150, speed_um_s: 118_300, duty: 8904 },
    };
    let (t_us, followed_by, supply_mv) = (20_475_000, 300, 11_200);
    FaultReport { fault, number: 3, t_us, followed_by, wheels, supply_mv }
}
