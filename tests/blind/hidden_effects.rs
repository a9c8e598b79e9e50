//! Which effects can be hidden in a robot, and which of the model's parameters do they correspond to?

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use robot_model::effect::{Effect, find};
use shared_proto::WheelPair;
use sim_target::Scenario;
use sim_target::plant::PlantParameters;
use sim_target::scenario::HiddenEffect;

use super::kinematic::mechanism::Mechanism;
use super::plant::Plant;

/// The strength at which an effect's detectability is measured first: typical in the field.
pub const REFERENCE: f64 = 1.0;

/// Effects of the catalogue.
pub fn inside() -> Vec<HiddenEffect> {
    HiddenEffect::ALL.iter().copied().filter(|effect| effect.is_in_catalogue()).collect()
}

/// Effects outside the catalogue.
pub fn outside() -> Vec<HiddenEffect> {
    HiddenEffect::ALL.iter().copied().filter(|effect| !effect.is_in_catalogue()).collect()
}

/// What a robot of either plant can hide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Secret {
    /// In the plant of forces.
    Forces(HiddenEffect),
    /// In the plant of kinematics.
    Kinematic(Mechanism),
}

impl Secret {
    /// Its name; of the catalogue's effects, that of the catalogue.
    pub fn id(self) -> &'static str {
        match self {
            Self::Forces(effect) => effect.id(),
            Self::Kinematic(mechanism) => mechanism.id(),
        }
    }

    /// The effect of the plant of forces.
    pub fn of_forces(self) -> Option<HiddenEffect> {
        if let Self::Forces(effect) = self { Some(effect) } else { None }
    }

    /// The mechanism of the plant of kinematics.
    pub fn of_kinematics(self) -> Option<Mechanism> {
        if let Self::Kinematic(mechanism) = self { Some(mechanism) } else { None }
    }

    /// The effects of the fit that knows the truth; none for what is outside the catalogue.
    pub fn with_companions(self) -> Vec<&'static dyn Effect> {
        match self {
            Self::Forces(effect) => with_companions(effect),
            Self::Kinematic(mechanism) => find(mechanism.id()).into_iter().collect(),
        }
    }

    /// The regressors on which an effect outside the catalogue depends; any of them is right.
    pub fn regressors(self) -> &'static [&'static str] {
        match self {
            Self::Forces(effect) => regressors(effect),
            Self::Kinematic(mechanism) => mechanism.regressors(),
        }
    }

    /// What a plant can hide, in the catalogue or outside it.
    pub fn all(plant: Plant, in_catalogue: bool) -> Vec<Self> {
        match plant {
            Plant::Forces if in_catalogue => inside().into_iter().map(Self::Forces).collect(),
            Plant::Forces => outside().into_iter().map(Self::Forces).collect(),
            Plant::Kinematic => Mechanism::ALL
                .iter()
                .filter(|mechanism| mechanism.is_in_catalogue() == in_catalogue)
                .map(|mechanism| Self::Kinematic(*mechanism))
                .collect(),
        }
    }
}

/// One effect to be hidden.
#[derive(Clone, Copy, Debug)]
pub struct Hidden {
    /// Which.
    pub effect: HiddenEffect,
    /// Its strength; 1 is typical in the field.
    pub strength: f64,
    /// Draws signs and directions.
    pub seed: u64,
}

impl Hidden {
    /// Puts it into the robot or what is round it.
    pub fn hide(&self, scenario: &mut Scenario) {
        self.effect.apply(scenario, self.strength, &mut ChaCha8Rng::seed_from_u64(self.seed));
        if self.effect == HiddenEffect::CasterKick {
            // Every procedure asks for this. Otherwise each run begins with a kick of its own, after a reversal
            // that is not in the recording.
            scenario.placement.caster_trails = true;
        }
    }

    /// The same, weakened until it is physical.
    pub fn possible_in(mut self, sound: &Scenario) -> Self {
        for _ in 0..20 {
            let mut scenario = sound.clone();
            self.hide(&mut scenario);
            if scenario.validate().is_ok() {
                break;
            }
            self.strength *= 0.8;
        }
        self
    }
}

