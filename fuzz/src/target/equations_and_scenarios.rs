//! What describes the world: equations of effects for the model, scenarios for the simulator.

use campaign::model::equation_error;
use robot_model::effect::custom::CustomError;
use robot_model::effect::{Custom, Effect, Memory};
use robot_model::kinematics::WheelPair;
use robot_model::numeric::Jet;
use robot_model::recording::Step;
use sim_target::{Options, Scenario, SimTarget};

use crate::bytes::text;

/// `dtheta = k * v^2 * omega`, as on the command line.
pub fn expression(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let points = |error: &CustomError, text: &str| {
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
