//! Which runs are driven? And how far has each wheel turned at each millisecond?

use core::f64::consts::{FRAC_PI_2, TAU};

/// One step \[s\].
pub const DT_S: f64 = 1e-3;
/// Standing still before and after each leg \[s\].
const PAUSE_S: f64 = 0.4;
/// Steepness of the ramps, of the faster wheel \[m/s^2\].
const ACCEL_MPS2: f64 = 0.3;

/// A motion from rest to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// How far each wheel is to roll, by the nominal robot \[m\].
    pub wheels_m: [f64; 2],
    /// Speed of the faster wheel \[m/s\].
    pub speed_mps: f64,
    /// Standing still instead \[s\].
    pub rest_s: f64,
}

impl Leg {
    fn straight(travel_m: f64, speed_mps: f64) -> Self {
        Self { wheels_m: [travel_m; 2], speed_mps, rest_s: 0.0 }
    }

    /// On the spot, counter-clockwise positive.
    fn spin(turn_rad: f64, speed_mps: f64, track_m: f64) -> Self {
        let rim_m = turn_rad * track_m / 2.0;
        Self { wheels_m: [-rim_m, rim_m], speed_mps, rest_s: 0.0 }
    }

    /// Forwards round a centre; to the right if the turn is negative.
    fn arc(radius_m: f64, turn_rad: f64, speed_mps: f64, track_m: f64) -> Self {
        let (middle_m, rim_m) = (radius_m * turn_rad.abs(), turn_rad * track_m / 2.0);
        Self { wheels_m: [middle_m - rim_m, middle_m + rim_m], speed_mps, rest_s: 0.0 }
    }
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRun {
    /// Its name.
    pub name: String,
    /// Which way the robot faces at its start \[rad\].
    pub heading_rad: f64,
    /// What it carries \[kg\].
    pub payload_kg: f64,
    /// Held out: nothing is fitted to it.
    pub held_out: bool,
    /// Its motions.
    pub legs: Vec<Leg>,
}

/// The usual campaign of a robot with this track, its wheels no faster than `fast_mps`.
pub fn planned_runs(track_m: f64, fast_mps: f64) -> Vec<PlannedRun> {
    let run = |name: &str, heading_rad, legs| PlannedRun {
        name: name.into(),
        heading_rad,
        payload_kg: 0.0,
        held_out: false,
        legs,
    };
    let back = |speed_mps| {
        vec![Leg::straight(1.6, speed_mps * fast_mps), Leg::straight(-1.6, speed_mps * fast_mps)]
    };
    let rest = Leg { wheels_m: [0.0; 2], speed_mps: 0.0, rest_s: 5.0 };
    let mut all = vec![run("rest", 0.0, vec![rest])];
    for (quarter, share) in [0.35, 1.0, 0.6, 0.85].into_iter().enumerate() {
        let name = format!("out_and_back_{}", ["east", "north", "west", "south"][quarter]);
        all.push(run(&name, quarter as f64 * FRAC_PI_2, back(share)));
    }
    for (pace, share) in [("slow", 0.35), ("fast", 0.9)] {
        for (way, sign) in [("left", 1.0), ("right", -1.0)] {
            let spin = Leg::spin(sign * 2.0 * TAU, share * fast_mps, track_m);
            all.push(run(&format!("spin_{pace}_{way}"), 0.0, vec![spin]));
        }
    }
    for (size, tracks) in [("small", 1.0), ("large", 2.2)] {
        for (pace, share) in [("slow", 0.4), ("fast", 1.0)] {
            for (way, sign) in [("left", 1.0), ("right", -1.0)] {
                let arc = Leg::arc(tracks * track_m, sign * 0.9 * TAU, share * fast_mps, track_m);
                all.push(run(&format!("arc_{size}_{pace}_{way}"), 0.0, vec![arc]));
            }
        }
    }
    for (way, sign) in [("left", 1.0), ("right", -1.0)] {
        let corner = Leg::spin(sign * FRAC_PI_2, 0.4 * fast_mps, track_m);
        let side = [Leg::straight(0.9, 0.7 * fast_mps), corner];
        all.push(PlannedRun {
            held_out: true,
            ..run(&format!("square_{way}"), 0.0, side.repeat(4))
        });
    }
    let loaded = |run: PlannedRun| PlannedRun { payload_kg: 3.0, ..run };
    all.push(loaded(run("out_and_back_loaded", 0.0, back(0.5))));
    let arc = Leg::arc(track_m, 0.9 * TAU, 0.6 * fast_mps, track_m);
    all.push(loaded(run("arc_loaded", 0.0, vec![arc])));
    all.push(run("out_and_back_again", 0.0, back(0.35)));
    all
}

/// The wheels at one instant, by their encoders and the nominal radius.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wheels {
    /// Rolled since the start of the run \[m\].
    pub rolled_m: [f64; 2],
    /// Speed \[m/s\].
    pub speed_mps: [f64; 2],
    /// Acceleration \[m/s^2\].
    pub accel_mps2: [f64; 2],
}

