//! What the robot said last, and what the page wishes: shared between the session's thread and the server's.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde::Deserialize;
use serde_json::{Value, json};
use shared_proto::{Config, Telemetry, WheelTelemetry};

use super::driven::{Driven, Motion};

/// So many frames are kept for those who come later: at 500 Hz, ten seconds.
const KEPT: usize = 5000;

/// So many poses of a camera: at 25 Hz, more than a minute.
const POSES_KEPT: usize = 2000;

/// A page that has heard nothing for longer moves nothing: what it sends may have waited on its way.
const STALE_MS: u64 = 200;

/// More wishes than this do not wait: the oldest go.
const WISHES_MAX: usize = 64;

/// A robot, as the page sees it.
pub struct Robot {
    begun: Instant,
    said: Mutex<Said>,
    driven: Mutex<Motion>,
    wishes: Mutex<VecDeque<Wish>>,
}

/// What the robot said.
#[derive(Default)]
struct Said {
    condition: Value,
    /// The latest frames, as the page takes them.
    rows: VecDeque<[i64; 15]>,
    /// How many frames there have been.
    count: u64,
    /// What a camera has seen last: time \[us\], x and y \[um\], heading \[urad\].
    poses: VecDeque<[i64; 4]>,
    poses_count: u64,
    /// The path that a model predicts, and how often it has.
    prediction: Option<Value>,
    predictions: u64,
}

/// What a listener has been told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heard {
    frames: u64,
    poses: u64,
    predictions: u64,
}

/// What the page wishes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// To move, or to go on moving.
    Hold(Hold),
    /// Brake along a ramp.
    Stop,
    /// Zero duty at once, latched as a fault.
    CutMotors,
    /// Clear the latched fault.
    Clear,
}

/// A button is held: the motion of this number goes on.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// Tells pages apart: while one drives, no other does.
    pub page: u64,
    /// The page counts its motions; after its end, a number does not come back.
    pub number: u64,
    /// What is wanted.
    pub motion: HeldMotion,
    /// `now_ms` of the news that the page has heard last: how old this message may be.
    pub heard_ms: u64,
}

/// A motion that the page can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum HeldMotion {
    /// A velocity, which may change from message to message.
    Velocity {
        /// Forward positive \[m/s\].
        forward_mps: f64,
        /// To the left positive \[rad/s\].
        turn_rad_s: f64,
    },
    /// Straight ahead by so much, backwards if negative.
    Straight {
        /// \[m\]
        distance_m: f64,
        /// Cruise speed \[m/s\].
        speed_mps: f64,
    },
    /// Along a circle.
    Arc {
        /// Of the middle between the wheels \[m\].
        radius_m: f64,
        /// To the left positive \[rad\].
        angle_rad: f64,
        /// Cruise speed of the faster wheel \[m/s\].
        speed_mps: f64,
    },
    /// On the spot by so much, to the left positive.
    Spin {
        /// \[rad\]
        angle_rad: f64,
        /// Cruise speed of the wheels \[m/s\].
        speed_mps: f64,
    },
}

impl Default for Robot {
    fn default() -> Self {
        Self {
            begun: Instant::now(),
            said: Mutex::default(),
            driven: Mutex::default(),
            wishes: Mutex::default(),
        }
    }
}

impl Robot {
    /// The server's clock \[ms\].
    fn now_ms(&self) -> u64 {
        self.begun.elapsed().as_millis() as u64
    }

    /// Adds frames of telemetry.
    pub fn push(&self, frames: impl Iterator<Item = Telemetry>) {
        let mut said = locked(&self.said);
        let mut driven = locked(&self.driven);
        for frame in frames {
            driven.push(frame);
            said.rows.push_back(row(&frame));
            said.count += 1;
            if said.rows.len() > KEPT {
                said.rows.pop_front();
            }
        }
    }

    /// What holds from now on.
    pub fn tell(&self, condition: Value) {
        locked(&self.said).condition = condition;
    }

    /// The configuration by which counts become angles.
    pub(super) fn set_config(&self, config: &Config) {
        *locked(&self.driven) = Motion::of(config);
    }

    /// What was driven since the last motion began, if there was one.
    pub(super) fn driven(&self) -> Option<Driven> {
        locked(&self.driven).driven()
    }

    pub(super) fn set_prediction(&self, prediction: Option<Value>) {
        let mut said = locked(&self.said);
        said.predictions += 1;
        said.prediction = prediction;
    }

    /// Adds what a camera has seen.
    pub fn push_poses(&self, poses: impl Iterator<Item = [i64; 4]>) {
        let mut said = locked(&self.said);
        for pose in poses {
            said.poses.push_back(pose);
            said.poses_count += 1;
            if said.poses.len() > POSES_KEPT {
                said.poses.pop_front();
            }
        }
    }

    /// The condition, and the frames and poses that whoever has `heard` this has not heard yet.
    pub fn news(&self, heard: Heard) -> (Value, Heard) {
        let said = locked(&self.said);
        let now_ms = self.now_ms();
        let rows = fresh(&said.rows, said.count - heard.frames.min(said.count));
        let mut news = json!({"condition": said.condition, "rows": rows, "now_ms": now_ms});
        if said.poses_count > 0 {
            news["camera"] = json!(fresh(&said.poses, said.poses_count - heard.poses));
        }
        if heard.predictions != said.predictions {
            news["prediction"] = json!(said.prediction);
        }
        let predictions = said.predictions;
        (news, Heard { frames: said.count, poses: said.poses_count, predictions })
    }

