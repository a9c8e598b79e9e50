//! Fitted values in the units that are easiest to read: a ratio in percent, a length in
//! millimetres, an angle in mrad.

use super::plus_minus;
use super::print::DECIMALS_MAX;

/// The factor and the unit in which a value of this size is easiest to read.
pub fn scaled_unit(size: f64, unit: &str) -> (f64, String) {
    let milli = |name: &str| (1e3, name.to_owned());
    match unit {
        "1" if size < 1.0 => (100.0, "%".into()),
        "1" => (1.0, String::new()),
        _ if size >= 0.5 => (1.0, unit.to_owned()),
        "m" => milli("mm"),
        "rad" => milli("mrad"),
        "s" => milli("ms"),
        "rad/m" => milli("mrad/m"),
        "rad/s" => milli("mrad/s"),
        other => (1.0, other.to_owned()),
    }
}

/// `0.84 ± 0.02 %`.
pub fn value_with_sigma(value: f64, sigma: f64, unit: &str) -> String {
    let (factor, name) = scaled_unit(value.abs().max(sigma), unit);
    format!("{} {name}", plus_minus(value * factor, sigma * factor)).trim_end().to_owned()
}

/// An exact value, with the digits of another one that has this sigma: `0.83 %`.
pub fn value_in_unit(value: f64, sigma: f64, unit: &str) -> String {
    let (factor, name) = scaled_unit(value.abs().max(sigma), unit);
    let decimals = super::decimals(sigma * factor);
    format!("{:.decimals$} {name}", value * factor).trim_end().to_owned()
}

/// The 95 % interval of such a value: `0.80 to 0.88 %`.
pub fn interval_in_unit(value: f64, sigma: f64, (low, high): (f64, f64), unit: &str) -> String {
    let (factor, name) = scaled_unit(value.abs().max(sigma), unit);
    let decimals = super::decimals(sigma * factor);
    let (low, high) = (low * factor, high * factor);
    let text = match decimals {
        0..=DECIMALS_MAX => format!("{low:.decimals$} to {high:.decimals$} {name}"),
        _ => format!("{low:.2e} to {high:.2e} {name}"),
    };
    text.trim_end().to_owned()
}

/// A probability: `0.03`, `0.002`, `2e-7`, never a row of zeros.
pub fn probability(p: f64) -> String {
    match p {
        p if p >= 0.0095 => format!("{p:.2}"),
        p if p >= 0.000_95 => format!("{p:.3}"),
        p if p > 1e-99 => format!("{p:.0e}"),
        _ => "< 1e-99".into(),
    }
}

/// A probability with its name: `p = 0.03`, `p < 1e-99`.
pub fn p_value(p: f64) -> String {
    match probability(p).strip_prefix("< ") {
        Some(less) => format!("p < {less}"),
        None => format!("p = {}", probability(p)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_the_unit_that_is_easiest_to_read() {
        assert_eq!(value_with_sigma(0.0084, 0.0002, "1"), "0.840 ± 0.020 %");
        assert_eq!(value_with_sigma(0.021, 0.001, "s"), "21.0 ± 1.0 ms");
        assert_eq!(value_with_sigma(1.546, 0.26, "rad/s"), "1.55 ± 0.26 rad/s");
        assert_eq!(value_with_sigma(-0.25, 0.07, "s^2/m"), "-0.250 ± 0.070 s^2/m");
        assert_eq!(interval_in_unit(0.0084, 0.0002, (0.008, 0.0088), "1"), "0.800 to 0.880 %");
        assert_eq!(value_with_sigma(2e-19, 1.5e-19, "m/s^2"), "2.00e-19 ± 1.50e-19 m/s^2");
        let (low, high) = (-1e-19, 5e-19);
        assert_eq!(
            interval_in_unit(2e-19, 1.5e-19, (low, high), "1/s"),
            "-1.00e-19 to 5.00e-19 1/s"
        );
    }

    #[test]
    fn a_probability_is_never_a_row_of_zeros() {
        assert_eq!(probability(0.031), "0.03");
        assert_eq!(probability(0.0024), "0.002");
        assert_eq!(probability(2.4e-7), "2e-7");
        assert_eq!(probability(0.0), "< 1e-99");
        assert_eq!((p_value(0.0), p_value(0.031)), ("p < 1e-99".into(), "p = 0.03".into()));
    }
}
