//! Counts of telemetry as angles of the wheels, and the nominal robot of a configuration.

use std::f64::consts::TAU;

use robot_model::kinematics::{Geometry, WheelPair};
use shared_proto::{Config, EncoderConfig, GeometryConfig, Telemetry};

/// How far both wheels have turned by one frame of telemetry, since power-on.
pub fn turns(frame: &Telemetry, config: &Config) -> WheelPair<f64> {
    let angle_rad = |counts: i64, encoder: EncoderConfig| {
        counts as f64 * TAU / (encoder.counts_per_rev * encoder.gear_reduction)
    };
    WheelPair {
        left: angle_rad(frame.wheels.left.counts, config.encoder.left),
        right: angle_rad(frame.wheels.right.counts, config.encoder.right),
    }
}

/// The nominal robot of a configuration, its radius and track known to this share, one sigma.
pub fn geometry(config: &Config, tolerance_share: f64) -> Geometry {
    let GeometryConfig { wheel_radius_m, track_width_m, .. } = config.geometry;
    let encoder = config.encoder.left;
    Geometry {
        wheel_radius_m,
        wheel_radius_sigma_m: wheel_radius_m * tolerance_share,
        track_width_m,
        track_width_sigma_m: track_width_m * tolerance_share,
        counts_per_wheel_rev: encoder.counts_per_rev * encoder.gear_reduction,
    }
}
