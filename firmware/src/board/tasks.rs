//! The tasks with concrete types, and the statics that they share.
//!
//! ```text
//! interrupt priority   what runs there
//! 0                    guard (SysTick)
//! 1                    embassy's clock (TIM5)
//! 2                    control: capture, profile, PID
//! 6                    link, flash: their interrupts only copy and wake
//! none                 supervisor, link, telemetry, inputs, lights
//! ```

use embassy_executor::{InterruptExecutor, SendSpawner, Spawner};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::mode::Async;
use embassy_stm32::usart::{RingBufferedUartRx, UartTx};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::{Duration, Ticker};
use shared_proto::{Name, ResetCause};

use super::bridge::Bridge;
use super::encoders::TimerEncoders;
use super::flash::StoreFlash;
use super::input::PolledInput;
use super::lamps::{self, Lamps};
use super::supply::DividedSupply;
use super::{NAME, guard};
use crate::hal::BoardInfo;
use crate::shared::Shared;
use crate::store::FlashStore;
use crate::task;

/// What the tasks share: 1.7 KiB. One robot, one static; critical sections, because the control tasks
/// interrupt the others.
pub static SHARED: Shared<CriticalSectionRawMutex> = Shared::new();

/// The executor of the control tasks; it runs in an interrupt that the chip has no use for.
pub static CONTROL: InterruptExecutor = InterruptExecutor::new();

/// Priority of the control tasks: above the link's interrupts, below the clock.
pub const CONTROL_PRIORITY: Priority = Priority::P2;

/// Priority of the interrupts that serve everything else.
pub const SERVICE_PRIORITY: Priority = Priority::P6;

/// Bytes of a UART's receive buffer: what comes in 5.5 ms at 921600 baud. DMA fills it: an interrupt a
/// byte would come too late whenever the control tick has the core for longer than a byte takes, 11 us.
pub const LINK_BUFFER_LEN: usize = 512;

/// Starts the three control tasks in this interrupt.
pub fn spawn_control(
    irq: embassy_stm32::interrupt::Interrupt,
    encoders: TimerEncoders,
    motors: Bridge,
    supply: DividedSupply,
) {
    irq.set_priority(CONTROL_PRIORITY);
    let spawner: SendSpawner = CONTROL.start(irq);
    spawner.spawn(once(capture(encoders)));
    spawner.spawn(once(profile()));
    spawner.spawn(once(pid(motors, supply)));
}

/// Starts what keeps the robot company.
pub fn spawn_others(
    spawner: Spawner,
    store: FlashStore<StoreFlash>,
    reset_cause: ResetCause,
    lamps: Lamps,
) {
    let board = BoardInfo {
        board: Name::new(NAME).unwrap_or_default(),
        uid: embassy_stm32::uid::uid(),
        reset_cause,
    };
    defmt::info!("{=str} {=str}, started by {}", NAME, env!("CARGO_PKG_VERSION"), reset_cause);
    spawner.spawn(once(supervisor(store, board)));
    spawner.spawn(once(telemetry()));
    spawner.spawn(once(show(lamps)));
    spawner.spawn(once(heartbeat()));
}

/// Starts the link on a UART.
pub fn spawn_link(
    spawner: Spawner,
    writer: UartTx<'static, Async>,
    reader: RingBufferedUartRx<'static>,
) {
    spawner.spawn(once(transmit(writer)));
    spawner.spawn(once(receive(reader)));
}

/// Starts the watch on the emergency stop and on the motor driver's fault output.
pub fn spawn_lines(spawner: Spawner, stop: PolledInput, fault: PolledInput) {
    spawner.spawn(once(emergency_stop(stop)));
    spawner.spawn(once(driver_fault(fault)));
}

/// Each task is started once: its storage is free.
fn once<T, E: core::fmt::Debug>(token: Result<T, E>) -> T {
    token.expect("a task is started once")
}

#[embassy_executor::task]
async fn capture(encoders: TimerEncoders) {
    task::capture::run(&SHARED, encoders).await;
}

#[embassy_executor::task]
async fn profile() {
    task::profile::run(&SHARED).await;
}

#[embassy_executor::task]
async fn pid(motors: Bridge, supply: DividedSupply) {
    task::pid::run(&SHARED, motors, supply).await;
}

#[embassy_executor::task]
async fn supervisor(store: FlashStore<StoreFlash>, board: BoardInfo) {
    task::supervisor::run(&SHARED, store, board).await;
}

#[embassy_executor::task]
async fn telemetry() {
    task::telemetry::run(&SHARED).await;
}

#[embassy_executor::task]
async fn receive(reader: RingBufferedUartRx<'static>) {
    task::link::receive(&SHARED, reader).await;
}

#[embassy_executor::task]
async fn transmit(writer: UartTx<'static, Async>) {
    task::link::transmit(&SHARED, writer).await;
}

#[embassy_executor::task]
async fn emergency_stop(pin: PolledInput) {
    task::lines::emergency_stop(&SHARED, pin).await;
}

#[embassy_executor::task]
async fn driver_fault(pin: PolledInput) {
    task::lines::driver_fault(&SHARED, pin).await;
}

#[embassy_executor::task]
async fn show(lamps: Lamps) {
    lamps::run(&SHARED, lamps).await;
}

/// Shows the guard that the executor of the other tasks gets round.
#[embassy_executor::task]
async fn heartbeat() {
    let mut ticker = Ticker::every(Duration::from_millis(5));
    loop {
        guard::alive(guard::Part::Others);
        ticker.next().await;
    }
}
