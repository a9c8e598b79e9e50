//! One run of the board, from power-on to power-off, together with the plant and a host.

use std::cell::RefCell;
use std::future::Future;
use std::sync::{Arc, Mutex};

use rigless::emulator::{self, Driver, HitKind, Host, Settled, Start, Stop};
use rigless::image::Image;
use rigless::session::Session as Machine;
use rigless::time::VirtualNanos;
use sim_target::{Chassis, Scenario, now_us};

use crate::board::{self, Nucleo};
use crate::bug::BugInjector;
use crate::by_function::{ByFunction, FunctionCost};
use crate::chip::{EarlyAccesses, RegisterAccess, Revision};
use crate::control_ticks::{TickRecorder, TickTimes};
use crate::cost::{Counter, TickCost};
use crate::flash_array::{self, Flash, FlashArray, Operation};
use crate::monitor::{Bench, BoardMonitor};
use crate::motor_driver::Wiring;
use crate::plant_and_host::PlantAndHost;
use crate::random::{self, Generator};
use crate::stack::{Stack, StackDepth};

/// How often plant and chip are synchronised \[us\]: a period of the PWM.
const STEP_US: u64 = 50;

/// What to emulate.
#[derive(Clone, Debug)]
pub struct Emulation {
    /// The image's ELF.
    pub image: std::path::PathBuf,
    /// The robot around the board.
    pub scenario: Scenario,
    /// The flash's content at power-on; blank if absent.
    pub flash: Option<Flash>,
    /// The flash's power fails before the operation (erasure, word) with this number, counted from 0.
    pub cut_before: Option<u64>,
    /// Count the instructions of every control tick.
    pub count: bool,
    /// Count the instructions of control ticks by function; slow.
    pub by_function: bool,
    /// The chip's silicon.
    pub revision: Revision,
    /// The motor driver.
    pub wiring: Wiring,
    /// The core has an MPU, as the chip has. The firmware guards its stack with it and does nothing else; without one
    /// that guard is missing, and the emulator takes a fifth less time.
    pub mpu: bool,
}

/// The results of a run.
#[derive(Debug)]
pub struct RunResult<T> {
    /// The procedure's result.
    pub found: T,
    /// The flash's content.
    pub flash: Flash,
    /// What each control tick cost, if they were counted.
    pub ticks: Vec<TickCost>,
    /// Erasures and programmed words.
    pub flash_operations: u64,
    /// The same operations, one by one; none after a power cut.
    pub flash_journal: Vec<Operation>,
    /// Instructions a tick by function, most first, if they were counted.
    pub functions: Vec<FunctionCost>,
    /// The first accesses of peripherals.
    pub early: Vec<RegisterAccess>,
    /// The times of each control tick.
    pub tick_times: Vec<TickTimes>,
    /// Instructions that the core has executed.
    pub instructions: u64,
    /// Duration of the run \[us\].
    pub lived_us: u64,
    /// Restarts during the run, by any cause.
    pub resets: usize,
    /// How deep the stack was.
    pub stack: StackDepth,
    /// Accesses that the emulator does not model, and wrong flash writes; there should be none.
    pub unexpected: Vec<String>,
}

impl Emulation {
    /// The usual board: blank flash, silicon and driver as most have them; nothing is counted, and there is no MPU.
    pub fn of(image: impl Into<std::path::PathBuf>, scenario: Scenario) -> Self {
        Self {
            image: image.into(),
            scenario,
            flash: None,
            cut_before: None,
            count: false,
            by_function: false,
            revision: crate::REVISION,
            wiring: Wiring::default(),
            mpu: false,
        }
    }

