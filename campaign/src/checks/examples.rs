//! Each check, on an example campaign with one planted mistake.

use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::recorded::{Campaign, Run};
use crate::to_recording::Recordings;

/// A change of a run's rows.
type Mutation = fn(&mut Run);

fn of_counts(run: &mut Run, change: impl Fn(f64, f64) -> (f64, f64)) {
    for row in &mut run.rows {
        if let (Some(left), Some(right)) = (row.counts.left, row.counts.right) {
            let (left, right) = change(left, right);
            (row.counts.left, row.counts.right) = (Some(left), Some(right));
        }
    }
}

fn of_positions(run: &mut Run, change: impl Fn(f64, f64) -> (f64, f64)) {
    for row in &mut run.rows {
        if let (Some(x_m), Some(y_m)) = (row.x_m, row.y_m) {
            let (x_m, y_m) = change(x_m, y_m);
            (row.x_m, row.y_m) = (Some(x_m), Some(y_m));
        }
    }
}

fn of_headings(run: &mut Run, change: impl Fn(f64) -> f64) {
    run.rows.iter_mut().for_each(|row| row.heading_rad = row.heading_rad.map(&change));
}

/// Changes the rows from a share of the run on.
fn from(run: &mut Run, share: f64, change: impl FnMut(&mut crate::row::Row)) {
    let k = (share * run.rows.len() as f64) as usize;
    run.rows[k..].iter_mut().for_each(change);
}

fn wrap(run: &mut Run) {
    let start = run.rows[run.rows.len() / 2].counts.right.unwrap_or(0.0);
    of_counts(run, |left, right| (left, (right - start).rem_euclid(65_536.0)));
}

fn reset(run: &mut Run) {
    let mut first = None;
    from(run, 0.5, |row| {
        if let (Some(left), Some(right)) = (row.counts.left, row.counts.right) {
            let (from_left, from_right) = *first.get_or_insert((left, right));
            (row.counts.left, row.counts.right) =
                (Some(left - from_left), Some(right - from_right));
        }
    });
}

fn jump(run: &mut Run) {
    from(run, 0.5, |row| {
        row.x_m = row.x_m.map(|x| x + 0.08);
        row.y_m = row.y_m.map(|y| y - 0.09);
    });
}

fn frozen(run: &mut Run) {
    let mut held = None;
    from(run, 0.33, |row| {
        let pose = (row.x_m, row.y_m, row.heading_rad);
        if row.x_m.is_some() && held.is_none() {
            held = Some((row.t_s, pose));
        }
        if let (Some((since_s, pose)), true) = (held, row.x_m.is_some())
            && row.t_s < since_s + 6.0
        {
            (row.x_m, row.y_m, row.heading_rad) = pose;
        }
    });
}

fn glitch(run: &mut Run) {
    let k = run.rows.len() / 3;
    if let Some(row) = run.rows[k..].iter_mut().find(|row| row.x_m.is_some()) {
        row.x_m = row.x_m.map(|x| x + 0.5);
    }
}

fn held_counts(run: &mut Run) {
    let mut held = (f64::NEG_INFINITY, run.rows[0].counts);
    for row in &mut run.rows {
        if row.counts.left.is_none() {
            continue;
        }
        if row.t_s - held.0 >= 0.2499 {
            held = (row.t_s, row.counts);
        }
        row.counts = held.1;
    }
}

fn misread(run: &mut Run) {
    if let Some(row) = run.rows.iter_mut().rfind(|row| row.heading_rad.is_some()) {
        row.heading_rad = row.heading_rad.map(|heading| heading + FRAC_PI_2);
    }
}

fn nothing(_: &mut Run) {}

/// An example, read once: every other run of its 21, and the one that is changed alone.
struct Example {
    folder: PathBuf,
    campaign: Campaign,
    /// A part of the name of the run that is changed alone.
    alone: &'static str,
}

impl Example {
    fn read(name: &str, alone: &'static str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name);
        let mut campaign = Campaign::read(&folder).unwrap();
        let mut index = 0;
        campaign.runs.retain(|run| {
            index += 1;
            index % 2 == 1 || run.name.contains(alone)
        });
        Self { folder, campaign, alone }
    }

