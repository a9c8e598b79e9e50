//! Wires swapped in every way: each combination is named rightly before the robot has moved 10 mm, or
//! nothing runs away.
//!
//! Six swaps, so 64 combinations: encoder plugs exchanged, motor connectors exchanged, and for each wheel
//! the encoder's A and B, and the motor's leads.

use std::collections::HashSet;

use beeline_tests::robot::{Snapshot, meters, on_robot};
use host_link::motion::Motion;
use shared_proto::{Command, Config, Fault, MotionEnd, State, Wheel, WheelPair};
use sim_target::plant::{MotorParameters, PlantFault};
use sim_target::{Scenario, now_us};

/// Farthest that any part of the drive may move before the name \[m\].
const MOVED_M_MAX: f64 = 0.010;

/// A wheel that follows its own count rolls this close to the 5 cm of the motion: the scenario's wheels are
/// not quite those of the configuration \[m\].
const ROLLED_M_MAX: f64 = 0.002;

/// What is swapped.
#[derive(Clone, Copy, Debug)]
struct Wiring {
    encoder_plugs: bool,
    motor_connectors: bool,
    a_b: WheelPair<bool>,
    leads: WheelPair<bool>,
}

/// What a push of one side's motor does.
struct Effect {
    /// The counter that moves.
    counter: Wheel,
    /// It moves against the push.
    reversed: bool,
    /// The wheel that turns.
    wheel: Wheel,
    /// It turns backwards.
    backwards: bool,
}

impl Wiring {
    fn of(bits: u32) -> Self {
        let bit = |n: u32| bits >> n & 1 == 1;
        Self {
            encoder_plugs: bit(0),
            motor_connectors: bit(1),
            a_b: WheelPair::new(bit(2), bit(3)),
            leads: WheelPair::new(bit(4), bit(5)),
        }
    }

    fn faults(&self) -> Vec<PlantFault> {
        let mut faults = Vec::new();
        let mut add = |on: bool, fault| faults.extend(on.then_some(fault));
        add(self.encoder_plugs, PlantFault::EncodersExchanged);
        add(self.motor_connectors, PlantFault::MotorsExchanged);
        for wheel in Wheel::BOTH {
            add(*self.a_b.get(wheel), PlantFault::EncoderReversed(wheel));
            add(*self.leads.get(wheel), PlantFault::MotorReversed(wheel));
        }
        faults
    }

    fn push(&self, side: Wheel) -> Effect {
        let wheel = if self.motor_connectors { side.other() } else { side };
        let backwards = *self.leads.get(wheel);
        let counter = if self.encoder_plugs { wheel.other() } else { wheel };
        Effect { counter, reversed: backwards != *self.a_b.get(wheel), wheel, backwards }
    }

    /// The fault that the check must name, worked out from the wiring alone.
    fn name(&self) -> Option<Fault> {
        Wheel::BOTH.into_iter().find_map(|side| {
            let effect = self.push(side);
            if effect.counter != side {
                Some(Fault::EncodersExchanged(side))
            } else {
                effect.reversed.then_some(Fault::EncoderReversed(side))
            }
        })
    }

    /// How far each wheel's rim rolls where nothing can be named.
    fn rolls(&self, distance_m: WheelPair<f64>) -> WheelPair<f64> {
        let mut rolls = WheelPair::both(0.0);
        for side in Wheel::BOTH {
            let Effect { wheel, backwards, .. } = self.push(side);
            let way_m = *distance_m.get(side);
            *rolls.get_mut(wheel) = if backwards { -way_m } else { way_m };
        }
        rolls
    }

    fn words(&self) -> String {
        let mut words = Vec::new();
        let mut add = |on: bool, word: &'static str| words.extend(on.then_some(word));
        add(self.encoder_plugs, "encoder plugs");
        add(self.motor_connectors, "motors");
        add(self.a_b.left, "A/B left");
        add(self.a_b.right, "A/B right");
        add(self.leads.left, "leads left");
        add(self.leads.right, "leads right");
        if words.is_empty() { "nothing".into() } else { words.join(", ") }
    }
}

