//! Does the benchmark meet its bars? Shares over many verdicts, and tables of what was missed.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::case::Kind;
use super::hard::Hard;
use super::plant::Plant;
use super::verdict::Verdict;

/// One line of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// The claim.
    pub claim: &'static str,
    /// The measured share or ratio.
    pub measured: f64,
    /// Of how many.
    pub of: usize,
    /// Lowest and highest value that meets it.
    pub within: [f64; 2],
    /// Printed as it is, not in percent.
    pub ratio: bool,
}

impl Bar {
    /// Whether it is met; a bar without cases is.
    pub fn holds(&self) -> bool {
        self.of == 0 || (self.within[0]..=self.within[1]).contains(&self.measured)
    }

    fn number(&self, value: f64) -> String {
        if self.ratio { format!("{value:.3}") } else { format!("{:.1} %", 100.0 * value) }
    }

    fn line(&self) -> String {
        let wanted = match self.within {
            [low, high] if low <= 0.0 => format!("<= {}", self.number(high)),
            [low, high] if high >= 1.0 && !self.ratio => format!(">= {}", self.number(low)),
            [low, high] => format!("{} to {}", self.number(low), self.number(high)),
        };
        let verdict = if self.of == 0 {
            "-"
        } else if self.holds() {
            "holds"
        } else {
            "MISSED"
        };
        let measured = if self.of == 0 { "-".to_owned() } else { self.number(self.measured) };
        format!("{:<52} {wanted:>18} {measured:>9} {:>5}  {verdict}", self.claim, self.of)
    }
}

/// The share of these verdicts for which `is` holds, and their number.
fn share<'a>(of: impl Iterator<Item = &'a Verdict>, is: impl Fn(&Verdict) -> bool) -> (f64, usize) {
    let (mut all, mut hits) = (0, 0);
    for verdict in of {
        all += 1;
        hits += usize::from(is(verdict));
    }
    (hits as f64 / f64::from(u32::try_from(all).unwrap_or(u32::MAX)).max(1.0), all)
}

/// The bars of the benchmark.
///
/// A campaign whose effect stands out by less than half of what is required, or by more than twice, counts in none
/// of the first eight; it is listed by [`too_weak`].
pub fn bars(all: &[Verdict]) -> Vec<Bar> {
    let verdicts: &Vec<Verdict> =
        &all.iter().filter(|verdict| verdict.as_strong_as_required()).cloned().collect();
    let of = |kinds: &'static [Kind]| {
        verdicts.iter().filter(move |verdict| kinds.contains(&verdict.case.kind))
    };
    let covered: Vec<bool> = verdicts
        .iter()
        .flat_map(|verdict| verdict.covered.iter().map(|interval| interval.1))
        .collect();
    let coverage = covered.iter().filter(|hit| **hit).count() as f64 / covered.len().max(1) as f64;
    let named = of(&[Kind::Outside]).filter_map(Verdict::regressor_named).collect::<Vec<_>>();
    let regressor = named.iter().filter(|hit| **hit).count() as f64 / named.len().max(1) as f64;
    let ratios = ratios(verdicts);
    let mut bars = vec![
        bar(
            "one effect, medium and strong: named, or in its class",
            share(of(&[Kind::Medium, Kind::Strong]), Verdict::good),
            [0.95, 1.0],
        ),
        bar("one effect, weak: the same", share(of(&[Kind::Weak]), Verdict::good), [0.80, 1.0]),
        bar("two effects: both", share(of(&[Kind::Two]), Verdict::good), [0.85, 1.0]),
        bar(
            "nothing, or nuisances only: false alarm",
            share(of(&[Kind::Nothing, Kind::Nuisance]), Verdict::false_alarm),
            [0.0, 0.05],
        ),
        bar(
            "outside the catalogue: flagged, or as good as the truth",
            share(of(&[Kind::Outside]), Verdict::good),
            [0.90, 1.0],
        ),
        bar("  flagged: a right regressor named", (regressor, named.len()), [0.80, 1.0]),
        bar("95 % intervals: cover", (coverage, covered.len()), [0.90, 0.98]),
        Bar {
            claim: "cross-validated error over truth's, 95 of 100",
            measured: quantile(&ratios, 0.95),
            of: ratios.len(),
            within: [0.0, 1.15],
            ratio: true,
        },
    ];
    bars.extend(bars_of_unknown_robots(all));
    bars
}

/// A bar that is no ratio.
const fn bar(claim: &'static str, (measured, of): (f64, usize), within: [f64; 2]) -> Bar {
    Bar { claim, measured, of, within, ratio: false }
}

