//! Effects that a user writes as an expression: fitted, judged, plotted and ranked as the built-in ones.
//!
//! ```text
//! d(target) = f(v, omega, ...; parameters) d(per)
//! ```
//!
//! | target | what grows by it | per |
//! | --- | --- | --- |
//! | `ds_left`, `ds_right` | the travel of that wheel \[m\] | second; metre rolled by that wheel; radian turned |
//! | `dtheta` | the heading, counter-clockwise \[rad\] | second; metre travelled; radian turned |
//! | `dn` | the place, to the left \[m\] | second; metre travelled; radian turned |
//!
//! Metres and radians count without a sign, forwards as backwards: a sign comes from the expression,
//! `v`, `omega` or `sign(v)`. Where an expression has no finite value, the effect does nothing.
//!
//! | variable | what it is |
//! | --- | --- |
//! | `v`, `v_left`, `v_right` | speed of the middle and of each wheel, forwards positive \[m/s\] |
//! | `omega` | turn rate, counter-clockwise positive \[rad/s\] |
//! | `a`, `a_left`, `a_right` | acceleration of the middle and of each wheel \[m/s^2\] |
//! | `theta` | heading in the fixed frame \[rad\] |
//! | `phi_left`, `phi_right` | angle of each wheel \[rad\] |
//! | `s` | path driven in this run, forwards or backwards \[m\] |
//! | `t`, `t_run` | time since the campaign's first run began, and since this run began \[s\] |
//! | `payload` | load on board \[kg\] |
//!
//! Every other name is a free parameter, four at most. The parameters in which the expression is
//! linear, and with which it vanishes, are its amplitudes; the others say where it acts (shapes).

mod evaluate;
mod parse;
#[cfg(test)]
mod tests;
mod unit;

use core::fmt;
use core::ops::Range;
use std::collections::BTreeMap;

use self::parse::Tree;
use self::unit::Unit;
use super::{ActsOn, Change, Effect, Facts, Memory, Parameter, Role, Survey};
use crate::jet::{Jet, PARAMETERS_MAX};
use crate::motion::Step;
use crate::sides::Sides;

/// The powers of metre, second and kilogram of a unit, as parameters declare it.
#[cfg(test)]
pub(super) fn dimensions(unit: &str) -> Result<[f64; 3], String> {
    Unit::parse(unit).map(|it| it.0)
}

/// What an expression changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Travel of the left wheel.
    DsLeft,
    /// Travel of the right wheel.
    DsRight,
    /// Heading.
    Dtheta,
    /// Sideways, to the left.
    Dn,
}

/// Per what an expression is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Per {
    /// Per second.
    Second,
    /// Per metre of travel.
    Metre,
    /// Per radian turned.
    Radian,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::DsLeft, Self::DsRight, Self::Dtheta, Self::Dn];

    /// Its name in an expression.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DsLeft => "ds_left",
            Self::DsRight => "ds_right",
            Self::Dtheta => "dtheta",
            Self::Dn => "dn",
        }
    }
}

impl Per {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Second, Self::Metre, Self::Radian];

    /// Its name in `model.toml`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Second => "second",
            Self::Metre => "metre",
            Self::Radian => "radian",
        }
    }

    const fn unit(self) -> Unit {
        match self {
            Self::Second => Unit([0.0, 1.0, 0.0]),
            Self::Metre => Unit([1.0, 0.0, 0.0]),
            Self::Radian => Unit::ONE,
        }
    }
}

/// What a user says about an effect of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct Custom {
    /// Its id in `model.toml` and JSON.
    pub id: String,
    /// What it changes.
    pub target: Target,
    /// Per what.
    pub per: Per,
    /// The right-hand side.
    pub expression: String,
    /// Units of parameters, where declared; the others follow from the expression.
    pub units: BTreeMap<String, String>,
    /// Least and greatest plausible values of parameters, where declared.
    pub ranges: BTreeMap<String, [f64; 2]>,
}

/// Which part of a [`Custom`] is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// The id.
    Id,
    /// The left-hand side of an equation.
    Target,
    /// The expression.
    Expression,
    /// The unit of this parameter.
    Unit(String),
    /// The range of this parameter.
    Range(String),
}

/// Why an expression cannot be used, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CustomError {
    /// Which part is wrong.
    pub part: Part,
    /// Where in that part, in bytes.
    pub at: Range<usize>,
    /// What is wrong.
    pub problem: String,
    /// What to try.
    pub hint: String,
}

impl CustomError {
    fn new(part: Part, at: Range<usize>, problem: &str, hint: &str) -> Self {
        Self { part, at, problem: problem.to_owned(), hint: hint.to_owned() }
    }
}

impl fmt::Display for CustomError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.problem)
    }
}

impl core::error::Error for CustomError {}

