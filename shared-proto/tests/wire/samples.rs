//! One message of every kind, with every variant of every enum in at least one of them.

use shared_proto::*;

use crate::refusals::{refusals, report};

/// A message, or the hello.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a few dozen of them in a test")]
pub enum Any {
    Hello(Hello),
    Challenge(Hello, Nonce),
    Open(Open),
    Opened(Opened),
    Request(Request),
    Reply(Reply),
    Telemetry(Telemetry),
    Event(Event),
}

impl Any {
    pub fn frame(&self, encoder: &mut Encoder) -> Frame {
        match self {
            Any::Hello(hello) => encoder.hello(*hello),
            Any::Challenge(hello, nonce) => encoder.challenge(*hello, *nonce),
            Any::Open(open) => encoder.open(*open, &session_key()),
            Any::Opened(opened) => encoder.opened(*opened, &session_key()),
            Any::Request(message) => encoder.message(message),
            Any::Reply(message) => encoder.message(message),
            Any::Telemetry(message) => encoder.message(message),
            Any::Event(message) => encoder.message(message),
        }
    }

    pub fn read(received: &Received<'_>) -> Option<Self> {
        Some(match received.channel {
            Channel::Hello => match received.challenge() {
                None => Any::Hello(received.hello()?),
                Some(challenge) => Any::Challenge(received.hello()?, challenge),
            },
            Channel::Open => Any::Open(received.open()?),
            Channel::Opened => Any::Opened(received.opened()?),
            Channel::Request => Any::Request(received.message()?),
            Channel::Reply => Any::Reply(received.message()?),
            Channel::Telemetry => Any::Telemetry(received.message()?),
            Channel::Event => Any::Event(received.message()?),
        })
    }
}

/// A configuration in which no two numbers are alike, so that exchanged fields show.
pub fn config() -> Config {
    Config {
        name: Name::new("bumble").unwrap(),
        geometry: GeometryConfig {
            wheel_radius_m: 0.036,
            track_width_m: 0.372,
            wheel_weight: 0.9919,
            heading_pull_rad_per_m: -0.0125,
        },
        encoder: WheelPair {
            left: EncoderConfig { counts_per_rev: 900.0, gear_reduction: 1.5, reversed: false },
            right: EncoderConfig { counts_per_rev: 901.0, gear_reduction: 1.25, reversed: true },
        },
        motor: WheelPair {
            left: MotorConfig { reversed: true },
            right: MotorConfig { reversed: false },
        },
        pid: PidConfig { kp_per_m: 40.0, ki_per_m_s: 60.0, kd_s_per_m: 1.0 },
        feedforward: FeedforwardConfig {
            left: feedforward([0.48, 0.52, 24.0, 1.2]),
            right: feedforward([0.46, 0.5, 25.0, 1.3]),
            supply_v: 12.6,
        },
        limits: LimitsConfig {
            speed_mps_max: 0.6,
            acceleration_mps2_max: 1.1,
            stop_deceleration_mps2: 0.5,
            duty_max: 0.95,
            duty_slew_per_s: 20.0,
            hold_s: 2.5,
        },
        protection: ProtectionConfig {
            following_error_m_max: 0.02,
            stall_time_s: 0.06,
            probe_duty_max: 0.25,
            supply_v_min: 9.0,
            supply_v_max: 16.8,
            link_timeout_s: 0.2,
        },
        odometry: OdometryConfig {
            noise_m_per_sqrt_m: 0.0007,
            wheel_weight_sd: 0.0003,
            track_width_sd_m: 0.0015,
        },
        driver: DriverConfig {
            pwm_hz: 16_000.0,
            enable_inverted: true,
            fault_inverted: false,
            name: Driver::Drv8833,
            at_fault: AtFault::Brake,
        },
    }
}

/// kS both ways, kV, kA.
pub fn feedforward(
    [ks_forward_v, ks_backward_v, kv_v_s_per_m, ka_v_s2_per_m]: [f64; 4],
) -> WheelFeedforward {
    WheelFeedforward { ks_forward_v, ks_backward_v, kv_v_s_per_m, ka_v_s2_per_m }
}

fn identity(reset_cause: ResetCause, config_origin: ConfigOrigin) -> Identity {
    Identity {
        name: Name::new("bumble").unwrap(),
        board: Name::new("simulator").unwrap(),
        uid: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12],
        firmware: [0, 1, 200],
        protocol: 1,
        control_period_us: 1000,
        limits: config().limits,
        reset_cause,
        config_origin,
        store_damaged: true,
        unsaved: false,
    }
}

