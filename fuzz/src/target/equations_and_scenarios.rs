//! What describes the world: equations of effects for the model, scenarios for the simulator.

use campaign::model::equation_error;
use campaign::motor_model::motor_equation_error;
use robot_model::drivetrain::effect::{Acting, Excitation, Moment};
use robot_model::drivetrain::{MotorCustom, MotorEffect, WheelMotor};
use robot_model::effect::{Custom, Effect, Memory};
use robot_model::expression::ExpressionError;
use robot_model::kinematics::WheelPair;
use robot_model::numeric::Jet;
use robot_model::recording::Step;
use sim_target::{Options, Scenario, SimTarget};

use crate::bytes::text;

/// `dtheta = k * v^2 * omega`, as on the command line.
pub fn expression(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let points = |error: &ExpressionError, text: &str| {
        assert!(text.get(error.at.clone()).is_some(), "{error:?} in {text:?}");
        let told = equation_error(text, error);
        assert!(!told.problem.is_empty() && !told.hint.is_empty(), "{error:?}");
    };
    let custom = match Custom::from_equation(text) {
        Ok(custom) => custom,
        Err(error) => return points(&error, text),
    };
    let again = Custom::from_equation(&custom.equation()).expect("an equation is read again");
    assert_eq!(custom, again);
    let effect = match custom.build() {
        Ok(effect) => effect,
        Err(error) => return points(&error, &custom.expression),
    };
    let facts = effect.facts();
    assert!(!facts.parameters.is_empty());
    for parameter in facts.parameters {
        assert!(parameter.low.is_finite() && parameter.high.is_finite(), "{parameter:?}");
        assert!(parameter.low < parameter.high, "{parameter:?}");
    }
    for start in effect.starts(&Default::default()) {
        assert_eq!(start.len(), facts.parameters.len());
        for step in steps() {
            acts(&effect, &start, &step);
            let doubled: Vec<f64> = start.iter().map(|value| 2.0 * value + 1.0).collect();
            acts(&effect, &doubled, &step);
        }
    }
}

/// `dV = q * v * abs(v)`, of the motors.
pub fn motor_expression(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let points = |error: &ExpressionError, text: &str| {
        assert!(text.get(error.at.clone()).is_some(), "{error:?} in {text:?}");
        let told = motor_equation_error(text, error);
        assert!(!told.problem.is_empty() && !told.hint.is_empty(), "{error:?}");
    };
    let custom = match MotorCustom::from_equation(text) {
        Ok(custom) => custom,
        Err(error) => return points(&error, text),
    };
    let again = MotorCustom::from_equation(&custom.equation()).expect("an equation is read again");
    assert_eq!(custom, again);
    let effect = match custom.build() {
        Ok(effect) => effect,
        Err(error) => return points(&error, &custom.expression),
    };
    let motor = WheelMotor {
        ks_forward_v: 0.5,
        ks_backward_v: 0.5,
        kv_v_s_per_m: 24.0,
        ka_v_s2_per_m: 0.7,
    };
    let excitation =
        Excitation { speed_mps_max: 0.4, gear_reduction: 1.0, counts_per_wheel_turn: 900.0 };
    for start in effect.starts(&excitation) {
        for (speed, volts) in [(0.0, 0.0), (0.3, 7.0), (-0.2, -5.0)] {
            let moment = Moment {
                side: 1.0,
                speed_mps: (speed, -speed),
                volts: (volts, 3.0),
                full_v: 12.0,
                turns: 7.7,
                t_s: 12.0,
                since_pause_s: f64::INFINITY,
                heading_rad: 0.3,
            };
            let before = Acting { volts, motor };
            let mut after = before;
            effect.act(&start, &moment, &mut after);
            assert_eq!(after, before, "{start:?} at {moment:?}");
            let doubled: Vec<f64> = start.iter().map(|value| 2.0 * value + 1.0).collect();
            effect.act(&doubled, &moment, &mut after);
            let of_motor = [after.motor.ks_forward_v, after.motor.kv_v_s_per_m];
            let inertia = after.motor.ka_v_s2_per_m;
            assert!(after.volts.is_finite() && inertia.is_finite() && inertia > 0.0, "{after:?}");
            assert!(of_motor.iter().all(|k| k.is_finite() && *k >= 0.0), "{after:?}");
        }
    }
}

/// What an effect changes is finite, and so are its derivatives.
fn acts(effect: &dyn Effect, values: &[f64], step: &Step) {
    let change = effect.act(&Jet::parameters(values), step, &mut Memory::default());
    let jets = [change.angle_rad.left, change.angle_rad.right, change.turn_rad, change.sideways_m];
    for jet in jets {
        let finite = jet.value.is_finite() && jet.by.iter().all(|slope| slope.is_finite());
        assert!(finite, "{values:?} at {step:?}: {jet:?}");
    }
}

/// At rest, forwards, backwards, turning on the spot.
fn steps() -> [Step; 4] {
    [(0.0, 0.0), (0.3, 0.29), (-0.3, -0.31), (0.1, -0.1)].map(|(left, right)| Step {
        t_s: 1.0,
        dt_s: 0.02,
        clock_s: 10.0,
        phi_rad: WheelPair::new(2.0, 1.9),
        dphi_rad: WheelPair::new(left * 0.02 / 0.036, right * 0.02 / 0.036),
        wheel_speed_mps: WheelPair::new(left, right),
        wheel_accel_mps2: WheelPair::new(0.1 * left, 0.1 * right),
        path_m: 0.5,
        since_reversal_m: None,
        payload_kg: 1.0,
        wheel_radius_m: 0.036,
        track_width_m: 0.372,
        gear_reduction: 1.0,
        heading_rad: 0.1,
        place_m: [0.2, 0.1],
    })
}

/// A scenario file.
pub fn scenario(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let scenario = match Scenario::parse("file", text) {
        Ok(scenario) => scenario,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let written = scenario.to_toml();
    let again = Scenario::parse("file", &written).unwrap_or_else(|e| panic!("{e}\n{written}"));
    assert_eq!(scenario, again);
    let mut target = SimTarget::new(&scenario, Options::default()).expect("there is no file");
    target.run_until_us(20_000);
    let pose = target.testbed().pose();
    let finite = [pose.x_m, pose.y_m, pose.heading_rad].iter().all(|number| number.is_finite());
    assert!(finite, "{pose:?}\n{written}");
}
