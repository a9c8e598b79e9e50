//! Wheels that slip are a matter of the robot and its floor, not of the files.

use crate::checks::data_hypotheses;
use crate::kinematics::wheel_pair::WheelPair;
use crate::recording::Recording;
use crate::tests::synthetic::{ROBOT, campaign, full_plan};

/// The counts of a run with each step times a factor for each wheel, by the share of the run that is over and by the share
/// of a turn in the motion.
fn slipping(run: &mut Recording, factor: &dyn Fn(f64, f64) -> WheelPair<f64>) {
    let before = run.wheels.clone();
    let count = before.len() as f64;
    let mut phi_rad = before[0].phi_rad;
    for (k, pair) in before.windows(2).enumerate() {
        let step = pair[1].phi_rad.since(pair[0].phi_rad);
        let rim_rad = step.difference().abs();
        let sharpness = rim_rad / (2.0 * step.mean().abs() + rim_rad).max(1e-12);
        let by = factor(k as f64 / count, sharpness);
        let rolled = WheelPair::new(by.left * step.left, by.right * step.right);
        phi_rad = WheelPair::new(phi_rad.left + rolled.left, phi_rad.right + rolled.right);
        run.wheels[k + 1].phi_rad = phi_rad;
    }
}

/// What is refused among these runs, in words.
fn refused(runs: &[Recording]) -> Option<String> {
    let found = data_hypotheses(&ROBOT, runs);
    let first = found.iter().find(|found| !found.what.is_minor())?;
    Some(format!("{:?} in {:?}", first.what, first.run))
}

#[test]
fn a_wheel_that_spins_for_most_of_one_run_is_refused_by_no_check() {
    let sound = campaign(&full_plan(), &[], 5);
    let mut wrong = Vec::new();
    for (index, run) in sound.runs.iter().enumerate().step_by(3) {
        for (from, times) in [(0.0, 1.7), (0.1, 2.3), (0.3, 2.0), (0.2, 4.0)] {
            for (left, right) in [(true, false), (true, true)] {
                let by = |slips: bool| if slips { times } else { 1.0 };
                let mut runs = sound.runs.clone();
                slipping(&mut runs[index], &|share, _| match share >= from {
                    true => WheelPair::new(by(left), by(right)),
                    false => WheelPair::both(1.0),
                });
                if let Some(told) = refused(&runs) {
                    let wheels = if right { "both wheels" } else { "left wheel" };
                    wrong.push(format!("{} from {from}, {wheels} {times}: {told}", run.name));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn wheels_that_slip_the_more_the_sharper_the_turn_are_refused_by_no_check() {
    let sound = campaign(&full_plan(), &[], 5);
    let mut wrong = Vec::new();
    for share in [0.2, 0.3, 0.4] {
        let mut runs = sound.runs.clone();
        for run in &mut runs {
            slipping(run, &|_, chi| WheelPair::both(1.0 / (1.0 - share * chi)));
        }
        if let Some(told) = refused(&runs) {
            wrong.push(format!("slip {share}: {told}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
