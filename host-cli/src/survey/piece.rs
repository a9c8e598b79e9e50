//! What the wheels do in a piece of a run.

pub use robot_model::recording::Piece;
use shared_proto::{TravelUnit, WheelPair};

use crate::motion::Motion;

/// How far each wheel rolls, and how fast the faster one \[m, m/s\].
///
/// A body that turns by theta about a centre at radius r rolls its wheels by theta (r -+ b/2); the
/// speed of an arc is that of the body's middle, the speed of a spin that of the rims.
fn wheels(piece: &Piece, track_width_m: f64) -> (WheelPair<f64>, f64) {
    let half_m = track_width_m / 2.0;
    match *piece {
        Piece::Straight { travel_m, speed_mps } => (WheelPair::both(travel_m), speed_mps),
        Piece::Spin { turn_rad, speed_mps } => {
            (WheelPair::new(-turn_rad * half_m, turn_rad * half_m), speed_mps)
        }
        Piece::Arc { radius_m, turn_rad, speed_mps } => {
            let (ahead_m, aside_m) = (radius_m * turn_rad.abs(), turn_rad * half_m);
            let faster = 1.0 + half_m / radius_m;
            (WheelPair::new(ahead_m - aside_m, ahead_m + aside_m), speed_mps * faster)
        }
        Piece::Rest { .. } => (WheelPair::both(0.0), 0.0),
    }
}

/// The motion that drives a piece; `None` for a rest.
pub fn motion(piece: &Piece, track_width_m: f64, acceleration_mps2: f64) -> Option<Motion> {
    if let Piece::Rest { .. } = piece {
        return None;
    }
    let (distance, cruise) = wheels(piece, track_width_m);
    Some(Motion { unit: TravelUnit::Meter, distance, cruise, acceleration: acceleration_mps2 })
}

/// The same piece, no wheel faster than this.
pub fn capped(piece: Piece, track_width_m: f64, speed_mps_max: f64) -> Piece {
    let (_, wheel_mps) = wheels(&piece, track_width_m);
    let share = if wheel_mps > speed_mps_max { speed_mps_max / wheel_mps } else { 1.0 };
    match piece {
        Piece::Straight { travel_m, speed_mps } => {
            Piece::Straight { travel_m, speed_mps: speed_mps * share }
        }
        Piece::Spin { turn_rad, speed_mps } => {
            Piece::Spin { turn_rad, speed_mps: speed_mps * share }
        }
        Piece::Arc { radius_m, turn_rad, speed_mps } => {
            Piece::Arc { radius_m, turn_rad, speed_mps: speed_mps * share }
        }
        rest @ Piece::Rest { .. } => rest,
    }
}

/// How long a piece takes \[s\].
pub fn duration_s(piece: &Piece, track_width_m: f64, acceleration_mps2: f64) -> f64 {
    match (piece, motion(piece, track_width_m, acceleration_mps2)) {
        (Piece::Rest { duration_s }, _) => *duration_s,
        (_, Some(motion)) => motion.duration_s(),
        (_, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_is_driven_at_the_speed_of_its_middle_and_a_left_one_rolls_the_right_wheel_farther() {
        let arc = Piece::Arc { radius_m: 0.5, turn_rad: 2.0, speed_mps: 0.2 };
        let motion = motion(&arc, 0.4, 0.3).unwrap();
        // 2 (0.5 -+ 0.2) metres; the outer wheel is faster by 0.7 / 0.5.
        assert!((motion.distance.left - 0.6).abs() < 1e-12);
        assert!((motion.distance.right - 1.4).abs() < 1e-12);
        assert!((motion.cruise - 0.28).abs() < 1e-12);
    }

    #[test]
    fn a_spin_rolls_the_rims_against_each_other_and_no_wheel_is_faster_than_allowed() {
        let spin = Piece::Spin { turn_rad: -3.0, speed_mps: 0.9 };
        let motion = motion(&capped(spin, 0.4, 0.25), 0.4, 0.3).unwrap();
        assert!((motion.distance.left - 0.6).abs() < 1e-12);
        assert!((motion.distance.right + 0.6).abs() < 1e-12);
        assert!((motion.cruise - 0.25).abs() < 1e-12);
        let slow = Piece::Arc { radius_m: 0.5, turn_rad: 2.0, speed_mps: 0.1 };
        assert_eq!(capped(slow, 0.4, 0.25), slow);
    }

    #[test]
    fn a_rest_is_no_motion_and_takes_its_time() {
        let rest = Piece::Rest { duration_s: 3.0 };
        assert_eq!(motion(&rest, 0.4, 0.3), None);
        assert_eq!(duration_s(&rest, 0.4, 0.3), 3.0);
    }
}
