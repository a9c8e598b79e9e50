use core::f64::consts::TAU;

use shared_proto::{Wheel, WheelPair};

use super::rig::{drive, robot};
use crate::plant::{PlantFault, PlantParameters};

fn geared(phase: f64) -> PlantParameters {
    let mut parameters = PlantParameters::default();
    for encoder in [&mut parameters.encoder.left, &mut parameters.encoder.right] {
        encoder.counts_per_rev = 64.0;
        encoder.gear_reduction = 43.7;
        encoder.phase = Some(phase);
    }
    parameters
}

#[test]
fn the_count_is_the_floor_of_the_angle_for_fractional_gears_too() {
    for phase in [0.0, 0.37, 1.0] {
        let mut plant = robot(geared(phase));
        for duty in [0.7, -0.9, 0.2] {
            for _ in 0..300 {
                drive(&mut plant, duty, -duty, 3_000);
                let position = plant.wheel_angles_rad().map(|a| a * 64.0 * 43.7 / TAU + phase);
                // Counts start at zero wherever the phase does.
                let expected = position.map(|p| p.floor() as i64 - phase.floor() as i64);
                assert_eq!(plant.counts(), expected);
            }
        }
    }
}

#[test]
fn a_reversed_encoder_counts_down() {
    let mut parameters = geared(0.5);
    parameters.encoder.right.reversed = true;
    let mut plant = robot(parameters);
    drive(&mut plant, 0.5, 0.5, 2_000_000);
    assert!(plant.counts().left > 1000);
    assert!((plant.counts().left + plant.counts().right).abs() <= 1, "{:?}", plant.counts());
}

#[test]
fn every_edge_comes_when_a_finer_look_sees_it() {
    for (duty, reversed) in [(0.9, false), (-0.9, false), (0.9, true)] {
        let mut parameters = geared(0.25);
        parameters.encoder.left.reversed = reversed;
        let mut plant = robot(parameters);
        drive(&mut plant, duty, duty, 1_000_000);
        let mut fine = plant.clone();
        plant.advance_to(1_000_500);
        let step = plant.encoder_step(Wheel::Left);
        let edges: Vec<_> = step.edges().collect();
        assert!(edges.len() >= 2, "{edges:?}");
        assert_eq!(edges.last().map(|edge| edge.count), Some(step.count_after));
        let mut seen = Vec::new();
        for t_us in 1_000_001..=1_000_500 {
            let before = fine.counts().left;
            fine.advance_to(t_us);
            if fine.counts().left != before {
                seen.push((t_us as f64, fine.counts().left));
            }
        }
        assert_eq!(seen.len(), edges.len());
        for (edge, (t_us, count)) in edges.iter().zip(seen) {
            assert_eq!(edge.count, count);
            // The finer sampling is late by up to a microsecond.
            assert!((t_us - edge.t_us - 0.5).abs() < 0.8, "{edge:?} seen at {t_us}");
        }
    }
}

#[test]
fn a_step_without_edges_has_none() {
    let mut plant = robot(geared(0.5));
    plant.advance_to(1000);
    let step = plant.encoder_step(Wheel::Right);
    assert_eq!((step.count_before, step.count_after), (0, 0));
    assert_eq!(step.edges().count(), 0);
}

#[test]
fn an_unplugged_encoder_stands_still_and_goes_on_from_there() {
    let mut plant = robot(geared(0.5));
    drive(&mut plant, 0.5, 0.5, 1_000_000);
    plant.inject(PlantFault::EncoderUnplugged(Wheel::Left));
    let at_unplugging = plant.counts();
    drive(&mut plant, 0.5, 0.5, 1_000_000);
    assert_eq!(plant.counts().left, at_unplugging.left);
    assert_eq!(plant.encoder_step(Wheel::Left).edges().count(), 0);
    let missed = plant.counts().right - at_unplugging.right;
    assert!(missed > 1000);
    plant.remove(PlantFault::EncoderUnplugged(Wheel::Left));
    assert_eq!(plant.counts().left, at_unplugging.left, "no jump when the plug goes in");
    drive(&mut plant, 0.5, 0.5, 1_000_000);
    let behind = plant.counts().right - plant.counts().left;
    assert!((behind - missed).abs() <= 1, "{behind}, {missed}");
}

#[test]
fn swapped_wires_count_the_other_way_without_a_jump() {
    let mut plant = robot(geared(0.5));
    drive(&mut plant, 0.5, 0.5, 1_000_000);
    let turning_point = plant.counts().left;
    plant.inject(PlantFault::EncoderReversed(Wheel::Left));
    assert_eq!(plant.counts().left, turning_point);
    drive(&mut plant, 0.5, 0.5, 1_000_000);
    let sum = plant.counts().left + plant.counts().right;
    assert!((sum - 2 * turning_point).abs() <= 2, "{sum}, {turning_point}");
    assert!(plant.counts().left < turning_point - 1000);
}

#[test]
fn noise_counts_at_its_rate_and_leaves_a_trace() {
    let mut plant = robot(geared(0.5));
    plant.inject(PlantFault::EncoderNoise(Wheel::Right, -2000.0));
    plant.advance_to(10_000_000);
    let false_counts = plant.counts().right;
    // A Poisson number of 20000: sigma 141, 4 of these.
    assert!((-20_566..=-19_434).contains(&false_counts), "{false_counts}");
    assert_ne!(false_counts, -20_000, "random, not a clock");
    plant.remove(PlantFault::EncoderNoise(Wheel::Right, 0.0));
    plant.advance_to(20_000_000);
    assert_eq!(plant.counts(), WheelPair::new(0, false_counts));
}

#[test]
fn false_counts_are_edges_as_well() {
    let mut plant = robot(geared(0.5));
    plant.inject(PlantFault::EncoderNoise(Wheel::Left, 50_000.0));
    drive(&mut plant, 0.6, 0.6, 1_000_000);
    plant.advance_to(1_001_000);
    let step = plant.encoder_step(Wheel::Left);
    let counts: Vec<_> = step.edges().map(|edge| edge.count).collect();
    let expected: Vec<_> = (step.count_before + 1..=step.count_after).collect();
    assert_eq!(counts, expected);
    assert!(counts.len() > 10, "{counts:?}");
}
