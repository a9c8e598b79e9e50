//! Waits for wheels that a fault left rolling: the motors are off then, and no brake holds them.
//!
//! The next motion would begin its encoder check, and the next experiment its travel, with wheels that roll already; and how
//! far the robot rolled belongs to where it is on its floor. Friction alone slows such wheels. If they do not become slower,
//! something pushes the robot, a slope for one: that ends the wait, because the robot would roll on and on. Where one wheel goes
//! on counting and the other one stands, it is no wheel that rolls: its encoder counts interference.

use std::time::Duration;

use host_link::session::Session;
use shared_proto::{Command, Telemetry, Wheel, WheelPair};

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
    /// This one counts on, and the other one stands.
    CountsAlone(Wheel),
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
            rolled.push(now.zip(before).map(|(now, before)| now.abs_diff(before)));
        }
        if session.is_cancelled() || stands(&rolled) {
            rest = Rest::Stands;
            break;
        }
        if is_pushed(&rolled) {
            rest = counts_alone(&rolled).map_or(Rest::Rolls, Rest::CountsAlone);
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

/// What to say of a wheel that counts while the other one stands.
pub fn counts_by_itself(wheel: Wheel) -> Error {
    let (name, other) = (wheel.name(), wheel.other().name());
    Error::new(format_args!(
        "the {name} wheel counts on with its motor off, while the {other} one stands: its encoder counts interference"
    ))
    .hint("look at that encoder's plug, ground and screen, and lead its lines away from the motors'")
}

/// Whether the wheels stand, by the counts of each slice.
fn stands(rolled: &[WheelPair<u64>]) -> bool {
    let still = |counts: &WheelPair<u64>| counts.left + counts.right == 0;
    rolled.len() >= STANDS && rolled[rolled.len() - STANDS..].iter().all(still)
}

/// The wheel that counts while the other one stands, of wheels that do not become slower.
fn counts_alone(rolled: &[WheelPair<u64>]) -> Option<Wheel> {
    let last = &rolled[rolled.len().saturating_sub(PUSHED)..];
    let stands = |wheel: Wheel| last.iter().all(|counts| *counts.get(wheel) == 0);
    Wheel::BOTH.into_iter().find(|wheel| stands(wheel.other()))
}

/// Whether they roll no slower than before, by the counts of each slice. A count more or less is none.
fn is_pushed(rolled: &[WheelPair<u64>]) -> bool {
    let Some(from) = rolled.len().checked_sub(2 * PUSHED) else { return false };
    let (before, last) = rolled[from..].split_at(PUSHED);
    let sum = |slices: &[WheelPair<u64>]| {
        slices.iter().map(|counts| counts.left + counts.right).sum::<u64>()
    };
    let slower = 2 * PUSHED as u64;
    sum(last) > slower && sum(last) + 2 >= sum(before)
}

#[cfg(test)]
mod tests {
    use super::{counts_alone, is_pushed, stands};
    use shared_proto::{Wheel, WheelPair};

    fn both(counts: impl IntoIterator<Item = u64>) -> Vec<WheelPair<u64>> {
        counts.into_iter().map(|counts| WheelPair::new(counts / 2, counts - counts / 2)).collect()
    }

    #[test]
    fn wheels_that_friction_slows_stand_in_the_end_and_are_not_called_pushed() {
        let rolled = both((0..20).map(|slice| 60_u64.saturating_sub(4 * slice)));
        for upto in 0..rolled.len() {
            assert!(!is_pushed(&rolled[..upto]), "{upto}");
        }
        assert!(stands(&rolled));
        assert!(!stands(&rolled[..15]));
    }

    #[test]
    fn wheels_that_a_slope_keeps_rolling_are_pushed() {
        assert!(is_pushed(&both([20; 8])));
        assert!(is_pushed(&both([10, 14, 18, 22, 26, 30, 34, 38])));
        assert_eq!(counts_alone(&both([20; 8])), None);
        // Not told apart from a few counts of coarse encoders.
        assert!(!is_pushed(&both([1; 8])));
    }

    #[test]
    fn a_wheel_that_counts_while_the_other_one_stands_is_not_pushed() {
        // The left one has rolled out, and stands; the right one counts on.
        let mut rolled = [9, 5, 2, 1, 0, 0, 0, 0].map(|left| WheelPair::new(left, 40)).to_vec();
        assert!(!is_pushed(&rolled), "they became slower");
        rolled.extend([WheelPair::new(0, 40); 4]);
        assert!(is_pushed(&rolled));
        assert_eq!(counts_alone(&rolled), Some(Wheel::Right));
    }
}
