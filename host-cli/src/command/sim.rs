//! `beeline sim`: serves a simulated robot in real time.
//!
//! The server itself is in `sim-link`.

use std::time::Duration;

use serde_json::{Value, json};
use sim_link::{ClientLog, ServeEvent, ServeOptions, serve};

use crate::cli::{Common, Listen, SimArgs};
use crate::error::{Context, Error, Result};
use crate::interrupt;
use crate::port::Port;
use crate::ui::{BOLD, note, paint, say, say_text, warn};

pub(super) fn run(common: &Common, args: &SimArgs) -> Result<()> {
    if !matches!(common.port, Port::Sim(_)) {
        return Err(Error::new(format_args!(
            "`beeline sim` simulates a robot; {} is one",
            common.port
        ))
        .hint("--port sim:SCENARIO.toml says which robot to simulate"));
    }
    let scenario = common.sim().scenario(&common.port)?;
    if args.scenario {
        let text = scenario.to_toml();
        match common.json {
            true => say(toml::from_str::<Value>(&text).context("the scenario")?),
            false => say_text(text.trim_end()),
        }
        return Ok(());
    }
    let Some(listen) = &args.listen else { return Err(Error::new("give --listen")) };
    let network = matches!(listen, Listen::Tcp(_));
    let mut target = common.sim().served(&scenario, network)?;
    if !listen.is_local() && !target.has_key() {
        let open = "anyone who can reach that address can drive the robot: it has no key";
        if !args.insecure {
            return Err(Error::new(open).hint(
                "--key-file FILE gives it one (`beeline key new FILE` makes it), --listen tcp:127.0.0.1:7700 is for this machine alone; --insecure if you mean it",
            ));
        }
        warn(open);
    }
    let options = ServeOptions {
        camera: args.camera.as_deref(),
        reset_on_connect: args.reset_on_connect,
        duration: args
            .duration
            .map(|time| Duration::try_from_secs_f64(time.s).unwrap_or(Duration::MAX)),
        requests: None,
    };
    let mut log = ClientLog::default();
    let mut tell = |event| match event {
        ServeEvent::Listening(address) if common.json => say(json!({ "listening": address })),
        ServeEvent::Listening(address) => {
            say(format_args!("{} in real time on {}", scenario.name, paint(BOLD, &address)));
            say(format_args!("  beeline identify --port {address}"));
        }
        ServeEvent::Client(event) => {
            if let Some(line) = log.line(event) {
                note(line);
            }
        }
        ServeEvent::NotPutBack => note("the robot is moving and was not put back"),
    };
    Ok(serve(&mut target, listen, &options, &interrupt::cancel(), &mut tell)?)
}
