//! Runs whose columns cannot be in the units of their names, in words: what is suspected, and what to do.

use std::fs;
use std::path::{Path, PathBuf};
use std::slice;

use robot_model::checks::{
    BadRow, Mismatch, OffEndPose, Suspicion, bad_row, end_pose_misfits, end_poses_off,
    heading_offset, median_pose_error, mismatch, suspicions,
};
use robot_model::recording::{Recording, Robot};

use crate::convention::{Convention, OtherConvention};
use crate::error::{CampaignError, Place, Warning};
use crate::recorded::{Campaign, Run};
use crate::robot_toml::place_of_key;
use crate::row::Column;

/// Refuses a run that no robot can have driven; `file` is where it was read.
pub(crate) fn check(
    file: &Path,
    run: &Run,
    robot: &Robot,
    recording: &Recording,
) -> Result<(), CampaignError> {
    let fail = |place: Place, problem: String, hint: &str| {
        Err(CampaignError::new(place, problem, hint.to_owned()))
    };
    for suspicion in suspicions(robot, recording) {
        match suspicion {
            Suspicion::Positions { per_m, measured_m, rolled_m } => {
                let unit = if per_m > 500.0 { "millimetres" } else { "centimetres" };
                let problem = format!(
                    "x_m looks like {unit}: the robot would have moved {measured_m:.0} m while its \
                     wheels rolled {rolled_m:.1} m"
                );
                let hint = "give x_m and y_m in metres; if they are, check wheel_radius_m and \
                            counts_per_rev in robot.toml";
                return fail(header(file, Column::X), problem, hint);
            }
            Suspicion::Headings { measured_rad, turned_rad } => {
                let problem = format!(
                    "heading_rad looks like degrees: the robot would have turned {measured_rad:.0} \
                     rad while its wheels turned it {turned_rad:.1} rad"
                );
                let hint = "give heading_rad in radians; if it is, check track_width_m, counts_per_rev and gear_reduction in \
                     robot.toml";
                return fail(header(file, Column::Heading), problem, hint);
            }
            Suspicion::CounterOverflow { right, t_s, bits } => {
                let column = if right { Column::RightCounts } else { Column::LeftCounts };
                let row = run.rows.iter().position(|row| row.t_s >= t_s).unwrap_or(0);
                let before = run.rows[..row].iter().rev().find_map(|row| row.get(column));
                let after = run.rows[row].get(column);
                let (from, to) = (before.unwrap_or(f64::NAN), after.unwrap_or(f64::NAN));
                let problem = format!(
                    "{} goes from {from} to {to} in one step: its {bits}-bit counter overflowed",
                    column.name()
                );
                let hint = format!(
                    "{} {} from this row on",
                    if to < from { "add" } else { "subtract" },
                    2_u64.pow(bits)
                );
                let place = Place { line: row as u64 + 2, ..header(file, column) };
                return fail(place, problem, &hint);
            }
            // A robot may be that slow: only a warning.
            Suspicion::Clock { .. } => {}
        }
    }
    Ok(())
}

/// Refuses a campaign whose wheels and poses cannot be of one robot; no run of it is suspicious.
pub(crate) fn check_all(
    folder: &Path,
    robot: &Robot,
    runs: &[Recording],
) -> Result<(), CampaignError> {
    let Some(found) = mismatch(robot, runs) else { return Ok(()) };
    let toml = |key: &str| place_of_key(&folder.join("robot.toml"), key);
    // What is wrong with a column is wrong in all runs: the first one stands for them.
    let csv = |column: Column| {
        let name = runs.first().map_or("", |run| run.name.as_str());
        header(&folder.join("runs").join(format!("{name}.csv")), column)
    };
    let fail =
        |place: Place, problem: String, hint: &str| Err(CampaignError::new(place, problem, hint));
    match found {
        Mismatch::Travel { times } => {
            let problem = format!(
                "on straight stretches the robot moved {} times as far as its wheels rolled by this file",
                factor(times)
            );
            let hint = "check wheel_radius_m (not the diameter), counts_per_rev (four counts per line with \
                        quadrature) and gear_reduction, and that x_m and y_m are in metres";
            fail(toml("wheel_radius_m"), problem, hint)
        }
        Mismatch::Backwards => {
            let problem = "in this and all other runs the robot moved backwards where its wheels rolled forwards";
            let hint = "left_counts and right_counts must increase when the robot drives forwards: change both signs, \
                        or add pi to heading_rad";
            fail(csv(Column::LeftCounts), problem.to_owned(), hint)
        }
        Mismatch::Turns { times } if times < -0.5 => {
            let problem =
                "in this and all other runs the robot turned the opposite way to its wheels";
            let hint = "swap left_counts and right_counts, or change the signs of heading_rad and y_m: \
                        headings are counter-clockwise, y is to the left of x";
            fail(csv(Column::LeftCounts), problem.to_owned(), hint)
        }
        Mismatch::Turns { times } if times.abs() < STANDS => {
            let problem = "in this and all other runs the robot did not turn where its wheels say that it did";
            let hint = "one wheel counts backwards: left_counts and right_counts must increase when the robot drives forwards";
            fail(csv(Column::LeftCounts), problem.to_owned(), hint)
        }
        Mismatch::Turns { times } => {
            let problem = format!(
                "the robot turned {} times as far as its wheels say by this file",
                factor(times.max(0.0))
            );
            let hint = "check track_width_m: the distance between the middles of the wheels' treads, in metres";
            fail(toml("track_width_m"), problem, hint)
        }
    }
}

