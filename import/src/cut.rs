//! Cuts one long log into runs: at standstill, and where somebody carried the robot.
//!
//! ```text
//! wheels   ______/~~~~~~\__/~~~~~~\__________/~~~~\______
//! poses    ......          ..      ....^jump....
//! runs        [--- one run, with a short stop ---]  [-- another --]
//! ```
//!
//! A short stop belongs to a run, as between the sides of a square; a long one ends it. So does any stop during which the
//! poses move: the robot was carried, or the tracker lost its place.

use crate::angle::wrapped;
use crate::plane::FlatPose;

/// Half of the window in which a wheel has to turn, to count as moving \[s\].
const HALF_WINDOW_S: f64 = 0.15;
/// A wheel that turns by less in the window stands: the dither of an encoder \[rad\].
const STANDS_RAD: f64 = 0.012;
/// A run keeps so much of the standstill round it, in which its first and last poses are measured well \[s\].
const MARGIN_S: f64 = 0.5;
/// Poses that move by more while the wheels stand: the robot was carried \[m, rad\].
const CARRIED: (f64, f64) = (0.05, 0.15);
/// A run in which no wheel turned by more is no run \[rad\].
pub(crate) const ROLLED_MIN_RAD: f64 = 2.0;
/// Two samples further apart than this: the log was interrupted \[s\].
const GAP_S: f64 = 2.0;

/// How a log is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutOptions {
    /// A longer stop ends a run \[s\].
    pub rest_s: f64,
    /// How many of the poses' units make a metre.
    pub units_per_m: f64,
}

impl Default for CutOptions {
    fn default() -> Self {
        // Half as much again as the stops between the pieces of a run of `beeline campaign`.
        Self { rest_s: 2.0, units_per_m: 1.0 }
    }
}

/// A piece of a log, by its samples of the wheels, the last one included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The first sample.
    pub from: usize,
    /// The last sample.
    pub to: usize,
    /// Why it begins where it does.
    pub begins: Begins,
}

/// Why a piece begins where it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begins {
    /// The robot set off after a long stop, or for the first time.
    SetOff,
    /// The robot was carried while its wheels stood, or the tracker jumped.
    Carried,
    /// The log was interrupted.
    Interrupted,
}

impl Begins {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::SetOff => "after a stop",
            Self::Carried => "after it was carried",
            Self::Interrupted => "after an interruption",
        }
    }
}

/// Cuts a log: the wheels over time \[s, rad\], and the poses on the same clock.
pub fn cut(
    t_s: &[f64],
    phi_rad: &[[f64; 2]],
    poses: &[FlatPose],
    options: CutOptions,
) -> Vec<Piece> {
    let moves = moves(t_s, phi_rad);
    let mut pieces: Vec<Piece> = Vec::new();
    for (from, to) in moves {
        let before = pieces.last_mut();
        let begins = match &before {
            None => Some(Begins::SetOff),
            Some(before) => apart(t_s, poses, (before.to, from), options),
        };
        match (begins, before) {
            (None, Some(before)) => before.to = to,
            (begins, _) => {
                pieces.push(Piece { from, to, begins: begins.unwrap_or(Begins::SetOff) })
            }
        }
    }
    pieces.retain(|piece| rolled_rad(&phi_rad[piece.from..=piece.to]) > ROLLED_MIN_RAD);
    with_margins(t_s, poses, options.units_per_m, &mut pieces);
    pieces
}

/// Stretches in which a wheel turns, by their first and last samples; an interruption ends one.
fn moves(t_s: &[f64], phi_rad: &[[f64; 2]]) -> Vec<(usize, usize)> {
    let mut moves: Vec<(usize, usize)> = Vec::new();
    let (mut first, mut last) = (0, 0);
    let mut open: Option<usize> = None;
    for k in 0..t_s.len() {
        while t_s[first] < t_s[k] - HALF_WINDOW_S && first < k {
            first += 1;
        }
        while last + 1 < t_s.len() && t_s[last + 1] <= t_s[k] + HALF_WINDOW_S {
            last += 1;
        }
        // Samples that are further apart than the window are compared with their neighbours.
        let (a, b) = (first.min(k.saturating_sub(1)), last.max(k));
        let is_gap = k > 0 && t_s[k] - t_s[k - 1] > GAP_S;
        let is_moving = !is_gap && turned_rad(&phi_rad[a], &phi_rad[b]) > STANDS_RAD;
        match (is_moving, open) {
            (true, None) => open = Some(k),
            (false, Some(from)) => {
                moves.push((from, k - 1));
                open = None;
            }
            _ => {}
        }
    }
    moves.extend(open.map(|from| (from, t_s.len() - 1)));
    moves
}

