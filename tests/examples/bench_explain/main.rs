//! How much time and memory does `explain` need? For 12 runs of 2000 samples, of four and sixteen times as many, and for
//! 100 runs of 2000. And how fast is a fit of three parameters beside SciPy's, where that is installed? `cargo xtask bench explain [TIMES...]`:
//! runs of so many times 2000 samples, 1, 4 and 16 by default.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write;
use std::process::{Command, ExitCode};
use std::time::Instant;

use robot_model::effect::{Effect, find};
use robot_model::explain::model::fit;
use robot_model::explain::{StepFound, explain};
use robot_model::kinematics::Pose;
use robot_model::recording::Campaign;
use robot_model::recording::{Piece, Sampling, nominal_run};
use robot_model::recording::{Recording, Robot};

/// The bars: seconds of 12 and of 100 runs of 2000 samples, on two idle cores; megabytes of 12.
const SECONDS_MAX: f64 = 1.0;
const SECONDS_MAX_MANY: f64 = 8.0;
const MEGABYTES_MAX: f64 = 300.0;
const RUNS: usize = 12;
const MANY_RUNS: usize = 100;
const SAMPLES: usize = 2000;

const ROBOT: Robot = Robot::PAPER;
/// The hidden truth: rho, scale, delta; and a side slip \[s\], which a model of three parameters does not have.
const TRUTH: [f64; 3] = [0.008, -0.004, 0.015];
const SLIP_S: f64 = 0.03;

fn main() -> ExitCode {
    println!("explain: a pose with every sample; radii, track width and side slip hidden\n");
    println!(
        "{:>6} {:>14} {:>10} {:>11} {:>12}",
        "runs", "samples a run", "seconds", "to first", "peak memory"
    );
    let chosen: Vec<usize> = std::env::args().skip(1).filter_map(|arg| arg.parse().ok()).collect();
    let times = if chosen.is_empty() { vec![1, 4, 16] } else { chosen };
    // The most memory counts from the start: the largest comes last.
    let mut sizes: Vec<[usize; 2]> = times.iter().map(|times| [RUNS, SAMPLES * times]).collect();
    sizes.insert(1, [MANY_RUNS, SAMPLES]);
    let mut first = None;
    let mut good = true;
    for size in sizes {
        good &= explain_of(size, &mut first);
    }
    beside_scipy();
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Explains so many runs of so many samples, and says how long that took beside the first time; whether the bars hold.
fn explain_of(size: [usize; 2], first: &mut Option<f64>) -> bool {
    let [runs, samples] = size;
    let campaign = campaign(runs, samples);
    let began = Instant::now();
    let answer = explain(&campaign).expect("a sound campaign");
    let seconds = began.elapsed().as_secs_f64();
    let megabytes = peak_megabytes();
    let ratio = seconds / *first.get_or_insert(seconds);
    let memory =
        megabytes.map_or_else(|| "unknown".into(), |megabytes| format!("{megabytes:.0} MB"));
    println!("{runs:>6} {samples:>14} {seconds:>10.2} {ratio:>11.1} {memory:>12}");
    // In brackets: what is too small to matter.
    let named = |step: &StepFound| match step.matters {
        true => step.effect.clone(),
        false => format!("({})", step.effect),
    };
    let found: Vec<String> = answer.steps.iter().map(named).collect();
    println!("{:>6} found: {}", "", found.join(", "));
    let most_s = match size {
        [RUNS, SAMPLES] => SECONDS_MAX,
        [MANY_RUNS, SAMPLES] => SECONDS_MAX_MANY,
        _ => return true,
    };
    let mut good = bar(&format!("at most {most_s} s"), seconds <= most_s);
    if let (RUNS, Some(megabytes)) = (runs, megabytes) {
        good &= bar(&format!("below {MEGABYTES_MAX} MB"), megabytes < MEGABYTES_MAX);
    }
    good
}

fn bar(claim: &str, holds: bool) -> bool {
    println!("{:>6} {} {claim}", "", if holds { "holds:" } else { "MISSED:" });
    holds
}

/// The most memory that this process ever had, where the system tells \[MB\].
fn peak_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024.0 / 1e6)
}

/// So many runs of so many samples, fifty a second.
fn campaign(runs: usize, samples: usize) -> Campaign {
    let straight = |speed_mps: f64| {
        let there = Piece::Straight { travel_m: 1.5, speed_mps };
        vec![there, Piece::Straight { travel_m: -1.5, speed_mps }]
    };
    let spin = |turn_rad: f64, speed_mps: f64| vec![Piece::Spin { turn_rad, speed_mps }];
    let arc = |radius_m: f64, turn_rad: f64, speed_mps: f64| {
        vec![Piece::Arc { radius_m, turn_rad, speed_mps }]
    };
    let square = |turn_rad: f64| {
        vec![
            Piece::Straight { travel_m: 1.0, speed_mps: 0.25 },
            Piece::Spin { turn_rad, speed_mps: 0.1 },
        ]
    };
    let plans: [Vec<Piece>; RUNS] = [
        straight(0.12),
        straight(0.3),
        straight(0.2),
        straight(0.35),
        spin(2.0 * TAU, 0.06),
        spin(-2.0 * TAU, 0.15),
        arc(0.4, TAU, 0.12),
        arc(0.4, -TAU, 0.3),
        arc(0.9, TAU, 0.35),
        arc(0.9, -TAU, 0.15),
        square(FRAC_PI_2),
        square(-FRAC_PI_2),
    ];
    let settings = Sampling { sample_s: 0.02, samples_per_pose: 1, ..Sampling::USUAL };
    let runs = plans
        .into_iter()
        .cycle()
        .take(runs)
        .enumerate()
        .map(|(index, pieces)| {
            let once = nominal_run(&ROBOT, "once", &pieces, &settings).wheels.len() - 1;
            let often = samples.div_ceil(once).max(1);
            let mut run =
                nominal_run(&ROBOT, &format!("{index:03}"), &pieces.repeat(often), &settings);
            run.wheels.truncate(samples);
            run.measured_poses.truncate(samples);
            measure(&mut run, index as u64 + 1);
            run
        })
        .collect();
    Campaign { robot: ROBOT, runs }
}

