//! The bounds on the length of messages are bounds, are reached, and are in the documentation.

use shared_proto::*;

use crate::decoding::parts;
use crate::samples::{self, Any};

/// The longest message of each kind: every number at its longest, every name full.
///
/// A varint is longest at the largest value, a signed one at the smallest.
fn longest() -> Vec<Any> {
    let name = Name::new(&"x".repeat(NAME_LEN_MAX)).unwrap();
    let wheel = WheelTelemetry {
        counts: i64::MIN,
        setpoint_um: i64::MIN,
        error_um: i32::MIN,
        speed_um_s: i32::MIN,
        terms: PidTerms {
            feedforward: i16::MIN,
            proportional: i16::MIN,
            integral: i16::MIN,
            derivative: i16::MIN,
        },
        duty: i16::MIN,
        applied_uvs: i64::MIN,
    };
    let config = Config { name, ..samples::config() };
    let fault = FaultReport {
        fault: Fault::Stall(Wheel::Left),
        number: u32::MAX,
        t_us: u64::MAX,
        followed_by: u16::MAX,
        wheels: WheelPair::both(WheelAtFault {
            error_um: i32::MIN,
            speed_um_s: i32::MIN,
            duty: i16::MIN,
        }),
        supply_mv: u16::MAX,
    };
    let (session, id) = (u32::MAX, u32::MAX);
    vec![
        Any::Challenge(
            Hello { protocol: u16::MAX, schema: u64::MAX, session: u32::MAX },
            [0xFF; 16],
        ),
        Any::Request(Request {
            session,
            id,
            until_ms: u64::MAX,
            command: Command::WriteConfig(config.clone()),
        }),
        Any::Reply(Reply { session, id, t_us: u64::MAX, outcome: Ok(Answer::Config(config)) }),
        Any::Telemetry(Telemetry {
            number: u32::MAX,
            t_us: u64::MAX,
            wheels: WheelPair::both(wheel),
            supply_mv: u16::MAX,
            pose: Pose { x_um: i64::MIN, y_um: i64::MIN, heading_urad: i64::MIN },
            deviation: PoseDeviation {
                x_um: u32::MAX,
                y_um: u32::MAX,
                heading_urad: u32::MAX,
                x_y: i16::MIN,
                x_heading: i16::MIN,
                y_heading: i16::MIN,
            },
            ..samples::telemetry()
        }),
        Any::Event(Event::Fault(fault)),
        Any::Open(Open { session, nonce: [0xFF; 16] }),
        Any::Opened(Opened { session, boot: [0xFF; 16], counter: u64::MAX }),
    ]
}

#[test]
fn each_bound_is_reached_by_the_longest_message_of_its_kind() {
    for (message, bound) in longest().into_iter().zip(LengthBound::ALL) {
        let frame = message.frame(&mut Encoder::new());
        let (channel, payload) = parts(&frame);
        let sealed = matches!(channel, Channel::Open | Channel::Opened);
        let len = payload.len() + if sealed { Seal::LEN } else { 0 };
        assert_eq!((channel, len), (bound.channel, bound.payload_len));
        // COBS takes one byte more for every 254 without a zero; these messages have zeros.
        let slack = bound.frame_len - frame.len();
        assert!(slack <= 1, "{:?}: {} of {} bytes", bound.channel, frame.len(), bound.frame_len);
    }
}

#[test]
fn the_table_of_bounds_in_the_documentation_is_that_of_this_build() {
    let table: Vec<String> = LengthBound::ALL
        .iter()
        .map(|LengthBound { channel, payload_len, frame_len }| {
            format!("//! | {} `{channel:?}` | {payload_len} | {frame_len} |", *channel as u8)
        })
        .collect();
    let table = table.join("\n");
    println!("{table}");
    let source = include_str!("../../src/lib.rs");
    assert!(source.contains(&table), "src/lib.rs should say:\n{table}");
}
