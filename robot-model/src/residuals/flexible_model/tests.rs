use super::*;
use crate::effect::custom::Custom;
use crate::effect::definition::{Change, Facts, Memory, Parameter};
use crate::explain::model_errors::errors;
use crate::explain::{Answer, explain};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::campaign::Campaign;
use crate::recording::motion::Step;
use crate::tests::synthetic::{NOISE, campaign, end_poses_only, full_plan};

/// Tyres that give way sideways, late: dn = -k F dt, T dF/dt = v omega - F.
#[derive(Debug)]
struct LateTyres;

impl Effect for LateTyres {
    fn facts(&self) -> Facts<'_> {
        static FACTS: Facts<'static> = Facts {
            id: "late_tyres",
            parameters: &[Parameter::amplitude("k", "s", 1.0)],
            ..Facts::DEFAULT
        };
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, memory: &mut Memory) -> Change {
        let force = step.speed_mps() * step.turn_rate_rad_s();
        let before = memory.wheel.left.map_or(0.0, |jet| jet.value);
        let after = before + (force - before) * step.dt_s / 0.4;
        memory.wheel.left = Some(Jet::constant(after));
        Change { sideways_m: p[0] * (-after * step.dt_s), ..Change::NONE }
    }
}

/// A carpet whose pile carries each tyre as far as it rolls.
#[derive(Debug)]
struct Pile;

impl Effect for Pile {
    fn facts(&self) -> Facts<'_> {
        static FACTS: Facts<'static> = Facts {
            id: "pile",
            parameters: &[
                Parameter::amplitude("d_x", "1", 1.0),
                Parameter::amplitude("d_y", "1", 1.0),
            ],
            ..Facts::DEFAULT
        };
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _: &mut Memory) -> Change {
        let [left_m, right_m] = [step.wheel_travel_m().left, step.wheel_travel_m().right];
        let (both_m, more_m) = (left_m.abs() + right_m.abs(), right_m.abs() - left_m.abs());
        let (sin, cos) = step.heading_rad.sin_cos();
        Change {
            drift_m: [p[0] * (both_m / 2.0), p[1] * (both_m / 2.0)],
            turn_rad: (p[0] * cos + p[1] * sin) * (more_m / step.track_width_m),
            ..Change::NONE
        }
    }
}

/// The left wheel's counter loses counts above this rate [rad/s], in proportion to what is above it.
#[derive(Debug)]
struct LeftLoses(f64);

impl Effect for LeftLoses {
    fn facts(&self) -> Facts<'_> {
        static FACTS: Facts<'static> = Facts {
            id: "left_loses",
            parameters: &[Parameter::amplitude("k", "s", 1.0)],
            ..Facts::DEFAULT
        };
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _: &mut Memory) -> Change {
        let rate = step.wheel_speed_mps.left.abs() / step.wheel_radius_m;
        let lost = p[0] * (rate - self.0).max(0.0);
        Change { travel: WheelPair::new(lost, Jet::ZERO), ..Change::NONE }
    }
}

/// Thin lines of the wheels' discs that are lost above a rate of their own: each wheel loses counts in steps.
#[derive(Debug)]
struct ThinLines;

impl Effect for ThinLines {
    fn facts(&self) -> Facts<'_> {
        static FACTS: Facts<'static> = Facts {
            id: "thin_lines",
            parameters: &[Parameter::amplitude("k", "1", 1.0)],
            ..Facts::DEFAULT
        };
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _: &mut Memory) -> Change {
        // What each line takes, in steps of one, and the rate [rad/s] from which it does.
        let of = |speed_mps: f64, lines: &[f64]| {
            let rate = speed_mps.abs() / step.wheel_radius_m;
            lines.iter().filter(|from| rate > **from).count() as f64
        };
        let WheelPair { left, right } = step.wheel_speed_mps;
        Change {
            travel: WheelPair::new(
                p[0] * of(left, &[3.6, 3.8, 4.4, 4.5, 4.7, 5.9, 6.0, 6.3, 6.4, 7.9]),
                p[0] * of(right, &[4.0, 4.1, 5.1, 5.2, 5.4, 5.7, 7.3, 7.4, 8.0, 8.2]),
            ),
            ..Change::NONE
        }
    }
}

/// A round puddle in which a wheel loses travel, as it loses none beside it.
#[derive(Debug)]
struct Puddle([f64; 2]);

