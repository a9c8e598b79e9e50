//! Robots that are computed here, by other and finer steps than the model's, with one effect or none.

use core::f64::consts::TAU;

use super::*;
use crate::drivetrain::effect::KnownMotorEffect;
use crate::drivetrain::recording::{Sample, VoltageRecording};
use crate::kinematics::WheelPair;
use crate::numeric::random::Random;

mod drivers;
mod own_effects;

/// A robot's motors, by their torques: explicit steps of 0.1 ms.
#[derive(Clone, Copy)]
struct Motors {
    ks: [f64; 2],
    kv: [f64; 2],
    /// What opposes forwards more, by wheel \[V\].
    against: [f64; 2],
    at_rest: f64,
    slow: (f64, f64),
    dead: f64,
    drag: f64,
    /// Volts, waves per turn.
    wave: (f64, f64),
    sag: f64,
    /// The mean voltage is the duty to the power of one more than this.
    bend: f64,
    /// The voltage changes at most so fast \[V/s\].
    slew_v_per_s: f64,
    late_s: f64,
    warms_per_s: f64,
    /// Warmer by this share after a pause of 20 s between both rounds; cools in 12 s.
    warmed: f64,
    /// A slope that pushes where the robot looked at first \[V\].
    slope: f64,
    /// More inertia on the left than on the right, half the difference \[V s^2/m\].
    heavier_left: f64,
    /// Mass times its distance behind the axle, over the square of the track width, in volts \[V s^2/m^2\].
    mass_behind: f64,
    /// More friction of the right wheel where it rubs, most at angle zero \[V\].
    rubs: f64,
}

const SOUND: Motors = Motors {
    ks: [0.5; 2],
    kv: [24.0; 2],
    against: [0.0; 2],
    at_rest: 0.0,
    slow: (0.0, 0.05),
    dead: 0.0,
    drag: 0.0,
    wave: (0.0, 7.0),
    sag: 0.0,
    bend: 0.0,
    slew_v_per_s: f64::INFINITY,
    late_s: 0.0,
    warms_per_s: 0.0,
    warmed: 0.0,
    slope: 0.0,
    heavier_left: 0.0,
    mass_behind: 0.0,
    rubs: 0.0,
};

const KA: f64 = 0.55;
const KC: f64 = 0.12;
const ROBOT: KnownRobot = KnownRobot {
    wheel_radius_m: 0.036,
    track_width_m: 0.372,
    gear_reduction: 1.0,
    meters_per_count: 2.5e-4,
};

impl Motors {
    fn friction(&self, wheel: usize, v: f64, warm: f64) -> f64 {
        let slow = self.slow.0 * (-(v / self.slow.1).powi(2)).exp();
        let rest = if v.abs() < 1e-9 { self.at_rest } else { 0.0 };
        (self.ks[wheel] + slow + rest) * warm
    }

    /// Friction of the right wheel where it rubs, besides.
    fn rubbing(&self, wheel: usize, turns: f64) -> f64 {
        if wheel == 1 { self.rubs * (TAU * turns).cos().max(0.0) } else { 0.0 }
    }

    /// What a bent duty leaves of 12 V \[V\].
    fn bent(&self, volts: f64) -> f64 {
        if volts == 0.0 { 0.0 } else { volts * (volts.abs() / 12.0).powf(self.bend) }
    }

    /// What the driver makes of the voltages that are wanted \[V\].
    fn driver(&self, slewed: &mut [f64; 2], wanted: [f64; 2]) -> [f64; 2] {
        let most = self.slew_v_per_s * 1e-4;
        *slewed = [0, 1].map(|i| slewed[i] + (wanted[i] - slewed[i]).clamp(-most, most));
        slewed.map(|volts| self.bent(volts))
    }

    /// What the resistance is at a time, of what it was at first.
    fn warm(&self, t_s: f64) -> f64 {
        let cooled = if t_s < 68.0 { 0.0 } else { (-(t_s - 68.0) / 12.0).exp() };
        1.0 + self.warms_per_s * t_s + self.warmed * cooled
    }

