//! From a scenario to the parts that a simulation starts from.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{FaultClock, Scenario};
use crate::instruments::{Camera, Gyro, Ruler};
use crate::plant::{Plant, PlantFault, Pose};
use crate::wire::WireParameters;

/// The parts of one simulation, each with random numbers of its own.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The robot on its start line, with the error of its first placement.
    pub plant: Plant,
    /// The robot's true start pose.
    pub start: Pose,
    /// The overhead camera.
    pub camera: Camera,
    /// The ruler.
    pub ruler: Ruler,
    /// The gyro, if there is one.
    pub gyro: Option<Gyro>,
    /// The line from host to robot.
    pub to_robot: WireParameters,
    /// The line from robot to host.
    pub to_host: WireParameters,
    /// Faults, in simulated time.
    pub faults: Vec<FaultEvent>,
    /// Faults, in time from [`Plant::first_driven_us`].
    pub motion_faults: Vec<FaultEvent>,
    /// The scenario's seed.
    pub seed: u64,
}

/// A fault and its times in microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultEvent {
    /// The fault.
    pub fault: PlantFault,
    /// When \[us\].
    pub at_us: u64,
    /// When the fault ends, if ever \[us\].
    pub until_us: Option<u64>,
}

/// The random streams that are drawn from the scenario's seed.
enum Stream {
    Plant = 1,
    Camera = 2,
    Ruler = 3,
    Placement = 4,
    Gyro = 5,
}

impl Scenario {
    /// Builds the robot and its surroundings.
    ///
    /// # Panics
    ///
    /// If the scenario does not pass [`validate`](Self::validate).
    pub fn set_up(&self) -> Setup {
        let start = self.placement(Pose::default(), 0);
        Setup {
            plant: Plant::new(self.plant.clone(), start, self.seed_of(Stream::Plant)),
            start,
            camera: Camera::new(self.camera, self.seed_of(Stream::Camera)),
            ruler: Ruler::new(self.ruler, self.seed_of(Stream::Ruler)),
            gyro: self.gyro.map(|gyro| Gyro::new(gyro, self.seed_of(Stream::Gyro))),
            to_robot: self.link.to_robot(),
            to_host: self.link.to_host(),
            faults: self.events(FaultClock::Simulated),
            motion_faults: self.events(FaultClock::Motion),
            seed: self.seed,
        }
    }

    /// The true pose after putting the robot on a line for the `run`-th time, counted from 0.
    pub fn placement(&self, line: Pose, run: u64) -> Pose {
        self.placement.place(line, self.seed_of(Stream::Placement), run)
    }

    fn seed_of(&self, stream: Stream) -> u64 {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream as u64);
        rng.next_u64()
    }

    fn events(&self, clock: FaultClock) -> Vec<FaultEvent> {
        let us = |s: f64| (s * 1e6).round() as u64;
        self.faults
            .iter()
            .filter(|fault| fault.clock == clock)
            .map(|scheduled| FaultEvent {
                fault: scheduled.fault,
                at_us: us(scheduled.at_s),
                until_us: scheduled.until_s.map(us),
            })
            .collect()
    }
}
