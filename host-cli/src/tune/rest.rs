//! Waits for wheels that a fault left rolling: the motors are off then, and no brake holds them.
//!
//! The next motion would begin its encoder check, and the next experiment its travel, with wheels that roll already; and how
//! far the robot rolled belongs to where it is on its floor. Friction alone slows such wheels. If they do not become slower,
//! something pushes the robot, a slope for one: that ends the wait, because the robot would roll on and on.

use std::time::Duration;

use host_link::session::Session;
use shared_proto::{Command, Telemetry};

use crate::error::{Error, Result};

/// Time between two telemetry frames \[ms\].
const PERIOD_MS: u16 = 20;
/// How far the wheels roll is looked at this often.
const SLICE: Duration = Duration::from_millis(200);
/// Wheels without a count for so many slices stand.
const STANDS: usize = 2;
/// Wheels that rolled as far in the last so many slices as in as many before did not become slower.
const PUSHED: usize = 4;
/// So many slices at most: the longest that a wheel with little friction rolls.
const PATIENCE: usize = 40;

/// How the wait ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// The wheels stand, or the wait was cancelled.
    Stands,
    /// They roll on and do not become slower.
    Rolls,
}

/// Appends the frames until the wheels stand, or it is clear that they will not.
pub async fn wait_until_wheels_stand(
    session: &mut Session,
    telemetry: &mut Vec<Telemetry>,
) -> Result<Rest> {
    session.request(Command::Subscribe { period_ms: PERIOD_MS }).await?;
    let mut rest = Rest::Rolls;
    let mut rolled = Vec::new();
    let mut before = None;
    for _ in 0..PATIENCE {
        session.listen(SLICE).await?;
        telemetry.extend(session.take_all_telemetry());
        telemetry.sort_by_key(|frame| frame.t_us);
        let counts = telemetry.last().map(|frame| frame.wheels.map(|wheel| wheel.counts));
        if let (Some(before), Some(now)) = (before.replace(counts).flatten(), counts) {
            let way = now.zip(before).map(|(now, before)| now.abs_diff(before));
            rolled.push(way.left + way.right);
        }
        if session.is_cancelled() || stands(&rolled) {
            rest = Rest::Stands;
            break;
        }
        if is_pushed(&rolled) {
            break;
        }
    }
    session.request(Command::Subscribe { period_ms: 0 }).await?;
    Ok(rest)
}

/// What to say of it.
pub fn rolls_by_itself() -> Error {
    Error::new("something pushes the robot as hard as its friction can hold it").hint(
        "tune on a level floor, without a cable that pulls; the robot must stand still by itself",
    )
}

/// Whether the wheels stand, by the counts of each slice.
fn stands(rolled: &[u64]) -> bool {
    rolled.len() >= STANDS && rolled[rolled.len() - STANDS..].iter().all(|counts| *counts == 0)
}

/// Whether they roll no slower than before, by the counts of each slice. A count more or less is none.
fn is_pushed(rolled: &[u64]) -> bool {
    let Some(from) = rolled.len().checked_sub(2 * PUSHED) else { return false };
    let (before, last) = rolled[from..].split_at(PUSHED);
    let sum = |slices: &[u64]| slices.iter().sum::<u64>();
    let slower = 2 * PUSHED as u64;
    sum(last) > slower && sum(last) + 2 >= sum(before)
}

#[cfg(test)]
mod tests {
    use super::{is_pushed, stands};

    #[test]
    fn wheels_that_friction_slows_stand_in_the_end_and_are_not_called_pushed() {
        let rolled: Vec<u64> = (0..20).map(|slice| 60_u64.saturating_sub(4 * slice)).collect();
        for upto in 0..rolled.len() {
            assert!(!is_pushed(&rolled[..upto]), "{upto}");
        }
        assert!(stands(&rolled));
        assert!(!stands(&rolled[..15]));
    }

    #[test]
    fn wheels_that_a_slope_keeps_rolling_are_pushed() {
        assert!(is_pushed(&[20, 20, 20, 20, 20, 20, 20, 20]));
        assert!(is_pushed(&[10, 14, 18, 22, 26, 30, 34, 38]));
        // Not told apart from a few counts of coarse encoders.
        assert!(!is_pushed(&[1, 1, 1, 1, 1, 1, 1, 1]));
    }
}
