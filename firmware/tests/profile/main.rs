//! The fixed-point profile against plain formulas in f64, over the whole range of accepted inputs.

mod pull;
mod reference;

use firmware::profile::{Plan, Profile, ProfileState, Setpoint};
use firmware::units::Travel;
use proptest::prelude::*;
use shared_proto::{Config, Drive, MotionError, TravelUnit, WheelPair};

use reference::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn from_rest_position_is_within_a_count_of_plain_formulas_over_10_km(
        (left, right, cruise, a) in drives(), shares in prop::collection::vec(0.0..1.0, 10), start in any::<u32>(),
    ) {
        let plan = match Plan::drive(start, at_rest(), &order(left, right, cruise, a), &fast_config()) {
            Ok(plan) => plan,
            Err(MotionError::NoDistance) => { prop_assert!(left == 0.0 && right == 0.0); return Ok(()) }
            Err(MotionError::TooLong) => {
                let far = left.abs().max(right.abs());
                let ramp_s = cruise.min((a * far).sqrt()) / a;
                prop_assert!(ramp_s > 999.0 || far / cruise + ramp_s > 1.99e6);
                return Ok(())
            }
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        };
        let far = left.abs().max(right.abs());
        let lead = Reference::quickest(0.0, far, cruise, a);
        let shares_of = WheelPair::new(left / far, right / far);
        for tick in ticks_of_interest(&WheelPair::both(lead), &shares) {
            let (s, v) = lead.state(f64::from(tick) / HZ);
            let state = plan.at(start.wrapping_add(tick));
            for (state, share) in [(state.left, shares_of.left), (state.right, shares_of.right)] {
                prop_assert!((position_m(state) - s * share).abs() < COUNT_M);
                // The acceleration is known to 2^-63 m/tick^2, which counts over a ramp's ticks.
                let ramped_mps = lead.vc.abs() / a * HZ * 0.5f64.powi(63) * HZ;
                let speed_tolerance_mps = 1e-12 + 2.0 * ramped_mps + a * boundary_s(cruise, lead.duration_s);
                prop_assert!((speed_mps(state) - v * share).abs() < speed_tolerance_mps);
                prop_assert!(speed_mps(state).abs() <= cruise * (1.0 + 1e-12));
            }
        }
        prop_assert!(ends_at(&plan, WheelPair::new(left, right)));
        let end = plan.at(plan.end_tick());
        prop_assert!(speed_mps(end.left) == 0.0 && speed_mps(end.right) == 0.0);
        let late = f64::from(plan.end_tick().wrapping_sub(start)) - lead.duration_s * HZ;
        prop_assert!((-1e-3..1.001).contains(&late), "{late} ticks late");
    }

    #[test]
    fn from_any_motion_both_wheels_meet_plain_formulas_and_end_together(
        (left, right, cruise, a) in drives(),
        v_left in -20.0..20.0, v_right in prop_oneof![-20.0..20.0, Just(0.0)],
        shares in prop::collection::vec(0.0..1.0, 10), start in any::<u32>(),
    ) {
        // From rest the wheels keep a proportion instead: see above.
        prop_assume!(v_left != 0.0 || v_right != 0.0);
        let from = WheelPair::new(moving(v_left), moving(v_right));
        let plan = match Plan::drive(start, from, &order(left, right, cruise, a), &fast_config()) {
            Ok(plan) => plan,
            Err(MotionError::NoDistance) => return Ok(()),
            Err(MotionError::TooLong) => {
                let fastest = cruise.max(f64::abs(v_left)).max(f64::abs(v_right));
                prop_assert!(fastest / a > 999.0 || (left.abs().max(right.abs()) + fastest * fastest / a) / cruise > 1.9e6);
                return Ok(())
            }
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        };
        let (l, r) = (Reference::quickest(v_left, left, cruise, a), Reference::quickest(v_right, right, cruise, a));
        let duration_s = l.duration_s.max(r.duration_s);
        let references = WheelPair::new(l.stretched(left, duration_s), r.stretched(right, duration_s));
        // Bisection in f64 knows positions to about 1e-16 of the farthest way there and back.
        let reach = 4.0 * (1e4 + 400.0 / a) + cruise * duration_s;
        let tolerance_m = COUNT_M + reach * 1e-15;
        for tick in ticks_of_interest(&references, &shares) {
            let state = plan.at(start.wrapping_add(tick));
            for (state, reference) in [(state.left, references.left), (state.right, references.right)] {
                let (s, v) = reference.state(f64::from(tick) / HZ);
                prop_assert!((position_m(state) - s).abs() < tolerance_m, "{tick}: {} {s}", position_m(state));
                let limit = cruise.max(reference.v0.abs());
                prop_assert!(speed_mps(state).abs() <= limit * (1.0 + 1e-12));
                // At the top of a triangle velocity is the root of a distance, and as uncertain.
                let uncertain = (reach * 1e-15 * a).sqrt() + (1e-15 * reach / duration_s) + 1e-9 * a;
                prop_assert!((speed_mps(state) - v).abs() < 1e-8 + 4.0 * uncertain, "{tick}: {} {v}", speed_mps(state));
            }
        }
        let late = f64::from(plan.end_tick().wrapping_sub(start)) - duration_s * HZ;
        prop_assert!((-1e-2..1.01).contains(&late), "{late} ticks late");
        prop_assert!(ends_at(&plan, WheelPair::new(left, right)));
    }

    #[test]
    fn a_new_command_or_stop_mid_motion_jumps_neither_in_position_nor_in_velocity(
        (left, right, cruise, a) in (-3.0..3.0, -3.0..3.0, 0.05..2.0, 0.2..20.0),
        (left2, right2, cruise2, a2) in (-3.0..3.0, -3.0..3.0, 0.05..2.0, 0.2..20.0),
        when in 0.0..1.0, stop_at in 0.0..1.0, start in any::<u32>(),
    ) {
        let config = fast_config();
        let first = Plan::drive(start, at_rest(), &order(left, right, cruise, a), &config).unwrap();
        let length = |plan: &Plan| f64::from(plan.end_tick().wrapping_sub(plan.start_tick()));
        let switch = start.wrapping_add((when * length(&first)) as u32);
        let second = Plan::drive(switch, first.at(switch), &order(left2, right2, cruise2, a2), &config).unwrap();
        let stop_tick = switch.wrapping_add((stop_at * length(&second)) as u32);
        let deceleration = a.max(a2);
        let stop = Plan::stop(stop_tick, second.at(stop_tick), deceleration);

        let mut profile = Profile::new(first.clone());
        let mut last: Option<WheelPair<Setpoint>> = None;
        for n in 0..stop.end_tick().wrapping_sub(start) + 3 {
            let tick = start.wrapping_add(n);
            if tick == switch { profile.replace(&second) }
            if tick == stop_tick { profile.replace(&stop) }
            let now = profile.setpoints(tick);
            if let Some(last) = last {
                for (last, now) in [(last.left, now.left), (last.right, now.right)] {
                    check_step(last, now, deceleration)?;
                }
            }
            last = Some(now);
        }
        prop_assert_eq!(last.unwrap().map(|s| s.travel), stop.target());
        // Both wheels brake in proportion: the same curvature to the end.
        let (from, to) = (second.at(stop_tick), stop.at(stop.end_tick()));
        let braked = from.zip(to).map(|(from, to)| position_m(to) - position_m(from));
        let cross = braked.left * speed_mps(from.right) - braked.right * speed_mps(from.left);
        prop_assert!(cross.abs() < 1e-9, "{cross}");
    }

    #[test]
    fn stepping_equals_the_closed_form_bit_for_bit_even_across_missed_ticks(
        (left, right, cruise, a) in (-0.5..0.5, -0.5..0.5, 0.05..2.0, 0.05..50.0),
        start in any::<u32>(), miss in 2u32..50,
    ) {
        let plan = Plan::drive(start, at_rest(), &order(left, right, cruise, a), &fast_config()).unwrap();
        let mut profile = Profile::new(plan.clone());
        for n in 0..plan.end_tick().wrapping_sub(start) + 5 {
            if n % miss == 1 { continue }
            let tick = start.wrapping_add(n);
            let setpoint = profile.setpoints(tick);
            prop_assert_eq!(setpoint.map(|s| s.travel), plan.at(tick).map(|s| Travel::from(s.position)));
            prop_assert_eq!(profile.finished(tick), n >= plan.end_tick().wrapping_sub(start));
        }
    }
}

