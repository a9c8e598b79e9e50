//! Runs that are off by far more than the others: which they are, what to do, and what the error floor is then.

use robot_model::explain::Answer;
use robot_model::residuals::Unexplained;

use super::listed;

/// Which runs are off by far more than the others, if any are.
pub fn runs_off(unexplained: &Unexplained) -> Option<String> {
    let off = &unexplained.runs_off;
    let are = if off.len() == 1 { "is" } else { "are" };
    let text = format!("{} {are} off by far more than the other runs", some_named(off));
    (!off.is_empty()).then_some(text)
}

/// Which runs the answer is not about, and how far they are off what it is about, if any are set aside.
pub fn set_aside(answer: &Answer) -> Option<String> {
    let errors = answer.set_aside.as_ref()?;
    let off = &answer.unexplained.runs_off;
    let (was, it_is) = if off.len() == 1 { ("was", "it is") } else { ("were", "they are") };
    let size = format!("{:.0} mm", 1e3 * errors.position_rms_m);
    let named = some_named(off);
    Some(format!(
        "{named} {was} left out: {it_is} {size} off the others' model, far more than any of those."
    ))
}

/// What to do about runs that are off by far more than the others.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveAgain {
    /// In a sentence.
    pub words: String,
    /// The runs to be driven again; none if all of them were.
    pub runs: Vec<String>,
}

/// What to do if some of these runs are off by far more than the others: what happened once does not happen again. Runs with the
/// same number in `motions` repeat one another.
pub fn drive_again(
    unexplained: &Unexplained,
    runs: &[String],
    motions: &[usize],
) -> Option<DriveAgain> {
    let off = &unexplained.runs_off;
    let driven = |run: &String| runs.iter().zip(motions).find(|(name, _)| *name == run);
    let has_like = |run: &String, is_off: bool| {
        driven(run).is_some_and(|(_, own)| {
            let mut others = runs.iter().zip(motions).filter(|(name, _)| *name != run);
            others.any(|(name, motion)| motion == own && off.contains(name) == is_off)
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
    use robot_model::estimation::Errors;

    use super::*;
    use crate::empty_answer::nothing_found;

    #[test]
    fn runs_set_aside_are_named_with_how_far_they_are_off() {
        let off = Unexplained { runs_off: vec!["slipped".into()], ..Unexplained::default() };
        let mut answer = Answer { unexplained: off, ..nothing_found() };
        assert_eq!(set_aside(&answer), None);
        let errors = Errors { position_rms_m: 0.0998, ..Errors::default() };
        answer.set_aside = Some(errors);
        let words =
            "slipped was left out: it is 100 mm off the others' model, far more than any of those.";
        assert_eq!(set_aside(&answer).unwrap(), words);
        assert_eq!(answer.runs_set_aside(), 1);
        answer.unexplained.runs_off.push("pushed".into());
        assert!(
            set_aside(&answer).unwrap().starts_with("slipped and pushed were left out: they are")
        );
    }

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
        let runs: Vec<String> = ["01", "loaded"].map(str::to_owned).to_vec();
        assert_eq!(super::drive_again(&off(&[]), &runs, &[0, 1]), None);
    }

    #[test]
    fn what_is_to_be_done_goes_by_what_was_driven_and_not_by_names() {
        let six = ["a", "b", "c", "d", "e", "f"];
        let spins = ["06_out", "07_spin", "22_spin_2"];
        let joy = ["03_joy", "08_joy", "09_joy"];
        for (off, all, motions, words, to_drive) in [
            (
                &["loaded"][..],
                &["loaded", "spin"][..],
                &[0, 1][..],
                "Drive loaded again: if it is off again, its motion",
                1,
            ),
            (
                &six,
                &six,
                &[0, 1, 2, 3, 4, 5],
                "Drive a, b, c, d and 2 more again: if they are off again, their",
                6,
            ),
            (&["07_spin"], &spins, &[0, 1, 1], "Driven again, 07_spin was not off", 0),
            (&spins[1..], &spins, &[0, 1, 1], "07_spin and 22_spin_2 are off each", 0),
            (&["07_spin", "06_out"], &spins, &[0, 1, 1], "Drive 06_out again", 1),
            // Two motions with letters in common, and one motion with two names.
            (&["07_spin"], &spins, &[0, 1, 2], "Drive 07_spin again", 1),
            (&joy[..2], &joy, &[0, 1, 2], "Drive 03_joy and 08_joy again", 2),
            (&["01"], &["01", "anything"], &[0, 0], "Driven again, 01 was not off", 0),
        ] {
            let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
            let unexplained = Unexplained { runs_off: owned(off), ..Unexplained::default() };
            let all: Vec<String> = owned(all);
            let again = drive_again(&unexplained, &all, motions).unwrap();
            assert!(again.words.starts_with(words), "{again:?}");
            assert_eq!(again.runs.len(), to_drive, "{again:?}");
        }
    }
}
