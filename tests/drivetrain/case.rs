//! A robot with something hidden in its motors, and its recording, as `beeline tune --record` drives and writes it.

use std::path::Path;

use campaign::{Campaign, CampaignWriter, Experiments};
use host_cli::tune::{drive_experiments, recorded};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Config, EncoderConfig, WheelPair};
use sim_target::{Options, Scenario};

use super::hidden::{Hidden, INSIDE, OUTSIDE};
use crate::robot::on_robot_with;

/// The floor that every robot gets \[m\].
const FLOOR_M: f64 = 3.0;

/// What kind of campaign it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One effect, strong.
    Strong,
    /// One effect, a third as strong.
    Weak,
    /// Two effects, two thirds as strong.
    Two,
    /// Nothing.
    Nothing,
    /// One that is in no catalogue.
    Outside,
}

/// A campaign to record.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its number within the seed.
    pub number: u64,
    /// The kind.
    pub kind: Kind,
    /// What is hidden.
    pub hidden: Vec<Hidden>,
    scenario: Scenario,
    config: Config,
}

impl Case {
    /// Draws a case: of ten, three strong, two weak, one with two, two with nothing, two from outside.
    pub fn draw(seed: u64, number: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64((seed << 32) ^ number ^ 0x0D7A_0000_0000_0000);
        let kind = match number % 10 {
            0 | 3 | 7 => Kind::Strong,
            1 | 5 => Kind::Weak,
            2 => Kind::Two,
            4 | 8 => Kind::Nothing,
            _ => Kind::Outside,
        };
        let pick = |rng: &mut ChaCha8Rng| INSIDE[rng.random_range(0..INSIDE.len())].0;
        let hidden = match kind {
            Kind::Strong | Kind::Weak => vec![pick(&mut rng)],
            Kind::Two => {
                let first = pick(&mut rng);
                let mut second = pick(&mut rng);
                while second == first {
                    second = pick(&mut rng);
                }
                vec![first, second]
            }
            Kind::Nothing => Vec::new(),
            Kind::Outside => vec![OUTSIDE[rng.random_range(0..OUTSIDE.len())]],
        };
        let strength = match kind {
            Kind::Weak => 0.33,
            Kind::Two => 0.67,
            _ => 1.0,
        };
        Self::with(seed, number, kind, hidden, strength)
    }

    /// A robot of this seed and number, with this hidden.
    pub fn with(seed: u64, number: u64, kind: Kind, hidden: Vec<Hidden>, strength: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64((seed << 32) ^ number ^ 0x0D7B_0000_0000_0000);
        let name = format!("motors {seed} {number}");
        let mut scenario = Scenario { name, seed: rng.random(), ..Scenario::default() };
        let mut config = Config::default();
        build(&mut scenario, &mut config, &mut rng);
        for hidden in &hidden {
            hidden.apply(&mut scenario.plant, &mut config, strength, &mut rng);
        }
        Self { number, kind, hidden, scenario, config }
    }

    /// The same robot with nothing hidden.
    pub fn sound(&self, seed: u64) -> Self {
        Self::with(seed, self.number, Kind::Nothing, Vec::new(), 0.0)
    }

    /// The plant's parameters.
    pub fn plant(&self) -> &sim_target::plant::PlantParameters {
        &self.scenario.plant
    }

    /// Changes a part of the plant; the configuration knows the encoders that come of it.
    pub fn change(&mut self, change: impl FnOnce(&mut sim_target::plant::PlantParameters)) {
        change(&mut self.scenario.plant);
        self.config.encoder = self.scenario.plant.encoder.map(|encoder| EncoderConfig {
            counts_per_rev: encoder.counts_per_rev,
            gear_reduction: encoder.gear_reduction,
            reversed: false,
        });
    }

    /// Records it into a folder, and reads it back.
    pub fn record(&self, folder: &Path) -> Result<Experiments, String> {
        let options = Options { config: Some(self.config.clone()), ..Options::default() };
        let driven = on_robot_with(&self.scenario, options, async |robot| {
            robot.listen(0.01).await;
            drive_experiments(&mut robot.session, FLOOR_M).await
        });
        let (config, driven) = driven.map_err(|error| error.to_string())?;
        let writer = CampaignWriter::open(folder, &recorded::robot_of(&config))
            .map_err(|error| error.to_string())?;
        recorded::write(&writer, None, &config, &driven).map_err(|error| error.to_string())?;
        drop(writer);
        let read = Campaign::read(folder).map_err(|error| error.to_string())?;
        read.experiments(folder).map_err(|error| error.to_string())
    }
}

/// A robot with two equal motors.
///
/// | what | from | to |
/// | --- | --- | --- |
/// | mass | 3 kg | 5.5 kg |
/// | dry friction | 0.03 N m | 0.09 N m |
/// | motor's constant, resistance | 0.85 | 1.15 times the standard one's |
/// | counts per turn of a wheel | 700 | 4000, on the wheel or on a motor behind a gear of 30 |
fn build(scenario: &mut Scenario, config: &mut Config, rng: &mut ChaCha8Rng) {
    let plant = &mut scenario.plant;
    let mass = rng.random_range(0.75..1.4);
    plant.body.mass_kg *= mass;
    plant.body.yaw_inertia_kgm2 *= mass;
    let mut motor = plant.motor.left;
    motor.coulomb_torque_nm = rng.random_range(0.03..0.09);
    motor.torque_constant_nm_per_a *= rng.random_range(0.85..1.15);
    motor.resistance_ohm *= rng.random_range(0.85..1.15);
    motor.rotor_inertia_kgm2 *= rng.random_range(0.6..1.8);
    plant.motor = WheelPair::both(motor);
    let counts = rng.random_range(700.0_f64..4000.0).round();
    let (counts_per_rev, gear_reduction) =
        if rng.random() { (counts, 1.0) } else { ((counts / 30.0).round().max(32.0), 30.0) };
    for encoder in [&mut plant.encoder.left, &mut plant.encoder.right] {
        (encoder.counts_per_rev, encoder.gear_reduction) = (counts_per_rev, gear_reduction);
    }
    config.encoder =
        WheelPair::both(EncoderConfig { counts_per_rev, gear_reduction, reversed: false });
    for substep_us in [500, 400, 300, 200, 150, 100, 60, 30] {
        plant.substep_us = substep_us;
        if plant.validate().is_ok() {
            break;
        }
    }
}
