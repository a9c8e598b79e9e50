//! The tasks with concrete types, and the statics that they share.
//!
//! ```text
//! interrupt priority   what runs there
//! 0                    guard (SysTick)
//! 2                    control: capture, profile, PID, in the interrupt of their timer (TIM2)
//! 6                    embassy's clock (TIM5), link: their interrupts only copy and wake
//! none                 supervisor, link, telemetry, safety inputs, LEDs
//! ```

use core::future::{pending, poll_fn};
use core::pin::pin;
use core::task::Poll;

use embassy_executor::Spawner;
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::mode::Async;
use embassy_stm32::usart::{RingBufferedUartRx, UartTx};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use shared_proto::{Name, ResetCause};
use static_cell::StaticCell;

use super::bridge::{Bridge, StopLine};
use super::control_timer::{self, Tim2ControlTimer};
use super::encoders::TimerEncoders;
use super::flash::StoreFlash;
use super::input::PolledInput;
use super::leds::{self, Leds};
use super::supply::DividedSupply;
use super::{NAME, check_in};
use crate::hal::{BoardInfo, WaitPin};
use crate::shared::Shared;
use crate::store::FlashStore;
use crate::task;

/// What the tasks share.
pub(super) type BoardShared = Shared<CriticalSectionRawMutex>;

/// What the tasks share: 3.5 KiB, one static for the one robot. Critical sections, because the control
/// tasks interrupt the others. Initialised at run time: a static initialiser would take 3.5 KiB of flash.
static SHARED: StaticCell<BoardShared> = StaticCell::new();

/// Initialises what the tasks share. Call once.
pub fn shared() -> &'static BoardShared {
    SHARED.init_with(Shared::new)
}

/// Priority of the control tasks: above the clock's and the link's interrupts.
pub const CONTROL_PRIORITY: Priority = Priority::P2;

/// Priority of the interrupts that serve everything else.
pub const SERVICE_PRIORITY: Priority = Priority::P6;

/// Length of the UART's receive buffer \[bytes\]: 5.5 ms at 921600 baud. DMA fills the buffer. An interrupt
/// for each byte would come too late, because a control tick takes longer than a byte (11 us).
pub const LINK_BUFFER_LEN: usize = 512;

/// Starts the three control tasks in the interrupt of their timer.
pub fn spawn_control(
    spawner: Spawner,
    shared: &'static BoardShared,
    timer: Tim2ControlTimer,
    encoders: TimerEncoders,
    motors: Bridge,
    supply: DividedSupply,
) {
    // Control does not use embassy's clock, so the clock's timer queue can wait.
    interrupt::TIM5.set_priority(SERVICE_PRIORITY);
    interrupt::TIM2.set_priority(CONTROL_PRIORITY);
    spawner.spawn(once(control(shared, timer, encoders, motors, supply)));
}

/// Starts the tasks beside control: supervisor, telemetry, LEDs.
pub fn spawn_others(
    spawner: Spawner,
    shared: &'static BoardShared,
    store: FlashStore<StoreFlash>,
    reset_cause: ResetCause,
    leds: Leds,
) {
    let board = BoardInfo {
        board: Name::new(NAME).unwrap_or_default(),
        uid: embassy_stm32::uid::uid(),
        reset_cause,
        random: super::random(),
    };
    defmt::info!("{=str} {=str}, started by {}", NAME, env!("CARGO_PKG_VERSION"), reset_cause);
    spawner.spawn(once(supervisor(shared, store, board)));
    spawner.spawn(once(telemetry(shared)));
    spawner.spawn(once(show(shared, leds)));
    spawner.spawn(once(heartbeat(shared)));
}

/// Starts the link on a UART.
pub fn spawn_link(
    spawner: Spawner,
    shared: &'static BoardShared,
    writer: UartTx<'static, Async>,
    reader: RingBufferedUartRx<'static>,
) {
    spawner.spawn(once(transmit(shared, writer)));
    spawner.spawn(once(receive(shared, reader)));
}

/// Starts the tasks that watch the emergency stop and the motor driver's fault output.
pub fn spawn_safety_inputs(
    spawner: Spawner,
    shared: &'static BoardShared,
    stop: PolledInput,
    line: StopLine,
    fault: PolledInput,
) {
    spawner.spawn(once(stop_line(shared, line)));
    spawner.spawn(once(emergency_stop(shared, stop)));
    spawner.spawn(once(driver_fault(shared, fault)));
}

/// Each task is started once, so its storage is free.
pub(super) fn once<T, E: core::fmt::Debug>(token: Result<T, E>) -> T {
    token.expect("a task is started once")
}

/// Holds the three control tasks and hands them to the timer's interrupt, which polls one after another.
#[embassy_executor::task]
async fn control(
    shared: &'static BoardShared,
    timer: Tim2ControlTimer,
    encoders: TimerEncoders,
    motors: Bridge,
    supply: DividedSupply,
) {
    let mut capture = pin!(task::capture::run(shared, timer, encoders));
    let mut profile = pin!(task::profile::run(shared));
    let mut pid = pin!(task::pid::run(shared, motors, supply));
    let tick = pin!(poll_fn(move |context| {
        let _ = capture.as_mut().poll(context);
        let _ = profile.as_mut().poll(context);
        let _ = pid.as_mut().poll(context);
        Poll::<()>::Pending
    }));
    // SAFETY: called once. A task's futures are in a static, this one never ends, and it polls none of them.
    unsafe { control_timer::run(tick) };
    pending().await
}

#[embassy_executor::task]
async fn supervisor(shared: &'static BoardShared, store: FlashStore<StoreFlash>, board: BoardInfo) {
    task::supervisor::run(shared, store, board).await;
}

#[embassy_executor::task]
async fn telemetry(shared: &'static BoardShared) {
    task::telemetry::run(shared).await;
}

#[embassy_executor::task]
async fn receive(shared: &'static BoardShared, reader: RingBufferedUartRx<'static>) {
    task::link::receive(shared, reader).await;
}

#[embassy_executor::task]
async fn transmit(shared: &'static BoardShared, writer: UartTx<'static, Async>) {
    task::link::transmit(shared, writer).await;
}

#[embassy_executor::task]
async fn emergency_stop(shared: &'static BoardShared, pin: PolledInput) {
    task::safety_inputs::emergency_stop(shared, WaitPin(pin)).await;
}

#[embassy_executor::task]
async fn stop_line(shared: &'static BoardShared, line: StopLine) {
    task::safety_inputs::stop_line(shared, WaitPin(line)).await;
}

#[embassy_executor::task]
async fn driver_fault(shared: &'static BoardShared, pin: PolledInput) {
    task::safety_inputs::driver_fault(shared, pin).await;
}

#[embassy_executor::task]
async fn show(shared: &'static BoardShared, leds: Leds) {
    leds::run(shared, leds).await;
}

/// Shows the guard that every safety task runs, and with them the executor of the tasks beside control.
#[embassy_executor::task]
async fn heartbeat(shared: &'static BoardShared) {
    task::heartbeat::run(shared, || check_in::alive(check_in::CheckedTask::Others)).await;
}