fn turned_rad(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    (b[0] - a[0]).abs().max((b[1] - a[1]).abs())
}

fn rolled_rad(phi_rad: &[[f64; 2]]) -> f64 {
    phi_rad.windows(2).map(|pair| turned_rad(&pair[0], &pair[1])).sum()
}

/// Why a stop between two samples ends a run, if it does.
fn apart(
    t_s: &[f64],
    poses: &[FlatPose],
    (from, to): (usize, usize),
    options: CutOptions,
) -> Option<Begins> {
    if t_s[from..=to].windows(2).any(|pair| pair[1] - pair[0] > GAP_S) {
        return Some(Begins::Interrupted);
    }
    if was_carried(within(poses, t_s[from], t_s[to]), options.units_per_m) {
        return Some(Begins::Carried);
    }
    (t_s[to] - t_s[from] > options.rest_s).then_some(Begins::SetOff)
}

/// The poses of a time.
fn within(poses: &[FlatPose], from_s: f64, to_s: f64) -> &[FlatPose] {
    let from = poses.partition_point(|pose| pose.t_s < from_s);
    let to = poses.partition_point(|pose| pose.t_s <= to_s);
    &poses[from..to.max(from)]
}

/// Whether the poses of a stop begin and end elsewhere: by the medians of a few at both ends, as single ones may be off.
fn was_carried(poses: &[FlatPose], units_per_m: f64) -> bool {
    const FEW: usize = 3;
    if poses.len() < 2 * FEW {
        return match poses {
            [first, .., last] => is_elsewhere(first, last, units_per_m),
            _ => false,
        };
    }
    let middle = |poses: &[FlatPose]| {
        let of = |number: &dyn Fn(&FlatPose) -> f64| {
            let mut numbers: Vec<f64> = poses.iter().map(number).collect();
            numbers.sort_by(f64::total_cmp);
            numbers[numbers.len() / 2]
        };
        let heading_rad = of(&|pose| pose.heading_rad.unwrap_or(f64::NAN));
        FlatPose {
            t_s: 0.0,
            position_m: [of(&|pose| pose.position_m[0]), of(&|pose| pose.position_m[1])],
            heading_rad: (!heading_rad.is_nan()).then_some(heading_rad),
        }
    };
    is_elsewhere(&middle(&poses[..FEW]), &middle(&poses[poses.len() - FEW..]), units_per_m)
}

fn is_elsewhere(a: &FlatPose, b: &FlatPose, units_per_m: f64) -> bool {
    let moved = (b.position_m[0] - a.position_m[0]).hypot(b.position_m[1] - a.position_m[1]);
    let turned_rad = a.heading_rad.zip(b.heading_rad).map_or(0.0, |(a, b)| b - a);
    moved > CARRIED.0 * units_per_m || wrapped(turned_rad).abs() > CARRIED.1
}