    /// Drives voltages from rest; the counts go on from `travel`.
    fn drive(
        &self,
        steps: &[(f64, f64, f64)],
        started_s: f64,
        travel: &mut [f64; 2],
        first_m: f64,
    ) -> Experiment {
        const H: f64 = 1e-4;
        let mut samples = Vec::new();
        let heading_rad =
            |travel: &[f64; 2]| (travel[1] - travel[0] - first_m) / ROBOT.track_width_m;
        let begins_rad = heading_rad(travel);
        let (mut v, mut vs, mut slewed, mut n) = ([0.0_f64; 2], [0.0_f64; 2], [0.0; 2], 0_usize);
        let mut queue = vec![[0.0; 2]; (self.late_s / H).round() as usize];
        for &(left, right, duration_s) in steps {
            for _ in 0..(duration_s / H).round() as usize {
                if n % 50 == 0 {
                    let seen = travel
                        .map(|x| (x / ROBOT.meters_per_count).floor() * ROBOT.meters_per_count);
                    samples.push(Sample {
                        t_s: n as f64 * H,
                        travel_m: WheelPair::new(seen[0], seen[1]),
                        applied_vs: WheelPair::new(vs[0], vs[1]),
                    });
                }
                vs = [vs[0] + H * left, vs[1] + H * right];
                queue.push([left, right]);
                let acting = self.driver(&mut slewed, queue.remove(0));
                let warm = self.warm(started_s + n as f64 * H);
                let drawn: f64 = (0..2).map(|i| acting[i] * (acting[i] - self.kv[i] * v[i])).sum();
                // Both motors' push in terms of the robot's speed u and yaw rate, each times the track width b.
                let (u, turn) = (0.5 * (v[0] + v[1]), v[1] - v[0]);
                let (outwards, yaw) = (self.mass_behind * turn * turn, self.mass_behind * u * turn);
                let taken = [0.5 * outwards + yaw, 0.5 * outwards - yaw];
                let slope = self.slope * heading_rad(travel).cos();
                let mut push = [0.0; 2];
                let mut held = [0.0; 2];
                for i in 0..2 {
                    let u = acting[i] * (1.0 - self.sag * drawn);
                    let u = u.signum() * (u.abs() - self.dead).max(0.0);
                    let turns = travel[i] / (TAU * ROBOT.wheel_radius_m);
                    let wave = self.wave.0 * (TAU * self.wave.1 * turns + 1.0).sin();
                    push[i] = u - self.kv[i] * v[i] - self.against[i] - wave - taken[i] + slope
                        - self.drag * v[i] * v[i].abs();
                    held[i] = self.friction(i, v[i], warm) + self.rubbing(i, turns);
                }
                let net = |i: usize| {
                    if v[i].abs() < 1e-9 {
                        push[i].signum() * (push[i].abs() - held[i]).max(0.0)
                    } else {
                        push[i] - held[i] * v[i].signum()
                    }
                };
                let (a, b, kc) = (net(0), net(1), KC * warm);
                let (left, right) =
                    ((KA + self.heavier_left) * warm, (KA - self.heavier_left) * warm);
                let det = left * right - kc * kc;
                let accelerates = [(right * a - kc * b) / det, (left * b - kc * a) / det];
                for i in 0..2 {
                    let stuck = v[i].abs() < 1e-9 && push[i].abs() <= held[i];
                    let next = if stuck { 0.0 } else { v[i] + H * accelerates[i] };
                    v[i] = if next * v[i] < 0.0 { 0.0 } else { next };
                    travel[i] += H * v[i];
                }
                n += 1;
            }
        }
        let recording = VoltageRecording::new(samples).unwrap();
        Experiment { recording, started_s, heading_rad: begins_rad, held_out: false }
    }

