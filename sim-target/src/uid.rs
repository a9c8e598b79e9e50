//! A simulated robot's unique number.

use crate::scenario::Scenario;

/// A unique number, as a chip has, for each robot and each seed. Faults do not change the number.
pub(crate) fn uid(scenario: &Scenario) -> [u8; 12] {
    let robot = Scenario { seed: 0, faults: Vec::new(), ..scenario.clone() };
    // FNV-1a of 64 bits: the same on every machine.
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in format!("{robot:?}").bytes() {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    let mut uid = *b"sim:\0\0\0\0\0\0\0\0";
    uid[4..].copy_from_slice(&(hash ^ scenario.seed).to_be_bytes());
    uid
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::PlantFault;
    use crate::scenario::{FaultClock, ScheduledFault};

    #[test]
    fn another_seed_or_scenario_is_another_robot_and_a_broken_one_is_the_same() {
        let robot = Scenario::default();
        let mut other = robot.clone();
        other.plant.geometry.track_width_m *= 1.01;
        let seeded = Scenario { seed: robot.seed + 1, ..robot.clone() };
        assert_ne!(uid(&robot), uid(&other));
        assert_ne!(uid(&robot), uid(&seeded));
        assert_ne!(uid(&other), uid(&seeded));
        let mut broken = robot.clone();
        broken.faults.push(ScheduledFault {
            fault: PlantFault::SupplyDip { volts: 1.0 },
            clock: FaultClock::Simulated,
            at_s: 1.0,
            until_s: None,
        });
        assert_eq!(uid(&robot), uid(&broken));
    }
}