    /// Switches the board on, runs the procedure, and switches the board off.
    ///
    /// The procedure runs in virtual time, as against the simulator.
    pub fn run<T, F, P>(&self, procedure: P) -> Result<RunResult<T>, Box<dyn std::error::Error>>
    where
        T: Send + 'static,
        F: Future<Output = T> + 'static,
        P: FnOnce(Bench) -> F + Send + 'static,
    {
        let images = [Image::read(&self.image, None)?];
        // The first stop comes before the first instruction: the flash is there from power-on.
        let mut machine = Machine::new(
            Box::new(Nucleo::new(self.revision, self.wiring, self.mpu)?),
            0,
            VirtualNanos(1),
        )?;
        machine.watch(FlashArray::watch());
        machine.watch(board::PROGRAM);
        let found = Arc::new(Mutex::new(None));
        let (slot, scenario, wiring) = (found.clone(), self.scenario.clone(), self.wiring);
        let begin = Box::new(move || {
            let chassis = Chassis::new(&scenario);
            let monitor = BoardMonitor::default();
            let wire = chassis.host_wire();
            let session = sim_link::session(&wire, 1, "emulated");
            let bench =
                Bench { testbed: chassis.testbed(), session, wire, monitor: monitor.clone() };
            let host = Box::pin(async move {
                let output = procedure(bench).await;
                *slot.lock().expect("no holder has panicked") = Some(output);
            });
            PlantAndHost::new(chassis, wiring, monitor, host)
        });
        let mut array = FlashArray::new(self.flash.as_deref());
        array.cut_before = self.cut_before;
        let (counter, by_function) = self.counters(&mut machine)?;
        let lockstep = Lockstep {
            begin: Some(begin),
            array,
            counter,
            by_function,
            tick_recorder: TickRecorder::default(),
            early: EarlyAccesses::default(),
            generator: Generator::default(),
            bug_injector: BugInjector::new(&self.image)?,
            program_stores: 0,
            resets: 0,
            stack: Stack::of(&self.image)?,
            stack_depth: StackDepth::default(),
        };
        let ended = emulator::run(machine, &Start::new(&images), lockstep)?;
        let unexpected = unexpected(&ended.session, &ended.driver);
        let stop = ended.stop;
        let found = found.lock().expect("no holder has panicked").take();
        Ok(RunResult {
            found: found.ok_or("the core stopped before the procedure was over")?,
            flash: ended.driver.array.content(),
            ticks: ended.driver.counter.map_or_else(Vec::new, |counter| counter.ticks),
            flash_operations: ended.driver.array.operations,
            flash_journal: ended.driver.array.journal,
            functions: ended.driver.by_function.map_or_else(Vec::new, ByFunction::table),
            early: ended.driver.early.0,
            tick_times: ended.driver.tick_recorder.tick_times,
            instructions: stop.map_or(0, |stop| stop.instruction_count),
            lived_us: stop.map_or(0, |stop| stop.at.0 / 1000),
            resets: ended.session.resets().len(),
            stack: ended.driver.stack_depth,
            unexpected,
        })
    }

    /// What counts instructions, as far as it is asked for.
    fn counters(
        &self,
        machine: &mut Machine<Nucleo>,
    ) -> Result<Counters, Box<dyn std::error::Error>> {
        let mut counter = None;
        if self.count {
            let (new, watches) = Counter::new(&self.image)?;
            watches.into_iter().for_each(|watch| machine.watch(watch));
            counter = Some(new);
        }
        let mut by_function = None;
        if self.by_function {
            let (new, watches) = ByFunction::new(&self.image)?;
            watches.into_iter().for_each(|watch| machine.watch(watch));
            by_function = Some(new);
        }
        Ok((counter, by_function))
    }
}

/// Of tasks, and of functions.
type Counters = (Option<Counter>, Option<ByFunction>);

/// What the emulator could not model, and wrong writes to the flash.
fn unexpected(machine: &Machine<Nucleo>, lockstep: &Lockstep) -> Vec<String> {
    let mut unexpected: Vec<String> = Vec::new();
    unexpected.extend(machine.unmapped().iter().map(|access| format!("unmapped: {access:?}")));
    unexpected.extend(machine.refused().iter().map(|access| format!("refused: {access:?}")));
    // What is modelled here instead is none.
    let unimplemented =
        machine.unimplemented().iter().filter(|(_, access)| access.instance != random::INSTANCE);
    unexpected.extend(unimplemented.map(|access| format!("unimplemented: {access:?}")));
    if lockstep.array.overwritten > 0 {
        unexpected.push(format!("{} words programmed but not erased", lockstep.array.overwritten));
    }
    if lockstep.program_stores > 0 {
        unexpected.push(format!("{} stores into the program", lockstep.program_stores));
    }
    unexpected
}

