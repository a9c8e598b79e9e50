//! Runs that are copies of others: the same recording twice is not twice the evidence.
//!
//! ```text
//! b is a copy of a  if  each row of b has a row of a at its time, up to one shift of the clock,
//!                       with the same counts, up to one offset of each counter, and the same pose,
//!                       both to the digits of the file that has fewer
//! ```
//!
//! A run without positions is nobody's copy: it is no evidence, and counts alone may be the same twice.
//!
//! So a copy may lack values, be cut short, thinned out, written with fewer digits, or on another clock. Two drives of
//! the same kind are told apart by the noise of their poses and the phase of their encoders: no ten rows of theirs
//! agree in each digit.

use crate::error::CopiedRun;
use crate::recorded::Run;
use crate::row::{Column, Row};

/// A part of a run counts as a copy from so many rows on; a whole run always.
const ROWS_MIN: usize = 10;

/// So many shifts of the clock are tried for a pair of runs: a robot that stands still has the same pose in many rows.
const SHIFTS_MAX: usize = 200;

/// The columns that are compared besides the time.
const COMPARED: [Column; 5] =
    [Column::LeftCounts, Column::RightCounts, Column::X, Column::Y, Column::Heading];

/// The place of x among them.
const X: usize = 2;

/// Takes the copies out of the runs, so that each recording counts once.
///
/// Of copies one stays: one that is held out, as nothing may be fitted to what a model is tested with; else the longest; else the
/// first.
pub(crate) fn take_out(runs: &mut Vec<Run>) -> Vec<CopiedRun> {
    let fingerprints: Vec<Fingerprint> = runs.iter().map(Fingerprint::of).collect();
    // The best first, so that each run is compared with those that stay.
    let mut order: Vec<usize> = (0..runs.len()).collect();
    order.sort_by_key(|index| {
        (!runs[*index].facts.held_out, usize::MAX - runs[*index].rows.len(), *index)
    });
    let near = Near::new(runs, &fingerprints);
    let mut stays = vec![None; runs.len()];
    let mut copies = Vec::new();
    for (place, index) in order.into_iter().enumerate() {
        let same = |other: &usize| {
            let (a, b) =
                ((&runs[*other], &fingerprints[*other]), (&runs[index], &fingerprints[index]));
            if a.0.rows.len() >= b.0.rows.len() { is_copy(b, a) } else { is_copy(a, b) }
        };
        // In the order in which they came to stay.
        let mut others = near.of(index, &runs[index], &fingerprints[index]);
        others.retain(|other| stays[*other].is_some());
        others.sort_unstable_by_key(|other| stays[*other]);
        match others.iter().find(|other| same(other)) {
            Some(of) => copies.push((index, *of)),
            None => stays[index] = Some(place),
        }
    }
    copies.sort_unstable();
    let named = |(copy, of): &(usize, usize)| CopiedRun {
        name: runs[*copy].name.clone(),
        of: runs[*of].name.clone(),
    };
    let told: Vec<CopiedRun> = copies.iter().map(named).collect();
    for (copy, _) in copies.iter().rev() {
        runs.remove(*copy);
    }
    told
}

/// What is known of a run before it is compared: half a unit of the last digit of each column, and a row whose pose tells most.
struct Fingerprint {
    half_digit: [f64; COMPARED.len()],
    half_time: f64,
    /// The row in the middle of those with a position.
    telling: Option<usize>,
}

impl Fingerprint {
    fn of(run: &Run) -> Self {
        let half_of =
            |column: Column| half_digit(run.rows.iter().filter_map(|row| row.get(column)));
        let posed: Vec<usize> =
            (0..run.rows.len()).filter(|row| run.rows[*row].x_m.is_some()).collect();
        Self {
            half_digit: COMPARED.map(half_of),
            half_time: half_of(Column::Time),
            telling: posed.get(posed.len() / 2).copied(),
        }
    }
}

/// Which runs have a row at the place of another run's telling row: no others can be copies, and to compare each run with each
/// would take as many steps as the square of their number.
struct Near {
    /// The x of every row with a position, and the run.
    rows: ByDigits,
    /// The same of the telling rows alone.
    telling: ByDigits,
}

/// x \[m\] and run, sorted, for each number of digits with which x is written: half a unit of the last one, and the rows.
type ByDigits = Vec<(f64, Vec<(f64, usize)>)>;

impl Near {
    fn new(runs: &[Run], fingerprints: &[Fingerprint]) -> Self {
        let half_digit = |run: &usize| fingerprints[*run].half_digit[X];
        let all = 0..runs.len();
        let rows = |run: usize| runs[run].rows.iter().filter_map(|row| row.x_m).collect();
        let telling = |run: usize| {
            let row = fingerprints[run].telling.map(|row| &runs[run].rows[row]);
            row.and_then(|row| row.x_m).into_iter().collect()
        };
        Self {
            rows: by_digits(all.clone(), half_digit, rows),
            telling: by_digits(all, half_digit, telling),
        }
    }

