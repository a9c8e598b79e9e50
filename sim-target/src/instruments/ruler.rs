//! A ruler, laid from the start line to the robot, or along the robot's trace.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::plant::{ParameterError, Pose, RangeCheck};

/// How good the ruler and its reader are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RulerParameters {
    /// Distance between the marks that are told apart, q \[m\].
    pub resolution_m: f64,
    /// How far the reader is off before rounding to a mark, standard deviation \[m\].
    pub reading_sigma_m: f64,
}

impl Default for RulerParameters {
    /// Millimetre marks, read to half a millimetre.
    fn default() -> Self {
        Self { resolution_m: 0.0005, reading_sigma_m: 0.0003 }
    }
}

impl RulerParameters {
    /// Refuses a value outside its range, and names the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("");
        check.within("resolution_m", self.resolution_m, 0.0, 0.1)?;
        check.within("reading_sigma_m", self.reading_sigma_m, 0.0, 0.1)
    }

    /// Standard deviation of one reading, \[m\]: the reader's, and q/sqrt(12) for the rounding.
    pub fn sigma_m(&self) -> f64 {
        (self.resolution_m * self.resolution_m / 12.0 + self.reading_sigma_m * self.reading_sigma_m)
            .sqrt()
    }
}

/// Where the robot ended, relative to the start line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndReading {
    /// Along the line \[m\].
    pub forward_m: f64,
    /// To its left \[m\].
    pub left_m: f64,
}

/// The trace's tangent at the end, as a right triangle: the paper's dx and dy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentReading {
    /// Base, along the start line \[m\].
    pub dx_m: f64,
    /// Height, left positive \[m\]; the paper's dy_A is positive to the right.
    pub dy_m: f64,
}

/// A ruler and its reader.
#[derive(Clone, Debug)]
pub struct Ruler {
    parameters: RulerParameters,
    rng: ChaCha8Rng,
}

impl Ruler {
    /// A ruler; the seed draws the reader's errors.
    pub fn new(parameters: RulerParameters, seed: u64) -> Self {
        Self { parameters, rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// Reads the robot's distance along a start line and across.
    pub fn read(&mut self, line: Pose, end: Pose) -> EndReading {
        let end = end.relative_to(line);
        EndReading { forward_m: self.mark(end.x_m), left_m: self.mark(end.y_m) }
    }

    /// Reads the triangle under the trace's tangent at the end, over a base of about `base_m`:
    /// dy = dx tan(heading), each of the two read for itself.
    ///
    /// The heading must be within a quarter turn of the line.
    pub fn tangent(&mut self, line: Pose, end: Pose, base_m: f64) -> TangentReading {
        TangentReading {
            dx_m: self.mark(base_m),
            dy_m: self.mark(base_m * end.relative_to(line).heading_rad.tan()),
        }
    }

    /// The ruler's parameters.
    pub fn parameters(&self) -> &RulerParameters {
        &self.parameters
    }

    fn mark(&mut self, true_m: f64) -> f64 {
        let error: f64 = StandardNormal.sample(&mut self.rng);
        let seen_m = true_m + self.parameters.reading_sigma_m * error;
        let mark_m = self.parameters.resolution_m;
        if mark_m > 0.0 { (seen_m / mark_m).round() * mark_m } else { seen_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: Pose = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
    const END: Pose = Pose { x_m: 1.80912, y_m: -0.03583, heading_rad: -0.0396 };

    #[test]
    fn readings_stand_on_marks() {
        let mut ruler = Ruler::new(RulerParameters::default(), 3);
        for _ in 0..100 {
            let EndReading { forward_m, left_m } = ruler.read(LINE, END);
            let TangentReading { dx_m, dy_m } = ruler.tangent(LINE, END, 0.02525);
            for reading_m in [forward_m, left_m, dx_m, dy_m] {
                let marks = reading_m / 0.0005;
                assert!((marks - marks.round()).abs() < 1e-6, "{reading_m} is between two marks");
            }
        }
    }

    #[test]
    fn the_spread_of_readings_is_the_declared_sigma() {
        let mut ruler = Ruler::new(RulerParameters::default(), 5);
        let n = 20_000;
        // Spread over a mark's width: sigma_m() assumes a uniform rounding error.
        let square: f64 = (0..n)
            .map(|i| {
                let y_m = -0.03 + 0.0005 * f64::from(i) / 137.0;
                (ruler.read(LINE, Pose { y_m, ..END }).left_m - y_m).powi(2)
            })
            .sum();
        let rms_m = (square / f64::from(n)).sqrt();
        // 0.5 % of sampling error at n = 20000; 4 of these.
        assert!((rms_m / ruler.parameters().sigma_m() - 1.0).abs() < 0.02, "{rms_m}");
    }

    #[test]
    fn an_exact_ruler_reads_the_papers_triangle() {
        let exact = RulerParameters { resolution_m: 0.0, reading_sigma_m: 0.0 };
        let triangle = Ruler::new(exact, 1).tangent(LINE, END, 0.02525);
        assert_eq!(triangle.dx_m, 0.02525);
        // The paper: dx = 2.525 cm, dy = 1 mm to the right, for 0.0396 rad, given to three digits.
        assert!((triangle.dy_m + 0.001).abs() < 1e-6, "{}", triangle.dy_m);
    }
}