thread_local! {
    static PLANT_AND_HOST: RefCell<Option<PlantAndHost>> = const { RefCell::new(None) };
}

/// Keeps the chip in step with plant and host.
struct Lockstep {
    begin: Option<Box<dyn FnOnce() -> PlantAndHost + Send>>,
    array: FlashArray,
    counter: Option<Counter>,
    by_function: Option<ByFunction>,
    tick_recorder: TickRecorder,
    early: EarlyAccesses,
    generator: Generator,
    bug_injector: BugInjector,
    /// Stores of the program into itself.
    program_stores: u64,
    /// Restarts that have been recorded.
    resets: usize,
    stack: Stack,
    stack_depth: StackDepth,
}

impl Driver<Nucleo> for Lockstep {
    fn on_settled(&mut self, machine: &mut Machine<Nucleo>, host: &mut dyn Host, settled: Settled) {
        if let Some(reset_us) = machine.resets().get(self.resets).map(|reset| reset.at.0 / 1000) {
            self.resets += 1;
            self.bug_injector.clean_up(host);
            machine.board_mut().show_revision();
            PLANT_AND_HOST.with_borrow(|slot| {
                if let Some(around) = slot {
                    let mut monitor = around.monitor.0.borrow_mut();
                    monitor.resets_us.push(reset_us);
                    monitor.lines.show_again();
                }
            });
        }
        match settled {
            Settled::Access { access, value } => {
                self.array.on_access(&access, host);
                self.tick_recorder.on_access(&access);
                self.early.on_access(&access, value);
                let fails = PLANT_AND_HOST.with_borrow(|slot| {
                    slot.as_ref().is_some_and(|around| around.monitor.0.borrow().random_fails)
                });
                self.generator.on_access(&access, value, fails, machine.board_mut());
                self.bug_injector.on_access(&access);
                if let Some(counter) = &mut self.counter {
                    counter.on_access(&access);
                }
            }
            Settled::Hit(hit) if hit.kind == HitKind::Write => {
                if hit.address >= flash_array::BASE {
                    self.array.on_store(hit.address, host);
                } else {
                    self.program_stores += 1;
                }
            }
            Settled::Hit(hit) => {
                if let Some(counter) = &mut self.counter {
                    counter.on_hit(&hit);
                }
                if let Some(by_function) = &mut self.by_function {
                    by_function.on_hit(&hit);
                }
            }
            _ => {}
        }
    }

    fn on_stop(
        &mut self,
        machine: &mut Machine<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        PLANT_AND_HOST.with_borrow_mut(|slot| {
            if let Some(begin) = self.begin.take() {
                *slot = Some(begin());
                self.array.show(host);
                self.stack.paint(host);
            }
            let around = slot.as_mut().expect("begun at the first stop");
            let clock_fails = around.monitor.0.borrow().clock_fails;
            around.meet(machine.board_mut(), stop.at);
            if clock_fails && machine.board_mut().watches_clock(stop.at) {
                self.bug_injector.raise_nmi(host);
            }
            if around.poll_host() {
                self.stack_depth = self.stack.depth(host);
                *slot = None;
                return None;
            }
            around.hand_over(machine.board_mut());
            self.bug_injector.on_stop(host);
            let mut outside = around.monitor.0.borrow_mut();
            for bug in std::mem::take(&mut outside.bugs) {
                self.bug_injector.plant(bug, host);
            }
            outside.flash_operations = self.array.operations;
            if let Some(flash) = outside.power_on.take() {
                self.array.put(&flash, host);
                board::forget_ram(host);
                self.stack.paint(host);
                outside.pull_reset = true;
            }
            if std::mem::take(&mut outside.pull_reset) {
                machine.reset_by_pin(stop.at, stop.instruction_count, host);
            }
            drop(outside);
            let next_us = around.chassis.next_us().clamp(now_us() + 1, now_us() + STEP_US);
            Some(VirtualNanos(next_us * 1000))
        })
    }
}