/// The bars of a robot that nobody has described: that nothing is passed over in silence, that the reachable error is the
/// noise, that only what is there and matters is called worth correcting, that wrong numbers and clocks are named.
///
/// Silence and the reachable error count in every campaign, however strong what it hides came out.
fn bars_of_unknown_robots(verdicts: &[Verdict]) -> Vec<Bar> {
    let sound = |verdict: &&Verdict| verdict.case.effects.is_empty();
    // Outside the catalogue a substitute may be right: that has its own bar.
    let hiding = |verdict: &&Verdict| {
        !sound(verdict) && verdict.case.kind != Kind::Outside && verdict.as_strong_as_required()
    };
    let geometry = |verdict: &&Verdict| verdict.geometry_named().is_some();
    let clock = |verdict: &&Verdict| verdict.case.hard == Hard::Clock;
    vec![
        bar(
            "something hidden: 1.4 times the noise left, no flag",
            share(verdicts.iter().filter(|verdict| verdict.hides()), Verdict::silent),
            [0.0, 0.02],
        ),
        bar(
            "floor within 15 % of the noise",
            share(verdicts.iter(), Verdict::reachable_is_right),
            [0.95, 1.0],
        ),
        bar(
            "sound robots: nothing worth correcting, no flag",
            share(verdicts.iter().filter(sound), Verdict::worth_nothing),
            [0.98, 1.0],
        ),
        bar(
            "hiding: worth correcting, and not there",
            share(verdicts.iter().filter(hiding), |verdict| !verdict.extra_matters.is_empty()),
            [0.0, 0.05],
        ),
        bar(
            "wrong data sheet: radius, ratio and track named",
            share(verdicts.iter().filter(geometry), |verdict| {
                verdict.geometry_named() == Some(true)
            }),
            [0.95, 1.0],
        ),
        bar(
            "clock off: told to 10 ms",
            share(verdicts.iter().filter(clock), |verdict| verdict.clock_found == Some(true)),
            [0.95, 1.0],
        ),
    ]
}

/// Cross-validated error over that of the fit that knows the truth, where there is one.
fn ratios(verdicts: &[Verdict]) -> Vec<f64> {
    // A robot that hides nothing has a ratio of one unless something is found in it.
    let inside = verdicts
        .iter()
        .filter(|verdict| verdict.case.kind != Kind::Outside && !verdict.case.effects.is_empty());
    // A ratio that is not a number counts against the answer.
    let number = |ratio: f64| if ratio.is_finite() { ratio } else { f64::INFINITY };
    let mut ratios: Vec<f64> =
        inside.map(|verdict| number(verdict.cross_validated_ratio)).collect();
    ratios.sort_by(f64::total_cmp);
    ratios
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    sorted[(share * last as f64).ceil() as usize]
}

/// The bars as a table.
pub fn table(bars: &[Bar]) -> String {
    let head = format!("{:<52} {:>18} {:>9} {:>5}\n", "", "bar", "measured", "of");
    head + &bars.iter().map(|bar| bar.line() + "\n").collect::<String>()
}

/// What a case hides, by name.
pub fn ids(verdict: &Verdict) -> Vec<&'static str> {
    verdict.case.effects.iter().map(|effect| effect.id()).collect()
}

/// For each hidden effect what was found, most frequent first; classes by their first member.
pub fn confusion(verdicts: &[Verdict]) -> String {
    let mut rows: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    let hidden = |verdict: &Verdict| match verdict.case.effects.len() {
        0 => "(nothing)".to_owned(),
        _ => ids(verdict).join(" + "),
    };
    for verdict in verdicts.iter().filter(|verdict| verdict.case.kind != Kind::Two) {
        let row = rows.entry(hidden(verdict)).or_default();
        let mut add = |name: String| *row.entry(name).or_default() += 1;
        if verdict.found.is_empty() {
            add("nothing".into());
        }
        for class in &verdict.found {
            let right = class.iter().find(|id| ids(verdict).contains(&id.as_str()));
            match (right, class.len()) {
                (Some(_), 1) => add("itself".into()),
                (Some(_), n) => add(format!("a class of {n}")),
                (None, _) => add(class[0].clone()),
            }
        }
        if verdict.flagged {
            add("flag".into());
        }
    }
    let mut text = format!("{:<26} what was found (times)\n", "hidden");
    for (hidden, row) in rows {
        let mut found: Vec<(String, usize)> = row.into_iter().collect();
        found.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let found: Vec<String> = found.iter().map(|(name, n)| format!("{name} {n}")).collect();
        let _ = writeln!(text, "{hidden:<26} {}", found.join(", "));
    }
    text
}

