//! Leaves out single poses that are elsewhere, and says so.

use robot_model::checks::outliers_s;
use robot_model::recording::Campaign;

use crate::angle::nearest;

/// More of a run's poses than this share are no outliers, but something else.
const SHARE_MAX: f64 = 0.1;

/// Leaves out poses that are elsewhere for a frame or a few; what was done, in words. Positions are in metres by now, and clocks
/// together roughly.
pub fn leave_out(campaign: &mut Campaign) -> Option<String> {
    let (mut all, mut left_out) = (0, 0);
    for run in &mut campaign.runs {
        all += run.measured_poses.len();
        let times_s = outliers_s(&campaign.robot, run);
        let share = times_s.len() as f64 / run.measured_poses.len().max(1) as f64;
        if times_s.is_empty() || share > SHARE_MAX {
            continue;
        }
        left_out += times_s.len();
        let is_sound = |t_s: f64| times_s.binary_search_by(|other| other.total_cmp(&t_s)).is_err();
        run.measured_poses.retain(|pose| is_sound(pose.t_s));
        // A heading that was turned away and back may have come back with a turn more.
        let mut before_rad = None;
        for heading_rad in
            run.measured_poses.iter_mut().filter_map(|pose| pose.heading_rad.as_mut())
        {
            let before = *before_rad.get_or_insert(*heading_rad);
            *heading_rad = nearest(*heading_rad, before);
            before_rad = Some(*heading_rad);
        }
    }
    let are = if left_out == 1 { "is an outlier" } else { "are outliers" };
    (left_out > 0).then(|| {
        format!("{left_out} of {all} poses {are}, far from those before and after: left out")
    })
}
