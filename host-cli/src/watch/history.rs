//! The last seconds of telemetry, and the path that they drew.

use std::collections::VecDeque;

use shared_proto::{Telemetry, WheelPair, WheelTelemetry};

/// So much telemetry is drawn \[us\].
const SPAN_US: u64 = 12_000_000;

/// The path has a point every so far \[m\].
const STEP_M: f64 = 0.005;

/// So many points are kept; then every second one goes.
const POINTS_MAX: usize = 4000;

/// One wheel at one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelNow {
    /// \[m/s\]
    pub speed_mps: f64,
    /// What the speed should be, from two setpoints \[m/s\].
    pub setpoint_mps: f64,
    /// Following error: setpoint minus measured travel \[m\].
    pub error_m: f64,
    /// -1 to 1.
    pub duty: f64,
}

/// One frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since power-on \[us\].
    pub t_us: u64,
    /// Each wheel.
    pub wheels: WheelPair<WheelNow>,
}

/// The last seconds, and the path.
#[derive(Clone, Debug, Default)]
pub struct History {
    samples: VecDeque<Sample>,
    last: Option<Telemetry>,
    path: Vec<(f64, f64)>,
}

impl History {
    /// Adds a frame.
    pub fn push(&mut self, frame: &Telemetry) {
        let before = self.last.filter(|last| last.t_us < frame.t_us);
        if before.is_none() && self.last.is_some() {
            // The robot has started anew.
            *self = Self::default();
        }
        let dt_s = before.map(|before| (frame.t_us - before.t_us) as f64 * 1e-6);
        let wheel = |now: WheelTelemetry, before: Option<WheelTelemetry>| {
            let moved_um = before.map(|before| now.setpoint_um.saturating_sub(before.setpoint_um));
            let setpoint_mps = moved_um.zip(dt_s).map(|(um, dt_s)| um as f64 * 1e-6 / dt_s);
            WheelNow {
                speed_mps: f64::from(now.speed_um_s) * 1e-6,
                setpoint_mps: setpoint_mps.unwrap_or_default(),
                error_m: f64::from(now.error_um) * 1e-6,
                duty: f64::from(now.duty) / f64::from(i16::MAX),
            }
        };
        let of = before.map(|before| before.wheels);
        let wheels = WheelPair::new(
            wheel(frame.wheels.left, of.map(|wheels| wheels.left)),
            wheel(frame.wheels.right, of.map(|wheels| wheels.right)),
        );
        self.samples.push_back(Sample { t_us: frame.t_us, wheels });
        while self.samples.front().is_some_and(|first| frame.t_us - first.t_us > SPAN_US) {
            self.samples.pop_front();
        }
        self.last = Some(*frame);
        self.go_to(frame.pose.x_um as f64 * 1e-6, frame.pose.y_um as f64 * 1e-6);
    }

    fn go_to(&mut self, x_m: f64, y_m: f64) {
        let far =
            |(from_x_m, from_y_m): &(f64, f64)| (x_m - from_x_m).hypot(y_m - from_y_m) >= STEP_M;
        if self.path.last().is_none_or(far) {
            self.path.push((x_m, y_m));
        }
        if self.path.len() > POINTS_MAX {
            let mut number = 0;
            self.path.retain(|_| {
                number += 1;
                number % 2 == 1
            });
        }
    }

    /// The last frame.
    pub fn last(&self) -> Option<&Telemetry> {
        self.last.as_ref()
    }

    /// The last sample.
    pub fn now(&self) -> Option<&Sample> {
        self.samples.back()
    }

    /// The path \[m\]: x ahead, y to the left.
    pub fn path(&self) -> &[(f64, f64)] {
        &self.path
    }

    /// The largest of each of so many spans of time, the newest last; none where there is no frame.
    pub fn largest(
        &self,
        spans: usize,
        of: impl Fn(&WheelPair<WheelNow>) -> f64,
    ) -> Vec<Option<f64>> {
        let mut largest: Vec<Option<f64>> = vec![None; spans];
        let (Some(last), true) = (self.samples.back(), spans > 0) else { return largest };
        for sample in &self.samples {
            let ago = (last.t_us - sample.t_us) as usize * spans / (SPAN_US as usize + 1);
            let slot = &mut largest[spans - 1 - ago];
            let value = of(&sample.wheels);
            *slot = Some(slot.map_or(value, |most| most.max(value)));
        }
        largest
    }
}
