//! `cargo xtask emulate`: the flashed image behind a TCP port, in real time.
//!
//! The chip's clock follows real time. If the emulator is too slow, the chip's clock falls behind and does
//! not catch up. For the robot the host then only sends more often, so no timeout of the robot comes early;
//! for the host every answer takes longer. A host gives up after 1.5 s without an answer, which takes the
//! chip a few milliseconds: so the emulator may be some hundred times too slow, but not more.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use emulated_board::{Bench, Emulation};
use host_link::listen::Listen;
use host_link::motion::{self, Motion, RecordOptions};
use host_link::{Cancel, Session};
use shared_proto::WheelPair;
use sim_link::{ClientLog, ServeError, ServeEvent, ServeOptions, Server};
use sim_target::{Scenario, now_us, sleep_until_us};

/// How often chip and client exchange bytes, on the chip's clock \[us\].
const STEP_US: u64 = 1000;

/// A longer lag is not made up for.
const LAG_MAX: Duration = Duration::from_millis(5);

const USE: &str = "use: cargo xtask emulate [--listen HOST:PORT] [--scenario FILE] [--camera FILE] \
                   [--flash FILE]";

struct Options {
    listen: String,
    scenario: Option<PathBuf>,
    camera: Option<PathBuf>,
    flash: Option<PathBuf>,
}

impl Options {
    fn parse() -> Result<Self, String> {
        let mut options =
            Self { listen: "127.0.0.1:7701".into(), scenario: None, camera: None, flash: None };
        let mut args = std::env::args().skip(1);
        while let Some(option) = args.next() {
            let value = args.next().ok_or(USE)?;
            match option.as_str() {
                "--listen" => options.listen = value,
                "--scenario" => options.scenario = Some(value.into()),
                "--camera" => options.camera = Some(value.into()),
                "--flash" => options.flash = Some(value.into()),
                _ => return Err(USE.into()),
            }
        }
        Ok(options)
    }
}

fn main() -> ExitCode {
    match serve() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn serve() -> Result<(), Box<dyn std::error::Error>> {
    let options = Options::parse()?;
    let image = std::env::var_os("BEELINE_IMAGE").ok_or("run this by `cargo xtask emulate`")?;
    let scenario = match &options.scenario {
        Some(path) => Scenario::load(path)?,
        None => Scenario::default(),
    };
    // Without the file, the flash is blank.
    let flash = options.flash.as_ref().and_then(|path| std::fs::read(path).ok());
    let cancel = Cancel::default();
    let asked = cancel.clone();
    ctrlc::set_handler(move || asked.request())?;
    eprintln!("translating the image ...");
    warm_up(Emulation::of(image.clone(), Scenario::default()), cancel.clone())?;
    let emulation = Emulation { flash, ..Emulation::of(image, scenario) };
    let (listen, camera) = (options.listen, options.camera);
    let ended = emulation.run(move |bench: Bench| async move {
        let listen = Listen::Tcp(listen);
        let options = ServeOptions { camera: camera.as_deref(), ..ServeOptions::default() };
        let server = Server::open(&listen, &options, bench.wire.clone(), bench.testbed.clone());
        match server {
            Ok(server) => in_real_time(server, &cancel).await.map_err(|error| error.to_string()),
            Err(error) => Err(error.to_string()),
        }
    })?;
    if let Some(path) = &options.flash {
        std::fs::write(path, &ended.flash)?;
    }
    for line in &ended.unexpected {
        eprintln!("{line}");
    }
    Ok(ended.found?)
}

/// Exercises requests and a drive there and back, on a sound board of its own.
///
/// The emulator translates code when the program first reaches it, which takes seconds in all. A host would
/// run into its timeout of 1.5 s. What was translated is there for the next board of this program.
fn warm_up(emulation: Emulation, cancel: Cancel) -> Result<(), Box<dyn std::error::Error>> {
    let ended = emulation.run(move |mut bench: Bench| async move {
        bench.session.cancel_by(&cancel);
        exercise(&mut bench.session).await.map_err(|error| error.to_string())
    })?;
    Ok(ended.found?)
}

async fn exercise(session: &mut Session) -> host_link::Result<()> {
    session.open().await?;
    session.identify().await?;
    let config = session.read_config().await?;
    session.write_config(&config).await?;
    let there = Motion { distance: WheelPair::both(0.2), acceleration: 0.4, ..Motion::PAPER };
    for motion in [there, there.reversed()] {
        motion::drive(session, &motion, RecordOptions::default(), &mut |_| ()).await?;
    }
    Ok(())
}

async fn in_real_time(mut server: Server, cancel: &Cancel) -> Result<(), ServeError> {
    println!("the flashed image on an emulated NUCLEO-F429ZI, on {}", server.address());
    println!("  beeline identify --port {}", server.address());
    let begin = Instant::now();
    let mut start = begin;
    let start_us = now_us();
    let mut lost = Duration::ZERO;
    let mut log = ClientLog::default();
    while !cancel.is_requested() {
        server.exchange(&mut |event| match event {
            ServeEvent::Client(event) => {
                if let Some(line) = log.line(event) {
                    eprintln!("{line}");
                }
            }
            ServeEvent::Listening(_) | ServeEvent::NotPutBack => {}
        })?;
        sleep_until_us(now_us() + STEP_US).await;
        let due = start + Duration::from_micros(now_us() - start_us);
        match due.checked_duration_since(Instant::now()) {
            Some(early) => std::thread::sleep(early),
            None => {
                let late = Instant::now() - due;
                if late > LAG_MAX {
                    start += late;
                    lost += late;
                }
            }
        }
    }
    let (chip_s, world_s) = ((now_us() - start_us) as f64 * 1e-6, begin.elapsed().as_secs_f64());
    println!(
        "{chip_s:.1} s on the chip's clock in {world_s:.1} s; {:.1} s behind",
        lost.as_secs_f64()
    );
    Ok(())
}
