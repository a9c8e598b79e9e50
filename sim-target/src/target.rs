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
use firmware::hal::{BoardInfo, WaitPin};
use firmware::shared::Shared;
use firmware::store::FlashStore;
use firmware::task;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Config, Key, Name, ResetCause};

use crate::clock;
use crate::executor::Executor;
use crate::flash::Flash;
use crate::guard::{Guard, GuardedTask};
use crate::hardware::{Hardware, VirtualControlTimer};
use crate::nor::Nor;
use crate::pin::Pin;
use crate::robot_task::{RobotTask, StoppedTasks};
use crate::scenario::Scenario;
use crate::testbed::Testbed;
use crate::uid::uid;
use crate::wire::{HostWire, Wire};
use crate::world::World;

/// A simulated robot's flash, which no scenario describes.
#[derive(Clone, Default)]
pub struct Options {
    /// A file for the flash's content; without one, nothing survives the simulation.
    pub flash: Option<PathBuf>,
    /// The configuration in the flash. Ignored if `flash` names a file that exists.
    pub config: Option<Config>,
    /// Only its holders may talk to the robot, whatever key the flash holds.
    pub key: Option<Key>,
    /// No host may set or clear the key.
    pub key_locked: bool,
    /// The board's own store, on this flash, in place of one that writes all at once: nothing of the above then.
    pub nor: Option<Nor>,
    /// Seeds the robot's source of random numbers; without one, the robot has none.
    pub random: Option<[u8; 32]>,
}

/// A robot on this thread's virtual clock. One at a time per thread.
pub struct SimTarget {
    /// None only while the robot restarts.
    executor: Option<Executor>,
    board: BoardInfo,
    random: Option<ChaCha8Rng>,
    nor: Option<Nor>,
    testbed: Testbed,
    to_robot: Wire,
    to_host: Wire,
}

