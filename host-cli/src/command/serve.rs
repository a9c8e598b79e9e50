//! `beeline serve`: a campaign's model on a page, or a robot.
//!
//! The pages and their answers are made by [`crate::model_page`] and [`crate::robot_page`].

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;
use std::time::Duration;

use clap::Parser;
use host_link::Cancel;
use host_link::address::Address;
use host_link::listen::{Line, Listen};
use host_link::share::{SharedPort, is_shared};
use serde_json::json;
use sim_link::{RemoteTestbed, ServeEvent, ServeOptions};
use sim_target::instruments::CameraSample;

use super::compare::{read, warn_if_single_run};
use crate::cli::{Cli, Common, ServeArgs};
use crate::error::{Error, Result};
use crate::explain::next_run_options;
use crate::fit_cache::FitCache;
use crate::interrupt;
use crate::model_page::Workbench;
use crate::page_server::Server;
use crate::port::Port;
use crate::robot_page::{Predictor, Procedures, Robot, RobotPage, predict_for};
use crate::ui::{note, tell};
use crate::{model_page, robot_page};

/// Where the page is, if nothing else was said.
const USUAL: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 7780);

/// A robot that the page's own program serves is reached at any free port of this machine.
const ANY: &str = "127.0.0.1:0";

/// Carries out a command line.
type RunCli = fn(&Cli) -> Result<()>;

/// `run` carries out the commands that a robot's page guides through.
pub(super) fn run(common: &Common, args: &ServeArgs, run: RunCli) -> Result<()> {
    match &args.campaign {
        Some(campaign) if common.port.is_sim() => model(common, args, campaign),
        // The robot, and what its campaign's model predicts.
        Some(campaign) => robot(common, args, run, Predictor::of_campaign(campaign)?),
        None => robot(common, args, run, Predictor::configured()),
    }
}

/// The page on which effects are switched.
fn model(common: &Common, args: &ServeArgs, folder: &Path) -> Result<()> {
    let (read, campaign) = read(folder)?;
    warn_if_single_run(&campaign);
    let server = bind(args.listen)?;
    let options = next_run_options(common, &read);
    let cache = args.reuse.cache(common.json);
    let workbench = explaining(folder, (read, campaign), options, cache)?;
    open_page(common, args, &server, None);
    model_page::serve(server, workbench)
}

/// A campaign on the workbench, which `explain` already looks at.
fn explaining(
    folder: &Path,
    read: (campaign::Campaign, robot_model::recording::Campaign),
    options: String,
    cache: FitCache,
) -> Result<Arc<Workbench>> {
    let workbench = Arc::new(Workbench::new(folder, read, options, cache)?);
    let beside = Arc::clone(&workbench);
    std::thread::spawn(move || {
        beside.explain();
        beside.look_ahead();
    });
    Ok(workbench)
}

/// The page on which a robot is watched and driven.
fn robot(common: &Common, args: &ServeArgs, run: RunCli, predictor: Predictor) -> Result<()> {
    let server = bind(args.listen)?;
    let key = common.sim().key()?;
    // Dropped last: the robot is reached through it until it stands.
    let (address, testbed, _line) = match &common.port {
        Port::Sim(_) => {
            let (address, testbed, line) = simulated(common)?;
            (address, Some(testbed), Some(line))
        }
        // What another program shares is reached through it, as by any other command.
        Port::At(Address::Serial { path, baud }) if !is_shared(path) => {
            let (address, line) = shared(path, *baud)?;
            (address, None, Some(line))
        }
        Port::At(address) | Port::Served(address, _) => (address.clone(), None, None),
    };
    let port = match &testbed {
        Some(testbed) => Port::Served(address.clone(), testbed.clone()),
        None => Port::At(address.clone()),
    };
    let robot = Arc::new(Robot::default());
    let (beside, at) = (Arc::clone(&robot), address.clone());
    let kept = std::thread::spawn(move || {
        robot_page::keep_session(&at, key.as_ref(), &beside, &interrupt::cancel())
    });
    open_page(common, args, &server, Some(&address));
    // A page shows words.
    let for_page = Common { port, json: false, ..common.clone() };
    let procedures = Arc::new(procedures(for_page, run, server.ip()));
    let page = RobotPage { robot: Arc::clone(&robot), procedures, simulated: testbed.is_some() };
    if let Some(testbed) = testbed {
        std::thread::spawn(move || watch_by_camera(&testbed, &robot));
    }
    let driven = Arc::clone(&page.robot);
    std::thread::spawn(move || predict_for(&driven, &predictor));
    robot_page::serve(server, page)?;
    match kept.join() {
        Ok(left) => Ok(left?),
        Err(_) => Err(Error::new("the session with the robot has ended by a mistake of Beeline's")
            .hint("`beeline identify` shows the robot's state, `beeline stop` stops it")),
    }
}

