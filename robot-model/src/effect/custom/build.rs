//! How does an equation become an effect that can be fitted?
//!
//! This puts together parsing, units and analysis, each of which has its own file.

use std::borrow::Cow;

use super::analysis::{amplitudes, plausible_limit, typical_of, without_bound};
use super::dimensions::units;
use super::equation::Custom;
use super::error::{CustomError, CustomProblem, DefinitionPart};
use super::evaluate::evaluate;
use super::parse::parse;
use super::target::{Per, Target};
use super::tree::Tree;
use super::unit::Unit;
use crate::effect::catalogue::find;
use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter, Role};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;

impl Custom {
    /// The effect, ready to be fitted.
    pub fn build(&self) -> Result<CustomEffect, CustomError> {
        let sound = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if self.id.is_empty() || !self.id.chars().all(sound) || find(&self.id).is_some() {
            let problem = CustomProblem::Id(self.id.clone());
            return Err(CustomError::new(DefinitionPart::Id, 0..self.id.len(), problem));
        }
        let (tree, names) = parse(&self.expression)?;
        let mut declared = vec![None; names.len()];
        for (name, unit) in &self.units {
            let part = DefinitionPart::Unit(name.clone());
            let fail = |problem| CustomError::new(part, 0..unit.len(), problem);
            match names.iter().position(|parameter| parameter == name) {
                Some(index) => declared[index] = Some(Unit::parse(unit).map_err(fail)?),
                None => return Err(fail(no_parameter(name, &names))),
            }
        }
        let amplitudes = amplitudes(&tree, names.len()).ok_or_else(|| {
            CustomError::in_expression(tree.at.clone(), CustomProblem::DoesNotVanish)
        })?;
        let units = units(&tree, (self.target, self.per), &declared, &names)?;
        let parameters = (0..names.len())
            .map(|index| self.parameter(&tree, index, &names[index], units[index], &amplitudes))
            .collect::<Result<Vec<_>, _>>()?;
        if let Some((name, _)) = self.ranges.iter().find(|(name, _)| !names.contains(name)) {
            let part = DefinitionPart::Range(name.clone());
            return Err(CustomError::new(part, 0..0, no_parameter(name, &names)));
        }
        if let Some(motion) = without_bound(&tree, self.per, names.len()) {
            let problem = CustomProblem::Unbounded(motion);
            return Err(CustomError::in_expression(tree.at.clone(), problem));
        }
        Ok(CustomEffect {
            custom: self.clone(),
            name: format!("your own {}", self.id),
            equation: self.equation(),
            signature: format!("{} proportional to {}", self.target.name(), self.expression),
            parameters,
            tree,
        })
    }

    fn parameter(
        &self,
        tree: &Tree,
        index: usize,
        name: &str,
        unit: Unit,
        amplitudes: &[usize],
    ) -> Result<Parameter, CustomError> {
        let is_amplitude = amplitudes.contains(&index);
        let shown = self
            .units
            .get(name)
            .map_or_else(|| unit.to_string(), |declared| declared.trim().to_owned());
        let range = match self.ranges.get(name) {
            Some([low, high]) => {
                let sound = low.is_finite() && high.is_finite() && low < high;
                let holds_zero = *low <= 0.0 && *high >= 0.0;
                if !sound || (is_amplitude && !holds_zero) {
                    let problem = CustomProblem::Range {
                        name: name.to_owned(),
                        range: [*low, *high],
                        of_amplitude: is_amplitude,
                    };
                    let part = DefinitionPart::Range(name.to_owned());
                    return Err(CustomError::new(part, 0..0, problem));
                }
                (*low, *high)
            }
            None if is_amplitude => {
                let limit = plausible_limit(tree, index, self.target, self.per);
                (-limit, limit)
            }
            None => {
                let typical = typical_of(unit);
                (typical / 30.0, typical * 30.0)
            }
        };
        if !is_plausible(range) {
            let problem = CustomProblem::NoPlausibleValue(name.to_owned());
            return Err(CustomError::in_expression(tree.at.clone(), problem));
        }
        let role = if is_amplitude { Role::Amplitude } else { Role::Shape };
        Ok(Parameter {
            name: Cow::Owned(name.into()),
            unit: Cow::Owned(shown),
            low: range.0,
            high: range.1,
            possible: (f64::NEG_INFINITY, f64::INFINITY),
            role,
            usual: None,
        })
    }
}

/// Whether a range can be searched: neither so wide nor so narrow that its numbers overflow when they are squared.
fn is_plausible((low, high): (f64, f64)) -> bool {
    const SIZES: core::ops::RangeInclusive<f64> = 1e-100..=1e100;
    let bounded = |end: f64| end == 0.0 || SIZES.contains(&end.abs());
    bounded(low) && bounded(high) && low < high
}

fn no_parameter(name: &str, parameters: &[String]) -> CustomProblem {
    CustomProblem::NoParameter { name: name.to_owned(), parameters: parameters.to_vec() }
}

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
        let rate = evaluate(&self.tree, p, step);
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
        let parameters = &self.parameters;
        if parameters.iter().all(|parameter| parameter.role == Role::Amplitude) {
            return vec![vec![0.0; parameters.len()]];
        }
        // Three places within each range, logarithmic where the range is positive.
        [0.5, 0.35, 0.65]
            .map(|share: f64| {
                let at = |&Parameter { low, high, role, .. }: &Parameter| match role {
                    Role::Amplitude => 0.0,
                    Role::Shape if low > 0.0 => low * (high / low).powf(share),
                    Role::Shape => low + share * (high - low),
                };
                parameters.iter().map(at).collect()
            })
            .into()
    }
}
