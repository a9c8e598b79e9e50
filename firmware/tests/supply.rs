//! Which supply a configuration admits, and whether the duty is scaled by it.

use firmware::shared::SupplyLimits;
use shared_proto::Config;

#[test]
fn zeros_mean_no_limit_and_a_supply_that_is_not_measured_scales_nothing() {
    let mut config = Config::default();
    let limits = SupplyLimits::new(&config);
    assert_eq!((limits.min, limits.max, limits.nominal), (9000, 18_500, 12_000));
    assert!([9000, 12_000, 18_500].into_iter().all(|supply_mv| limits.admits(supply_mv)));
    assert!([0, 8999, 18_501].into_iter().all(|supply_mv| !limits.admits(supply_mv)));

    config.protection.supply_v_max = 0.0;
    assert!(SupplyLimits::new(&config).admits(u16::MAX));

    // Without a divider the measurement is of nothing.
    config.protection.supply_v_min = 0.0;
    let limits = SupplyLimits::new(&config);
    assert!(limits.admits(0));
    assert_eq!(limits.nominal, 0);
}
