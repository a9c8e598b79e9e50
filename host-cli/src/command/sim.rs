//! `beeline sim`

use std::time::Duration;

use serde_json::json;

use crate::cli::{Common, SimArgs};
use crate::error::{Error, Result};
use crate::port::Port;
use crate::serve::{ServeOptions, serve};
use crate::ui::{BOLD, paint, say};

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
        say(scenario.to_toml().trim_end());
        return Ok(());
    }
    let Some(listen) = &args.listen else { return Err(Error::new("give --listen")) };
    let mut target = common.sim().target(&scenario)?;
    let options = ServeOptions {
        camera: args.camera.as_deref(),
        reset_on_connect: args.reset_on_connect,
        duration: args
            .duration
            .map(|time| Duration::try_from_secs_f64(time.s).unwrap_or(Duration::MAX)),
    };
    serve(&mut target, listen, &options, |address| {
        if common.json {
            say(json!({ "listening": address }));
        } else {
            say(format_args!("{} in real time on {}", scenario.name, paint(BOLD, address)));
            say(format_args!("  beeline identify --port {address}"));
        }
    })
}
