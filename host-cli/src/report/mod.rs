//! The page of a campaign: one self-contained HTML file with everything that `explain` and `compare` say.
//!
//! | section | file |
//! | --- | --- |
//! | paths, measured and predicted | `paths.rs` |
//! | the cross-validated error as effects are added | `waterfall.rs` |
//! | each effect: evidence, values with intervals, remedy | `effects.rs` |
//! | where the error comes from, before and after | `regimes.rs` |
//! | the residuals against each variable | `curves.rs` |
//! | the place on the floor that it depends on | `floor.rs` |
//! | two of these as one picture | `drawing.rs` |
//! | what all of them need | `campaign_report.rs` |
//!
//! Nothing in it comes from the network, and nothing in it runs. The same campaign gives the same bytes.

mod campaign_report;
mod curves;
mod drawing;
mod effects;
mod floor;
mod paths;
mod regimes;
#[cfg(test)]
mod tests;
mod waterfall;

use std::fmt::Write;

use robot_model::explain::Answer;

use crate::calibration_page::drawing::{COLOURS, STYLE};
use crate::calibration_page::page::PAGE_STYLE;
use crate::escape::html as escape;
use crate::explain::{
    errors_text, gyro_words, headline, next_run_command, no_next_run, on_held_out,
};
use crate::words;

pub use campaign_report::CampaignReport;
pub use drawing::to_svg;

use campaign_report::before;

/// How the parts of a report look.
pub(crate) const REPORT_STYLE: &str = "\
.grid{display:grid;grid-template-columns:repeat(3,minmax(0,1fr));gap:14px}.grid svg{margin:0}\
.grid figure,.pair figure{margin:0;border:1px solid var(--faint);border-radius:10px;padding:12px 12px 8px;break-inside:avoid}\
.pair{display:grid;grid-template-columns:repeat(2,minmax(0,1fr));gap:14px}.pair svg{margin:0}\
h1{text-wrap:balance}figcaption{font-size:14px;color:var(--soft);display:flex;flex-wrap:wrap;justify-content:space-between;gap:0 10px;\
margin-bottom:6px;align-items:baseline}figcaption b{flex-basis:100%;color:var(--ink);font-weight:650;overflow-wrap:anywhere}\
figcaption span{white-space:nowrap}\
.legend{display:flex;flex-wrap:wrap;gap:6px 22px;color:var(--soft);font-size:14px;margin:0 0 12px}\
.legend i{display:inline-block;width:22px;height:0;border-top:3px solid;vertical-align:middle;margin-right:7px}\
.legend i.k{border-color:var(--line);border-top-width:6px;border-radius:3px}.legend i.b{border-color:var(--before)}.legend i.a{border-color:var(--after)}\
.card{border:1px solid var(--faint);border-radius:12px;padding:18px 22px 16px;margin:14px 0;break-inside:avoid}\
.card h3{margin:0 0 2px;font-size:18px;font-weight:650}.card h3 .n{color:var(--after);margin-right:10px}\
.card p{margin:8px 0 0}.card code,.next code{font:14px ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;color:var(--soft)}\
.class{border-left:4px solid var(--before);padding:2px 0 2px 14px;margin-top:12px}\
.lead{font-size:19px;line-height:1.45;max-width:40em}.next{border-left:4px solid var(--after);padding:4px 0 4px 18px}\
.next code{display:inline-block;padding:8px 12px;border:1px solid var(--faint);border-radius:8px;color:var(--ink);margin-top:6px;overflow-wrap:anywhere}\
.ids{color:var(--soft);font-size:14px}.rej td{vertical-align:top;text-align:left}.rej td:last-child,.rej th:last-child{text-align:right;white-space:nowrap}\
.rej th{text-align:left}.way{stroke:var(--line);stroke-opacity:.35}.named{paint-order:stroke;stroke:var(--paper);stroke-width:4px;stroke-linejoin:round}.noise{fill:var(--faint);opacity:.6}.whisker{stroke-width:1.3;fill:none}\
.only-narrow{display:none}\
@media screen and (max-width:640px){.only-wide{display:none}.only-narrow{display:block}\
.d.only-narrow text{font-size:13px}.d.only-narrow .tick{font-size:12px}.wide{overflow-x:auto}.wide svg{width:760px}.wide .d text{font-size:13px}}\
@media(max-width:820px){.grid{grid-template-columns:1fr 1fr}.pair{grid-template-columns:1fr}}\
@media(max-width:520px){.grid{grid-template-columns:1fr}}\
@media print{p,li{orphans:3;widows:3}tr,.next{break-inside:avoid}thead{display:table-header-group}.lead{font-size:15px}figcaption{font-size:11px}.grid{grid-template-columns:repeat(3,minmax(0,1fr))}.pair{grid-template-columns:repeat(2,minmax(0,1fr))}.card{padding:12px 16px}h2{break-after:avoid}}";

