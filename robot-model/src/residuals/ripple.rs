//! Do the residuals ripple many times per turn of a wheel, as from gear teeth, magnets or slots?
//!
//! Such a ripple moves the track by less than a millimetre for a moment, so no auxiliary effect of a few columns finds it,
//! and there are too many orders to fit each. But every measured heading contains the ripple since the one
//! before, and innovations are independent of each other:
//!
//! ```text
//! z_k = a (cos n phi_k - cos n phi_(k-1)) + b (sin n phi_k - sin n phi_(k-1)) + 1 sigma        (1)
//! gain of a and b: without a ripple chi^2 of two degrees, for each order n and each wheel      (2)
//! ```

use crate::effect::composition::Terms;
use crate::estimation::ekf::{FilterObserver, Innovation, numbers, whiten};
use crate::estimation::fit::Fitted;
use crate::estimation::state::Quantity;
use crate::kinematics::pose::Pose;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::distributions::chi_squared;
use crate::numeric::parallel;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::motion::Step;
use crate::recording::run::PoseMeasurement;

/// Orders tested: auxiliary effects test lower ones, and the turns of a geared motor lie higher.
const ORDERS: std::ops::RangeInclusive<u32> = 4..=64;

/// The innovations of a run's headings, with the angles of the wheels.
struct Headings<'r> {
    run: &'r PreparedRun,
    /// What each number of the pose at hand measures.
    quantities: Vec<Quantity>,
    /// Its innovations, normalised.
    pending: Vec<f64>,
    /// The normalised innovation of each heading, with the angles of the wheels.
    rows: Vec<(f64, WheelPair<f64>)>,
}

impl FilterObserver for Headings<'_> {
    fn row(&mut self, innovation: Innovation, _: &[f64]) {
        self.pending.push(innovation.value / innovation.variance.sqrt());
    }

    /// The filter gives the numbers of a pose first, then the pose.
    fn pose(&mut self, measurement: &PoseMeasurement, _: &Step, _: Pose) {
        self.quantities.clear();
        self.quantities.extend(numbers(measurement).map(|(quantity, ..)| quantity));
        let pairs = self.quantities.iter().zip(&self.pending);
        let heading = pairs.into_iter().find(|(quantity, _)| **quantity == Quantity::Heading);
        if let Some((_, z)) = heading {
            self.rows.push((*z, self.run.recording.phi_at(measurement.t_s)));
        }
        self.pending.clear();
    }
}

/// Probability by chance of a ripple as strong as the strongest one, of all orders and both wheels tested.
pub(crate) fn ripple(prepared: &Prepared, fitted: &Fitted<'_>) -> f64 {
    let fixed = Terms::Fixed(&fitted.terms);
    let runs = parallel::map(&prepared.runs, |run| {
        let (quantities, pending, rows) = (Vec::new(), Vec::new(), Vec::new());
        let mut headings = Headings { run, quantities, pending, rows };
        whiten(&run.motion, &run.recording.measured_poses, fixed, &fitted.noise, &mut headings);
        headings.rows
    });
    let orders: Vec<u32> = ORDERS.collect();
    let strongest = parallel::map(&orders, |order| {
        let order = f64::from(*order);
        gain(&runs, |phi| order * phi.left).max(gain(&runs, |phi| order * phi.right))
    });
    let most = strongest.into_iter().fold(0.0, f64::max);
    (chi_squared(2, most) * (2 * orders.len()) as f64).min(1.0)
}

/// Equation (2).
fn gain(runs: &[Vec<(f64, WheelPair<f64>)>], angle_rad: impl Fn(&WheelPair<f64>) -> f64) -> f64 {
    let (mut cc, mut cs, mut ss, mut zc, mut zs) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for rows in runs {
        let mut before: Option<(f64, f64)> = None;
        for (z, phi) in rows {
            let (sin, cos) = angle_rad(phi).sin_cos();
            if let Some((sin_before, cos_before)) = before {
                let (c, s) = (cos - cos_before, sin - sin_before);
                (cc, cs, ss) = (cc + c * c, cs + c * s, ss + s * s);
                (zc, zs) = (zc + z * c, zs + z * s);
            }
            before = Some((sin, cos));
        }
    }
    let determinant = cc * ss - cs * cs;
    if determinant <= 1e-6 * cc * ss {
        0.0
    } else {
        (zc * zc * ss - 2.0 * zc * zs * cs + zs * zs * cc) / determinant
    }
}
