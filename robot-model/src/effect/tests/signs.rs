//! Signs and sizes: does each effect do what its description says, in figures that follow from its equation?

use core::f64::consts::{FRAC_PI_2, TAU};

use super::*;
use crate::kinematics::pose::Pose;

/// The pose that a second of a steady motion leads to, with one effect.
fn after_a_second(id: &str, values: &[f64], left_mps: f64, right_mps: f64) -> Pose {
    let terms = [Term::new(find(id).unwrap(), values.into())];
    let mut composer = Composer::new(Terms::Fixed(&terms));
    let mut pose = Pose::ORIGIN;
    let speed = WheelPair::new(left_mps, right_mps);
    for k in 0..100 {
        let step = Step {
            dt_s: 0.01,
            dphi_rad: speed.map(|speed| 0.01 * speed / ROBOT.wheel_radius_m),
            wheel_speed_mps: speed,
            wheel_accel_mps2: WheelPair::both(0.5),
            since_reversal_m: Some(0.0001 * f64::from(k)),
            clock_s: 1000.0,
            payload_kg: 2.0,
            heading_rad: pose.heading_rad,
            wheel_radius_m: ROBOT.wheel_radius_m,
            track_width_m: ROBOT.track_width_m,
            gear_reduction: 1.0,
            ..Step::default()
        };
        pose =
            crate::estimation::transition::Transition::new(pose, &composer.step(&step), 1.0).pose;
    }
    pose
}

/// Sums of a hundred steps, rounded.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12
}

const V: f64 = 0.2;

fn ahead(id: &str, values: &[f64]) -> Pose {
    after_a_second(id, values, V, V)
}

fn back(id: &str, values: &[f64]) -> Pose {
    after_a_second(id, values, -V, -V)
}

/// The turn of a second's spin to the left, and to the right.
fn spins(id: &str, values: &[f64]) -> [f64; 2] {
    [(-V, V), (V, -V)].map(|(left, right)| after_a_second(id, values, left, right).heading_rad)
}

/// An arc to the left, v = 0.2.
fn arc(id: &str, values: &[f64]) -> Pose {
    after_a_second(id, values, 0.15, 0.25)
}

/// Whether the effect does what its description says.
fn matches_its_description(id: &str) -> bool {
    let of_robot = of_wheels(id).or_else(|| of_drive_and_caster(id));
    let holds = of_robot.or_else(|| of_world_and_instruments(id));
    holds.unwrap_or_else(|| panic!("{id} has no test of its signs"))
}

/// The turn of a second's spin with 0.4 m/s between the rims \[rad\].
const SPIN_RAD: f64 = 0.4 / ROBOT.track_width_m;

/// The same for effects of wheels and tyres; `None` for others.
fn of_wheels(id: &str) -> Option<bool> {
    let turn = SPIN_RAD;
    Some(match id {
        // Left is positive: a larger right wheel curves left ahead, right when reversing.
        "wheel_radius_ratio" => {
            let heading = 0.01 * V / ROBOT.track_width_m;
            same(ahead(id, &[0.01]).heading_rad, heading)
                && same(back(id, &[0.01]).heading_rad, -heading)
        }
        "wheel_radius_scale" => {
            same(ahead(id, &[0.01]).x_m, 0.202) && same(back(id, &[0.01]).x_m, -0.202)
        }
        "track_width" => {
            let [left, right] = spins(id, &[0.01]);
            same(left, turn / 1.01) && same(right, -turn / 1.01)
        }
        // chi of a spin is 1, of a straight 0, of the arc 0.1 / (2 0.2 + 0.1).
        "scrub" => {
            let [left, right] = spins(id, &[0.01]);
            let arc = arc(id, &[0.01]).heading_rad;
            same(left, turn / 1.01)
                && same(right, -turn / 1.01)
                && same(arc, 0.1 / ROBOT.track_width_m / 1.002)
        }
        // Pushed outwards, by k v times the turn: to the right of where it would be, in a left turn.
        "side_slip" => {
            let (slipped, straight) = (arc(id, &[0.05]), arc(id, &[0.0]));
            let outwards = straight.x_m.hypot(straight.y_m) * 0.05 * 0.1 / ROBOT.track_width_m;
            let apart = (slipped.x_m - straight.x_m).hypot(slipped.y_m - straight.y_m);
            slipped.seen_from(straight).y_m < 0.0
                && same(apart, outwards)
                && slipped.heading_rad == straight.heading_rad
        }
        // Forwards and faster: less than was counted. Backwards it is braking: more.
        "traction_slip" => {
            same(ahead(id, &[0.02]).x_m, 0.2 * 0.99) && same(back(id, &[0.02]).x_m, -0.2 * 1.01)
        }
        // 1 - 0.1 v^2 of the turn.
        "turn_load_transfer" => {
            same(arc(id, &[0.1]).heading_rad, 0.996 * 0.1 / ROBOT.track_width_m)
        }
        "speed_growth" => same(ahead(id, &[0.1]).x_m, 0.2 * 1.004),
        "wheel_eccentricity" | "encoder_eccentricity" => {
            // At zero angle the radius is at its largest for c, growing for s; each wheel its own.
            let turned = |values: &[f64]| first_degrees(id, values);
            let (c, s) = (turned(&[0.01, 0.0, 0.0, 0.0]), turned(&[0.0, 0.0, 0.0, 0.01]));
            c.left > 1.0 && c.right == 1.0 && s.left == 1.0 && s.right > 1.0
        }
        _ => return None,
    })
}

