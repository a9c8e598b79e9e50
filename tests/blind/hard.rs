//! What makes a campaign as hard as the world: a wrong data sheet, a tracker that wobbles, clocks that disagree, a tape
//! measure instead of a camera.
//!
//! ```text
//! geometry   wheel_radius_m and track_width_m of robot.toml are off by 3 to 20 %, the wheels differ by 0.3 to 3 %
//! wobble     poses err by 2 cm in x and in y and by 10 mrad, correlated over 2 s                            (1)
//! clock      poses are stamped late by a constant of 0.4 to 5 s, or early
//! ends       only the first and the last pose of each run are measured
//! sync       each run's poses were brought to the encoders' clock at both ends, to 20 ms: late by e_0 (1 - u) + e_1 u  (2)
//! ```
//!
//! (1) e(t + d) = e(t) exp(-d/T) + s sqrt(1 - exp(-2 d/T)) n, n standard normal. Late is positive. (2) e_0 and e_1 are drawn for
//! each run, u goes from 0 at its first pose to 1 at its last.

use campaign::{Campaign, Row};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::kinematic::normal;

/// (1): position, each coordinate \[m\], and heading \[rad\].
pub const WOBBLE: [f64; 2] = [0.02, 0.01];
/// T of (1) \[s\].
const WOBBLE_S: f64 = 2.0;
/// Standard deviation of e_0 and e_1 of (2) \[s\].
const SYNC_S: f64 = 0.02;

/// In which way a campaign is hard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Hard {
    /// In none.
    #[default]
    None,
    /// A wrong data sheet.
    Geometry,
    /// Poses with correlated noise.
    Wobble,
    /// Poses by another clock.
    Clock,
    /// First and last poses only.
    Ends,
    /// A clock for each run, synchronised at both ends.
    Sync,
}

impl Hard {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::None, Self::Geometry, Self::Wobble, Self::Clock, Self::Ends, Self::Sync];

    /// Of six campaigns, one each, but two with a wrong data sheet. Hard by `Sync` are those that are asked for.
    pub const TURNS: [Self; 6] =
        [Self::None, Self::Geometry, Self::Geometry, Self::Wobble, Self::Clock, Self::Ends];

    /// Its name in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Geometry => "geometry",
            Self::Wobble => "wobble",
            Self::Clock => "clock",
            Self::Ends => "ends",
            Self::Sync => "sync",
        }
    }

    /// The effects of the catalogue that are there because of it.
    pub fn effects(self) -> &'static [&'static str] {
        match self {
            Self::Geometry => &GEOMETRY,
            Self::Clock => &["measurement_delay"],
            Self::None | Self::Wobble | Self::Ends | Self::Sync => &[],
        }
    }
}

/// The effects of the data sheet's numbers.
pub const GEOMETRY: [&str; 3] = ["wheel_radius_ratio", "wheel_radius_scale", "track_width"];

/// By how much it is hard.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difficulty {
    /// In which way.
    pub hard: Hard,
    /// True mean radius over that of robot.toml, less one.
    pub radius: f64,
    /// True track width over that of robot.toml, less one.
    pub track: f64,
    /// Right radius less the left one, over their mean.
    pub ratio: f64,
    /// By how much poses are stamped late \[s\].
    pub late_s: f64,
    seed: u64,
}