/// The target is the nearest step of travel; of two equally near ones either will do.
fn ends_at(plan: &Plan, target_m: WheelPair<f64>) -> bool {
    plan.target().zip(target_m).all(|(target, m)| (target.to_si() - m).abs() <= 0.5f64.powi(33))
}

fn moving(velocity_mps: f64) -> ProfileState {
    let mut state = ProfileState::default();
    state.velocity.0 = fixed::types::I0F64::from_num(velocity_mps / HZ);
    state
}

/// Velocity changes by at most a dt, and travel by the mean velocity, both to the last rounding.
fn check_step(last: Setpoint, now: Setpoint, a: f64) -> Result<(), TestCaseError> {
    let (v0, v1) = (last.speed.to_si(), now.speed.to_si());
    // Two roundings of 2^-25 m/s.
    prop_assert!((v1 - v0).abs() <= a / HZ + 6.1e-8, "velocity {v0} to {v1}");
    let rolled = (now.travel.0 - last.travel.0).to_num::<f64>();
    // The mean is off where a phase begins inside the tick, by a dt^2 / 4 for each of two wheels' bends.
    let bend = a / HZ / HZ / 2.0 + 1e-9;
    prop_assert!((rolled - (v0 + v1) / 2.0 / HZ).abs() <= bend, "rolled {rolled} at {v0} {v1}");
    prop_assert!(now.acceleration.to_si().abs() <= a + 6e-8);
    Ok(())
}