/// The same for effects of encoders, gears, caster and body; `None` for others.
fn of_drive_and_caster(id: &str) -> Option<bool> {
    let turn = SPIN_RAD;
    Some(match id {
        // Wheels at 5.6 rad/s, 2.6 above w0 = 3: further than was counted.
        "lost_counts" => {
            let more = 1.0 + 0.1 * (V / ROBOT.wheel_radius_m - 3.0) / 3.0;
            same(ahead(id, &[0.1, 3.0]).x_m, V * more)
                && same(ahead(id, &[0.1, 6.0]).x_m, V)
                && same(back(id, &[0.1, 3.0]).x_m, -V * more)
        }
        "backlash" => backlash_takes_its_play_at_each_reversal(),
        // A swing of 0.05 rad in 1 cm, over after 20 cm but for exp(-20).
        "caster_kick" => {
            let [left, right] = [ahead(id, &[0.05, 0.01]), back(id, &[0.05, 0.01])];
            left.heading_rad > 0.0 && same(right.heading_rad, -left.heading_rad) && whole_swing(id)
        }
        // The same way both ways, by c times the path.
        "heading_pull" => {
            same(ahead(id, &[0.01]).heading_rad, 0.002)
                && same(back(id, &[0.01]).heading_rad, 0.002)
        }
        "turn_asymmetry" => {
            let [left, right] = spins(id, &[0.01]);
            same(left, turn * 1.01) && same(right, -turn * 0.99)
        }
        _ => return None,
    })
}

/// The same for effects of floor, time, load, camera and yaw rate sensor; `None` for others.
fn of_world_and_instruments(id: &str) -> Option<bool> {
    let p = Jet::parameters(&[0.02, 0.03]);
    let effect = find(id).unwrap();
    Some(match id {
        // Turns towards downhill, and creeps there: k (1, l) for each metre, forwards and backwards.
        "slope" => [ahead(id, &[0.0, 1e-4, 0.5]), back(id, &[0.0, 1e-4, 0.5])].iter().all(|pose| {
            // The turn itself moves the robot sideways by k s^2/2: to the left ahead, to the right in reverse.
            let own = pose.x_m.signum() * 0.5e-4 * 0.04;
            // To the square of the turn, 2e-5, and of a hundredth of a step in heading.
            (pose.heading_rad - 2e-5).abs() < 1e-9 && (pose.y_m - 1e-5 - own).abs() < 1e-7
        }),
        "carpet_drift" => {
            let (there, here) = (ahead(id, &[0.01, -0.02]), back(id, &[0.01, -0.02]));
            same(there.x_m, 0.202)
                && same(here.x_m, -0.198)
                && same(there.y_m, -0.004)
                && same(here.y_m, -0.004)
                && there.heading_rad == 0.0
                && a_spin_is_carried_too()
        }
        // After 1000 s, and with 2 kg.
        "thermal_drift" => same(ahead(id, &[1e-6]).x_m, 0.2 * 1.001),
        "payload" => same(ahead(id, &[0.001]).x_m, 0.2 * 0.998),
        "measurement_delay" => effect.observe(&p).delay_s.value == 0.02,
        "heading_drift" => effect.observe(&p).heading_drift_rad_s.value == 0.02,
        "marker_offset" => effect.observe(&p).offset_m.map(|jet| jet.value) == [0.02, 0.03],
        "gyro_bias" => {
            [1.5, 0.0, -1.5].iter().all(|omega| effect.sense_rate(&p, *omega).value == 0.02)
        }
        "gyro_scale" => {
            [1.5, 0.0, -1.5].iter().all(|omega| effect.sense_rate(&p, *omega).value == 0.02 * omega)
        }
        _ => return None,
    })
}

#[test]
fn signs_and_sizes_are_those_that_the_descriptions_state() {
    let ids = CATALOGUE.iter().map(|effect| effect.facts().id);
    let broken: Vec<&str> = ids.filter(|id| !matches_its_description(id)).collect();
    assert_eq!(broken, [""; 0]);
}