    /// Two dozen experiments, as `beeline tune --record` drives them, with voltages that are never twice the same.
    fn campaign(&self, seed: u64) -> Vec<Experiment> {
        let mut random = Random::new(seed);
        let mut travel = [0.3 * random.uniform(), 0.3 * random.uniform()];
        let first_m = travel[1] - travel[0];
        let mut clock_s = 0.0;
        let mut driven = Vec::new();
        for round in 0..2 {
            if round == 1 && self.warmed != 0.0 {
                clock_s += 20.0;
            }
            for kind in 0..6 {
                for sign in [1.0, -1.0] {
                    let v = |volts: f64, random: &mut Random| {
                        sign * volts * (0.95 + 0.1 * random.uniform())
                    };
                    let steps: Vec<(f64, f64, f64)> = match kind {
                        0 => (1..=60)
                            .map(|i| f64::from(i) * sign * 0.025)
                            .map(|v| (v, v, 0.03))
                            .collect(),
                        1..=3 => {
                            let level = [1.8, 4.0, 8.0][kind - 1] + f64::from(round) * 0.7;
                            let v = v(level, &mut random);
                            vec![(v, v, 0.9), (0.0, 0.0, 0.3)]
                        }
                        4 => {
                            let v = v(4.5, &mut random);
                            vec![(v, v, 0.5), (-v, -v, 0.5), (0.0, 0.0, 0.3)]
                        }
                        _ => {
                            let v = v(4.0, &mut random);
                            vec![(-v, v, 0.7), (0.0, 0.0, 0.3)]
                        }
                    };
                    driven.push(self.drive(&steps, clock_s, &mut travel, first_m));
                    clock_s += 4.0;
                }
            }
        }
        driven
    }

    fn answer(&self) -> MotorAnswer {
        missing(&ROBOT, &self.campaign(7)).unwrap()
    }
}

/// The one effect that is found, or its class, with its first parameter.
fn only(motors: Motors) -> (Vec<String>, Estimate, MotorAnswer) {
    let answer = motors.answer();
    let [step] = answer.steps.as_slice() else { panic!("{answer:#?}") };
    let named = core::iter::once(&step.effect).chain(&step.class);
    let named = named.map(|effect| effect.facts().id.to_owned()).collect();
    (named, step.parameters[0].clone(), answer.clone())
}

fn holds(estimate: &Estimate, truth: f64) -> bool {
    (estimate.value - truth).abs() < estimate.half_width_95.max(0.05 * truth.abs())
}

#[test]
fn motors_without_an_effect_get_none_and_their_constants_are_right() {
    let answer = SOUND.answer();
    assert!(answer.steps.is_empty() && !answer.unexplained.structure, "{answer:#?}");
    assert!(answer.next.is_none());
    // What is left is what counts hide.
    let left = answer.baseline.cross_validated_m / answer.resolution_m;
    assert!((0.8..1.1).contains(&left), "{left}");
    for (constant, truth) in answer.constants.iter().zip([0.5, 24.0, KA, KC]) {
        assert!((constant.value / truth - 1.0).abs() < 0.03, "{constant:?}");
    }
    let alone = &answer.tried[0];
    let better = 1.0 - alone.cross_validated_m / answer.baseline.cross_validated_m;
    // Four amplitudes of cogging, by the angle that the counts round, are 3 % better to first order by chance.
    assert!(better < 0.04, "{better} {alone:?}");
}

/// kW as (2) of the parent module has it, by the robot's speed and yaw rate, where the model has both wheels' speeds.
#[test]
fn unequal_inertia_and_a_mass_behind_the_axle_are_constants_and_no_effect() {
    let answer = Motors { heavier_left: 0.03, mass_behind: 0.6, ..SOUND }.answer();
    assert!(answer.steps.is_empty() && !answer.unexplained.structure, "{answer:#?}");
    let left = answer.baseline.cross_validated_m / answer.resolution_m;
    assert!((0.8..1.1).contains(&left), "{left}");
    let of = |name| answer.constants.iter().find(|constant| constant.name == name).unwrap();
    assert!((of("kD").value - 0.03).abs() < 0.004, "{:?}", of("kD"));
    // Four spins, in which half a count is a fifth of what kW does.
    assert!(holds(of("kW"), 0.6) && of("kW").half_width_95 < 0.2, "{:?}", of("kW"));
}

