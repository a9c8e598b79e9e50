//! How far beside its line a robot ended, by the poses at rest before and after the drive alone.
//!
//! A fit of the path takes the start's heading from the whole path. Where something else than the wheels moves the
//! robot, a carpet that carries it aside, that heading is wrong, and the fitted offset too.

use robot_model::calibration::{TrackSample, WheelAngles};
use robot_model::kinematics::Pose;

/// Wheels that have turned by less than this stand still \[rad\]: a count or two.
const STILL_RAD: f64 = 0.02;
/// A camera may be this late \[s\]: poses so soon after the stop are left out.
const LATE_S: f64 = 0.1;

/// The end's distance from the start's heading line, left positive \[m\]; `None` without poses and headings at rest at
/// both ends.
pub(super) fn offset_m(samples: &[TrackSample], angles: &[WheelAngles]) -> Option<f64> {
    let (first, last) = (angles.first()?, angles.last()?);
    let is_at = |now: &WheelAngles, end: &WheelAngles| {
        let turned = now.turns.since(end.turns);
        turned.left.abs().max(turned.right.abs()) < STILL_RAD
    };
    let start_s = angles.iter().take_while(|now| is_at(now, first)).last()?.t_s;
    let stop_s = angles.iter().rev().take_while(|now| is_at(now, last)).last()?.t_s + LATE_S;
    let start = mean(samples.iter().filter(|sample| sample.t_s <= start_s))?;
    let end = mean(samples.iter().filter(|sample| sample.t_s >= stop_s))?;
    Some(end.seen_from(start).y_m)
}

/// The mean of poses that differ by noise alone.
fn mean<'a>(samples: impl Iterator<Item = &'a TrackSample>) -> Option<Pose> {
    let (mut n, mut sum, mut first_rad) = (0.0, [0.0; 3], None);
    for sample in samples {
        let heading_rad = sample.heading_rad?;
        let about_rad = *first_rad.get_or_insert(heading_rad);
        let off_rad = heading_rad - about_rad;
        sum[0] += sample.x_m;
        sum[1] += sample.y_m;
        sum[2] += off_rad.sin().atan2(off_rad.cos());
        n += 1.0;
    }
    Some(Pose::new(sum[0] / n, sum[1] / n, first_rad? + sum[2] / n))
}

#[cfg(test)]
mod tests {
    use robot_model::kinematics::WheelPair;

    use super::*;

    fn sample(t_s: f64, x_m: f64, y_m: f64, heading_rad: Option<f64>) -> TrackSample {
        TrackSample { t_s, x_m, y_m, heading_rad }
    }

    #[test]
    fn the_offset_is_that_of_poses_at_rest_in_the_frame_of_the_start() {
        let angles: Vec<WheelAngles> = [0.0, 0.0, 0.0, 20.0, 40.0, 40.0, 40.0]
            .iter()
            .enumerate()
            .map(|(k, turned)| WheelAngles { t_s: k as f64, turns: WheelPair::both(*turned) })
            .collect();
        // Along y, and a centimetre to the right of it at the end; a pose on the way is anywhere.
        let up = Some(core::f64::consts::FRAC_PI_2);
        let mut track = vec![
            sample(0.5, 0.001, 0.0, up),
            sample(1.5, -0.001, 0.0, up),
            sample(3.0, 7.0, 7.0, up),
            sample(4.5, 0.009, 2.0, up),
            sample(5.5, 0.011, 2.0, up),
        ];
        let offset_m = offset_m(&track, &angles).unwrap();
        assert!((offset_m + 0.01).abs() < 1e-12, "{offset_m}");
        track[0].heading_rad = None;
        assert_eq!(super::offset_m(&track, &angles), None);
        assert_eq!(super::offset_m(&track[2..], &angles), None);
    }
}
