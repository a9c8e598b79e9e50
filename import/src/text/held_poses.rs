//! Poses of a table with a row for each sample of the wheels, in which a pose stands until the next is measured: all but the first
//! of each are old.

use crate::log::Pose3;

/// Such a share of all rows between two that differ, at least, and so many differ.
const SHARE_MIN: f64 = 0.3;
const STEPS_MIN: usize = 20;
/// A pose that is rounded repeats as well, and then changes by the least that it can; one that is held, by more.
const ROUNDED_TIMES: f64 = 3.0;

/// Whether poses are held: while the robot moves, many repeat the one before.
pub(super) fn are_held(poses: &[Pose3]) -> bool {
    let mut steps: Vec<f64> = Vec::new();
    let (mut least, mut repeats, mut run) = (f64::INFINITY, 0, 0);
    for pair in poses.windows(2) {
        if is_repeated(&pair[0], &pair[1]) {
            run += 1;
            continue;
        }
        let parts = [0, 1].map(|axis| pair[1].position_m[axis] - pair[0].position_m[axis]);
        let step = parts.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
        least = if step > 1e-9 { least.min(step) } else { least };
        steps.push(step);
        // A longer standstill says nothing.
        repeats += if run < STEPS_MIN { run } else { 0 };
        run = 0;
    }
    if steps.len() < STEPS_MIN {
        return false;
    }
    let share = repeats as f64 / (repeats + steps.len()) as f64;
    let middle = steps.len() / 2;
    let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    share > SHARE_MIN && median > ROUNDED_TIMES * least
}

/// Leaves the first of those that are alike.
pub(super) fn keep_first(poses: &mut Vec<Pose3>) {
    poses.dedup_by(|later, first| is_repeated(first, later));
}

fn is_repeated(a: &Pose3, b: &Pose3) -> bool {
    a.position_m == b.position_m && a.orientation == b.orientation
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poses(x: impl Fn(f64) -> f64) -> Vec<Pose3> {
        let pose = |k: u32| Pose3 {
            t_s: f64::from(k) * 0.01,
            position_m: [x(f64::from(k)), 0.1 * x(f64::from(k)), 0.0],
            orientation: None,
        };
        (0..400).map(pose).collect()
    }

    #[test]
    fn a_pose_that_stands_for_four_rows_is_held_and_one_that_is_rounded_is_not() {
        // It speeds up.
        let speed = |k: f64| 1e-5 * k * k;
        let mut held = poses(|k| speed(4.0 * (k / 4.0).floor()));
        assert!(are_held(&held));
        keep_first(&mut held);
        assert_eq!(held.len(), 100);
        assert!((held[1].t_s - 0.04).abs() < 1e-12);
        assert!(!are_held(&poses(speed)));
        assert!(!are_held(&poses(|k| (speed(k) / 5e-3).round() * 5e-3)));
        // It drives, and stands for long.
        assert!(!are_held(&poses(|k| speed(k.min(150.0)))));
    }
}
