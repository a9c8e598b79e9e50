//! docs/drivers.md says of each driver what this build does.

use shared_proto::{Driver, DriverFacts, Terminals};

fn words(terminals: Terminals) -> &'static str {
    match terminals {
        Terminals::Open => "coasts",
        Terminals::Shorted => "brakes",
        Terminals::Unknown => "as the driver does",
    }
}

#[test]
fn the_table_of_drivers_in_the_page_is_that_of_this_build() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/drivers.md");
    let page = std::fs::read_to_string(path).expect("docs/drivers.md is there");
    let rows = Driver::ALL.map(|driver| {
        let DriverFacts { between_pulses, standing, off, has_fault, pwm_hz_max, .. } =
            driver.facts();
        let fault = if has_fault { "yes" } else { "no" };
        let [between, standing, off] = [between_pulses, standing, off].map(words);
        let (name, khz) = (driver.name(), pwm_hz_max / 1000);
        format!("| `{name}` | {between} | {standing} | {off} | {khz} kHz | {fault} |")
    });
    let table = rows.join("\n");
    assert!(page.contains(&table), "docs/drivers.md should say:\n{table}");
    for driver in Driver::ALL {
        let rows = page.lines().filter(|row| row.starts_with(&format!("| `{}` |", driver.name())));
        assert_eq!(rows.count(), 2, "{}: its wiring, and what it does", driver.name());
    }
}

#[test]
fn every_driver_bears_the_frequency_of_the_factory_and_can_be_set_by_its_name() {
    for driver in Driver::ALL {
        let mut config = shared_proto::Config::default();
        config.driver.name = driver;
        assert_eq!(config.validate(), Ok(()), "{}", driver.name());
        let json = serde_json::to_value(config.driver).expect("a driver is JSON");
        assert_eq!(json["name"], driver.name());
    }
}
