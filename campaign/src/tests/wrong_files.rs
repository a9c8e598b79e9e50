//! Each way in which the files of a campaign can be wrong, and what is said of it.

use std::path::Path;

use super::{CSV, TOML, error};
use crate::Campaign;

#[test]
fn every_way_to_be_wrong_has_its_place_and_a_hint() {
    #[rustfmt::skip]
    let cases = [
        (error("name = \"r\"\nwheel_radius_m = x\n", None), "robot.toml, line 2, column 18: "),
        (error("name = \"r\"\n", None), "missing field `wheel_radius_m`"),
        (error(&TOML.replace("900", "-1"), Some(CSV)), "robot.toml, line 4, column 1: counts_per_rev = -1 is invalid; it must"),
        (error(&TOML.replace("0.036", "nan"), Some(CSV)), "line 2, column 1: wheel_radius_m = NaN is invalid"),
        (error(&TOML.replace("0.372", "\"b\""), Some(CSV)), "line 3, column 17: invalid type: string"),
        (error(&format!("{TOML}wheels = 3\n"), Some(CSV)), "line 5, column 1: unknown field `wheels`"),
        (error(&format!("{TOML}[[run]]\nname = \"07_b\"\n"), Some(CSV)), "robot.toml, line 6, column 8: the run `07_b` does not exist; add the file runs/07_b.csv"),
        (error(&format!("{TOML}[[run]]\nname = \"01_a\"\npayload_kg = 1\n\n[[run]]\nname = \"02_a\"\npayload_kg = -1\n"), Some(CSV)), "line 11, column 1: payload_kg = -1 is invalid"),
        (error(&format!("{TOML}[[run]]\nname = \"01_a\"\npayload_kg = 1\n\n[[run]]\nname = \"01_a\"\nstarted_s = 1\n"), Some(CSV)), "robot.toml, line 10, column 1: there are two [[run]] named `01_a`; merge them into one"),
        (error(TOML, None), "ROBOT: this campaign has no runs; put"),
        (error(TOML, Some("")), "01_a.csv: the file is empty; the first line must name"),
        (error(TOML, Some("t_s,left_counts\n0,0\n1,1\n")), "01_a.csv, line 1: the required column `right_counts` is missing"),
        (error(TOML, Some(&CSV.replace("5,5", "5,five"))), "01_a.csv, line 3, column 3: `five` is not a number; leave"),
        (error(TOML, Some(&CSV.replace("5,5", "inf,5"))), "line 3, column 2: `inf` is not a finite number"),
        (error(TOML, Some(&CSV.replace("5,5", "NaN,5"))), "line 3, column 2: `NaN` is not a finite number"),
        (error(TOML, Some(&CSV.replace("1,5", "0,5"))), "line 3, column 1: the time 0 s is not later than the 0 s before it; sort"),
        (error(TOML, Some(&CSV.replace("1,5", ",5"))), "line 3, column 1: the time is missing"),
        (error(TOML, Some(&CSV.replace("5,5", "5"))), "line 3: 2 cells, but the header has 3"),
        (error(TOML, Some("t_s,left_counts,right_counts\n0,0,0\n")), "a run needs at least two rows, this one has 1"),
        (error(TOML, Some(&CSV.replace(',', ";"))), "01_a.csv, line 1: its columns are separated by semicolons; put commas"),
        (error(TOML, Some("t_s;left_counts;right_counts\n0,5;0;0\n1,5;5;5\n")), "01_a.csv, line 1: its columns are separated by semicolons; put commas in their place, and a point into each number"),
        (error(TOML, Some(&CSV.replace(',', "\t"))), "01_a.csv, line 1: its columns are separated by tabs; put commas"),
        (error(TOML, Some("t_s,left_counts,right_counts,x_m\n0,0,0,0\n1,5,5,0\n")), "01_a.csv, line 1, column 4: there is x_m without y_m; a position"),
        (error(TOML, Some("t_s,y_m,left_counts,right_counts\n0,0,0,0\n1,0,5,5\n")), "01_a.csv, line 1, column 2: there is y_m without x_m; a position"),
        (error(TOML, Some("t_s,left_counts,right_counts,x_m,y_m\n0,0,0,0,0\n1,5,5,,0\n")), "01_a.csv, line 3, column 5: there is y_m without x_m; a position"),
        (error(TOML, Some("t_s,left_counts,right_counts,x_m,y_m\n0,0,0,0,0\n1,5,5,1.79e308,0\n")), "01_a.csv, line 3, column 4: x_m = 1.79e308 is out of range; it must be from -1e8 to 1e8 m"),
        (error(TOML, Some(&CSV.replace("5,5", "5,1e17"))), "line 3, column 3: right_counts = 1e17 is out of range; it must be from -9.007199254740992e15 to"),
        (error(&TOML.replace("0.036", "1e160"), Some(CSV)), "line 2, column 1: wheel_radius_m = 1e160 is invalid; it must be from 1e-6 to 1e6 m"),
        (error(&format!("{TOML}position_sigma_m = 1.0\n"), Some(CSV)), "line 5, column 1: position_sigma_m = 1 is invalid; it must be from 1e-7 to 0.5 m"),
        (error(&format!("{TOML}[[run]]\nname = \"01_a\"\nstarted_s = 1e300\n"), Some(CSV)), "line 7, column 1: started_s = 1e300 is invalid; it must be from -1e11 to 1e11 s"),
        (error(TOML, Some("t_s,t_s,left_counts,right_counts\n")), "line 1, column 2: the column `t_s` appears twice"),
    ];
    for (error, expected) in cases {
        assert!(error.contains(expected), "{error}\n  does not say: {expected}");
        assert!(error.contains("; "), "no hint: {error}");
    }
    let nowhere = Campaign::read(Path::new("/nowhere/at/all")).unwrap_err().to_string();
    assert!(nowhere.contains("robot.toml: there is no such file"), "{nowhere}");
}
