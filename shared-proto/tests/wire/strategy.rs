//! Arbitrary messages: any bit pattern of any field, whether or not a robot would take it.

use proptest::collection::vec;
use proptest::prelude::*;
use shared_proto::*;

use crate::samples::{Any, faults, feedforward};

/// Any f64, every NaN, infinity and subnormal among them.
fn number() -> BoxedStrategy<f64> {
    any::<u64>().prop_map(f64::from_bits).boxed()
}

fn pair<T: std::fmt::Debug + 'static>(
    one: impl Fn() -> BoxedStrategy<T>,
) -> BoxedStrategy<WheelPair<T>> {
    (one(), one()).prop_map(|(left, right)| WheelPair { left, right }).boxed()
}

fn name() -> BoxedStrategy<Name> {
    vec(any::<char>(), 0..=NAME_LEN_MAX)
        .prop_map(|chars| {
            let mut text = String::new();
            for c in chars {
                if text.len() + c.len_utf8() <= NAME_LEN_MAX {
                    text.push(c);
                }
            }
            Name::new(&text).expect("short enough")
        })
        .boxed()
}

fn config() -> BoxedStrategy<Config> {
    let encoder = || {
        (number(), number(), any::<bool>())
            .prop_map(|(counts_per_rev, gear_reduction, reversed)| EncoderConfig {
                counts_per_rev,
                gear_reduction,
                reversed,
            })
            .boxed()
    };
    let motor = || any::<bool>().prop_map(|reversed| MotorConfig { reversed }).boxed();
    (name(), vec(number(), 31), pair(encoder), pair(motor), driver())
        .prop_map(|(name, n, encoder, motor, driver)| Config {
            name,
            geometry: GeometryConfig {
                wheel_radius_m: n[0],
                track_width_m: n[1],
                wheel_weight: n[2],
                heading_pull_rad_per_m: n[19],
            },
            encoder,
            motor,
            pid: PidConfig { kp_per_m: n[3], ki_per_m_s: n[4], kd_s_per_m: n[5] },
            feedforward: FeedforwardConfig {
                left: feedforward([n[6], n[7], n[8], n[23]]),
                right: feedforward([n[24], n[25], n[26], n[27]]),
                supply_v: n[20],
            },
            limits: LimitsConfig {
                speed_mps_max: n[9],
                acceleration_mps2_max: n[10],
                stop_deceleration_mps2: n[11],
                duty_max: n[12],
                duty_slew_per_s: n[13],
                hold_s: n[22],
            },
            protection: ProtectionConfig {
                following_error_m_max: n[14],
                stall_time_s: n[15],
                probe_duty_max: n[16],
                supply_v_min: n[17],
                supply_v_max: n[21],
                link_timeout_s: n[18],
            },
            odometry: OdometryConfig {
                noise_m_per_sqrt_m: n[28],
                wheel_weight_sd: n[29],
                track_width_sd_m: n[30],
            },
            driver,
        })
        .boxed()
}

fn driver() -> BoxedStrategy<DriverConfig> {
    let flags = any::<[bool; 2]>();
    let at_fault = proptest::sample::select(AtFault::ALL.to_vec());
    (number(), flags, driver_name(), at_fault)
        .prop_map(|(pwm_hz, [enable_inverted, fault_inverted], name, at_fault)| DriverConfig {
            pwm_hz,
            enable_inverted,
            fault_inverted,
            name,
            at_fault,
        })
        .boxed()
}

fn driver_name() -> BoxedStrategy<Driver> {
    proptest::sample::select(Driver::ALL.to_vec()).boxed()
}

fn wheel() -> BoxedStrategy<Wheel> {
    prop_oneof![Just(Wheel::Left), Just(Wheel::Right)].boxed()
}

fn state() -> BoxedStrategy<State> {
    proptest::sample::select(vec![
        State::Boot,
        State::Idle,
        State::Armed,
        State::Driving,
        State::Stopping,
        State::Faulted,
    ])
    .boxed()
}

fn fault_report() -> BoxedStrategy<FaultReport> {
    let fault = wheel().prop_flat_map(|wheel| proptest::sample::select(faults(wheel, wheel)));
    let wheel = || {
        (any::<i32>(), any::<i32>(), any::<i16>())
            .prop_map(|(error_um, speed_um_s, duty)| WheelAtFault { error_um, speed_um_s, duty })
    };
    let wheels = (wheel(), wheel()).prop_map(|(left, right)| WheelPair { left, right });
    (fault, any::<u32>(), any::<u64>(), any::<u16>(), wheels, any::<u16>())
        .prop_map(|(fault, number, t_us, followed_by, wheels, supply_mv)| FaultReport {
            fault,
            number,
            t_us,
            followed_by,
            wheels,
            supply_mv,
        })
        .boxed()
}

