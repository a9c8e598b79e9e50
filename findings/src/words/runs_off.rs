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

/// What to do if some runs are off by far more than the others, of these: what happened once does not happen again.
pub fn drive_again(unexplained: &Unexplained, runs: &[String]) -> Option<String> {
    let off = &unexplained.runs_off;
    let sound = |once: &&String| {
        let again = |run: &&String| {
            let [first, second] = [once, run].map(|name| without_repetition(plain(name)));
            !off.contains(run) && first == second
        };
        runs.iter().any(|run| again(&run))
    };
    let once: Vec<String> = off.iter().filter(sound).cloned().collect();
    if !once.is_empty() && once.len() == off.len() {
        let was = if once.len() == 1 { "was" } else { "were" };
        return Some(format!(
            "Driven again, {} {was} not off: a wheel slipped or the robot was pushed that once. Move such a run out of \
             the campaign's folder `runs`, or set `held_out = true` for it in robot.toml.",
            some_named(&once)
        ));
    }
    let (is, their) = if off.len() == 1 { ("it is", "its") } else { ("they are", "their") };
    let text = format!(
        "Drive {} again: if {is} off again, {their} motion, load or place is the cause; if not, a wheel slipped \
         or the robot was pushed this once.",
        some_named(off)
    );
    (!off.is_empty()).then_some(text)
}

/// The name of a run that was driven several times: of `spin_2` it is `spin`.
fn without_repetition(name: &str) -> &str {
    let digits = name.trim_end_matches(|c: char| c.is_ascii_digit());
    digits.strip_suffix('_').filter(|_| digits.len() < name.len()).unwrap_or(name)
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
        let again = drive_again(&["loaded"], &["loaded", "spin"]).unwrap();
        assert!(again.starts_with("Drive loaded again: if it is off again, its motion"), "{again}");
        let again = drive_again(&six, &six).unwrap();
        assert!(again.starts_with("Drive a, b, c, d and 2 more again: if they are off"), "{again}");
        let again = drive_again(&["07_spin"], &["06_out", "07_spin", "22_spin_2"]).unwrap();
        assert!(again.starts_with("Driven again, 07_spin was not off"), "{again}");
        let again = drive_again(&["07_spin", "22_spin_2"], &["07_spin", "22_spin_2"]).unwrap();
        assert!(again.starts_with("Drive 07_spin and 22_spin_2 again"), "{again}");
    }
}
