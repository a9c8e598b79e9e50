//! How does an equation become an effect of the motors that can be fitted?
//!
//! What the text means is read in [`crate::expression`]; here it becomes an effect.

use std::borrow::Cow;

use super::equation::MotorCustom;
use super::plausible::{amplitude_of, samples, without_bound};
use super::variables::{NAMES, value};
use crate::drivetrain::effect::definition::{
    Acting, Excitation, Moment, MotorEffect, MotorFacts, MotorParameter, MotorRole,
};
use crate::drivetrain::effect::find;
use crate::expression::{
    Context, Declared, ExpressionError, ExpressionProblem, Tree, check_id, evaluate, starts,
};
use crate::numeric::jet::Jet;

/// Where shapes are tried. Motors differ by more than robots do, and a fit goes astray from a speed that is five times off.
const PLACES_IN_RANGE: [f64; 7] = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8];

/// An amplitude may come to as much; more would be visible without any fit \[V\].
const LIMIT_V: f64 = 24.0;
/// A usual effect comes to as much \[V\].
const USUAL_V: f64 = 0.3;

impl MotorCustom {
    /// The effect, ready to be fitted.
    pub fn build(&self) -> Result<CustomMotorEffect, ExpressionError> {
        check_id(&self.id, find(&self.id).is_some())?;
        let context =
            Context { names: NAMES, samples: &samples(), left_side: self.target.left_side() };
        let declared = Declared { units: &self.units, ranges: &self.ranges };
        let amplitude = |volts, tree: &Tree, index| amplitude_of(volts, tree, index, self.target);
        let limit = |tree: &Tree, index| amplitude(LIMIT_V, tree, index);
        let (tree, read) = context.read(&self.expression, declared, limit)?;
        if let Some(motion) = without_bound(&tree, read.len()) {
            let problem = ExpressionProblem::Unbounded(motion);
            return Err(ExpressionError::in_expression(tree.at.clone(), problem));
        }
        let parameters = read.into_iter().enumerate().map(|(index, parameter)| {
            let (low, high) = (parameter.low, parameter.high);
            let (role, usual) = if parameter.is_amplitude {
                let usual = amplitude(USUAL_V, &tree, index);
                (MotorRole::Amplitude, usual.min(high.max(-low)))
            } else {
                (MotorRole::Shape, if low > 0.0 { low } else { 0.01 * (high - low) })
            };
            MotorParameter {
                name: Cow::Owned(parameter.name),
                unit: Cow::Owned(parameter.unit),
                low,
                high,
                usual,
                role,
            }
        });
        Ok(CustomMotorEffect {
            custom: self.clone(),
            name: format!("your own {}", self.equation()),
            equation: self.equation(),
            parameters: parameters.collect(),
            tree,
        })
    }
}

/// An effect of the motors of the user's own.
#[derive(Debug)]
pub struct CustomMotorEffect {
    custom: MotorCustom,
    name: String,
    equation: String,
    parameters: Vec<MotorParameter>,
    tree: Tree,
}

impl CustomMotorEffect {
    /// What the user wrote.
    pub fn custom(&self) -> &MotorCustom {
        &self.custom
    }
}

impl MotorEffect for CustomMotorEffect {
    fn facts(&self) -> MotorFacts<'_> {
        MotorFacts {
            id: &self.custom.id,
            name: &self.name,
            equation: &self.equation,
            parameters: &self.parameters,
            sign: self.custom.target.sign(),
            shown_by: "experiments in which what stands in its expression varies",
            remedy: "add this term to the feedforward of your own controller",
        }
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        if !self.custom.motors.holds(moment) {
            return;
        }
        let mut at = [Jet::ZERO; _];
        at.iter_mut().zip(p).for_each(|(jet, value)| *jet = Jet::constant(*value));
        let change = evaluate(&self.tree, &at, &|index| value(index, moment, &acting.motor)).value;
        if change.is_finite() {
            self.custom.target.add(change, acting);
        }
    }

    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        let ranges = self.parameters.iter().map(|&MotorParameter { low, high, role, .. }| {
            (low, high, role == MotorRole::Amplitude)
        });
        starts(&Vec::from_iter(ranges), &PLACES_IN_RANGE)
    }
}
