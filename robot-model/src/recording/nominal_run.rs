//! What would the wheels do in a planned run? Recordings of a nominal robot that drives given pieces.

use crate::kinematics::wheel_pair::WheelPair;
use crate::recording::run::{PoseMeasurement, Recording, Robot, WheelSample};

/// One piece of a planned run, from rest to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// Straight on; backwards if negative \[m\], at a speed \[m/s\].
    Straight {
        /// How far \[m\].
        travel_m: f64,
        /// How fast \[m/s\].
        speed_mps: f64,
    },
    /// On the spot; clockwise if negative.
    Spin {
        /// How far \[rad\].
        turn_rad: f64,
        /// How fast the rims run \[m/s\].
        speed_mps: f64,
    },
    /// In a curve; to the right if the turn is negative.
    Arc {
        /// Radius of the middle's path \[m\].
        radius_m: f64,
        /// How far round \[rad\].
        turn_rad: f64,
        /// How fast the middle runs \[m/s\].
        speed_mps: f64,
    },
    /// Stand still \[s\].
    Rest {
        /// How long \[s\].
        duration_s: f64,
    },
}

/// How a planned run is sampled and driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Between two samples \[s\].
    pub sample_s: f64,
    /// Number of samples between two measured poses.
    pub samples_per_pose: usize,
    /// Acceleration of the faster wheel \[m/s^2\].
    pub accel_mps2: f64,
}

impl Sampling {
    /// 100 samples and 20 poses a second, 0.3 m/s^2.
    pub const USUAL: Self = Self { sample_s: 0.01, samples_per_pose: 5, accel_mps2: 0.3 };
}

impl Piece {
    /// How far each wheel rolls, and how fast the faster one \[m, m/s\].
    ///
    /// A body that turns by theta about a centre at radius r rolls its wheels by theta (r -+ b/2).
    pub fn wheels(self, track_m: f64) -> (WheelPair<f64>, f64) {
        match self {
            Piece::Straight { travel_m, speed_mps } => (WheelPair::both(travel_m), speed_mps),
            Piece::Spin { turn_rad, speed_mps } => {
                let rim_m = turn_rad * track_m / 2.0;
                (WheelPair::new(-rim_m, rim_m), speed_mps)
            }
            Piece::Arc { radius_m, turn_rad, speed_mps } => {
                let (middle_m, rim_m) = (radius_m * turn_rad.abs(), turn_rad * track_m / 2.0);
                let outer = 1.0 + track_m / (2.0 * radius_m);
                (WheelPair::new(middle_m - rim_m, middle_m + rim_m), speed_mps * outer)
            }
            Piece::Rest { .. } => (WheelPair::both(0.0), 0.0),
        }
    }

    /// How long it takes \[s\]: d/v + v/a where the ramps leave room for a cruise, else 2 sqrt(d/a).
    pub fn duration_s(self, track_m: f64, accel_mps2: f64) -> f64 {
        let (travel_m, speed_mps) = self.wheels(track_m);
        let farther_m = travel_m.left.abs().max(travel_m.right.abs());
        match self {
            Piece::Rest { duration_s } => duration_s,
            _ if farther_m * accel_mps2 >= speed_mps * speed_mps => {
                farther_m / speed_mps + speed_mps / accel_mps2
            }
            _ => 2.0 * (farther_m / accel_mps2).sqrt(),
        }
    }

