use super::*;
use proptest::prelude::*;

fn close(a: f64, b: f64) -> bool {
    // One rounding in the number and one in the unit.
    (a - b).abs() <= 4.0 * f64::EPSILON * b.abs()
}

#[test]
fn lengths_are_read_in_every_unit_with_or_without_a_space() {
    for (text, m) in [
        ("2.525cm", 0.02525),
        ("1mm", 0.001),
        ("37.2 cm", 0.372),
        ("0.5in", 0.0127),
        ("-3e-2 m", -0.03),
        (" +.5ft ", 0.1524),
        ("1E3um", 0.001),
    ] {
        let length: Length = text.parse().unwrap();
        assert!(close(length.m, m), "{text}: {} instead of {m}", length.m);
    }
}

#[test]
fn a_decimal_length_is_the_nearest_double() {
    // 36 times 0.001 is 0.036000000000000004.
    for (text, m) in [("36mm", 0.036), ("37.2cm", 0.372), ("33 mm", 0.033), ("0.7um", 7e-7)] {
        assert_eq!(text.parse::<Length>().unwrap().m, m, "{text}");
    }
}

#[test]
fn wheel_and_ground_are_kept_apart_and_convert_by_the_radius() {
    let turns: Distance = "8rev".parse().unwrap();
    assert_eq!(turns, Distance::Wheel(8.0 * TAU));
    assert!(close(turns.m(0.036), 8.0 * TAU * 0.036));
    assert!(close("1.8m".parse::<Distance>().unwrap().rev(0.036), 1.8 / 0.036 / TAU));
    assert!(close("0.523rev/s".parse::<Speed>().unwrap().rev_per_s(0.036), 0.523));
    assert!(close("60rpm".parse::<Speed>().unwrap().rev_per_s(0.1), 1.0));
    assert!(close("36km/h".parse::<Speed>().unwrap().mps(0.1), 10.0));
    assert!(close("0.101 rev/s^2".parse::<Acceleration>().unwrap().rev_per_s2(0.036), 0.101));
    assert!(close("50ms".parse::<Time>().unwrap().s, 0.05));
    assert!(close("180deg".parse::<Angle>().unwrap().rad, TAU / 2.0));
}

#[test]
fn a_bare_number_is_refused_with_a_hint() {
    let message = "2.5".parse::<Length>().unwrap_err().to_string();
    assert!(message.contains("`2.5` has no unit") && message.contains("1mm"), "{message}");
}

#[test]
fn an_unknown_unit_is_named_with_its_place_and_the_known_ones() {
    let message = "3 parsec".parse::<Length>().unwrap_err().to_string();
    assert!(message.contains("`parsec` (at character 3"), "{message}");
    assert!(message.contains("mm, um"), "{message}");
    let message = "3m".parse::<Speed>().unwrap_err().to_string();
    assert!(message.contains("`m` (at character 2"), "{message}");
}

#[test]
fn text_infinity_and_overflow_are_refused() {
    for text in ["", "mm", "nan m", "inf m", "1e400m", "1e308km", "1.2.3m", "--1m", "e5m"] {
        assert!(text.parse::<Length>().is_err(), "{text} was accepted");
    }
}

#[test]
fn values_show_the_digits_that_their_sigma_makes_significant() {
    assert_eq!(plus_minus(0.991_858, 0.004_065), "0.9919 ± 0.0041");
    assert_eq!(plus_minus(1.0, 0.0996), "1.00 ± 0.10");
    assert_eq!(plus_minus(1234.5, 120.0), "1234 ± 120");
    assert_eq!(LengthUnit::Cm.format(0.035_706_9, 4), "3.5707 cm");
}

#[test]
fn a_distance_is_printed_as_it_was_typed() {
    for (text, printed) in [
        ("33.3cm", "0.333 m"),
        ("8rev", "8 rev"),
        ("33.3rev", "33.3 rev"),
        ("-1.8096 m", "-1.8096 m"),
    ] {
        assert_eq!(text.parse::<Distance>().unwrap().to_string(), printed);
    }
}

proptest! {
    #[test]
    fn whatever_is_printed_in_millimetres_is_read_back(mm in -1e6_f64..1e6) {
        let length: Length = format!("{mm}mm").parse().unwrap();
        prop_assert!((length.m * 1e3 - mm).abs() <= 1e-12 * mm.abs());
    }

    #[test]
    fn no_text_makes_the_parser_panic(text in ".*") {
        let _ = text.parse::<Length>();
        let _ = text.parse::<Acceleration>();
    }
}
