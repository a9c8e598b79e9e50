//! A case with its robot: how strong must an effect be, and the campaign that is recorded with it.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use robot_model::effect::{Effect, find};
use robot_model::explain::model::fit;
use robot_model::recording::Campaign;

use super::case::{Case, Kind};
use super::hard::{Difficulty, GEOMETRY, Hard};
use super::hidden_effects::REFERENCE;
use super::plant::{Dose, Plant, Robot, Taken, take, take_twin};
use super::robots::{Forces, Kinematic};
use super::strength::{Trial, scaled, sigmas, visibility};

/// How many times a strength is tried and scaled before the campaign is recorded.
const TRIALS: usize = 3;
/// A strength within this factor, in e-folds, is not tried again: effects are not linear.
const NEAR: f64 = 0.7;

/// A recorded campaign; what stands out in it, where that is known before any fit; and the same robot's without what is
/// hidden, where no fit knows that.
pub type Shown = (Taken, Vec<f64>, Option<Taken>);

/// A case with its robot and its difficulty.
pub struct BenchmarkRobot<'a> {
    /// The case.
    pub case: &'a Case,
    robot: Box<dyn Robot + 'a>,
    /// What makes its campaign hard.
    pub difficulty: Difficulty,
}

impl<'a> BenchmarkRobot<'a> {
    /// The robot of a case.
    pub fn new(case: &'a Case) -> Self {
        // Every other user can say how good the camera is.
        let knows_its_camera = ChaCha8Rng::seed_from_u64(case.seed ^ (1 << 32)).random_bool(0.5);
        let unequal = case.effects.iter().all(|effect| effect.id() != "wheel_radius_ratio");
        let difficulty = Difficulty::draw(case.hard, case.seed, unequal);
        let robot: Box<dyn Robot> = match case.plant {
            Plant::Forces => Box::new(Forces::new(case, &difficulty, knows_its_camera)),
            Plant::Kinematic => Box::new(Kinematic::new(case, &difficulty, knows_its_camera)),
        };
        Self { case, robot, difficulty }
    }

    fn take(&self, doses: &mut [Dose]) -> Result<Taken, String> {
        take(self.robot.as_ref(), &self.difficulty, doses)
    }

    /// A second campaign with other noise, if the plant does not know its noise.
    ///
    /// # Errors
    /// What went wrong, for a person to read.
    pub fn twin(&self, taken: &Taken) -> Result<Option<Campaign>, String> {
        take_twin(self.robot.as_ref(), &self.difficulty, &taken.doses)
    }

    /// The effects of the fit that knows the truth, each once: those of these indices, and with a wrong data sheet its
    /// numbers.
    pub fn known(&self, doses: &[Dose]) -> Vec<&'static dyn Effect> {
        let hidden = doses.iter().flat_map(|dose| self.case.effects[dose.index].with_companions());
        let wrong = if self.case.hard == Hard::Geometry { &GEOMETRY[..] } else { &[] };
        let mut known: Vec<&'static dyn Effect> = Vec::new();
        for effect in hidden.chain(wrong.iter().copied().filter_map(find)) {
            if known.iter().all(|other| other.facts().id != effect.facts().id) {
                known.push(effect);
            }
        }
        known
    }

    /// Scales the strength of one effect until it stands out alone by `wanted` sigma, or as far as it can: stronger than
    /// any real robot has it, an effect is no longer what the catalogue says, and hardly stands out more.
    fn scale(&self, dose: &mut Dose, wanted: f64) -> Result<(), String> {
        let (mut first, mut last): (Option<Trial>, Option<Trial>) = (None, None);
        for _ in 0..TRIALS {
            let mut alone = [self.robot.possible(*dose)];
            let taken = self.take(&mut alone)?;
            let model =
                fit(&taken.mended, &self.known(&alone)).map_err(|error| error.to_string())?;
            let reached = sigmas(&model, self.case.effects[dose.index].id());
            let now = Trial { strength: alone[0].strength, reached };
            if let (Some(first), Some(last)) = (first, last)
                && now.is_too_strong(first)
                && last.reached < wanted
            {
                dose.strength = last.strength;
                break;
            }
            first = first.or(Some(now));
            last = Some(now);
            dose.strength = scaled(alone[0].strength, wanted, reached);
            if (reached / wanted).ln().abs() < NEAR {
                break;
            }
        }
        *dose = self.robot.possible(*dose);
        Ok(())
    }

    /// Scales an outside effect until it moves the robot so many times as far as noise does.
    fn scale_to_noise(&self, dose: &mut Dose) -> Result<(), String> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.case.seed ^ (1 << 33));
        // Two centimetres of wobble times ten would be another robot.
        let most: f64 = if self.case.hard == Hard::Wobble { 4.0 } else { 10.0 };
        let wanted = rng.random_range(3_f64.ln()..most.ln()).exp();
        for _ in 0..=TRIALS {
            let reached = times_noise(&self.take(&mut [*dose])?);
            if (reached / wanted - 1.0).abs() < 0.1 {
                break;
            }
            dose.strength *= (wanted / reached.max(1e-3)).min(100.0);
            *dose = self.robot.possible(*dose);
        }
        Ok(())
    }

    /// The recorded campaign.
    ///
    /// # Errors
    /// What went wrong, for a person to read.
    pub fn record(&self) -> Result<Shown, String> {
        let whole = 0..self.case.effects.len();
        let mut doses: Vec<Dose> = whole.map(|index| Dose { index, strength: REFERENCE }).collect();
        let Some(wanted) = self.case.kind.sigmas() else {
            return Ok((self.take(&mut doses)?, Vec::new(), None));
        };
        match (self.case.kind, self.case.plant) {
            (Kind::Outside, Plant::Kinematic) => {
                self.scale_to_noise(&mut doses[0])?;
                let taken = self.take(&mut doses)?;
                let reached = times_noise(&taken);
                let ends = self.case.hard == Hard::Ends;
                let without = if ends { Some(self.take(&mut [])?) } else { None };
                Ok((taken, vec![reached], without))
            }
            (Kind::Outside, Plant::Forces) => self.record_outside(&mut doses, wanted),
            _ => {
                doses.iter_mut().try_for_each(|dose| self.scale(dose, wanted))?;
                Ok((self.take(&mut doses)?, Vec::new(), None))
            }
        }
    }

    /// An effect of forces that no fit knows.
    fn record_outside(&self, doses: &mut [Dose], wanted: f64) -> Result<Shown, String> {
        let without = self.take(&mut [])?;
        let shows = |taken: &Taken| {
            visibility(&without.mended, &taken.mended).map_err(|error| error.to_string())
        };
        let mut taken = self.take(doses)?;
        let mut reached = shows(&taken)?;
        if reached < wanted {
            doses[0].strength = scaled(doses[0].strength, 1.5 * wanted, reached);
            doses[0] = self.robot.possible(doses[0]);
            taken = self.take(doses)?;
            reached = shows(&taken)?;
        }
        Ok((taken, vec![reached], Some(without)))
    }
}

/// How many times as far as noise it moves the robot.
fn times_noise(taken: &Taken) -> f64 {
    taken.moved_m.unwrap_or(f64::NAN) / taken.noise_m.unwrap_or(f64::NAN)
}
