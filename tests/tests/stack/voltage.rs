//! Voltages without feedback: what is applied is what is told, and nothing goes beyond its limits.

use beeline_tests::robot::{Robot, Snapshot, meters, on_robot};
use host_link::motion::{VoltageRun, VoltageStep, apply_voltages};
use shared_proto::{
    Command, Fault, MotionEnd, MotionError, MotionId, Refusal, State, Telemetry, Voltage, Wheel,
    WheelPair,
};
use sim_target::plant::PlantFault;
use sim_target::{Scenario, now_us};

use crate::motion::fast_line;

/// Forwards at 3 V for 2 s, far within every limit.
const GENTLE: Voltage = Voltage {
    motion: MotionId(5),
    volts: WheelPair::both(3.0),
    ramp_v_per_s: 20.0,
    duration_s: 2.0,
    travel_m_max: 2.0,
    speed_mps_max: 0.8,
};

fn run(volts: &[(f64, f64)], duration_s: f64) -> VoltageRun {
    let step = |&(left, right)| VoltageStep { volts: WheelPair::new(left, right), duration_s };
    VoltageRun {
        steps: volts.iter().map(step).collect(),
        ramp_v_per_s: 100.0,
        travel_m_max: 2.0,
        speed_mps_max: 0.8,
        period_ms: 10,
    }
}

async fn apply(robot: &mut Robot, run: &VoltageRun) -> (MotionEnd, Vec<Telemetry>) {
    let mut telemetry = Vec::new();
    let end = apply_voltages(&mut robot.session, run, &mut telemetry).await.expect("no fault");
    assert_eq!(robot.state().await, State::Idle);
    (end, telemetry)
}

/// Mean voltage between two frames, and the left wheel's speed \[m/s\].
fn between(a: &Telemetry, b: &Telemetry) -> (WheelPair<f64>, f64) {
    let s = (b.t_us - a.t_us) as f64 * 1e-6;
    let volts = |wheel: Wheel| {
        (b.wheels.get(wheel).applied_uvs - a.wheels.get(wheel).applied_uvs) as f64 * 1e-6 / s
    };
    let counts = b.wheels.left.counts - a.wheels.left.counts;
    let rolled_m = counts as f64 / 900.0 * std::f64::consts::TAU * 0.036;
    (WheelPair::new(volts(Wheel::Left), volts(Wheel::Right)), rolled_m / s)
}

#[test]
fn what_is_applied_is_what_was_commanded_on_any_supply_and_telemetry_sums_it_up() {
    for open_circuit_v in [9.8, 12.0, 15.0] {
        let mut scenario = Scenario::default();
        scenario.plant.supply.open_circuit_v = open_circuit_v;
        on_robot(&scenario, async |robot| {
            let (end, telemetry) = apply(robot, &run(&[(3.0, 3.2)], 2.0)).await;
            assert_eq!(end, MotionEnd::Completed);
            let driving: Vec<&Telemetry> =
                telemetry.iter().filter(|t| t.state == State::Driving && !t.probing).collect();
            // The last second of the plateau.
            let (a, b) = (driving[80], driving[180]);
            let (volts, speed_mps) = between(a, b);
            // The measured supply has noise of 20 mV, a sixth of a per cent.
            assert!((volts.left - 3.0).abs() < 0.006, "{open_circuit_v} V: {volts:?}");
            assert!((volts.right - 3.2).abs() < 0.006, "{open_circuit_v} V: {volts:?}");
            // By the factory's feedforward, which is that of the standard robot, to its tenth.
            let expected_mps = (3.0 - 0.48) / 24.0;
            assert!((speed_mps / expected_mps - 1.0).abs() < 0.1, "{speed_mps} {expected_mps}");
            let rest = telemetry.last().expect("frames");
            assert_eq!((rest.wheels.left.duty, rest.wheels.right.duty), (0, 0));
        });
    }
}