#[test]
fn the_papers_run_takes_20_475_s_with_ramps_of_5_178_s_and_a_cruise_of_10_118_s() {
    let drive = Drive {
        unit: TravelUnit::WheelRevolution,
        distance: WheelPair::both(8.0),
        cruise: 0.523,
        acceleration: 0.101,
        ..order(0.0, 0.0, 1.0, 1.0)
    };
    let plan = Plan::drive(0, at_rest(), &drive, &Config::default()).unwrap();
    // 8 / 0.523 + 0.523 / 0.101 = 20.4746 s: the first tick after it.
    assert_eq!(plan.end_tick(), 20_475);
    let mut profile = Profile::new(plan);
    let mut ticks = [0; 3];
    for tick in 0..20_475 {
        let acceleration = profile.setpoints(tick).left.acceleration.to_si();
        ticks[if acceleration > 0.0 {
            0
        } else if acceleration == 0.0 {
            1
        } else {
            2
        }] += 1;
    }
    for (ticks, expected) in ticks.into_iter().zip([5178, 10_118, 5178]) {
        assert!(i32::abs(ticks - expected) <= 1, "{ticks} for {expected}");
    }
    // 8 x 2 pi x 0.036 m
    assert!((profile.setpoints(20_475).right.travel.to_si() - 1.809_557_368).abs() < 1e-9);
}

#[test]
fn an_arcs_wheels_keep_their_proportion_at_every_tick() {
    let plan = Plan::drive(7, at_rest(), &order(1.5, -0.37, 0.4, 0.3), &Config::default()).unwrap();
    for tick in 7..plan.end_tick() {
        let state = plan.at(tick);
        let off = position_m(state.right) + position_m(state.left) * 0.37 / 1.5;
        // Roundings of phases, far below the step of travel.
        assert!(off.abs() < 2e-11, "{tick}: {off}");
    }
}

/// How far three positions in a row are from a line [m].
fn bends(plan: &Plan, tick: u32) -> [f64; 2] {
    let steps = |tick| plan.at(tick).map(|state| state.position.0.to_bits());
    let (before, here, after) = (steps(tick - 1), steps(tick), steps(tick + 1));
    let bend = |before: i128, here: i128, after: i128| {
        (after - 2 * here + before).unsigned_abs() as f64 * 0.5f64.powi(64)
    };
    [bend(before.left, here.left, after.left), bend(before.right, here.right, after.right)]
}

