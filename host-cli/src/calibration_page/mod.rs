//! The picture of a calibration: one self-contained HTML file, or the drawing alone as SVG.
//!
//! It loads nothing from the network, and has no script. The same report gives the same bytes. What
//! the report says is left to [`crate::calibrate`].

mod calibration_report;
pub(crate) mod drawing;
pub(crate) mod page;
pub(crate) mod scale;
#[cfg(test)]
mod tests;

pub use calibration_report::{
    Basis, CalibrationReport, EndReading, PathSource, ProfileNumbers, RunReport,
};

/// The whole report as one HTML file that needs nothing else: no network, no script.
pub fn to_html(report: &CalibrationReport) -> String {
    page::page(report)
}

/// Only the drawing of both paths, as a stand-alone SVG file.
pub fn to_svg(report: &CalibrationReport) -> String {
    let head = format!(
        "<title>{}</title><style>{}{}</style><rect width=\"100%\" height=\"100%\" rx=\"12\" style=\"fill:var(--paper)\"/>",
        crate::escape::html(&report.robot_name),
        drawing::COLOURS,
        drawing::STYLE
    );
    drawing::plan_view(report, " xmlns=\"http://www.w3.org/2000/svg\" width=\"960\"", &head) + "\n"
}
