//! Telemetry counts as wheel angles, and the nominal robot of a configuration.

use std::f64::consts::TAU;

use robot_model::kinematics::{Geometry, WheelPair};
use shared_proto::{Config, EncoderConfig, GeometryConfig, Telemetry};

/// The angles of both wheels since power-on, from one telemetry frame \[rad\].
pub fn turns(frame: &Telemetry, config: &Config) -> WheelPair<f64> {
    let angle_rad = |counts: i64, encoder: EncoderConfig| {
        counts as f64 * TAU / (encoder.counts_per_rev * encoder.gear_reduction)
    };
    WheelPair {
        left: angle_rad(frame.wheels.left.counts, config.encoder.left),
        right: angle_rad(frame.wheels.right.counts, config.encoder.right),
    }
}

/// The nominal robot of a configuration; radius and track width have this relative uncertainty, one
/// sigma.
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