    /// The same piece, no wheel faster than this.
    pub fn capped(self, track_m: f64, speed_mps_max: f64) -> Self {
        let (_, wheel_mps) = self.wheels(track_m);
        let share = if wheel_mps > speed_mps_max { speed_mps_max / wheel_mps } else { 1.0 };
        match self {
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
}

/// The run that these pieces make: wheel angles of the nominal robot, and measurements without a value at the times
/// at which a pose would be measured.
pub fn nominal_run(robot: &Robot, name: &str, pieces: &[Piece], sampling: &Sampling) -> Recording {
    let mut recording = Recording { name: name.to_owned(), ..Recording::default() };
    let mut phi = WheelPair::both(0.0);
    let mut k = 0;
    let mut push = |k: usize, phi_rad: WheelPair<f64>| {
        let t_s = k as f64 * sampling.sample_s;
        recording.wheels.push(WheelSample { t_s, phi_rad });
        if k.is_multiple_of(sampling.samples_per_pose) {
            recording.measured_poses.push(PoseMeasurement {
                t_s,
                position_m: None,
                heading_rad: None,
            });
        }
    };
    push(0, phi);
    for piece in pieces {
        let (travel_m, speed_mps) = piece.wheels(robot.track_width_m);
        let longest_m = travel_m.left.abs().max(travel_m.right.abs());
        let profile = Profile::new(longest_m, speed_mps, sampling.accel_mps2);
        let duration_s = match *piece {
            Piece::Rest { duration_s } => duration_s,
            _ => profile.duration_s(),
        };
        let samples = (duration_s / sampling.sample_s).ceil() as usize;
        for i in 1..=samples {
            let share = profile.share(i as f64 * sampling.sample_s);
            let angle = travel_m.map(|travel_m| share * travel_m / robot.wheel_radius_m);
            k += 1;
            push(k, phi.zip(angle).map(|(a, b)| a + b));
        }
        phi = phi.zip(travel_m).map(|(a, b)| a + b / robot.wheel_radius_m);
    }
    recording
}

/// A trapezoid of speed over time.
struct Profile {
    length_m: f64,
    speed_mps: f64,
    ramp_s: f64,
    cruise_s: f64,
}

impl Profile {
    fn new(length_m: f64, speed_mps: f64, accel_mps2: f64) -> Self {
        // Too short to reach the speed: a triangle.
        let speed_mps = speed_mps.min((length_m * accel_mps2).sqrt());
        if speed_mps <= 0.0 {
            return Self { length_m: 0.0, speed_mps: 0.0, ramp_s: 0.0, cruise_s: 0.0 };
        }
        let ramp_s = speed_mps / accel_mps2;
        Self { length_m, speed_mps, ramp_s, cruise_s: length_m / speed_mps - ramp_s }
    }

    fn duration_s(&self) -> f64 {
        self.cruise_s + 2.0 * self.ramp_s
    }

    /// Share of the length after a time.
    fn share(&self, t_s: f64) -> f64 {
        if self.length_m <= 0.0 {
            return 0.0;
        }
        let accel = self.speed_mps / self.ramp_s;
        let left_s = self.duration_s() - t_s;
        let at_m = if left_s <= 0.0 {
            self.length_m
        } else if t_s < self.ramp_s {
            accel * t_s * t_s / 2.0
        } else if left_s < self.ramp_s {
            self.length_m - accel * left_s * left_s / 2.0
        } else {
            self.speed_mps * (t_s - self.ramp_s / 2.0)
        };
        at_m / self.length_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: Robot = Robot {
        wheel_radius_m: 0.05,
        track_width_m: 0.4,
        gear_reduction: 1.0,
        rad_per_count: 0.001,
        position_sigma_m: None,
        heading_sigma_rad: None,
    };

    #[test]
    fn an_arc_is_driven_at_the_speed_of_its_middle_and_a_left_one_rolls_the_right_wheel_farther() {
        let arc = Piece::Arc { radius_m: 0.5, turn_rad: 2.0, speed_mps: 0.2 };
        let (travel_m, speed_mps) = arc.wheels(0.4);
        // 2 (0.5 -+ 0.2) metres; the outer wheel is faster by 0.7 / 0.5.
        assert!((travel_m.left - 0.6).abs() < 1e-12 && (travel_m.right - 1.4).abs() < 1e-12);
        assert!((speed_mps - 0.28).abs() < 1e-12);
    }

    #[test]
    fn a_spin_rolls_the_rims_against_each_other_and_no_wheel_is_faster_than_allowed() {
        let spin = Piece::Spin { turn_rad: -3.0, speed_mps: 0.9 };
        let (travel_m, speed_mps) = spin.capped(0.4, 0.25).wheels(0.4);
        assert!((travel_m.left - 0.6).abs() < 1e-12 && (travel_m.right + 0.6).abs() < 1e-12);
        assert!((speed_mps - 0.25).abs() < 1e-12);
        let slow = Piece::Arc { radius_m: 0.5, turn_rad: 2.0, speed_mps: 0.1 };
        assert_eq!(slow.capped(0.4, 0.25), slow);
        assert_eq!(Piece::Rest { duration_s: 3.0 }.duration_s(0.4, 0.3), 3.0);
    }

    #[test]
    fn pieces_end_where_they_should_within_the_limits_of_speed_and_acceleration() {
        let pieces = [
            Piece::Straight { travel_m: -0.5, speed_mps: 0.3 },
            Piece::Spin { turn_rad: 2.0, speed_mps: 0.1 },
            Piece::Arc { radius_m: 0.6, turn_rad: -1.5, speed_mps: 0.2 },
            Piece::Rest { duration_s: 1.0 },
        ];
        let run = nominal_run(&ROBOT, "all", &pieces, &Sampling::USUAL);
        run.validate().unwrap();
        let end = run.wheels.last().unwrap().phi_rad.map(|phi_rad| phi_rad * 0.05);
        // -0.5 - 0.4 + 0.9 + 0.3 and -0.5 + 0.4 + 0.9 - 0.3, to rounding.
        assert!((end.left - 0.3).abs() < 1e-12 && (end.right - 0.5).abs() < 1e-12, "{end:?}");
        let speeds: Vec<f64> = run
            .wheels
            .windows(2)
            .map(|pair| 0.05 * (pair[1].phi_rad.right - pair[0].phi_rad.right) / 0.01)
            .collect();
        // The arc's outer wheel: 0.2 (1 + 0.2 / 0.6) is the left one's; the right one's limit is 0.3.
        assert!(speeds.iter().all(|speed| speed.abs() < 0.3 + 1e-9));
        assert!(speeds.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.3 * 0.01 + 1e-9));
    }
}
