//! A simulated robot: the firmware's own tasks on the plant, in virtual time.

use core::cell::RefCell;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Wake, Waker};

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use firmware::hal::BoardInfo;
use firmware::shared::Shared;
use firmware::task;
use shared_proto::{Config, Name, ResetCause};

use crate::board::{ClockBeat, Flash, Hardware, Pin};
use crate::clock;
use crate::executor::Executor;
use crate::instruments::{
    Camera, CameraParameters, CameraSample, EndReading, Gyro, GyroSample, Ruler,
};
use crate::plant::{Plant, PlantFault, Pose};
use crate::scenario::{FaultEvent, Scenario, Setup};
use crate::uid::uid;
use crate::wire::Wire;

/// How to set a simulated robot up, beyond what its scenario says.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// A file that stands for the robot's flash; without one, nothing survives the simulation.
    pub flash: Option<PathBuf>,
    /// What the robot finds in its flash. Ignored if `flash` names a file that exists.
    pub config: Option<Config>,
}

/// A robot on this thread's virtual clock. One at a time per thread.
pub struct SimTarget {
    executor: Executor,
    lab: Lab,
    to_robot: Wire,
    to_host: Wire,
}

/// What surrounds the robot: the plant, what measures it, and what will go wrong.
pub(crate) struct World {
    plant: Plant,
    scenario: Scenario,
    /// How often the robot has been put on its line again.
    placements: u64,
    camera: Camera,
    camera_samples: Vec<CameraSample>,
    ruler: Ruler,
    gyro: Option<Gyro>,
    gyro_samples: Vec<GyroSample>,
    /// In order of time.
    schedule: Vec<Scheduled>,
    /// What waits for the motors to be driven for the first time.
    motion_faults: Vec<FaultEvent>,
    emergency_stop: Pin,
    driver_fault: Pin,
    stall_us: u64,
}

