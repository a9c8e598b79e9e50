//! What is wrong with an equation of the user's own, where, and what to try, in words.

use std::collections::BTreeMap;
use std::path::Path;

use robot_model::expression::{
    DefinitionPart, Expected, ExpressionError, ExpressionProblem, RequiredUnit, UnboundedWhen,
};
use toml::Spanned;

use crate::{CampaignError, Place};

/// What an equation is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The path: `dtheta = ...`.
    Path,
    /// The motors: `dV = ...`.
    Motors,
}

impl About {
    /// An equation, and what can stand on its left.
    const fn example(self) -> &'static str {
        match self {
            Self::Path => {
                "for example dtheta = k * v^2 * omega; the left side is ds_left, ds_right, dtheta or \
                 dn, followed by /dt, /ds or /dtheta for per second, metre or radian"
            }
            Self::Motors => {
                "for example dV = q * v * abs(v); the left side is dV, dkS, dkV or dkA, followed by \
                 _left or _right for one motor"
            }
        }
    }

    /// A unit that a parameter may have.
    const fn unit(self) -> &'static str {
        match self {
            Self::Path => "s/m",
            Self::Motors => "V s/m",
        }
    }

    /// An error in an equation, with its column and a caret.
    pub fn error(self, text: &str, error: &ExpressionError) -> CampaignError {
        let column = text.get(..error.at.start).map_or(0, |start| start.chars().count()) as u64 + 1;
        let place = Place { line: 1, column, ..Place::whole(Path::new("the equation")) };
        let told = problem(&error.problem) + &caret(text, error);
        CampaignError::new(place, told, hint(&error.problem, self))
    }
}

/// Where the declaration of an effect stands in its file, in bytes.
pub struct Declaration<'a> {
    pub about: About,
    pub start: usize,
    pub left_side: usize,
    /// As long as the string has no escapes.
    pub expression: usize,
    pub expression_text: &'a str,
    pub unit: &'a BTreeMap<String, Spanned<String>>,
    pub range: &'a BTreeMap<String, Spanned<[f64; 2]>>,
}

impl Declaration<'_> {
    /// An error in it.
    pub fn error(&self, file: &Path, text: &str, error: &ExpressionError) -> CampaignError {
        let byte = match &error.part {
            DefinitionPart::Id => self.start,
            DefinitionPart::Target => self.left_side,
            DefinitionPart::Expression => self.expression + error.at.start,
            DefinitionPart::Unit(name) => {
                let inside = |unit: &Spanned<String>| unit.span().start + 1 + error.at.start;
                self.unit.get(name).map_or(self.start, inside)
            }
            DefinitionPart::Range(name) => {
                self.range.get(name).map_or(self.start, |range| range.span().start)
            }
        };
        let mut told = problem(&error.problem);
        if error.part == DefinitionPart::Expression {
            told += &caret(self.expression_text, error);
        }
        CampaignError::new(Place::of_byte(file, text, byte), told, hint(&error.problem, self.about))
    }
}

/// The text, and on the next line carets under what is wrong.
fn caret(text: &str, error: &ExpressionError) -> String {
    let before = text.get(..error.at.start).map_or(0, |start| start.chars().count());
    let wide = text.get(error.at.clone()).map_or(1, |wrong| wrong.chars().count()).max(1);
    format!("\n    {text}\n    {}{}", " ".repeat(before), "^".repeat(wide))
}

/// Values by name, without their places.
pub fn values<A, B>(
    from: &BTreeMap<String, Spanned<A>>,
    of: impl Fn(&A) -> B,
) -> BTreeMap<String, B> {
    from.iter().map(|(name, value)| (name.clone(), of(value.get_ref()))).collect()
}

/// This id, or with the first number behind it that makes it free.
pub fn free_id(wanted: String, is_taken: impl Fn(&str) -> bool) -> String {
    if !is_taken(&wanted) {
        return wanted;
    }
    let mut numbered = (2_u64..).map(|number| format!("{wanted}_{number}"));
    numbered.find(|id| !is_taken(id)).unwrap_or(wanted)
}

