//! Is a clock in seconds, and does it go on evenly? Only speeds can tell: tracks know nothing of time.

use crate::recording::run::{Recording, WheelSample};

/// A clock that can hardly be in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlowClock {
    /// The fastest that a wheel would turn \[rad/s\].
    pub rate_rad_s: f64,
    /// How many of the clock's units make a second, as likely as not: 1e3, 1e6 or 1e9.
    pub per_s: f64,
}

/// A clock in a smaller unit than seconds makes wheels this slow, though they turn by a radian or more and samples
/// are a second or more apart: 20 rad/s, with a second for a millisecond \[rad/s\].
const SLOW_RAD_S: f64 = 0.02;
/// The slowest fastest speed of a robot's wheels \[rad/s\].
const LIKELY_RAD_S: f64 = 0.2;
/// Fewer samples than these may really be minutes apart.
const SAMPLES_MIN: usize = 20;

/// Whether a run's clock can hardly be in seconds; `run` is valid.
pub fn slow_clock(run: &Recording) -> Option<SlowClock> {
    let mut spacings: Vec<f64> =
        run.wheels.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
    spacings.sort_by(f64::total_cmp);
    if run.wheels.len() < SAMPLES_MIN || spacings[spacings.len() / 2] < 1.0 {
        return None;
    }
    let (mut rate_rad_s, mut rolled_rad) = (0.0_f64, 0.0);
    for pair in run.wheels.windows(2) {
        let turned = pair[1].phi_rad.since(pair[0].phi_rad).map(f64::abs);
        let most = turned.left.max(turned.right);
        rate_rad_s = rate_rad_s.max(most / (pair[1].t_s - pair[0].t_s));
        rolled_rad += most;
    }
    let units = [1e3, 1e6, 1e9];
    let per_s = units.into_iter().find(|per_s| rate_rad_s * per_s > LIKELY_RAD_S).unwrap_or(1e9);
    (rolled_rad > 1.0 && rate_rad_s < SLOW_RAD_S).then_some(SlowClock { rate_rad_s, per_s })
}

/// From one row to the next a clock goes on by more than the time that passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockJump {
    /// Where the later row stands \[s\].
    pub t_s: f64,
    /// How far it is from the earlier one \[s\].
    pub jump_s: f64,
}

/// From one row to the next no run lasts longer than this \[s\].
const GAP_S_MAX: f64 = 3600.0;
/// A jump is at least so long \[s\], and so many ordinary spacings of rows.
const JUMP_S_MIN: f64 = 0.5;
const JUMP_SPACINGS_MIN: f64 = 20.0;
/// In rows that are farther apart than this a robot can stop and start again unseen \[s\].
const SPACING_S_MAX: f64 = 0.1 + 1e-9;
/// Rows at either side by which a wheel's speed is told, and the least speed \[rad/s\].
const ROWS_BESIDE: usize = 10;
const RATE_RAD_S_MIN: f64 = 0.5;
/// In a jump a wheel turns no farther than in so many ordinary spacings.
const SPACINGS_TURNED_MAX: f64 = 3.0;

/// Whether a run's clock jumps ahead: the rows are hours apart, or a wheel that turns before and after has turned in a long
/// gap no farther than from any row to the next. Rows that were lost are no jump: the wheel went on in them. A valid run.
pub fn clock_jump(run: &Recording) -> Option<ClockJump> {
    let wheels = &run.wheels;
    if slow_clock(run).is_some() {
        return None;
    }
    let gap_s = |index: usize| wheels[index + 1].t_s - wheels[index].t_s;
    let mut spacings: Vec<f64> = (0..wheels.len().saturating_sub(1)).map(gap_s).collect();
    spacings.sort_by(f64::total_cmp);
    let spacing_s = *spacings.get(spacings.len() / 2)?;
    let jumps = |index: &usize| {
        let gap_s = gap_s(*index);
        gap_s > GAP_S_MAX
            || gap_s > JUMP_S_MIN.max(JUMP_SPACINGS_MIN * spacing_s)
                && spacing_s <= SPACING_S_MAX
                && stands_in_a_gap(wheels, *index, spacing_s)
    };
    let index = (0..spacings.len()).find(jumps)?;
    Some(ClockJump { t_s: wheels[index + 1].t_s, jump_s: gap_s(index) })
}

/// Whether a wheel that turns before and after has hardly turned from this row to the next.
fn stands_in_a_gap(wheels: &[WheelSample], index: usize, spacing_s: f64) -> bool {
    let (Some(first), last) = (index.checked_sub(ROWS_BESIDE), index + 1 + ROWS_BESIDE) else {
        return false;
    };
    if last >= wheels.len() {
        return false;
    }
    let turned = |from: usize, to: usize| wheels[to].phi_rad.since(wheels[from].phi_rad);
    let rate = |from: usize, to: usize| {
        let took_s = wheels[to].t_s - wheels[from].t_s;
        turned(from, to).map(|rad| rad / took_s)
    };
    let (before, after, there) =
        (rate(first, index), rate(index + 1, last), turned(index, index + 1));
    let stands = |before: f64, after: f64, there: f64| {
        let slower = before.abs().min(after.abs());
        let same_way = before.signum() == after.signum();
        same_way
            && slower > RATE_RAD_S_MIN
            && there.abs() <= SPACINGS_TURNED_MAX * slower * spacing_s
    };
    stands(before.left, after.left, there.left) || stands(before.right, after.right, there.right)
}