/// On a carpet a spin goes as far as its rims roll, and does not turn more for it; about one wheel it goes half as far.
fn a_spin_is_carried_too() -> bool {
    let [spin, pivot] =
        [-V, 0.0].map(|left_mps| after_a_second("carpet_drift", &[0.01, -0.02], left_mps, V));
    let turned = after_a_second("carpet_drift", &[0.0, 0.0], 0.0, V);
    same(spin.x_m, 0.002)
        && same(spin.y_m, -0.004)
        && same(spin.heading_rad, SPIN_RAD)
        && same(pivot.x_m - turned.x_m, 0.001)
        && same(pivot.heading_rad, turned.heading_rad)
}

/// Twenty centimetres after a reversal all of the swing has been made.
fn whole_swing(id: &str) -> bool {
    let step = Step {
        dphi_rad: WheelPair::both(0.2 / ROBOT.wheel_radius_m),
        since_reversal_m: Some(0.0),
        wheel_radius_m: ROBOT.wheel_radius_m,
        ..Step::default()
    };
    let p = Jet::parameters(&[0.05, 0.01]);
    let turn_rad = find(id).unwrap().act(&p, &step, &mut Memory::default()).turn_rad.value;
    (turn_rad / 0.05 - 1.0).abs() < 3e-9
}

/// How far the ground gets ahead of a left wheel with play that moves with these speeds, 10 ms each \[rad\].
fn ahead_by_play(memory: &mut Memory, coast_mps2: f64, speeds_mps: &[f64]) -> f64 {
    let effect = find("backlash").unwrap();
    let p = Jet::parameters(&[PLAY_RAD, 0.01, coast_mps2]);
    let mut moved = |speed_mps: &f64| -> f64 {
        let step = Step {
            dt_s: 0.01,
            dphi_rad: WheelPair::both(0.01 * speed_mps / ROBOT.wheel_radius_m),
            wheel_speed_mps: WheelPair::both(*speed_mps),
            wheel_radius_m: ROBOT.wheel_radius_m,
            ..Step::default()
        };
        effect.act(&p, &step, memory).angle_rad.left.value
    };
    speeds_mps.iter().map(&mut moved).sum()
}

const PLAY_RAD: f64 = 0.05;

fn backlash_takes_its_play_at_each_reversal() -> bool {
    let (ahead, back) = ([V; 50], [-V; 50]);
    let mut memory = Memory::default();
    // A wheel that always drags. Engaged from the start; backwards the ground stays ahead by the play, forwards behind.
    let mut drags = |speeds: &[f64]| ahead_by_play(&mut memory, 10.0, speeds);
    let reversals = drags(&ahead) == 0.0
        && same(drags(&back), PLAY_RAD)
        && same(drags(&ahead), -PLAY_RAD)
        && drags(&ahead) == 0.0;
    // One that slows down by 0.1 m/s^2 of itself, braked by 0.2: ahead by the play, at rest and backwards, behind when it
    // is driven forwards again. Braked by 0.05 it stays behind.
    let ramp = |per_step_mps: f64, from_mps: f64| -> Vec<f64> {
        (1..=50).map(|k| from_mps + per_step_mps * f64::from(k)).collect()
    };
    let mut memory = Memory::default();
    let mut rolls = |speeds: &[f64]| ahead_by_play(&mut memory, 0.1, speeds);
    let braked = rolls(&ahead) == 0.0
        && rolls(&ramp(-0.0005, V)) == 0.0
        && same(rolls(&ramp(-0.002, V - 0.025)), PLAY_RAD)
        && rolls(&back) == 0.0
        && same(rolls(&ahead), -PLAY_RAD);
    reversals && braked
}

/// Travel of each wheel since angle zero, after each of so many steps \[m\].
fn travels(
    id: &str,
    values: &[f64],
    gear: f64,
    dphi_rad: f64,
    steps: usize,
) -> Vec<WheelPair<f64>> {
    let terms = [Term::new(find(id).unwrap(), values.into())];
    let mut composer = Composer::new(Terms::Fixed(&terms));
    let (mut phi, mut sum) = (0.0, WheelPair::both(0.0));
    (0..steps)
        .map(|_| {
            let step = Step {
                phi_rad: WheelPair::both(phi),
                dphi_rad: WheelPair::both(dphi_rad),
                wheel_radius_m: ROBOT.wheel_radius_m,
                track_width_m: ROBOT.track_width_m,
                gear_reduction: gear,
                ..Step::default()
            };
            phi += dphi_rad;
            let increment = composer.step(&step);
            let half_m = increment.turn_rad * ROBOT.track_width_m / 2.0;
            sum = WheelPair::new(
                sum.left + increment.travel_m - half_m,
                sum.right + increment.travel_m + half_m,
            );
            sum
        })
        .collect()
}