/// How the lines of this page's drawings look, beyond those of a calibration's.
pub(crate) const DRAWING_STYLE: &str = "\
.seen{fill:none;stroke:var(--line);stroke-width:5;stroke-opacity:.55;stroke-linecap:round;stroke-linejoin:round}\
.thin .p{stroke-width:1.7}.zero{stroke:var(--line);stroke-width:1.2;fill:none}\
.d .tick{font-size:12px}.d .q{font-size:13px;font-weight:650;fill:var(--ink)}";

/// What the bars are, and over which runs.
fn what_bars_show(report: &CampaignReport<'_>) -> String {
    let runs = match (report.context.runs.len(), &report.answer.set_aside) {
        (1, _) => {
            return "There is only one run: it is predicted by a fit to itself, and nothing can be cross-validated. Bars \
                are root mean squares over the run; p is the probability that chance alone does as well."
                .to_owned();
        }
        (_, None) => "all runs",
        (_, Some(_)) => "all runs but those left out",
    };
    format!(
        "Each run is predicted by a fit to all the others (cross-validation), and what no other run shows by a fit \
        to the rest of the run, so an effect gains nothing by overfitting. Bars are root mean squares over {runs}; \
        the upright mark is the error of the fit to {runs}, and p is the probability that chance alone does as well as the effect."
    )
}

/// The whole page.
pub fn to_html(report: &CampaignReport<'_>) -> String {
    let robot = escape(report.context.robot);
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <title>{robot}: what is missing</title>\n<style>{COLOURS}\n{STYLE}\n{PAGE_STYLE}\n{DRAWING_STYLE}{REPORT_STYLE}</style></head>\n<body>\n"
    );
    header(&mut html, report, &robot);
    section(&mut html, "The error, effect by effect", &what_bars_show(report));
    html.push_str(&waterfall::draw(report));
    held_out(&mut html, report);
    section(
        &mut html,
        "Measured and predicted",
        "The runs with the largest errors of each kind, from above, with \
        their errors before and after. Deviations are averaged over a twentieth of the run and enlarged by the factor in \
        the corner; the measured path is drawn to scale. Where poses were measured only at the ends of a run, they \
        are dots, and the paths between them are dead reckoning.",
    );
    html.push_str(&paths::draw(report));
    if !report.answer.steps.is_empty() {
        section(&mut html, "What is missing", "");
        html.push_str(&effects::draw(report));
    }
    section(
        &mut html,
        "Where the error comes from",
        "Every run is cut into stretches where the regime changes; each dot \
        is the error over all stretches of one kind, in multiples of what noise alone gives. Within the \
        grey band it is noise. On the right: the error that all stretches of a kind share without the missing effects, \
        per metre of wheel travel, where it is significant.",
    );
    html.push_str(&regimes::draw(report));
    unexplained(&mut html, report);
    advice(&mut html, report);
    rejected(&mut html, report);
    let runs = crate::ui::runs(report.context.runs.len());
    let _ = write!(
        html,
        "\n<footer>{runs}. The start pose of each run is free. \u{b1} is one standard error; intervals contain the truth \
         in 95 % of cases. Model: exact arcs from encoder counts, and the effects named here.</footer>\n</body></html>\n"
    );
    html
}

fn header(html: &mut String, report: &CampaignReport<'_>, robot: &str) {
    let answer = report.answer;
    let last =
        answer.steps.last().map_or(&answer.baseline.cross_validated, |step| &step.cross_validated);
    let mm =
        |errors: &robot_model::estimation::Errors| format!("{:.1} mm", errors.position_rms_m * 1e3);
    let (before, after) = (mm(&answer.baseline.cross_validated), mm(last));
    let title = title(answer);
    let _ = write!(
        html,
        "<p class=\"sub\">{robot} \u{b7} {}</p>\n<h1>{title}",
        crate::ui::runs(report.context.runs.len())
    );
    if !answer.steps.is_empty() {
        let _ = write!(
            html,
            ": <span class=\"before\">{before}</span> without, <span class=\"after\">{after}</span> with"
        );
    }
    let _ = writeln!(
        html,
        "</h1>\n<p class=\"lead\">{}</p>",
        escape(&headline(answer, report.context))
    );
    if !answer.known.is_empty() {
        let known = answer.known.iter().map(|step| report.context.name(&step.effect));
        let names = known.collect::<Vec<_>>().join(", ");
        let _ = writeln!(html, "<p>Already compensated on the robot: {}.</p>", escape(&names));
    }
    let _ =
        writeln!(html, "<p class=\"sub\">{}</p>", escape(&words::finding(report.comparisons[0])));
}