impl SimTarget {
    /// A robot at power-on. The thread's virtual clock starts at zero.
    ///
    /// # Errors
    /// If the flash's file cannot be read.
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
        flash.lend_key(options.key);
        flash.lock_key(options.key_locked);
        clock::claim();
        let setup = scenario.set_up();
        let seed = setup.seed;
        let to_robot = Wire::to_board(setup.to_robot, seed ^ 0x746f_726f_626f_7400);
        let to_host = Wire::new(setup.to_host, seed ^ 0x746f_686f_7374_0000);
        let world = World::new(scenario, setup, Pin::default(), Pin::default());
        let world = Rc::new(RefCell::new(world));
        let board = BoardInfo {
            board: Name::new("simulator").unwrap_or_default(),
            uid: uid(scenario),
            reset_cause: ResetCause::PowerOn,
            random: None,
        };
        let random = options.random.map(ChaCha8Rng::from_seed);
        let testbed = Testbed { world, flash, stopped: StoppedTasks::default() };
        let nor = options.nor;
        let mut target = Self { executor: None, board, random, nor, testbed, to_robot, to_host };
        target.boot();
        Ok(target)
    }

    /// Starts guard and tasks.
    fn boot(&mut self) {
        self.board.random = self.random.as_mut().map(|random| random.random());
        let world = self.testbed.world.clone();
        world.borrow_mut().guard = Some(Guard::new(clock::now_us()));
        let shared: SimShared = Rc::new(Shared::new());
        let mut executor = Executor::new(self.testbed.stopped.clone());
        Self::spawn_control(&mut executor, &shared, Hardware(world.clone()));
        self.spawn_others(&mut executor, &shared);
        self.executor = Some(executor);
    }

    fn spawn_control(executor: &mut Executor, shared: &SimShared, hardware: Hardware) {
        let (s, h) = (shared.clone(), hardware.clone());
        executor.spawn(RobotTask::Capture, async move {
            task::capture::run(&s, VirtualControlTimer::new(), h).await
        });
        let s = shared.clone();
        executor.spawn(RobotTask::Profile, async move { task::profile::run(&s).await });
        let s = shared.clone();
        executor.spawn(RobotTask::Pid, async move {
            task::pid::run(&s, hardware.clone(), hardware).await
        });
    }

    fn spawn_others(&self, executor: &mut Executor, shared: &SimShared) {
        let s = shared.clone();
        executor.spawn(RobotTask::Telemetry, async move { task::telemetry::run(&s).await });
        let (s, wire) = (shared.clone(), self.to_host.clone());
        executor.spawn(RobotTask::Transmit, async move { task::link::transmit(&s, wire).await });
        let (s, wire) = (shared.clone(), self.to_robot.clone());
        executor.spawn(RobotTask::Receive, async move { task::link::receive(&s, wire).await });
        let (stop, fault) = {
            let world = self.testbed.world.borrow();
            (WaitPin(world.emergency_stop.clone()), world.driver_fault.clone())
        };
        let s = shared.clone();
        executor.spawn(RobotTask::EmergencyStop, async move {
            task::safety_inputs::emergency_stop(&s, stop).await
        });
        let s = shared.clone();
        executor.spawn(RobotTask::DriverFault, async move {
            task::safety_inputs::driver_fault(&s, fault).await
        });
        let (s, flash, board) = (shared.clone(), self.testbed.flash.clone(), self.board.clone());
        match self.nor.clone() {
            None => executor.spawn(RobotTask::Supervisor, async move {
                task::supervisor::run(&s, flash, board).await
            }),
            Some(nor) => executor.spawn(RobotTask::Supervisor, async move {
                task::supervisor::run(&s, FlashStore::new(nor), board).await
            }),
        }
        let (s, world) = (shared.clone(), self.testbed.world.clone());
        executor.spawn(RobotTask::Heartbeat, async move {
            task::heartbeat::run(&s, || world.borrow_mut().check_in(GuardedTask::Others)).await
        });
    }

    /// Whether only holders of a key may talk to the robot.
    pub fn has_key(&self) -> bool {
        self.testbed.flash.has_key()
    }

    /// A restart by the watchdog, or after a power cut: the tasks end and begin again. The plant rolls on.
    fn restart(&mut self, cause: ResetCause) {
        self.end_tasks();
        if let Some(nor) = &self.nor {
            nor.tear();
        }
        self.testbed.stopped.clear();
        self.testbed.world.borrow_mut().restart = false;
        self.board.reset_cause = cause;
        self.boot();
    }

    /// Ends all tasks, and what would wake them.
    fn end_tasks(&mut self) {
        self.to_robot.forget_reader();
        self.to_host.forget_reader();
        self.testbed.world.borrow().emergency_stop.forget_waiter();
        self.testbed.world.borrow().driver_fault.forget_waiter();
        self.executor = None;
        clock::forget_alarms();
    }

    /// The host's end of the serial line.
    pub fn host_wire(&self) -> HostWire {
        HostWire { to_robot: self.to_robot.clone(), to_host: self.to_host.clone() }
    }

    /// The testbed round the robot.
    pub fn testbed(&self) -> Testbed {
        self.testbed.clone()
    }

    /// Runs robot and host together, as fast as possible, until the host is done.
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
            self.poll_tasks();
            if !flag.0.load(Ordering::Relaxed) && self.advance(u64::MAX) {
                // The restart has forgotten the host's alarms too: the host sets them again.
                flag.0.store(true, Ordering::Relaxed);
            }
        }
    }

    /// Runs the robot alone until this time.
    pub fn run_until_us(&mut self, t_us: u64) {
        loop {
            self.poll_tasks();
            if clock::now_us() >= t_us {
                return;
            }
            self.advance(t_us);
        }
    }

    fn poll_tasks(&mut self) {
        if let Some(executor) = &mut self.executor {
            executor.poll();
        }
    }

    /// Advances the clock to the next event or alarm, at most to `limit_us`; true if the robot restarted.
    fn advance(&mut self, limit_us: u64) -> bool {
        let mut world = self.testbed.world.borrow_mut();
        if core::mem::take(&mut world.power_cut) {
            world.plant_now().set_enabled(false);
            drop(world);
            self.restart(ResetCause::PowerOn);
            return true;
        }
        let next =
            world.next_event_us().min(clock::next_alarm_us().unwrap_or(u64::MAX)).min(limit_us);
        let next = next.max(clock::now_us()) + core::mem::take(&mut world.stall_us);
        clock::advance_to(next);
        world.act();
        let restart = world.restart;
        drop(world);
        if restart {
            self.restart(ResetCause::Watchdog);
        }
        restart
    }
}

impl Drop for SimTarget {
    fn drop(&mut self) {
        // Laboratory and wires may outlive the robot, but the tasks that wait for them end now.
        self.end_tasks();
        clock::release();
    }
}

/// What a simulated robot's tasks share.
type SimShared = Rc<Shared<NoopRawMutex>>;

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