/// Travel of each wheel over the first 0.3 rad, of nominal.
fn first_degrees(id: &str, values: &[f64]) -> WheelPair<f64> {
    let travel = travels(id, values, 1.0, 0.3, 1)[0];
    // To the last digits, which sums and differences of both wheels cost.
    travel.map(|travel_m| (travel_m / (0.3 * ROBOT.wheel_radius_m) * 1e12).round() / 1e12)
}

/// A disk of radius R rolls without slip; its axle sits e off its centre, in the direction alpha from
/// straight ahead, upwards positive, when phi is zero. Then the centre is at R phi, and
///
/// ```text
/// axle = R phi + e cos(alpha - phi)
/// ```
///
/// which is the radius seen by the axle, R + e sin(alpha - phi): c = e/R sin alpha, s = -e/R cos alpha.
#[test]
fn an_axle_off_the_centre_leads_and_lags_as_a_rolling_disk_does() {
    let radius_m = ROBOT.wheel_radius_m;
    let e_m = 0.01 * radius_m;
    let signs = [1.0, -1.0];
    for (alpha, way) in
        [0.0, 0.7, FRAC_PI_2, 3.0, -2.0].into_iter().flat_map(|alpha| signs.map(|way| (alpha, way)))
    {
        let other = alpha + 1.1;
        let pair = |alpha: f64| [e_m / radius_m * alpha.sin(), -e_m / radius_m * alpha.cos()];
        let values = [pair(alpha), pair(other)].concat();
        let dphi = way * 0.4;
        let axle = |alpha: f64, phi: f64| radius_m * phi + e_m * (alpha - phi).cos();
        for (k, travel) in travels("wheel_eccentricity", &values, 1.0, dphi, 40).iter().enumerate()
        {
            let phi = (k + 1) as f64 * dphi;
            for (got, alpha) in [(travel.left, alpha), (travel.right, other)] {
                // Forty roundings of a metre's parts.
                let error = got - (axle(alpha, phi) - axle(alpha, 0.0));
                assert!(error.abs() < 1e-14, "{alpha} {phi}: {error:e}");
            }
        }
    }
}

/// A disk of marks, centred e off the shaft in the direction alpha from the reading head, which is h away
/// from the shaft: at shaft angle theta the head stands at the angle
///
/// ```text
/// beta = atan2(-e sin(theta + alpha), h - e cos(theta + alpha)),  reads theta - beta + beta(0)
/// ```
///
/// To first order in e/h the wheel's angle grows by 1 - e/h cos(reading + alpha) for each that is read:
/// c = -e/h cos alpha, s = e/h sin alpha.
#[test]
fn a_disk_of_marks_off_the_shaft_leads_and_lags_once_a_turn_of_the_encoder() {
    let radius_m = ROBOT.wheel_radius_m;
    for (gear, off) in [(1.0, 1e-3), (43.7, 1e-3), (3.0, 2e-3)] {
        for alpha in [0.0, 0.7, 2.0, -2.0] {
            let beta = |theta: f64| {
                let at = theta + alpha;
                (-off * at.sin()).atan2(1.0 - off * at.cos())
            };
            let reads = |theta: f64| theta - beta(theta) + beta(0.0);
            let pair = |alpha: f64| [-off * alpha.cos(), off * alpha.sin()];
            let values = [pair(alpha), [0.0; 2]].concat();
            let mut most: f64 = 0.0;
            for theta in [0.5, 1.7, 2.9, 4.4, 6.0, 9.0] {
                let read_rad = reads(theta) / gear;
                let travel = travels("encoder_eccentricity", &values, gear, read_rad / 3.0, 3)[2];
                let lead_m = radius_m * theta / gear - radius_m * read_rad;
                most = most.max(lead_m.abs());
                // What is left is of second order: e/h times the lead and its own turn of two.
                let error = travel.left - radius_m * read_rad - lead_m;
                assert!(error.abs() < 4.0 * off * off * radius_m / gear, "{gear} {alpha} {theta}");
                assert!(same(travel.right, radius_m * read_rad));
            }
            assert!(most > 0.8 * off * radius_m / gear, "the ripple was seen");
        }
    }
}

#[test]
fn an_eccentric_wheel_has_no_error_after_each_full_turn() {
    // One turn of the wheel in a hundred steps or in three: the mean over each step is exact.
    for steps in [100, 3] {
        let values = [0.01, 0.02, -0.01, 0.005];
        let travel = travels("wheel_eccentricity", &values, 1.0, TAU / steps as f64, steps);
        let nominal_m = ROBOT.wheel_radius_m * TAU;
        let end = travel[steps - 1];
        // A hundred roundings of 2 mm.
        assert!((end.left - nominal_m).abs() < 1e-14 && (end.right - nominal_m).abs() < 1e-14);
    }
}