/// Something that happens to the robot at a known time.
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
    /// The surroundings of a robot that is switched on now.
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
        }
    }

    /// The plant as it is now, to the start of its present substep.
    ///
    /// Whoever asks between two substeps, because a command came in just then, does not cut one: where a
    /// drive's substeps lie would else depend on what the line lost before, and with them its last digits.
    pub(crate) fn plant_now(&mut self) -> &mut Plant {
        let now = clock::now_us();
        self.plant.advance_to(now - now % u64::from(self.plant.parameters().substep_us));
        &mut self.plant
    }

    /// Moves the plant alone, ahead of the clock.
    pub(crate) fn advance_plant_to(&mut self, t_us: u64) {
        self.plant.advance_to(t_us);
    }

    /// When something happens to the robot next \[us\].
    pub(crate) fn next_event_us(&self) -> u64 {
        let scheduled = self.schedule.first().map_or(u64::MAX, |event| event.at_us);
        let gyro = self.gyro.as_ref().map_or(u64::MAX, Gyro::next_t_us);
        scheduled.min(self.camera.next_t_us()).min(gyro)
    }

    /// Does what is due now.
    pub(crate) fn act(&mut self) {
        let now = clock::now_us();
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
            let seen = self.plant_seen();
            self.camera_samples.extend(self.camera.observe(&seen));
        }
        if self.gyro.as_ref().is_some_and(|gyro| gyro.next_t_us() <= now) {
            let seen = self.plant_seen();
            if let Some(gyro) = &mut self.gyro {
                self.gyro_samples.extend(gyro.observe(&seen));
            }
        }
    }

    /// The plant at this very moment, to be looked at: who looks between two substeps cuts none either.
    fn plant_seen(&mut self) -> Plant {
        let mut seen = self.plant_now().clone();
        seen.advance_to(clock::now_us());
        seen
    }

    fn set_fault(&mut self, fault: PlantFault, on: bool) {
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

/// The host's end of the serial line.
#[derive(Clone)]
pub struct HostWire {
    pub(crate) to_robot: Wire,
    pub(crate) to_host: Wire,
}

impl HostWire {
    /// Sends bytes to the robot.
    pub async fn write(&self, bytes: &[u8]) {
        self.to_robot.write(bytes).await;
    }

    /// Waits for bytes from the robot.
    pub async fn read(&self, buffer: &mut [u8]) -> usize {
        self.to_host.read(buffer).await
    }

    /// Sends bytes to the robot without waiting for room on the line.
    pub fn write_now(&self, bytes: &[u8]) {
        self.to_robot.write_now(bytes);
    }

    /// Takes the bytes that have come from the robot, without waiting.
    pub fn read_now(&self, buffer: &mut [u8]) -> usize {
        self.to_host.read_now(buffer)
    }

    /// Pulls the plug, or puts it back in.
    pub fn set_cut(&self, cut: bool) {
        self.to_robot.set_cut(cut);
        self.to_host.set_cut(cut);
    }
}

impl SimTarget {
    /// A robot at power-on. The thread's virtual clock starts at zero.
    ///
    /// # Errors
    /// If the file that stands for the flash cannot be read.
    ///
    /// # Panics
    /// If the thread has a simulated robot already.
    pub fn new(scenario: &Scenario, options: Options) -> std::io::Result<Self> {
        let flash = Flash::new(options.flash)?;
        if flash.content().is_none()
            && let Some(config) = &options.config
        {
            flash.put(config);
        }
        clock::claim();
        let emergency_stop = Pin::default();
        let driver_fault = Pin::default();
        let setup = scenario.set_up();
        let seed = setup.seed;
        let to_robot = Wire::new(setup.to_robot, seed ^ 0x746f_726f_626f_7400);
        let to_host = Wire::new(setup.to_host, seed ^ 0x746f_686f_7374_0000);
        let world = World::new(scenario, setup, emergency_stop.clone(), driver_fault.clone());
        let world = Rc::new(RefCell::new(world));

        let shared: Rc<Shared<NoopRawMutex>> = Rc::new(Shared::new());
        let board = BoardInfo {
            board: Name::new("simulator").unwrap_or_default(),
            uid: uid(scenario),
            reset_cause: ResetCause::PowerOn,
        };
        let hardware = Hardware(world.clone());
        let mut executor = Executor::new();
        let s = shared.clone();
        let h = hardware.clone();
        executor.spawn(async move { task::capture::run(&s, ClockBeat::new(), h).await });
        let s = shared.clone();
        executor.spawn(async move { task::profile::run(&s).await });
        let s = shared.clone();
        executor.spawn(async move { task::pid::run(&s, hardware.clone(), hardware).await });
        let s = shared.clone();
        executor.spawn(async move { task::telemetry::run(&s).await });
        let (s, wire) = (shared.clone(), to_host.clone());
        executor.spawn(async move { task::link::transmit(&s, wire).await });
        let (s, wire) = (shared.clone(), to_robot.clone());
        executor.spawn(async move { task::link::receive(&s, wire).await });
        let s = shared.clone();
        executor.spawn(async move { task::lines::emergency_stop(&s, emergency_stop).await });
        let s = shared.clone();
        executor.spawn(async move { task::lines::driver_fault(&s, driver_fault).await });
        let store = flash.clone();
        executor.spawn(async move { task::supervisor::run(&shared, store, board).await });

        Ok(Self { executor, lab: Lab { world, flash }, to_robot, to_host })
    }

    /// The host's end of the serial line.
    pub fn host_wire(&self) -> HostWire {
        HostWire { to_robot: self.to_robot.clone(), to_host: self.to_host.clone() }
    }

    /// The laboratory round the robot.
    pub fn lab(&self) -> Lab {
        self.lab.clone()
    }

    /// Runs robot and host together, as fast as it goes, until the host is done.
    ///
    /// The host may wait with [`sleep_until_us`] and on its [`HostWire`]; both follow the virtual clock.
    pub fn run<F: Future>(&mut self, host: F) -> F::Output {
        let mut host = pin!(host);
        let flag = Arc::new(Flag(AtomicBool::new(true)));
        let waker = Waker::from(flag.clone());
        loop {
            if flag.0.swap(false, Ordering::Relaxed)
                && let Poll::Ready(output) = host.as_mut().poll(&mut Context::from_waker(&waker))
            {
                return output;
            }
            self.executor.poll();
            if !flag.0.load(Ordering::Relaxed) {
                self.advance(u64::MAX);
            }
        }
    }

    /// Runs the robot alone until this time.
    pub fn run_until_us(&mut self, t_us: u64) {
        loop {
            self.executor.poll();
            if clock::now_us() >= t_us {
                return;
            }
            self.advance(t_us);
        }
    }

    /// Moves the clock to whatever comes next, at the latest to `limit_us`.
    fn advance(&mut self, limit_us: u64) {
        let mut world = self.lab.world.borrow_mut();
        let next =
            world.next_event_us().min(clock::next_alarm_us().unwrap_or(u64::MAX)).min(limit_us);
        let next = next.max(clock::now_us()) + core::mem::take(&mut world.stall_us);
        clock::advance_to(next);
        world.act();
    }
}

impl Drop for SimTarget {
    fn drop(&mut self) {
        // Laboratory and wires may outlive the robot; its tasks are freed below.
        self.to_robot.forget_reader();
        self.to_host.forget_reader();
        self.lab.world.borrow().emergency_stop.forget_waiter();
        self.lab.world.borrow().driver_fault.forget_waiter();
        clock::release();
    }
}

/// Waits until the virtual clock shows this time.
pub async fn sleep_until_us(t_us: u64) {
    embassy_time::Timer::at(embassy_time::Instant::from_micros(t_us)).await;
}

struct Flag(AtomicBool);

impl Wake for Flag {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}