/// A TOML string.
pub fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// What stands in a comment must stay one line, whatever a user's own effect is called.
pub fn one_line(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ")
}

/// What is wrong.
fn problem(problem: &ExpressionProblem) -> String {
    use ExpressionProblem as P;
    match problem {
        P::Id(id) => format!("`{id}` cannot be the id of an effect of your own"),
        P::NoEquals => "there is no = in it".to_owned(),
        P::Target(left) if left.is_empty() => "there is nothing on the left of =".to_owned(),
        P::Target(left) => format!("`{left}` cannot be changed"),
        P::NoParameter { name, .. } => format!("the expression has no parameter `{name}`"),
        P::Range { name, range: [low, high], .. } => {
            format!("{low} to {high} cannot be the range of {name}")
        }
        P::NoPlausibleValue(name) => format!("no plausible value of `{name}` follows from this"),
        P::DoesNotVanish => "the effect does not vanish when its parameters are zero".to_owned(),
        P::Unbounded(UnboundedWhen::AtRest) => {
            "it grows without bound when the robot stands still".to_owned()
        }
        P::Unbounded(UnboundedWhen::AtConstantSpeed) => {
            "it grows without bound when the robot drives at constant speed".to_owned()
        }
        P::Unbounded(UnboundedWhen::WithoutVoltage) => {
            "it grows without bound when the voltage goes to zero".to_owned()
        }
        P::ExponentTooLarge(power) => format!("the exponent {power} is too large"),
        P::NotAUnit(text) => format!("`{text}` is not a unit"),
        P::NotAnSiBaseUnit(unit) => format!("`{unit}` is not an SI base unit"),
        P::WrongUnit { required, factor } => {
            format!("{} (by a factor of {factor})", wrong_unit(required))
        }
        P::UnknownUnit(name) => format!("the unit of {name} does not follow from this"),
        P::Unexpected { found, .. } => format!("`{found}` cannot stand here"),
        P::EndsEarly => "the expression ends too early".to_owned(),
        P::ClosesNothing => "this parenthesis closes nothing".to_owned(),
        P::OpenParenthesis => "this parenthesis is never closed".to_owned(),
        P::OpenBracket => "this bracket is never closed".to_owned(),
        P::DoubleStar => "`**` is not an operator here".to_owned(),
        P::NoOperator => "a factor without its operator".to_owned(),
        P::NotANumber(text) => format!("`{text}` is not a number"),
        P::TooLong(most) => format!("this has more than {most} numbers, names and operators"),
        P::TooDeep => "nested too deep".to_owned(),
        P::Arguments { function, takes: 1, found } => {
            format!("{function} takes 1 argument, here are {found}")
        }
        P::Arguments { function, takes, found: 1 } => {
            format!("{function} takes {takes} arguments, here is 1")
        }
        P::Arguments { function, takes, found } => {
            format!("{function} takes {takes} arguments, here are {found}")
        }
        P::NotCalled(name) => format!("{name} is a function"),
        P::VariableCalled(name) => format!("{name} is not a function"),
        P::NoFunction { name, .. } => format!("there is no function {name}"),
        P::LooksLike { name, .. } => {
            format!("`{name}` is neither a variable nor a good name for a parameter")
        }
        P::Reserved { name, .. } => {
            format!("`{name}` is no variable here, and would mislead as a parameter")
        }
        P::TooManyParameters { name, most } => {
            format!("`{name}` would be parameter number {}", most + 1)
        }
    }
}

fn wrong_unit(required: &RequiredUnit) -> String {
    match required {
        RequiredUnit::LeftSide(left) => {
            let per = left.per.map_or_else(String::new, |per| format!(" per {per}"));
            let (quantity, unit) = (left.quantity, &left.unit);
            format!("{quantity}{per} has the unit {unit}, but the right side has another")
        }
        RequiredUnit::Argument(function) => {
            format!("the argument of {function} must not have a unit")
        }
        RequiredUnit::Exponent => "an exponent must not have a unit".to_owned(),
        RequiredUnit::Base => "a base with a variable exponent must not have a unit".to_owned(),
        RequiredUnit::Same => "these two have different units".to_owned(),
    }
}

