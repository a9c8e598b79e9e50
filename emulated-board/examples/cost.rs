//! `cargo xtask bench firmware`: what a control tick of the flashed image costs.

use std::time::Duration;

use emulated_board::{Bench, Emulation, INSTRUCTION_NS, TickCost};
use host_cli::motion::{self, Motion, RecordOptions};
use sim_target::Scenario;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let image =
        std::env::var_os("BEELINE_IMAGE").ok_or("run this by `cargo xtask bench firmware`")?;
    let emulation = Emulation {
        image: image.into(),
        scenario: Scenario::default(),
        flash: None,
        cut_before: None,
        count: true,
    };
    let ended = emulation.run(|mut bench: Bench| async move {
        bench.session.open().await?;
        let options = RecordOptions { period_ms: 2, rest: Duration::from_millis(100) };
        motion::drive(&mut bench.session, &Motion::PAPER, options, &mut |_| ()).await.map(drop)
    })?;
    ended.found.map_err(|error| error.to_string())?;
    let mut costs: Vec<u64> = ended.ticks.iter().map(|tick| tick.instructions).collect();
    costs.sort_unstable();
    let worst =
        ended.ticks.iter().max_by_key(|tick| tick.instructions).ok_or("no tick was counted")?;
    let mut latencies: Vec<&TickCost> = ended.ticks.iter().collect();
    latencies.sort_unstable_by_key(|tick| tick.to_pwm);
    let (latency, latest) = (latencies[latencies.len() / 2], latencies[latencies.len() - 1]);
    println!("control ticks over the paper's run, telemetry at 500/s: {}", costs.len());
    println!(
        "instructions of a whole tick: median {}, worst {} at {} us",
        costs[costs.len() / 2],
        worst.instructions,
        worst.t_us
    );
    for share in [0.9, 0.99, 0.999] {
        let at = (costs.len() as f64 * share) as usize;
        println!("{:.1} % of them take at most {}", share * 100.0, costs[at]);
    }
    println!(
        "share of the core at 1 kHz, {INSTRUCTION_NS} ns an instruction: {:.1} % at worst",
        (worst.instructions * INSTRUCTION_NS) as f64 / 1e4
    );
    for (name, index) in [("capture", 0), ("profile", 1), ("PID", 2)] {
        let mut part: Vec<u64> = ended.ticks.iter().map(|tick| tick.arithmetic[index]).collect();
        part.sort_unstable();
        println!("{name}: median {}, worst {}", part[part.len() / 2], part[part.len() - 1]);
    }
    println!(
        "from the timer's tick to the PWM: median {} instructions, worst {} at {} us",
        latency.to_pwm, latest.to_pwm, latest.t_us
    );
    Ok(())
}