impl Custom {
    /// Reads `dtheta = k * v^2 * omega`, or `dtheta/ds = ...`: target, per what, and the right-hand
    /// side. Errors point into the whole text.
    pub fn from_equation(text: &str) -> Result<Self, CustomError> {
        let fail = |at: Range<usize>, problem: &str| {
            let hint = "for example dtheta = k * v^2 * omega; the left is ds_left, ds_right, dtheta or \
                        dn, with /dt, /ds or /dtheta behind it for per second, metre or radian";
            Err(CustomError::new(Part::Target, at, problem, hint))
        };
        let Some(equals) = text.find('=') else {
            return fail(0..text.len(), "there is no = in it");
        };
        let left = text[..equals].trim();
        let begin = text.len() - text.trim_start().len();
        let at = begin.min(equals)..begin.min(equals) + left.len();
        let (name, per) = match left.split_once('/') {
            None => (left, Per::Second),
            Some((name, per)) => match per.trim() {
                "dt" => (name, Per::Second),
                "ds" => (name, Per::Metre),
                "dtheta" => (name, Per::Radian),
                _ => return fail(at, &format!("`{left}` cannot be changed")),
            },
        };
        let Some(target) = Target::ALL.into_iter().find(|it| it.name() == name.trim()) else {
            return fail(at, &format!("`{left}` cannot be changed"));
        };
        let rest = &text[equals + 1..];
        let from = equals + 1 + rest.len() - rest.trim_start().len();
        let custom = Self {
            id: format!("custom_{}", target.name()),
            target,
            per,
            expression: rest.trim().to_owned(),
            units: BTreeMap::new(),
            ranges: BTreeMap::new(),
        };
        // So that an error in the expression points into the equation.
        parse::parse(&custom.expression).map_err(|error| CustomError {
            at: error.at.start + from..error.at.end + from,
            ..error
        })?;
        Ok(custom)
    }

    /// The equation, as a user would write it.
    pub fn equation(&self) -> String {
        let per = match self.per {
            Per::Second => "dt",
            Per::Metre => "ds",
            Per::Radian => "dtheta",
        };
        format!("{}/{per} = {}", self.target.name(), self.expression)
    }

