//! Where did the tracker jump, freeze, or repeat old poses? And the poses with that mended.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::numeric::median::median;
use crate::recording::run::PoseMeasurement;

use super::data_fault::DataFault;
use super::start_pose_fit::{Fit, lateness};
use super::thinned_run::{ThinnedRun, every_few};

/// Fewer poses do not show what is usual.
const POSES_MIN: usize = 20;
/// A jump is longer than the wheels rolled by this \[m\], and by this many times what is usual (95 %).
const JUMP_M: f64 = 0.04;
const JUMP_TIMES: f64 = 8.0;
const USUAL: f64 = 0.95;
/// And than this share of the way of the wheels.
const WAY_SHARE: f64 = 0.2;
/// So many poses before and after it agree with it.
const AGREE: usize = 3;
/// A smaller jump of the heading is none \[rad\].
const TURN_RAD: f64 = 0.05;
/// A tracker is frozen if it repeats one pose for this long \[s\], so many times as long as it usually holds one,
/// while the robot moves by this \[m\] or turns by this \[rad\].
const FROZEN_S: f64 = 1.0;
const FROZEN_TIMES: f64 = 4.0;
const MOVED_M: f64 = 0.05;
const TURNED_RAD: f64 = 0.3;
/// Poses are held if most new ones come after so many repeats.
const HELD: usize = 3;

/// Poses without what was wrong with them, and what that was.
pub(super) struct Mended {
    pub(super) poses: Vec<PoseMeasurement>,
    pub(super) found: Vec<DataFault>,
}

/// The poses of a track that has them all, beside where its wheels led.
pub(super) fn mended(track: &ThinnedRun, reckoned: &[Pose], lever_m: f64) -> Mended {
    let mut mended = Mended { poses: track.poses.clone(), found: Vec::new() };
    if track.poses.len() >= POSES_MIN {
        mended.without_repeats(track, reckoned);
        let few = track.with(&every_few(&mended.poses, POSES_MIN));
        let late_s = lateness(&few, reckoned, lever_m);
        let direction_rad = Fit::robust(&few, reckoned, late_s, lever_m).direction_rad;
        mended.without_jumps(track, reckoned, late_s, direction_rad);
    }
    mended
}

/// Poses from one index to another, both included, that are the same to the bit.
fn repeats(poses: &[PoseMeasurement]) -> Vec<(usize, usize)> {
    let mut groups = Vec::new();
    let mut from = 0;
    for k in 1..=poses.len() {
        let same = poses.get(k).is_some_and(|pose| {
            let first = &poses[from];
            (pose.position_m, pose.heading_rad) == (first.position_m, first.heading_rad)
        });
        if !same {
            groups.push((from, k - 1));
            from = k;
        }
    }
    groups
}

impl Mended {
    fn without_repeats(&mut self, track: &ThinnedRun, reckoned: &[Pose]) {
        let poses = &track.poses;
        let groups = repeats(poses);
        let wheels: Vec<Pose> = poses.iter().map(|pose| track.at(reckoned, pose.t_s)).collect();
        // From the first pose of a group until the next group begins.
        let moves = |(from, to): &(usize, usize)| {
            let first = wheels[*from];
            wheels[*from..=(*to + 1).min(wheels.len() - 1)].iter().any(|pose| {
                (pose.x_m - first.x_m).hypot(pose.y_m - first.y_m) > 1e-4
                    || (pose.heading_rad - first.heading_rad).abs() > 1e-3
            })
        };
        let moving: Vec<(usize, usize)> =
            groups.iter().filter(|group| moves(group)).copied().collect();
        let lengths = moving.iter().map(|(from, to)| (to - from + 1) as f64).collect();
        let spans = moving.iter().map(|(from, to)| poses[*to].t_s - poses[*from].t_s).collect();
        let (Some(length), Some(span_s)) = (median(lengths), median(spans)) else { return };
        let is_held = moving.len() >= POSES_MIN / 2 && length >= HELD as f64;
        let frozen = |(from, to): (usize, usize)| {
            let lasts_s = poses[to].t_s - poses[from].t_s;
            let (first, heading) = (wheels[from], poses[from].heading_rad.is_some());
            let far = wheels[from..=to].iter().any(|pose| {
                (pose.x_m - first.x_m).hypot(pose.y_m - first.y_m) > MOVED_M
                    || heading && (pose.heading_rad - first.heading_rad).abs() > TURNED_RAD
            });
            far && lasts_s >= FROZEN_S.max(FROZEN_TIMES * span_s) && to - from >= AGREE
        };
        let mut kept = vec![true; poses.len()];
        for (from, to) in groups {
            let frozen = frozen((from, to));
            if frozen {
                let (from_s, to_s) = (poses[from].t_s, poses[to].t_s);
                self.found.push(DataFault::TrackerFrozen { from_s, to_s });
            }
            if frozen || is_held && moves(&(from, to)) {
                kept[from + 1..=to].fill(false);
            }
        }
        if is_held {
            let starts: Vec<f64> = moving.iter().map(|(from, _)| poses[*from].t_s).collect();
            let every = starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
            self.found.push(DataFault::PosesHeld { every_s: median(every).unwrap_or(span_s) });
        }
        let kept = poses.iter().zip(kept).filter(|(_, kept)| *kept);
        self.poses = kept.map(|(pose, _)| *pose).collect();
    }

