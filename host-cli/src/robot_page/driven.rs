//! What was driven since the last motion began.

use shared_proto::{Config, State, Telemetry};

/// What was driven since the last motion began.
pub(super) struct Driven {
    /// By which counts become angles.
    pub(super) config: Config,
    /// Some of the frames.
    pub(super) frames: Vec<Telemetry>,
}

/// The frames since the last motion began, some of them.
#[derive(Default)]
pub(super) struct Motion {
    config: Option<Config>,
    frames: Vec<Telemetry>,
    /// The robot moves.
    moves: bool,
}

impl Motion {
    /// Times between kept frames \[us\].
    const EVERY_US: u64 = 40_000;
    /// Of more frames, every second is kept.
    const FRAMES_MAX: usize = 3000;

    /// Of a robot with this configuration, which stands.
    pub(super) fn of(config: &Config) -> Self {
        Self { config: Some(config.clone()), ..Self::default() }
    }

    /// What was driven, if anything was.
    pub(super) fn driven(&self) -> Option<Driven> {
        let config = self.config.clone()?;
        (self.frames.len() > 1).then(|| Driven { config, frames: self.frames.clone() })
    }

    /// Whether it goes on.
    pub(super) fn moves(&self) -> bool {
        self.moves
    }

    /// The next frame of telemetry.
    pub(super) fn push(&mut self, frame: Telemetry) {
        let moves = matches!(frame.state, State::Driving | State::Stopping);
        if moves && !std::mem::replace(&mut self.moves, moves) {
            self.frames.clear();
        }
        self.moves = moves;
        let last_us = self.frames.last().map(|last| last.t_us);
        // A robot that has restarted begins anew.
        if last_us.is_some_and(|last_us| frame.t_us < last_us) {
            self.frames.clear();
        }
        let is_due = last_us.is_none_or(|last_us| frame.t_us >= last_us + Self::EVERY_US);
        if !moves && self.frames.is_empty() || !is_due {
            return;
        }
        // One more after it has stopped.
        let stands = self.frames.last().is_some_and(|last| last.wheels == frame.wheels);
        if moves || !stands {
            self.frames.push(frame);
        }
        if self.frames.len() > Self::FRAMES_MAX {
            let mut number = 0_usize;
            self.frames.retain(|_| {
                number += 1;
                number % 2 == 1
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use shared_proto::{Pose, PoseDeviation, WheelPair, WheelTelemetry};

    use super::*;

    #[test]
    fn a_motion_is_kept_from_its_beginning_until_the_next_one_begins() {
        let mut motion = Motion::of(&Config::default());
        let mut t_us = 0;
        let mut drive = |motion: &mut Motion, state: State, times: u32| {
            for _ in 0..times {
                t_us += 2000;
                let counts = if state == State::Driving { t_us as i64 } else { 0 };
                let wheel = WheelTelemetry { counts, ..WheelTelemetry::default() };
                motion.push(Telemetry {
                    number: 0,
                    t_us,
                    state,
                    probing: false,
                    wheels: WheelPair::both(wheel),
                    supply_mv: 12_000,
                    pose: Pose::default(),
                    deviation: PoseDeviation::default(),
                });
            }
        };
        drive(&mut motion, State::Idle, 1000);
        assert!(motion.driven().is_none());
        drive(&mut motion, State::Driving, 1000);
        // Two seconds, 25 times a second.
        assert_eq!(motion.driven().unwrap().frames.len(), 50);
        drive(&mut motion, State::Idle, 1000);
        assert!(motion.driven().unwrap().frames.len() <= 52, "a robot that stands adds nothing");
        drive(&mut motion, State::Driving, 100);
        assert_eq!(motion.driven().unwrap().frames.len(), 5);
        drive(&mut motion, State::Driving, 400_000);
        assert!(motion.driven().unwrap().frames.len() <= 3001);
    }
}