/// The wheels at each millisecond of a run, with a pause before and after each leg.
pub fn turn_wheels(run: &PlannedRun) -> Vec<Wheels> {
    let steps = |duration_s: f64| (duration_s / DT_S).round() as usize;
    let mut wheels = vec![Wheels::default()];
    let mut at_m = [0.0; 2];
    let still = |wheels: &mut Vec<Wheels>, at_m: [f64; 2], duration_s: f64| {
        let there = Wheels { rolled_m: at_m, ..Wheels::default() };
        wheels.extend(core::iter::repeat_n(there, steps(duration_s)));
    };
    for leg in &run.legs {
        still(&mut wheels, at_m, PAUSE_S + leg.rest_s);
        let farther_m = leg.wheels_m[0].abs().max(leg.wheels_m[1].abs());
        let profile = Trapezoid::new(farther_m, leg.speed_mps);
        for k in 1..=steps(profile.duration_s()) {
            let [travel, speed, accel] = profile.at(k as f64 * DT_S);
            let share = leg.wheels_m.map(|wheel_m| wheel_m / farther_m);
            wheels.push(Wheels {
                rolled_m: [0, 1].map(|i| at_m[i] + share[i] * travel),
                speed_mps: share.map(|share| share * speed),
                accel_mps2: share.map(|share| share * accel),
            });
        }
        at_m = [0, 1].map(|i| at_m[i] + leg.wheels_m[i]);
        still(&mut wheels, at_m, PAUSE_S);
    }
    wheels
}

/// A ramp, a cruise and a ramp.
struct Trapezoid {
    distance_m: f64,
    speed_mps: f64,
    ramp_s: f64,
}

impl Trapezoid {
    fn new(distance_m: f64, speed_mps: f64) -> Self {
        let speed_mps = speed_mps.min((distance_m * ACCEL_MPS2).sqrt());
        Self { distance_m, speed_mps, ramp_s: speed_mps / ACCEL_MPS2 }
    }

    fn duration_s(&self) -> f64 {
        if self.speed_mps > 0.0 { self.distance_m / self.speed_mps + self.ramp_s } else { 0.0 }
    }

    /// Travel, speed and acceleration at a time after the start \[m, m/s, m/s^2\].
    fn at(&self, t_s: f64) -> [f64; 3] {
        let left_s = self.duration_s() - t_s;
        if left_s <= 0.0 {
            [self.distance_m, 0.0, 0.0]
        } else if t_s < self.ramp_s {
            [ACCEL_MPS2 * t_s * t_s / 2.0, ACCEL_MPS2 * t_s, ACCEL_MPS2]
        } else if left_s < self.ramp_s {
            [self.distance_m - ACCEL_MPS2 * left_s * left_s / 2.0, ACCEL_MPS2 * left_s, -ACCEL_MPS2]
        } else {
            [self.speed_mps * (t_s - self.ramp_s / 2.0), self.speed_mps, 0.0]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wheels_roll_as_far_as_their_legs_and_never_jump() {
        for run in planned_runs(0.35, 0.35) {
            let wheels = turn_wheels(&run);
            let last = wheels[wheels.len() - 1].rolled_m;
            for i in 0..2 {
                let whole_m: f64 = run.legs.iter().map(|leg| leg.wheels_m[i]).sum();
                assert!((last[i] - whole_m).abs() < 1e-9, "{} {last:?}", run.name);
                // The last step of a leg is up to a step away from its end, at hardly any speed.
                let most_m = 0.35 * DT_S + 1e-6;
                assert!(
                    wheels
                        .windows(2)
                        .all(|pair| { (pair[1].rolled_m[i] - pair[0].rolled_m[i]).abs() < most_m }),
                    "{}",
                    run.name
                );
            }
        }
    }
}
