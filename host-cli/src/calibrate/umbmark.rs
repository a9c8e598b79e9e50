//! UMBmark: squares driven both ways, and what their ends say about wheels and track.
//!
//! # Equations
//!
//! A square of side L begins along x. Its end, measured less reckoned by the wheels, is e, the mean of
//! several. If every leg bends by beta to the left and every turn is too wide by a, then to first order
//!
//! ```text
//! left turns:  e = 2 L (a + beta) ( 1, -1)              (1)
//! right turns: e = 2 L (a - beta) ( 1,  1)              (2)
//! ```
//!
//! so a and beta follow by least squares over x and y. Then, with b the track width in use:
//!
//! ```text
//! b'  = b E_b,     E_b = (pi/2) / (pi/2 + a)                                            (3)
//! W_T' = W_T E_d,  E_d = (R + b/2) / (R - b/2),  R = (L/2) / sin(beta/2)                (4)
//! E_max,syst = max |e| of the two ways                                                  (5)
//! ```
//!
//! The mean of both radii stays: a closed path says nothing about it. Source: Borenstein and Feng, UMBmark:
//! a benchmark test for measuring odometry errors in mobile robots, 1995; (1) and (2) are derived anew
//! for turns to the left positive, and use both coordinates.

use std::f64::consts::FRAC_PI_2;
use std::path::PathBuf;
use std::time::Duration;

use robot_model::kinematics::Pose;
use robot_model::recording::Piece;
use shared_proto::{Config, ConfigOrigin, GeometryConfig};

use super::checks::{Checks, check};
use super::measure::Instrument;
use super::save;
use crate::error::{Error, Result};
use crate::quantity::{Length, join_units};
use crate::survey::align::reckoned;
use crate::survey::piece;
use crate::survey::samples::{camera_track, on_one_encoder, robot_file, rows};
use crate::ui;
use crate::undo::{self, Undo};
use campaign::growing::track_so_far;
use campaign::{Campaign, Run, RunFacts};
use host_link::motion::{self, RecordOptions};
use host_link::session::Session;

/// How to drive the squares.
#[derive(Clone, Debug)]
pub struct UmbmarkSettings {
    /// Side of the square \[m\].
    pub side_m: f64,
    /// Squares each way.
    pub runs: u16,
    /// Speed of the wheels, on the sides and in the turns \[m/s\].
    pub speed_mps: f64,
    /// Their acceleration \[m/s^2\].
    pub acceleration_mps2: f64,
    /// Where the geometry before this one is remembered, so that it can be undone; `None`: nowhere.
    pub undo_folder: Option<PathBuf>,
}

/// Which way round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Turns to the left.
    Left,
    /// Turns to the right.
    Right,
}