/// Adds to both ends of each piece some of the standstill, as far as the robot stayed there.
fn with_margins(t_s: &[f64], poses: &[FlatPose], units_per_m: f64, pieces: &mut [Piece]) {
    let moving: Vec<Piece> = pieces.to_vec();
    for (index, piece) in pieces.iter_mut().enumerate() {
        // Two runs share no sample.
        let before = index.checked_sub(1).map_or(0, |before| moving[before].to + 1);
        let middle_s = (t_s[before] + t_s[piece.from]) / 2.0;
        let least_s = if index == 0 { t_s[0] } else { middle_s };
        let stays = |a_s: f64, b_s: f64| !was_carried(within(poses, a_s, b_s), units_per_m);
        while piece.from > before
            && t_s[piece.from - 1] >= least_s.max(t_s[moving[index].from] - MARGIN_S)
            && t_s[piece.from] - t_s[piece.from - 1] < MARGIN_S
            && stays(t_s[piece.from - 1], t_s[moving[index].from])
        {
            piece.from -= 1;
        }
        let after = moving.get(index + 1).map_or(t_s.len() - 1, |after| after.from - 1);
        let most_s = match moving.get(index + 1) {
            Some(after) => (t_s[piece.to] + t_s[after.from]) / 2.0,
            None => t_s[t_s.len() - 1],
        };
        while piece.to < after
            && t_s[piece.to + 1] <= most_s.min(t_s[moving[index].to] + MARGIN_S)
            && t_s[piece.to + 1] - t_s[piece.to] < MARGIN_S
            && stays(t_s[moving[index].to], t_s[piece.to + 1])
        {
            piece.to += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wheels and poses at 20 and 10 Hz: straights of so many seconds at 0.3 m/s, with stops of so many between, during
    /// which the robot is carried so far.
    fn log(parts: &[(f64, f64, f64)]) -> (Vec<f64>, Vec<[f64; 2]>, Vec<FlatPose>) {
        let (mut t_s, mut phi_rad, mut poses) = (Vec::new(), Vec::new(), Vec::new());
        let (mut t, mut phi, mut x) = (0.0, 0.0, 0.0);
        for (drives_s, stops_s, carried_m) in parts {
            let ends = t + drives_s + stops_s;
            let (moves_until, jumps_at) = (t + drives_s, t + drives_s + stops_s / 2.0);
            while t < ends - 1e-9 {
                if t < moves_until {
                    phi += 0.05 * 0.3 / 0.036;
                    x += 0.05 * 0.3;
                } else if t <= jumps_at && jumps_at < t + 0.05 {
                    x += carried_m;
                }
                t += 0.05;
                t_s.push(t);
                phi_rad.push([phi, phi]);
                if t_s.len() % 2 == 0 {
                    poses.push(FlatPose { t_s: t, position_m: [x, 0.0], heading_rad: Some(0.0) });
                }
            }
        }
        (t_s, phi_rad, poses)
    }

    fn pieces(parts: &[(f64, f64, f64)]) -> Vec<(f64, f64, Begins)> {
        let (t_s, phi_rad, poses) = log(parts);
        let pieces = cut(&t_s, &phi_rad, &poses, CutOptions::default());
        pieces.iter().map(|piece| (t_s[piece.from], t_s[piece.to], piece.begins)).collect()
    }

    #[test]
    fn a_long_stop_ends_a_run_and_a_short_one_does_not() {
        let found = pieces(&[(0.0, 3.0, 0.0), (5.0, 1.2, 0.0), (5.0, 4.0, 0.0), (5.0, 2.0, 0.0)]);
        assert_eq!(found.len(), 2, "{found:?}");
        let near = |(from_s, to_s, _): (f64, f64, Begins), a_s: f64, b_s: f64| {
            (from_s - a_s).abs() < 0.35 && (to_s - b_s).abs() < 0.35
        };
        assert!(near(found[0], 2.5, 14.7) && near(found[1], 17.7, 23.7), "{found:?}");
    }

    #[test]
    fn a_robot_that_is_carried_begins_a_new_run_and_no_run_has_the_jump() {
        let found = pieces(&[(5.0, 1.2, 0.5), (5.0, 1.0, 0.0)]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert_eq!(found[1].2, Begins::Carried);
        assert!(found[0].1 <= 5.65 && found[1].0 >= 5.6, "{found:?}");
    }

    #[test]
    fn what_hardly_moves_is_no_run() {
        assert!(pieces(&[(0.1, 5.0, 0.0)]).is_empty());
        assert!(pieces(&[(0.0, 5.0, 1.0)]).is_empty());
    }

    #[test]
    fn an_interruption_of_the_log_ends_a_run() {
        let (mut t_s, phi_rad, _) = log(&[(10.0, 1.0, 0.0)]);
        t_s.iter_mut().filter(|t| **t > 5.0).for_each(|t| *t += 30.0);
        let found = cut(&t_s, &phi_rad, &[], CutOptions::default());
        assert_eq!(found.len(), 2, "{found:?}");
        assert_eq!(found[1].begins, Begins::Interrupted);
    }
}
