//! The targets.

mod campaign_files;
mod equations_and_scenarios;
mod frames;
mod logs;
mod robot;
mod tables;
mod typed_input;

use crate::memory::in_proportion;

/// One kind of input, and what must hold of it.
pub struct Target {
    /// Its name, and that of its corpus.
    pub name: &'static str,
    /// What reads such an input, and what must hold.
    pub holds: &'static str,
    /// Its dictionary, a file of `fuzz/dictionary/`.
    pub dictionary: Option<&'static str>,
    /// The longest input that the search tries \[bytes\].
    pub len_max: usize,
    test: fn(&[u8]),
}

impl Target {
    /// Tests an input.
    ///
    /// # Panics
    /// If something does not hold that must.
    pub fn run(&self, input: &[u8]) {
        in_proportion(input.len(), || (self.test)(input));
    }

    /// The target of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        TARGETS.iter().find(|target| target.name == name)
    }
}

macro_rules! targets {
    ($($name:literal $len_max:literal $dictionary:expr, $test:path, $holds:literal;)*) => {
        /// All targets.
        pub const TARGETS: &[Target] = &[$(
            Target { name: $name, holds: $holds, dictionary: $dictionary, len_max: $len_max, test: $test }
        ),*];
    };
}

targets! {
    "frames" 1024 None, frames::frames,
        "any bytes on a line: a good frame, passed on, is the same; a flipped bit never changes what arrives";
    "messages" 512 None, frames::messages,
        "any payload on any channel: what is read is written and read the same, no longer than said; an accepted \
         configuration is in its ranges";
    "robot" 1024 None, robot::robot,
        "any frames, bytes, times and buttons at a whole robot: its answers can be read; without `Arm` no motor has \
         current; after an emergency stop none has; after silence it stands still";
    "robot_toml" 4096 Some("robot_toml"), campaign_files::robot_toml,
        "written and read the same; numbers finite";
    "run_csv" 4096 Some("table"), campaign_files::run_csv,
        "numbers in the ranges of their columns, times that increase; written and read the same";
    "model_toml" 4096 Some("model_toml"), campaign_files::model_toml,
        "written and read the same; numbers finite";
    "motors_toml" 4096 Some("model_toml"), campaign_files::motors_toml,
        "an effect of the user's own that is read has finite ranges and usual sizes";
    "plan_toml" 4096 Some("plan_toml"), campaign_files::plan_toml,
        "written and read the same; every run ends within the hour";
    "expression" 512 Some("expression"), equations_and_scenarios::expression,
        "an error points into the text; the equation is read the same again; what is built changes nothing at \
         zero, and never by what is not finite";
    "motor_expression" 512 Some("expression"), equations_and_scenarios::motor_expression,
        "the same of an equation of the motors, which changes nothing at amplitudes of zero";
    "scenario" 4096 Some("scenario"), equations_and_scenarios::scenario,
        "written and read the same; a robot of it stays finite";
    "track" 4096 Some("table"), tables::track,
        "numbers finite, times that increase, at least two positions; written and read the same";
    "gyro" 4096 Some("table"), tables::gyro,
        "numbers finite, times that increase";
    "config_set" 256 Some("config"), typed_input::config_set,
        "field and value: what is accepted is in its range, changes nothing else, and is shown so that it can be \
         set again";
    "config_file" 4096 Some("config"), typed_input::config_file,
        "in its ranges; written and read the same";
    "quantity" 128 Some("quantity"), typed_input::quantity,
        "any word of the command line: numbers finite; addresses and ports are read the same again";
    "bag" 49152 None, logs::bag,
        "a ROS 2 bag in MCAP or SQLite: numbers finite, times that increase; what is imported is read again";
    "log_table" 4096 Some("table"), logs::log_table,
        "a table or a trajectory of another program: numbers finite, times that increase";
    "wpilog" 4096 None, logs::wpilog,
        "a data log of WPILib: numbers finite, times that increase";
    "controller_yaml" 4096 None, logs::controller_yaml,
        "numbers above zero";
}
