//! The laboratory: measures a simulated robot, handles it, and breaks it.

use core::cell::RefCell;
use std::rc::Rc;

use crate::flash::Flash;
use crate::instruments::{CameraParameters, CameraSample, EndReading, GyroSample};
use crate::plant::{Plant, PlantFault, Pose};
use crate::world::World;

/// The laboratory round the robot: sees the truth, measures, breaks things.
#[derive(Clone)]
pub struct Lab {
    pub(crate) world: Rc<RefCell<World>>,
    pub(crate) flash: Flash,
}

impl Lab {
    /// Where the robot really is.
    pub fn pose(&self) -> Pose {
        self.world.borrow_mut().plant_now().pose()
    }

    /// Looks at the plant.
    pub fn plant<T>(&self, look: impl FnOnce(&Plant) -> T) -> T {
        look(self.world.borrow_mut().plant_now())
    }

    /// What the overhead camera has seen so far.
    pub fn camera_samples(&self) -> Vec<CameraSample> {
        self.world.borrow().camera_samples.clone()
    }

    /// How many samples the camera has taken so far.
    pub fn camera_len(&self) -> usize {
        self.world.borrow().camera_samples.len()
    }

    /// What the camera has seen since the sample with this number.
    pub fn camera_samples_from(&self, first: usize) -> Vec<CameraSample> {
        self.world.borrow().camera_samples[first..].to_vec()
    }

    /// Has the camera take its next picture at this time, and all others at its rate after it.
    pub fn trigger_camera(&self, t_us: u64) {
        self.world.borrow_mut().camera.trigger(t_us);
    }

    /// What the camera's data sheet says.
    pub fn camera_parameters(&self) -> CameraParameters {
        *self.world.borrow().camera.parameters()
    }

    /// What the gyro has read since the sample with this number; nothing if there is none.
    pub fn gyro_samples_from(&self, first: usize) -> Vec<GyroSample> {
        self.world.borrow().gyro_samples[first..].to_vec()
    }

    /// How often the gyro has been read so far.
    pub fn gyro_len(&self) -> usize {
        self.world.borrow().gyro_samples.len()
    }

    /// Puts another load on the robot \[kg\].
    pub fn set_payload(&self, payload_kg: f64) {
        self.world.borrow_mut().plant_now().set_payload(payload_kg);
    }

    /// Measures with the ruler how far the robot is along the start line, and off it.
    pub fn read_offset(&self) -> EndReading {
        let mut world = self.world.borrow_mut();
        let pose = world.plant_now().pose();
        world.ruler.read(Pose::default(), pose)
    }

    /// Standard deviation of one reading of the ruler \[m\].
    pub fn ruler_sigma_m(&self) -> f64 {
        self.world.borrow().ruler.parameters().sigma_m()
    }

    /// Picks the robot up and puts it on its start line, as well as the scenario's person can.
    ///
    /// The line is the x axis. The wheels stand still; the encoders count on.
    pub fn place_at_start(&self) {
        self.place_on(Pose::default());
    }

    /// Picks the robot up and puts it on a line that begins here, as well as the scenario's person can.
    pub fn place_on(&self, line: Pose) {
        let mut world = self.world.borrow_mut();
        world.placements += 1;
        let pose = world.scenario.placement(line, world.placements);
        let trails = world.scenario.placement.caster_trails;
        let plant = world.plant_now();
        plant.place(pose);
        if trails {
            plant.trail_caster();
        }
    }

    /// Breaks something, now.
    pub fn inject(&self, fault: PlantFault) {
        self.world.borrow_mut().set_fault(fault, true);
    }

    /// Mends it.
    pub fn mend(&self, fault: PlantFault) {
        self.world.borrow_mut().set_fault(fault, false);
    }

    /// Makes the next control tick late by this much: somebody held the CPU.
    pub fn stall_cpu(&self, delay_us: u64) {
        self.world.borrow_mut().stall_us = delay_us;
    }

    /// Makes the flash refuse to be written.
    pub fn write_protect_flash(&self, on: bool) {
        self.flash.set_write_protected(on);
    }

    /// What the flash holds, as TOML.
    pub fn flash_content(&self) -> Option<String> {
        self.flash.content()
    }
}
