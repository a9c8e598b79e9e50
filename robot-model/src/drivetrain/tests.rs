//! The model against its closed solution, the fit on quantised counts, and the margin in the time domain.

use super::*;
use crate::kinematics::WheelPair;

const MOTOR: WheelMotor =
    WheelMotor { ks_forward_v: 0.5, ks_backward_v: 0.6, kv_v_s_per_m: 24.0, ka_v_s2_per_m: 0.7 };

fn drivetrain() -> Drivetrain {
    let right = WheelMotor { ks_forward_v: 0.8, kv_v_s_per_m: 26.0, ..MOTOR };
    let wheels = WheelPair::new(MOTOR, right);
    Drivetrain { wheels, kc_v_s2_per_m: 0.15, kw_v_s2_per_m2: 0.0, delay_s: 0.003 }
}

/// An experiment in which the voltages are these, each for a time \[s\]; travel is left zero.
fn applied(steps: &[(f64, f64, f64)]) -> VoltageRecording {
    let mut applied_vs = WheelPair::both(0.0);
    let mut samples = vec![Sample { t_s: 0.0, travel_m: WheelPair::both(0.0), applied_vs }];
    for &(left, right, duration_s) in steps {
        for _ in 0..(duration_s * 100.0).round() as usize {
            applied_vs.left += 0.01 * left;
            applied_vs.right += 0.01 * right;
            let t_s = 0.01 * samples.len() as f64;
            samples.push(Sample { t_s, travel_m: WheelPair::both(0.0), applied_vs });
        }
    }
    VoltageRecording::new(samples).unwrap()
}

/// As encoders with this distance per count see a drivetrain.
fn seen(model: &Drivetrain, recording: &VoltageRecording, q_m: f64) -> VoltageRecording {
    let travel = model.travel_m(recording);
    let samples = recording.samples().iter().zip(travel).map(|(sample, travel_m)| Sample {
        travel_m: travel_m.map(|travel_m| (travel_m / q_m).floor() * q_m),
        ..*sample
    });
    VoltageRecording::new(samples).unwrap()
}

/// Steps both ways, on the spot too, and one slow.
fn experiments() -> Vec<VoltageRecording> {
    [
        (2.0, 2.0),
        (-2.0, -2.0),
        (4.0, 4.0),
        (-4.0, -4.0),
        (7.0, 7.0),
        (-7.0, -7.0),
        (4.0, -4.0),
        (-4.0, 4.0),
    ]
    .map(|(left, right)| applied(&[(left, right, 1.0), (0.0, 0.0, 0.3)]))
    .to_vec()
}

#[test]
fn a_step_of_one_wheel_is_the_closed_solution() {
    let model = Drivetrain { kc_v_s2_per_m: 0.0, delay_s: 0.0, ..drivetrain() };
    let recording = applied(&[(3.0, 0.0, 1.0)]);
    let travel = model.travel_m(&recording);
    let (speed_mps, constant_s) = ((3.0 - 0.5) / 24.0, 0.7 / 24.0);
    for (sample, travel) in recording.samples().iter().zip(travel) {
        let t = sample.t_s;
        let expected_m = speed_mps * (t - constant_s * (1.0 - (-t / constant_s).exp()));
        assert!((travel.left - expected_m).abs() < 2e-6, "{t} s: {} {expected_m}", travel.left);
        assert_eq!(travel.right, 0.0);
    }
}

#[test]
fn friction_holds_a_wheel_up_to_ks_in_its_direction_and_not_beyond() {
    let model = drivetrain();
    for (volts, moves) in [(0.49, false), (0.55, true), (-0.59, false), (-0.65, true)] {
        let end = model.travel_m(&applied(&[(volts, 0.0, 2.0)])).pop().unwrap();
        assert_eq!(end.left.abs() > 1e-4, moves, "{volts} V: {} m", end.left);
    }
}

