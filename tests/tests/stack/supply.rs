//! Does a robot drive alike whatever its battery's voltage, and does it refuse one that is too high?

use beeline_tests::robot::{meters, on_robot};
use host_link::motion::Motion;
use shared_proto::{Command, Fault, Refusal, State, Telemetry, Wheel};
use sim_target::Scenario;
use sim_target::plant::PlantFault;

/// A line that never delays: telemetry of every control tick gets through.
fn on_supply(open_circuit_v: f64) -> Scenario {
    let mut scenario = Scenario::default();
    scenario.link.baud = 0;
    scenario.plant.supply.open_circuit_v = open_circuit_v;
    scenario
}

/// Root mean square and largest following error of a drive \[um\].
fn following_error_um(motion: &Motion, open_circuit_v: f64, nominal_v: f64) -> [f64; 2] {
    on_robot(&on_supply(open_circuit_v), async |robot| {
        let mut config = robot.session.read_config().await.expect("it answers");
        config.feedforward.supply_v = nominal_v;
        config.protection.supply_v_min = 8.0;
        robot.session.write_config(&config).await.expect("it is valid");
        robot.tell(Command::Subscribe { period_ms: 1 }).await;
        robot.tell(Command::Arm { take: false }).await;
        let id = robot.drive(motion).await.expect("accepted");
        robot.finish(id).await;
        assert_eq!(robot.session.status().await.expect("it answers").fault, None);
        let telemetry: Vec<Telemetry> = robot.session.take_telemetry().collect();
        let driving = telemetry.iter().filter(|t| t.state == State::Driving && !t.probing);
        // For its first second the drive takes back the three counts by which the encoder check left it ahead.
        let errors: Vec<f64> = driving
            .skip(1000)
            .flat_map(|t| Wheel::BOTH.map(|wheel| f64::from(t.wheels.get(wheel).error_um)))
            .collect();
        assert!(errors.len() > 5000, "{} errors", errors.len());
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        let largest = errors.iter().fold(0.0, |largest: f64, error| largest.max(error.abs()));
        [(squares / errors.len() as f64).sqrt(), largest]
    })
}

#[test]
fn from_9_to_14_volts_a_drive_follows_as_at_12() {
    // The paper's ramp and cruise, 0.101 and 0.523 turns of a wheel of 36 mm; and as fast as 9 V allow.
    for motion in [meters(1.0, 1.0, 0.1183, 0.0228), meters(1.0, 1.0, 0.28, 0.3)] {
        let at_12 = following_error_um(&motion, 12.0, 12.0);
        for supply_v in [9.0, 10.5, 12.6, 14.0] {
            let at = following_error_um(&motion, supply_v, 12.0);
            println!("{supply_v} V: {at:.1?} um, at 12 V {at_12:.1?} um");
            for (at, at_12) in at.into_iter().zip(at_12) {
                assert!((at / at_12 - 1.0).abs() < 0.1, "{supply_v} V: {at} um, {at_12} at 12 V");
            }
        }
        // Without a nominal supply the battery is seen: the test can fail.
        let unscaled = following_error_um(&motion, 9.0, 0.0);
        println!("9 V, not scaled: {unscaled:.1?} um");
        assert!(unscaled[0] > 1.2 * at_12[0], "{unscaled:?} against {at_12:?}");
    }
}

#[test]
fn a_supply_that_is_too_high_stops_the_motors_within_10_ms_and_refuses_to_arm() {
    on_robot(&on_supply(12.0), async |robot| {
        robot.cruise(&meters(2.0, 2.0, 0.3, 0.5), 1.5).await;
        let from_us = robot.snapshot().t_us;
        robot.testbed.inject(PlantFault::SupplyDip { volts: -8.0 });
        robot.listen(0.2).await;
        let report = robot.fault().await.expect("a fault");
        assert_eq!(report.fault, Fault::SupplyHigh);
        let off_us = robot.last_powered_us(from_us).expect("it drove") - from_us;
        assert!(off_us <= 10_000, "{off_us} us");
    });
    on_robot(&on_supply(19.0), async |robot| {
        let refused = robot.ask(Command::Arm { take: false }).await;
        let Err(Refusal::Faulted(report)) = refused else { panic!("{refused:?}") };
        assert_eq!(report.fault, Fault::SupplyHigh);
    });
}

#[test]
fn the_check_of_an_unplugged_encoder_ends_within_10_mm_at_any_supply() {
    for supply_v in [9.5, 12.0, 18.0] {
        on_robot(&on_supply(supply_v), async |robot| {
            robot.testbed.inject(PlantFault::EncoderUnplugged(Wheel::Left));
            robot.listen(0.05).await;
            let start = robot.snapshot();
            robot.cruise(&meters(0.1, 0.1, 0.1, 0.5), 1.5).await;
            robot.listen(1.0).await;
            let report = robot.fault().await.expect("a fault");
            assert_eq!(report.fault, Fault::NoResponse(Wheel::Left), "{supply_v} V");
            let snapshots = robot.snapshots_from(start.t_us);
            let moved_m = snapshots.iter().map(|at| at.moved_since_m(&start)).fold(0.0, f64::max);
            println!("{supply_v} V: {:.1} mm", moved_m * 1e3);
            assert!(moved_m <= 0.01, "{supply_v} V: {moved_m} m");
        });
    }
}