fn status(state: State, motion_end: Option<MotionEnd>, fault: Option<Fault>) -> Status {
    Status {
        t_us: 20_475_000,
        state,
        motion: Some(MotionId(77)),
        motion_end,
        fault: fault.map(report),
        supply_mv: 11_900,
        link: LinkStatistics {
            frames_received: 1000,
            frames_damaged: 20,
            frames_lost: 30,
            frames_sent: 4000,
            telemetry_dropped: 5,
            frames_refused: 6,
        },
        ticks: 20_475,
        tick_delay_us_max: 12,
        ticks_lost: 7,
    }
}

fn drive(unit: TravelUnit) -> Drive {
    Drive {
        motion: MotionId(77),
        unit,
        distance: WheelPair { left: 8.0, right: -8.0 },
        cruise: 0.523,
        acceleration: 0.101,
        start_us: None,
    }
}

pub fn telemetry() -> Telemetry {
    Telemetry {
        number: 517,
        t_us: 5_178_000,
        state: State::Driving,
        probing: false,
        wheels: WheelPair {
            left: WheelTelemetry {
                counts: 1219,
                setpoint_um: 306_400,
                error_um: -120,
                speed_um_s: 118_300,
                terms: PidTerms {
                    feedforward: 9000,
                    proportional: -157,
                    integral: 64,
                    derivative: -3,
                },
                duty: 8904,
                applied_uvs: 9_470_312,
            },
            right: WheelTelemetry {
                counts: -1200,
                setpoint_um: -301_600,
                error_um: 80,
                speed_um_s: -117_000,
                terms: PidTerms {
                    feedforward: -8900,
                    proportional: 105,
                    integral: -60,
                    derivative: 4,
                },
                duty: -8851,
                applied_uvs: -9_412_700,
            },
        },
        supply_mv: 11_900,
        pose: Pose { x_um: 306_000, y_um: -1250, heading_urad: 12_400 },
        deviation: PoseDeviation {
            x_um: 270,
            y_um: 410,
            heading_urad: 2230,
            x_y: -120,
            x_heading: 80,
            y_heading: 7093,
        },
    }
}

/// 16 bytes that count up from this one.
pub fn bytes(first: u8) -> Nonce {
    std::array::from_fn(|i| first + i as u8)
}

/// A hello as a host of some version sends it.
pub fn host_hello() -> Hello {
    Hello { protocol: 2, schema: 0x1122_3344_5566_7788, session: 0xA1B2 }
}

/// The key of the session that the frames `open` and `opened` begin.
pub fn session_key() -> Key {
    Key::new(bytes(0)).of_session(&host_hello().to_bytes(), &bytes(0x10), &bytes(0x20))
}

/// Every message by name; a later line of the same kind adds a variant of an inner enum.
pub fn all() -> Vec<(String, Any)> {
    let mut all = vec![(
        "hello".to_string(),
        // Not this build's hash, so that the hello's layout is pinned independently of the hash.
        Any::Hello(Hello { protocol: 1, schema: 0x1122_3344_5566_7788, session: 0xA1B2_C3D4 }),
    )];
    all.push(("hello.challenge".to_string(), Any::Challenge(host_hello(), bytes(0x20))));
    let session = host_hello().session;
    all.push(("open".to_string(), Any::Open(Open { session, nonce: bytes(0x10) })));
    let opened = Opened { session, boot: bytes(0x30), counter: 1000 };
    all.push(("opened".to_string(), Any::Opened(opened)));
    all.extend(requests());
    all.extend(replies());
    all.push(("telemetry".to_string(), Any::Telemetry(telemetry())));
    all.push((
        "telemetry.probing".to_string(),
        Any::Telemetry(Telemetry { probing: true, ..telemetry() }),
    ));
    all.extend(events());
    all
}

