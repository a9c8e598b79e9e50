//! What stands behind `beeline model add` and `remove`: effects, a campaign, and equations with units and ranges.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use campaign::model::{custom_from_equation, equation_error};
use campaign::motor_model::{motor_custom_from_equation, motor_equation_error};
use robot_model::drivetrain::MotorCustom;
use robot_model::effect::Custom;
use robot_model::expression::ExpressionError;

use crate::cli::AddArgs;
use crate::error::{Error, Result};

/// An effect of the user's own, of the path or of the motors.
pub(super) trait Equation: Sized {
    /// Reads an equation.
    fn read(text: &str) -> Result<Self>;

    /// The names of its parameters.
    fn parameters(&self) -> std::result::Result<Vec<String>, ExpressionError>;

    /// An error in a text of it, in words.
    fn error(text: &str, error: &ExpressionError) -> Error;

    fn id(&mut self) -> &mut String;
    fn units(&mut self) -> &mut BTreeMap<String, String>;
    fn ranges(&mut self) -> &mut BTreeMap<String, [f64; 2]>;
}

macro_rules! equation {
    ($custom:ty, $read:path, $error:path) => {
        impl Equation for $custom {
            fn read(text: &str) -> Result<Self> {
                Ok($read(text)?)
            }

            fn parameters(&self) -> std::result::Result<Vec<String>, ExpressionError> {
                <$custom>::parameters(self)
            }

            fn error(text: &str, error: &ExpressionError) -> Error {
                $error(text, error).into()
            }

            fn id(&mut self) -> &mut String {
                &mut self.id
            }

            fn units(&mut self) -> &mut BTreeMap<String, String> {
                &mut self.units
            }

            fn ranges(&mut self) -> &mut BTreeMap<String, [f64; 2]> {
                &mut self.ranges
            }
        }
    };
}

equation!(Custom, custom_from_equation, equation_error);
equation!(MotorCustom, motor_custom_from_equation, motor_equation_error);

/// The equations, each with its name and the units and ranges of its own parameters.
pub(super) fn equations<E: Equation>(args: &AddArgs) -> Result<Vec<E>> {
    let read = |text: &String| {
        let equation = E::read(text)?;
        let own = equation.parameters().map_err(|error| E::error(text, &error))?;
        Ok((equation, own))
    };
    let mut read = args.custom.iter().map(read).collect::<Result<Vec<_>>>()?;
    let of_units = args.unit.iter().map(|unit| &unit.0);
    for name in of_units.chain(args.range.iter().map(|range| &range.0)) {
        if !read.iter().any(|(_, own)| own.contains(name)) {
            return Err(Error::new(format_args!("no --custom has a parameter `{name}`"))
                .hint("--unit and --range name a parameter of an equation"));
        }
    }
    for (index, (equation, own)) in read.iter_mut().enumerate() {
        equation.units().extend(args.unit.iter().filter(|unit| own.contains(&unit.0)).cloned());
        equation.ranges().extend(args.range.iter().filter(|one| own.contains(&one.0)).cloned());
        if let Some(name) = args.name.get(index) {
            equation.id().clone_from(name);
        }
    }
    Ok(read.into_iter().map(|one| one.0).collect())
}

/// Refuses a name that the user gave and that an effect has.
pub(super) fn names_are_free(args: &AddArgs, is_taken: impl Fn(&str) -> bool) -> Result<()> {
    for (index, name) in args.name.iter().enumerate() {
        if is_taken(name) || args.name[..index].contains(name) {
            return Err(Error::new(format_args!("there is an effect `{name}` already"))
                .hint("choose another --name, or remove that effect first"));
        }
    }
    Ok(())
}

/// Effects and, last, the campaign.
pub(super) fn split<'a>(
    what: &'a [PathBuf],
    effects_needed: bool,
    verb: &str,
    example: &str,
) -> Result<(Vec<String>, &'a Path)> {
    let (campaign, effects) = what.split_last().ok_or_else(|| Error::new("which campaign?"))?;
    if effects.is_empty() && effects_needed {
        return Err(Error::new(format_args!(
            "name an effect and a campaign; there is only {}",
            campaign.display()
        ))
        .hint(format_args!("`beeline model {verb} {example}`")));
    }
    Ok((effects.iter().map(|effect| effect.to_string_lossy().into_owned()).collect(), campaign))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    /// The arguments alone.
    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        add: AddArgs,
    }

    fn args(line: &[&str]) -> AddArgs {
        Line::parse_from([&["add"], line, &["robot"]].concat()).add
    }

    #[test]
    fn units_and_ranges_go_to_the_equation_with_that_parameter() {
        let both = ["--custom", "dtheta/ds = c + both * s", "--custom", "dn/ds = q * v * both"];
        let declared =
            ["--unit=c=1/m", "--unit=q=s/m", "--range=q=-0.1..0.1", "--range=both=-1..1"];
        let customs: Vec<Custom> = equations(&args(&[&both[..], &declared].concat())).unwrap();
        let names =
            |of: &[&String]| of.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(" ");
        let has = |k: usize| {
            let custom = &customs[k];
            let units: Vec<_> = custom.units.keys().collect();
            let ranges: Vec<_> = custom.ranges.keys().collect();
            (names(&units), names(&ranges))
        };
        assert_eq!(has(0), ("c".to_owned(), "both".to_owned()));
        assert_eq!(has(1), ("q".to_owned(), "both q".to_owned()));
        for declared in ["--unit=d=m", "--range=d=0..1"] {
            let wrong = args(&[&both[..], &[declared]].concat());
            let error = equations::<Custom>(&wrong).unwrap_err().to_string();
            assert!(error.contains("no --custom has a parameter `d`"), "{error}");
        }
    }

    #[test]
    fn names_go_to_the_equations_in_their_order() {
        let line = ["--custom=dV = q * v", "--custom=dkS_left = k", "--name=a", "--name=b"];
        let equations: Vec<MotorCustom> = equations(&args(&line)).unwrap();
        let ids: Vec<&str> = equations.iter().map(|one| one.id.as_str()).collect();
        assert_eq!(ids, ["a", "b"]);
    }
}
