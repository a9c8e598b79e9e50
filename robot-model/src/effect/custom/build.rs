//! How does an equation become an effect that can be fitted?
//!
//! What the text means is read in [`crate::expression`]; here it becomes an effect.

use std::borrow::Cow;

use super::analysis::{plausible_limit, samples, without_bound};
use super::equation::Custom;
use super::target::{Per, Target};
use super::variables::{NAMES, value};
use crate::effect::catalogue::find;
use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter, Role};
use crate::expression::{
    Context, Declared, ExpressionError, ExpressionProblem, Tree, check_id, evaluate, starts,
};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;

impl Custom {
    /// The effect, ready to be fitted.
    pub fn build(&self) -> Result<CustomEffect, ExpressionError> {
        check_id(&self.id, find(&self.id).is_some())?;
        let context = Context {
            names: NAMES,
            samples: &samples(),
            left_side: self.target.left_side(self.per),
        };
        let declared = Declared { units: &self.units, ranges: &self.ranges };
        let limit = |tree: &Tree, index| plausible_limit(tree, index, self.target, self.per);
        let (tree, read) = context.read(&self.expression, declared, limit)?;
        if let Some(motion) = without_bound(&tree, self.per, read.len()) {
            let problem = ExpressionProblem::Unbounded(motion);
            return Err(ExpressionError::in_expression(tree.at.clone(), problem));
        }
        let parameters = read.into_iter().map(|parameter| Parameter {
            name: Cow::Owned(parameter.name),
            unit: Cow::Owned(parameter.unit),
            low: parameter.low,
            high: parameter.high,
            possible: (f64::NEG_INFINITY, f64::INFINITY),
            role: if parameter.is_amplitude { Role::Amplitude } else { Role::Shape },
            usual: None,
        });
        Ok(CustomEffect {
            custom: self.clone(),
            name: format!("your own {}", self.id),
            equation: self.equation(),
            signature: format!("{} proportional to {}", self.target.name(), self.expression),
            parameters: parameters.collect(),
            tree,
        })
    }
}

/// Where shapes are tried.
const PLACES_IN_RANGE: [f64; 3] = [0.5, 0.35, 0.65];

/// An effect of the user's own.
#[derive(Debug)]
pub struct CustomEffect {
    custom: Custom,
    name: String,
    equation: String,
    signature: String,
    parameters: Vec<Parameter>,
    tree: Tree,
}

impl CustomEffect {
    /// What the user wrote.
    pub fn custom(&self) -> &Custom {
        &self.custom
    }
}

impl Effect for CustomEffect {
    fn facts(&self) -> Facts<'_> {
        Facts {
            id: &self.custom.id,
            name: &self.name,
            equation: &self.equation,
            parameters: &self.parameters,
            signature: &self.signature,
            shown_by: "runs in which what stands in its expression varies",
            compensation: "add this term to the odometry",
            ..Facts::DEFAULT
        }
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let rate = evaluate(&self.tree, p, &|index| value(index, step));
        if !(rate.value.is_finite() && rate.by.iter().all(|slope| slope.is_finite())) {
            return Change::NONE;
        }
        let amount = |metres: f64| {
            rate * match self.custom.per {
                Per::Second => step.dt_s,
                Per::Metre => metres.abs(),
                Per::Radian => step.turn_rad().abs(),
            }
        };
        let travel_m = step.wheel_travel_m();
        let nothing = Jet::ZERO;
        match self.custom.target {
            Target::DsLeft => {
                let angle = amount(travel_m.left) / step.wheel_radius_m;
                Change { angle_rad: WheelPair::new(angle, nothing), ..Change::NONE }
            }
            Target::DsRight => {
                let angle = amount(travel_m.right) / step.wheel_radius_m;
                Change { angle_rad: WheelPair::new(nothing, angle), ..Change::NONE }
            }
            Target::Dtheta => Change { turn_rad: amount(step.travel_m()), ..Change::NONE },
            Target::Dn => Change { sideways_m: amount(step.travel_m()), ..Change::NONE },
        }
    }

    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        let ranges = self
            .parameters
            .iter()
            .map(|&Parameter { low, high, role, .. }| (low, high, role == Role::Amplitude));
        starts(&Vec::from_iter(ranges), &PLACES_IN_RANGE)
    }
}
