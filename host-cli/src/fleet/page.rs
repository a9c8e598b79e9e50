//! The page of a fleet: what is found, every parameter over time, every campaign.

use std::fmt::Write;

use findings::quantity::{interval_in_unit, value_with_sigma};
use robot_model::fleet::RobotJudged;

use super::{Fleet, Kind, drawing, places, words};
use crate::calibration_page::drawing::{COLOURS, STYLE};
use crate::calibration_page::page::PAGE_STYLE;
use crate::escape::html as escape;

const FLEET_STYLE: &str = "\
.pair{display:grid;grid-template-columns:repeat(2,minmax(0,1fr));gap:14px}.pair svg{margin:0}\
@media(max-width:820px){.pair{grid-template-columns:1fr}}\
figure{margin:0;border:1px solid var(--faint);border-radius:10px;padding:12px 12px 8px;break-inside:avoid}\
figcaption{font-size:14px;color:var(--soft);display:flex;flex-wrap:wrap;justify-content:space-between;gap:0 10px;margin-bottom:6px}\
figcaption b{color:var(--ink);font-weight:650}.thin .p{stroke-width:1.5}.d .tick{font-size:12px}\
.zero{stroke:var(--line);stroke-width:1.2;fill:none}.noise{fill:var(--faint);opacity:.6}.whisker{stroke-width:1.2;fill:none}\
.n0{stroke:var(--line);opacity:.75}.fn0{fill:var(--line);stroke:none}.fa,.fb{stroke:none}\
.found{list-style:none;padding:0;margin:14px 0 0;max-width:52em}.found li{border-left:4px solid var(--line);padding:4px 0 4px 16px;margin:10px 0;display:flex;gap:14px}\
.found .wears,.found .drifts{border-color:var(--before)}.found .unlike{border-color:var(--after)}\
.found b{flex:0 0 4.6em;font-weight:650}\
.legend{display:flex;flex-wrap:wrap;gap:6px 22px;color:var(--soft);font-size:14px;margin:0 0 12px}\
.legend i{display:inline-block;width:22px;height:0;border-top:3px solid;vertical-align:middle;margin-right:7px}\
.legend i.b{border-color:var(--before)}.legend i.a{border-color:var(--after)}.legend i.k{border-color:var(--line)}\
.legend i.n{border-color:var(--faint);border-top-width:12px}\
.wide{overflow-x:auto}.verdicts td{vertical-align:top;text-align:left}.verdicts th{text-align:left}\
.verdicts td.num,.verdicts th.num{text-align:right;white-space:nowrap}.verdicts td:first-child,.verdicts td.date{white-space:nowrap}";

/// Of more campaigns only those with the largest errors are listed; the table for programs has all.
const LISTED_MAX: usize = 200;

/// The page.
pub fn page(fleet: &Fleet) -> String {
    let campaigns: usize = fleet.kinds.iter().map(|kind| kind.campaigns.len()).sum();
    let robots: usize = fleet.kinds.iter().map(|kind| kind.robots.len()).sum();
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <title>Fleet</title>\n<style>{COLOURS}\n{STYLE}\n{PAGE_STYLE}\n{FLEET_STYLE}</style></head>\n<body>\n\
         <p class=\"sub\">{}, {}</p>\n<h1>{}</h1>\n",
        counted(robots, "robot"),
        counted(campaigns, "campaign"),
        title(fleet)
    );
    findings(&mut html, fleet);
    for kind in &fleet.kinds {
        of_kind(&mut html, kind);
    }
    if !fleet.left_out.is_empty() {
        html.push_str("<h2>Left out</h2>\n<ul>\n");
        for (folder, why) in &fleet.left_out {
            let folder = escape(&folder.to_string_lossy());
            let _ = writeln!(html, "<li>{folder}: {}</li>", escape(why));
        }
        html.push_str("</ul>\n");
    }
    let bars = match fleet.kinds.iter().any(Kind::is_comparable) {
        true => " Bars are 95 % intervals.",
        false => "",
    };
    let _ = write!(
        html,
        "<footer>All campaigns of a kind are fitted with the same effects.{bars} What is said to be there has a \
         false discovery rate below 1 %, over all questions of this page together.</footer>\n</body></html>\n",
    );
    html
}

/// `1 robot`, `3 robots`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn title(fleet: &Fleet) -> String {
    let all = words::findings_of(fleet);
    let robots = |what: &[&str]| {
        let named = all.iter().filter(|one| what.contains(&one.what));
        let mut robots: Vec<_> = named.filter_map(|one| one.robot.as_ref()).collect();
        robots.sort();
        robots.dedup();
        robots.len()
    };
    let (change, unlike) = (robots(&["wears", "drifts"]), robots(&["unlike"]));
    let parts: Vec<String> = [
        (change > 0)
            .then(|| format!("<span class=\"before\">{} changed</span>", counted(change, "robot"))),
        (unlike > 0).then(|| {
            let verb = if unlike == 1 { "is" } else { "are" };
            format!("<span class=\"after\">{unlike} {verb} unlike the others</span>")
        }),
    ]
    .into_iter()
    .flatten()
    .collect();
    match parts.is_empty() {
        true => words::nothing_found(fleet).to_owned(),
        false => parts.join(", "),
    }
}

