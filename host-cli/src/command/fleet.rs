//! `beeline fleet`: many robots and dates on one page.
//!
//! What it finds is computed in [`crate::fleet`].

use crate::cli::{Common, FleetArgs};
use crate::error::{Error, Result};
use crate::fleet::{Fleet, campaigns, csv, findings_of, json, nothing_found, page, study};
use crate::table::{Cell, Table, wrapped};
use crate::ui::{BAD, BOLD, DIM, Progress, WARN, note, paint, say, warn};
use campaign::file::{WriteError, check_writable, write_whole};
use robot_model::effect::CATALOGUE;
use std::path::Path;

/// Longest line of a paragraph.
const LINE: usize = 96;

pub(super) fn run(common: &Common, args: &FleetArgs) -> Result<()> {
    let folders = campaigns(&args.folders).map_err(|(folder, error)| {
        Error::new(format_args!("cannot read the folder {}: {error}", folder.display()))
            .hint("give campaign folders, or folders that contain some")
    })?;
    if folders.is_empty() {
        return Err(Error::new("there is no campaign in these folders")
            .hint("a campaign is a folder with a robot.toml and a folder `runs`"));
    }
    // Before the work: a file that cannot be written must not cost the time.
    for file in [&args.output, &args.table].into_iter().flatten() {
        check_writable(file).map_err(|error| cannot(file, &error))?;
    }
    let progress = Progress::new(format!("{} campaigns", folders.len()), common.json);
    let fleet = study(&folders, &CATALOGUE, |share| progress.set(share));
    drop(progress);
    for (folder, why) in &fleet.left_out {
        warn(format_args!("{} is left out: {why}", folder.display()));
    }
    if fleet.kinds.is_empty() {
        return Err(Error::new("none of these campaigns can be used").hint(
            "each says above what is wrong with it; `beeline explain` of one says the same",
        ));
    }
    if let Some(file) = &args.table {
        write_whole(file, csv(&fleet).as_bytes()).map_err(|error| cannot(file, &error))?;
    }
    if let Some(file) = &args.output {
        write_whole(file, page(&fleet).as_bytes()).map_err(|error| cannot(file, &error))?;
    }
    if common.json {
        say(json(&fleet));
        return Ok(());
    }
    show(&fleet);
    for file in [&args.output, &args.table].into_iter().flatten() {
        note(format_args!("{} written", file.display()));
    }
    Ok(())
}

fn cannot(file: &Path, error: &WriteError) -> Error {
    Error::new(format_args!("cannot write {}: {error}", file.display()))
        .hint(error.hint("choose another file"))
}

fn show(fleet: &Fleet) {
    let found = findings_of(fleet);
    if found.is_empty() {
        say(paint(BOLD, format_args!("{}.", nothing_found(fleet))));
    }
    for finding in &found {
        let style = match finding.what {
            "wears" | "drifts" => BAD,
            "unlike" => WARN,
            _ => BOLD,
        };
        let mut lines = wrapped(&finding.words, LINE - 8).into_iter();
        let first = lines.next().unwrap_or_default();
        say(format_args!("{}{first}", paint(style, format_args!("{:8}", finding.what))));
        lines.for_each(|line| say(format_args!("        {line}")));
    }
    for kind in &fleet.kinds {
        say("");
        say(paint(BOLD, &kind.name));
        let mut table = Table::new("lrrl");
        let head = ["robot", "campaigns", "nominal", "missing in the last one"];
        table.row(head.map(|text| Cell::styled(DIM, text)));
        for (number, name) in kind.robots.iter().enumerate() {
            let own: Vec<_> = kind.campaigns.iter().filter(|one| one.robot == number).collect();
            let Some(last) = own.last() else { continue };
            let missing =
                if last.missing.is_empty() { "nothing".into() } else { last.missing.join("; ") };
            let mm = 1e3 * last.errors[0].cross_validated.position_rms_m;
            table.row([
                name.clone().into(),
                own.len().into(),
                format!("{mm:.1} mm").into(),
                Cell::from(missing),
            ]);
        }
        table.say(0);
    }
}