fn origin() -> BoxedStrategy<ConfigOrigin> {
    prop_oneof![Just(ConfigOrigin::Factory), Just(ConfigOrigin::Saved)].boxed()
}

fn motion_end() -> BoxedStrategy<MotionEnd> {
    proptest::sample::select(vec![
        MotionEnd::Completed,
        MotionEnd::Stopped,
        MotionEnd::Faulted,
        MotionEnd::Replaced,
        MotionEnd::TravelLimit,
        MotionEnd::SpeedLimit,
    ])
    .boxed()
}

fn drive() -> BoxedStrategy<Drive> {
    let unit = prop_oneof![Just(TravelUnit::Meter), Just(TravelUnit::WheelRevolution)];
    let start_us = any::<Option<u64>>();
    (any::<u32>(), unit, pair(number), number(), number(), start_us)
        .prop_map(|(motion, unit, distance, cruise, acceleration, start_us)| Drive {
            motion: MotionId(motion),
            unit,
            distance,
            cruise,
            acceleration,
            start_us,
        })
        .boxed()
}

fn velocity() -> BoxedStrategy<Velocity> {
    (any::<u32>(), number(), number(), number())
        .prop_map(|(motion, forward_mps, turn_rad_s, acceleration_mps2)| Velocity {
            motion: MotionId(motion),
            forward_mps,
            turn_rad_s,
            acceleration_mps2,
        })
        .boxed()
}

fn voltage() -> BoxedStrategy<Voltage> {
    (any::<u32>(), pair(number), vec(number(), 4))
        .prop_map(|(motion, volts, n)| Voltage {
            motion: MotionId(motion),
            volts,
            ramp_v_per_s: n[0],
            duration_s: n[1],
            travel_m_max: n[2],
            speed_mps_max: n[3],
        })
        .boxed()
}

fn command() -> BoxedStrategy<Command> {
    prop_oneof![
        proptest::sample::select(vec![
            Command::Identify,
            Command::Status,
            Command::ReadConfig,
            Command::SaveConfig,
            Command::Arm { take: false },
            Command::Arm { take: true },
            Command::Disarm,
            Command::Stop,
            Command::EmergencyStop,
        ]),
        config().prop_map(Command::WriteConfig),
        origin().prop_map(Command::RestoreConfig),
        drive().prop_map(Command::Drive),
        velocity().prop_map(Command::Velocity),
        voltage().prop_map(Command::Voltage),
        any::<u32>().prop_map(|motion| Command::Renew { motion: MotionId(motion) }),
        any::<u32>().prop_map(|number| Command::ClearFault { number }),
        any::<u16>().prop_map(|period_ms| Command::Subscribe { period_ms }),
        any::<u32>().prop_map(|number| Command::Recall { number }),
        proptest::option::of(any::<[u8; 16]>())
            .prop_map(|key| Command::SetKey { key: key.map(Key::new) }),
    ]
    .boxed()
}

fn identity() -> BoxedStrategy<Identity> {
    let reset_cause = proptest::sample::select(vec![
        ResetCause::PowerOn,
        ResetCause::Pin,
        ResetCause::Software,
        ResetCause::Watchdog,
        ResetCause::Panic,
        ResetCause::BrownOut,
    ]);
    let numbers = (any::<[u8; 12]>(), any::<[u16; 3]>(), any::<u16>(), any::<u32>(), config());
    (name(), name(), numbers, reset_cause, origin(), any::<[bool; 2]>())
        .prop_map(|(name, board, numbers, cause, origin, flags)| {
            let (uid, firmware, protocol, control_period_us, config) = numbers;
            Identity {
                name,
                board,
                uid,
                firmware,
                protocol,
                control_period_us,
                limits: config.limits,
                reset_cause: cause,
                config_origin: origin,
                store_damaged: flags[0],
                unsaved: flags[1],
            }
        })
        .boxed()
}

fn status() -> BoxedStrategy<Status> {
    let motion = proptest::option::of(any::<u32>().prop_map(MotionId));
    let motion_end = proptest::option::of(motion_end());
    let fault = proptest::option::of(fault_report());
    (any::<u64>(), state(), motion, motion_end, fault, any::<u16>(), any::<[u32; 8]>())
        .prop_map(|(t_us, state, motion, motion_end, fault, supply_mv, n)| Status {
            t_us,
            state,
            motion,
            motion_end,
            fault,
            supply_mv,
            link: LinkStatistics {
                frames_received: n[0],
                frames_damaged: n[1],
                frames_lost: n[2],
                frames_sent: n[3],
                telemetry_dropped: n[4],
                frames_refused: n[5],
            },
            ticks: n[5],
            tick_delay_us_max: n[6],
            ticks_lost: n[7],
        })
        .boxed()
}

