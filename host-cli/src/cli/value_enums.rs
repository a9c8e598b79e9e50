//! Arguments that name one of several choices.

use std::path::PathBuf;
use std::str::FromStr;

/// How the robot's deviation is measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// The simulator's overhead camera.
    Camera,
    /// The simulator's ruler.
    Ruler,
    /// A person is asked.
    Ask,
    /// A file to which another program writes the track.
    Track(PathBuf),
    /// No poses are measured.
    NoPoses,
}

impl FromStr for Measure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "camera" => Ok(Measure::Camera),
            "ruler" => Ok(Measure::Ruler),
            "ask" => Ok(Measure::Ask),
            "none" => Ok(Measure::NoPoses),
            _ => match text.strip_prefix("track:") {
                Some(path) if !path.is_empty() => Ok(Measure::Track(path.into())),
                _ => {
                    Err("must be camera, ask, track:FILE, ruler (to calibrate) or none (to record)"
                        .into())
                }
            },
        }
    }
}

/// How a robot is calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The paper's method: a straight run.
    Straight,
    /// Squares both ways.
    Umbmark,
}

impl FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "straight" => Ok(Method::Straight),
            "umbmark" => Ok(Method::Umbmark),
            _ => Err("must be straight or umbmark".into()),
        }
    }
}