/// On a ramp the sum tells until when it goes: a tick later, and the voltage is a tick's change higher.
#[test]
fn the_voltage_of_a_frame_is_summed_up_to_the_instant_of_its_counts() {
    let mut scenario = Scenario::default();
    scenario.plant.supply.noise_sigma_v = 0.0;
    scenario.plant.supply.resistance_ohm = 0.0;
    on_robot(&scenario, async |robot| {
        let ramp = VoltageRun { ramp_v_per_s: 4.0, period_ms: 10, ..run(&[(3.0, 3.0)], 0.8) };
        let (_, telemetry) = apply(robot, &ramp).await;
        let rises = telemetry.windows(2).filter(|pair| {
            let drives = |frame: &Telemetry| frame.state == State::Driving && !frame.probing;
            pair.iter().all(drives) && pair[1].wheels.left.duty > pair[0].wheels.left.duty
        });
        // The duty of a frame is on the motor from the frame on: 10 ticks at it and at the nine above, 4.5 changes on average.
        let changes = rises.map(|pair| {
            let duty_v = f64::from(pair[0].wheels.left.duty) / 32767.0 * 12.0;
            (between(&pair[0], &pair[1]).0.left - duty_v) / (4.0 * 1e-3)
        });
        let changes: Vec<f64> = changes.collect();
        let mean = changes.iter().sum::<f64>() / changes.len() as f64;
        assert!(changes.len() > 50 && (mean - 4.5).abs() < 0.3, "{mean} of {}", changes.len());
    });
}

#[test]
fn a_limit_of_travel_or_speed_ends_it_at_once_and_is_named() {
    on_robot(&Scenario::default(), async |robot| {
        let start = robot.snapshot();
        let short = VoltageRun { travel_m_max: 0.1, ..run(&[(6.0, 6.0)], 5.0) };
        let (end, _) = apply(robot, &short).await;
        assert_eq!(end, MotionEnd::TravelLimit);
        let went_m = robot.snapshot().moved_since_m(&start);
        // A shorted motor brakes within its time constant of 32 ms; the encoder check rolls a millimetre or two first.
        assert!((0.1..0.12).contains(&went_m), "{went_m}");
        let slow = VoltageRun { speed_mps_max: 0.15, ..run(&[(-8.0, -8.0)], 5.0) };
        let (end, telemetry) = apply(robot, &slow).await;
        assert_eq!(end, MotionEnd::SpeedLimit);
        let fastest = telemetry.iter().map(|t| -t.wheels.left.speed_um_s).max();
        assert!(fastest.is_some_and(|um_s| (130_000..190_000).contains(&um_s)), "{fastest:?}");
    });
}

#[test]
fn one_voltage_takes_the_place_of_another_without_a_stop_and_nothing_else_does() {
    on_robot(&fast_line(), async |robot| {
        let (end, telemetry) = apply(robot, &run(&[(4.0, 4.0), (-4.0, -4.0)], 1.0)).await;
        assert_eq!(end, MotionEnd::Completed);
        // Between full speed forwards and backwards no frame but a few shows the wheel at rest.
        let speeds: Vec<i32> = telemetry.iter().map(|t| t.wheels.left.speed_um_s).collect();
        let forward = speeds.iter().rposition(|&v| v > 100_000).expect("forwards");
        let backward = speeds.iter().position(|&v| v < -100_000).expect("backwards");
        assert!((1..25).contains(&(backward - forward)), "{forward} {backward}");

        robot.tell(Command::Arm { take: false }).await;
        robot.tell(Command::Voltage(GENTLE)).await;
        robot.renew(GENTLE.motion, 1.2).await;
        let refused = robot.drive(&meters(0.1, 0.1, 0.1, 0.2)).await;
        assert_eq!(refused, Err(Refusal::State(State::Driving)));
        robot.finish(GENTLE.motion).await;
        // A voltage begins from a standstill only, and its number is used up.
        let drive = robot.drive(&meters(0.3, 0.3, 0.1, 0.2)).await.expect("it drives");
        let another = Voltage { motion: MotionId(1000), ..GENTLE };
        let refused = robot.ask(Command::Voltage(another)).await;
        assert_eq!(refused, Err(Refusal::State(State::Driving)));
        robot.finish(drive).await;
        let before = robot.snapshot();
        robot.tell(Command::Voltage(GENTLE)).await;
        robot.listen(0.5).await;
        assert!(robot.snapshot().moved_since_m(&before) < 1e-3);
    });
}