#[test]
fn a_wheel_that_is_dragged_feels_the_other_one() {
    let model = drivetrain();
    let alone = model.travel_m(&applied(&[(4.0, 0.0, 0.05)])).pop().unwrap().left;
    let together = model.travel_m(&applied(&[(4.0, 4.0, 0.05)])).pop().unwrap().left;
    assert!(together < 0.95 * alone, "{together} {alone}");
}

#[test]
fn the_fit_finds_the_constants_from_counts_and_the_regression_is_farther_off() {
    let truth = drivetrain();
    let recordings: Vec<_> =
        experiments().iter().map(|recording| seen(&truth, recording, 2.5e-4)).collect();
    let found = fit(&recordings).unwrap();
    let Constants { value, half_widths_95 } = found.constants;
    println!("{value:?}\n{half_widths_95:?}\n{:?}", found.regression);
    for (found, truth) in
        [(value.wheels.left, truth.wheels.left), (value.wheels.right, truth.wheels.right)]
    {
        let off = |found: f64, truth: f64| (found / truth - 1.0).abs();
        assert!(off(found.ks_forward_v, truth.ks_forward_v) < 0.02);
        assert!(off(found.ks_backward_v, truth.ks_backward_v) < 0.02);
        assert!(off(found.kv_v_s_per_m, truth.kv_v_s_per_m) < 0.005);
        assert!(off(found.ka_v_s2_per_m, truth.ka_v_s2_per_m) < 0.03);
    }
    assert!((value.kc_v_s2_per_m - truth.kc_v_s2_per_m).abs() < 0.03);
    assert!((value.delay_s - truth.delay_s).abs() < 0.001);
    assert!(found.residual_m < 2.5e-4, "{}", found.residual_m);
    let by_regression = found.regression.wheels.left.ka_v_s2_per_m;
    assert!((by_regression / 0.85 - 1.0).abs() > 0.05, "{by_regression}");
}

/// As encoders see a drivetrain whose wheels begin just past the edge of a count.
fn past_an_edge(model: &Drivetrain, recording: &VoltageRecording, q_m: f64) -> VoltageRecording {
    let travel = model.travel_m(recording);
    let samples = recording.samples().iter().zip(travel).map(|(sample, travel_m)| Sample {
        travel_m: travel_m.map(|travel_m| (travel_m.abs() / q_m).floor() * q_m * travel_m.signum()),
        ..*sample
    });
    VoltageRecording::new(samples).unwrap()
}

#[test]
fn half_a_count_that_is_missing_at_every_start_passes_for_neither_friction_nor_delay() {
    let truth = drivetrain();
    let q_m = 4e-3;
    let uncounted: Vec<_> =
        experiments().iter().map(|recording| past_an_edge(&truth, recording, q_m)).collect();
    let counted: Vec<_> = uncounted
        .iter()
        .map(|recording| recording.clone().with_counts_of(WheelPair::both(q_m)))
        .collect();
    let off = |recordings: &[VoltageRecording]| {
        let Constants { value, half_widths_95 } = fit(recordings).unwrap().constants;
        let (found, truth_of) = (value.wheels.left, truth.wheels.left);
        let ks = (found.ks_forward_v / truth_of.ks_forward_v - 1.0).abs();
        let ka_v_s2_per_m = found.ka_v_s2_per_m + value.kc_v_s2_per_m;
        let ka_off = ka_v_s2_per_m - truth_of.ka_v_s2_per_m - truth.kc_v_s2_per_m;
        println!("{value:?} {half_widths_95:?}");
        assert!(ka_off.abs() < half_widths_95.left.ka_straight_v_s2_per_m, "{ka_off}");
        (ks, (value.delay_s - truth.delay_s).abs())
    };
    let (ks, delay_s) = off(&counted);
    assert!(ks < 0.02 && delay_s < 0.001, "{ks} {delay_s}");
    let (ks, delay_s) = off(&uncounted);
    assert!(ks > 0.05 && delay_s > 0.001, "{ks} {delay_s}");
}

