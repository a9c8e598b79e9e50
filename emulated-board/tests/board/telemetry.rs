//! What 500 telemetry frames a second take of the line, beside the same content in other clothes.

use shared_proto::Encoder;

use super::paper::driven;
use super::uneventful;

/// Bytes a second at 921600 baud: eight bits, start and stop.
const LINE: f64 = 92_160.0;

/// Frames a second.
const RATE: f64 = 500.0;

/// The nearest standard messages of MAVLink 2 and their payloads \[bytes\], after its message
/// definitions: without extension fields, and with the zeros at the end left out as the protocol does.
///
/// | content | message | payload |
/// | --- | --- | --- |
/// | both wheels' counts | WHEEL_DISTANCE: time u64, distance f64 x 16, count u8 | 137 |
/// | setpoint, value, PID terms | PID_TUNING, one a wheel: six f32, axis u8 | 25 each |
/// | duty | SERVO_OUTPUT_RAW: time u32, u16 x 8, port u8 | 21 |
/// | supply | SYS_STATUS | 31 |
/// | state, flags | HEARTBEAT | 9 |
const MAVLINK: [usize; 6] = [137, 25, 25, 21, 31, 9];

/// Header of 10 bytes and checksum of 2.
const MAVLINK_OVERHEAD: usize = 12;

#[test]
fn five_hundred_frames_a_second_are_a_fraction_of_the_line_and_none_is_lost() {
    let ended = driven();
    uneventful(ended);
    let (telemetry, statistics) = &ended.found;
    assert_eq!((statistics.frames_lost, statistics.frames_damaged), (0, 0));
    // Every control tick's frame, each 2 ms after the one before.
    // A tick's time is taken when it begins, up to 10 us late.
    let steps = telemetry.windows(2).map(|pair| pair[1].t_us - pair[0].t_us);
    let gaps: Vec<u64> = steps.filter(|step_us| step_us.abs_diff(2000) > 20).collect();
    assert!(gaps.is_empty(), "{gaps:?}");
    assert!(telemetry.len() > 9_500, "{} frames", telemetry.len());

    let mut encoder = Encoder::new();
    let ours: Vec<usize> = telemetry.iter().map(|frame| encoder.message(frame).len()).collect();
    let json: usize =
        telemetry.iter().map(|frame| serde_json::to_string(frame).unwrap().len() + 1).sum();
    let mean = |sum: usize| sum as f64 / telemetry.len() as f64;
    let mavlink: usize = MAVLINK.iter().map(|payload| payload + MAVLINK_OVERHEAD).sum();
    println!("{} frames, none lost         bytes a frame   of the line at 500/s", telemetry.len());
    for (name, bytes) in [
        ("Beeline, mean", mean(ours.iter().sum())),
        ("Beeline, largest", *ours.iter().max().unwrap() as f64),
        ("JSON lines, mean", mean(json)),
        ("MAVLink 2, six messages", mavlink as f64),
    ] {
        println!("{name:<32} {bytes:>9.1} {:>17.1} %", bytes * RATE / LINE * 100.0);
    }
    let share = mean(ours.iter().sum()) * RATE / LINE;
    // A frame of this content has 72 bytes of values that change; more than 82 would be waste.
    assert!((0.25..0.45).contains(&share), "{share}");
}