    fn simulated() -> &'static Self {
        static EXAMPLE: OnceLock<Example> = OnceLock::new();
        EXAMPLE.get_or_init(|| Self::read("mystery-robot", "12_arc_small_fast_left"))
    }

    fn real() -> &'static Self {
        static EXAMPLE: OnceLock<Example> = OnceLock::new();
        EXAMPLE.get_or_init(|| Self::read("optiodom", "square_231220200029_04"))
    }
}

/// What is said of an example whose runs are changed: its error, else its warnings.
fn said(example: &Example, run: Option<&str>, headings: bool, mutation: Mutation) -> String {
    let folder = &example.folder;
    let mut campaign = example.campaign.clone();
    for changed in &mut campaign.runs {
        if run.is_none_or(|run| changed.name.contains(run)) {
            mutation(changed);
        }
        if !headings {
            changed.rows.iter_mut().for_each(|row| row.heading_rad = None);
        }
    }
    let recordings = Recordings::of(&campaign);
    let warnings = recordings.warnings(&campaign, folder);
    match recordings.into_model(&campaign, folder) {
        Err(error) => error.to_string(),
        Ok(_) => warnings.iter().map(|warning| format!("{warning}\n")).collect(),
    }
}

#[test]
fn a_heading_marker_that_sits_crooked_is_taken_out_and_refuses_no_campaign() {
    let turn: Mutation = |run| {
        let headings = run.rows.iter_mut().filter_map(|row| row.heading_rad.as_mut());
        headings.for_each(|heading_rad| *heading_rad += 0.12);
    };
    for example in [Example::simulated(), Example::real()] {
        let said = said(example, None, true, turn);
        assert!(said.contains("the heading marker is mounted at an angle"), "{said}");
        let headings = |campaign: &Campaign| -> Vec<f64> {
            let recordings = Recordings::of(campaign);
            let poses = recordings.runs.iter().flat_map(|run| &run.measured_poses);
            poses.filter_map(|pose| pose.heading_rad).collect()
        };
        let mut turned = example.campaign.clone();
        turned.runs.iter_mut().for_each(turn);
        for (as_it_was, corrected) in headings(&example.campaign).iter().zip(headings(&turned)) {
            assert!((as_it_was - corrected).abs() < 0.01, "{as_it_was} and {corrected}");
        }
    }
}

/// What is done, what is said of it with headings and without, and whether it can be wrong in all runs.
const CASES: [(&str, Mutation, &str, Option<&str>, bool); 24] = [
    ("nothing", nothing, "", Some(""), true),
    (
        "exchanged",
        |run| of_counts(run, |left, right| (right, left)),
        "left_counts and right_counts are exchanged",
        Some("left_counts and right_counts are exchanged"),
        true,
    ),
    (
        "left",
        |run| of_counts(run, |left, right| (-left, right)),
        "left_counts has the wrong sign",
        Some("left_counts has the wrong sign"),
        true,
    ),
    (
        "right",
        |run| of_counts(run, |left, right| (left, -right)),
        "right_counts has the wrong sign",
        Some("right_counts has the wrong sign"),
        true,
    ),
    (
        "both",
        |run| of_counts(run, |left, right| (-left, -right)),
        "both have the wrong sign",
        Some("both have the wrong sign"),
        true,
    ),
    (
        "y",
        |run| of_positions(run, |x, y| (x, -y)),
        "y_m has the wrong sign",
        Some("y_m has the wrong sign"),
        true,
    ),
    ("x", |run| of_positions(run, |x, y| (-x, y)), "x_m has the wrong sign", None, true),
    ("x y", |run| of_positions(run, |x, y| (y, x)), "x_m and y_m are exchanged", None, true),
    ("clockwise", |run| of_headings(run, |rad| -rad), "heading_rad counts clockwise (", None, true),
    (
        "degrees",
        |run| of_headings(run, f64::to_degrees),
        "heading_rad looks like degrees (",
        None,
        true,
    ),
    (
        "+ 90",
        |run| of_headings(run, |rad| rad + FRAC_PI_2),
        "give heading_rad - pi/2 in place",
        None,
        true,
    ),
    (
        "+ 40",
        |run| of_headings(run, |rad| rad + 0.7),
        "heading_rad is turned (+40 degrees)",
        None,
        true,
    ),
    (
        "compass",
        |run| of_headings(run, |rad| FRAC_PI_2 - rad),
        "give pi/2 - heading_rad in place",
        None,
        true,
    ),
    (
        "millimetres",
        |run| of_positions(run, |x, y| (1e3 * x, 1e3 * y)),
        "x_m and y_m look like millimetres",
        Some("x_m and y_m look like millimetres"),
        true,
    ),
    (
        "half",
        |run| of_counts(run, |left, right| (left / 2.0, right / 2.0)),
        "left_counts and right_counts should be 2.0 times as large",
        Some("left_counts and right_counts should be 2.0 times as large"),
        false,
    ),
    (
        "left times 4",
        |run| of_counts(run, |left, right| (4.0 * left, right)),
        "left_counts should be 4.0 times smaller",
        Some("left_counts should be 4.0 times smaller"),
        true,
    ),
    (
        "wrap",
        wrap,
        "its 16-bit counter wrapped around",
        Some("its 16-bit counter wrapped around"),
        false,
    ),
    (
        "wrap once",
        |run| from(run, 0.5, |row| row.counts.left = row.counts.left.map(|left| left + 65_536.0)),
        "its 16-bit counter wrapped around",
        Some("its 16-bit counter wrapped around"),
        false,
    ),
    (
        "one wrong count",
        |run| {
            let k = run.rows.len() / 2;
            if let Some(row) = run.rows[k..].iter_mut().find(|row| row.counts.left.is_some()) {
                row.counts.left = row.counts.left.map(|left| left + 66_000.0);
            }
        },
        "a row is corrupt",
        Some("a row is corrupt"),
        false,
    ),
    (
        "reset",
        reset,
        "restart from zero in the middle of the run",
        Some("restart from zero in the middle"),
        false,
    ),
    ("jump", jump, "the tracker jumps by 0.12 m", Some("the tracker jumps by 0.12 m"), false),
    (
        "frozen",
        frozen,
        "the tracker is frozen: from here to line ",
        Some("the tracker is frozen"),
        false,
    ),
    (
        "glitch",
        glitch,
        "m off those before and after it",
        Some("m off those before and after it"),
        false,
    ),
    ("misread", misread, "the run ends 9", None, false),
];

