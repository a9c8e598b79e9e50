//! How fast the simulator is: `cargo xtask bench sim`.
//!
//! The paper's run of eight revolutions with everything that belongs to it: firmware tasks, plant, camera,
//! line, host session, telemetry at 100 Hz. Then the plant alone with the same look-ups, and all of it
//! with a plant that does not move, so that the shares come from the same minute on the same core.

use std::process::ExitCode;
use std::time::Instant;

use beeline_tests::robot::on_unwatched_robot;
use host_link::motion::{self, Motion, RecordOptions};
use shared_proto::WheelPair;
use sim_target::plant::Plant;
use sim_target::{Options, Scenario, SimTarget, now_us};

/// Times real time, on one core.
const SPEED_MIN: f64 = 500.0;
/// The fastest of this many: the machine undisturbed.
const REPEATS: usize = 7;

fn main() -> ExitCode {
    let mut simulated_s = 0.0;
    let whole_s = best(|| simulated_s = experiment());
    let plant_s = best(|| plant_alone(simulated_s));
    let resting_s = best(|| firmware_at_rest(simulated_s));
    let times = simulated_s / whole_s;
    println!("the paper's run: {simulated_s:.2} s simulated in {:.1} ms", whole_s * 1e3);
    println!("{times:.0} times real time on one core");
    println!("share of the plant alone:                 {:>5.1} %", 100.0 * plant_s / whole_s);
    println!(
        "share of firmware tasks, clock, line, host: {:>3.1} %",
        100.0 * (1.0 - plant_s / whole_s)
    );
    println!(
        "an idle robot takes                       {:>5.1} % as long",
        100.0 * resting_s / whole_s
    );
    let holds = times >= SPEED_MIN;
    println!("{}: {SPEED_MIN} times real time or better", if holds { "holds" } else { "MISSED" });
    if holds { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn best(mut run: impl FnMut()) -> f64 {
    let mut time_s = || {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..REPEATS).map(|_| time_s()).fold(f64::INFINITY, f64::min)
}

/// Everything; returns the simulated time [s].
fn experiment() -> f64 {
    on_unwatched_robot(&Scenario::default(), async |session| {
        let options = RecordOptions { period_ms: 10, ..RecordOptions::default() };
        let run = motion::drive(session, &Motion::PAPER, options, &mut |_| ()).await;
        assert!(run.is_ok_and(|run| run.telemetry.len() > 2000), "a healthy robot");
        now_us() as f64 * 1e-6
    })
}

/// The plant at the paper's cruise, read every millisecond as the firmware does.
fn plant_alone(simulated_s: f64) {
    let scenario = Scenario::default();
    let setup = scenario.set_up();
    let mut plant: Plant = setup.plant;
    plant.set_enabled(true);
    // The duty of the feedforward at 0.118 m/s.
    plant.set_duty(WheelPair::both(0.28));
    let mut sum = 0;
    for tick in 1..=(simulated_s * 1000.0) as u64 {
        plant.advance_to(tick * 1000);
        sum += plant.counts().left + i64::from(plant.supply_v() > 0.0);
        plant.set_duty(WheelPair::both(0.28));
    }
    assert!(sum > 0);
}

/// The firmware with nothing to do, and a plant that stands.
fn firmware_at_rest(simulated_s: f64) {
    let mut target = SimTarget::new(&Scenario::default(), Options::default()).expect("no file");
    target.run_until_us((simulated_s * 1e6) as u64);
}
