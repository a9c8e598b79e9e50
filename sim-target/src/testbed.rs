//! The testbed: measures a simulated robot, handles it, and breaks it.

use core::cell::RefCell;
use std::rc::Rc;

use crate::flash::Flash;
use crate::instruments::{CameraParameters, CameraSample, EndReading, GyroSample};
use crate::plant::{Plant, PlantFault, Pose};
use crate::robot_task::{RobotTask, StoppedTasks};
use crate::world::World;

/// The testbed round the robot: knows the true pose, measures, and injects faults.
#[derive(Clone)]
pub struct Testbed {
    pub(crate) world: Rc<RefCell<World>>,
    pub(crate) flash: Flash,
    pub(crate) stopped: StoppedTasks,
}

impl Testbed {
    /// The robot's true pose.
    pub fn pose(&self) -> Pose {
        self.world.borrow_mut().plant_now().pose()
    }

    /// Reads something from the plant.
    pub fn plant<T>(&self, read: impl FnOnce(&Plant) -> T) -> T {
        read(self.world.borrow_mut().plant_now())
    }

    /// The overhead camera's samples so far.
    pub fn camera_samples(&self) -> Vec<CameraSample> {
        self.world.borrow().camera_samples.clone()
    }

    /// How many samples the camera has taken so far.
    pub fn camera_len(&self) -> usize {
        self.world.borrow().camera_samples.len()
    }

    /// The camera's samples from this number on.
    pub fn camera_samples_from(&self, first: usize) -> Vec<CameraSample> {
        self.world.borrow().camera_samples[first..].to_vec()
    }

    /// Makes the camera take its next picture at this time, and further ones at its rate.
    pub fn trigger_camera(&self, t_us: u64) {
        self.world.borrow_mut().camera.trigger(t_us);
    }

    /// The camera's parameters.
    pub fn camera_parameters(&self) -> CameraParameters {
        *self.world.borrow().camera.parameters()
    }

    /// The gyro's samples from this number on; none without a gyro.
    pub fn gyro_samples_from(&self, first: usize) -> Vec<GyroSample> {
        self.world.borrow().gyro_samples[first..].to_vec()
    }

    /// How many samples the gyro has taken so far.
    pub fn gyro_len(&self) -> usize {
        self.world.borrow().gyro_samples.len()
    }

    /// Puts another load on the robot \[kg\].
    pub fn set_payload(&self, payload_kg: f64) {
        self.world.borrow_mut().plant_now().set_payload(payload_kg);
    }

    /// Measures with the ruler the robot's distance along the start line and across.
    pub fn read_offset(&self) -> EndReading {
        let mut world = self.world.borrow_mut();
        let pose = world.plant_now().pose();
        world.ruler.read(Pose::default(), pose)
    }

    /// Standard deviation of one reading of the ruler \[m\].
    pub fn ruler_sigma_m(&self) -> f64 {
        self.world.borrow().ruler.parameters().sigma_m()
    }

    /// Puts the robot on its start line, with the scenario's placement error.
    ///
    /// The line is the x axis. The wheels stand still; the encoders count on.
    pub fn place_at_start(&self) {
        self.place_on(Pose::default());
    }

    /// Puts the robot on a line that begins at this pose, with the scenario's placement error.
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

    /// Injects a fault, now.
    pub fn inject(&self, fault: PlantFault) {
        self.world.borrow_mut().set_fault(fault, true);
    }

    /// Removes a fault.
    pub fn mend(&self, fault: PlantFault) {
        self.world.borrow_mut().set_fault(fault, false);
    }

    /// Delays the next control tick by this much, as a stalled CPU does.
    pub fn stall_cpu(&self, delay_us: u64) {
        self.world.borrow_mut().stall_us = delay_us;
    }

    /// Stops one of the firmware's tasks alone, as a task that waits for what never comes. A simulated robot
    /// only: what runs on an emulated chip is stopped there.
    pub fn stop_task(&self, task: RobotTask) {
        self.stopped.stop(task);
    }

    /// Lets the stopped tasks run again, as if they had slept. They must be woken by something.
    pub fn resume_tasks(&self) {
        self.stopped.clear();
    }

    /// Takes the guard and its watchdog out of the robot, to see what the control tick does alone.
    pub fn remove_guard(&self) {
        self.world.borrow_mut().guard = None;
    }

    /// Restarts the robot's controller, as its watchdog does. The robot rolls on.
    pub fn restart_controller(&self) {
        self.world.borrow_mut().restart_asked = true;
    }

    /// Takes the power away at this very moment, and gives it back: in the middle of a write to the flash, too.
    pub fn cut_power(&self) {
        self.world.borrow_mut().power_cut = true;
    }

    /// Makes every write to the flash fail, or ends that.
    pub fn write_protect_flash(&self, on: bool) {
        self.flash.set_write_protected(on);
    }

    /// What the flash holds, as TOML.
    pub fn flash_content(&self) -> Option<String> {
        self.flash.content()
    }
}