/// What to try, where it has names or numbers of the problem in it.
fn hint_with_names(problem: &ExpressionProblem, about: About) -> Option<String> {
    use ExpressionProblem as P;
    Some(match problem {
        P::NoParameter { parameters, .. } if parameters.is_empty() => "it has none".to_owned(),
        P::NoParameter { parameters, .. } => format!("it has {}", parameters.join(", ")),
        P::UnknownUnit(name) => {
            let unit = about.unit();
            format!(
                "declare it, for example --unit \"{name}={unit}\"; in a file unit.{name} = \"{unit}\""
            )
        }
        P::NotCalled(name) => format!("write {name}(...)"),
        P::NoFunction { functions, .. } => {
            format!("there are {}; multiply with *", functions.join(", "))
        }
        P::Reserved { variables, .. } => {
            format!("the variables are {}; or choose another name", variables.join(", "))
        }
        P::LooksLike { variable, .. } => format!("did you mean {variable}?"),
        P::TooManyParameters { most, .. } => format!("at most {most} can be fitted"),
        _ => return None,
    })
}

/// What to try.
fn hint(problem: &ExpressionProblem, about: About) -> String {
    use ExpressionProblem as P;
    if let Some(hint) = hint_with_names(problem, about) {
        return hint;
    }
    let hint = match problem {
        P::Id(_) => "small letters, digits and _, and no effect of the catalogue",
        P::NoEquals | P::Target(_) => about.example(),
        P::Range { of_amplitude: true, .. } => {
            "two finite numbers, the lower one first, and zero within: at zero the effect is gone"
        }
        P::Range { of_amplitude: false, .. } => "two finite numbers, the lower one first",
        P::NoPlausibleValue(_) => {
            "numbers of everyday size in SI units, and units with small powers; or declare its range"
        }
        P::DoesNotVanish => "multiply it by a parameter: k * (...)",
        P::Unbounded(UnboundedWhen::AtRest) => {
            "do not divide by something that can be zero: write k / max(abs(v), 0.02[m/s]), for example"
        }
        P::Unbounded(UnboundedWhen::AtConstantSpeed) => {
            "do not divide by something that can be zero: write k / max(abs(a), 0.02[m/s^2]), for example"
        }
        P::Unbounded(UnboundedWhen::WithoutVoltage) => {
            "do not divide by something that can be zero: write k / max(abs(volts), 0.1[V]), for example"
        }
        P::ExponentTooLarge(_) => "at most 100 either way",
        P::NotAUnit(_) | P::NotAnSiBaseUnit(_) => {
            "for example 1, m, s/m, m/s^2, rad/m, s^2/m^2, 1/kg, V s/m"
        }
        P::WrongUnit { required: RequiredUnit::LeftSide(left), .. } => match left.per {
            None => "check each factor; or declare another unit",
            Some(_) => "check each factor; or declare another unit, or another per",
        },
        P::WrongUnit { required: RequiredUnit::Same, .. } => {
            "a number can carry its unit: 0.3[m/s]"
        }
        P::WrongUnit { .. } => "divide it by something of its own unit",
        P::Unexpected { expected: Expected::Operator, .. } => "an operator was expected: + - * / ^",
        P::Unexpected { expected: Expected::OperatorOrClose, .. } => {
            "an operator or ) was expected"
        }
        P::Unexpected { expected: Expected::Operand, .. } | P::EndsEarly => {
            "a number, a variable, a parameter or ( was expected"
        }
        P::ClosesNothing => "take it out",
        P::OpenParenthesis => "add the missing )",
        P::OpenBracket => "for example 0.3[m/s]",
        P::DoubleStar => "a power is written v^2",
        P::NoOperator => "multiply with *: 2*v",
        P::NotANumber(_) => "for example 0.3 or 2e-3",
        P::TooLong(_) => "write it with fewer terms",
        P::TooDeep => "write it with fewer parentheses",
        P::Arguments { .. } => "separate arguments by commas",
        P::VariableCalled(_) => "multiply with *",
        // Told above.
        P::NoParameter { .. }
        | P::UnknownUnit(_)
        | P::NotCalled(_)
        | P::NoFunction { .. }
        | P::Reserved { .. }
        | P::LooksLike { .. }
        | P::TooManyParameters { .. } => "",
    };
    hint.to_owned()
}

