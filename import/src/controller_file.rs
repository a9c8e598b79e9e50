//! The numbers of a controller from its file of ROS 2 parameters (YAML).
//!
//! Known are `diff_drive_controller` (`wheel_radius`, `wheel_separation` and their multipliers) and TurtleBot3's
//! `turtlebot3_node` (`wheels.radius`, `wheels.separation`). The names of nodes and namespaces above them do not matter.

use std::path::Path;

use campaign::bounded_read::read_keys;
use campaign::{CampaignError, Place};
use saphyr_parser::{Event, Parser};

use crate::geometry::Geometry;
use crate::log::error;

/// What a file says of a controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerFile {
    /// By which it computes odometry.
    pub geometry: Geometry,
    /// The odometry adds up what was commanded, and not how far the wheels turned.
    pub is_open_loop: bool,
    /// Turns are those of a gyro.
    pub uses_gyro: bool,
}

/// A number, a text or a truth value of a file, with the names above it.
#[derive(Clone, Debug, PartialEq)]
struct Parameter {
    names: Vec<String>,
    value: String,
    line: u64,
}

impl Parameter {
    /// The names above its own, and its own; a dot within a name is the same as a name within another.
    fn path(&self) -> String {
        self.names.join(".")
    }

    fn is(&self, owner: &str, name: &str) -> bool {
        self.path() == joined(owner, name)
    }
}

/// A name below others, if there are any.
fn joined(owner: &str, name: &str) -> String {
    if owner.is_empty() { name.to_owned() } else { format!("{owner}.{name}") }
}

/// More levels are no file of parameters.
const DEPTH_MAX: usize = 64;

/// Reads a file of parameters.
pub fn read(file: &Path) -> Result<ControllerFile, CampaignError> {
    parse(file, &read_keys(file).map_err(|cause| CampaignError::io(file, "read it", cause))?)
}

/// Reads the text of a file of parameters; errors call it `file`.
pub fn parse(file: &Path, text: &str) -> Result<ControllerFile, CampaignError> {
    let parameters = parameters(file, text)?;
    const RADII: [(&str, &str); 2] =
        [("wheel_radius", "wheel_separation"), ("wheels.radius", "wheels.separation")];
    let mut found: Vec<(String, &str, &str)> = Vec::new();
    for (radius, separation) in RADII {
        for parameter in &parameters {
            let path = parameter.path();
            let Some(owner) = path.strip_suffix(radius) else { continue };
            if !(owner.is_empty() || owner.ends_with('.')) {
                continue;
            }
            let owner = owner.trim_end_matches('.');
            let is_new = found.iter().all(|(other, name, _)| other != owner || *name != radius);
            if is_new && parameters.iter().any(|other| other.is(owner, separation)) {
                found.push((owner.to_owned(), radius, separation));
            }
        }
    }
    let (owner, radius, separation) = match found.as_slice() {
        [only] => only,
        [] => {
            let hint = "name a file of ROS 2 parameters with wheel_radius and wheel_separation (diff_drive_controller) or wheels.radius and wheels.separation (TurtleBot3), or give --wheel-radius and --track-width";
            return Err(error(
                file,
                "no controller in it has a wheel radius and a separation",
                hint,
            ));
        }
        several => {
            let owners: Vec<&str> = several.iter().map(|(owner, ..)| owner.as_str()).collect();
            let problem = format!("it has several controllers: {}", owners.join(", "));
            return Err(error(
                file,
                problem,
                "keep only the one whose odometry is in the bag, or give --wheel-radius and --track-width",
            ));
        }
    };
    let number = |name: &str, missing: Option<f64>| number(file, &parameters, owner, name, missing);
    let geometry = Geometry {
        wheel_radius_m: number(radius, None)?,
        radius_multipliers: [
            number("left_wheel_radius_multiplier", Some(1.0))?,
            number("right_wheel_radius_multiplier", Some(1.0))?,
        ],
        wheel_separation_m: number(separation, None)?,
        separation_multiplier: number("wheel_separation_multiplier", Some(1.0))?,
    };
    let is_true = |name: &str| {
        let mut own = parameters.iter().filter(|parameter| parameter.path().ends_with(name));
        own.any(|parameter| parameter.value.eq_ignore_ascii_case("true"))
    };
    Ok(ControllerFile {
        geometry,
        is_open_loop: is_true(&joined(owner, "open_loop")),
        // TurtleBot3 has it in another node of the same file.
        uses_gyro: is_true("odometry.use_imu"),
    })
}

/// A number above zero; if it is said more than once, the last one counts, as in ROS 2.
fn number(
    file: &Path,
    parameters: &[Parameter],
    owner: &str,
    name: &str,
    missing: Option<f64>,
) -> Result<f64, CampaignError> {
    let parameter = parameters.iter().rfind(|parameter| parameter.is(owner, name));
    let Some(parameter) = parameter else {
        return missing.ok_or_else(|| error(file, format!("{owner} has no {name}"), "add it"));
    };
    let number: Option<f64> = parameter.value.parse().ok();
    number.filter(|number| *number > 0.0 && number.is_finite()).ok_or_else(|| {
        let place = Place { line: parameter.line, ..Place::whole(file) };
        let problem = format!("{name} = `{}` is not a number above zero", parameter.value);
        CampaignError::new(place, problem, "give the number that the controller used")
    })
}

