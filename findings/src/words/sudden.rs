//! What happened at once in a run, in words.

use robot_model::residuals::SuddenMotion;

/// A wheel that went this share as far as the other, or less, went as far as it says.
const STANDS: f64 = 0.25;

/// A turn of fewer sigma is none.
const TURNED_SIGMAS: f64 = 3.0;

/// When the robot moved as its wheels did not, by how much, and what that may be; a whole sentence.
pub fn sudden_motion(found: &SuddenMotion) -> String {
    let SuddenMotion { run, from_s, to_s, turn_rad, turn_sigma_rad, .. } = found;
    let [left_m, right_m] = &found.wheels_m;
    let when = format!("{run}, {from_s:.1} to {to_s:.1} s");
    let far = |way_m: f64| {
        let less = if way_m < 0.0 { "less far" } else { "further" };
        format!("{:.0} mm {less} ahead", 1e3 * way_m.abs())
    };
    if turn_rad.abs() < TURNED_SIGMAS * turn_sigma_rad {
        return format!(
            "{when}: the robot came {} than its wheels say: they slipped, counts are wrong, the robot was pushed, or its poses \
             are late from then on.",
            far(f64::midpoint(*left_m, *right_m))
        );
    }
    let turned = format!(
        "{when}: the robot turned by {:.1} degrees more to the {} than its wheels say",
        turn_rad.abs().to_degrees(),
        if *turn_rad > 0.0 { "left" } else { "right" }
    );
    let one = |wheel: &str, way_m: f64| {
        format!(
            "{turned}, as if its {wheel} wheel had come {}: the wheel slipped, its counts are wrong, the robot was pushed, or its \
             poses are late from then on.",
            far(way_m)
        )
    };
    if right_m.abs() < STANDS * left_m.abs() {
        one("left", *left_m)
    } else if left_m.abs() < STANDS * right_m.abs() {
        one("right", *right_m)
    } else {
        format!(
            "{turned}, and came {}: wheels slipped, counts are wrong, the robot was pushed, or its poses are late from then on.",
            far(f64::midpoint(*left_m, *right_m))
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_is_named_where_the_other_went_as_far_as_it_says() {
        let of = |turn_rad: f64, wheels_m: [f64; 2]| {
            let run = "04_free".to_owned();
            let (from_s, to_s, turn_sigma_rad) = (10.0, 10.3, 1e-3);
            sudden_motion(&SuddenMotion { run, from_s, to_s, turn_rad, turn_sigma_rad, wheels_m })
        };
        assert_eq!(
            of(0.17, [-0.027, 0.001]),
            "04_free, 10.0 to 10.3 s: the robot turned by 9.7 degrees more to the left than its wheels say, as if its left wheel \
             had come 27 mm less far ahead: the wheel slipped, its counts are wrong, the robot was pushed, or its poses are late \
             from then on."
        );
        let right = of(-0.17, [0.0, -0.02]);
        assert!(
            right.contains("more to the right than its wheels say, as if its right wheel"),
            "{right}"
        );
        assert!(of(0.5, [-0.05, 0.02]).contains("and came 15 mm less far ahead: wheels slipped"));
        assert!(
            of(1e-3, [0.02, 0.02]).contains("the robot came 20 mm further ahead than its wheels")
        );
    }
}
