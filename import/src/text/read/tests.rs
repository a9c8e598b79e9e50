//! Tables as people have them, and tables that are no tables.

use super::*;
use crate::text::parse_mappings;

fn parsed(text: &str, map: &str) -> Result<TextLogs, CampaignError> {
    let mappings = if map.is_empty() { Vec::new() } else { parse_mappings(map).unwrap() };
    parse(Path::new("log.csv"), text.as_bytes(), &mappings)
}

#[test]
fn a_tum_trajectory_has_poses_with_comments_and_without() {
    let rows = "1732473042.5 1 2 0 0 0 0.6 0.8\n1732473042.6 1.5 2 0 0 0 0.6 0.8\n";
    for comment in ["", "# timestamp tx ty tz qx qy qz qw\n"] {
        let logs = parsed(&format!("{comment}{rows}"), "").unwrap();
        let poses = logs.poses.unwrap().poses;
        assert_eq!(poses.len(), 2);
        assert_eq!(poses[1].position_m, [1.5, 2.0, 0.0]);
        assert_eq!(poses[0].orientation, Some([0.0, 0.0, 0.6, 0.8]));
        assert!((poses[0].t_s - 1_732_473_042.5).abs() < 1e-6);
        assert_eq!(logs.wheels, None);
    }
}

#[test]
fn a_euroc_file_has_its_header_in_a_comment_and_nanoseconds() {
    let text = "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n\
                1403636580838555648,1,2,0,1,0,0,0\n1403636580938555648,1,2,0,1,0,0,0\n";
    let poses = parsed(text, "").unwrap().poses.unwrap().poses;
    assert!((poses[1].t_s - poses[0].t_s - 0.1).abs() < 1e-6);
    assert_eq!(poses[0].orientation, Some([0.0, 0.0, 0.0, 1.0]));
}