#[cfg(test)]
mod tests {
    use robot_model::drivetrain::MotorCustom;
    use robot_model::effect::Custom;
    use robot_model::expression::ExpressionError;

    use super::{About, hint, problem};

    fn told_of(error: &ExpressionError, about: About) -> String {
        format!("{}; {}", problem(&error.problem), hint(&error.problem, about))
    }

    #[test]
    fn every_mistake_is_told_with_a_hint() {
        for (equation, told) in [
            ("k * v", "there is no = in it; for example dtheta = "),
            ("dx = k * v", "`dx` cannot be changed; for example dtheta = "),
            ("dtheta = ", "the expression ends too early; a number, a variable"),
            ("dtheta = k v", "`v` cannot stand here; an operator was expected"),
            ("dtheta = k * (v v)", "`v` cannot stand here; an operator or ) was expected"),
            ("dtheta = k ** 2", "`**` is not an operator here; a power is written v^2"),
            ("dtheta = k * sine(v)", "there is no function sine; there are sin, cos,"),
            ("dtheta = k * sin", "sin is a function; write sin(...)"),
            ("dtheta = k * max(v)", "max takes 2 arguments, here is 1; separate arguments"),
            ("dtheta = k * sin(v, v)", "sin takes 1 argument, here are 2; separate arguments"),
            ("dtheta = k * v(2)", "v is not a function; multiply with *"),
            ("dtheta = k1+k2+k3+k4+k5", "`k5` would be parameter number 5; at most 4"),
            ("dtheta = k * (v + omega)", "these two have different units (by a factor of m)"),
            ("dtheta = k * sin(v)", "the argument of sin must not have a unit (by a factor of m/s"),
            ("dtheta = k * v + 2 * v", "the effect does not vanish when its parameters are zero"),
            ("dn = k / a", "it grows without bound when the robot drives at constant speed"),
            ("dtheta = k * 3[mm]", "`mm` is not an SI base unit; for example 1, m, s/m"),
            (
                "dtheta = k1 * k2 * v",
                "the unit of k1 does not follow from this; declare it, for example --unit \"k1=s/m\"",
            ),
        ] {
            let custom = Custom::from_equation(equation);
            let error = custom.and_then(|custom| custom.build()).expect_err(equation);
            let found = told_of(&error, About::Path);
            assert!(found.starts_with(told), "{equation}: {found}");
        }
    }

    #[test]
    fn hints_of_equations_of_motors_are_about_motors() {
        for (equation, told) in [
            ("q * v", "there is no = in it; for example dV = q * v"),
            ("dtheta = k * v", "`dtheta` cannot be changed; for example dV = q"),
            (
                "dV = a * b * v",
                "the unit of a does not follow from this; declare it, for example --unit \"a=V s/m\"",
            ),
            (
                "dV = k * v_left",
                "`v_left` is no variable here, and would mislead as a parameter; the variables are v, v_other",
            ),
            ("dV = k / volts", "it grows without bound when the voltage goes to zero; do not"),
            ("dV = k / v", "it grows without bound when the robot stands still; do not divide"),
            ("dV = 2[V] * k * v * 1[s/m] * exp(k * v)", "the effect does not vanish when"),
        ] {
            let custom = MotorCustom::from_equation(equation);
            let error = custom.and_then(|custom| custom.build()).expect_err(equation);
            let found = told_of(&error, About::Motors);
            assert!(found.starts_with(told), "{equation}: {found}");
        }
        let mut custom = MotorCustom::from_equation("dkV = k * abs(v)").expect("an equation");
        custom.units.insert("k".into(), "V s/m".into());
        let found = told_of(&custom.build().expect_err("a wrong unit"), About::Motors);
        assert!(
            found.starts_with("dkV has the unit V s/m, but the right side has another"),
            "{found}"
        );
    }
}
