//! The robots of both plants.

use campaign::plan::CampaignPlan;
use sim_target::Scenario;
use sim_target::scenario::HiddenEffect;

use super::case::{Case, Kind};
use super::hard::{Difficulty, GEOMETRY, Hard};
use super::hidden_effects::{Hidden, true_parameters};
use super::kinematic::mechanism::{self, Mechanism};
use super::kinematic::robot::Robot as KinematicRobot;
use super::plant::{Dose, Ideal, Recorded, Robot, Truth};
use super::sim_target_robot::{PERIOD_MS, plan, record, sound};

/// A robot of forces, as `beeline campaign record` drives it.
pub struct Forces {
    case: Case,
    sound: Scenario,
    plan: CampaignPlan,
    knows_its_camera: bool,
}

/// What each effect of a case draws of its own.
fn seed_of(case: &Case, index: usize) -> u64 {
    case.seed ^ ((index as u64 + 1) << 40)
}

impl Forces {
    /// The robot of a case.
    pub fn new(case: &Case, difficulty: &Difficulty, knows_its_camera: bool) -> Self {
        let effects: Vec<HiddenEffect> =
            case.effects.iter().filter_map(|secret| secret.of_forces()).collect();
        let mut sound = sound(case.seed, case.kind, &effects);
        let radius_m = &mut sound.plant.geometry.wheel_radius_m;
        radius_m.left *= 1.0 - difficulty.ratio / 2.0;
        radius_m.right *= 1.0 + difficulty.ratio / 2.0;
        Self { case: case.clone(), sound, plan: plan(), knows_its_camera }
    }

    fn hidden(&self, dose: Dose) -> Option<Hidden> {
        let effect = self.case.effects[dose.index].of_forces()?;
        Some(Hidden { effect, strength: dose.strength, seed: seed_of(&self.case, dose.index) })
    }

    fn record_once(&self, doses: &[Dose], seed: u64) -> Result<Recorded, String> {
        let mut scenario = Scenario { seed, ..self.sound.clone() };
        let hidden: Vec<Hidden> = doses.iter().filter_map(|dose| self.hidden(*dose)).collect();
        hidden.iter().for_each(|secret| secret.hide(&mut scenario));
        scenario.validate().map_err(|error| error.to_string())?;
        let mut campaign =
            record(&scenario, &self.plan, PERIOD_MS).map_err(|error| error.to_string())?;
        if !self.knows_its_camera {
            campaign.robot.position_sigma_m = None;
            campaign.robot.heading_sigma_rad = None;
        }
        let hidden = hidden.iter().map(|secret| secret.effect.id());
        let others = hidden.filter(|id| !GEOMETRY.contains(id));
        let truth = GEOMETRY.into_iter().chain(others).flat_map(|id| {
            true_parameters(id, &scenario)
                .into_iter()
                .map(|(name, value)| (id.to_owned(), name, value))
        });
        Ok(Recorded { campaign, truth: truth.collect(), ideal: None })
    }
}

impl Robot for Forces {
    fn record(&self, doses: &mut [Dose]) -> Result<Recorded, String> {
        const TIMES: usize = 8;
        let mut outcome = self.record_once(doses, self.sound.seed);
        for _ in 0..TIMES {
            if outcome.is_ok() {
                break;
            }
            doses.iter_mut().for_each(|dose| dose.strength *= 0.7);
            outcome = self.record_once(doses, self.sound.seed);
        }
        outcome
    }

    fn record_twin(&self, doses: &[Dose]) -> Option<Result<Recorded, String>> {
        // Cameras, encoders and hands draw from it; what is hidden does not.
        Some(self.record_once(doses, self.sound.seed ^ (1 << 34)))
    }

    fn possible(&self, dose: Dose) -> Dose {
        let hidden = self.hidden(dose).map(|hidden| hidden.possible_in(&self.sound));
        Dose { strength: hidden.map_or(dose.strength, |hidden| hidden.strength), ..dose }
    }
}

/// A robot of the second plant.
pub struct Kinematic {
    case: Case,
    robot: KinematicRobot,
    /// Unequal wheels of a robot whose data sheet is wrong.
    always: Vec<mechanism::Hidden>,
    knows_its_camera: bool,
}

impl Kinematic {
    /// The robot of a case.
    pub fn new(case: &Case, difficulty: &Difficulty, knows_its_camera: bool) -> Self {
        let gyro = case.effects.iter().any(|secret| secret.id().starts_with("gyro_"));
        let robot = KinematicRobot::new(case.seed, case.kind == Kind::Nuisance, gyro);
        let ratio = mechanism::Hidden {
            mechanism: Mechanism::WheelRadiusRatio,
            p: [difficulty.ratio, 0.0, 0.0, 0.0],
        };
        let always = if difficulty.hard == Hard::Geometry { vec![ratio] } else { Vec::new() };
        Self { case: case.clone(), robot, always, knows_its_camera }
    }

    fn truth(&self, hidden: &[mechanism::Hidden]) -> Vec<Truth> {
        let fastest_rad_s = self.robot.fastest_rad_s();
        let mut truth: Vec<Truth> = Vec::new();
        for one in hidden {
            let id = one.mechanism.id();
            let numbers = one.true_parameters(fastest_rad_s).into_iter();
            truth.extend(numbers.map(|(name, value)| (id.to_owned(), name, value)));
        }
        for (id, name) in GEOMETRY.into_iter().zip(["rho", "s", "delta"]) {
            if !truth.iter().any(|known| known.0 == id && known.2 != 0.0) {
                truth.retain(|known| known.0 != id);
                truth.push((id.to_owned(), name, 0.0));
            }
        }
        truth
    }
}

impl Robot for Kinematic {
    fn record(&self, doses: &mut [Dose]) -> Result<Recorded, String> {
        let hidden = doses.iter().filter_map(|dose| {
            let mechanism = self.case.effects[dose.index].of_kinematics()?;
            let seed = seed_of(&self.case, dose.index);
            Some(mechanism::Hidden::new(mechanism, dose.strength, seed))
        });
        let hidden: Vec<_> = self.always.iter().copied().chain(hidden).collect();
        let recorded = self.robot.record((&self.always, &hidden), self.knows_its_camera);
        let (campaign, truth) = (recorded.campaign, self.truth(&hidden));
        let (hidden, sound) = (recorded.ideal, recorded.sound);
        let ideal = Ideal { hidden, sound, camera: self.robot.camera };
        Ok(Recorded { campaign, truth, ideal: Some(ideal) })
    }

    fn possible(&self, dose: Dose) -> Dose {
        let mechanism = self.case.effects[dose.index].of_kinematics();
        let most = mechanism.map_or(f64::INFINITY, Mechanism::strength_max);
        Dose { strength: dose.strength.min(most), ..dose }
    }
}
