//! What can go wrong with the data of a recording: done to it on purpose.

use core::f64::consts::{FRAC_PI_2, PI};

use crate::kinematics::wheel_pair::WheelPair;
use crate::recording::{PoseMeasurement, Recording};
use crate::tests::synthetic::ROBOT;

/// Something done to a run.
pub(super) type Mutation = fn(&mut Recording);

fn wheels(run: &mut Recording, change: impl Fn(f64, WheelPair<f64>) -> WheelPair<f64>) {
    let start_s = run.wheels[0].t_s;
    for sample in &mut run.wheels {
        sample.phi_rad = change(sample.t_s - start_s, sample.phi_rad);
    }
}

fn positions(run: &mut Recording, change: impl Fn([f64; 2]) -> [f64; 2]) {
    for pose in &mut run.measured_poses {
        pose.position_m = pose.position_m.map(&change);
    }
}

fn headings(run: &mut Recording, change: impl Fn(f64) -> f64) {
    for pose in &mut run.measured_poses {
        pose.heading_rad = pose.heading_rad.map(&change);
    }
}

pub(super) fn exchanged(run: &mut Recording) {
    wheels(run, |_, phi| WheelPair::new(phi.right, phi.left));
}

pub(super) fn left_reversed(run: &mut Recording) {
    wheels(run, |_, phi| WheelPair::new(-phi.left, phi.right));
}

pub(super) fn right_reversed(run: &mut Recording) {
    wheels(run, |_, phi| WheelPair::new(phi.left, -phi.right));
}

pub(super) fn both_reversed(run: &mut Recording) {
    wheels(run, |_, phi| phi.map(|phi| -phi));
}

pub(super) fn y_mirrored(run: &mut Recording) {
    positions(run, |[x, y]| [x, -y]);
}

pub(super) fn x_mirrored(run: &mut Recording) {
    positions(run, |[x, y]| [-x, y]);
}

pub(super) fn axes_exchanged(run: &mut Recording) {
    positions(run, |[x, y]| [y, x]);
}

pub(super) fn heading_negated(run: &mut Recording) {
    headings(run, |heading| -heading);
}

pub(super) fn degrees(run: &mut Recording) {
    headings(run, f64::to_degrees);
}

pub(super) fn degrees_of_compass(run: &mut Recording) {
    headings(run, |heading| (FRAC_PI_2 - heading).to_degrees().rem_euclid(360.0));
}

pub(super) fn turned_left(run: &mut Recording) {
    headings(run, |heading| heading + FRAC_PI_2);
}

pub(super) fn turned_round(run: &mut Recording) {
    headings(run, |heading| heading + PI);
}

pub(super) fn turned_askew(run: &mut Recording) {
    headings(run, |heading| heading - 0.7);
}

pub(super) fn compass(run: &mut Recording) {
    headings(run, |heading| FRAC_PI_2 - heading);
}

pub(super) fn millimetres(run: &mut Recording) {
    positions(run, |position| position.map(|value| 1e3 * value));
}

pub(super) fn centimetres(run: &mut Recording) {
    positions(run, |position| position.map(|value| 1e2 * value));
}

/// As many counts as with half the edges.
pub(super) fn half_counts(run: &mut Recording) {
    wheels(run, |_, phi| phi.map(|phi| 0.5 * phi));
}

pub(super) fn left_four_times(run: &mut Recording) {
    wheels(run, |_, phi| WheelPair::new(4.0 * phi.left, phi.right));
}

/// A counter of 16 bits that is about to go round when the run begins.
pub(super) fn wraps(run: &mut Recording) {
    let range = 65_536.0 * ROBOT.rad_per_count;
    let first = run.wheels[0].phi_rad;
    wheels(run, |_, phi| {
        WheelPair::new(phi.left, (phi.right - first.right + 0.999 * range).rem_euclid(range))
    });
}

/// 65536 counts more, once.
pub(super) fn wraps_once(run: &mut Recording) {
    wheels(run, |t_s, phi| {
        let more = if t_s > 3.0 { 65_536.0 * ROBOT.rad_per_count } else { 0.0 };
        WheelPair::new(phi.left + more, phi.right)
    });
}

/// Both counters restart from zero when the faster wheel has rolled for half a metre.
pub(super) fn reset(run: &mut Recording) {
    let first = run.wheels[0].phi_rad;
    let mut offset = WheelPair::both(0.0);
    let mut done = false;
    for sample in &mut run.wheels {
        let phi_rad = sample.phi_rad.since(first);
        if !done && phi_rad.left.abs().min(phi_rad.right.abs()) > 8.0 {
            (offset, done) = (phi_rad, true);
        }
        sample.phi_rad = phi_rad.since(offset);
    }
}

/// Among the poses of a run, one that comes after this share.
fn index(run: &Recording, share: f64) -> usize {
    (share * run.measured_poses.len() as f64) as usize
}

pub(super) fn glitch(run: &mut Recording) {
    let k = index(run, 0.4);
    let pose = &mut run.measured_poses[k];
    pose.position_m = pose.position_m.map(|[x, y]| [x + 0.4, y - 0.6]);
    pose.heading_rad = pose.heading_rad.map(|heading| heading + 2.0);
}

pub(super) fn jump(run: &mut Recording) {
    let k = index(run, 0.5);
    for pose in &mut run.measured_poses[k..] {
        pose.position_m = pose.position_m.map(|[x, y]| [x + 0.07, y + 0.1]);
    }
}

/// For six seconds, or half the run.
pub(super) fn frozen(run: &mut Recording) {
    let k = index(run, 0.3);
    let held = run.measured_poses[k];
    let until_s = held.t_s + f64::min(6.0, 0.5 * run.duration_s());
    for pose in run.measured_poses[k..].iter_mut().take_while(|pose| pose.t_s < until_s) {
        (pose.position_m, pose.heading_rad) = (held.position_m, held.heading_rad);
    }
}

/// New counts four times a second, repeated in between.
pub(super) fn counts_held(run: &mut Recording) {
    let mut held = run.wheels[0];
    for sample in &mut run.wheels {
        if sample.t_s - held.t_s > 0.2499 {
            held = *sample;
        }
        sample.phi_rad = held.phi_rad;
    }
}

/// New poses twice a second, repeated in between.
pub(super) fn poses_held(run: &mut Recording) {
    let mut held = run.measured_poses[0];
    for pose in &mut run.measured_poses {
        if pose.t_s - held.t_s > 0.4999 {
            held = *pose;
        }
        (pose.position_m, pose.heading_rad) = (held.position_m, held.heading_rad);
    }
}

pub(super) fn late(run: &mut Recording) {
    run.measured_poses.iter_mut().for_each(|pose| pose.t_s += 0.8);
}

pub(super) fn without_headings(run: &mut Recording) {
    run.measured_poses.iter_mut().for_each(|pose: &mut PoseMeasurement| pose.heading_rad = None);
}
