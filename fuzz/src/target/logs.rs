//! Logs of other programs, as `beeline import` reads them.

use std::path::Path;

use import::controller_file;
use import::geometry::Geometry;
use import::source::{Choice, Chosen, Sources};
use import::understand::{Hints, understand};
use import::{text, wpilog};

use crate::bytes::text as as_text;

/// A bag, all the way to a campaign.
pub fn bag(input: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("drive.mcap");
    std::fs::write(&file, input).expect("there is room");
    let Ok(sources) = Sources::open(std::slice::from_ref(&file), &[]) else { return };
    let nominal = Geometry::nominal(0.036, 0.372);
    let odometry = sources.offers().into_iter().find_map(|offer| {
        let topic = offer.option?.strip_prefix("--odometry ")?.to_owned();
        Some((topic, nominal))
    });
    for odometry in [None, odometry] {
        let choice = Choice { odometry, ..Choice::default() };
        let Ok(chosen) = sources.choose(&choice) else { continue };
        sound(&chosen);
        understood(chosen, &nominal, &folder.path().join("my-robot"));
    }
}

/// Times increase and numbers are finite.
fn sound(chosen: &Chosen) {
    let (wheels, poses) = (&chosen.wheels, &chosen.poses.poses);
    assert_eq!(wheels.t_s.len(), wheels.turned.len());
    assert!(wheels.t_s.windows(2).all(|pair| pair[0] < pair[1]), "times increase");
    assert!(wheels.turned.iter().flatten().all(|number| number.is_finite()));
    assert!(poses.windows(2).all(|pair| pair[0].t_s < pair[1].t_s), "times increase");
    assert!(poses.iter().flat_map(|pose| pose.position_m).all(f64::is_finite));
}

/// If runs come of it, they are written and read again.
fn understood(chosen: Chosen, nominal: &Geometry, folder: &Path) {
    let hints = Hints {
        wheel_radius_m: Some(nominal.wheel_radius_m),
        track_width_m: Some(nominal.wheel_separation_m),
        ..Hints::default()
    };
    let understood = understand(chosen.wheels, &chosen.poses, &hints, chosen.same_clock);
    let Ok(understood) = understood else { return };
    assert!(understood.clock.late_s.is_finite());
    let _ = std::fs::remove_dir_all(folder);
    if let Ok(written) = import::write::write(&understood, folder, false) {
        let read = campaign::Campaign::read(folder).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read.runs.len(), written.names.len());
    }
}

/// A table or a trajectory.
pub fn log_table(input: &[u8]) {
    let Ok(logs) = text::parse(Path::new("log.csv"), input, &[]) else { return };
    sound_logs(logs);
}

/// Times increase and numbers are finite.
fn sound_logs(logs: text::TextLogs) {
    if let Some(wheels) = logs.wheels {
        assert!(wheels.t_s.windows(2).all(|pair| pair[0] < pair[1]), "times increase");
        assert!(wheels.turned.iter().flatten().all(|number| number.is_finite()));
    }
    if let Some(log) = logs.poses {
        assert!(log.poses.windows(2).all(|pair| pair[0].t_s < pair[1].t_s), "times increase");
        assert!(log.poses.iter().flat_map(|pose| pose.position_m).all(f64::is_finite));
    }
}

/// A data log of WPILib.
pub fn wpilog(input: &[u8]) {
    let mappings =
        text::parse_mappings("x_m=/p.x,y_m=/p.y,heading_rad=/p.heading").expect("mappings");
    let Ok(logs) = wpilog::parse(Path::new("log.wpilog"), input, &mappings) else { return };
    sound_logs(logs);
}

/// The parameters of a controller.
pub fn controller_yaml(input: &[u8]) {
    let Some(text) = as_text(input) else { return };
    let Ok(file) = controller_file::parse(Path::new("c.yaml"), text) else { return };
    let [left_m, right_m] = file.geometry.radii_m();
    assert!([left_m, right_m, file.geometry.track_width_m()].iter().all(|m| *m >= 0.0));
    assert!(file.geometry.wheel_radius_m > 0.0 && file.geometry.wheel_separation_m > 0.0);
}
