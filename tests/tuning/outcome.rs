//! Tunes a drawn robot as a user would, and judges what came of it by the robot's true motion.

use host_cli::tune::{Settings, Tuned, tune};
use shared_proto::{Config, State};
use sim_target::Options;

use super::robots::UntunedRobot;
use crate::robot::on_robot_with;

/// The floor that every robot gets \[m\].
pub const FLOOR_M: f64 = 3.0;

/// What came of a tuning.
pub struct TuningOutcome {
    /// The tuning, or why not.
    pub tuned: Result<Box<Tuned>, String>,
    /// How far behind where it stood, and how far ahead, the robot's middle was \[m\].
    pub range_m: (f64, f64),
    /// The motors were off at the end, or the robot stood still.
    pub at_rest: bool,
    /// The configuration that a restart would read is the original one.
    pub unchanged: bool,
    /// The configuration that the robot has now.
    pub config: Config,
}

impl UntunedRobot {
    /// Least root mean square distance from the setpoints that this robot's encoders and supply allow \[m\].
    ///
    /// A count that is read as its lower edge is off by a half on average and by 1/sqrt(12) about that; a loop that takes
    /// the mean out still has the latter. The setpoints' own accuracy is a part of it for a fine encoder: the supply's
    /// noise of 20 mV moves a wheel by a few hundredths of a millimetre.
    pub fn following_floor_m(&self) -> f64 {
        let count_m = self.meters_per_count() / 12.0_f64.sqrt();
        count_m.hypot(2e-5)
    }

    /// Tunes it.
    pub fn tune(&self) -> TuningOutcome {
        let options = Options { config: Some(self.config.clone()), ..Options::default() };
        on_robot_with(&self.scenario, options, async |robot| {
            robot.listen(0.01).await;
            let settings = Settings {
                floor_m: FLOOR_M,
                wheels_up: false,
                stiffness: 1.0,
                record: false,
                undo_folder: None,
            };
            let start = robot.snapshot().pose;
            let tuned = tune(&mut robot.session, &settings, &mut |_| {}).await;
            let ways = robot.snapshots_from(0);
            let ahead = ways.iter().map(|snapshot| snapshot.pose.relative_to(start).x_m);
            let range_m =
                ahead.fold((0.0_f64, 0.0_f64), |(low, high), x_m| (low.min(x_m), high.max(x_m)));
            let state = robot.state().await;
            let config = robot.session.read_config().await.expect("it answers");
            TuningOutcome {
                tuned: tuned.map(Box::new).map_err(|error| error.to_string()),
                range_m,
                at_rest: matches!(state, State::Idle | State::Faulted),
                unchanged: config == self.config,
                config,
            }
        })
    }
}
