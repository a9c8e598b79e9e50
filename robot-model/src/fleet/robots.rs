//! The values of one parameter of one robot: their mean, and whether they change with time.

/// One value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The number of the robot.
    pub robot: usize,
    /// When it was measured \[days\]; `None` if nobody knows.
    pub at_days: Option<f64>,
    /// The value.
    pub value: f64,
    /// Its standard error, above zero.
    pub sigma: f64,
}

/// How the values of a robot change with time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend {
    /// Change a day.
    pub per_day: f64,
    /// Its standard error.
    pub sigma: f64,
    /// Probability of at least as much by chance.
    pub p_value: f64,
    /// It is there: the false discovery rate is below [`super::RATE`].
    pub is_there: bool,
}

/// The straight line through the values of a robot: (1) of the module.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    /// The weighted mean, and its standard error.
    pub mean: f64,
    pub mean_sigma: f64,
    /// The change a day with its standard error, if there are two dates.
    pub slope: Option<(f64, f64)>,
    /// Squared residuals over their variances, and the degrees of freedom.
    pub chi_squared: f64,
    pub freedom: usize,
}

impl Line {
    /// Of the values of one robot. Where one has no date, there is no slope.
    pub fn through(values: &[Measured]) -> Self {
        let weight = |one: &Measured| one.sigma.powi(-2);
        let sum: f64 = values.iter().map(weight).sum();
        let mean = values.iter().map(|one| weight(one) * one.value).sum::<f64>() / sum;
        let dates: Option<Vec<f64>> = values.iter().map(|one| one.at_days).collect();
        let slope = dates.as_deref().and_then(|dates| {
            let pairs = || values.iter().zip(dates);
            let middle = pairs().map(|(one, at)| weight(one) * at).sum::<f64>() / sum;
            let square: f64 = pairs().map(|(one, at)| weight(one) * (at - middle).powi(2)).sum();
            let cross: f64 =
                pairs().map(|(one, at)| weight(one) * (at - middle) * (one.value - mean)).sum();
            (square > 0.0).then(|| (cross / square, square.powf(-0.5), middle))
        });
        let residual = |one: &Measured| {
            let (slope, _, middle) = slope.unwrap_or_default();
            let at = one.at_days.map_or(0.0, |at| at - middle);
            (one.value - mean - slope * at) / one.sigma
        };
        let unknowns = if slope.is_some() { 2 } else { 1 };
        Self {
            mean,
            mean_sigma: sum.powf(-0.5),
            slope: slope.map(|(slope, sigma, _)| (slope, sigma)),
            chi_squared: values.iter().map(|one| residual(one).powi(2)).sum(),
            freedom: values.len().saturating_sub(unknowns),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(day: f64, value: f64, sigma: f64) -> Measured {
        Measured { robot: 0, at_days: Some(day), value, sigma }
    }

    #[test]
    fn a_line_through_its_points_has_no_residuals() {
        let line = Line::through(&[at(0.0, 1.0, 0.1), at(10.0, 3.0, 0.1), at(20.0, 5.0, 0.1)]);
        let (slope, sigma) = line.slope.unwrap();
        assert!((slope - 0.2).abs() < 1e-12 && (line.mean - 3.0).abs() < 1e-12);
        // 0.1 / sqrt(10^2 + 10^2).
        assert!((sigma - 0.1 / 200.0_f64.sqrt()).abs() < 1e-12);
        assert!(line.chi_squared < 1e-20 && line.freedom == 1);
    }

    #[test]
    fn without_dates_there_is_a_mean_and_no_slope() {
        let undated = Measured { at_days: None, ..at(0.0, 1.0, 0.1) };
        let line = Line::through(&[undated, Measured { value: 2.0, sigma: 0.2, ..undated }]);
        assert!(line.slope.is_none() && line.freedom == 1);
        // Weights 100 and 25.
        assert!((line.mean - 1.2).abs() < 1e-12);
        let same_day = Line::through(&[at(3.0, 1.0, 0.1), at(3.0, 2.0, 0.1)]);
        assert!(same_day.slope.is_none());
    }
}
