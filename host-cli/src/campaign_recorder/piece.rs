//! The motion that drives a piece of a run.

use host_link::Motion;
pub use robot_model::recording::Piece;
use shared_proto::{TravelUnit, WheelPair};

/// The motion that drives a piece; `None` for a rest.
///
/// The speed of an arc is that of the robot's middle, that of a spin is of the rims; the motion's
/// is that of the faster wheel.
pub fn motion(piece: &Piece, track_width_m: f64, acceleration_mps2: f64) -> Option<Motion> {
    if let Piece::Rest { .. } = piece {
        return None;
    }
    let (travel_m, cruise) = piece.wheels(track_width_m);
    let distance = WheelPair::new(travel_m.left, travel_m.right);
    Some(Motion { unit: TravelUnit::Meter, distance, cruise, acceleration: acceleration_mps2 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_takes_as_long_as_its_piece_and_a_rest_is_none() {
        let arc = Piece::Arc { radius_m: 0.5, turn_rad: 2.0, speed_mps: 0.2 };
        let motion = motion(&arc, 0.4, 0.3).unwrap();
        assert!((motion.duration_s() - arc.duration_s(0.4, 0.3)).abs() < 1e-12);
        assert_eq!(super::motion(&Piece::Rest { duration_s: 3.0 }, 0.4, 0.3), None);
    }
}
