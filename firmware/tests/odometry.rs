//! Travel from counts, against exact integer arithmetic, over every accepted configuration.

use firmware::odometry::Odometry;
use proptest::prelude::*;
use shared_proto::{Config, WheelPair};

/// C * Q * W_T \[m\] in twice the precision of f64, by error-free products.
fn exact_m(counts: i64, q_m: f64, wheel_weight: f64) -> f64 {
    let (high, low) = product(q_m, wheel_weight);
    let (c_high, c_low) = ((counts >> 26) as f64 * 67_108_864.0, (counts & 0x3FF_FFFF) as f64);
    let parts =
        [product(c_high, high), product(c_low, high), product(c_high, low), product(c_low, low)];
    let rest: f64 = parts.iter().map(|part| part.1).sum();
    parts[0].0 + (parts[1].0 + (parts[2].0 + parts[3].0 + rest))
}

/// a b = high + low exactly.
fn product(a: f64, b: f64) -> (f64, f64) {
    let high = a * b;
    (high, a.mul_add(b, -high))
}

/// Every configuration that `validate` accepts, as far as odometry reads it.
fn configs() -> impl Strategy<Value = Config> {
    let weight = prop_oneof![0.8..=1.25, Just(0.9919), Just(1.0)];
    let q = (1e-6f64.ln()..0.1f64.ln()).prop_map(f64::exp);
    (0.005..=1.0, weight, q.clone(), q, 0.01..=1000.0f64).prop_filter_map(
        "counts per turn in range",
        |(radius, weight, q_left, q_right, reduction)| {
            let mut config = Config::default();
            config.geometry.wheel_radius_m = radius;
            config.geometry.wheel_weight = weight;
            for (encoder, q) in
                [(&mut config.encoder.left, q_left), (&mut config.encoder.right, q_right)]
            {
                encoder.gear_reduction = reduction;
                encoder.counts_per_rev = core::f64::consts::TAU * radius / (q * reduction);
            }
            config.validate().is_ok().then_some(config)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5000))]

    #[test]
    fn travel_is_counts_times_q_times_w_t_to_a_nanometre_over_10_km(
        config in configs(), left in -1e4..1e4, right in -1e4..1e4,
    ) {
        let q_m = WheelPair::new(
            config.meters_per_count(&config.encoder.left),
            config.meters_per_count(&config.encoder.right),
        );
        let counts = WheelPair::new((left / q_m.left) as i64, (right / q_m.right) as i64);
        let travel = Odometry::new(&config).travel(counts);
        for (travel, exact) in [
            (travel.left, exact_m(counts.left, q_m.left, 1.0)),
            (travel.right, exact_m(counts.right, q_m.right, config.geometry.wheel_weight)),
        ] {
            // Q W_T rounded to 2^-65 over 1.25e10 counts, and the result to 2^-33 m.
            prop_assert!((travel.to_si() - exact).abs() < 1.0e-9, "{} {exact}", travel.to_si());
        }
    }

    #[test]
    fn travel_is_the_exact_product_of_count_and_distance_per_count_rounded_once(
        config in configs(), left in any::<i64>(), right in any::<i32>(),
    ) {
        let odometry = Odometry::new(&config);
        let counts = WheelPair::new(left >> 14, i64::from(right));
        let q = odometry.meters_per_count();
        let rounded = |counts: i64, q: u64| (((i128::from(counts) * i128::from(q)) + (1 << 31)) >> 32) as i64;
        let travel = odometry.travel(counts);
        prop_assert_eq!(travel.left.0.to_bits(), rounded(counts.left, q.left.0.to_bits()));
        prop_assert_eq!(travel.right.0.to_bits(), rounded(counts.right, q.right.0.to_bits()));
    }

    #[test]
    fn no_count_overflows(config in configs(), left in any::<i64>(), right in any::<i64>()) {
        Odometry::new(&config).travel(WheelPair::new(left, right));
    }
}

#[test]
fn at_w_t_0_9919_the_right_wheel_turns_1_by_0_9919_as_far_for_the_same_travel_over_10_km() {
    let mut config = Config::default();
    config.geometry.wheel_weight = 0.9919;
    for counts_per_rev in [900.0, 4096.0, 226_194.0] {
        config.encoder.left.counts_per_rev = counts_per_rev;
        config.encoder.right.counts_per_rev = counts_per_rev;
        let odometry = Odometry::new(&config);
        let q_m = config.meters_per_count(&config.encoder.left);
        for kilometres in 1..=10 {
            let left = (f64::from(kilometres) * 1000.0 / q_m) as i64;
            let goal = odometry.travel(WheelPair::both(left)).left;
            // The right wheel's count at which its travel is the left one's.
            let at = |counts| odometry.travel(WheelPair::both(counts)).right;
            let (mut low, mut high) = (0, 2 * left);
            while high - low > 1 {
                let middle = (low + high) / 2;
                if at(middle) <= goal { low = middle } else { high = middle }
            }
            let expected = left as f64 / 0.9919;
            assert!((low as f64 - expected).abs() <= 1.0, "{low} for {expected}");
        }
    }
}

#[test]
fn a_wheel_weight_of_one_changes_nothing() {
    let odometry = Odometry::new(&Config::default());
    let q = odometry.meters_per_count();
    assert_eq!(q.left, q.right);
}

#[test]
fn a_change_of_1e_8_in_w_t_moves_10_km_by_a_tenth_of_a_millimetre() {
    let mut config = Config::default();
    let counts = WheelPair::both(39_788_736);
    config.geometry.wheel_weight = 0.9919;
    let before = Odometry::new(&config).travel(counts).right;
    config.geometry.wheel_weight = 0.991_900_01;
    let moved_m = Odometry::new(&config).travel(counts).right.to_si() - before.to_si();
    assert!((moved_m - 1e-4).abs() < 1e-8, "{moved_m}");
}
