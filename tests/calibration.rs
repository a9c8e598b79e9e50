//! Does a calibration make a simulated robot drive straight? Verdicts by the truth, which only the simulator knows.

use host_cli::calibrate::{CalibrateStep, CalibrationDrive, Decision, Settings, calibrate};
use host_cli::pose_source::PoseSource;
use host_cli::pose_source::camera::Camera;
use host_cli::pose_source::ruler::Ruler;
use sim_target::plant::Pose;
use sim_target::{Scenario, Testbed};

use crate::parallel::in_order;
use crate::robot::on_robot;

/// The instrument that measures the robot's deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instrument {
    /// The overhead camera: 1 mm, 2 mrad.
    Camera,
    /// The ruler: marks of half a millimetre.
    Ruler,
}

/// How one robot's calibration went.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationOutcome {
    /// Which robot.
    pub seed: u64,
    /// The true R_R / R_L.
    pub true_ratio: f64,
    /// W_T of the first run.
    pub wheel_weight: f64,
    /// Its sigma.
    pub sigma: f64,
    /// Whether its 95 % interval covers the true ratio.
    pub covered: bool,
    /// True lateral error at the end of the first run, from its true start \[m\].
    pub before_m: f64,
    /// The same with the new W_T; the first run's where none was written \[m\].
    pub after_m: f64,
    /// What was done, in one word.
    pub decision: &'static str,
}

impl CalibrationOutcome {
    /// The factor by which the lateral error has fallen.
    pub fn factor(&self) -> f64 {
        (self.before_m / self.after_m).abs()
    }

    /// Error of W_T in its own sigmas.
    pub fn error_sigmas(&self) -> f64 {
        (self.wheel_weight - self.true_ratio) / self.sigma
    }
}

/// Where a drive truly began, and where the robot truly was when it was measured.
#[derive(Clone, Copy, Default)]
struct TrueRun {
    start: Option<Pose>,
    end: Pose,
}

impl TrueRun {
    fn watch(&mut self, testbed: &Testbed) {
        self.start.get_or_insert_with(|| testbed.pose());
    }

    fn lateral_m(&self) -> f64 {
        self.start.map_or(f64::NAN, |start| self.end.relative_to(start).y_m)
    }
}

/// Calibrates the robot that this seed draws.
///
/// # Errors
/// The message that a user would read.
pub fn verdict_on(seed: u64, instrument: Instrument) -> Result<CalibrationOutcome, String> {
    verdict_on_scenario(&Scenario::draw(seed), instrument)
}

/// Calibrates the robot of a scenario.
///
/// # Errors
/// The message that a user would read.
pub fn verdict_on_scenario(
    scenario: &Scenario,
    instrument: Instrument,
) -> Result<CalibrationOutcome, String> {
    on_robot(scenario, async |robot| {
        let testbed = robot.testbed.clone();
        let source: &mut dyn PoseSource = match instrument {
            Instrument::Camera => &mut Camera::new(testbed.clone()),
            Instrument::Ruler => &mut Ruler::new(testbed.clone()),
        };
        let (mut before, mut after) = (TrueRun::default(), TrueRun::default());
        let mut tell = |step: CalibrateStep<'_>| match step {
            // The first call comes when the robot has hardly begun its first ramp.
            CalibrateStep::Driving(CalibrationDrive::Before, _) => before.watch(&testbed),
            CalibrateStep::Driving(CalibrationDrive::After, _) => after.watch(&testbed),
            CalibrateStep::Measured(CalibrationDrive::Before, _) => before.end = testbed.pose(),
            CalibrateStep::Measured(CalibrationDrive::After, _) => after.end = testbed.pose(),
            _ => {}
        };
        let settings = Settings::default();
        let outcome = calibrate(&mut robot.session, source, &settings, &mut tell).await;
        let outcome = outcome.map_err(|error| error.to_string())?;
        let radius_m = scenario.plant.geometry.wheel_radius_m;
        let true_ratio = radius_m.right / radius_m.left;
        let measured = &outcome.before.wheel_weight;
        let (decision, after_m) = match outcome.decision {
            Decision::Corrected(_) => ("corrected", after.lateral_m()),
            Decision::NotBetter(_) => ("not better", before.lateral_m()),
            Decision::NotRepeatable(..) => ("not repeatable", before.lateral_m()),
            Decision::AlreadyStraight => ("already straight", before.lateral_m()),
            Decision::CannotTell => ("cannot tell", before.lateral_m()),
            Decision::NotARadius => ("not a radius", before.lateral_m()),
        };
        Ok(CalibrationOutcome {
            seed: scenario.seed,
            true_ratio,
            wheel_weight: measured.value,
            sigma: measured.sigma,
            covered: (measured.low95..=measured.high95).contains(&true_ratio),
            before_m: before.lateral_m(),
            after_m,
            decision,
        })
    })
}

/// Calibrates many robots on all cores; the verdicts are in the order of the seeds.
pub fn verdicts_on(
    seeds: &[u64],
    instrument: Instrument,
) -> Vec<Result<CalibrationOutcome, String>> {
    in_order(seeds, |seed| verdict_on(*seed, instrument))
}

/// Lower quartile, median and upper quartile, by linear interpolation between ranks.
pub fn quartiles(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    [0.25, 0.5, 0.75].map(|share| {
        let rank = share * (sorted.len().max(1) - 1) as f64;
        let low = sorted.get(rank.floor() as usize).copied().unwrap_or(f64::NAN);
        let high = sorted.get(rank.ceil() as usize).copied().unwrap_or(f64::NAN);
        low + (high - low) * rank.fract()
    })
}
