//! Plans of a robot with a heading pull.

use firmware::profile::{Plan, ProfileState};
use firmware::units::Travel;
use proptest::prelude::*;
use shared_proto::{Config, MotionError, WheelPair};

use super::reference::*;
use super::*;

fn pulled(track_width_m: f64, heading_pull_rad_per_m: f64) -> Config {
    let mut config = fast_config();
    config.geometry.track_width_m = track_width_m;
    config.geometry.heading_pull_rad_per_m = heading_pull_rad_per_m;
    config
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn a_pull_is_steered_against_over_the_whole_way_and_where_it_leads_stays(
        (left, right, cruise, a) in drives(), track in 0.02..5.0, pull in -0.1..0.1, start in any::<u32>(),
        share in 0.0..1.0,
    ) {
        let drive = order(left, right, cruise, a);
        let plan = match Plan::drive(start, at_rest(), &drive, &pulled(track, pull)) {
            Ok(plan) => plan,
            Err(MotionError::NoDistance | MotionError::TooLong) => return Ok(()),
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        };
        // By itself it turns by c |s| more than its wheels do: after the whole way and on it.
        let turns = |state: WheelPair<ProfileState>| {
            let (l, r) = (position_m(state.left), position_m(state.right));
            (r - l, (r + l) / 2.0)
        };
        let (wheels, path) = turns(plan.at(plan.end_tick()));
        prop_assert!((path - (left + right) / 2.0).abs() <= 1e-9, "{path}");
        let turned = wheels + track * pull * path.abs();
        prop_assert!((turned - (right - left)).abs() <= 1e-9, "{turned}");
        let on_the_way = start.wrapping_add((share * f64::from(plan.end_tick().wrapping_sub(start))) as u32);
        let (wheels_so_far, path_so_far) = turns(plan.at(on_the_way));
        // Where phases meet, the rounding of the longest ramp shows as 54 nm a wheel (`profile`); here and in the stop.
        let rounding = 8.0 * 60e-9 * (1.0 + path.abs() + wheels.abs());
        prop_assert!((wheels_so_far * path - wheels * path_so_far).abs() <= rounding);
        // The farther wheel keeps to the limits.
        let state = plan.at(on_the_way);
        prop_assert!(state.all(|state| speed_mps(state).abs() <= cruise * (1.0 + 1e-12)));
        // A stop keeps the proportion.
        let stop = Plan::stop(on_the_way, state, a);
        let (wheels_stopped, path_stopped) = turns(stop.at(stop.end_tick()));
        prop_assert!((wheels_stopped * path - wheels * path_stopped).abs() <= rounding);
    }

    #[test]
    fn no_pull_and_no_way_change_no_bit_of_a_plan(
        (left, right, cruise, a) in drives(), track in 0.02..5.0, pull in -0.1..0.1,
        v_left in prop_oneof![-20.0..20.0, Just(0.0)], v_right in prop_oneof![-20.0..20.0, Just(0.0)],
        shares in prop::collection::vec(0.0..1.0, 10),
    ) {
        let from = WheelPair::new(moving(v_left), moving(v_right));
        let plan = |left: f64, right: f64, config: &Config| {
            Plan::drive(0, from, &order(left, right, cruise, a), config)
        };
        // Whatever the track is; and a spin has no way.
        let pairs = [
            (plan(left, right, &fast_config()), plan(left, right, &pulled(track, 0.0))),
            (plan(left, right, &fast_config()), plan(left, right, &pulled(track, -0.0))),
            (plan(-right, right, &fast_config()), plan(-right, right, &pulled(track, pull))),
        ];
        for (plain, steered) in pairs {
            let (plain, steered) = match (plain, steered) {
                (Ok(plain), Ok(steered)) => (plain, steered),
                (Err(plain), Err(steered)) => { prop_assert_eq!(plain, steered); continue }
                other => return Err(TestCaseError::fail(format!("{other:?}"))),
            };
            prop_assert_eq!(plain.end_tick(), steered.end_tick());
            for share in shares.iter().chain(&[0.0, 1.0]) {
                let tick = (share * f64::from(plain.end_tick())) as u32;
                prop_assert_eq!(plain.at(tick), steered.at(tick));
            }
        }
    }
}

#[test]
fn a_robot_that_is_pulled_to_the_left_rolls_its_left_wheel_farther_both_ways() {
    // 0.372 m x 0.02 rad/m x 1.5 m / 2 = 5.58 mm
    for sign in [1.0, -1.0] {
        let drive = order(1.5 * sign, 1.5 * sign, 0.4, 0.3);
        let plan = Plan::drive(0, at_rest(), &drive, &pulled(0.372, 0.02)).unwrap();
        let target = plan.target().map(Travel::to_si);
        assert!((target.left - (1.5 * sign + 0.005_58)).abs() < 1e-9, "{target:?}");
        assert!((target.right - (1.5 * sign - 0.005_58)).abs() < 1e-9, "{target:?}");
    }
}
