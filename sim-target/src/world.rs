//! The physical world of a simulated robot: plant, instruments, and scheduled faults.

use crate::clock;
use crate::guard::{Guard, GuardedTask};
use crate::instruments::{Camera, CameraSample, Gyro, GyroSample, Ruler};
use crate::pin::Pin;
use crate::plant::{Plant, PlantFault};
use crate::scenario::{FaultEvent, Scenario, Setup};

/// A robot's body and everything around it.
pub(crate) struct World {
    plant: Plant,
    pub(crate) scenario: Scenario,
    /// How often the robot has been put on its start line again.
    pub(crate) placements: u64,
    pub(crate) camera: Camera,
    pub(crate) camera_samples: Vec<CameraSample>,
    pub(crate) ruler: Ruler,
    gyro: Option<Gyro>,
    pub(crate) gyro_samples: Vec<GyroSample>,
    /// Beginnings and ends of faults, in order of time.
    schedule: Vec<Scheduled>,
    /// Faults whose clock starts when the motors are driven for the first time.
    motion_faults: Vec<FaultEvent>,
    pub(crate) emergency_stop: Pin,
    pub(crate) driver_fault: Pin,
    /// How late the next control tick will be \[us\].
    pub(crate) stall_us: u64,
    /// The robot's guard; none if the controller runs elsewhere, or a test has taken the guard out.
    pub(crate) guard: Option<Guard>,
    /// The watchdog has restarted the controller, and its tasks must begin again.
    pub(crate) restart: bool,
    /// A test wants that.
    pub(crate) restart_asked: bool,
    /// The power has gone for a moment.
    pub(crate) power_cut: bool,
}

/// A fault that begins or ends at a known time.
#[derive(Clone, Copy, Debug)]
struct Scheduled {
    at_us: u64,
    fault: PlantFault,
    on: bool,
}

/// The beginnings and ends of faults, in order of time.
fn schedule(faults: &[FaultEvent], origin_us: u64) -> Vec<Scheduled> {
    let ends = faults.iter().filter_map(|event| {
        let at_us = origin_us + event.until_us?;
        Some(Scheduled { at_us, fault: event.fault, on: false })
    });
    let begins = faults.iter().map(|event| Scheduled {
        at_us: origin_us + event.at_us,
        fault: event.fault,
        on: true,
    });
    let mut schedule: Vec<_> = begins.chain(ends).collect();
    schedule.sort_by_key(|event| event.at_us);
    schedule
}

impl World {
    /// The world of a robot at power-on.
    pub(crate) fn new(
        scenario: &Scenario,
        setup: Setup,
        emergency_stop: Pin,
        driver_fault: Pin,
    ) -> Self {
        Self {
            plant: setup.plant,
            scenario: scenario.clone(),
            placements: 0,
            camera: setup.camera,
            camera_samples: Vec::new(),
            ruler: setup.ruler,
            gyro: setup.gyro,
            gyro_samples: Vec::new(),
            schedule: schedule(&setup.faults, 0),
            motion_faults: setup.motion_faults,
            emergency_stop,
            driver_fault,
            stall_us: 0,
            guard: None,
            restart: false,
            restart_asked: false,
            power_cut: false,
        }
    }

    /// The plant at the start of its present substep.
    ///
    /// A command that arrives between two substeps does not split one. Otherwise the substeps of a drive,
    /// and with them its last digits, would depend on which frames the line lost before.
    pub(crate) fn plant_now(&mut self) -> &mut Plant {
        let now = clock::now_us();
        self.plant.advance_to(now - now % u64::from(self.plant.parameters().substep_us));
        &mut self.plant
    }

    /// Advances the plant alone, ahead of the clock.
    pub(crate) fn advance_plant_to(&mut self, t_us: u64) {
        self.plant.advance_to(t_us);
    }

    /// When the next fault, picture or gyro reading is due \[us\].
    pub(crate) fn next_event_us(&self) -> u64 {
        let scheduled = self.schedule.first().map_or(u64::MAX, |event| event.at_us);
        let gyro = self.gyro.as_ref().map_or(u64::MAX, Gyro::next_t_us);
        let guard = self.guard.as_ref().map_or(u64::MAX, Guard::next_us);
        scheduled.min(self.camera.next_t_us()).min(gyro).min(guard)
    }

    /// Carries out what is due now: faults, pictures, gyro readings, the guard.
    pub(crate) fn act(&mut self) {
        let now = clock::now_us();
        self.act_guard(now);
        if !self.motion_faults.is_empty()
            && let Some(origin_us) = self.plant.first_driven_us()
        {
            let mut all = schedule(&std::mem::take(&mut self.motion_faults), origin_us);
            all.append(&mut self.schedule);
            all.sort_by_key(|event| event.at_us);
            self.schedule = all;
        }
        while let Some(&Scheduled { at_us, fault, on }) = self.schedule.first()
            && at_us <= now
        {
            self.schedule.remove(0);
            self.set_fault(fault, on);
        }
        if self.camera.next_t_us() <= now {
            let plant = self.plant_copy();
            self.camera_samples.extend(self.camera.observe(&plant));
        }
        if self.gyro.as_ref().is_some_and(|gyro| gyro.next_t_us() <= now) {
            let plant = self.plant_copy();
            if let Some(gyro) = &mut self.gyro {
                self.gyro_samples.extend(gyro.observe(&plant));
            }
        }
    }

    /// A task of the controller shows the guard that it runs.
    pub(crate) fn check_in(&mut self, task: GuardedTask) {
        if let Some(guard) = &mut self.guard {
            guard.alive(task);
        }
    }

    /// Lets the guard check. A tripped guard takes the motors off, and so does a restart.
    fn act_guard(&mut self, now_us: u64) {
        let Some(guard) = &mut self.guard else { return };
        if now_us < guard.next_us() {
            return;
        }
        self.restart = guard.act(now_us) || std::mem::take(&mut self.restart_asked);
        if guard.tripped() || self.restart {
            self.plant_now().set_enabled(false);
        }
    }

    /// A copy of the plant, advanced to this moment: an observation splits no substep either.
    fn plant_copy(&mut self) -> Plant {
        let mut plant = self.plant_now().clone();
        plant.advance_to(clock::now_us());
        plant
    }

    /// Injects or removes a fault, and sets the safety inputs.
    pub(crate) fn set_fault(&mut self, fault: PlantFault, on: bool) {
        let plant = self.plant_now();
        if on {
            plant.inject(fault);
        } else {
            plant.remove(fault);
        }
        let (stop, driver) = (plant.estop_line(), plant.driver_fault_line());
        self.emergency_stop.set_low(stop);
        self.driver_fault.set_low(driver);
    }
}