#[test]
fn what_differs_by_side_or_direction_is_told_from_a_push() {
    let (named, a, _) = only(Motors { ks: [0.54, 0.46], kv: [24.3, 23.7], ..SOUND });
    assert!(named == ["side_asymmetry"] && holds(&a, 0.08), "{named:?} {a:?}");
    let (named, e, _) = only(Motors { against: [0.08, -0.08], ..SOUND });
    assert!(named == ["direction_asymmetry"] && holds(&e, 0.08), "{named:?} {e:?}");
    let (named, e, _) = only(Motors { slope: 0.1, ..SOUND });
    assert!(named == ["load_torque"] && holds(&e, 0.1), "{named:?} {e:?}");
}

#[test]
fn frictions_are_told_apart_and_where_they_are_not_the_class_says_so() {
    let (named, k, _) = only(Motors { slow: (0.2, 0.06), ..SOUND });
    assert!(named == ["stribeck"] && holds(&k, 0.2), "{named:?} {k:?}");
    let (named, v_0, _) = only(Motors { dead: 0.2, ..SOUND });
    assert!(named[0] == "dead_band" && holds(&v_0, 0.2), "{named:?} {v_0:?}");
    let (named, _, answer) = only(Motors { at_rest: 0.25, ..SOUND });
    assert!(named.iter().any(|id| id == "static_friction"), "{named:?}");
    if named.len() > 1 {
        let next = answer.next.expect("a class asks for an experiment");
        assert!(next.separates[0].facts().id == named[0] && next.apart_m > 0.0, "{next:?}");
    }
}

#[test]
fn drag_waves_sag_delay_and_warmth_are_named_with_their_sizes() {
    let (named, q, _) = only(Motors { drag: 4.0, ..SOUND });
    // A driver that gives more of small voltages does the same while the speed goes with the voltage.
    assert!(named[0] == "quadratic_drag" && holds(&q, 4.0), "{named:?} {q:?}");
    assert!(named[1..].iter().all(|id| id == "bridge_curve"), "{named:?}");
    let (named, c, _) = only(Motors { sag: 8e-4, ..SOUND });
    assert!(named == ["supply_sag"] && holds(&c, 8e-4), "{named:?} {c:?}");
    let (named, tau, _) = only(Motors { late_s: 0.004, ..SOUND });
    assert!(named[0] == "transport_delay" && holds(&tau, 0.004), "{named:?} {tau:?}");
    let (named, h, _) = only(Motors { warms_per_s: 1.5e-3, ..SOUND });
    assert!(named == ["heating"] && holds(&h, 1.5e-3), "{named:?} {h:?}");
    let (named, _, answer) = only(Motors { wave: (0.1, 7.0), ..SOUND });
    let p: Vec<f64> = answer.steps[0].parameters.iter().map(|p| p.value).collect();
    assert_eq!(named, ["cogging"]);
    assert!((p[4] - 7.0).abs() < 0.1, "{p:?}");
    assert!((p[0].hypot(p[1]) - 0.1).abs() < 0.02, "{p:?}");
}

/// What helps when fast, and what grows under load, is neither drag nor a sag.
#[test]
fn drag_and_sag_are_never_negative() {
    for motors in [Motors { drag: -2.0, ..SOUND }, Motors { sag: -4e-4, ..SOUND }] {
        let answer = motors.answer();
        let opposite = |id: &str| id == "quadratic_drag" || id == "supply_sag";
        let mut found = answer.steps.iter().filter(|step| opposite(step.effect.facts().id));
        assert!(found.all(|step| step.parameters[0].value > 0.0), "{answer:#?}");
    }
}

/// A straight line in time describes neither the jump nor how it fades.
#[test]
fn motors_that_were_warmed_in_a_pause_and_cool_are_named() {
    let (named, _, answer) = only(Motors { warmed: 0.12, ..SOUND });
    assert_eq!(named, ["heating"]);
    let [_, w, tau] = answer.steps[0].parameters.as_slice() else { panic!("{answer:#?}") };
    assert!(holds(w, 0.12) && holds(tau, 12.0), "{w:?} {tau:?}");
    let left = answer.steps[0].errors.cross_validated_m / answer.resolution_m;
    assert!(left < 1.2, "{left}");
}