/// Starts a motion with these wires; returns the fault, and how far anything moved until the motors were
/// off for good \[m\].
fn drive(wiring: Wiring, motion: &Motion) -> (Option<Fault>, f64) {
    on_robot(&Scenario::default(), async |robot| {
        for fault in wiring.faults() {
            robot.testbed.inject(fault);
        }
        robot.listen(0.05).await;
        let (start, start_us) = (robot.snapshot(), now_us());
        let id = robot.cruise(motion, 1.5).await;
        robot.finish(id).await;
        let status = robot.session.status().await.unwrap();
        let fault = status.fault.map(|report| report.fault);
        let snapshots = robot.snapshots_from(start_us);
        let moved = |snapshot: &Snapshot| snapshot.moved_since_m(&start);
        if fault.is_none() {
            assert_eq!(status.motion_end, Some(MotionEnd::Completed), "{}", wiring.words());
            let end = snapshots.last().unwrap();
            let rolled_m = end.rolled_m.zip(start.rolled_m).map(|(end, start)| end - start);
            let off_m = rolled_m.zip(wiring.rolls(motion.distance)).map(|(is, should)| is - should);
            assert!(
                off_m.all(|off_m| off_m.abs() < ROLLED_M_MAX),
                "{}: rolled {rolled_m:?} m",
                wiring.words()
            );
        } else {
            assert_eq!(status.state, State::Faulted);
            robot.listen(1.0).await;
        }
        let all = robot.snapshots_from(start_us);
        (fault, all.iter().map(moved).fold(0.0, f64::max))
    })
}

#[test]
fn all_64_combinations_of_swapped_wires_are_named_before_10_mm_or_run_away_with_nothing() {
    let ways = [("ahead", meters(0.05, 0.05, 0.1, 0.5)), ("spin", meters(-0.05, 0.05, 0.1, 0.5))];
    println!("swapped | named | moved before, ahead | spin");
    let (mut named, mut farthest_m, mut names) = (0, 0.0_f64, HashSet::new());
    for bits in 0..64 {
        let wiring = Wiring::of(bits);
        let found = ways.each_ref().map(|(_, motion)| drive(wiring, motion));
        let word = match wiring.name() {
            Some(fault) => fault.to_string(),
            None if bits == 0 => "nothing is wrong".into(),
            None => "nothing: each wheel follows its own count, in mirror image".into(),
        };
        let mm = found.map(|(_, moved_m)| format!("{:.1} mm", moved_m * 1e3));
        println!("{} | {word} | {}", wiring.words(), mm.join(" | "));
        for ((way, _), (fault, moved_m)) in ways.iter().zip(found) {
            assert_eq!(fault, wiring.name(), "{}, {way}", wiring.words());
            if fault.is_some() {
                assert!(moved_m <= MOVED_M_MAX, "{}, {way}: {moved_m} m", wiring.words());
                farthest_m = farthest_m.max(moved_m);
            }
            names.extend(fault.map(|fault| fault.to_string()));
        }
        named += u32::from(wiring.name().is_some());
    }
    println!("{named} of 64 named, farthest {:.2} mm", farthest_m * 1e3);
    assert_eq!((named, names.len()), (56, 3), "{names:?}");
}

/// Motors that hobby robots have, at 12 V; the firmware's configuration stays as it was delivered.
fn motors() -> Vec<(&'static str, MotorParameters)> {
    let standard = MotorParameters::default();
    let stall_nm = 12.0 / standard.resistance_ohm * standard.wheel_torque_constant_nm_per_a();
    vec![
        (
            "dry friction of 13 % of stall",
            MotorParameters { coulomb_torque_nm: 0.13 * stall_nm, ..standard },
        ),
        (
            "a worn gear of 100:1",
            MotorParameters { gear_ratio: 100.0, coulomb_torque_nm: 0.5, ..standard },
        ),
        ("a fast gear of 15:1", MotorParameters { gear_ratio: 15.0, ..standard }),
        ("a weak winding of 20 ohm", MotorParameters { resistance_ohm: 20.0, ..standard }),
        ("a heavy rotor", MotorParameters { rotor_inertia_kgm2: 8e-6, ..standard }),
    ]
}

fn with_motor(motor: &MotorParameters) -> Scenario {
    let mut scenario = Scenario::default();
    scenario.plant.motor = WheelPair::both(*motor);
    scenario
}