/// What is being read: a mapping, with the name whose value comes next; or a sequence, in which nothing has a name.
enum Level {
    Mapping(Option<String>),
    Sequence,
}

/// All values of a file that have a name.
fn parameters(file: &Path, text: &str) -> Result<Vec<Parameter>, CampaignError> {
    let wrong = |line: u64, problem: String| {
        let place = Place { line, ..Place::whole(file) };
        CampaignError::new(place, problem, "give a file of ROS 2 parameters (YAML)")
    };
    let mut levels: Vec<Level> = Vec::new();
    let mut parameters = Vec::new();
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|error| {
            wrong(error.marker().line() as u64, format!("this is not YAML: {}", error.info()))
        })?;
        let line = span.start.line() as u64;
        match event {
            Event::MappingStart(..) | Event::SequenceStart(..) if levels.len() == DEPTH_MAX => {
                return Err(wrong(line, format!("it has more than {DEPTH_MAX} levels")));
            }
            Event::MappingStart(..) => levels.push(Level::Mapping(None)),
            Event::SequenceStart(..) => levels.push(Level::Sequence),
            Event::MappingEnd | Event::SequenceEnd => {
                levels.pop();
                value_is_complete(&mut levels);
            }
            Event::Scalar(text, ..) => match levels.last_mut() {
                Some(Level::Mapping(name @ None)) => *name = Some(text.into_owned()),
                Some(Level::Mapping(Some(_))) => {
                    parameters.extend(names(&levels).map(|names| Parameter {
                        names,
                        value: text.into_owned(),
                        line,
                    }));
                    value_is_complete(&mut levels);
                }
                _ => {}
            },
            Event::Alias(_) => value_is_complete(&mut levels),
            _ => {}
        }
    }
    Ok(parameters)
}

/// The name of the mapping's next value comes next.
fn value_is_complete(levels: &mut [Level]) {
    if let Some(Level::Mapping(name)) = levels.last_mut() {
        *name = None;
    }
}

/// The names of all levels; `None` within a sequence.
fn names(levels: &[Level]) -> Option<Vec<String>> {
    let names = levels.iter().map(|level| match level {
        Level::Mapping(name) => name.clone(),
        Level::Sequence => None,
    });
    names.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<ControllerFile, String> {
        parse(Path::new("c.yaml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn both_kinds_of_files_are_read_with_their_multipliers() {
        let text = "\
controller_manager:
  ros__parameters: {update_rate: 100}
/my_robot/base:
  ros__parameters:
    left_wheel_names: [\"left\"]   # names
    wheel_separation: 0.372
    wheel_radius: 0.036
    left_wheel_radius_multiplier: 1.01
    open_loop: True
";
        let read = parsed(text).unwrap();
        let geometry =
            Geometry { radius_multipliers: [1.01, 1.0], ..Geometry::nominal(0.036, 0.372) };
        assert_eq!(read, ControllerFile { geometry, is_open_loop: true, uses_gyro: false });
        // Two keys of the same name, as in a file that TurtleBot3 has had.
        let text = "\
/**:
  turtlebot3_node:
    ros__parameters:
      wheels:
        separation: 0.160
        radius: 0.033
/**:
  diff_drive_controller:
    ros__parameters:
      odometry:
        use_imu: true
";
        let read = parsed(text).unwrap();
        let geometry = Geometry::nominal(0.033, 0.16);
        assert_eq!(read, ControllerFile { geometry, is_open_loop: false, uses_gyro: true });
        assert_eq!(
            parsed("wheel_radius: 0.033\nwheel_separation: 0.16\n").unwrap().geometry,
            geometry
        );
        let dots =
            "a:\n  ros__parameters:\n    wheels.radius: 0.033\n    wheels.separation: 0.16\n";
        assert_eq!(parsed(dots).unwrap().geometry, geometry);
    }

    #[test]
    fn a_file_that_does_not_say_it_is_one_error_with_its_line() {
        let several = "a:\n  wheel_radius: 1\n  wheel_separation: 1\nb:\n  wheel_radius: 1\n  wheel_separation: 1\n";
        let deep: String = (0..100).map(|level| format!("{}a:\n", " ".repeat(level))).collect();
        let deep_flow = "[".repeat(1000);
        let cases = [
            ("a: [1, 2", "c.yaml, line 2: this is not YAML: "),
            ("", "no controller in it has a wheel radius"),
            ("a:\n  wheel_radius: 0.036\n", "no controller in it has a wheel radius"),
            (
                "a:\n  wheel_radius: x\n  wheel_separation: 1\n",
                "c.yaml, line 2: wheel_radius = `x` is not a number",
            ),
            ("a:\n  wheel_radius: 1\n  wheel_separation: -1\n", "line 3"),
            ("a:\n  wheel_radius: &r 1\n  wheel_separation: *r\n", "no controller in it"),
            (several, "several controllers: a, b"),
            (&deep, "more than 64 levels"),
            (&deep_flow, "this is not YAML"),
        ];
        for (text, says) in cases {
            let said = parsed(text).unwrap_err();
            assert!(said.contains(says), "{text:?}: {said}");
        }
    }
}