/// The finding in a few words.
fn title(answer: &Answer) -> String {
    let matter = answer.steps.iter().filter(|step| step.is_missing()).count();
    match (matter, answer.unexplained.structure) {
        (0, false) => "Nothing is missing".to_owned(),
        (0, true) => "An unknown effect".to_owned(),
        (1, _) => "One effect is missing".to_owned(),
        (n, _) => format!("{} effects are missing", findings::headline::number_word(n)),
    }
}

fn section(html: &mut String, title: &str, words: &str) {
    let _ = write!(html, "\n<h2>{title}</h2>\n");
    if !words.is_empty() {
        let _ = writeln!(html, "<p class=\"sub\">{words}</p>");
    }
}

/// The errors on held-out runs.
fn held_out(html: &mut String, report: &CampaignReport<'_>) {
    let Some(held_out) = &report.answer.held_out else { return };
    let _ = writeln!(
        html,
        "<p>{}, used neither to fit nor to select: <span class=\"before\">{}</span> \
         for the {}, <span class=\"after\">{}</span> with the missing effects.</p>",
        escape(&on_held_out(held_out).replacen("on", "On", 1)),
        errors_text(&held_out.baseline),
        before(report.answer),
        errors_text(&held_out.model)
    );
}

fn unexplained(html: &mut String, report: &CampaignReport<'_>) {
    let residuals = &report.answer.unexplained;
    let p = escape(&crate::quantity::p_value(residuals.p_value));
    let off = words::runs_off(residuals).map(|text| format!(" <b>{}</b>.", escape(&text)));
    let words = if residuals.structure {
        format!(
            "The residuals depend on <b>{}</b> ({p}), and no candidate effect explains this. \
             An effect that does must have the shape below.{}",
            escape(&words::depends_on(residuals)),
            off.unwrap_or_default()
        )
    } else {
        format!(
            "The residuals depend on none of the variables tested{} ({p}): these curves should lie on zero within their bars.",
            if residuals.slight.is_empty() { "" } else { " by more than a little" }
        )
    };
    section(html, if residuals.structure { "Still unexplained" } else { "Residuals" }, "");
    let again = words::driven_again(residuals).map(|text| format!(" {}", escape(&text)));
    let _ = writeln!(html, "<p>{words}{}</p>", again.unwrap_or_default());
    for found in &residuals.sudden {
        let _ = writeln!(html, "<p>{}</p>", escape(&words::sudden_motion(found)));
    }
    html.push_str(&floor::draw(report).unwrap_or_default());
    html.push_str(
        "<p class=\"sub\">Each drawing shows the error that all runs share, per metre of wheel travel, against one \
         variable. Error bars are 95 % intervals: a curve whose bars all touch zero shows nothing.</p>\n",
    );
    html.push_str(&curves::draw(report));
}

fn advice(html: &mut String, report: &CampaignReport<'_>) {
    section(html, "What to do next", "");
    match &report.answer.next_run {
        Some(next) => {
            let _ = writeln!(
                html,
                "<div class=\"next\"><p><b>Record {}.</b> It tells {} apart: {}. {}</p><code>{}</code></div>",
                escape(next.kind.name()),
                escape(&words::listed(&next.separates)),
                escape(&words::predicted(&next.predicted)),
                escape(gyro_words(next).unwrap_or_default()),
                escape(&next_run_command(next, report.context))
            );
        }
        None => {
            let (words, command) = no_next_run(report.answer, report.context);
            let words = escape(&words);
            let _ = match command {
                Some(command) => writeln!(
                    html,
                    "<div class=\"next\"><p>{words}</p><code>{}</code></div>",
                    escape(&command)
                ),
                None => writeln!(html, "<p>{words}</p>"),
            };
        }
    }
}

fn rejected(html: &mut String, report: &CampaignReport<'_>) {
    if report.answer.rejected.is_empty() {
        return;
    }
    section(
        html,
        "Considered and rejected",
        "-2 log likelihoods are cross-validated unless stated otherwise; a gain below 4 is noise.",
    );
    html.push_str("<table class=\"rej\"><thead><tr><th>effect</th><th>reason</th><th>cross-validated, with it</th></tr></thead><tbody>");
    for rejected in &report.answer.rejected {
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(report.context.name(&rejected.effect)),
            escape(&words::reason(&rejected.reason)),
            errors_text(&rejected.cross_validated)
        );
    }
    html.push_str("</tbody></table>\n");
}
