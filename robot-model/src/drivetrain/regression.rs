//! A first guess: least squares on differentiated travel, as tuners of other makers do it.
//!
//! Speed and acceleration are differences over a window, so both lag and both have the encoder's noise: kA comes out
//! some tens of per cent off. As a beginning for the fit of travel that is good enough.

use nalgebra::{Matrix4, Vector4};

use super::model::{Drivetrain, WheelMotor};
use super::recording::{Sample, VoltageRecording};
use super::residuals::samples_per_count;
use crate::kinematics::WheelPair;

/// Half a window of the differences, at least \[s\]; and in samples that see the same count, of a coarse encoder.
const HALF_S: f64 = 0.03;
const HALF_COUNTS: f64 = 1.0;

/// The constants of (1) without coupling or delay; None if the recordings do not turn both wheels.
pub fn regress(recordings: &[VoltageRecording]) -> Option<Drivetrain> {
    let half_s = HALF_S.max(HALF_COUNTS * s_per_count(recordings));
    let of = |side: fn(WheelPair<f64>) -> f64| wheel(recordings, half_s, side);
    let wheels = WheelPair::new(of(|pair| pair.left)?, of(|pair| pair.right)?);
    Some(Drivetrain { wheels, ..Drivetrain::default() })
}

fn wheel(
    recordings: &[VoltageRecording],
    half_s: f64,
    side: fn(WheelPair<f64>) -> f64,
) -> Option<WheelMotor> {
    let mut normal = Matrix4::zeros();
    let mut right = Vector4::zeros();
    let fastest = recordings
        .iter()
        .flat_map(|recording| differences(recording, half_s, side))
        .fold(0.0_f64, |fastest, row| fastest.max(row.speed_mps.abs()));
    for row in recordings.iter().flat_map(|recording| differences(recording, half_s, side)) {
        // A wheel at rest tells nothing but that friction holds it.
        if row.speed_mps.abs() < 0.05 * fastest {
            continue;
        }
        let forward = f64::from(u8::from(row.speed_mps > 0.0));
        let terms = Vector4::new(forward, forward - 1.0, row.speed_mps, row.acceleration_mps2);
        normal += terms * terms.transpose();
        right += terms * row.volts;
    }
    let scale = normal.diagonal().max();
    let ridge = Matrix4::from_diagonal_element(1e-9 * scale);
    let found = (normal + ridge).cholesky()?.solve(&right);
    if !found.iter().all(|value| value.is_finite()) || found[2] <= 0.0 {
        return None;
    }
    let kv_v_s_per_m = found[2];
    Some(WheelMotor {
        ks_forward_v: found[0].max(0.0),
        ks_backward_v: found[1].max(0.0),
        kv_v_s_per_m,
        // No motor answers within 2 ms, nor takes a second.
        ka_v_s2_per_m: found[3].clamp(0.002 * kv_v_s_per_m, kv_v_s_per_m),
    })
}

/// How long a count lasts, on average; zero for travel that is not counted.
fn s_per_count(recordings: &[VoltageRecording]) -> f64 {
    let (mut s, mut intervals) = (0.0, 0.0);
    for samples in recordings.iter().map(VoltageRecording::samples) {
        s += samples[samples.len() - 1].t_s - samples[0].t_s;
        intervals += samples.len() as f64 - 1.0;
    }
    let per_count = samples_per_count(recordings);
    if per_count > 1.0 { per_count * s / intervals } else { 0.0 }
}

struct Row {
    volts: f64,
    speed_mps: f64,
    acceleration_mps2: f64,
}

/// Central differences over a window.
fn differences(
    recording: &VoltageRecording,
    half_s: f64,
    side: fn(WheelPair<f64>) -> f64,
) -> Vec<Row> {
    let samples = recording.samples();
    let mut rows = Vec::new();
    for (index, middle) in samples.iter().enumerate() {
        let early = samples[..index].iter().rposition(|s| s.t_s <= middle.t_s - half_s);
        let late = samples[index..].iter().position(|s| s.t_s >= middle.t_s + half_s);
        let (Some(early), Some(late)) = (early, late.map(|late| late + index)) else { continue };
        let slope = |a: &Sample, b: &Sample, of: fn(&Sample) -> WheelPair<f64>| {
            (side(of(b)) - side(of(a))) / (b.t_s - a.t_s)
        };
        let (a, b) = (&samples[early], &samples[late]);
        let travel: fn(&Sample) -> WheelPair<f64> = |sample| sample.travel_m;
        let rise = slope(middle, b, travel) - slope(a, middle, travel);
        rows.push(Row {
            volts: slope(a, b, |sample| sample.applied_vs),
            speed_mps: slope(a, b, travel),
            acceleration_mps2: rise / (0.5 * (b.t_s - a.t_s)),
        });
    }
    rows
}