/// Both only where a wheel runs forwards: either alone makes the way back as much worse as it makes the way there better.
#[test]
fn two_asymmetries_that_hide_each_other_are_both_found() {
    let motors = Motors { ks: [0.54, 0.46], against: [0.04, -0.04], ..SOUND };
    let answer = motors.answer();
    let mut ids: Vec<&str> = answer.steps.iter().map(|step| step.effect.facts().id).collect();
    ids.sort_unstable();
    assert_eq!(ids, ["direction_asymmetry", "side_asymmetry"], "{answer:#?}");
    assert!(answer.steps.iter().all(|step| step.p_value < 0.004), "{answer:#?}");
}

/// Drag that the model lacks moves kS and kV by voltage, in all experiments alike.
#[test]
fn intervals_hold_the_constants_of_motors_with_an_effect_that_the_model_lacks() {
    let found = baseline_errors(&ROBOT, &Motors { drag: 0.4, ..SOUND }.campaign(7)).unwrap();
    let [ks, kv] = [&found.constants[0], &found.constants[1]];
    println!("{ks:?} {kv:?}");
    assert!((ks.value - 0.5).abs() < ks.half_width_95, "{ks:?}");
}

#[test]
fn two_effects_are_both_found_and_held_out_experiments_confirm_them() {
    let motors = Motors { slope: 0.1, drag: 4.0, ..SOUND };
    let mut experiments = motors.campaign(7);
    for experiment in experiments.iter_mut().step_by(5) {
        experiment.held_out = true;
    }
    let answer = missing(&ROBOT, &experiments).unwrap();
    let mut ids: Vec<&str> = answer.steps.iter().map(|step| step.effect.facts().id).collect();
    ids.sort_unstable();
    assert_eq!(ids, ["load_torque", "quadratic_drag"], "{answer:#?}");
    let (before, after) = (answer.baseline, answer.steps[1].errors);
    assert!(after.cross_validated_m < 0.1 * before.cross_validated_m);
    assert!(after.held_out_m.unwrap() < 0.1 * before.held_out_m.unwrap(), "{after:?} {before:?}");
}

#[test]
fn a_chosen_effect_that_the_motors_have_is_needed_and_one_that_they_lack_is_not() {
    let mut experiments = Motors { drag: 4.0, ..SOUND }.campaign(7);
    for experiment in experiments.iter_mut().step_by(5) {
        experiment.held_out = true;
    }
    let effects = ["quadratic_drag", "backlash"].map(|id| KnownMotorEffect::find(id, &[]).unwrap());
    let [none, one, both] =
        [0, 1, 2].map(|len| fit_chosen(&ROBOT, &experiments, &effects[..len]).unwrap());
    let before = missing(&ROBOT, &experiments).unwrap().baseline;
    let off_m = none.errors.cross_validated_m - before.cross_validated_m;
    assert!(off_m.abs() < 1e-12 && none.effects.is_empty(), "as explain has it: {none:#?}");
    assert!(one.errors.cross_validated_m < 0.15 * before.cross_validated_m, "{one:#?}");
    assert!(one.errors.held_out_m.unwrap() < 0.15 * before.held_out_m.unwrap(), "{one:#?}");
    assert!(one.effects[0].matters && holds(&one.effects[0].parameters[0], 4.0), "{one:#?}");
    let needed: Vec<bool> = both.effects.iter().map(|effect| effect.matters).collect();
    assert_eq!(needed, [true, false], "{both:#?}");
    assert!(both.effects[0].without_m > 5.0 * both.errors.cross_validated_m);
}

#[test]
fn too_few_experiments_or_none_that_move_are_refused() {
    let experiments = SOUND.campaign(7);
    let few = missing(&ROBOT, &experiments[..EXPERIMENTS_MIN - 1]).unwrap_err();
    assert_eq!(few, MissingError::TooFew { experiments: EXPERIMENTS_MIN - 1 });
    let mut travel = [0.0; 2];
    let still: Vec<Experiment> =
        (0..10).map(|i| SOUND.drive(&[(0.2, 0.2, 0.5)], f64::from(i), &mut travel, 0.0)).collect();
    assert_eq!(missing(&ROBOT, &still).unwrap_err(), MissingError::NoMotion);
}