/// Adds what a camera measures of the robot with the hidden truth, and rounds wheel angles to whole counts.
fn measure(run: &mut Recording, seed: u64) {
    let mut random = Random(seed);
    let [rho, scale, delta] = TRUTH;
    let mut pose = Pose::new(0.1, -0.2, 0.4 * seed as f64);
    let mut before = run.wheels[0];
    for (wheel, measurement) in run.wheels.iter().zip(&mut run.measured_poses) {
        let dphi = before.phi_rad.zip(wheel.phi_rad).map(|(a, b)| b - a);
        let radius_m = ROBOT.wheel_radius_m * (1.0 + scale);
        let left_m = radius_m * (1.0 - rho / 2.0) * dphi.left;
        let right_m = radius_m * (1.0 + rho / 2.0) * dphi.right;
        let heading_rad = pose.heading_rad;
        pose = pose.advance(left_m, right_m, ROBOT.track_width_m * (1.0 + delta));
        let dt_s = wheel.t_s - before.t_s;
        let turn_rad = pose.heading_rad - heading_rad;
        if dt_s > 0.0 {
            let aside_m = -SLIP_S * (left_m + right_m) / 2.0 / dt_s * turn_rad;
            pose.x_m += -aside_m * heading_rad.sin();
            pose.y_m += aside_m * heading_rad.cos();
            let rolled_m = (left_m.abs() + right_m.abs()) / 2.0;
            pose.heading_rad += 1e-3 * rolled_m.sqrt() * random.normal();
        }
        measurement.position_m =
            Some([pose.x_m + 1e-3 * random.normal(), pose.y_m + 1e-3 * random.normal()]);
        measurement.heading_rad = Some(pose.heading_rad + 2e-3 * random.normal());
        before = *wheel;
    }
    for wheel in &mut run.wheels {
        wheel.phi_rad = wheel
            .phi_rad
            .map(|phi_rad| (phi_rad / ROBOT.rad_per_count).floor() * ROBOT.rad_per_count);
    }
}

/// A small generator, the same on every machine (splitmix64).
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 + 1e-17
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// The same three parameters from the same data: here with noise and cross-validated errors, by SciPy the parameters
/// alone.
fn beside_scipy() {
    let campaign = campaign(RUNS, SAMPLES);
    let three: Vec<&'static dyn Effect> =
        ["wheel_radius_ratio", "wheel_radius_scale", "track_width"]
            .map(|id| find(id).expect("an effect of the catalogue"))
            .into();
    let began = Instant::now();
    let model = fit(&campaign, &three).expect("a sound campaign");
    let here_s = began.elapsed().as_secs_f64();
    let values: Vec<f64> = model.effects.iter().map(|effect| effect.parameters[0].value).collect();
    println!(
        "\nthree parameters, {RUNS} runs of {SAMPLES} samples (truth {TRUTH:?}, side slip left out)"
    );
    println!("  beeline, with noise and cross-validation: {here_s:.2} s, {values:.5?}");
    match scipy(&campaign) {
        Ok((scipy_s, values)) => {
            println!("  scipy.optimize.least_squares:             {scipy_s:.2} s, {values:.5?}");
            println!("  beeline takes {:.2} times as long", here_s / scipy_s);
        }
        Err(why) => println!("  scipy.optimize.least_squares: not compared ({why})"),
    }
}

fn scipy(campaign: &Campaign) -> Result<(f64, Vec<f64>), String> {
    let mut table = "run,phi_left_rad,phi_right_rad,x_m,y_m,heading_rad\n".to_owned();
    for (index, run) in campaign.runs.iter().enumerate() {
        for (wheel, measurement) in run.wheels.iter().zip(&run.measured_poses) {
            let [x_m, y_m] = measurement.position_m.unwrap_or_default();
            let heading_rad = measurement.heading_rad.unwrap_or_default();
            let phi = wheel.phi_rad;
            let _ = writeln!(table, "{index},{},{},{x_m},{y_m},{heading_rad}", phi.left, phi.right);
        }
    }
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let file = folder.path().join("runs.csv");
    std::fs::write(&file, table).map_err(|error| error.to_string())?;
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/bench_explain/fit.py");
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let output = Command::new(&python)
        .arg(script)
        .arg(&file)
        .args([ROBOT.wheel_radius_m.to_string(), ROBOT.track_width_m.to_string()])
        .output()
        .map_err(|error| format!("{python}: {error}"))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        return Err(text.lines().last().unwrap_or("it failed").to_owned());
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let mut numbers = text.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
    let seconds = numbers.next().ok_or("it printed nothing")?;
    Ok((seconds, numbers.take(3).collect()))
}