fn requests() -> Vec<(String, Any)> {
    let mut all = Vec::new();
    let mut request = |name: &str, command: Command| {
        let until_ms = if command.needs_lease() { 20_975 } else { 0 };
        let request = Request { session: 0xA1B2, id: 7, until_ms, command };
        all.push((format!("request.{name}"), Any::Request(request)));
    };
    request("identify", Command::Identify);
    request("status", Command::Status);
    request("read_config", Command::ReadConfig);
    request("write_config", Command::WriteConfig(config()));
    request("save_config", Command::SaveConfig);
    request("restore_config.factory", Command::RestoreConfig(ConfigOrigin::Factory));
    request("restore_config.saved", Command::RestoreConfig(ConfigOrigin::Saved));
    request("arm", Command::Arm { take: false });
    request("arm.take", Command::Arm { take: true });
    request("disarm", Command::Disarm);
    request("drive.meter", Command::Drive(drive(TravelUnit::Meter)));
    request("drive.wheel_revolution", Command::Drive(drive(TravelUnit::WheelRevolution)));
    let start_us = Some(20_475_000);
    request(
        "drive.later",
        Command::Drive(Drive { start_us, ..drive(TravelUnit::WheelRevolution) }),
    );
    let velocity = Velocity {
        motion: MotionId(77),
        forward_mps: 0.118,
        turn_rad_s: -0.25,
        acceleration_mps2: 0.5,
    };
    request("velocity", Command::Velocity(velocity));
    let voltage = Voltage {
        motion: MotionId(77),
        volts: WheelPair { left: 3.5, right: -3.5 },
        ramp_v_per_s: 2.0,
        duration_s: 1.5,
        travel_m_max: 0.25,
        speed_mps_max: 0.5,
    };
    request("voltage", Command::Voltage(voltage));
    request("renew", Command::Renew { motion: MotionId(77) });
    request("stop", Command::Stop);
    request("emergency_stop", Command::EmergencyStop);
    request("clear_fault", Command::ClearFault { number: 3 });
    request("subscribe", Command::Subscribe { period_ms: 20 });
    request("recall", Command::Recall { number: 517 });
    request("set_key", Command::SetKey { key: Some(Key::new(bytes(0x40))) });
    request("clear_key", Command::SetKey { key: None });
    all
}

fn replies() -> Vec<(String, Any)> {
    let mut all = Vec::new();
    let mut reply = |name: &str, outcome| {
        let reply = Reply { session: 0xA1B2, id: 7, t_us: 20_475_123, outcome };
        all.push((format!("reply.{name}"), Any::Reply(reply)));
    };
    reply("done", Ok(Answer::Done));
    for (name, cause, origin) in [
        ("power_on", ResetCause::PowerOn, ConfigOrigin::Saved),
        ("pin", ResetCause::Pin, ConfigOrigin::Factory),
        ("software", ResetCause::Software, ConfigOrigin::Saved),
        ("watchdog", ResetCause::Watchdog, ConfigOrigin::Saved),
        ("panic", ResetCause::Panic, ConfigOrigin::Saved),
        ("brown_out", ResetCause::BrownOut, ConfigOrigin::Saved),
    ] {
        reply(&format!("identity.{name}"), Ok(Answer::Identity(identity(cause, origin))));
    }
    for (name, state, end, fault) in [
        ("boot", State::Boot, None, None),
        ("idle", State::Idle, Some(MotionEnd::Completed), None),
        ("armed", State::Armed, Some(MotionEnd::Stopped), None),
        ("driving", State::Driving, None, None),
        ("stopping", State::Stopping, Some(MotionEnd::Replaced), None),
        ("faulted", State::Faulted, Some(MotionEnd::Faulted), Some(Fault::Driver)),
        ("travel_limit", State::Armed, Some(MotionEnd::TravelLimit), None),
        ("speed_limit", State::Armed, Some(MotionEnd::SpeedLimit), None),
    ] {
        reply(&format!("status.{name}"), Ok(Answer::Status(status(state, end, fault))));
    }
    let never_moved = Status { motion: None, ..status(State::Idle, None, None) };
    reply("status.never_moved", Ok(Answer::Status(never_moved)));
    reply("config", Ok(Answer::Config(config())));
    reply("telemetry", Ok(Answer::Telemetry(telemetry())));
    for (name, refusal) in refusals() {
        reply(&format!("refusal.{name}"), Err(refusal));
    }
    all
}

/// Every fault; those of a wheel are of the one and the other in turn.
pub fn faults(one: Wheel, other: Wheel) -> Vec<Fault> {
    vec![
        Fault::FollowingError(one),
        Fault::Stall(other),
        Fault::EncoderDead(one),
        Fault::EncoderReversed(other),
        Fault::CountRate(one),
        Fault::LinkLost,
        Fault::TimeToLive,
        Fault::SupplyLow,
        Fault::DeadlineMissed,
        Fault::Driver,
        Fault::EmergencyStop,
        Fault::Unsupervised,
        Fault::EncodersExchanged(other),
        Fault::SupplyHigh,
        Fault::NoResponse(one),
    ]
}

fn events() -> Vec<(String, Any)> {
    let mut all = Vec::new();
    let mut event = |name: &str, event| all.push((format!("event.{name}"), Any::Event(event)));
    event("state", Event::State { t_us: 5_178_000, state: State::Stopping });
    let (t_us, motion, end) = (20_475_000, MotionId(77), MotionEnd::Completed);
    event("motion_ended", Event::MotionEnded { t_us, motion, end });
    for fault in faults(Wheel::Left, Wheel::Right) {
        event(&format!("fault.{}", fault.id()), Event::Fault(report(fault)));
    }
    all
}