/// An effect of the catalogue, with the effects that the same part of the robot causes as well: the fit that knows
/// the truth has these, too.
pub fn with_companions(effect: HiddenEffect) -> Vec<&'static dyn Effect> {
    let companions: &[&str] = match effect {
        // Wheels that yield to a shifted load also yield to an added one.
        HiddenEffect::TurnLoadTransfer => &["payload"],
        _ => &[],
    };
    core::iter::once(effect.id()).chain(companions.iter().copied()).filter_map(find).collect()
}

/// Effects that the plant of forces has as well where this one is hidden, by its own numbers or as a test of the simulator
/// shows: `explain` is right to name them. They are no part of the fit that knows the truth.
pub fn also_there(effect: HiddenEffect) -> &'static [&'static str] {
    match effect {
        // `apply` makes the track narrower, so that gentle arcs stay as they are.
        HiddenEffect::Scrub => &["track_width"],
        // It puts one wheel's contact point a centimetre ahead: the robot turns about a point off the axle's middle.
        HiddenEffect::TurnAsymmetry => &["marker_offset"],
        // In a spin the caster pushes creeping tyres aside: the robot turns about a point off the axle's middle.
        HiddenEffect::SideSlip => &["marker_offset"],
        _ => &[],
    }
}

/// The regressors on which an effect outside the catalogue depends by its physics, by the names of `explain`; any of
/// them is right.
pub fn regressors(effect: HiddenEffect) -> &'static [&'static str] {
    use HiddenEffect as E;
    match effect {
        // A force builds up along the path after each change of motion.
        E::RelaxationLength => &["distance since reversal", "acceleration", "turn rate"],
        // Above a torque: under acceleration, the more the heavier the robot is; now and then.
        E::SetScrewSlip => &["acceleration", "direction of travel", "time in the run", "load"],
        E::WetPatch | E::FloorBump | E::LensDistortion => &["place", "heading"],
        E::BentAxle | E::MagneticEncoder | E::GearRipple | E::FlatSpot => &["wheel angle"],
        // A force against the motion, whatever the speed: the turn depends on the travel and its sign.
        E::DraggingBrush => &["direction of travel", "turn rate", "speed"],
        E::StaleFrames => &["speed", "wheel speed", "turn rate", "time in the run"],
        E::StickyCaster => &["distance since reversal", "turn rate", "direction of travel"],
        // Side force: speed times turn rate.
        E::SoftSidewalls => &["turn rate", "speed", "wheel speed"],
        E::TetherPull => &["direction of travel", "heading", "speed"],
        _ => &[],
    }
}

/// True parameters of an effect, by the names of the model, where one of the plant's numbers is a parameter of the
/// model; not where it merely causes one.
pub fn true_parameters(effect: &str, scenario: &Scenario) -> Vec<(&'static str, f64)> {
    let share = radius_shares(scenario);
    let nominal = sim_target::plant::PlantParameters::default().geometry;
    let mean = (share.left + share.right) / 2.0;
    let (camera, gyro) = (&scenario.camera, scenario.gyro.unwrap_or_default());
    match effect {
        "wheel_radius_ratio" => vec![("rho", (share.right - share.left) / mean)],
        "wheel_radius_scale" => vec![("s", mean - 1.0)],
        "track_width" => {
            vec![("delta", scenario.plant.geometry.track_width_m / nominal.track_width_m - 1.0)]
        }
        "measurement_delay" => vec![("tau", camera.delay_s)],
        "marker_offset" => vec![("l_x", camera.marker.forward_m), ("l_y", camera.marker.left_m)],
        "speed_growth" => {
            // R (1 + g w^2) with w = v/R.
            let growth = scenario.plant.wheel.left.centrifugal_growth_s2;
            vec![("k", growth / nominal.wheel_radius_m.left.powi(2))]
        }
        "carpet_drift" => {
            let floor = &scenario.plant.floor;
            let (sin, cos) = floor.pile_direction_rad.sin_cos();
            vec![("d_x", floor.pile_drift * cos), ("d_y", floor.pile_drift * sin)]
        }
        "gyro_bias" => vec![("bias", gyro.bias_rad_s)],
        "gyro_scale" => vec![("k", gyro.scale)],
        _ => Vec::new(),
    }
}

/// Both wheels' true radius over the nominal one.
fn radius_shares(scenario: &Scenario) -> WheelPair<f64> {
    let nominal_m = PlantParameters::default().geometry.wheel_radius_m;
    scenario.plant.geometry.wheel_radius_m.zip(nominal_m).map(|(is, nominal)| is / nominal)
}
