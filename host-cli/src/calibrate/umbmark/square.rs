//! Drives one square, one side after the other, and measures its start and its end.

use std::f64::consts::FRAC_PI_2;
use std::path::PathBuf;
use std::time::Duration;

use campaign::{Run, RunFacts};
use host_link::Session;
use host_link::motion::{self, RecordOptions};
use robot_model::kinematics::Pose;
use robot_model::recording::Piece;
use shared_proto::Config;

use crate::campaign_recorder::piece;
use crate::campaign_recorder::samples::{on_one_encoder, rows};
use crate::error::{Error, Result};
use crate::pose_source::PoseSource;
use crate::pose_source::align::reckoned;

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
    /// The folder that remembers the old geometry for an undo; `None`: it is not remembered.
    pub undo_folder: Option<PathBuf>,
}

/// The direction of the turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turning {
    /// Turns to the left.
    Left,
    /// Turns to the right.
    Right,
}

/// One square.
pub(super) struct Square {
    /// Its end, measured less dead reckoning, in the frame of its start \[m\].
    pub(super) error_m: [f64; 2],
    /// Its track, if there is one.
    pub(super) run: Option<Run>,
}

/// How long the robot stands still, so that poses can be averaged.
const STAND: Duration = Duration::from_millis(500);

/// Drives one square and has its end measured.
pub(super) async fn square(
    session: &mut Session,
    source: &mut dyn PoseSource,
    settings: &UmbmarkSettings,
    config: &Config,
    way: Turning,
    progress: &mut dyn FnMut(f64),
) -> Result<Square> {
    let turn_rad = if way == Turning::Left { FRAC_PI_2 } else { -FRAC_PI_2 };
    let speed_mps = settings.speed_mps;
    let side = [
        Piece::Straight { travel_m: settings.side_m, speed_mps },
        Piece::Spin { turn_rad, speed_mps: speed_mps / 2.0 },
    ];
    // The robot was put at its mark just now: earlier poses are from elsewhere.
    let first = source.pose_count()?.unwrap_or(0);
    let start = stand(session, source).await?;
    let started_us = session.clock().now_us();
    let mut telemetry = Vec::new();
    let pieces = side.repeat(4);
    for (done, piece) in pieces.iter().enumerate() {
        let motion =
            piece::motion(piece, config.geometry.track_width_m, settings.acceleration_mps2);
        let Some(motion) = motion else { continue };
        let options = RecordOptions { period_ms: 20, rest: STAND / 2, ..RecordOptions::default() };
        motion::drive_into(session, &motion, options, &mut telemetry, &mut |share| {
            progress((done as f64 + share) / pieces.len() as f64);
        })
        .await?;
    }
    let end = stand(session, source).await?;
    let poses = reckoned(config, &telemetry);
    let reckoned = poses.last().map_or(Pose::ORIGIN, |last| last.pose);
    let end_m = end_m(session, source, start.zip(end)).await?;
    let run = match source.is_simulated() {
        true => Some(Run {
            name: String::new(),
            facts: RunFacts { started_s: Some(started_us as f64 * 1e-6), ..RunFacts::default() },
            rows: rows(&telemetry, &source.poses_from(first)?, &[])
                .iter()
                .map(|row| on_one_encoder(row, config))
                .collect(),
        }),
        false => None,
    };
    Ok(Square { error_m: [end_m[0] - reckoned.x_m, end_m[1] - reckoned.y_m], run })
}

/// Lets the robot stand still until poses of it were measured, and returns their mean.
async fn stand(session: &mut Session, source: &dyn PoseSource) -> Result<Option<Pose>> {
    /// Enough poses for a mean, and how often to wait for them.
    const POSES: usize = 3;
    const WAITS: usize = 10;
    let before = source.pose_count()?;
    for _ in 0..WAITS {
        session.listen(STAND).await?;
        if source.pose_count()?.zip(before).is_none_or(|(now, before)| now >= before + POSES) {
            break;
        }
    }
    before.map_or(Ok(None), |before| standing_pose(source, before))
}

/// The mean of the last poses of a robot that has stood still since the pose with number `from`;
/// `None` if the source has no poses.
fn standing_pose(source: &dyn PoseSource, from: usize) -> Result<Option<Pose>> {
    const POSES: usize = 10;
    let Some(count) = source.pose_count()? else { return Ok(None) };
    let track = source.poses_from(from.max(count.saturating_sub(POSES)).min(count))?;
    let headings: Option<Vec<f64>> = track.iter().map(|pose| pose.heading_rad).collect();
    let Some(headings) = headings.filter(|headings| !headings.is_empty()) else {
        return Err(Error::new("the track has no pose with a heading of the robot at its mark")
            .hint("UMBmark needs heading_rad, and a tracking system that is running; or --measure ask"));
    };
    let n = headings.len() as f64;
    // Headings of a robot that stands still differ by noise alone: averaged about the first,
    // unwrapped.
    let about = headings[0];
    let off = headings.iter().map(|heading| (heading - about).sin().atan2((heading - about).cos()));
    Ok(Some(Pose {
        x_m: track.iter().map(|pose| pose.x_m).sum::<f64>() / n,
        y_m: track.iter().map(|pose| pose.y_m).sum::<f64>() / n,
        heading_rad: about + off.sum::<f64>() / n,
    }))
}

/// Where the robot is, in the frame of its start \[m\].
async fn end_m(
    session: &mut Session,
    source: &mut dyn PoseSource,
    ends: Option<(Pose, Pose)>,
) -> Result<[f64; 2]> {
    if let Some((start, end)) = ends {
        let end = end.seen_from(start);
        return Ok([end.x_m, end.y_m]);
    }
    source.read_offset(&session.clock()).await
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose_source::track_file::TrackFile;

    #[test]
    fn poses_from_before_the_robot_was_put_at_its_mark_do_not_count() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut text = String::from("t_s,x_m,y_m,heading_rad\n");
        for k in 0..15 {
            // Five poses at the mark, after ten from elsewhere.
            let pose = if k < 10 { "0.5,-0.2,0.3" } else { "0.1,0.2,0.05" };
            text += &format!("{}.5,{pose}\n", k);
        }
        std::fs::write(file.path(), text).unwrap();
        let track = TrackFile { path: file.path().into(), noise: None, confirm: false };
        assert_eq!(track.pose_count().unwrap(), Some(15));
        let pose = standing_pose(&track, 10).unwrap().unwrap();
        for (is, want) in [(pose.x_m, 0.1), (pose.y_m, 0.2), (pose.heading_rad, 0.05)] {
            assert!((is - want).abs() < 1e-12, "{pose:?}");
        }
        // No pose since then: an error, and not an old pose.
        let error = standing_pose(&track, 15).unwrap_err().to_string();
        assert!(error.contains("no pose with a heading"), "{error}");
    }
}
