//! How `beeline compare` grows with a campaign: `cargo xtask bench scale`.
//!
//! Two campaigns, one with many rows and one with many runs, and each of them at half its size: the ratio of the times shows
//! whether the work grows as the input does. Each comparison is a process of its own, so that its memory is its own.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use clap::Parser;
use host_cli::cli::Cli;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A campaign, and how long its comparison may take on two cores.
struct Case {
    what: &'static str,
    runs: usize,
    rows_of_a_run: usize,
    seconds_max: f64,
}

const CASES: [Case; 2] = [
    Case { what: "many rows", runs: 20, rows_of_a_run: 50_000, seconds_max: 10.0 },
    Case { what: "many runs", runs: 3_000, rows_of_a_run: 200, seconds_max: 20.0 },
];

/// Twice the input may take so many times as long: twice, and what a busy machine adds.
const RATIO_MAX: f64 = 2.6;

/// How often a case is timed; the fastest counts.
const REPEATS: usize = 3;

fn main() -> ExitCode {
    if let Some(folder) = std::env::args().skip_while(|word| word != "--one").nth(1) {
        return compare(&folder);
    }
    println!(
        "{:<10} {:>9} {:>6} {:>9} {:>10} {:>16}",
        "", "rows", "runs", "seconds", "memory", "half the input"
    );
    let mut holds = true;
    for case in CASES {
        let half = Case { runs: case.runs / 2, ..case };
        let ((half_s, _), (whole_s, peak_mib)) = (timed(&half), timed(&case));
        let ratio = whole_s / half_s;
        let held = whole_s <= case.seconds_max && ratio <= RATIO_MAX;
        holds &= held;
        println!(
            "{:<10} {:>9} {:>6} {whole_s:>7.1} s {peak_mib:>6.0} MiB {half_s:>7.1} s, x{ratio:.2}  {}: at most {} s and x{RATIO_MAX}",
            case.what,
            case.runs * case.rows_of_a_run,
            case.runs,
            if held { "holds" } else { "MISSED" },
            case.seconds_max,
        );
    }
    if holds { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Seconds and peak memory \[MiB\] of `beeline compare` on such a campaign.
fn timed(case: &Case) -> (f64, f64) {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), case);
    let mut best = (f64::INFINITY, 0.0);
    for _ in 0..REPEATS {
        let start = Instant::now();
        let output = Command::new(std::env::current_exe().expect("this program"))
            .arg("--one")
            .arg(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .output()
            .expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let peak = said.lines().find_map(|line| line.strip_prefix("peak ")?.parse::<f64>().ok());
        let timed = (start.elapsed().as_secs_f64(), peak.unwrap_or(f64::NAN) / 1024.0);
        if timed.0 < best.0 {
            best = timed;
        }
    }
    best
}

/// `beeline compare FOLDER`, and how much memory it took.
fn compare(folder: &str) -> ExitCode {
    let cli = Cli::try_parse_from(["beeline", "compare", folder, "--no-cache"])
        .expect("a command of beeline");
    if let Err(error) = host_cli::command::run(&cli) {
        eprintln!("{error}");
        return ExitCode::FAILURE;
    }
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = peak.and_then(|peak| peak.split_whitespace().next()).unwrap_or("NaN");
    eprintln!("peak {kib}");
    ExitCode::SUCCESS
}

/// Rows a second.
const RATE_HZ: f64 = 50.0;
const RADIUS_M: f64 = 0.036;
const TRACK_M: f64 = 0.372;
const COUNTS_PER_REV: f64 = 900.0;

/// Writes a campaign: arcs forward and backward with rests between them, by a robot whose right wheel is half a percent larger,
/// seen by a tracker with 1 mm and 2 mrad of noise in every second row.
fn write(folder: &Path, case: &Case) {
    let runs = folder.join("runs");
    std::fs::create_dir(&runs).expect("the folder is new");
    let toml = format!(
        "name = \"large\"\nwheel_radius_m = {RADIUS_M}\ntrack_width_m = {TRACK_M}\ncounts_per_rev = {COUNTS_PER_REV}\n\
         position_sigma_m = 0.001\nheading_sigma_rad = 0.002\n"
    );
    std::fs::write(folder.join("robot.toml"), toml).expect("there is room");
    for run in 0..case.runs {
        let file = runs.join(format!("{:04}_arcs.csv", run + 1));
        std::fs::write(file, rows(run as u64, case.rows_of_a_run)).expect("there is room");
    }
}

fn rows(seed: u64, len: usize) -> String {
    /// From rest, there and back, and rest again.
    const PERIOD_S: f64 = 4.0;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // The sum of twelve uniform numbers is near enough to a normal one.
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let (speed_mps, turn_rad_s) = (0.15 + 0.01 * normal(), 0.2 * normal());
    let mut text = String::from("t_s,left_counts,right_counts,x_m,y_m,heading_rad\n");
    let (mut pose, mut travel_m) = ([0.0_f64; 3], [0.0_f64; 2]);
    for row in 0..len {
        let t_s = row as f64 / RATE_HZ;
        let share = (std::f64::consts::TAU * t_s / PERIOD_S).sin();
        let share = if share.abs() < 0.3 { 0.0 } else { share };
        let wheels =
            [-0.5, 0.5].map(|side| (speed_mps + side * TRACK_M * turn_rad_s) * share / RATE_HZ);
        let counts = travel_m
            .map(|m: f64| (m / (RADIUS_M * std::f64::consts::TAU) * COUNTS_PER_REV).floor());
        let _ = write!(text, "{t_s:.6},{},{},", counts[0], counts[1]);
        if row % 2 == 0 {
            let [x_m, y_m, heading_rad] = pose;
            let seen =
                [x_m + 1e-3 * normal(), y_m + 1e-3 * normal(), heading_rad + 2e-3 * normal()];
            let _ = writeln!(text, "{:.7},{:.7},{:.7}", seen[0], seen[1], seen[2]);
        } else {
            text.push_str(",,\n");
        }
        // The encoders count what the nominal wheel would have rolled.
        travel_m = [travel_m[0] + wheels[0], travel_m[1] + wheels[1] / 1.005];
        let turned_rad = (wheels[1] - wheels[0]) / TRACK_M;
        let way_m = 0.5 * (wheels[0] + wheels[1]);
        let middle_rad = pose[2] + 0.5 * turned_rad;
        pose = [
            pose[0] + way_m * middle_rad.cos(),
            pose[1] + way_m * middle_rad.sin(),
            pose[2] + turned_rad,
        ];
    }
    text
}