#[test]
fn what_turns_no_wheel_or_too_seldom_is_refused() {
    let still = vec![applied(&[(0.1, 0.1, 1.0)]); 3];
    assert_eq!(fit(&still), Err(FitError::NoMotion));
    assert_eq!(fit(&still[..2]), Err(FitError::TooFew));
}

const FACTS: LoopFacts = LoopFacts {
    period_s: 1e-3,
    speed_window_s: 0.04,
    meters_per_count: 2.5e-4,
    supply_v: 12.0,
    stiffness: 1.0,
    integral_share_max_per_s: f64::INFINITY,
};

/// Largest travel error after a push of 1 V that begins at 0.2 s, early and at the end of 4 s \[m\], by time steps: a loop
/// with its delay, its window, no friction.
fn pushed(gains: &Gains, motor: &WheelMotor, delay_s: f64) -> (f64, f64) {
    const H_S: f64 = 1e-4;
    let (mut x, mut v, mut integral) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut history = vec![0.0; 400];
    let mut inputs = vec![0.0; (delay_s / H_S).round() as usize + 1];
    let mut volts = 0.0;
    let (mut early, mut late) = (0.0_f64, 0.0_f64);
    for step in 0..40_000 {
        if step % 10 == 0 {
            let mean_speed = (x - history[step % 400]) / 0.04;
            volts = -gains.kp_v_per_m * x - integral - gains.kd_v_s_per_m * mean_speed;
            integral += gains.ki_v_per_m_s * x * 1e-3;
        }
        history[step % 400] = x;
        let len = inputs.len();
        let delayed = std::mem::replace(&mut inputs[step % len], volts);
        let push = if step > 2000 { 1.0 } else { 0.0 };
        v += H_S * (delayed + push - motor.kv_v_s_per_m * v) / motor.ka_v_s2_per_m;
        x += H_S * v;
        early = if step < 20_000 { early.max(x.abs()) } else { early };
        late = if step > 36_000 { late.max(x.abs()) } else { late };
    }
    (early, late)
}

#[test]
fn the_gains_keep_their_margin_and_stay_stable_with_constants_30_percent_off() {
    for scale in [0.3, 1.0, 4.0] {
        for constant_s in [0.008, 0.03, 0.12] {
            let motor = WheelMotor {
                kv_v_s_per_m: 24.0 * scale,
                ka_v_s2_per_m: 24.0 * scale * constant_s,
                ..MOTOR
            };
            let model = Drivetrain {
                wheels: WheelPair::both(motor),
                delay_s: 0.002,
                ..Drivetrain::default()
            };
            let facts = LoopFacts { meters_per_count: 2e-5, ..FACTS };
            let gains = design(&model, &facts).unwrap();
            println!("{constant_s} s: {gains:?}");
            assert!(gains.ms_worst <= 1.6 && gains.ms <= gains.ms_worst);
            assert!(gains.phase_margin_rad > 0.6, "{gains:?}");
            for (kv, ka) in [(1.0, 1.0), (0.7, 0.7), (0.7, 1.3), (1.3, 0.7), (1.3, 1.3)] {
                let off = WheelMotor {
                    kv_v_s_per_m: kv * motor.kv_v_s_per_m,
                    ka_v_s2_per_m: ka * motor.ka_v_s2_per_m,
                    ..motor
                };
                let (early, late) = pushed(&gains, &off, 0.002);
                assert!(late < 0.2 * early, "kv {kv}, ka {ka}: {early} {late}");
            }
        }
    }
}

#[test]
fn a_coarse_encoder_and_a_wish_for_softness_make_the_loop_softer() {
    let model = drivetrain();
    let fine = design(&model, &LoopFacts { meters_per_count: 1e-5, ..FACTS }).unwrap();
    let coarse = design(&model, &LoopFacts { meters_per_count: 2e-2, ..FACTS }).unwrap();
    assert!(coarse.kp_v_per_m < fine.kp_v_per_m);
    assert!(coarse.kp_v_per_m * 2e-2 <= 0.1 * 12.0 + 1e-9);
    let soft = design(&model, &LoopFacts { meters_per_count: 1e-5, stiffness: 0.5, ..FACTS });
    let soft = soft.unwrap();
    assert!(soft.kp_v_per_m < 0.51 * fine.kp_v_per_m && soft.ms <= fine.ms + 0.05);
}