/// The commands that the page guides through, with this robot; further pages are served at this address.
fn procedures(common: Common, run: RunCli, ip: IpAddr) -> Procedures {
    let options = common.clone();
    let run_line = move |args: &[String]| {
        let words = ["beeline".to_owned()].into_iter().chain(args.iter().cloned());
        run(&Cli { common: common.clone(), ..Cli::try_parse_from(words)? })
    };
    let serve_model = move |folder: &Path| {
        let (read, campaign) = read(folder)?;
        let words = next_run_options(&options, &read);
        let workbench = explaining(folder, (read, campaign), words, FitCache::of_user(true))?;
        let server = bind(Some(SocketAddr::new(ip, 0)))?;
        let link = server.link();
        std::thread::spawn(move || model_page::serve(server, workbench));
        Ok(link)
    };
    Procedures::new(Box::new(run_line), Box::new(serve_model))
}

/// Passes on what the camera of a simulated robot sees, until that robot ends.
fn watch_by_camera(testbed: &RemoteTestbed, robot: &Robot) {
    const EVERY: Duration = Duration::from_millis(40);
    let mut seen = 0;
    while let Ok(samples) = testbed.ask(move |testbed| testbed.camera_samples_from(seen)) {
        seen += samples.len();
        let micro = |value: f64| (value * 1e6).round() as i64;
        let pose = |CameraSample { t_s, x_m, y_m, heading_rad }: CameraSample| {
            [t_s, x_m, y_m, heading_rad].map(micro)
        };
        robot.push_poses(samples.into_iter().map(pose));
        std::thread::sleep(EVERY);
    }
}

/// A line to the robot that a thread of this program keeps; ends, and waits for its thread, with this value.
struct KeptLine {
    end: Cancel,
    thread: Option<JoinHandle<()>>,
}

impl KeptLine {
    fn new(keep: impl FnOnce(&Cancel) + Send + 'static) -> Self {
        let end = Cancel::default();
        let asked = end.clone();
        Self { end, thread: Some(std::thread::spawn(move || keep(&asked))) }
    }
}

impl Drop for KeptLine {
    fn drop(&mut self) {
        self.end.request();
        // If it has panicked, there is nothing left to wait for.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// A simulated robot in real time, in a thread of its own.
fn simulated(common: &Common) -> Result<(Address, RemoteTestbed, KeptLine)> {
    let options = common.sim();
    let scenario = options.scenario(&common.port)?;
    let (sender, listening) = sync_channel(1);
    let (testbed, requests) = RemoteTestbed::new();
    let line = KeptLine::new(move |end| {
        let failed = |error: Error| {
            let _ = sender.send(Err(error));
        };
        let mut target = match options.served(&scenario, true) {
            Ok(target) => target,
            Err(error) => return failed(error),
        };
        let mut news = |event| {
            if let ServeEvent::Listening(address) = event {
                let _ = sender.send(Ok(address));
            }
        };
        let listen = Listen::Tcp(ANY.to_owned());
        let options = ServeOptions { requests: Some(requests), ..ServeOptions::default() };
        if let Err(error) = sim_link::serve(&mut target, &listen, &options, end, &mut news) {
            failed(error.into());
        }
    });
    let address = listening.recv().map_err(|_| Error::new("the simulated robot has ended"))??;
    Ok((address.parse().map_err(Error::new)?, testbed, line))
}

/// A serial port that this program owns from now on, and shares.
fn shared(path: &str, baud: u32) -> Result<(Address, KeptLine)> {
    /// A device that is gone is looked for this often.
    const AGAIN_AFTER: Duration = Duration::from_secs(1);
    let mut line = Line::open(&Listen::Tcp(ANY.to_owned()))?;
    let address = line.address().parse().map_err(Error::new)?;
    // Before the page: a port that does not exist is an error at once.
    let mut port = Some(SharedPort::open(path, baud, &line)?);
    let path = path.to_owned();
    let kept = KeptLine::new(move |end| {
        while !end.is_requested() {
            if let Some(mut port) = port.take()
                && port.pass_on(&mut line, end, &mut |_| {}).is_ok()
            {
                return;
            }
            std::thread::sleep(AGAIN_AFTER);
            port = SharedPort::open(&path, baud, &line).ok();
        }
    });
    Ok((address, kept))
}

fn open_page(common: &Common, args: &ServeArgs, server: &Server, robot: Option<&Address>) {
    let link = server.link();
    let port = robot.map(Address::to_string);
    tell(common.json, json!({"link": link, "port": port}), format_args!("{link}"));
    if let Some(port) = port.filter(|_| !common.json) {
        note(format_args!("other commands reach the robot too: --port {port}"));
    }
    if !common.json {
        note("Ctrl-C ends it");
    }
    if !args.no_open && open::that_detached(&link).is_err() {
        note("no browser could be started: open the link yourself");
    }
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