#[test]
fn voltages_that_no_robot_should_apply_are_refused() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        for (wrong, error) in [
            (Voltage { volts: WheelPair::both(61.0), ..GENTLE }, MotionError::TooHigh),
            (Voltage { volts: WheelPair::new(1.0, f64::NAN), ..GENTLE }, MotionError::NotPositive),
            (Voltage { ramp_v_per_s: 0.0, ..GENTLE }, MotionError::NotPositive),
            (Voltage { ramp_v_per_s: 0.001, ..GENTLE }, MotionError::TooLong),
            (Voltage { duration_s: 61.0, ..GENTLE }, MotionError::TooLong),
            (Voltage { travel_m_max: 21.0, ..GENTLE }, MotionError::TooFar),
            (Voltage { speed_mps_max: 0.81, ..GENTLE }, MotionError::TooFast),
            (Voltage { speed_mps_max: f64::INFINITY, ..GENTLE }, MotionError::NotPositive),
        ] {
            let answer = robot.ask(Command::Voltage(wrong)).await;
            assert_eq!(answer, Err(Refusal::Motion(error)), "{wrong:?}");
        }
        assert_eq!(robot.state().await, State::Armed);
    });
}

/// When the motors had no current any more \[us\].
fn without_current_us(snapshots: &[Snapshot]) -> u64 {
    snapshots.iter().rev().find(|s| s.current_a.any(|a| a > 0.0)).map_or(0, |s| s.t_us)
}

#[test]
fn a_dead_host_a_stop_and_the_emergency_stop_end_a_voltage_in_time() {
    on_robot(&Scenario::default(), async |robot| {
        for (number, ending, fault) in [
            (20, None, Some(Fault::LinkLost)),
            (21, Some(Command::Stop), None),
            (22, Some(Command::EmergencyStop), Some(Fault::EmergencyStop)),
        ] {
            robot.tell(Command::Arm { take: false }).await;
            let voltage = Voltage { motion: MotionId(number), duration_s: 20.0, ..GENTLE };
            robot.tell(Command::Voltage(voltage)).await;
            robot.renew(voltage.motion, 2.0).await;
            let event_us = now_us();
            if let Some(ending) = ending {
                robot.tell(ending).await;
            }
            robot.listen(1.5).await;
            // A braking motor's current is negative.
            let ended_us = without_current_us(&robot.snapshots_from(event_us)) - event_us;
            assert!(ended_us < 250_000, "{fault:?}: {ended_us} us");
            let report = robot.fault().await;
            assert_eq!(report.map(|report| report.fault), fault);
            if let Some(report) = report {
                robot.tell(Command::ClearFault { number: report.number }).await;
            }
        }
    });
}

#[test]
fn the_encoder_check_comes_first() {
    on_robot(&Scenario::default(), async |robot| {
        robot.testbed.inject(PlantFault::EncoderReversed(Wheel::Right));
        let start = robot.snapshot();
        let error =
            apply_voltages(&mut robot.session, &run(&[(3.0, 3.0)], 1.0), &mut Vec::new()).await;
        let text = error.expect_err("it must be found").to_string();
        assert!(text.contains("encoder_reversed (right wheel)"), "{text}");
        assert!(robot.snapshot().moved_since_m(&start) < 0.01);
    });
}
