//! Which axis of a gyro points up: the one whose rates go with those at which the wheels turn the robot.

use robot_model::recording::GyroSample;

use crate::log::WheelLog;

/// Half of the window over which the wheels' turn rate is taken \[s\].
const HALF_WINDOW_S: f64 = 0.1;
/// The axis that is up goes so well with the wheels, at least.
const CORRELATION_MIN: f64 = 0.8;
/// Wheels that never turn the robot faster show no axis: in units of the difference between both angles \[rad/s\].
const TURNS_MIN_RAD_S: f64 = 0.2;

/// The yaw rates of the robot, and what a user should know. The wheels are in radians, without wraps.
pub(crate) fn yaw_rates(wheels: &WheelLog) -> (Vec<GyroSample>, Option<String>) {
    let rates = &wheels.gyro_and_supply.turn_rates;
    if rates.is_empty() {
        return (Vec::new(), None);
    }
    let both: Vec<(f64, [f64; 3])> =
        rates.iter().filter_map(|(t_s, rates)| Some((turn_rate(wheels, *t_s)?, *rates))).collect();
    let fastest = both.iter().map(|(rate, _)| rate.abs()).fold(0.0, f64::max);
    let correlations = [0, 1, 2].map(|axis| correlation(&both, axis));
    let best = (0..3).max_by(|a, b| correlations[*a].abs().total_cmp(&correlations[*b].abs()));
    let (axis, sign, said) = match best {
        _ if fastest < TURNS_MIN_RAD_S => (2, 1.0, None),
        Some(axis) if correlations[axis].abs() > CORRELATION_MIN => {
            let sign = correlations[axis].signum();
            let name = ["x", "y", "z"][axis];
            let way = if sign > 0.0 { "up" } else { "down" };
            let said = format!("the {name} axis of the gyro points {way}: taken for the yaw rate");
            (axis, sign, (axis != 2 || sign < 0.0).then_some(said))
        }
        _ => {
            let said = "no axis of the gyro turns as the wheels do: it was left out";
            return (Vec::new(), Some(said.into()));
        }
    };
    let yaw =
        rates.iter().map(|(t_s, rates)| GyroSample { t_s: *t_s, rate_rad_s: sign * rates[axis] });
    (yaw.collect(), said)
}

/// How fast the right wheel turned against the left one round a time.
fn turn_rate(wheels: &WheelLog, t_s: f64) -> Option<f64> {
    let difference = |t_s: f64| {
        let after = wheels.t_s.partition_point(|own| *own < t_s);
        let before = after.checked_sub(1)?;
        let (from, to) = (wheels.t_s.get(before)?, wheels.t_s.get(after)?);
        let of = |index: usize| wheels.turned[index][1] - wheels.turned[index][0];
        Some(of(before) + (t_s - from) / (to - from) * (of(after) - of(before)))
    };
    Some(
        (difference(t_s + HALF_WINDOW_S)? - difference(t_s - HALF_WINDOW_S)?)
            / (2.0 * HALF_WINDOW_S),
    )
}

/// Of the wheels' rate and an axis.
fn correlation(both: &[(f64, [f64; 3])], axis: usize) -> f64 {
    let count = both.len().max(1) as f64;
    let pairs = || both.iter().map(|(wheels, gyro)| [*wheels, gyro[axis]]);
    let means = [0, 1].map(|of| pairs().map(|pair| pair[of]).sum::<f64>() / count);
    let product = |a: usize, b: usize| -> f64 {
        pairs().map(|pair| (pair[a] - means[a]) * (pair[b] - means[b])).sum()
    };
    let size = (product(0, 0) * product(1, 1)).sqrt();
    if size > 0.0 { product(0, 1) / size } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::GyroAndSupply;

    /// A robot that turns to and fro, with a gyro whose axes see this much of it.
    fn log(axes: [f64; 3]) -> WheelLog {
        let angle = |t_s: f64| 3.0 * (0.8 * t_s).sin();
        let t_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.02).collect();
        let turned = t_s.iter().map(|t_s| [-angle(*t_s), angle(*t_s) + 0.5 * t_s]).collect();
        let rates = (0..400).map(|k| {
            let t_s = 0.5 + f64::from(k) * 0.045;
            let rate = 3.0 * 0.8 * (0.8 * t_s).cos();
            (t_s, axes.map(|share| 0.02 + share * rate + 0.1 * (7.0 * t_s).sin()))
        });
        let gyro_and_supply =
            GyroAndSupply { turn_rates: rates.collect(), ..GyroAndSupply::default() };
        WheelLog { t_s, turned, gyro_and_supply, ..WheelLog::default() }
    }

    #[test]
    fn the_axis_that_turns_with_the_wheels_is_taken_with_its_sign() {
        let (yaw, said) = yaw_rates(&log([0.0, 0.1, 1.0]));
        assert_eq!((yaw.len(), said), (400, None));
        let upright = yaw[0].rate_rad_s;
        let (yaw, said) = yaw_rates(&log([0.0, 0.1, -1.0]));
        assert!(
            (yaw[0].rate_rad_s + 0.02 + 0.1 * 3.5_f64.sin() - upright + 0.02 + 0.1 * 3.5_f64.sin())
                .abs()
                < 1e-9
        );
        assert!(said.unwrap().contains("the z axis of the gyro points down"));
        let (_, said) = yaw_rates(&log([1.0, 0.0, 0.0]));
        assert!(said.unwrap().contains("the x axis of the gyro points up"));
        let (yaw, said) = yaw_rates(&log([0.0; 3]));
        assert!(yaw.is_empty() && said.unwrap().contains("left out"));
    }
}
