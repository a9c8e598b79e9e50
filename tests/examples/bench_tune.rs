//! Robots over two decades of motor size, tuned from the factory's gains: how many follow, and how right the constants are.
//! `cargo xtask bench tune [--seed S] [--robots N]`; seed 1 and 300 robots by default. `--robot NUMBER` repeats one of them.

use std::process::ExitCode;

use beeline_tests::parallel::in_order;
use beeline_tests::tuning::outcome::FLOOR_M;
use beeline_tests::tuning::robots::{UntunedRobot, draw};

fn main() -> ExitCode {
    let Some(seeds) = arguments() else {
        eprintln!("usage: bench_tune [--seed S] [--robots N] | --robot NUMBER");
        return ExitCode::from(2);
    };
    let lines = in_order(&seeds, |seed| one(*seed));
    let mut counts = Counts::default();
    for (seed, line) in seeds.iter().zip(&lines) {
        println!("{seed}: {}", line.text);
        counts.add(line);
    }
    counts.print();
    ExitCode::SUCCESS
}

/// The numbers of the robots.
fn arguments() -> Option<Vec<u64>> {
    let (mut seed, mut robots) = (1, 300);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next()?.parse().ok()?;
        match word.as_str() {
            "--seed" => seed = value,
            "--robots" => robots = value,
            "--robot" => return Some(vec![value]),
            _ => return None,
        }
    }
    Some((0..robots).map(|number| seed * 100_000 + number).collect())
}

/// One robot's result.
struct Line {
    text: String,
    /// It follows within twice the floor, without overshoot.
    follows: bool,
    refused: bool,
    /// Beyond its floor, moving at the end, or changed although refused.
    broken: bool,
    /// kS, kV, kA relative to the truth, less 1.
    errors: Option<[f64; 3]>,
    /// Whether their 95 % intervals hold the truth.
    covers: Option<[bool; 3]>,
    took_s: f64,
}

/// A robot in a few words.
fn about(robot: &UntunedRobot) -> String {
    let counts = robot.config.encoder.left.counts_per_rev;
    format!(
        "{:.2} kg, {counts} counts, kS {:.2} V, kV {:.1}, kA/kV {:.0} ms, delay {} ms, play {:.1} deg",
        robot.scenario.plant.body.mass_kg,
        robot.truth[0],
        robot.truth[1],
        robot.truth[2] / robot.truth[1] * 1e3,
        robot.scenario.plant.bridge.delay_ms,
        robot.scenario.plant.gear.left.backlash_rad.to_degrees(),
    )
}

/// Marks a number whose interval does not contain the truth.
fn outside_interval(covers: bool) -> &'static str {
    if covers { "" } else { "*" }
}

fn one(seed: u64) -> Line {
    let robot = draw(seed);
    let verdict = robot.tune();
    let about = about(&robot);
    let (behind_m, ahead_m) = verdict.range_m;
    let outside = ahead_m > FLOOR_M || behind_m < -0.1;
    match &verdict.tuned {
        Err(why) => Line {
            text: format!(
                "{about}: REFUSED {why}{}",
                if outside || !verdict.at_rest || !verdict.unchanged {
                    format!(
                        " BROKEN {behind_m:.2} {ahead_m:.2} {} {}",
                        verdict.at_rest, verdict.unchanged
                    )
                } else {
                    String::new()
                }
            ),
            follows: false,
            refused: true,
            broken: outside || !verdict.at_rest || !verdict.unchanged,
            errors: None,
            covers: None,
            took_s: f64::NAN,
        },
        Ok(tuned) => {
            let floor_m = robot.following_floor_m();
            let follows = tuned.after.rms_m <= 2.0 * floor_m && tuned.after.overshoot < 0.05;
            let value = &tuned.fit.constants.value;
            let off = &tuned.fit.constants.half_widths_95.left;
            let motor = &value.wheels.left;
            let found = [motor.ks_forward_v, motor.kv_v_s_per_m, value.ka_of_robot(motor).0];
            let off = [off.ks_forward_v, off.kv_v_s_per_m, off.ka_straight_v_s2_per_m];
            let mut errors = [0.0; 3];
            let mut covers = [false; 3];
            for i in 0..3 {
                errors[i] = found[i] / robot.truth[i] - 1.0;
                covers[i] = (found[i] - robot.truth[i]).abs() <= off[i];
            }
            Line {
                text: format!(
                    "{about}: rms {:.3} mm ({:.1} floors), overshoot {:.1} %, kS {:+.1} %{} kV {:+.1} %{} kA {:+.1} %{}, delay {:.1} ms, {:.0} s, {:.2} m{}{}",
                    tuned.after.rms_m * 1e3,
                    tuned.after.rms_m / floor_m,
                    tuned.after.overshoot * 100.0,
                    errors[0] * 100.0,
                    outside_interval(covers[0]),
                    errors[1] * 100.0,
                    outside_interval(covers[1]),
                    errors[2] * 100.0,
                    outside_interval(covers[2]),
                    value.delay_s * 1e3,
                    tuned.took_s,
                    ahead_m - behind_m,
                    if follows { "" } else { " LOOSE" },
                    if outside { " OUTSIDE" } else { "" },
                ),
                follows,
                refused: false,
                broken: outside || !verdict.at_rest,
                errors: Some(errors),
                covers: Some(covers),
                took_s: tuned.took_s,
            }
        }
    }
}

#[derive(Default)]
struct Counts {
    robots: usize,
    follow: usize,
    refused: usize,
    broken: usize,
    errors: Vec<[f64; 3]>,
    covers: Vec<[bool; 3]>,
    took_s: Vec<f64>,
}

impl Counts {
    fn add(&mut self, line: &Line) {
        self.robots += 1;
        self.follow += usize::from(line.follows);
        self.refused += usize::from(line.refused);
        self.broken += usize::from(line.broken);
        self.errors.extend(line.errors);
        self.covers.extend(line.covers);
        if line.took_s.is_finite() {
            self.took_s.push(line.took_s);
        }
    }

    fn print(&self) {
        let share = |count: usize| 100.0 * count as f64 / self.robots.max(1) as f64;
        println!("\n{} robots", self.robots);
        println!("follow within twice the floor    {:5.1} %", share(self.follow));
        println!("refused                          {:5.1} %", share(self.refused));
        println!("left the floor or broke a limit  {:5.1} %", share(self.broken));
        for (i, name) in ["kS", "kV", "kA"].into_iter().enumerate() {
            let off = self.errors.iter().map(|errors| 100.0 * errors[i].abs()).collect();
            let covered = self.covers.iter().filter(|covers| covers[i]).count();
            println!(
                "{name}: median {:.2} % off; its 95 % interval covers {:.0} %",
                median(off),
                100.0 * covered as f64 / self.covers.len().max(1) as f64
            );
        }
        println!("median time {:.0} s", median(self.took_s.clone()));
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