#[test]
fn a_bound_on_the_integral_is_kept_with_as_stiff_a_proportional_gain() {
    let model = drivetrain();
    let free = design(&model, &FACTS).unwrap();
    let bounded = design(&model, &LoopFacts { integral_share_max_per_s: 0.1, ..FACTS }).unwrap();
    assert!(free.ki_v_per_m_s > 0.2 * free.kp_v_per_m, "{free:?}");
    assert!(bounded.ki_v_per_m_s <= 0.1 * bounded.kp_v_per_m, "{bounded:?}");
    assert!(bounded.kp_v_per_m >= free.kp_v_per_m && bounded.ms_worst <= 1.6, "{bounded:?}");
}

/// Largest distance from a trapezoid of speed \[m\], by time steps: the loop of [`pushed`] with feedforward, kF of its
/// acceleration \[V s^2/m\].
fn followed(gains: &Gains, motor: &WheelMotor, delay_s: f64, kf: f64) -> f64 {
    const H_S: f64 = 1e-4;
    let (mut x, mut v, mut integral, mut setpoint) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let mut history = vec![0.0; 400];
    let mut inputs = vec![0.0; (delay_s / H_S).round() as usize + 1];
    let mut volts = 0.0;
    let mut worst_m = 0.0_f64;
    for step in 0..20_000 {
        let t_s = f64::from(step) * H_S;
        // 0.3 m/s, reached and left at 0.6 m/s^2.
        let speed = (0.6 * t_s).min(0.3).min(0.6 * (1.5 - t_s)).max(0.0);
        let acceleration = match t_s {
            0.0..0.5 => 0.6,
            1.0..1.5 => -0.6,
            _ => 0.0,
        };
        let at = step as usize;
        if at.is_multiple_of(10) {
            let error = setpoint - x;
            let mean_speed = (x - history[at % 400]) / 0.04;
            volts = motor.kv_v_s_per_m * speed + kf * acceleration + gains.kp_v_per_m * error;
            volts += integral + gains.kd_v_s_per_m * (speed - mean_speed);
            integral += gains.ki_v_per_m_s * error * 1e-3;
            worst_m = worst_m.max(error.abs());
        }
        history[at % 400] = x;
        let len = inputs.len();
        let delayed = std::mem::replace(&mut inputs[at % len], volts);
        v += H_S * (delayed - motor.kv_v_s_per_m * v) / motor.ka_v_s2_per_m;
        x += H_S * v;
        setpoint += H_S * speed;
    }
    worst_m
}

#[test]
fn the_feedforward_allows_for_the_lag_of_the_measured_speed_and_for_the_delay() {
    for (constant_s, delay_s) in [(0.06, 0.001), (0.2, 0.004), (0.4, 0.005)] {
        let ka_v_s2_per_m = constant_s * MOTOR.kv_v_s_per_m;
        let motor = WheelMotor { ka_v_s2_per_m, ..MOTOR };
        let model = Drivetrain { wheels: WheelPair::both(motor), delay_s, ..Drivetrain::default() };
        let gains = design(&model, &LoopFacts { meters_per_count: 2e-5, ..FACTS }).unwrap();
        let kf = gains.feedforward_ka(&model, &motor, 1e-3, 0.04);
        let allowed = followed(&gains, &motor, delay_s, kf);
        let plain = followed(&gains, &motor, delay_s, motor.ka_v_s2_per_m);
        println!("{constant_s} s, {delay_s} s: {kf} {allowed} {plain}");
        assert!(allowed < 0.5 * plain, "{constant_s} s, {delay_s} s: {allowed} {plain}");
    }
}