/// Cases whose effect does not stand out as required, a line each.
pub fn too_weak(verdicts: &[Verdict]) -> String {
    let mut text = String::new();
    for verdict in verdicts.iter().filter(|verdict| !verdict.as_strong_as_required()) {
        let reached: Vec<String> =
            verdict.reached.iter().map(|sigmas| format!("{sigmas:.1}")).collect();
        let ids = ids(verdict).join(", ");
        let wanted = match (verdict.case.kind, verdict.case.plant) {
            (Kind::Outside, Plant::Kinematic) => "3 to 10 times the noise".to_owned(),
            (kind, _) => format!("{} sigma", kind.sigmas().unwrap_or(0.0)),
        };
        let _ = writeln!(
            text,
            "  case {:<4} {:<9} {:<8} [{ids}] at [{}] of {wanted}",
            verdict.case.index,
            verdict.case.plant.name(),
            verdict.case.hard.name(),
            reached.join(", ")
        );
    }
    text
}

/// Every case that misses a bar, a line each.
pub fn misses(verdicts: &[Verdict]) -> String {
    let mut text = String::new();
    for verdict in verdicts {
        let wrong = faults(verdict);
        if wrong.is_empty() {
            continue;
        }
        let found = verdict.found.iter().zip(&verdict.matters);
        // What is worth correcting is marked.
        let found: Vec<String> = found
            .map(|(class, matters)| class.join("|") + if *matters { "!" } else { "" })
            .collect();
        let reached: Vec<String> =
            verdict.reached.iter().map(|sigmas| format!("{sigmas:.0}")).collect();
        let flag = match verdict.flagged {
            true => format!(", flag on {}", verdict.depends_on.join(", ")),
            false => String::new(),
        };
        let case = &verdict.case;
        let _ = writeln!(
            text,
            "  case {:<4} seed {:<11} {:<9} {:<8} {:<12} hidden [{}] at [{}]: found [{}]{flag}; {}",
            case.index,
            case.seed,
            case.plant.name(),
            case.hard.name(),
            case.kind.name(),
            ids(verdict).join(", "),
            reached.join(", "),
            found.join(", "),
            wrong.join("; "),
        );
    }
    text
}

/// What is wrong with an answer; nothing if it meets all bars.
fn faults(verdict: &Verdict) -> Vec<String> {
    let mut faults = Vec::new();
    let ratio = verdict.cross_validated_ratio;
    let outside = verdict.case.kind == Kind::Outside;
    if verdict.as_strong_as_required() {
        if !verdict.good() {
            faults.push("MISSED".to_owned());
        }
        // An error that is not a number is too large.
        let close = ratio <= 1.15;
        if (!outside && !close) || (outside && !verdict.good()) {
            faults.push(format!("cross-validated {ratio:.3} of the truth's"));
        }
        if verdict.regressor_named() == Some(false) {
            faults.push(format!("depends on {}", verdict.regressors.join(" or ")));
        }
        let uncovered: Vec<&str> = verdict
            .covered
            .iter()
            .filter(|interval| !interval.1)
            .map(|interval| interval.0.as_str())
            .collect();
        if !uncovered.is_empty() {
            faults.push(format!("outside its interval: {}", uncovered.join(", ")));
        }
        if !verdict.case.effects.is_empty() && !outside && !verdict.extra_matters.is_empty() {
            let each = verdict.extra_matters.iter();
            let each: Vec<String> =
                each.map(|(id, times)| format!("{id} by {times:.1} tolerances")).collect();
            faults.push(format!("worth correcting, and not there: {}", each.join(", ")));
        }
    }
    if let Some(why) = &verdict.refused {
        faults.push(format!("REFUSED: {}", why.lines().next().unwrap_or_default()));
    }
    if verdict.silent() {
        faults.push(format!("SILENT at {:.2} times the noise", verdict.over_noise));
    }
    if verdict.case.effects.is_empty() && !verdict.worth_nothing() {
        faults.push("worth correcting, or flagged".to_owned());
    }
    if !verdict.reachable_is_right() {
        faults.push(format!("floor {:.2} of the noise", verdict.reachable_ratio));
    }
    if verdict.geometry_named() == Some(false) {
        faults.push("the wrong data sheet is not named".to_owned());
    }
    if verdict.case.hard == Hard::Clock && verdict.clock_found != Some(true) {
        faults.push("the clock is not told".to_owned());
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_holds_at_its_edges_and_not_beyond() {
        let bar = |measured, within| Bar { claim: "", measured, of: 9, within, ratio: false };
        assert!(bar(0.95, [0.95, 1.0]).holds() && !bar(0.94, [0.95, 1.0]).holds());
        assert!(bar(0.05, [0.0, 0.05]).holds() && !bar(0.06, [0.0, 0.05]).holds());
        assert!(!bar(f64::NAN, [0.0, 1.0]).holds());
        assert!(Bar { of: 0, ..bar(f64::NAN, [0.0, 1.0]) }.holds());
    }
}
