//! Motor constants beside those of other methods, from the same recordings: SysId's form of regression, and output error by
//! SciPy. `cargo xtask bench identification [SEED [ROBOTS]]`; seed 1 and 40 robots by default, those of `bench tune`. Needs a Python
//! with NumPy and SciPy: `PYTHON` names it, `python3` by default.
//!
//! All three fit the straight experiments that `tune` drives, and are held to the straight ones that it drives for a campaign
//! besides: travel of the left wheel by its voltage alone, where each run begins being free.

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, ExitCode};

use beeline_tests::parallel::in_order;
use beeline_tests::robot::on_robot_with;
use beeline_tests::tuning::outcome::FLOOR_M;
use beeline_tests::tuning::robots::draw;
use host_cli::tune::drive_experiments;
use robot_model::drivetrain::{self, Drivetrain, VoltageRecording, WheelMotor};
use robot_model::kinematics::WheelPair;
use sim_target::Options;

/// With more counts a turn than this an encoder is fine, in the table.
const FINE: f64 = 500.0;

/// One robot's straight experiments.
struct Driven {
    number: u64,
    counts_per_rev: f64,
    truth: [f64; 3],
    fitted: Vec<VoltageRecording>,
    held_out: Vec<VoltageRecording>,
}

/// kS, kV, kA of the left wheel by one method, and the model for travel.
struct Found {
    constants: [f64; 3],
    model: Drivetrain,
}

/// What a method is off by: kS, kV, kA as shares of the truth, and travel of runs that it has not seen \[m\].
type Errors = [f64; 4];

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u64>());
    let (Ok(seed), Ok(robots)) =
        (numbers.next().unwrap_or(Ok(1)), numbers.next().unwrap_or(Ok(40)))
    else {
        eprintln!("usage: bench_identification [SEED [ROBOTS]]");
        return ExitCode::from(2);
    };
    let numbers: Vec<u64> = (0..robots).map(|number| seed * 100_000 + number).collect();
    let driven: Vec<Driven> =
        in_order(&numbers, |number| drive(*number)).into_iter().flatten().collect();
    println!("{} of {robots} robots drove all experiments", driven.len());
    let folder = tempfile::tempdir().expect("a folder for the recordings");
    for one in &driven {
        let file = folder.path().join(format!("{}.csv", one.number));
        std::fs::write(file, rows(&one.fitted)).expect("the recordings are written");
    }
    let Some(others) = others(folder.path()) else {
        eprintln!("error: no Python with NumPy and SciPy; name one with PYTHON");
        return ExitCode::FAILURE;
    };
    let mut table: [Vec<(f64, Errors)>; 3] = Default::default();
    for one in &driven {
        let (Ok(fit), Some([regression, output_error])) =
            (drivetrain::fit(&one.fitted), others.iter().find(|o| o.0 == one.number).map(|o| &o.1))
        else {
            println!("{}: one of the methods found nothing", one.number);
            continue;
        };
        let model = fit.constants.value;
        let left = model.wheels.left;
        let constants = [left.ks_forward_v, left.kv_v_s_per_m, model.ka_of_robot(&left).0];
        let ours = Found { constants, model };
        for (column, found) in table.iter_mut().zip([&ours, regression, output_error]) {
            column.push((one.counts_per_rev, errors(one, found)));
        }
    }
    print(&table);
    ExitCode::SUCCESS
}

/// Drives a robot's experiments; None if it stops with a fault.
fn drive(number: u64) -> Option<Driven> {
    let robot = draw(number);
    let options = Options { config: Some(robot.config.clone()), ..Options::default() };
    let experiments = on_robot_with(&robot.scenario, options, async |simulated| {
        simulated.listen(0.01).await;
        drive_experiments(&mut simulated.session, FLOOR_M).await
    });
    let (config, experiments) = experiments.ok()?;
    let straight = |identifies: bool| {
        let chosen = experiments.iter().filter(|one| one.identifies == identifies);
        chosen.filter_map(|one| one.recording(&config)).filter(is_straight).collect()
    };
    let counts_per_rev = robot.config.encoder.left.counts_per_rev;
    let (fitted, held_out) = (straight(true), straight(false));
    Some(Driven { number, counts_per_rev, truth: robot.truth, fitted, held_out })
}

