//! Runs that are off by far more than the others: which they are, what to do, and what the error floor is then.

use campaign::recorded::plain;
use robot_model::residuals::Unexplained;

use super::listed;

/// Which runs are off by far more than the others, if any are.
pub fn runs_off(unexplained: &Unexplained) -> Option<String> {
    let off = &unexplained.runs_off;
    let are = if off.len() == 1 { "is" } else { "are" };
    let text = format!("{} {are} off by far more than the other runs", some_named(off));
    (!off.is_empty()).then_some(text)
}

/// What to do about runs that are off by far more than the others.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveAgain {
    /// In a sentence.
    pub words: String,
    /// The runs to be driven again; none if all of them were.
    pub runs: Vec<String>,
}

/// What to do if some of these runs are off by far more than the others: what happened once does not happen again.
pub fn drive_again(unexplained: &Unexplained, runs: &[String]) -> Option<DriveAgain> {
    let off = &unexplained.runs_off;
    let has_like = |run: &String, is_off: bool| {
        let others = runs.iter().filter(|other| *other != run && off.contains(other) == is_off);
        driven(run, runs).is_some_and(|what| {
            others.map(|other| driven(other, runs)).any(|other| other == Some(what))
        })
    };
    let (once, others): (Vec<String>, Vec<String>) =
        off.iter().cloned().partition(|run| has_like(run, false));
    let (each_time, runs): (Vec<String>, Vec<String>) =
        others.into_iter().partition(|run| has_like(run, true));
    let one_of = |names: &[String], one: &'static str, many: &'static str| {
        if names.len() == 1 { one } else { many }
    };
    let words = if !runs.is_empty() {
        format!(
            "Drive {} again: if {} off again, {} motion, load or place is the cause; if not, a wheel slipped or the \
             robot was pushed this once.",
            some_named(&runs),
            one_of(&runs, "it is", "they are"),
            one_of(&runs, "its", "their")
        )
    } else if !once.is_empty() {
        format!(
            "Driven again, {} {} not off: a wheel slipped or the robot was pushed that once. Remove \
             such a run: its file in `runs`, and its [[run]] in robot.toml.",
            some_named(&once),
            one_of(&once, "was", "were")
        )
    } else {
        format!(
            "{} are off each time: their motion, load or place is the cause.",
            some_named(&each_time)
        )
    };
    (!off.is_empty()).then_some(DriveAgain { words, runs })
}

/// What was driven in a run, by its name: in `07_spin`, and in `22_spin_2` if there is the former, `spin`. Of runs that have
/// numbers alone nobody knows.
fn driven<'a>(run: &'a str, runs: &[String]) -> Option<&'a str> {
    let name = plain(run);
    let digits = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let first = digits.strip_suffix('_').filter(|_| digits.len() < name.len());
    let first = first.filter(|first| runs.iter().any(|run| plain(run) == *first));
    Some(first.unwrap_or(name)).filter(|name| !name.is_empty())
}

/// The first few of these names, and how many more there are.
fn some_named(all: &[String]) -> String {
    let (named, more) = all.split_at(all.len().min(RUNS_NAMED));
    let mut names = named.to_vec();
    if !more.is_empty() {
        names.push(format!("{} more", more.len()));
    }
    listed(&names)
}

/// What the error floor is that of.
pub fn error_floor(unexplained: &Unexplained) -> &'static str {
    match unexplained.runs_off.is_empty() {
        true => "error floor: any model at all",
        false => "error floor of the other runs",
    }
}

/// At most so many runs are named.
const RUNS_NAMED: usize = 4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_that_are_off_are_named() {
        let off = |names: &[&str]| {
            let runs_off = names.iter().map(|name| (*name).to_owned()).collect();
            Unexplained { runs_off, ..Unexplained::default() }
        };
        let of = |names: &[&str]| super::runs_off(&off(names));
        let text = |who: &str| Some(format!("{who} off by far more than the other runs"));
        assert_eq!(of(&[]), None);
        assert_eq!(of(&["loaded"]), text("loaded is"));
        assert_eq!(of(&["a", "b"]), text("a and b are"));
        let six = ["a", "b", "c", "d", "e", "f"];
        assert_eq!(of(&six), text("a, b, c, d and 2 more are"));
        let drive_again = |names: &[&str], runs: &[&str]| {
            let runs: Vec<String> = runs.iter().map(|name| (*name).to_owned()).collect();
            super::drive_again(&off(names), &runs)
        };
        assert_eq!(drive_again(&[], &["loaded"]), None);
        for (off, all, words, to_drive) in [
            (
                vec!["loaded"],
                vec!["loaded", "spin"],
                "Drive loaded again: if it is off again, its motion",
                1,
            ),
            (
                six.to_vec(),
                six.to_vec(),
                "Drive a, b, c, d and 2 more again: if they are off again, their",
                6,
            ),
            (
                vec!["07_spin"],
                vec!["06_out", "07_spin", "22_spin_2"],
                "Driven again, 07_spin was not off",
                0,
            ),
            (
                vec!["07_spin", "22_spin_2"],
                vec!["07_spin", "22_spin_2"],
                "07_spin and 22_spin_2 are off each",
                0,
            ),
            (
                vec!["07_spin", "03_arc"],
                vec!["03_arc", "07_spin", "22_spin_2"],
                "Drive 03_arc again",
                1,
            ),
            // These are numbers of a recorder: each may be another motion.
            (vec!["run_1"], vec!["run_1", "run_2", "run_3"], "Drive run_1 again", 1),
            (vec!["01"], vec!["01", "02", "03"], "Drive 01 again", 1),
        ] {
            let again = drive_again(&off, &all).unwrap();
            assert!(again.words.starts_with(words), "{again:?}");
            assert_eq!(again.runs.len(), to_drive, "{again:?}");
        }
    }
}
