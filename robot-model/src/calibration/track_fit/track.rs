//! What was measured? The track, and the wheel angles of the same run.

use super::error::TrackFitError;
use super::scatter::scatter;
use crate::kinematics::geometry::Geometry;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::angle::wrap;

/// One measurement of where the robot was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackSample {
    /// When \[s\], on the clock of the wheel angles.
    pub t_s: f64,
    /// Measured x in a fixed frame \[m\].
    pub x_m: f64,
    /// Measured y in a fixed frame \[m\].
    pub y_m: f64,
    /// Measured heading \[rad\], wrapped or not, if there is one.
    pub heading_rad: Option<f64>,
}

/// A measured track.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// In order of time.
    pub samples: Vec<TrackSample>,
    /// Noise of x and of y, one sigma \[m\].
    pub position_sigma_m: f64,
    /// Noise of the heading, one sigma \[rad\]; ignored if no sample has a heading.
    pub heading_sigma_rad: f64,
}

impl Track {
    /// A track. Noise that is not stated is estimated from the scatter of the samples.
    ///
    /// The estimate: second differences x(i) - 2 x(i+1) + x(i+2), which a smooth motion leaves near
    /// zero, have sqrt(6) times the noise of a sample.
    pub fn new(
        samples: Vec<TrackSample>,
        position_sigma_m: Option<f64>,
        heading_sigma_rad: Option<f64>,
    ) -> Self {
        let position_sigma_m = position_sigma_m.unwrap_or_else(|| {
            let axis = |read: fn(&TrackSample) -> f64| samples.iter().map(read).collect::<Vec<_>>();
            scatter(&axis(|sample| sample.x_m)).hypot(scatter(&axis(|sample| sample.y_m)))
                / 2_f64.sqrt()
        });
        let heading_sigma_rad = heading_sigma_rad.unwrap_or_else(|| {
            let mut headings: Vec<_> =
                samples.iter().filter_map(|sample| sample.heading_rad).collect();
            for i in 1..headings.len() {
                headings[i] = headings[i - 1] + wrap(headings[i] - headings[i - 1]);
            }
            scatter(&headings)
        });
        Self {
            samples,
            // Only a computed track has no noise; a micrometre keeps it solvable.
            position_sigma_m: position_sigma_m.max(1e-6),
            heading_sigma_rad: heading_sigma_rad.max(1e-6),
        }
    }
}

/// Cumulative wheel angles at one time, from any start value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelAngles {
    /// When \[s\].
    pub t_s: f64,
    /// How far the wheels have turned.
    pub turns: WheelPair<f64>,
}

/// Refuses data that no fit can use.
pub(super) fn validate(
    track: &Track,
    angles: &[WheelAngles],
    geometry: &Geometry,
) -> Result<(), TrackFitError> {
    geometry.validate()?;
    for (name, value) in [
        ("the noise of the position", track.position_sigma_m),
        ("the noise of the heading", track.heading_sigma_rad),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(TrackFitError::BadNumber { name, value });
        }
    }
    let samples = track.samples.iter().flat_map(|sample| {
        let heading_rad = sample.heading_rad.unwrap_or(0.0);
        [("time", sample.t_s), ("x", sample.x_m), ("y", sample.y_m), ("heading", heading_rad)]
    });
    let wheels = angles.iter().flat_map(|angle| {
        [("time", angle.t_s), ("wheel angle", angle.turns.left + angle.turns.right)]
    });
    for (name, value) in samples.chain(wheels) {
        if !value.is_finite() {
            return Err(TrackFitError::BadNumber { name, value });
        }
    }
    if let Some(pair) = track.samples.windows(2).find(|pair| pair[1].t_s <= pair[0].t_s) {
        return Err(TrackFitError::TimeNotIncreasing { name: "track", t_s: pair[1].t_s });
    }
    if let Some(pair) = angles.windows(2).find(|pair| pair[1].t_s <= pair[0].t_s) {
        return Err(TrackFitError::TimeNotIncreasing { name: "wheel angles", t_s: pair[1].t_s });
    }
    match angles.len() {
        0 | 1 => Err(TrackFitError::NoTravel),
        _ => Ok(()),
    }
}