impl Difficulty {
    /// Drawn by seed; `ratio`: whether the wheels may be made unequal.
    pub fn draw(hard: Hard, seed: u64, ratio: bool) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x6861_7264);
        let mut either = |low: f64, high: f64| {
            let size = rng.random_range(low..high);
            if rng.random() { size } else { -size }
        };
        let (radius, track, share) = (either(0.03, 0.2), either(0.03, 0.2), either(0.003, 0.03));
        let late_s = (either(0.4, 5.0) * 1e3).round() * 1e-3;
        let easy = Self { hard, seed, ..Self::default() };
        match hard {
            Hard::Geometry => {
                Self { radius, track, ratio: if ratio { share } else { 0.0 }, ..easy }
            }
            Hard::Clock => Self { late_s, ..easy },
            Hard::None | Hard::Wobble | Hard::Ends | Hard::Sync => easy,
        }
    }

    /// As hard, with its noise drawn anew.
    pub fn drawn_anew(&self) -> Self {
        Self { seed: self.seed ^ (1 << 35), ..*self }
    }

    /// What is hard about the poses, and cannot be mended.
    pub fn spoil_poses(&self, campaign: &mut Campaign) {
        match self.hard {
            Hard::Wobble => {
                let mut rng = ChaCha8Rng::seed_from_u64(self.seed ^ 0x776f_6262);
                campaign.runs.iter_mut().for_each(|run| wobble(&mut run.rows, &mut rng));
                if campaign.robot.position_sigma_m.is_some() {
                    campaign.robot.position_sigma_m = Some(WOBBLE[0]);
                    campaign.robot.heading_sigma_rad = Some(WOBBLE[1]);
                }
            }
            Hard::Ends => campaign.runs.iter_mut().for_each(|run| keep_ends(&mut run.rows)),
            Hard::Sync => {
                let mut rng = ChaCha8Rng::seed_from_u64(self.seed ^ 0x7379_6e63);
                campaign
                    .runs
                    .iter_mut()
                    .for_each(|run| run.rows = synchronised(&run.rows, &mut rng));
            }
            Hard::None | Hard::Geometry | Hard::Clock => {}
        }
    }

    /// What is wrong with the files, and could be mended by who knew it.
    pub fn spoil_files(&self, campaign: &mut Campaign) {
        campaign.robot.wheel_radius_m /= 1.0 + self.radius;
        campaign.robot.track_width_m /= 1.0 + self.track;
        if self.late_s != 0.0 {
            campaign
                .runs
                .iter_mut()
                .for_each(|run| run.rows = stamped_late(&run.rows, |_| self.late_s));
        }
    }
}

fn has_pose(row: &Row) -> bool {
    row.x_m.is_some() || row.heading_rad.is_some()
}

/// (1), begun anew.
fn wobble(rows: &mut [Row], rng: &mut ChaCha8Rng) {
    let sigmas = [WOBBLE[0], WOBBLE[0], WOBBLE[1]];
    let mut at: Option<(f64, [f64; 3])> = None;
    for row in rows.iter_mut().filter(|row| has_pose(row)) {
        let error = match at {
            None => sigmas.map(|sigma| sigma * normal(rng)),
            Some((t_s, before)) => {
                let keep = (-(row.t_s - t_s) / WOBBLE_S).exp();
                let fresh = (1.0 - keep * keep).sqrt();
                [0, 1, 2].map(|i| keep * before[i] + fresh * sigmas[i] * normal(rng))
            }
        };
        at = Some((row.t_s, error));
        row.x_m = row.x_m.map(|x_m| x_m + error[0]);
        row.y_m = row.y_m.map(|y_m| y_m + error[1]);
        row.heading_rad = row.heading_rad.map(|heading_rad| heading_rad + error[2]);
    }
}

/// Drops all poses but the first and the last one, and rows that are empty then.
fn keep_ends(rows: &mut Vec<Row>) {
    let first = rows.iter().position(has_pose);
    let last = rows.iter().rposition(has_pose);
    for (index, row) in rows.iter_mut().enumerate() {
        if Some(index) != first && Some(index) != last {
            (row.x_m, row.y_m, row.heading_rad) = (None, None, None);
        }
    }
    rows.retain(|row| has_pose(row) || row.counts.left.is_some() || row.gyro_z_rad_s.is_some());
}

/// (2).
fn synchronised(rows: &[Row], rng: &mut ChaCha8Rng) -> Vec<Row> {
    let [begin_s, end_s] = [0, 1].map(|_| SYNC_S * normal(rng));
    let mut times_s = rows.iter().filter(|row| has_pose(row)).map(|row| row.t_s);
    let first_s = times_s.next().unwrap_or(0.0);
    let last_s = times_s.next_back().unwrap_or(first_s);
    let share =
        |t_s: f64| if last_s > first_s { (t_s - first_s) / (last_s - first_s) } else { 0.0 };
    stamped_late(rows, |t_s| begin_s + (end_s - begin_s) * share(t_s))
}

