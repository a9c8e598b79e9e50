//! What is wrong with an equation of the user's own, and what to try, in words.

use robot_model::effect::custom::{CustomProblem, Expected, RequiredUnit, UnboundedWhen};

/// What is wrong.
pub fn problem(problem: &CustomProblem) -> String {
    use CustomProblem as P;
    match problem {
        P::Id(id) => format!("`{id}` cannot be the id of an effect of your own"),
        P::NoEquals => "there is no = in it".to_owned(),
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
        P::TooManyParameters { name, most } => {
            format!("`{name}` would be parameter number {}", most + 1)
        }
    }
}

fn wrong_unit(required: &RequiredUnit) -> String {
    match required {
        RequiredUnit::Target { target, per, unit } => format!(
            "{} per {} has the unit {unit}, but the right side has another",
            target.name(),
            per.name()
        ),
        RequiredUnit::Argument(function) => {
            format!("the argument of {function} must not have a unit")
        }
        RequiredUnit::Exponent => "an exponent must not have a unit".to_owned(),
        RequiredUnit::Base => "a base with a variable exponent must not have a unit".to_owned(),
        RequiredUnit::Same => "these two have different units".to_owned(),
    }
}

/// What to try.
pub fn hint(problem: &CustomProblem) -> String {
    use CustomProblem as P;
    let hint = match problem {
        P::NoParameter { parameters, .. } if parameters.is_empty() => "it has none",
        P::NoParameter { parameters, .. } => return format!("it has {}", parameters.join(", ")),
        P::UnknownUnit(name) => return format!("declare it: {name} in s/m, for example"),
        P::NotCalled(name) => return format!("write {name}(...)"),
        P::NoFunction { functions, .. } => {
            return format!("there are {}; multiply with *", functions.join(", "));
        }
        P::LooksLike { variable, .. } => return format!("did you mean {variable}?"),
        P::TooManyParameters { most, .. } => return format!("at most {most} can be fitted"),
        P::Id(_) => "small letters, digits and _, and no effect of the catalogue",
        P::NoEquals | P::Target(_) => {
            "for example dtheta = k * v^2 * omega; the left side is ds_left, ds_right, dtheta or \
             dn, followed by /dt, /ds or /dtheta for per second, metre or radian"
        }
        P::Range { of_amplitude: true, .. } => {
            "the lower end first, and zero within: at zero the effect is gone"
        }
        P::Range { of_amplitude: false, .. } => "the lower end first",
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
        P::NotAUnit(_) | P::NotAnSiBaseUnit(_) => {
            "for example 1, m, s/m, m/s^2, rad/m, s^2/m^2, 1/kg"
        }
        P::WrongUnit { required: RequiredUnit::Target { .. }, .. } => {
            "check each factor; or declare another unit, or another per"
        }
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
    };
    hint.to_owned()
}

#[cfg(test)]
mod tests {
    use robot_model::effect::Custom;

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
            ("dtheta = k1 * k2 * v", "the unit of k1 does not follow from this; declare it: k1 in"),
        ] {
            let custom = Custom::from_equation(equation);
            let error = custom.and_then(|custom| custom.build()).expect_err(equation);
            let found =
                format!("{}; {}", super::problem(&error.problem), super::hint(&error.problem));
            assert!(found.starts_with(told), "{equation}: {found}");
        }
    }
}