    /// The effect, ready to be fitted. It lives as long as the program does, as the built-in ones do.
    pub fn build(&self) -> Result<&'static CustomEffect, CustomError> {
        let sound = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if self.id.is_empty() || !self.id.chars().all(sound) || super::find(&self.id).is_some() {
            let problem = format!("`{}` cannot be the id of an effect of your own", self.id);
            let hint = "small letters, digits and _, and no effect of the catalogue";
            return Err(CustomError::new(Part::Id, 0..self.id.len(), &problem, hint));
        }
        let (tree, names) = parse::parse(&self.expression)?;
        let mut declared = vec![None; names.len()];
        for (name, unit) in &self.units {
            let part = Part::Unit(name.clone());
            let fail = |problem: String, hint: &str| {
                Err(CustomError::new(part.clone(), 0..unit.len(), &problem, hint))
            };
            let Some(index) = names.iter().position(|it| it == name) else {
                let hint = format!("it has {}", list(&names));
                return fail(format!("the expression has no parameter `{name}`"), &hint);
            };
            match Unit::parse(unit) {
                Ok(it) => declared[index] = Some(it),
                Err(problem) => return fail(problem, unit::HINT),
            }
        }
        let amplitudes = amplitudes(&tree, names.len()).ok_or_else(|| {
            let problem = "no parameter makes it vanish at zero";
            let hint =
                "an effect that is not there must be nothing: put a parameter in front, k * (...)";
            CustomError::new(Part::Expression, tree.at.clone(), problem, hint)
        })?;
        let target = Unit(match self.target {
            Target::Dtheta => [0.0; 3],
            _ => [1.0, 0.0, 0.0],
        });
        let wanted = Unit(core::array::from_fn(|i| target.0[i] - self.per.unit().0[i]));
        let target_name = format!("{} per {}", self.target.name(), self.per.name());
        let units = unit::units(&tree, wanted, &target_name, &declared, &names)?;
        let parameters = (0..names.len())
            .map(|index| self.parameter(&tree, index, &names[index], units[index], &amplitudes))
            .collect::<Result<Vec<_>, _>>()?;
        if let Some((name, _)) = self.ranges.iter().find(|(name, _)| !names.contains(name)) {
            let problem = format!("the expression has no parameter `{name}`");
            let hint = format!("it has {}", list(&names));
            return Err(CustomError::new(Part::Range(name.clone()), 0..0, &problem, &hint));
        }
        if let Some((when, instead)) = without_bound(&tree, self.per, names.len()) {
            let problem = format!("it grows without bound when the robot {when}");
            let hint = format!("no division by what becomes zero there: {instead}, for example");
            return Err(CustomError::new(Part::Expression, tree.at.clone(), &problem, &hint));
        }
        let facts = Box::leak(Box::new(Facts {
            id: kept(self.id.clone()),
            name: kept(format!("your own {}", self.id)),
            equation: kept(self.equation()),
            parameters: Box::leak(parameters.into_boxed_slice()),
            acts_on: ActsOn::Motion,
            signature: kept(format!("{} proportional to {}", self.target.name(), self.expression)),
            shown_by: "runs in which what stands in its expression varies",
            compensation: "a term in the odometry",
        }));
        let (target, per) = (self.target, self.per);
        Ok(Box::leak(Box::new(CustomEffect { custom: self.clone(), facts, tree, target, per })))
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
        let shown =
            self.units.get(name).map_or_else(|| unit.to_string(), |it| it.trim().to_owned());
        let range = match self.ranges.get(name) {
            Some([low, high]) => {
                let sound = low.is_finite() && high.is_finite() && low < high;
                let holds_zero = *low <= 0.0 && *high >= 0.0;
                if !sound || (is_amplitude && !holds_zero) {
                    let problem = format!("{low} to {high} cannot be the range of {name}");
                    let hint = if is_amplitude {
                        "the lower end first, and zero within: at zero the effect is gone"
                    } else {
                        "the lower end first"
                    };
                    return Err(CustomError::new(Part::Range(name.into()), 0..0, &problem, hint));
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
        let role = if is_amplitude { Role::Amplitude } else { Role::Shape };
        Ok(Parameter {
            name: kept(name.into()),
            unit: kept(shown),
            low: range.0,
            high: range.1,
            role,
        })
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

/// Text that lives as long as the program; an effect's facts do.
fn kept(text: String) -> &'static str {
    Box::leak(text.into_boxed_str())
}

/// An effect of the user's own.
#[derive(Debug)]
pub struct CustomEffect {
    custom: Custom,
    facts: &'static Facts,
    tree: Tree,
    target: Target,
    per: Per,
}

impl CustomEffect {
    /// What the user said.
    pub fn custom(&self) -> &Custom {
        &self.custom
    }
}

impl Effect for CustomEffect {
    fn facts(&self) -> &'static Facts {
        self.facts
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let rate = evaluate::evaluate(&self.tree, p, step);
        if !(rate.value.is_finite() && rate.by.iter().all(|it| it.is_finite())) {
            return Change::NONE;
        }
        let amount = |metres: f64| {
            rate * match self.per {
                Per::Second => step.dt_s,
                Per::Metre => metres.abs(),
                Per::Radian => step.turn_rad().abs(),
            }
        };
        let travel_m = step.wheel_travel_m();
        let nothing = Jet::ZERO;
        match self.target {
            Target::DsLeft => {
                let angle = amount(travel_m.left) / step.wheel_radius_m;
                Change { angle_rad: Sides::new(angle, nothing), ..Change::NONE }
            }
            Target::DsRight => {
                let angle = amount(travel_m.right) / step.wheel_radius_m;
                Change { angle_rad: Sides::new(nothing, angle), ..Change::NONE }
            }
            Target::Dtheta => Change { turn_rad: amount(step.travel_m()), ..Change::NONE },
            Target::Dn => Change { sideways_m: amount(step.travel_m()), ..Change::NONE },
        }
    }

    fn starts(&self, _survey: &Survey) -> Vec<Vec<f64>> {
        let parameters = self.facts.parameters;
        if parameters.iter().all(|it| it.role == Role::Amplitude) {
            return vec![vec![0.0; parameters.len()]];
        }
        // Three places within each range; evenly by factors where it is positive.
        [0.5, 0.35, 0.65]
            .map(|share: f64| {
                let at = |it: &Parameter| match it.role {
                    Role::Amplitude => 0.0,
                    Role::Shape if it.low > 0.0 => it.low * (it.high / it.low).powf(share),
                    Role::Shape => it.low + share * (it.high - it.low),
                };
                parameters.iter().map(at).collect()
            })
            .into()
    }
}

/// Steps at which the shape of an expression is probed: nothing special about any of them.
fn probes() -> [Step; 3] {
    let step = |v: f64, omega: f64, a: f64, t: f64| Step {
        t_s: 0.4 * t,
        dt_s: 0.1,
        clock_s: 90.0 * t,
        phi_rad: Sides::new(0.7 * t, 1.1 * t),
        dphi_rad: Sides::new(0.21, 0.34),
        wheel_speed_mps: Sides::new(v - 0.186 * omega, v + 0.186 * omega),
        wheel_accel_mps2: Sides::new(0.9 * a, 1.2 * a),
        path_m: 0.3 * t,
        since_reversal_m: Some(0.1 * t),
        payload_kg: 0.5 * t,
        wheel_radius_m: 0.036,
        track_width_m: 0.372,
        gear_reduction: 1.0,
        heading_rad: 0.6 * t,
        place_m: [0.2 * t, -0.1 * t],
    };
    [step(0.31, 0.72, 0.23, 3.1), step(0.17, -1.3, -0.41, 1.7), step(-0.23, 0.37, 0.11, 4.3)]
}

/// The largest set of parameters in which the expression is linear and with which it vanishes.
fn amplitudes(tree: &Tree, count: usize) -> Option<Vec<usize>> {
    let subsets = (1_u32..1 << count)
        .map(|bits| -> Vec<usize> { (0..count).filter(|j| bits & (1 << j) != 0).collect() });
    let mut subsets: Vec<_> = subsets.collect();
    subsets.sort_by_key(|it| core::cmp::Reverse(it.len()));
    let others = [0.83, 1.31, 0.57, 1.71];
    let (a, b) = ([0.41, -0.77, 1.23, 0.29], [-1.1, 0.63, 0.37, -0.91]);
    subsets.into_iter().find(|set| {
        let value = |step: &Step, of: &dyn Fn(usize) -> f64| {
            let at: Vec<f64> =
                (0..count).map(|j| if set.contains(&j) { of(j) } else { others[j] }).collect();
            evaluate::evaluate(tree, &Jet::parameters(&at), step).value
        };
        let mut finite = 0;
        let linear = probes().iter().all(|step| {
            let (of_a, of_b) = (value(step, &|j| a[j]), value(step, &|j| b[j]));
            let both = value(step, &|j| 2.0 * a[j] + b[j]);
            if !(of_a.is_finite() && of_b.is_finite() && both.is_finite()) {
                return true;
            }
            finite += 1;
            // A few roundings of sums of such numbers.
            (both - 2.0 * of_a - of_b).abs() <= 1e-9 * (of_a.abs() + of_b.abs() + both.abs())
        });
        linear && finite > 0
    })
}

/// When what an expression gives in a second grows without bound, and what to write instead; every run has such
/// moments, and a fit to them would be about nothing else.
fn without_bound(tree: &Tree, per: Per, count: usize) -> Option<(&'static str, &'static str)> {
    // Of what it was; and how much more a thousandth of that must give.
    const SLOWER: [f64; 2] = [1e-3, 1e-6];
    const GROWS: f64 = 100.0;
    let amount = |step: &Step| {
        let at = Jet::parameters(&[0.83, 1.31, 0.57, 1.71][..count]);
        let rate = evaluate::evaluate(tree, &at, step).value;
        let times = match per {
            Per::Second => 1.0,
            Per::Metre => step.speed_mps(),
            Per::Radian => step.turn_rate_rad_s(),
        };
        (rate * times).abs()
    };
    let slowly = |step: &Step, share: f64| Step {
        dphi_rad: step.dphi_rad.map(|it| share * it),
        wheel_speed_mps: step.wheel_speed_mps.map(|it| share * it),
        ..*step
    };
    let evenly = |step: &Step, share: f64| Step {
        wheel_accel_mps2: step.wheel_accel_mps2.map(|it| share * it),
        ..*step
    };
    let grows = |like: &dyn Fn(&Step, f64) -> Step| {
        probes().iter().any(|step| {
            let [slow, slower] = SLOWER.map(|share| amount(&like(step, share)));
            slow.is_finite() && slower > GROWS * slow
        })
    };
    if grows(&slowly) {
        Some(("stands", "k / max(abs(v), 0.02[m/s])"))
    } else if grows(&evenly) {
        Some(("drives evenly", "k / max(abs(a), 0.02[m/s^2])"))
    } else {
        None
    }
}

/// An amplitude beyond this would be seen with the naked eye: a fifth of the way, or of a radian a
/// metre or a second.
fn plausible_limit(tree: &Tree, index: usize, target: Target, per: Per) -> f64 {
    let most: f64 = match (target, per) {
        (Target::Dtheta, _) | (_, Per::Metre) => 0.2,
        (_, Per::Second | Per::Radian) => 0.1,
    };
    let slopes = probes().map(|step| {
        let at = Jet::parameters(&[0.83, 1.31, 0.57, 1.71]);
        evaluate::evaluate(tree, &at, &step).by[index].abs()
    });
    let slope = slopes.into_iter().filter(|it| it.is_finite()).fold(0.0, f64::max);
    if slope > 0.0 { most / slope } else { most }
}

/// What a quantity of this unit is, give or take, at a small robot: 0.3 m, 1 s, 2 kg.
fn typical_of(unit: Unit) -> f64 {
    let [m, s, kg] = unit.0;
    0.3_f64.powf(m) * 1.0_f64.powf(s) * 2.0_f64.powf(kg)
}