fn refusal() -> BoxedStrategy<Refusal> {
    prop_oneof![
        state().prop_map(Refusal::State),
        fault_report().prop_map(Refusal::Faulted),
        (any::<u8>(), number())
            .prop_map(|(field, value)| Refusal::Config(ConfigError::OutOfRange { field, value })),
        (wheel(), number()).prop_map(|(wheel, meters)| Refusal::Config(
            ConfigError::DistancePerCount { wheel, meters }
        )),
        (driver_name(), number())
            .prop_map(|(driver, hz)| Refusal::Config(ConfigError::PwmFrequency { driver, hz })),
        driver_name().prop_map(|driver| Refusal::Config(ConfigError::AtFault {
            driver,
            at_fault: AtFault::Brake
        })),
        proptest::sample::select(vec![
            MotionError::NotPositive,
            MotionError::NoDistance,
            MotionError::TooFar,
            MotionError::TooFast,
            MotionError::TooSteep,
            MotionError::TooLong,
            MotionError::Start,
            MotionError::TooHigh,
        ])
        .prop_map(Refusal::Motion),
        proptest::sample::select(vec![
            Refusal::NoSuchMotion,
            Refusal::NoSuchFault,
            Refusal::CauseRemains,
            Refusal::Period,
            Refusal::Store,
            Refusal::HelloFirst,
            Refusal::Unreadable,
            Refusal::Forgotten,
            Refusal::Key,
            Refusal::WrongKey,
            Refusal::Late,
            Refusal::Lease,
            Refusal::Driven,
        ]),
    ]
    .boxed()
}

fn telemetry() -> BoxedStrategy<Telemetry> {
    let wheel = || {
        (any::<[i64; 3]>(), any::<[i32; 2]>(), any::<[i16; 5]>())
            .prop_map(|(wide, medium, narrow)| WheelTelemetry {
                counts: wide[0],
                setpoint_um: wide[1],
                error_um: medium[0],
                speed_um_s: medium[1],
                terms: PidTerms {
                    feedforward: narrow[0],
                    proportional: narrow[1],
                    integral: narrow[2],
                    derivative: narrow[3],
                },
                duty: narrow[4],
                applied_uvs: wide[2],
            })
            .boxed()
    };
    let pose =
        any::<[i64; 3]>().prop_map(|[x_um, y_um, heading_urad]| Pose { x_um, y_um, heading_urad });
    let deviation = (any::<[u32; 3]>(), any::<[i16; 3]>()).prop_map(|(sd, correlation)| {
        let [x_um, y_um, heading_urad] = sd;
        let [x_y, x_heading, y_heading] = correlation;
        PoseDeviation { x_um, y_um, heading_urad, x_y, x_heading, y_heading }
    });
    let place = (pose, deviation);
    (any::<u32>(), any::<u64>(), state(), any::<bool>(), pair(wheel), (any::<u16>(), place))
        .prop_map(|(number, t_us, state, probing, wheels, (supply_mv, (pose, deviation)))| {
            Telemetry { number, t_us, state, probing, wheels, supply_mv, pose, deviation }
        })
        .boxed()
}

fn event() -> BoxedStrategy<Event> {
    prop_oneof![
        (any::<u64>(), state()).prop_map(|(t_us, state)| Event::State { t_us, state }),
        fault_report().prop_map(Event::Fault),
        (any::<u64>(), any::<u32>(), motion_end()).prop_map(|(t_us, motion, end)| {
            Event::MotionEnded { t_us, motion: MotionId(motion), end }
        }),
    ]
    .boxed()
}

/// A message of any kind.
pub fn message() -> BoxedStrategy<Any> {
    let outcome = prop_oneof![
        Just(Ok(Answer::Done)),
        identity().prop_map(|identity| Ok(Answer::Identity(identity))),
        status().prop_map(|status| Ok(Answer::Status(status))),
        config().prop_map(|config| Ok(Answer::Config(config))),
        telemetry().prop_map(|telemetry| Ok(Answer::Telemetry(telemetry))),
        refusal().prop_map(Err),
    ];
    prop_oneof![
        (any::<u16>(), any::<u64>(), any::<u32>()).prop_map(|(protocol, schema, session)| {
            Any::Hello(Hello { protocol, schema, session })
        }),
        (any::<u32>(), any::<u32>(), any::<u64>(), command()).prop_map(
            |(session, id, until_ms, command)| {
                Any::Request(Request { session, id, until_ms, command })
            }
        ),
        (any::<u32>(), any::<u32>(), any::<u64>(), outcome).prop_map(
            |(session, id, t_us, outcome)| Any::Reply(Reply { session, id, t_us, outcome })
        ),
        telemetry().prop_map(Any::Telemetry),
        event().prop_map(Any::Event),
    ]
    .boxed()
}