impl Effect for Puddle {
    fn facts(&self) -> Facts<'_> {
        static FACTS: Facts<'static> = Facts {
            id: "puddle",
            parameters: &[Parameter::amplitude("k", "1", 1.0)],
            ..Facts::DEFAULT
        };
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _: &mut Memory) -> Change {
        let (sin, cos) = step.heading_rad.sin_cos();
        let in_it = |side: f64| {
            let half_m = side * step.track_width_m / 2.0;
            let (x_m, y_m) = (step.place_m[0] - half_m * sin, step.place_m[1] + half_m * cos);
            f64::from(u8::from((x_m - self.0[0]).hypot(y_m - self.0[1]) < 0.2))
        };
        Change { travel: WheelPair::new(p[0] * in_it(1.0), p[0] * in_it(-1.0)), ..Change::NONE }
    }
}

fn answer_on(hidden: &[Term<'_>], seed: u64) -> Answer {
    explain(&campaign(&full_plan(), hidden, seed)).unwrap()
}

fn mm(errors: &Errors) -> f64 {
    1e3 * displacement_m(errors, 0.372)
}

/// What noise alone leaves on these runs of a sound robot [mm].
fn left_by_noise(sound: &Campaign) -> f64 {
    mm(&errors(&sound.prepare().unwrap(), &NOISE, &[]).cross_validated)
}

/// What a sound robot of the same seed leaves, the answer's model, and the reachable error [mm].
fn compared(hidden: &[Term<'_>], seed: u64) -> (f64, f64, f64, Answer) {
    let sound = left_by_noise(&campaign(&full_plan(), &[], seed));
    let answer = answer_on(hidden, seed);
    let last = answer.steps.last();
    let model = last.map_or(answer.baseline.cross_validated, |step| step.cross_validated);
    let steps: Vec<_> = answer
        .steps
        .iter()
        .map(|step| {
            format!("{} {:.2} {}", step.class.join("|"), 1e3 * step.effect_size_m, step.matters)
        })
        .collect();
    println!(
        "seed {seed}: sound {sound:.2}, nominal {:.2}, model {:.2}, floor {:.2}: {steps:?} {:?}",
        mm(&answer.baseline.cross_validated),
        mm(&model),
        mm(&answer.reachable),
        answer.unexplained.depends_on
    );
    (sound, mm(&model), mm(&answer.reachable), answer)
}

#[test]
fn tyres_that_answer_late_do_not_pass_for_noise() {
    for seed in 0..4 {
        let (sound, model, least, answer) =
            compared(&[Term::new(&LateTyres, vec![0.08])], 60 + seed);
        assert!(least < 1.15 * sound, "{least} of {sound}");
        assert!(model < 1.4 * sound || answer.unexplained.structure, "{model} of {sound}");
    }
}

#[test]
fn a_carpet_that_carries_tyres_in_a_spin_does_not_pass_for_noise() {
    for seed in 0..2 {
        let (sound, model, least, answer) =
            compared(&[Term::new(&Pile, vec![0.03, -0.02])], 100 + seed);
        assert!(least < 1.15 * sound, "{least} of {sound}");
        assert!(model < 1.2 * sound || answer.unexplained.structure, "{model} of {sound}");
        let ends = |hidden: &[Term<'_>]| end_poses_only(campaign(&full_plan(), hidden, 100 + seed));
        let sound = left_by_noise(&ends(&[]));
        let hidden = [Term::new(&Pile, vec![0.03, -0.02])];
        let least = mm(&explain(&ends(&hidden)).unwrap().reachable);
        println!("ends {least} {sound}");
        assert!(least < 1.3 * sound, "{least} of {sound}");
    }
}

#[test]
fn counts_that_one_wheel_alone_loses_do_not_pass_for_noise() {
    for (from_rad_s, seed) in [(4.0, 110), (5.0, 110), (4.0, 111)] {
        let hidden = LeftLoses(from_rad_s);
        let (sound, model, least, answer) = compared(&[Term::new(&hidden, vec![0.004])], seed);
        assert!(least < 1.15 * sound, "{least} of {sound}");
        assert!(model < 1.2 * sound || answer.unexplained.structure, "{model} of {sound}");
    }
}

#[test]
fn counts_that_are_lost_in_steps_do_not_pass_for_noise() {
    for seed in 0..2 {
        let (sound, model, least, answer) =
            compared(&[Term::new(&ThinLines, vec![0.002])], 112 + seed);
        assert!(least < 1.15 * sound, "{least} of {sound}");
        assert!(model < 1.2 * sound || answer.unexplained.structure, "{model} of {sound}");
    }
}

#[test]
fn a_puddle_with_an_edge_does_not_pass_for_noise() {
    let mut times = Vec::new();
    for seed in 0..6 {
        let (sound, model, least, answer) =
            compared(&[Term::new(&Puddle([0.5, 0.19]), vec![-0.06])], 120 + seed);
        times.push(least / sound);
        assert!(model < 1.2 * sound || answer.unexplained.structure, "{model} of {sound}");
    }
    // Where the edge lies between tracks is known only so well: 1.01 to 1.43. What is chosen leaves 3 and 5 in the first two.
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    assert!(mean < 1.3, "{times:?}");
}

#[test]
fn a_heading_that_turns_with_v_abs_v_does_not_pass_for_noise() {
    let own = Custom::from_equation("dtheta = k * v * abs(v)").unwrap().build().unwrap();
    for seed in 0..4 {
        let (sound, model, least, answer) = compared(&[Term::new(&own, vec![0.12])], 70 + seed);
        assert!(least < 1.15 * sound, "{least} of {sound}");
        assert!(model < 1.4 * sound || answer.unexplained.structure, "{model} of {sound}");
    }
}

#[test]
fn nor_does_it_where_only_the_ends_of_runs_are_measured() {
    let own = Custom::from_equation("dtheta = k * v * abs(v)").unwrap().build().unwrap();
    for seed in 0..4 {
        let hidden = [Term::new(&own, vec![0.12])];
        let ends = |hidden| end_poses_only(campaign(&full_plan(), hidden, 70 + seed));
        let sound = left_by_noise(&ends(&[]));
        let answer = explain(&ends(&hidden)).unwrap();
        let last = answer.steps.last();
        let model = mm(&last.map_or(answer.baseline.cross_validated, |step| step.cross_validated));
        assert!(model < 1.4 * sound || answer.unexplained.structure, "{model} of {sound}");
    }
}

/// A camera whose lens bends what lies far from its middle.
fn seen_through_a_lens(mut campaign: Campaign) -> Campaign {
    for pose in campaign.runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
        pose.position_m = pose.position_m.map(|[x_m, y_m]| {
            let (from_x_m, from_y_m) = (x_m - 0.3, y_m + 0.2);
            let bent = 0.003 * (from_x_m * from_x_m + from_y_m * from_y_m);
            [x_m + bent * from_x_m, y_m + bent * from_y_m]
        });
    }
    campaign
}

#[test]
fn a_lens_that_bends_the_floor_does_not_pass_for_noise() {
    for seed in 0..2 {
        let sound = campaign(&full_plan(), &[], 90 + seed);
        let noise = left_by_noise(&sound);
        let answer = explain(&seen_through_a_lens(sound)).unwrap();
        let (before, least) = (mm(&answer.baseline.cross_validated), mm(&answer.reachable));
        println!("{before} {least} {noise}");
        assert!(before > 2.0 * noise, "{before} of {noise}");
        assert!(least < 1.15 * noise, "{least} of {noise}");
        assert!(answer.unexplained.depends_on.contains(&Regressor::Place), "{answer:?}");
    }
}

/// A tracker whose origin is across the room.
fn seen_from_afar(mut campaign: Campaign) -> Campaign {
    for pose in campaign.runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
        pose.position_m = pose.position_m.map(|[x_m, y_m]| [x_m + 4.0, y_m - 3.0]);
    }
    campaign
}

#[test]
fn where_a_tracker_has_its_origin_changes_nothing_about_a_lens() {
    let sound = campaign(&full_plan(), &[], 90);
    let noise = left_by_noise(&sound);
    let answer = explain(&seen_from_afar(seen_through_a_lens(sound))).unwrap();
    let least = mm(&answer.reachable);
    println!("{least} {noise}");
    assert!(least < 1.15 * noise, "{least} of {noise}");
}

#[test]
fn on_a_sound_robot_the_reachable_error_is_that_of_the_model() {
    for seed in 0..4 {
        let (_, model, least, answer) = compared(&[], 80 + seed);
        let before = mm(&answer.baseline.cross_validated);
        assert!(least > 0.97 * model && model <= before, "{least} of {model}, {before}");
        assert!(!answer.unexplained.structure);
    }
}
