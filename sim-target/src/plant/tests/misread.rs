//! Encoders that do not tell the truth: each against the angle that is there.

use core::f64::consts::TAU;

use shared_proto::WheelPair;

use super::rig::{drive, robot};
use crate::plant::{EncoderParameters, PlantParameters};

fn with(encoder: EncoderParameters) -> PlantParameters {
    PlantParameters { encoder: WheelPair::both(encoder), ..PlantParameters::default() }
}

/// The largest and the smallest error of the count over a way, as wheel angle, and the share of it at the
/// end.
fn errors(encoder: EncoderParameters, duty: f64) -> (f64, f64, f64) {
    let mut plant = robot(with(encoder));
    let per_rad = encoder.counts_per_rev * encoder.gear_reduction / TAU;
    let (mut low, mut high, mut error) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for _ in 0..4000 {
        drive(&mut plant, duty, duty, 1000);
        let angle = plant.wheel_angles_rad().left;
        error = (plant.counts().left as f64 + 0.5) / per_rad - angle;
        (low, high) = (low.min(error), high.max(error));
    }
    (low, high, error / plant.wheel_angles_rad().left)
}

fn fine() -> EncoderParameters {
    EncoderParameters { counts_per_rev: 4000.0, phase: Some(0.0), ..EncoderParameters::default() }
}

#[test]
fn a_disc_off_its_shaft_errs_by_its_eccentricity_once_per_encoder_turn() {
    for gear_reduction in [1.0, 4.0] {
        let mut encoder = EncoderParameters { gear_reduction, ..fine() };
        encoder.error.eccentricity = 0.02;
        let (low, high, _) = errors(encoder, 0.5);
        // Zero at the start, with a phase of zero: +-e, over the gear; half a count of rounding.
        for extreme in [-low, high] {
            assert!((extreme * gear_reduction - 0.02).abs() < 0.0012, "{low} {high}");
        }
    }
}

#[test]
fn a_magnet_errs_twice_a_turn_and_teeth_as_often_as_there_are() {
    let crossings = |encoder: EncoderParameters, amplitude: f64| {
        let mut plant = robot(with(encoder));
        let (mut above, mut upwards) = (true, 0);
        while plant.wheel_angles_rad().left < TAU {
            drive(&mut plant, 0.1, 0.1, 1000);
            let counted = (plant.counts().left as f64 + 0.5) * TAU / encoder.counts_per_rev;
            let error = counted - plant.wheel_angles_rad().left;
            // With room for rounding, so that one crossing is one.
            if error > 0.3 * amplitude && !above {
                (above, upwards) = (true, upwards + 1);
            } else if error < -0.3 * amplitude {
                above = false;
            }
        }
        upwards
    };
    let mut magnet = fine();
    magnet.error.two_per_turn_rad = 0.01;
    // The first rise starts from zero and is not counted.
    assert_eq!(crossings(magnet, 0.01), 1);
    let mut teeth = fine();
    (teeth.error.mesh_rad, teeth.error.mesh_teeth) = (0.01, 11.0);
    assert_eq!(crossings(teeth, 0.01), 10);
}

#[test]
fn lines_get_lost_above_a_speed_and_in_proportion_to_what_is_above_it() {
    // From 5 rad/s on.
    let onset_rad_s = 5.0;
    let filtered = EncoderParameters {
        filter_s: 0.2 * TAU / (onset_rad_s * 4000.0),
        thin_line_share: 0.2,
        ..fine()
    };
    let mut lost = [0.0; 3];
    for (i, duty) in [0.3, 0.6, 1.0].into_iter().enumerate() {
        let mut plant = robot(with(filtered));
        drive(&mut plant, duty, duty, 3_000_000);
        let (counts, angle) = (plant.counts().left, plant.wheel_angles_rad().left);
        drive(&mut plant, duty, duty, 6_000_000);
        let way = (plant.wheel_angles_rad().left - angle) * 4000.0 / TAU;
        lost[i] = 1.0 - (plant.counts().left - counts) as f64 / way;
        let spin = plant.wheel_speeds_rad_s().left;
        // The share of thin lines that are narrower than the filter lets pass.
        let expected = 0.2 * (0.2 * spin / onset_rad_s - 0.2).max(0.0) / 0.8;
        // 800 thin lines by chance: 3.2 % of their number, and sqrt(n) of those concerned; 4 of these.
        let sigma = (expected / 4000.0).sqrt() + 1e-4;
        assert!((lost[i] - expected).abs() < 4.0 * sigma, "{} at {spin}: {expected}", lost[i]);
    }
    assert_eq!((lost[0] * 1e4).round(), 0.0, "nothing below the onset: {}", lost[0]);
    assert!(lost[2] > lost[1] && lost[1] > 0.005, "{lost:?}");
}

#[test]
fn going_back_loses_as_much_the_other_way_and_edges_tell_of_it() {
    let filtered =
        EncoderParameters { filter_s: 0.2 * TAU / (3.0 * 4000.0), thin_line_share: 0.2, ..fine() };
    let mut plant = robot(with(filtered));
    drive(&mut plant, 0.8, 0.8, 2_000_000);
    let missed = plant.wheel_angles_rad().left * 4000.0 / TAU - plant.counts().left as f64;
    assert!(missed > 50.0, "{missed}");
    drive(&mut plant, -0.8, -0.8, 4_000_000);
    let left = plant.counts().left as f64 - plant.wheel_angles_rad().left * 4000.0 / TAU;
    assert!(left > 0.0, "backwards it falls behind as well: {left}");
    for _ in 0..100 {
        drive(&mut plant, -0.8, -0.8, 1000);
        let step = plant.encoder_step(shared_proto::Wheel::Left);
        let last = step.edges().last().map_or(step.count_before, |edge| edge.count);
        assert_eq!(last, step.count_after);
    }
}
