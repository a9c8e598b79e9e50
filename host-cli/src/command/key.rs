//! `beeline key`: makes, sets and clears the key of the link.
//!
//! The key's file is `host-link`'s, and so is what is said to the robot.

use std::path::Path;

use campaign::file::write_new_private;
use host_link::address::Address;
use host_link::key_file;
use serde_json::json;
use shared_proto::Key;

use crate::cli::{Common, KeyCommand};
use crate::error::{Error, Result};
use crate::port::{Port, SimOptions, with_robot};
use crate::ui::{tell, warn};

pub(super) fn run(common: &Common, command: &KeyCommand) -> Result<()> {
    match command {
        KeyCommand::New { file } => {
            new(file)?;
            let words = format!(
                "{} written: with this key in a robot, whoever has the file can drive it",
                file.display()
            );
            tell(common.json, json!({ "file": file }), words);
            Ok(())
        }
        KeyCommand::Set { file } => set(common, Some(file)),
        KeyCommand::Clear => set(common, None),
    }
}

/// Writes a new key into a new file that only its owner may read.
fn new(file: &Path) -> Result<()> {
    let key = key_file::random()?;
    let name = file.display();
    match write_new_private(file, key_file::text(&key).as_bytes()) {
        Ok(true) => Ok(()),
        Ok(false) => {
            let problem = format_args!("{name} exists, and is not overwritten");
            Err(Error::new(problem).hint("name another file"))
        }
        Err(error) => {
            let hint = error.hint("does its folder exist, and may you write there?");
            Err(Error::new(format_args!("cannot write {name}: {error}")).hint(hint))
        }
    }
}

fn set(common: &Common, file: Option<&Path>) -> Result<()> {
    let key = file.map(key_file::read).transpose()?;
    if let Port::At(Address::Tcp(_)) = common.port {
        return Err(Error::new("a robot's key is set over its serial line, not over a network")
            .hint("`beeline sim --key-file FILE` gives a simulated robot its key"));
    }
    if common.port.is_sim() && common.flash.is_none() {
        warn("this simulated robot forgets when the command ends; --flash FILE gives it a memory");
    }
    // A robot that has no key yet will do.
    let sim = SimOptions { key_optional: true, ..common.sim() };
    let secret: Key = key_file::random()?;
    with_robot(&common.port, &sim, async |session, _| Ok(session.set_key(key, secret).await?))?;
    let words = match file {
        Some(file) => format!("the robot now obeys only hosts that have {}", file.display()),
        None => "the robot now obeys any host that can reach it".to_string(),
    };
    tell(common.json, json!({ "key": file.is_some() }), words);
    Ok(())
}