#[test]
fn columns_of_any_names_are_mapped_with_their_units() {
    let text = "stamp;enc_a;enc_b;px;py;course\n1000000000;5;7;100;200;90\n1100000000;6;8;;;\n1200000000;7;9;110;200;91\n";
    let map = "t_s=stamp:ns,left_counts=enc_a,right_counts=enc_b,x_m=px:mm,y_m=py:mm,heading_rad=course:deg";
    let logs = parsed(text, map).unwrap();
    let (wheels, poses) = (logs.wheels.unwrap(), logs.poses.unwrap().poses);
    assert_eq!(wheels.turned, [[5.0, 7.0], [6.0, 8.0], [7.0, 9.0]]);
    assert!((wheels.t_s[1] - 1.1).abs() < 1e-9);
    assert_eq!(poses.len(), 2, "a row without a position has no pose");
    assert!((poses[0].position_m[1] - 0.2).abs() < 1e-12);
    let [.., sin, cos] = poses[0].orientation.unwrap();
    assert!((2.0 * sin.atan2(cos) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn what_is_no_table_is_one_error_with_its_place_and_what_to_do() {
    for (text, says) in [
        ("", "the file is empty"),
        ("1 2 3\n4 5 6\n", "no header line that names its 3 columns"),
        (
            "a,b\n1,2\n",
            "line 1: no column is known to be the time; name the column of the time: --map t_s=COLUMN:UNIT; its columns are a, b",
        ),
        ("t_s,b\n1,2\n", "line 1: no columns are known to be wheels or positions"),
        (
            "t_s,x,y\n0,1,2\n1,two,3\n2,1,1\n",
            "line 3, column 2: `two` in the column `x` is not a number",
        ),
        ("t_s,x,y\n0,1\n1,1,1\n", "line 2: 2 cells, but there are 3 columns"),
        (
            "t,x,y\n0,1,1\n10000,1,1\n20000,1,1\n",
            "would be 10000 s apart; give their unit: --map t_s=t:ms",
        ),
        ("t_s,x,y\n", "fewer than two rows have a time"),
    ] {
        let error = parsed(text, "").unwrap_err().to_string();
        assert!(error.starts_with("log.csv") && error.contains(says), "{text:?}: {error}");
    }
    let error = parse(Path::new("log.csv"), &[0xff, 0xfe, 0], &[]).unwrap_err().to_string();
    assert!(error.contains("not UTF-8"), "{error}");
}

#[test]
fn a_file_that_ends_in_the_middle_of_a_line_is_read_up_to_there() {
    let logs = parsed("t_s,x,y\n0,1,2\n1,1,3\n2,1", "").unwrap();
    assert_eq!(logs.poses.unwrap().poses.len(), 2);
    assert!(logs.notes[0].text.contains("the last line is cut off"), "{:?}", logs.notes);
}

#[test]
fn two_columns_for_one_quantity_are_an_error_unless_one_is_named() {
    let text = "t_s,left_rad,right_rad,left_rad\n0,1,2,3\n1,2,3,4\n";
    let error = parsed(text, "").unwrap_err().to_string();
    assert!(
        error.contains(
            "both columns `left_rad` and `left_rad` may be left_rad; give them different names"
        ),
        "{error}"
    );
    let text = "time,stamp,left_rad,right_rad\n5,0,2,3\n6,1,3,4\n";
    let error = parsed(text, "").unwrap_err().to_string();
    assert!(error.contains("name the one that is: --map t_s=time"), "{error}");
    assert_eq!(parsed(text, "t_s=stamp").unwrap().wheels.unwrap().t_s, [0.0, 1.0]);
}

#[test]
fn decimals_may_have_commas_where_semicolons_separate() {
    let text = "t_s;left_rad;right_rad\n0,0;1,5;-2\n0,5;1,75;-2,25\n";
    let wheels = parsed(text, "").unwrap().wheels.unwrap();
    assert_eq!((wheels.t_s, wheels.turned), (vec![0.0, 0.5], vec![[1.5, -2.0], [1.75, -2.25]]));
}

#[test]
fn headings_in_degrees_are_converted_and_what_may_be_either_is_asked() {
    let table = |heading: &dyn Fn(f64) -> f64| {
        let row = |k: u32| {
            let rad = 0.04 * f64::from(k);
            format!("{k},{},{},{}\n", 0.5 * rad.sin(), -0.5 * rad.cos(), heading(rad))
        };
        format!("t_s,x_m,y_m,yaw\n{}", (0..471).map(row).collect::<String>())
    };
    let logs = parsed(&table(&|rad| rad.to_degrees() % 360.0), "").unwrap();
    assert_eq!(logs.notes[0].text, "the headings in `yaw` are degrees: converted");
    let last = logs.poses.unwrap().poses[470].orientation.unwrap();
    let expected_rad = 0.04 * 470.0 % std::f64::consts::TAU;
    assert!((2.0 * last[2].atan2(last[3]) - expected_rad).abs() < 1e-9);
    let error = parsed(&table(&|_| 90.0), "").unwrap_err().to_string();
    assert!(error.contains("give their unit: --map heading_rad=yaw:deg, or rad"), "{error}");
    assert!(parsed(&table(&|_| 90.0), "heading_rad=yaw:deg").is_ok());
}

#[test]
fn poses_that_stand_until_the_next_are_taken_once() {
    let row = |k: u32| {
        let held = f64::from(k / 4 * 4);
        format!("{},{k},{k},{},{}\n", f64::from(k) * 0.01, 1e-5 * held * held, 2e-4 * held)
    };
    let text = format!("t_s,left_rad,right_rad,x_m,y_m\n{}", (0..400).map(row).collect::<String>());
    let logs = parsed(&text, "").unwrap();
    assert_eq!(logs.poses.unwrap().poses.len(), 100);
    assert!(logs.notes[0].text.contains("the first of each is taken"), "{:?}", logs.notes);
}

/// Rows at these times, each with the name of its run.
fn rows(runs: &[(&str, &[f64])]) -> String {
    let mut text = "run,t_s,left_rad,right_rad,x_m,y_m\n".to_owned();
    for (name, times) in runs {
        text.extend(times.iter().map(|t_s| format!("{name},{t_s},{t_s},{t_s},{t_s},0\n")));
    }
    text
}

#[test]
fn runs_whose_time_begins_again_are_put_one_after_another_and_never_mixed() {
    let text = rows(&[("a", &[0.0, 1.0, 20.0]), ("b", &[0.0, 1.0, 9.0]), ("c", &[0.5, 2.0])]);
    let logs = parsed(&text, "").unwrap();
    let wheels = logs.wheels.unwrap();
    assert_eq!(wheels.t_s, [0.0, 1.0, 20.0, 30.0, 31.0, 39.0, 49.0, 50.5]);
    assert_eq!(logs.poses.unwrap().poses.len(), 8);
    assert!(logs.has_own_time);
    let [note] = logs.notes.as_slice() else { panic!("{:?}", logs.notes) };
    assert!(note.to_string().contains("each of 3 runs"), "{note}");
    // One clock for all runs stays as it is.
    let text = rows(&[("a", &[0.0, 1.0, 20.0]), ("b", &[25.0, 26.0])]);
    let logs = parsed(&text, "").unwrap();
    assert_eq!(logs.wheels.unwrap().t_s, [0.0, 1.0, 20.0, 25.0, 26.0]);
    assert!(!logs.has_own_time);
}

#[test]
fn a_table_of_two_recordings_without_their_names_is_refused_where_the_second_begins() {
    let text = rows(&[("a", &[0.0, 1.0, 19.0, 20.0]), ("b", &[0.0, 1.0])]).replace("run,", "lap,");
    let refused = parsed(&text, "").unwrap_err().to_string();
    assert!(refused.contains("time begins again: 0 s come after 20 s"), "{refused}");
    assert!(refused.contains("line 6"), "{refused}");
    // A single wrong time is no recording.
    let text = rows(&[("a", &[0.0, 1.0, 1e6, 2.0, 3.0, 4.0])]).replace("run,", "lap,");
    assert_eq!(parsed(&text, "").unwrap().wheels.unwrap().t_s.len(), 6);
}
