//! Wheels and poses brought together by their speeds: the clock, roughly, and the unit of wheels whose numbers are none of
//! radians.

use campaign::CampaignError;

use super::hints::Hints;
use super::nominal::unit;
use crate::alignment::{AlignError, Alignment, Speeds, align, speeds};
use crate::log::{Note, PoseLog, WheelLog, error};
use crate::plane::FlatPose;

/// Speeds of both, how they go together, and what a user should know. Changes the unit of wheels that are not in radians.
pub(super) fn aligned_by_speed(
    wheels: &mut WheelLog,
    poses: &PoseLog,
    flat: &[FlatPose],
    hints: &Hints,
) -> Result<([Speeds; 2], Alignment, Option<Note>), CampaignError> {
    let aligned = |wheels: &WheelLog| {
        let mut speeds = speeds(&wheels.t_s, &wheels.turned, flat)
            .ok_or_else(|| error(&wheels.file, "it has no duration", "record for longer"))?;
        let alignment = align(&speeds).map_err(|why| not_aligned(wheels, poses, why))?;
        if alignment.one_reversed {
            speeds[0] = speeds[0].one_reversed();
        }
        Ok((speeds, alignment))
    };
    let (speeds, alignment) = aligned(wheels)?;
    let Some((name, rad)) = unit(&alignment, hints) else { return Ok((speeds, alignment, None)) };
    wheels.turned.iter_mut().flatten().for_each(|number| *number *= rad);
    let text = format!("the wheels ({}) are in {name}, not in radians: converted", wheels.what);
    let (speeds, alignment) = aligned(wheels)?;
    Ok((speeds, alignment, Some(Note::new(&wheels.file, text))))
}

/// Speeds on the clock of the wheels, by which the poses are so late \[s\].
pub(super) fn speeds_together(
    [wheels, mut poses]: [Speeds; 2],
    alignment: &Alignment,
    late_s: f64,
) -> [Speeds; 2] {
    if alignment.drift == 0.0 {
        poses.start_s -= late_s;
    } else {
        poses.start_s = alignment.by_wheels_s(poses.start_s);
        poses.step_s *= 1.0 - alignment.drift;
    }
    [wheels, poses]
}

fn not_aligned(wheels: &WheelLog, poses: &PoseLog, why: AlignError) -> CampaignError {
    let (of_wheels, of_poses) = (&wheels.what, &poses.what);
    match why {
        AlignError::NoMotion { of_wheels: true } => error(
            &wheels.file,
            format!("the wheels ({of_wheels}) never turn"),
            "choose others with --wheels or --map",
        ),
        AlignError::NoMotion { of_wheels: false } => error(
            &poses.file,
            format!("the poses ({of_poses}) never move"),
            "choose others with --pose or --map",
        ),
        AlignError::NothingInCommon { misfit } => error(
            &poses.file,
            format!(
                "wheels ({of_wheels}) and poses ({of_poses}) have no motion in common: {:.0} % of it differ at best{}",
                100.0 * misfit,
                not_overlapping(wheels, poses)
            ),
            "check that both are of the same robot and drive, and which joint is left and which right",
        ),
        AlignError::Ambiguous { lags_s: [a, b] } => error(
            &poses.file,
            format!(
                "the clocks of wheels and poses may differ by {a:.2} s or by {b:.2} s: the motion repeats itself"
            ),
            "record a longer log, with stops of different lengths",
        ),
    }
}

/// How far apart both logs are by their stamps, in words that follow others, if they do not overlap.
fn not_overlapping(wheels: &WheelLog, poses: &PoseLog) -> String {
    let (Some([from_s, to_s]), Some([first_s, last_s])) = (
        wheels.t_s.first().zip(wheels.t_s.last()).map(|(from, to)| [*from, *to]),
        poses.poses.first().zip(poses.poses.last()).map(|(from, to)| [from.t_s, to.t_s]),
    ) else {
        return String::new();
    };
    match (first_s - to_s, from_s - last_s) {
        (after_s, _) if after_s > 0.0 => {
            format!(", and the poses begin {after_s:.1} s after the wheels end")
        }
        (_, before_s) if before_s > 0.0 => {
            format!(", and the poses end {before_s:.1} s before the wheels begin")
        }
        _ => String::new(),
    }
}
