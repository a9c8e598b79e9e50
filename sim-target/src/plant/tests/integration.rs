use shared_proto::WheelPair;

use super::rig::{drive, drive_paper_run, robot};
use crate::Scenario;
use crate::plant::{Plant, PlantParameters, Pose};

/// How far apart a run ends when the step is halved \[m\].
fn halving_m(parameters: &PlantParameters, run: impl Fn(&mut Plant)) -> f64 {
    let end = |substep_us: u32| {
        let mut plant = robot(PlantParameters { substep_us, ..parameters.clone() });
        run(&mut plant);
        plant.pose()
    };
    let (whole, half) = (end(parameters.substep_us), end(parameters.substep_us / 2));
    (whole.x_m - half.x_m).hypot(whole.y_m - half.y_m)
}

/// A tenth of a millimetre is a tenth of the camera's noise, so nobody can measure the step. Below a
/// nanometre the step would not be in effect at all.
fn is_fine(distance_m: f64) -> bool {
    (1e-9..1e-4).contains(&distance_m)
}

#[test]
fn halving_the_step_moves_the_papers_run_by_less_than_a_tenth_of_a_millimetre() {
    let paper = Scenario::default().plant;
    for (direction, gain) in [(1.0, 1.5), (-1.0, 1.5), (1.0, 0.0), (-1.0, 0.0)] {
        let apart_m = halving_m(&paper, |plant| {
            drive_paper_run(plant, WheelPair::both(direction), gain);
        });
        assert!(is_fine(apart_m), "{apart_m} m, direction {direction}, gain {gain}");
    }
}

#[test]
fn halving_the_step_changes_as_little_for_drawn_robots() {
    for seed in 0..5 {
        let drawn = Scenario::draw(seed).plant;
        let apart_m = halving_m(&drawn, |plant| {
            drive_paper_run(plant, WheelPair::both(1.0), 1.5);
        });
        assert!(is_fine(apart_m), "{apart_m} m, seed {seed}");
    }
}

#[test]
fn spins_arcs_and_wheelspin_converge_as_well() {
    let paper = Scenario::default().plant;
    for (left, right) in [(-0.3, 0.3), (0.4, 0.2), (1.0, 1.0)] {
        let apart_m = halving_m(&paper, |plant| {
            drive(plant, left, right, 2_000_000);
            drive(plant, 0.0, 0.0, 1_000_000);
        });
        assert!(is_fine(apart_m), "{apart_m} m, duty {left}, {right}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let run = |seed: u64| {
        let mut plant = Plant::new(Scenario::default().plant, Pose::default(), seed);
        drive(&mut plant, 0.5, 0.4, 3_000_000);
        (plant.pose(), plant.counts(), plant.supply_v())
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5).2, run(6).2);
}

#[test]
fn how_often_one_looks_changes_nothing() {
    let mut rarely = robot(PlantParameters::default());
    let mut often = rarely.clone();
    rarely.set_enabled(true);
    often.set_enabled(true);
    rarely.set_duty(WheelPair::new(0.5, 0.4));
    often.set_duty(WheelPair::new(0.5, 0.4));
    rarely.advance_to(2_000_000);
    for ms in 1..=2000 {
        often.advance_to(ms * 1000);
        often.supply_v();
        often.advance_to(ms * 500);
    }
    assert_eq!(rarely.pose(), often.pose());
    assert_eq!(rarely.counts(), often.counts());
}

#[test]
fn stopping_between_steps_is_the_same_as_taking_shorter_ones() {
    let mut stopped = robot(PlantParameters::default());
    let shorter = PlantParameters { substep_us: 100, ..PlantParameters::default() };
    let mut shorter = robot(shorter);
    for (left, right, duration_us) in [(0.5, 0.4, 2_000_000), (0.0, 0.0, 1_000_000)] {
        drive(&mut shorter, left, right, duration_us);
        for _ in 0..duration_us / 100 {
            drive(&mut stopped, left, right, 100);
        }
    }
    assert_eq!(stopped.pose(), shorter.pose());
}
