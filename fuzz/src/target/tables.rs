//! Tables that other programs write: tracks and gyro logs.

use std::fmt::Write as _;
use std::path::Path;

use campaign::track::parse_track;
use host_cli::pose_source::gyro_log;

use crate::bytes::text;

/// A track file.
pub fn track(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let file = Path::new("track.csv");
    let Ok((samples, _)) = parse_track(file, text) else { return };
    assert!(samples.len() >= 2);
    assert!(samples.windows(2).all(|pair| pair[0].t_s < pair[1].t_s), "times increase");
    let mut written = String::from("t_s,x_m,y_m,heading_rad\n");
    for sample in &samples {
        let numbers = [sample.t_s, sample.x_m, sample.y_m, sample.heading_rad.unwrap_or(0.0)];
        assert!(numbers.iter().all(|number| number.is_finite()), "{sample:?}");
        let heading = sample.heading_rad.map_or_else(String::new, |heading| format!("{heading:?}"));
        let _ = writeln!(written, "{:?},{:?},{:?},{heading}", sample.t_s, sample.x_m, sample.y_m);
    }
    let (again, _) = parse_track(file, &written).unwrap_or_else(|e| panic!("{e}\n{written}"));
    assert_eq!(samples, again);
}

/// A gyro's log, as far as it has come.
pub fn gyro(input: &[u8]) {
    let Some(text) = text(input) else { return };
    // Only whole lines are read.
    let whole = text.rfind('\n').map_or("", |last| &text[..=last]);
    let Ok((readings, _)) = gyro_log::parse(Path::new("gyro.csv"), whole.to_owned()) else {
        return;
    };
    assert!(readings.iter().all(|(t_s, rate)| t_s.is_finite() && rate.is_finite()));
    assert!(readings.windows(2).all(|pair| pair[0].0 < pair[1].0), "times increase");
}
