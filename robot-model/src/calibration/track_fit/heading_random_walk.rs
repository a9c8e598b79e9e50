//! What a random walk of the heading does to the path.
//!
//! Its variance per metre is estimated in `average_over_variance.rs`.

use super::run::{Beta, Run};
use crate::kinematics::pose::Pose;
use crate::numeric::mixed_model::Solution;

/// The run is divided into this many pieces, each with a random turn of its own.
pub(super) const PIECES: usize = 20;

impl Run<'_> {
    /// For each sample, what a turn of one radian in each piece of the run does to its pose: Z of (3).
    ///
    /// The turn is spread evenly over its piece; pieces are equal in wheel travel.
    pub(super) fn random_walk(&self, beta: &Beta, local: &[Pose], pieces: usize) -> Vec<Vec<Pose>> {
        let turns: Vec<_> =
            self.samples.iter().map(|sample| self.turns_at(sample.t_s - beta.delay_s).1).collect();
        let mut travelled = vec![0.0];
        for pair in turns.windows(2) {
            let step = pair[1].since(pair[0]);
            let so_far = travelled[travelled.len() - 1];
            travelled.push(so_far + step.left.abs() + step.right.abs());
        }
        let piece_rad = travelled[travelled.len() - 1] / pieces.max(1) as f64;
        let turned = |sample: usize, piece: usize| {
            (travelled[sample] / piece_rad - piece as f64).clamp(0.0, 1.0)
        };
        let world: Vec<_> = local.iter().map(|pose| beta.start.compose(*pose)).collect();
        let mut now = vec![Pose::ORIGIN; pieces];
        let mut all = vec![now.clone()];
        for i in 1..world.len() {
            let (dx_m, dy_m) = (world[i].x_m - world[i - 1].x_m, world[i].y_m - world[i - 1].y_m);
            for (piece, pose) in now.iter_mut().enumerate() {
                let heading_rad = turned(i, piece);
                let middle_rad = (heading_rad + pose.heading_rad) / 2.0;
                pose.x_m -= middle_rad * dy_m;
                pose.y_m += middle_rad * dx_m;
                pose.heading_rad = heading_rad;
            }
            all.push(now.clone());
        }
        all
    }

    /// The fitted poses, with the most likely wandering.
    pub(super) fn fitted(&self, beta: &Beta, best: &Solution) -> Vec<Pose> {
        let mut moved = *beta;
        moved.step(self.options, best.values.as_slice());
        let local = self.local(moved.wheel_weight, moved.delay_s, moved.scale);
        let wandering = self.random_walk(&moved, &local, PIECES);
        let turns = &best.values.as_slice()[self.unknowns()..];
        local
            .iter()
            .zip(wandering)
            .map(|(local, pieces)| {
                let mut pose = moved.start.compose(*local);
                for (piece, turn) in pieces.iter().zip(turns) {
                    pose.x_m += turn * piece.x_m;
                    pose.y_m += turn * piece.y_m;
                    pose.heading_rad += turn * piece.heading_rad;
                }
                pose
            })
            .collect()
    }
}