/// Whether both motors had the same voltage.
fn is_straight(recording: &VoltageRecording) -> bool {
    recording.samples().windows(2).all(|pair| {
        let volts_s = pair[1].applied_vs.since(pair[0].applied_vs);
        volts_s.left * volts_s.right >= 0.0
    })
}

fn rows(recordings: &[VoltageRecording]) -> String {
    let mut text = String::new();
    for (run, recording) in recordings.iter().enumerate() {
        for sample in recording.samples() {
            let (t_s, travel_m, applied_vs) =
                (sample.t_s, sample.travel_m.left, sample.applied_vs.left);
            writeln!(text, "{run},{t_s},{travel_m},{applied_vs}").expect("a text takes all");
        }
    }
    text
}

/// What Python's methods found, robot by robot: regression, and output error.
fn others(folder: &Path) -> Option<Vec<(u64, [Found; 2])>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/bench_identification/fit.py");
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let output = Command::new(python).arg(script).arg(folder).output().ok()?;
    eprint!("{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).ok()?;
    let found = text.lines().filter_map(|line| {
        let mut words = line.split_whitespace();
        let number = words.next()?.parse().ok()?;
        let values: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
        let [ks, kv, ka, ks_forward, ks_backward, kv_too, ka_too, delay_s] = values[..] else {
            return None;
        };
        let regression = found([ks, ks, kv, ka], 0.0);
        Some((
            number,
            [regression, self::found([ks_forward, ks_backward, kv_too, ka_too], delay_s)],
        ))
    });
    output.status.success().then(|| found.collect())
}

fn found(
    [ks_forward_v, ks_backward_v, kv_v_s_per_m, ka_v_s2_per_m]: [f64; 4],
    delay_s: f64,
) -> Found {
    let motor = WheelMotor { ks_forward_v, ks_backward_v, kv_v_s_per_m, ka_v_s2_per_m };
    let model = Drivetrain { wheels: WheelPair::both(motor), delay_s, ..Drivetrain::default() };
    Found { constants: [ks_forward_v, kv_v_s_per_m, ka_v_s2_per_m], model }
}

fn errors(one: &Driven, found: &Found) -> Errors {
    let [ks, kv, ka] = std::array::from_fn(|i| (found.constants[i] / one.truth[i] - 1.0).abs());
    let (mut squares, mut count) = (0.0, 0.0);
    for recording in &one.held_out {
        let start = recording.samples()[0].travel_m.left;
        let travel = found.model.travel_m(recording);
        let off: Vec<f64> = recording
            .samples()
            .iter()
            .zip(travel)
            .map(|(sample, travel)| sample.travel_m.left - start - travel.left)
            .collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        squares += off.iter().map(|off| (off - mean).powi(2)).sum::<f64>();
        count += off.len() as f64;
    }
    let travel_m = (squares / count).sqrt();
    // A model that a step cannot follow, kA below zero, is as wrong as can be.
    [ks, kv, ka, if travel_m.is_finite() { travel_m } else { f64::MAX }]
}

fn print(table: &[Vec<(f64, Errors)>; 3]) {
    let names = ["Beeline", "regression", "SciPy"];
    println!("median over the robots; in brackets as a ratio to Beeline's");
    for (what, fine) in [("all", None), ("fine encoders", Some(true)), ("coarse", Some(false))] {
        let chosen = |column: &[(f64, Errors)], i: usize| {
            let chosen = column
                .iter()
                .filter(|(counts, _)| fine.is_none_or(|fine| fine == (*counts > FINE)));
            median(chosen.map(|(_, errors)| errors[i]).collect())
        };
        let count = table[0]
            .iter()
            .filter(|(counts, _)| fine.is_none_or(|fine| fine == (*counts > FINE)))
            .count();
        println!("\n{what}, {count} robots: kS, kV, kA off; travel that was held out");
        for (name, column) in names.iter().zip(table) {
            let values: [f64; 4] = std::array::from_fn(|i| chosen(column, i));
            let ratio = |i: usize| values[i] / chosen(&table[0], i);
            println!(
                "{name:>10}  {:.2} % ({:.1})  {:.2} % ({:.1})  {:.1} % ({:.1})  {:.3} mm ({:.2})",
                values[0] * 100.0,
                ratio(0),
                values[1] * 100.0,
                ratio(1),
                values[2] * 100.0,
                ratio(2),
                values[3] * 1e3,
                ratio(3),
            );
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