    /// Whether a page that has heard these news last has heard them lately.
    pub fn is_fresh(&self, heard_ms: u64) -> bool {
        let now_ms = self.now_ms();
        // What has not been told yet was not heard.
        heard_ms <= now_ms && now_ms - heard_ms <= STALE_MS
    }

    /// Whether the robot moves, by the last frame that it sent.
    pub fn moves(&self) -> bool {
        locked(&self.driven).moves()
    }

    /// Takes a wish; of too many, the oldest go.
    pub fn wish(&self, wish: Wish) {
        let mut wishes = locked(&self.wishes);
        if wishes.len() >= WISHES_MAX {
            wishes.pop_front();
        }
        wishes.push_back(wish);
    }

    /// What is to be done now: a stop overtakes what was wished before it, and of what is held only the latest counts.
    pub(super) fn take_wishes(&self) -> Vec<Wish> {
        let taken = std::mem::take(&mut *locked(&self.wishes));
        let stops = |wish: &Wish| matches!(wish, Wish::Stop | Wish::CutMotors);
        let last_stop = taken.iter().rposition(stops);
        let mut due: Vec<Wish> = Vec::new();
        for (index, wish) in taken.into_iter().enumerate() {
            match wish {
                Wish::Hold(_) if last_stop.is_some_and(|stop| index < stop) => {}
                Wish::Hold(hold) if !self.is_fresh(hold.heard_ms) => {}
                Wish::Hold(_) => {
                    due.retain(|other| !matches!(other, Wish::Hold(_)));
                    due.push(wish);
                }
                _ if due.contains(&wish) => {}
                Wish::CutMotors => due.insert(0, wish),
                _ => due.push(wish),
            }
        }
        due
    }
}

/// The last so many of what is kept.
fn fresh<T>(kept: &VecDeque<T>, count: u64) -> Vec<&T> {
    let count = kept.len().min(count as usize);
    kept.iter().skip(kept.len() - count).collect()
}

/// A frame for the page: time \[us\], state, whether it probes, x and y \[um\], heading \[urad\], supply \[mV\]; of each wheel
/// setpoint and error \[um\], speed \[um/s\] and duty \[1/32767\].
fn row(frame: &Telemetry) -> [i64; 15] {
    let wheel = |wheel: WheelTelemetry| {
        let (error, speed) = (i64::from(wheel.error_um), i64::from(wheel.speed_um_s));
        [wheel.setpoint_um, error, speed, i64::from(wheel.duty)]
    };
    let [a, b, c, d] = wheel(frame.wheels.left);
    let [e, f, g, h] = wheel(frame.wheels.right);
    let (t_us, pose) = (frame.t_us as i64, frame.pose);
    let of_robot = (frame.state as i64, i64::from(frame.probing), i64::from(frame.supply_mv));
    let (state, probing, supply) = of_robot;
    [t_us, state, probing, pose.x_um, pose.y_um, pose.heading_urad, supply, a, b, c, d, e, f, g, h]
}

/// A lock whose holder panicked guards whole values all the same.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hold(number: u64) -> Wish {
        let motion = HeldMotion::Velocity { forward_mps: 0.1, turn_rad_s: 0.0 };
        Wish::Hold(Hold { page: 1, number, motion, heard_ms: 0 })
    }

    #[test]
    fn a_stop_overtakes_what_was_held_before_it_and_nothing_that_is_held_waits_in_a_queue() {
        let robot = Robot::default();
        for number in 1..=200 {
            robot.wish(hold(number));
        }
        assert_eq!(robot.take_wishes(), [hold(200)]);
        for wish in [hold(1), Wish::Stop, Wish::Stop, Wish::CutMotors] {
            robot.wish(wish);
        }
        assert_eq!(robot.take_wishes(), [Wish::CutMotors, Wish::Stop]);
        for wish in [Wish::Stop, hold(2)] {
            robot.wish(wish);
        }
        assert_eq!(robot.take_wishes(), [Wish::Stop, hold(2)]);
        robot.wish(hold(3));
        std::thread::sleep(std::time::Duration::from_millis(STALE_MS + 20));
        assert_eq!(robot.take_wishes(), [], "what has waited is stale");
    }

    #[test]
    fn whoever_comes_late_gets_what_is_kept_and_each_frame_once() {
        let robot = Robot::default();
        let frame = |number: u32| Telemetry {
            number,
            t_us: u64::from(number),
            state: shared_proto::State::Idle,
            probing: false,
            wheels: shared_proto::WheelPair::both(WheelTelemetry::default()),
            supply_mv: 12_000,
            pose: shared_proto::Pose::default(),
            deviation: shared_proto::PoseDeviation::default(),
        };
        robot.push((0..3 * KEPT as u32).map(frame));
        let (news, heard) = robot.news(Heard::default());
        assert_eq!(news["rows"].as_array().unwrap().len(), KEPT);
        robot.push((0..2).map(frame));
        let (news, heard) = robot.news(heard);
        assert_eq!(news["rows"].as_array().unwrap().len(), 2);
        assert_eq!(news["camera"], Value::Null, "nobody looks");
        robot.push_poses((0..3).map(|t_us| [t_us, 0, 0, 0]));
        let (news, heard) = robot.news(heard);
        assert_eq!((&news["rows"], news["camera"].as_array().unwrap().len()), (&json!([]), 3));
        assert_eq!(robot.news(heard).0["camera"], json!([]));
    }
}