fn findings(html: &mut String, fleet: &Fleet) {
    let all = words::findings_of(fleet);
    if all.is_empty() {
        return;
    }
    html.push_str("<ul class=\"found\">\n");
    for finding in &all {
        let _ = writeln!(
            html,
            "<li class=\"{0}\"><b>{0}</b><span>{1}</span></li>",
            finding.what,
            escape(&finding.words)
        );
    }
    html.push_str("</ul>\n");
}

fn of_kind(html: &mut String, kind: &Kind) {
    let _ = writeln!(
        html,
        "<h2>{}: {}, {}</h2>",
        escape(&kind.name),
        counted(kind.robots.len(), "robot"),
        counted(kind.campaigns.len(), "campaign")
    );
    if kind.is_comparable() {
        legend(html, kind);
        html.push_str("<div class=\"pair\">");
        for parameter in &kind.parameters {
            html.push_str(&drawing::draw(kind, parameter));
        }
        html.push_str("</div>\n");
    } else {
        values(html, kind);
    }
    campaigns(html, kind);
}

/// What is drawn in a kind's drawings, each line that there is.
fn legend(html: &mut String, kind: &Kind) {
    let judged = || kind.parameters.iter().flat_map(|one| &one.judgement.robots);
    let changes = |robot: &RobotJudged| robot.trend.is_some_and(|trend| trend.is_there);
    let all = [
        ("b", "changes with time", judged().any(changes)),
        ("a", "unlike the others", judged().any(|one| one.is_unlike && !changes(one))),
        ("k", "neither", judged().any(|one| !one.is_unlike && !changes(one))),
        ("n", "where most robots of the kind are", kind.robots.len() >= drawing::BAND_ROBOTS_MIN),
    ];
    // One kind of line needs no word.
    let there: Vec<_> = all.into_iter().filter(|(.., is_there)| *is_there).collect();
    if there.len() < 2 {
        return;
    }
    html.push_str("<p class=\"legend\">");
    for (class, words, _) in there {
        let _ = write!(html, "<span><i class=\"{class}\"></i>{words}</span>");
    }
    html.push_str("</p>\n");
}

/// The values of one robot on one day: there is nothing to compare them with, so nothing is drawn.
fn values(html: &mut String, kind: &Kind) {
    html.push_str(
        "<div class=\"wide\"><table class=\"verdicts\"><thead><tr><th>effect</th><th></th><th class=\"num\">value</th>\
         <th class=\"num\">95 %</th></tr></thead><tbody>\n",
    );
    for parameter in &kind.parameters {
        for found in parameter.values.iter().flatten() {
            let (value, sigma, unit) = (found.value, found.sigma, &parameter.unit);
            let _ = writeln!(
                html,
                "<tr><td>{}</td><td>{}</td><td class=\"num\">{}</td><td class=\"num\">{}</td></tr>",
                escape(parameter.effect.facts().name),
                escape(&parameter.name),
                escape(&value_with_sigma(value, sigma, unit)),
                escape(&interval_in_unit(value, sigma, (found.low95, found.high95), unit))
            );
        }
    }
    html.push_str("</tbody></table></div>\n");
}

fn campaigns(html: &mut String, kind: &Kind) {
    let mm =
        |errors: &robot_model::estimation::ErrorPair| 1e3 * errors.cross_validated.position_rms_m;
    let mut listed: Vec<_> = kind.campaigns.iter().collect();
    if listed.len() > LISTED_MAX {
        listed.sort_by(|a, b| mm(&b.errors[0]).total_cmp(&mm(&a.errors[0])));
        listed.truncate(LISTED_MAX);
        let _ = writeln!(
            html,
            "<p class=\"sub\">The {LISTED_MAX} campaigns with the largest errors; --table writes all.</p>"
        );
    }
    html.push_str(
        "<div class=\"wide\"><table class=\"verdicts\"><thead><tr><th>robot</th><th>date</th><th class=\"num\">nominal</th>\
         <th class=\"num\">with all effects</th><th>missing</th></tr></thead><tbody>\n",
    );
    for one in listed {
        let missing =
            if one.missing.is_empty() { "nothing".to_owned() } else { one.missing.join("; ") };
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td class=\"date\">{}</td><td class=\"num\">{:.1} mm</td><td class=\"num\">{:.1} mm</td><td>{}</td></tr>",
            escape(&kind.robots[one.robot]),
            one.dated.days.map_or_else(|| "unknown".to_owned(), places::date),
            mm(&one.errors[0]),
            mm(&one.errors[1]),
            escape(&missing)
        );
    }
    html.push_str("</tbody></table></div>\n");
}