#[test]
fn where_two_phases_meet_positions_fit_to_the_rounding_of_acceleration_and_of_double_precision() {
    for (left, right, cruise, a) in [
        (1e4, -9e3, 0.02, 1e-3),
        (1e4, 7.0, 20.0, 0.1),
        (2e4, 2e4, 0.4, 0.5),
        (2.0, 1.9, 0.3, 0.2),
        (0.01, 0.01, 0.3, 0.2),
    ] {
        let plan =
            Plan::drive(0, at_rest(), &order(left, right, cruise, a), &fast_config()).unwrap();
        let lead = Reference::quickest(0.0, left, cruise, a);
        let ramp_ticks = lead.vc / a * HZ;
        let fits_m = ramp_ticks.powi(2) * 0.5f64.powi(64) + left * 0.5f64.powi(51);
        for tick in ticks_of_interest(&WheelPair::both(lead), &[]) {
            for bend_m in bends(&plan, tick.max(1)) {
                assert!(bend_m <= a / HZ / HZ + fits_m, "{left} {cruise} {a} {tick}: {bend_m}");
            }
        }
    }
    // From motion, where one wheel has to wait for the other.
    let from = WheelPair::new(moving(0.5), moving(-0.2));
    let plan = Plan::drive(0, from, &order(3.0, 2.0, 0.6, 0.4), &fast_config()).unwrap();
    for tick in 1..plan.end_tick() + 2 {
        for bend_m in bends(&plan, tick) {
            assert!(bend_m <= 0.4 / HZ / HZ + 1e-12, "{tick}: {bend_m}");
        }
    }
}

#[test]
fn a_wheel_that_cannot_brake_in_time_goes_beyond_and_comes_back() {
    let from = WheelPair::new(moving(0.5), moving(0.5));
    let plan = Plan::drive(0, from, &order(0.05, 0.05, 0.4, 0.5), &Config::default()).unwrap();
    let farthest = (0..plan.end_tick()).map(|t| position_m(plan.at(t).left)).fold(0.0, f64::max);
    // v^2 / 2a = 0.25 m, sampled within half a tick of the turning point.
    assert!((farthest - 0.25).abs() < 1e-6, "{farthest}");
    assert_eq!(plan.target().left, Travel::from_si(0.05));
}

#[test]
fn standing_still_lasts_for_ever() {
    let plan = Plan::drive(0, at_rest(), &order(0.1, 0.1, 0.4, 0.5), &Config::default()).unwrap();
    let (target, end) = (plan.target(), plan.end_tick());
    let mut profile = Profile::new(plan);
    for tick in [0, 10, end, end + 1, end + (1 << 30), end + (3 << 30), end.wrapping_sub(1), 5] {
        let setpoint = profile.setpoints(tick);
        assert!(
            tick < end && tick == 0 || tick == 10 || setpoint.map(|s| s.travel) == target,
            "{tick}"
        );
    }
    assert!(profile.finished(5));
    // Whatever the tick, nothing is waited for.
    let here = WheelPair::both(Travel::from_si(3.0));
    profile.replace(&Plan::hold(here));
    assert!(profile.finished(3 << 30));
    assert_eq!(profile.setpoints(3 << 30).map(|s| s.travel), here);
}

#[test]
fn each_impossible_motion_is_refused_by_name() {
    let config = Config::default();
    let good = order(1.0, 1.0, 0.4, 0.5);
    let refuse = |drive: Drive| Plan::drive(0, at_rest(), &drive, &config).err();
    assert_eq!(refuse(good), None);
    for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        assert_eq!(refuse(Drive { cruise: bad, ..good }), Some(MotionError::NotPositive));
        assert_eq!(refuse(Drive { acceleration: bad, ..good }), Some(MotionError::NotPositive));
    }
    assert_eq!(
        refuse(Drive { distance: WheelPair::new(f64::NAN, 1.0), ..good }),
        Some(MotionError::NotPositive)
    );
    assert_eq!(
        refuse(Drive { distance: WheelPair::both(0.0), ..good }),
        Some(MotionError::NoDistance)
    );
    assert_eq!(
        refuse(Drive { distance: WheelPair::new(20_001.0, 1.0), ..good }),
        Some(MotionError::TooFar)
    );
    assert_eq!(refuse(Drive { cruise: 0.41, ..good }), Some(MotionError::TooFast));
    assert_eq!(refuse(Drive { acceleration: 1.01, ..good }), Some(MotionError::TooSteep));
    assert_eq!(
        refuse(Drive { acceleration: 1e-7, cruise: 0.01, ..good }),
        Some(MotionError::TooLong)
    );
    assert_eq!(refuse(Drive { cruise: 1e-9, ..good }), Some(MotionError::TooLong));
    assert_eq!(
        refuse(Drive { cruise: 1e-300, acceleration: 1e-300, ..good }),
        Some(MotionError::TooLong)
    );
}
