//! Pages about motors: what `tune` did, and what `explain --drivetrain` found. Each is one self-contained HTML file.
//!
//! | section | file |
//! | --- | --- |
//! | a tuning: constants, gains, how the wheels follow | `tuning.rs` |
//! | a campaign: what is missing | `campaign_page.rs` |
//! | the experiments, measured and modelled | `experiments.rs` |
//! | a small drawing of curves over time | `curves.rs` |
//!
//! Nothing in them comes from the network, and nothing runs. The same data give the same bytes.

mod campaign_page;
mod curves;
mod experiments;
mod tuning;

use std::fmt::Write;

use crate::calibration_page::drawing::{COLOURS, STYLE};
use crate::calibration_page::page::PAGE_STYLE;
use crate::escape::html as escape;
use crate::report::{DRAWING_STYLE, REPORT_STYLE};

pub use campaign_page::of_campaign;
pub use tuning::of_tuning;

/// Curves of another model, behind those that count.
const PALE: &str = ".d .p.pale{opacity:.35}";

/// The page up to its first line.
fn begin(robot: &str, title: &str) -> String {
    let robot = if robot.is_empty() { "robot" } else { robot };
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <title>{}: {title}</title>\n<style>{COLOURS}\n{STYLE}\n{PAGE_STYLE}\n{DRAWING_STYLE}{REPORT_STYLE}{PALE}</style></head>\n<body>\n",
        escape(robot)
    )
}

fn section(html: &mut String, title: &str, words: &str) {
    let _ = writeln!(html, "\n<h2>{title}</h2>\n<p class=\"sub\">{words}</p>");
}

/// A table: its head, and rows of cells.
fn table(html: &mut String, head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
    html.push_str("<table><thead><tr>");
    for cell in head {
        let _ = write!(html, "<th>{}</th>", escape(cell));
    }
    html.push_str("</tr></thead><tbody>");
    for row in rows {
        html.push_str("<tr>");
        for cell in row {
            let _ = write!(html, "<td>{}</td>", escape(&cell));
        }
        html.push_str("</tr>");
    }
    html.push_str("</tbody></table>\n");
}