/// A robot that turns by a smaller share of what its wheels say does not turn.
const STANDS: f64 = 0.02;

/// `0.250`, `10.0`.
fn factor(times: f64) -> String {
    if times < 1.0 { format!("{times:.3}") } else { format!("{times:.1}") }
}

/// What is odd about a campaign's runs without being an error.
pub(crate) fn warnings(
    folder: &Path,
    campaign: &Campaign,
    robot: &Robot,
    recordings: &[Recording],
) -> Vec<Warning> {
    if recordings.iter().any(|recording| recording.validate().is_err()) {
        return Vec::new();
    }
    let suspected: Vec<Vec<Suspicion>> =
        recordings.iter().map(|recording| suspicions(robot, recording)).collect();
    let mut warnings = slow_clocks(folder, campaign, &suspected);
    // In wrong units no other check means anything.
    if suspected.iter().all(Vec::is_empty) {
        warnings.extend(bad_rows_and_headings(folder, campaign, robot, recordings));
        if mismatch(robot, recordings).is_none() {
            warnings.extend(runs_off(folder, campaign, robot, recordings));
        }
    }
    warnings
}

/// Runs whose last pose lies far from dead reckoning, or that cannot be of the robot that drove the others.
fn runs_off(
    folder: &Path,
    campaign: &Campaign,
    robot: &Robot,
    recordings: &[Recording],
) -> Vec<Warning> {
    let found = odd(robot, recordings);
    let count = odd_runs(&found);
    let because = other_convention(robot, recordings, count);
    let many_off =
        |place| vec![Warning::ManyRunsOff { place, runs: count, of: recordings.len(), because }];
    if let Some(other) = because {
        let first = campaign.runs.first().map_or("", |run| run.name.as_str());
        return many_off(header(&run_file(folder, first), other.convention.column()));
    }
    if count > RUNS_OFF_MAX && 4 * count > recordings.len() {
        return many_off(place_of_key(&folder.join("robot.toml"), "wheel_radius_m"));
    }
    let warning = |(run, odd): (&Run, Odd)| {
        let file = run_file(folder, &run.name);
        if let Some(found) = odd.mismatch {
            return Some(Warning::RunMismatch {
                place: Place { line: 1, ..Place::whole(&file) },
                found,
            });
        }
        if let Some(off_m) = odd.pose_error_m {
            return Some(Warning::MostPosesOff { place: header(&file, Column::X), off_m });
        }
        let found = odd.end_pose?;
        let line = run.rows.iter().position(|row| row.t_s >= found.t_s)? as u64 + 2;
        let column = if found.position_m.is_some() { Column::X } else { Column::Heading };
        let place = Place { line, ..header(&file, column) };
        Some(Warning::EndPoseOff {
            place,
            position_m: found.position_m,
            heading_rad: found.heading_rad,
        })
    };
    campaign.runs.iter().zip(found).filter_map(warning).collect()
}

/// The convention by which all runs would agree with their wheels, if many do not by ours.
fn other_convention(
    robot: &Robot,
    runs: &[Recording],
    odd_runs_here: usize,
) -> Option<OtherConvention> {
    let sum = |misfits: &[f64]| misfits.iter().sum::<f64>();
    let here = end_pose_misfits(robot, runs);
    if sum(&here) < MISFIT_MIN && odd_runs_here <= RUNS_OFF_MAX {
        return None;
    }
    let all = Convention::ALL.into_iter().flat_map(|convention| {
        [false, true].map(|ends_only| OtherConvention { convention, ends_only })
    });
    let tried = all.map(|other| {
        let ours = other.in_ours(runs);
        (other, end_pose_misfits(robot, &ours), ours)
    });
    let (best, there, ours) = tried.min_by(|a, b| sum(&a.1).total_cmp(&sum(&b.1)))?;
    let better =
        here.iter().zip(&there).filter(|(here, there)| **here > 2.0 * **there + BETTER_MIN);
    let by_ends = better.count() > RUNS_OFF_MAX
        && sum(&here) > MISFIT_MIN
        && sum(&here) > MISFIT_TIMES * sum(&there);
    // Runs that end where they began show little at their ends: then the path in between counts.
    let fewer = || 4 * odd_runs(&odd(robot, &ours)) <= odd_runs_here;
    let by_ways = odd_runs_here > RUNS_OFF_MAX && sum(&there) <= sum(&here) && fewer();
    let sound = mismatch(robot, &ours).is_none();
    (sound && (by_ends || by_ways)).then_some(best)
}