    /// The runs of which this one may be a copy, or that may be copies of it; itself as well.
    fn of(&self, index: usize, run: &Run, fingerprint: &Fingerprint) -> Vec<usize> {
        let half_digit = fingerprint.half_digit[X];
        let own = fingerprint.telling.and_then(|row| run.rows[row].x_m);
        let mut found = vec![index];
        if let Some(x_m) = own {
            find(&self.rows, x_m, half_digit, &mut found);
        }
        for x_m in run.rows.iter().filter_map(|row| row.x_m) {
            find(&self.telling, x_m, half_digit, &mut found);
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

fn by_digits(
    runs: std::ops::Range<usize>,
    half_digit: impl Fn(&usize) -> f64,
    places: impl Fn(usize) -> Vec<f64>,
) -> ByDigits {
    let mut all = ByDigits::new();
    for run in runs {
        let half = half_digit(&run);
        let known = all.iter().position(|(other, _)| *other == half);
        let at = known.unwrap_or_else(|| {
            all.push((half, Vec::new()));
            all.len() - 1
        });
        all[at].1.extend(places(run).into_iter().map(|x_m| (x_m, run)));
    }
    for (_, rows) in &mut all {
        rows.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // A robot that stands still has the same pose in many rows.
        rows.dedup();
    }
    all
}

/// Adds the runs with a row as close to x as [`Close`] asks.
fn find(all: &ByDigits, x_m: f64, half_digit: f64, found: &mut Vec<usize>) {
    for (half, rows) in all {
        let within_m = within(*half, half_digit);
        let from = rows.partition_point(|(other_m, _)| *other_m < x_m - within_m);
        let near = rows[from..].iter().take_while(|(other_m, _)| *other_m <= x_m + within_m);
        found.extend(near.map(|(_, run)| *run));
    }
}

/// Half a unit of the last decimal digit that any of these numbers has.
fn half_digit(values: impl Iterator<Item = f64>) -> f64 {
    /// A file has no more; floats of this size have no more either.
    const DIGITS_MAX: i32 = 9;
    let mut digits = 0;
    for value in values {
        let scaled = |digits: i32| value * 10_f64.powi(digits);
        while digits < DIGITS_MAX
            && (scaled(digits) - scaled(digits).round()).abs()
                > 1e-6 * scaled(digits).abs().max(1.0)
        {
            digits += 1;
        }
        if digits == DIGITS_MAX {
            break;
        }
    }
    0.5 * 10_f64.powi(-digits)
}

/// Whether all rows of `b` are in `a`.
fn is_copy(
    (b, fingerprint_b): (&Run, &Fingerprint),
    (a, fingerprint_a): (&Run, &Fingerprint),
) -> bool {
    let whole = a.rows.len() == b.rows.len();
    if !whole && b.rows.len() < ROWS_MIN {
        return false;
    }
    let Some(telling) = fingerprint_b.telling.map(|row| &b.rows[row]) else { return false };
    let close = Close::new(fingerprint_a, fingerprint_b);
    let alike = a.rows.iter().filter(|row| close.poses(row, telling));
    alike.take(SHIFTS_MAX).any(|row| close.all(&a.rows, &b.rows, row.t_s - telling.t_s))
}

/// How close two numbers are to be the same, by half a unit of the last digit of each: what was rounded is off by half a digit at
/// most; two floats of the same text by nothing.
fn within(a: f64, b: f64) -> f64 {
    if a == b { 0.01 * a } else { 1.01 * a.max(b) }
}

/// How close two numbers of a column are, to be the same: the digits of the file that has fewer.
struct Close {
    within: [f64; COMPARED.len()],
    within_s: f64,
}

impl Close {
    fn new(a: &Fingerprint, b: &Fingerprint) -> Self {
        let mut all = [0.0; COMPARED.len()];
        for (index, all) in all.iter_mut().enumerate() {
            *all = within(a.half_digit[index], b.half_digit[index]);
        }
        // The shift of the clock is itself known to two digits' rounding.
        Self { within: all, within_s: 2.0 * a.half_time.max(b.half_time) + 1e-9 }
    }

    fn poses(&self, a: &Row, b: &Row) -> bool {
        (2..COMPARED.len()).all(|index| match (a.get(COMPARED[index]), b.get(COMPARED[index])) {
            (Some(a), Some(b)) => (a - b).abs() <= self.within[index],
            (_, None) => true,
            (None, Some(_)) => false,
        })
    }

    /// Whether each row of `b` has its row of `a`, with the clock of `b` shifted by `shift_s`.
    fn all(&self, a: &[Row], b: &[Row], shift_s: f64) -> bool {
        // A counter may begin anywhere: its offset is that of the first row.
        let mut offset = [None; 2];
        b.iter().all(|row| {
            let t_s = row.t_s + shift_s;
            let after = a.partition_point(|other| other.t_s < t_s - self.within_s);
            let near = a[after..].iter().take_while(|other| other.t_s <= t_s + self.within_s);
            near.into_iter()
                .any(|other| self.poses(other, row) && self.counts(other, row, &mut offset))
        })
    }

    fn counts(&self, a: &Row, b: &Row, offset: &mut [Option<f64>; 2]) -> bool {
        let pairs = [(a.counts.left, b.counts.left), (a.counts.right, b.counts.right)];
        pairs.iter().enumerate().all(|(index, pair)| match pair {
            (Some(a), Some(b)) => {
                let from = *offset[index].get_or_insert(a - b);
                // The first row's own rounding is in the offset.
                (a - b - from).abs() <= 2.0 * self.within[index]
            }
            (_, None) => true,
            (None, Some(_)) => false,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RunFacts;
    use shared_proto::WheelPair;

    /// A drive of 200 rows whose poses have noise; other seeds are other drives.
    fn drive(name: &str, seed: u64, noise_m: f64) -> Run {
        let mut state = (seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut noise = || {
            // Knuth's 64-bit linear congruence.
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            noise_m * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
        };
        let rounded =
            |value: f64, digits: i32| (value * 10_f64.powi(digits)).round() / 10_f64.powi(digits);
        let rows = (0..200).map(|k| {
            let t_s = f64::from(k) * 0.02;
            let at_m = (0.1 * (t_s - 0.3)).max(0.0);
            let seen = k % 3 == 0;
            Row {
                t_s,
                counts: WheelPair::both((at_m * 4000.0).floor()).map(Some),
                x_m: seen.then(|| rounded(at_m + noise(), 7)),
                y_m: seen.then(|| rounded(noise(), 7)),
                heading_rad: seen.then(|| rounded(noise(), 7)),
                ..Row::default()
            }
        });
        Run { name: name.into(), facts: RunFacts::default(), rows: rows.collect() }
    }

    fn changed(run: &Run, change: impl Fn(&mut Row)) -> Vec<Row> {
        let mut rows = run.rows.clone();
        rows.iter_mut().for_each(change);
        rows
    }

    fn rounded(row: &mut Row, digits: i32) {
        let round = |value: f64| (value * 10_f64.powi(digits)).round() / 10_f64.powi(digits);
        row.x_m = row.x_m.map(round);
        row.y_m = row.y_m.map(round);
        row.heading_rad = row.heading_rad.map(round);
    }

    #[test]
    fn a_copy_is_found_whatever_was_done_to_it() {
        let run = drive("01_a", 1, 0.002);
        let copies: [(&str, Vec<Row>); 8] = [
            ("equal", run.rows.clone()),
            ("on another clock", changed(&run, |row| row.t_s += 1234.567)),
            ("with fewer digits", changed(&run, |row| rounded(row, 4))),
            ("in millimetres", changed(&run, |row| rounded(row, 3))),
            ("cut at its end", run.rows[..120].to_vec()),
            ("cut at its start", run.rows[70..].to_vec()),
            ("thinned out", run.rows.iter().step_by(3).copied().collect()),
            ("with other counters, later and shorter", {
                let mut rows = changed(&run, |row| {
                    row.t_s += 3.0;
                    row.counts.left = row.counts.left.map(|counts| counts + 70_000.0);
                    rounded(row, 5);
                });
                rows.split_off(50)
            }),
        ];
        for (what, rows) in copies {
            let copy = Run { name: "02_b".into(), rows, ..run.clone() };
            let mut runs = vec![run.clone(), copy, drive("03_c", 2, 0.002)];
            let found = take_out(&mut runs);
            assert_eq!(found, [CopiedRun { name: "02_b".into(), of: "01_a".into() }], "{what}");
            assert_eq!(runs.len(), 2);
        }
    }

    #[test]
    fn drives_of_the_same_kind_are_no_copies_even_under_a_precise_tracker() {
        for noise_m in [0.01, 0.001, 0.00001] {
            let mut runs: Vec<Run> =
                (0..20).map(|seed| drive(&format!("{seed:02}_a"), seed, noise_m)).collect();
            assert_eq!(take_out(&mut runs), [], "{noise_m} m");
        }
    }

    #[test]
    fn runs_without_positions_are_no_copies() {
        let blind = |name: &str| {
            let run = drive(name, 1, 0.002);
            let rows =
                changed(&run, |row| (row.x_m, row.y_m, row.heading_rad) = (None, None, None));
            Run { rows, ..run }
        };
        assert_eq!(take_out(&mut vec![blind("01_a"), blind("02_a")]), []);
    }

    #[test]
    fn of_copies_the_held_out_one_stays_so_that_nothing_is_fitted_to_it() {
        let run = drive("01_a", 1, 0.002);
        let held_out = Run {
            name: "02_b".into(),
            facts: RunFacts { held_out: true, ..RunFacts::default() },
            rows: run.rows[..150].to_vec(),
        };
        let mut runs = vec![run, held_out];
        let found = take_out(&mut runs);
        assert_eq!(found, [CopiedRun { name: "01_a".into(), of: "02_b".into() }]);
        assert!(runs.len() == 1 && runs[0].facts.held_out);
    }
}
