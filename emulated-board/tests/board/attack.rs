//! A flooded link: every control tick comes when it is due all the same, and telemetry gives way first.

use emulated_board::{Bench, BoardMonitor};
use futures_lite::future;
use host_link::motion::{self, Motion, RecordOptions};
use shared_proto::{Command, Encoder, LinkStatistics, Request, Telemetry, WheelPair};
use sim_target::{HostWire, now_us, sleep_until_us};

use super::robot::Robot;
use super::{emulation, uneventful};

/// Two wheel revolutions at the paper's cruise.
const MOTION: Motion =
    Motion { distance: WheelPair::both(2.0), acceleration: 0.523, ..Motion::PAPER };

/// Bytes that are kept waiting for the line: it never falls silent, and what the host says besides is
/// hardly late: 150 bytes take 1.6 ms.
const WAITING: usize = 150;

/// A control tick may begin this late or early [ns]: what the core may be busy with at a higher priority,
/// or with interrupts masked, is less than 1,250 instructions of 8 ns.
const JITTER_NS_MAX: u64 = 10_000;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Flood {
    Nothing,
    Garbage,
    Requests,
}

/// Keeps the line to the robot full, for ever.
async fn flood(wire: HostWire, monitor: BoardMonitor, what: Flood) {
    let mut encoder = Encoder::new();
    let mut noise = 1_u64;
    loop {
        while what != Flood::Nothing && monitor.waiting() < WAITING {
            match what {
                Flood::Requests => {
                    for _ in 0..8 {
                        let request =
                            Request { session: 1, id: 1, until_ms: 0, command: Command::Status };
                        wire.write_now(&encoder.message(&request));
                    }
                }
                _ => {
                    // Every byte there is, and a zero at the end: else the host's next frame would be
                    // part of it.
                    let mut bytes = [0; 100];
                    for byte in &mut bytes[..99] {
                        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                        *byte = (noise >> 56) as u8;
                    }
                    wire.write_now(&bytes);
                }
            }
            // The monitor is updated at every step.
            sleep_until_us(now_us() + 60).await;
        }
        sleep_until_us(now_us() + 100).await;
    }
}

struct Phase {
    what: Flood,
    from_us: u64,
    to_us: u64,
    telemetry: Vec<Telemetry>,
    before: LinkStatistics,
    after: LinkStatistics,
    tick_delay_us_max: u32,
}

async fn drive(robot: &mut Robot, what: Flood) -> Phase {
    let before = robot.status().await.link;
    let from_us = now_us();
    let options = RecordOptions {
        period_ms: 2,
        rest: std::time::Duration::from_millis(50),
        ..RecordOptions::default()
    };
    let (wire, monitor) = (robot.0.wire.clone(), robot.0.monitor.clone());
    let mut silent = |_| ();
    let driven = motion::drive(&mut robot.0.session, &MOTION, options, &mut silent);
    let attacked = async {
        flood(wire, monitor, what).await;
        unreachable!("a flood does not end")
    };
    let recording = future::or(driven, attacked).await.unwrap_or_else(|e| panic!("{what:?}: {e}"));
    let to_us = now_us();
    // Let the line run empty.
    robot.listen(20).await;
    let status = robot.status().await;
    assert_eq!(status.fault, None, "{what:?}");
    let telemetry = recording.telemetry;
    let tick_delay_us_max = status.tick_delay_us_max;
    Phase { what, from_us, to_us, telemetry, before, after: status.link, tick_delay_us_max }
}

#[test]
fn a_flooded_link_delays_no_control_tick_and_telemetry_gives_way_first() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let mut phases = Vec::new();
            for what in [Flood::Nothing, Flood::Garbage, Flood::Requests] {
                phases.push(drive(&mut robot, what).await);
            }
            phases
        })
        .unwrap();
    uneventful(&ended);
    println!(
        "link flooded by  ticks  between two [us]     read to PWM  frames/s   damaged      good  \
         telemetry: sent  shed   rms error [um]"
    );
    for phase in &ended.found {
        let tick_times: Vec<_> = ended
            .tick_times
            .iter()
            .filter(|tick| (phase.from_us..phase.to_us).contains(&(tick.read_ns / 1000)))
            .collect();
        let between = tick_times.windows(2).map(|pair| pair[1].read_ns - pair[0].read_ns);
        let (shortest, longest) = (between.clone().min().unwrap(), between.max().unwrap());
        let latency = tick_times.iter().map(|tick| tick.written_ns - tick.read_ns).max().unwrap();
        let (before, after) = (&phase.before, &phase.after);
        let shed = after.telemetry_dropped - before.telemetry_dropped;
        let received = after.frames_received - before.frames_received;
        let damaged = after.frames_damaged - before.frames_damaged;
        let s = (phase.to_us - phase.from_us) as f64 * 1e-6;
        let squares = phase.telemetry.iter().map(|t| f64::from(t.wheels.left.error_um).powi(2));
        let rms_um = (squares.sum::<f64>() / phase.telemetry.len() as f64).sqrt();
        println!(
            "{:<15} {:>6}  {:>8.2} to {:>7.2} {:>9.2} us {:>9.0} {:>8} {:>9} {:>16} {:>5} {:>15.1}",
            format!("{:?}", phase.what).to_lowercase(),
            tick_times.len(),
            shortest as f64 * 1e-3,
            longest as f64 * 1e-3,
            latency as f64 * 1e-3,
            f64::from(received + damaged) / s,
            damaged,
            received,
            phase.telemetry.len(),
            shed,
            rms_um,
        );
        // One tick a millisecond, none left out.
        assert!(
            (tick_times.len() as f64 / s / 1000.0 - 1.0).abs() < 0.001,
            "{} in {s} s",
            tick_times.len()
        );
        let jitter_ns = (longest - 1_000_000).max(1_000_000 - shortest);
        assert!(jitter_ns <= JITTER_NS_MAX, "{:?}: {jitter_ns} ns", phase.what);
        assert!(phase.tick_delay_us_max <= 10, "{} us", phase.tick_delay_us_max);
        let last = phase.telemetry.last().expect("there is telemetry");
        // At rest where it was to go, to half a count of a coarse encoder.
        assert!(last.wheels.all(|wheel| wheel.error_um.abs() <= 251), "{:?}: {last:?}", phase.what);
        match phase.what {
            Flood::Nothing => assert_eq!((shed, damaged), (0, 0)),
            // The line from the robot is not what is flooded.
            Flood::Garbage => assert!(f64::from(damaged) > 800.0 * s, "{damaged} in {s} s"),
            // Every answer goes before telemetry.
            Flood::Requests => assert!(shed > 0 && f64::from(received) > 500.0 * s, "{received}"),
        }
    }
    let quiet = ended.found[0].telemetry.last().unwrap().wheels.map(|w| w.setpoint_um);
    println!("setpoints at the end of the first drive: {quiet:?} um");
}