/// Where the procedure is.
#[derive(Debug)]
pub enum UmbmarkStep<'a> {
    /// Link, supply and state are good.
    Checked(&'a Checks),
    /// A square is under way: after the correction or before, its number from 1, of how many; the share.
    Driving(bool, u16, u16, f64),
    /// All squares of a set are measured.
    Measured(bool, &'a Systematic),
    /// The correction is in use and was read back.
    Written(&'a GeometryConfig),
    /// It survives power-off.
    Saved,
}

/// What two sets of squares say.
#[derive(Clone, Debug, PartialEq)]
pub struct Systematic {
    /// Ends less reckoned ends of each square to the left \[m\].
    pub left_m: Vec<[f64; 2]>,
    /// Of each square to the right \[m\].
    pub right_m: Vec<[f64; 2]>,
    /// E_max,syst (5) \[m\].
    pub error_m: f64,
    /// E_d (4).
    pub wheel_ratio: f64,
    /// E_b (3).
    pub track_ratio: f64,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct UmbmarkOutcome {
    /// Before.
    pub before: Systematic,
    /// With the correction.
    pub after: Systematic,
    /// The geometry before and as corrected.
    pub geometry: [GeometryConfig; 2],
    /// Whether the correction is saved; if not it made it no better, and the old one is back.
    pub saved: bool,
    /// The first set as a campaign, where tracks were measured.
    pub campaign: Option<Campaign>,
}

impl Systematic {
    /// What these errors say.
    pub fn new(left_m: Vec<[f64; 2]>, right_m: Vec<[f64; 2]>, side_m: f64, track_m: f64) -> Self {
        let mean = |errors: &[[f64; 2]]| {
            let n = errors.len().max(1) as f64;
            let sum = |k: usize| errors.iter().map(|it| it[k]).sum::<f64>() / n;
            [sum(0), sum(1)]
        };
        let (left, right) = (mean(&left_m), mean(&right_m));
        // (1) and (2) along (1, -1) and (1, 1): 2 L (a + beta) and 2 L (a - beta).
        let sum = (left[0] - left[1]) / 2.0 / (2.0 * side_m);
        let difference = (right[0] + right[1]) / 2.0 / (2.0 * side_m);
        let (a, beta) = ((sum + difference) / 2.0, (sum - difference) / 2.0);
        let half = side_m / 2.0;
        // (4), with the fraction cleared of the infinite radius of a straight leg.
        let bend = track_m / 2.0 * (beta / 2.0).sin();
        Self {
            error_m: left[0].hypot(left[1]).max(right[0].hypot(right[1])),
            wheel_ratio: (half + bend) / (half - bend),
            track_ratio: FRAC_PI_2 / (FRAC_PI_2 + a),
            left_m,
            right_m,
        }
    }

    /// The geometry with (3) and (4) in it, the mean radius as it was.
    pub fn corrected(&self, in_use: &GeometryConfig) -> GeometryConfig {
        let wheel_weight = in_use.wheel_weight * self.wheel_ratio;
        GeometryConfig {
            wheel_radius_m: in_use.wheel_radius_m * (1.0 + in_use.wheel_weight)
                / (1.0 + wheel_weight),
            wheel_weight,
            track_width_m: in_use.track_width_m * self.track_ratio,
            ..*in_use
        }
    }
}

/// Drives squares both ways, corrects radii and track, drives them again, and keeps what is better.
pub async fn umbmark(
    session: &mut Session,
    instrument: &mut Instrument,
    settings: &UmbmarkSettings,
    tell: &mut dyn FnMut(UmbmarkStep<'_>),
) -> Result<UmbmarkOutcome> {
    instrument.begin()?;
    let checks = check(session).await?;
    if let Some(folder) = &settings.undo_folder {
        undo::check::<GeometryConfig>(folder, &checks.identity)?;
    }
    tell(UmbmarkStep::Checked(&checks));
    let config = &checks.config;
    let outcome = experiment(session, instrument, settings, &checks, tell).await;
    let saved = matches!(&outcome, Ok(outcome) if outcome.saved);
    if !saved && session.read_config().await.is_ok_and(|now| now != *config) {
        // Without a link this fails; what is saved is untouched all the same.
        let _ = session.restore_config(ConfigOrigin::Saved).await;
    }
    outcome
}

async fn experiment(
    session: &mut Session,
    instrument: &mut Instrument,
    settings: &UmbmarkSettings,
    checks: &Checks,
    tell: &mut dyn FnMut(UmbmarkStep<'_>),
) -> Result<UmbmarkOutcome> {
    let config = &checks.config;
    let (before, runs) = squares(session, instrument, settings, config, false, tell).await?;
    tell(UmbmarkStep::Measured(false, &before));
    let mut new = config.clone();
    new.geometry = before.corrected(&config.geometry);
    new.validate().map_err(|error| {
        Error::new(format_args!("the measured geometry is not plausibility: {error}"))
            .hint("check the readings and their signs")
    })?;
    session.write_config(&new).await?;
    tell(UmbmarkStep::Written(&new.geometry));
    let (after, _) = squares(session, instrument, settings, &new, true, tell).await?;
    tell(UmbmarkStep::Measured(true, &after));
    let saved = after.error_m < before.error_m;
    if saved {
        let undo = Undo {
            robot: checks.identity.name.as_str().into(),
            before: config.geometry,
            after: new.geometry,
        };
        save(session, settings.undo_folder.as_deref(), &checks.identity, &undo).await?;
        tell(UmbmarkStep::Saved);
    }
    let lab = match instrument {
        Instrument::Camera(lab, _) => Some(&*lab),
        _ => None,
    };
    let robot = robot_file(config, lab);
    let campaign = (!runs.is_empty()).then_some(Campaign { robot, runs, warnings: Vec::new() });
    let geometry = [config.geometry, new.geometry];
    Ok(UmbmarkOutcome { before, after, geometry, saved, campaign })
}

async fn squares(
    session: &mut Session,
    instrument: &mut Instrument,
    settings: &UmbmarkSettings,
    config: &Config,
    again: bool,
    tell: &mut dyn FnMut(UmbmarkStep<'_>),
) -> Result<(Systematic, Vec<Run>)> {
    let (mut left_m, mut right_m, mut runs) = (Vec::new(), Vec::new(), Vec::new());
    let all = 2 * settings.runs;
    for number in 0..all {
        let way = if number < settings.runs { Way::Left } else { Way::Right };
        instrument.prepare(session, "at its mark, along its line").await?;
        let square = square(session, instrument, settings, config, way, &mut |share| {
            tell(UmbmarkStep::Driving(again, number + 1, all, share));
        })
        .await?;
        match way {
            Way::Left => left_m.push(square.error_m),
            Way::Right => right_m.push(square.error_m),
        }
        if let Some(mut run) = square.run {
            run.name = format!("{:02}_square_{way:?}", number + 1).to_lowercase();
            run.facts.name.clone_from(&run.name);
            runs.push(run);
        }
    }
    let track_m = config.geometry.track_width_m;
    Ok((Systematic::new(left_m, right_m, settings.side_m, track_m), runs))
}

/// One square.
struct Square {
    /// Its end, measured less reckoned, as seen from its start \[m\].
    error_m: [f64; 2],
    /// Its track, where there is one.
    run: Option<Run>,
}

/// The robot stands; long enough for a camera to average.
const STAND: Duration = Duration::from_millis(500);

async fn square(
    session: &mut Session,
    instrument: &mut Instrument,
    settings: &UmbmarkSettings,
    config: &Config,
    way: Way,
    progress: &mut dyn FnMut(f64),
) -> Result<Square> {
    let turn_rad = if way == Way::Left { FRAC_PI_2 } else { -FRAC_PI_2 };
    let speed_mps = settings.speed_mps;
    let side = [
        Piece::Straight { travel_m: settings.side_m, speed_mps },
        Piece::Spin { turn_rad, speed_mps: speed_mps / 2.0 },
    ];
    // It was put at its mark just now: what was seen before is from elsewhere.
    let first = seen(instrument)?.unwrap_or(0);
    let start = stand(session, instrument).await?;
    let started_us = session.clock().now_us();
    let mut telemetry = Vec::new();
    let pieces = side.repeat(4);
    for (done, it) in pieces.iter().enumerate() {
        let motion = piece::motion(it, config.geometry.track_width_m, settings.acceleration_mps2);
        let Some(motion) = motion else { continue };
        let options = RecordOptions { period_ms: 20, rest: STAND / 2, ..RecordOptions::default() };
        motion::drive_into(session, &motion, options, &mut telemetry, &mut |share| {
            progress((done as f64 + share) / pieces.len() as f64);
        })
        .await?;
    }
    let end = stand(session, instrument).await?;
    let poses = reckoned(config, &telemetry);
    let reckoned = poses.last().map_or(Pose::ORIGIN, |it| it.pose);
    let end_m = end_m(session, instrument, start.zip(end)).await?;
    let run = match instrument {
        Instrument::Camera(lab, _) => Some(Run {
            name: String::new(),
            facts: RunFacts { started_s: Some(started_us as f64 * 1e-6), ..RunFacts::default() },
            rows: rows(&telemetry, &camera_track(lab, first), &[])
                .iter()
                .map(|row| on_one_encoder(row, config))
                .collect(),
        }),
        _ => None,
    };
    Ok(Square { error_m: [end_m[0] - reckoned.x_m, end_m[1] - reckoned.y_m], run })
}

/// How many poses were seen so far; `None` where nobody sees the robot on its way.
fn seen(instrument: &Instrument) -> Result<Option<usize>> {
    Ok(match instrument {
        Instrument::Camera(lab, _) => Some(lab.camera_len()),
        Instrument::TrackFile { path, .. } => Some(track_so_far(path)?.len()),
        Instrument::Ruler(_) | Instrument::Person { .. } => None,
    })
}

/// Lets the robot stand until it was seen standing, and gives the mean of what was seen meanwhile.
async fn stand(session: &mut Session, instrument: &Instrument) -> Result<Option<Pose>> {
    /// Enough for a mean, and how often to wait for so many.
    const POSES: usize = 3;
    const WAITS: usize = 10;
    let before = seen(instrument)?;
    for _ in 0..WAITS {
        session.listen(STAND).await?;
        if seen(instrument)?.zip(before).is_none_or(|(now, before)| now >= before + POSES) {
            break;
        }
    }
    before.map_or(Ok(None), |before| standing_pose(instrument, before))
}

/// Mean of the last poses that were seen of a robot that has stood since the one with number `from`;
/// `None` where nobody sees it now.
fn standing_pose(instrument: &Instrument, from: usize) -> Result<Option<Pose>> {
    const POSES: usize = 10;
    let first = |len: usize| from.max(len.saturating_sub(POSES)).min(len);
    let track = match instrument {
        Instrument::Camera(lab, _) => camera_track(lab, first(lab.camera_len())),
        Instrument::TrackFile { path, .. } => {
            let mut track = track_so_far(path)?;
            track.split_off(first(track.len()))
        }
        Instrument::Ruler(_) | Instrument::Person { .. } => return Ok(None),
    };
    let headings: Option<Vec<f64>> = track.iter().map(|it| it.heading_rad).collect();
    let Some(headings) = headings.filter(|it| !it.is_empty()) else {
        return Err(Error::new("the track has no pose with a heading of the robot at its mark")
            .hint("UMBmark needs heading_rad, and a tracking system that is running; or --measure ask"));
    };
    let n = headings.len() as f64;
    // Headings of a robot that stands differ by noise alone: about the first, unwrapped.
    let about = headings[0];
    let off = headings.iter().map(|it| (it - about).sin().atan2((it - about).cos()));
    Ok(Some(Pose {
        x_m: track.iter().map(|it| it.x_m).sum::<f64>() / n,
        y_m: track.iter().map(|it| it.y_m).sum::<f64>() / n,
        heading_rad: about + off.sum::<f64>() / n,
    }))
}

/// Where the robot is, as seen from where it started \[m\].
async fn end_m(
    session: &mut Session,
    instrument: &Instrument,
    ends: Option<(Pose, Pose)>,
) -> Result<[f64; 2]> {
    if let Instrument::Ruler(lab) = instrument {
        let reading = lab.read_offset();
        return Ok([reading.forward_m, reading.left_m]);
    }
    if let Some((start, end)) = ends {
        let end = end.seen_from(start);
        return Ok([end.x_m, end.y_m]);
    }
    loop {
        let question = "How far is it ahead of its mark, and to the left of it (-12mm 5mm)?";
        let answer = ui::ask(question, &session.clock()).await?;
        let lengths: std::result::Result<Vec<Length>, _> =
            join_units(&answer).iter().map(|it| it.parse()).collect();
        match lengths.as_deref() {
            Ok([ahead, left]) => return Ok([ahead.m, left.m]),
            _ => ui::warn("give two lengths with their units: ahead and left, -12mm 5mm"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a robot ends whose wheels and track are not as its odometry has them, less where it thinks
    /// it ends: its exact path.
    fn error_m(way: f64, side_m: f64, track_m: f64, true_track_m: f64, ratio: f64) -> [f64; 2] {
        let (mut x, mut y, mut h) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut roll = |left_m: f64, right_m: f64| {
            // The mean of both wheels' true radii is as it should be.
            let (left_m, right_m) =
                (left_m * 2.0 / (1.0 + ratio), right_m * 2.0 * ratio / (1.0 + ratio));
            let (s, turn) = ((left_m + right_m) / 2.0, (right_m - left_m) / true_track_m);
            let chord = if turn == 0.0 { s } else { s * (turn / 2.0).sin() / (turn / 2.0) };
            x += chord * (h + turn / 2.0).cos();
            y += chord * (h + turn / 2.0).sin();
            h += turn;
        };
        for _ in 0..4 {
            roll(side_m, side_m);
            let rim_m = way * FRAC_PI_2 * track_m / 2.0;
            roll(-rim_m, rim_m);
        }
        [x, y]
    }

    #[test]
    fn squares_both_ways_tell_the_wheels_from_the_track() {
        let in_use = Config::default().geometry;
        for (true_track_m, ratio) in [(0.380, 1.0), (0.372, 1.005), (0.368, 0.994)] {
            let errors = |way: f64| vec![error_m(way, 1.0, 0.372, true_track_m, ratio); 2];
            let it = Systematic::new(errors(1.0), errors(-1.0), 1.0, 0.372);
            let corrected = it.corrected(&in_use);
            // First order: what is left is of the order of the error squared, 5 % of a 2 % error.
            let (track, weight) =
                (corrected.track_width_m / true_track_m, corrected.wheel_weight / ratio);
            assert!((track - 1.0).abs() < 1e-3, "{track} {it:?}");
            assert!((weight - 1.0).abs() < 3e-4, "{weight} {it:?}");
            let mean = corrected.wheel_radius_m * (1.0 + corrected.wheel_weight) / 2.0;
            assert!((mean / 0.036 - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_perfect_robot_has_no_systematic_error_and_is_left_alone() {
        let it = Systematic::new(vec![[0.0; 2]; 5], vec![[0.0; 2]; 5], 4.0, 0.3);
        assert_eq!((it.error_m, it.wheel_ratio, it.track_ratio), (0.0, 1.0, 1.0));
    }

    #[test]
    fn a_robot_at_its_mark_is_not_where_it_was_before_it_was_put_there() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut text = String::from("t_s,x_m,y_m,heading_rad\n");
        for k in 0..15 {
            // Five pictures of the mark, after ten of where it was.
            let pose = if k < 10 { "0.5,-0.2,0.3" } else { "0.1,0.2,0.05" };
            text += &format!("{}.5,{pose}\n", k);
        }
        std::fs::write(file.path(), text).unwrap();
        let instrument = Instrument::TrackFile {
            path: file.path().into(),
            position_sigma_m: 0.001,
            heading_sigma_rad: 0.002,
            confirm: false,
            seen: 0,
        };
        assert_eq!(seen(&instrument).unwrap(), Some(15));
        let pose = standing_pose(&instrument, 10).unwrap().unwrap();
        for (is, want) in [(pose.x_m, 0.1), (pose.y_m, 0.2), (pose.heading_rad, 0.05)] {
            assert!((is - want).abs() < 1e-12, "{pose:?}");
        }
        // Nothing was seen since: no pose, and not an old one.
        let error = standing_pose(&instrument, 15).unwrap_err().to_string();
        assert!(error.contains("no pose with a heading"), "{error}");
    }
}