/// Runs with a smaller sum of misfits (shares of the path, and radians) are in our convention; in another one the
/// sum must be so many times smaller.
const MISFIT_MIN: f64 = 0.5;
const MISFIT_TIMES: f64 = 4.0;
/// A smaller improvement of a run does not count.
const BETTER_MIN: f64 = 0.02;

/// Single rows that no robot can have driven, and a heading offset that all runs share.
fn bad_rows_and_headings(
    folder: &Path,
    campaign: &Campaign,
    robot: &Robot,
    recordings: &[Recording],
) -> Vec<Warning> {
    let row = |(run, recording): (&Run, &Recording)| {
        let found = bad_row(robot, recording)?;
        let file = run_file(folder, &run.name);
        let (t_s, column) = match found {
            BadRow::Jump { right: false, t_s, .. } => (t_s, Column::LeftCounts),
            BadRow::Jump { right: true, t_s, .. } => (t_s, Column::RightCounts),
            BadRow::Spike { t_s, .. } => (t_s, Column::X),
        };
        let line = run.rows.iter().position(|row| row.t_s >= t_s)? as u64 + 2;
        Some(Warning::BadRow { place: Place { line, ..header(&file, column) }, found })
    };
    let mut warnings: Vec<Warning> = campaign.runs.iter().zip(recordings).filter_map(row).collect();
    if let Some(turned_rad) = heading_offset(robot, recordings) {
        let first = campaign.runs.first().map_or("", |run| run.name.as_str());
        let place = header(&run_file(folder, first), Column::Heading);
        warnings.push(Warning::HeadingOffset { place, turned_rad });
    }
    warnings
}

/// What is odd about a single run.
struct Odd {
    mismatch: Option<Mismatch>,
    pose_error_m: Option<f64>,
    end_pose: Option<OffEndPose>,
}

fn odd_runs(runs: &[Odd]) -> usize {
    let is_odd =
        |run: &&Odd| run.mismatch.is_some() || run.pose_error_m.is_some() || run.end_pose.is_some();
    runs.iter().filter(is_odd).count()
}

fn odd(robot: &Robot, runs: &[Recording]) -> Vec<Odd> {
    let alone = |(run, end_pose): (&Recording, _)| Odd {
        mismatch: mismatch(robot, slice::from_ref(run)),
        pose_error_m: median_pose_error(robot, run),
        end_pose,
    };
    runs.iter().zip(end_poses_off(robot, runs)).map(alone).collect()
}

fn run_file(folder: &Path, name: &str) -> PathBuf {
    folder.join("runs").join(format!("{name}.csv"))
}

/// More odd runs than this, and than a quarter of all, have a common cause.
const RUNS_OFF_MAX: usize = 2;

/// Runs whose clock can hardly be in seconds.
fn slow_clocks(folder: &Path, campaign: &Campaign, suspected: &[Vec<Suspicion>]) -> Vec<Warning> {
    let warning = |(run, found): (&Run, &Vec<Suspicion>)| {
        let rate_rad_s = found.iter().find_map(|suspicion| match suspicion {
            Suspicion::Clock { rate_rad_s } => Some(*rate_rad_s),
            _ => None,
        })?;
        let file = run_file(folder, &run.name);
        Some(Warning::Clock { place: header(&file, Column::Time), rate_rad_s })
    };
    campaign.runs.iter().zip(suspected).filter_map(warning).collect()
}

/// The place of a column's name; the whole file if it cannot be read again.
fn header(file: &Path, column: Column) -> Place {
    let text = fs::read_to_string(file).unwrap_or_default();
    let names = text.lines().next().unwrap_or_default().split(',');
    let name =
        |cell: &str| cell.trim().trim_start_matches('\u{feff}').trim_matches('"') == column.name();
    match names.into_iter().position(name) {
        Some(index) => Place { line: 1, column: index as u64 + 1, ..Place::whole(file) },
        None => Place::whole(file),
    }
}

#[cfg(test)]
mod tests;
