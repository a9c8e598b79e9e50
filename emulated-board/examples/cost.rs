//! `cargo xtask bench firmware`: what a control tick of the flashed image costs.

use std::time::Duration;

use emulated_board::{Bench, Emulation, FunctionCost, Spread, StackDepth, TickCost};
use host_cli::calibrate::{Settings, calibrate};
use host_cli::pose_source::camera::Camera;
use host_link::motion::{self, Motion, RecordOptions};
use shared_proto::{Command, Key, WheelPair};
use sim_target::{Scenario, now_us};

/// The board's core \[Hz\].
const CORE_HZ: f64 = 168e6;

/// The bar for a whole tick.
const TICK_MAX: u64 = 1300;

/// Prints how deep the stack was in a run.
fn print_stack(stack: StackDepth) {
    println!(
        "Stack: {} of {} bytes used at the deepest, {:.0} %, boot and calibration.",
        stack.used,
        stack.size,
        stack.used as f64 * 100.0 / stack.size as f64
    );
}

/// Prints where the instructions of a tick go, from a short drive.
fn print_functions(emulation: Emulation) -> Result<(), Box<dyn std::error::Error>> {
    let functions = Emulation { count: false, by_function: true, ..emulation }.run(
        |mut bench: Bench| async move {
            bench.session.open().await.map_err(|error| error.to_string())?;
            let distance = WheelPair::both(0.3);
            let motion = Motion { distance, cruise: 0.3, acceleration: 1.0, ..Motion::PAPER };
            let options = RecordOptions::default();
            let driven = motion::drive(&mut bench.session, &motion, options, &mut |_| ()).await;
            driven.map(drop).map_err(|error| error.to_string())
        },
    )?;
    functions.found?;
    println!("By function, inlined ones where they stand, in a short drive:");
    println!("     mean  worst tick");
    for FunctionCost { name, mean, worst } in &functions.functions {
        if *mean >= 1.0 || *worst > 0 {
            println!("  {mean:7.1}  {worst:10}  {name}");
        }
    }
    Ok(())
}

/// Instructions of a life of three seconds: so many requests, and telemetry or none. Also the telemetry frames.
fn life(
    emulation: &Emulation,
    key: bool,
    requests: u32,
    telemetry: bool,
) -> Result<(u64, usize), Box<dyn std::error::Error>> {
    const END_US: u64 = 3_000_000;
    let ended = Emulation { count: false, ..emulation.clone() }.run(
        move |mut bench: Bench| async move {
            let session = &mut bench.session;
            session.open().await?;
            if key {
                let key = Some(Key::new([7; Key::LEN]));
                session.set_key(key, Key::new([8; Key::LEN])).await?;
            }
            for _ in 0..requests {
                session.status().await?;
            }
            if telemetry {
                session.request(Command::Subscribe { period_ms: 2 }).await?;
            }
            session.listen(Duration::from_micros(END_US - now_us())).await?;
            host_link::Result::Ok(session.take_all_telemetry().count())
        },
    )?;
    Ok((ended.instructions, ended.found.map_err(|error| error.to_string())?))
}

/// Prints what a key costs: the difference that it makes to a telemetry frame, and to a request and its reply.
fn print_seals(emulation: &Emulation) -> Result<(), Box<dyn std::error::Error>> {
    const REQUESTS: u32 = 200;
    let cost = |key| {
        let (idle, _) = life(emulation, key, 0, false)?;
        let (asked, _) = life(emulation, key, REQUESTS, false)?;
        let (sent, frames) = life(emulation, key, 0, true)?;
        let of = |busy: u64, count: f64| (busy as f64 - idle as f64) / count;
        Ok::<_, Box<dyn std::error::Error>>((
            of(sent, frames.max(1) as f64),
            of(asked, f64::from(REQUESTS)),
        ))
    };
    let (plain, sealed) = (cost(false)?, cost(true)?);
    println!("Instructions beside the ticks                  without key  with key");
    println!("  a telemetry frame: sealed                       {:8.0}  {:8.0}", plain.0, sealed.0);
    println!("  a request and its reply: checked, and sealed    {:8.0}  {:8.0}", plain.1, sealed.1);
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let image =
        std::env::var_os("BEELINE_IMAGE").ok_or("run this by `cargo xtask bench firmware`")?;
    let emulation = Emulation { count: true, ..Emulation::of(image, Scenario::default()) };
    print_functions(emulation.clone())?;
    print_seals(&emulation)?;
    let ended = emulation.run(|mut bench: Bench| async move {
        bench.session.open().await.map_err(|error| error.to_string())?;
        let mut instrument = Camera::new(bench.testbed.clone());
        calibrate(&mut bench.session, &mut instrument, &Settings::default(), &mut |_| ())
            .await
            .map(drop)
            .map_err(|error| error.to_string())
    })?;
    ended.found?;
    let driven: Vec<TickCost> = ended.ticks.iter().copied().filter(TickCost::drives).collect();
    let spread = |ticks: &[TickCost], count: fn(&TickCost) -> u64| {
        Spread::of(ticks, count).ok_or("no tick was counted")
    };
    let whole = spread(&ended.ticks, |tick| tick.instructions)?;
    let at = ended.ticks.iter().find(|tick| tick.instructions == whole.worst);
    println!(
        "A calibration run on the emulated core: {} control ticks, {} of them driving.",
        ended.ticks.len(),
        driven.len()
    );
    println!("Instructions, two wheels                          median   worst");
    let line = |name: &str, spread: Spread| {
        println!("  {name:46} {:7} {:7}", spread.median, spread.worst);
    };
    line("a whole tick, interrupt and executor included", whole);
    line("from the timer's tick to the second PWM value", spread(&driven, |tick| tick.to_pwm)?);
    line("bare arithmetic", spread(&driven, TickCost::bare)?);
    line("  capture: counts, travel, speed", spread(&driven, |tick| tick.arithmetic[0])?);
    line("  profile", spread(&driven, |tick| tick.arithmetic[1])?);
    line("  PID", spread(&driven, |tick| tick.arithmetic[2])?);
    println!("For scale, on the same emulated core:");
    println!("  ODrive's trapezoid, SimpleFOC's PID and filter      444  (float, arithmetic only)");
    println!("  linorobot2's loop                                  5089  (double)");
    println!("  linorobot2's odometry                              3176  (double, besides)");
    println!(
        "Share of the core at 1 kHz and {} MHz, taking an instruction for a cycle: {:.1} %, worst {:.1} %.",
        CORE_HZ / 1e6,
        whole.median as f64 * 1e5 / CORE_HZ,
        whole.worst as f64 * 1e5 / CORE_HZ
    );
    println!(
        "The worst tick came {:.3} s after power-on; the bar is {TICK_MAX} instructions.",
        at.map_or(0.0, |tick| tick.t_us as f64 / 1e6)
    );
    print_stack(ended.stack);
    if whole.worst > TICK_MAX {
        return Err(format!("a control tick takes {} instructions", whole.worst).into());
    }
    Ok(())
}