#[test]
fn a_robot_whose_motors_are_not_those_of_the_configuration_passes_the_check() {
    for (name, motor) in motors() {
        for motion in [meters(0.1, 0.1, 0.05, 0.2), meters(-0.1, 0.1, 0.05, 0.2)] {
            on_robot(&with_motor(&motor), async |robot| {
                robot.tell(Command::Subscribe { period_ms: 1 }).await;
                let id = robot.cruise(&motion, 1.0).await;
                let probing =
                    robot.session.take_telemetry().filter(|t| t.probing).collect::<Vec<_>>();
                let ms = probing.last().map_or(0, |last| last.t_us - probing[0].t_us) / 1000;
                let duty = probing.iter().map(|t| t.wheels.left.duty.abs()).max().unwrap_or(0);
                println!("{name}: check of {ms} ms, largest duty {:.3}", f64::from(duty) / 32767.0);
                robot.finish(id).await;
                assert_eq!(robot.fault().await, None, "{name}");
            });
        }
    }
}

#[test]
fn with_those_motors_too_a_dead_encoder_is_named_before_10_mm() {
    for (name, motor) in motors() {
        for wheel in Wheel::BOTH {
            on_robot(&with_motor(&motor), async |robot| {
                robot.testbed.inject(PlantFault::EncoderUnplugged(wheel));
                let (start, start_us) = (robot.snapshot(), now_us());
                robot.cruise(&meters(0.5, 0.5, 0.1, 0.5), 3.0).await;
                let fault = robot.fault().await.map(|report| report.fault);
                assert_eq!(fault, Some(Fault::NoResponse(wheel)), "{name}");
                let moved = |snapshot: &Snapshot| snapshot.moved_since_m(&start);
                let moved_m = robot.snapshots_from(start_us).iter().map(moved).fold(0.0, f64::max);
                println!("{name}, {} encoder dead: moved {:.2} mm", wheel.name(), moved_m * 1e3);
                assert!(moved_m <= MOVED_M_MAX, "{name}: {moved_m} m");
                let config = Config::default();
                assert!(config.protection.probe_duty_max >= 0.25);
            });
        }
    }
}

/// Between two motions no encoder check is made: the wheels have shown that they answer.
#[test]
fn lines_exchanged_between_two_motions_are_named_within_10_mm() {
    let mut scenario = Scenario::default();
    let mut farthest_m: f64 = 0.0;
    for (supply_v, payload_kg) in [(12.0, 0.0), (9.5, 4.0), (18.0, 0.0), (18.0, 4.0)] {
        scenario.plant.supply.open_circuit_v = supply_v;
        scenario.plant.body.payload_kg = payload_kg;
        for exchanged in [PlantFault::EncoderReversed, PlantFault::MotorReversed] {
            for wheel in Wheel::BOTH {
                for motion in NEXT_MOTIONS {
                    let moved_m =
                        moves_after_exchange_m(&scenario, exchanged(wheel), wheel, &motion);
                    farthest_m = farthest_m.max(moved_m);
                }
            }
        }
    }
    println!("farthest: {:.1} mm", farthest_m * 1e3);
}

/// Slow and fast, gently and hard, ahead, back, on the spot.
const NEXT_MOTIONS: [Motion; 6] = [
    meters(1.0, 1.0, 0.05, 0.1),
    meters(-1.0, -1.0, 0.05, 0.1),
    meters(-1.0, -1.0, 0.12, 0.023),
    meters(-1.0, 1.0, 0.12, 0.5),
    meters(1.0, 1.0, 0.3, 0.5),
    meters(-1.0, -1.0, 0.3, 0.2),
];

fn moves_after_exchange_m(
    scenario: &Scenario,
    exchanged: PlantFault,
    wheel: Wheel,
    motion: &Motion,
) -> f64 {
    on_robot(scenario, async |robot| {
        let id = robot.cruise(&meters(0.05, 0.05, 0.2, 0.5), 0.1).await;
        robot.finish(id).await;
        robot.testbed.inject(exchanged);
        robot.listen(0.1).await;
        let (start, start_us) = (robot.snapshot(), now_us());
        robot.cruise(motion, 2.0).await;
        let case = format!("{exchanged:?}, {:?}, {motion:?}", scenario.plant.supply);
        let report = robot.fault().await.unwrap_or_else(|| panic!("{case}: no fault"));
        assert_eq!(report.fault, Fault::EncoderReversed(wheel), "{case}");
        // The other wheel follows its setpoint, which may have come some way.
        let rolled_m =
            |snapshot: &Snapshot| (snapshot.rolled_m.get(wheel) - start.rolled_m.get(wheel)).abs();
        let snapshots = robot.snapshots_from(start_us);
        let moved_m = snapshots.iter().map(rolled_m).fold(0.0, f64::max);
        assert!(moved_m < MOVED_M_MAX, "{case}: {moved_m}");
        moved_m
    })
}