/// The same rows with poses stamped later, each by a function of its time.
fn stamped_late(rows: &[Row], late_s: impl Fn(f64) -> f64) -> Vec<Row> {
    let mut all: Vec<Row> = Vec::with_capacity(2 * rows.len());
    for row in rows {
        let Row { x_m, y_m, heading_rad, .. } = *row;
        if has_pose(row) {
            // Times in a file are whole microseconds.
            let t_s = ((row.t_s + late_s(row.t_s)) * 1e6).round() * 1e-6;
            all.push(Row { t_s, x_m, y_m, heading_rad, ..Row::default() });
        }
        let rest = Row { x_m: None, y_m: None, heading_rad: None, ..*row };
        if rest.counts.left.is_some() || rest.gyro_z_rad_s.is_some() {
            all.push(rest);
        }
    }
    all.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    let mut merged: Vec<Row> = Vec::with_capacity(all.len());
    for row in all {
        match merged.last_mut() {
            Some(last) if row.t_s - last.t_s < 5e-7 => {
                let (pose, other) = if has_pose(&row) { (row, *last) } else { (*last, row) };
                let Row { x_m, y_m, heading_rad, .. } = pose;
                *last = Row { x_m, y_m, heading_rad, ..other };
            }
            _ => merged.push(row),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Row> {
        let row = |k: i32| {
            let mut row = Row { t_s: 0.05 * f64::from(k), ..Row::default() };
            (row.counts.left, row.counts.right) = (Some(f64::from(k)), Some(f64::from(k)));
            if k % 2 == 0 {
                (row.x_m, row.y_m, row.heading_rad) =
                    (Some(0.1 * f64::from(k)), Some(0.0), Some(0.0));
            }
            row
        };
        (0..2001).map(row).collect()
    }

    #[test]
    fn late_poses_keep_their_values_and_counts_their_times() {
        let before = rows();
        let after = stamped_late(&before, |_| 0.1);
        assert!(after.is_sorted_by(|a, b| a.t_s < b.t_s));
        let count = |rows: &[Row]| {
            let counts = rows.iter().filter(|row| row.counts.left.is_some()).count();
            (counts, rows.iter().filter(|row| has_pose(row)).count())
        };
        assert_eq!(count(&after), count(&before));
        // 0.1 s is two rows.
        let at = after.iter().find(|row| row.counts.left == Some(2.0)).unwrap();
        assert_eq!(at.x_m, Some(0.0));
    }

    #[test]
    fn wobble_is_as_large_as_stated_and_lasts_two_seconds() {
        let mut all = rows();
        wobble(&mut all, &mut ChaCha8Rng::seed_from_u64(5));
        let errors: Vec<f64> = all.iter().filter_map(|row| row.y_m).collect();
        let square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
        // 100 s are fifty correlation times: 10 % of the standard deviation.
        assert!((square.sqrt() / WOBBLE[0] - 1.0).abs() < 0.3, "{}", square.sqrt());
        let next = errors.windows(21).map(|w| w[0] * w[20]).sum::<f64>() / errors.len() as f64;
        // Two seconds later, exp(-1).
        assert!((next / square - 0.37).abs() < 0.2, "{}", next / square);
    }

    #[test]
    fn a_run_that_was_synchronised_at_both_ends_errs_by_another_time_at_each() {
        let before = rows();
        let after = synchronised(&before, &mut ChaCha8Rng::seed_from_u64(7));
        let times = |rows: &[Row]| -> Vec<f64> {
            rows.iter().filter(|row| has_pose(row)).map(|row| row.t_s).collect()
        };
        let late: Vec<f64> = times(&after)
            .iter()
            .zip(times(&before))
            .map(|(after, before)| after - before)
            .collect();
        let (begin, middle, end) = (late[0], late[late.len() / 2], late[late.len() - 1]);
        assert!((begin - end).abs() > 1e-3 && begin.abs().max(end.abs()) < 4.0 * SYNC_S);
        // Times are whole microseconds.
        assert!((middle - (begin + end) / 2.0).abs() < 3e-6, "{begin} {middle} {end}");
    }

    #[test]
    fn of_a_run_two_poses_are_left() {
        let mut all = rows();
        keep_ends(&mut all);
        let times: Vec<f64> = all.iter().filter(|row| has_pose(row)).map(|row| row.t_s).collect();
        assert_eq!((times.len(), all.len()), (2, 2001));
        assert_eq!(times, [0.0, 100.0]);
    }
}