    fn without_jumps(
        &mut self,
        track: &ThinnedRun,
        reckoned: &[Pose],
        late_s: f64,
        direction_rad: f64,
    ) {
        let (sin, cos) = direction_rad.sin_cos();
        let placed: Vec<(usize, [f64; 2], [f64; 2], f64)> = (self.poses.iter().enumerate())
            .filter_map(|(k, pose)| {
                let by_wheels = track.at(reckoned, pose.t_s - late_s);
                let (x, y) = (by_wheels.x_m, by_wheels.y_m);
                let turned_m = [cos * x - sin * y, sin * x + cos * y];
                Some((k, pose.position_m?, turned_m, by_wheels.heading_rad))
            })
            .collect();
        // How the way between two poses differs from that of the wheels.
        let excess = |a: usize, b: usize| {
            let ((_, p, from, _), (_, q, to, _)) = (placed[a], placed[b]);
            [0, 1].map(|axis| q[axis] - p[axis] - (to[axis] - from[axis]))
        };
        if placed.len() < POSES_MIN {
            return;
        }
        let length = |[x, y]: [f64; 2]| x.hypot(y);
        let mut sorted: Vec<f64> = (1..placed.len()).map(|k| length(excess(k - 1, k))).collect();
        sorted.sort_by(f64::total_cmp);
        let usual_m = sorted[(USUAL * (sorted.len() - 1) as f64) as usize];
        let limit_m = JUMP_M.max(JUMP_TIMES * usual_m);
        for k in AGREE..placed.len().saturating_sub(AGREE) {
            let by = excess(k - 1, k);
            // Poses before it against poses after it: a single outlier is no jump.
            let stays = (1..=AGREE).all(|back| {
                (0..AGREE).all(|on| {
                    let other = excess(k - back, k + on);
                    length([other[0] - by[0], other[1] - by[1]]) < 0.4 * length(by)
                })
            });
            let (from, to) = (placed[k - 1].2, placed[k].2);
            let way_m = length([to[0] - from[0], to[1] - from[1]]);
            if length(by) > limit_m.max(WAY_SHARE * way_m) && stays {
                let (index, earlier) = (placed[k].0, placed[k - 1].0);
                let turned_rad = placed[k].3 - placed[k - 1].3;
                let t_s = self.poses[index].t_s;
                self.found.push(DataFault::TrackerJump { t_s, by_m: length(by) });
                self.move_back(earlier, index, by, turned_rad);
            }
        }
    }

    /// Moves all poses from this one on back by as much, and about it by what its heading jumped.
    fn move_back(&mut self, earlier: usize, index: usize, by: [f64; 2], wheels_rad: f64) {
        let Some(pivot_m) = self.poses[index].position_m else { return };
        let headings = self.poses[earlier].heading_rad.zip(self.poses[index].heading_rad);
        let turned_rad = headings.map_or(0.0, |(before, after)| wrap(after - before - wheels_rad));
        let turned_rad = if turned_rad.abs() > TURN_RAD { turned_rad } else { 0.0 };
        let (sin, cos) = turned_rad.sin_cos();
        for pose in &mut self.poses[index..] {
            pose.position_m = pose.position_m.map(|[x_m, y_m]| {
                let (dx, dy) = (x_m - pivot_m[0], y_m - pivot_m[1]);
                let there = [pivot_m[0] + cos * dx + sin * dy, pivot_m[1] - sin * dx + cos * dy];
                [there[0] - by[0], there[1] - by[1]]
            });
            pose.heading_rad = pose.heading_rad.map(|heading| heading - turned_rad);
        }
    }
}
