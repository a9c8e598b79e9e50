//! `beeline serve`: the page on which effects are switched on and off.
//!
//! The page and its answers are made by [`crate::model_page`].

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;

use serde_json::json;

use super::compare::{read, warn_if_single_run};
use crate::cli::{Common, ServeArgs};
use crate::error::{Error, Result};
use crate::explain::next_run_options;
use crate::model_page::{Server, Workbench};
use crate::ui::{note, tell};

/// Where the page is, if nothing else was said.
const USUAL: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 7780);

pub(super) fn run(common: &Common, args: &ServeArgs) -> Result<()> {
    let (read, campaign) = read(&args.campaign)?;
    warn_if_single_run(&campaign);
    let server = bind(args.listen)?;
    let options = next_run_options(common, &read);
    let workbench = Arc::new(Workbench::new(&args.campaign, (read, campaign), options)?);
    let beside = Arc::clone(&workbench);
    std::thread::spawn(move || beside.explain());
    let link = server.link();
    tell(common.json, json!({"link": link}), format_args!("{link}"));
    if !common.json {
        note("Ctrl-C ends it");
    }
    if !args.no_open && open::that_detached(&link).is_err() {
        note("no browser could be started: open the link yourself");
    }
    server.run(workbench)
}

fn bind(asked: Option<SocketAddr>) -> Result<Server> {
    let address = asked.unwrap_or(USUAL);
    let bound = match (Server::bind(address), asked) {
        // Somebody else has it: any other does as well.
        (Err(_), None) => Server::bind(SocketAddr::new(USUAL.ip(), 0)),
        (bound, _) => bound,
    };
    bound.map_err(|error| {
        Error::new(format_args!("cannot serve the page at {address}: {error}"))
            .hint("choose another --listen, for example 127.0.0.1:0 for any free port")
    })
}