/// Checks the table, done to the one run or to all.
fn check_table(example: &Example, run: Option<&str>) {
    let mut wrong = Vec::new();
    for (name, mutation, with, without, of_all) in CASES {
        if run.is_none() && !of_all {
            continue;
        }
        for (headings, expected) in [(true, Some(with)), (false, without)] {
            let Some(expected) = expected else { continue };
            let said = said(example, run, headings, mutation);
            let is_one = said.matches('\n').count() <= 1;
            let place = run.is_none_or(|run| said.is_empty() || said.contains(run));
            let right = if expected.is_empty() { said.is_empty() } else { said.contains(expected) };
            if !(right && is_one && place) {
                wrong.push(format!("{name}, {run:?}, headings {headings}: {said}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_is_wrong_with_one_run_of_a_simulated_robot_is_told() {
    let example = Example::simulated();
    check_table(example, Some(example.alone));
}

#[test]
fn what_is_wrong_with_all_runs_of_a_simulated_robot_is_told() {
    check_table(Example::simulated(), None);
}

#[test]
fn what_is_wrong_with_one_run_of_a_real_robot_is_told() {
    let example = Example::real();
    check_table(example, Some(example.alone));
}

#[test]
fn what_is_wrong_with_all_runs_of_a_real_robot_is_told() {
    check_table(Example::real(), None);
}

#[test]
fn counts_that_are_held_are_never_an_error() {
    for example in [Example::simulated(), Example::real()] {
        let run = Some(example.alone);
        for (run, headings) in [(run, true), (run, false), (None, true)] {
            let said = said(example, run, headings, held_counts);
            let all_of_them = |line: &str| line.contains(" are new only every 0.");
            assert!(said.lines().all(all_of_them), "{run:?}: {said}");
        }
    }
}

#[test]
fn headings_that_sit_a_little_crooked_in_all_runs_are_one_warning() {
    let said = said(Example::simulated(), None, true, |run| of_headings(run, |rad| rad + 0.08));
    assert!(
        said.contains("01_rest.csv, line 1, column 9: ")
            && said.contains("heading_rad differs by +4."),
        "{said}"
    );
    assert_eq!(said.matches('\n').count(), 1, "{said}");
}
