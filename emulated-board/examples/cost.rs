//! `cargo xtask bench firmware`: what a control tick of the flashed image costs.

use std::time::Duration;

use emulated_board::{Bench, Emulation, INSTRUCTION_NS};
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
    let latest = ended.ticks.iter().map(|tick| tick.to_pwm).max().unwrap_or_default();
    println!("control ticks over the paper's run, telemetry at 500/s: {}", costs.len());
    println!(
        "instructions of a whole tick: median {}, worst {} at {} us",
        costs[costs.len() / 2],
        worst.instructions,
        worst.t_us
    );
    println!(
        "share of the core at 1 kHz, {INSTRUCTION_NS} ns an instruction: {:.1} % at worst",
        (worst.instructions * INSTRUCTION_NS) as f64 / 1e4
    );
    println!("from the timer's tick to the PWM: at most {latest} instructions");
    Ok(())
}
