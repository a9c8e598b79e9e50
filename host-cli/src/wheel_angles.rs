//! Telemetry counts as wheel angles, and the nominal robot of a configuration.

use std::f64::consts::TAU;

use robot_model::kinematics::{Geometry, WheelPair};
use shared_proto::{Config, GeometryConfig, Telemetry};

/// The angles of both wheels since power-on, from one telemetry frame \[rad\].
pub fn turns(frame: &Telemetry, config: &Config) -> WheelPair<f64> {
    for_model(frame.wheels.zip(config.encoder).map(|(wheel, encoder)| {
        wheel.counts as f64 * TAU / (encoder.counts_per_rev * encoder.gear_reduction)
    }))
}

/// A pair of the wire as the model's, which depends on none of our crates.
pub fn for_model<T>(of: shared_proto::WheelPair<T>) -> WheelPair<T> {
    WheelPair { left: of.left, right: of.right }
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

/// Travel of both wheels between two frames as the firmware has it, the right one's with W_T \[m\].
pub fn travel_m(
    config: &Config,
    first: &Telemetry,
    frame: &Telemetry,
) -> shared_proto::WheelPair<f64> {
    let q_m = config.encoder.map(|encoder| config.meters_per_count(&encoder));
    let counts = first.wheels.zip(frame.wheels);
    let mut travel = counts
        .zip(q_m)
        .map(|((first, now), q_m)| now.counts.wrapping_sub(first.counts) as f64 * q_m);
    travel.right *= config.geometry.wheel_weight;
    travel
}
