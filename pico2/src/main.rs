//! A robot with a Raspberry Pi Pico 2: the firmware's library on another chip.
//!
//! It shows what a board has to bring: the traits of [`firmware::hal`], a link and a flash. It is built and has run
//! nowhere. What the STM32 boards have and this one has not: a stop line that acts without the program, a guard above
//! all tasks (the watchdog alone restarts a program that hangs, within half a second), and the supply's brown-out level.
//!
//! | line | pin |
//! | --- | --- |
//! | link, TX and RX | GP0, GP1 |
//! | left motor A, B, C | GP2, GP3, GP6 |
//! | right motor A, B, C | GP4, GP5, GP7 |
//! | enable, fault | GP8, GP9 |
//! | left encoder A, B | GP10, GP11 |
//! | right encoder A, B | GP12, GP13 |
//! | stop switch, to ground, closed while not pressed | GP15 |
//! | supply, 47 kohm to it and 10 kohm to ground | GP26 |
#![no_std]
#![no_main]

mod bridge;
mod encoders;
mod store;

use core::cell::RefCell;
use core::sync::atomic::Ordering;

use bridge::{Bridge, CONTROL_ALIVE, Wheel};
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_futures::join::join3;
use embassy_rp::adc::{self, Adc};
use embassy_rp::bind_interrupts;
use embassy_rp::flash::Flash;
use embassy_rp::gpio::{Flex, Input, Level, Output, Pull};
use embassy_rp::peripherals::{PIO0, UART0};
use embassy_rp::pio::{self, Pio};
use embassy_rp::pwm::{self, Pwm};
use embassy_rp::uart::{self, BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_rp::watchdog::Watchdog;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::{Duration, Ticker, Timer};
use encoders::PioEncoders;
use firmware::hal::{self, BoardInfo, ControlTimer, Supply, WaitPin};
use firmware::shared::Shared;
use firmware::store::FlashStore;
use firmware::task;
use firmware::units::CONTROL_HZ;
use shared_proto::{Name, ResetCause, WheelPair};
use static_cell::{ConstStaticCell, StaticCell};
use store::StoreFlash;

bind_interrupts!(struct Irqs {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
    UART0_IRQ => uart::BufferedInterruptHandler<UART0>;
});

/// A hang restarts the chip after this time; an erasure of the flash takes 0.4 s at most.
const WATCHDOG: Duration = Duration::from_millis(500);

type BoardShared = Shared<CriticalSectionRawMutex>;
static SHARED: StaticCell<BoardShared> = StaticCell::new();
static SEND: ConstStaticCell<[u8; 512]> = ConstStaticCell::new([0; 512]);
static RECEIVE: ConstStaticCell<[u8; 1024]> = ConstStaticCell::new([0; 1024]);

/// A tick of embassy's clock.
struct TickTimer(Ticker);

impl ControlTimer for TickTimer {
    async fn next(&mut self) {
        self.0.next().await;
    }
}

/// The supply behind its divider.
struct DividedSupply {
    adc: Adc<'static, adc::Blocking>,
    pin: adc::Channel<'static>,
}

impl Supply for DividedSupply {
    fn millivolts(&mut self) -> u16 {
        let sample = u32::from(self.adc.blocking_read(&mut self.pin).unwrap_or(0));
        (sample * (3300 * 57 / 10) / 4095) as u16
    }
}

/// An input that is looked at every 2 ms.
struct PolledInput {
    pin: Input<'static>,
    active: Level,
}

impl hal::Level for PolledInput {
    fn is_low(&self) -> bool {
        self.pin.get_level() == self.active
    }

    async fn wait_until(&self, low: bool) {
        while self.is_low() != low {
            Timer::after_millis(2).await;
        }
    }
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_rp::init(Default::default());
    let mut watchdog = Watchdog::new(p.WATCHDOG);
    let reset_cause =
        if watchdog.reset_reason().is_some() { ResetCause::Watchdog } else { ResetCause::PowerOn };
    watchdog.pause_on_debug(true);
    watchdog.start(WATCHDOG);

    let Pio { mut common, sm0, sm1, .. } = Pio::new(p.PIO0, Irqs);
    let program = encoders::program(&mut common);
    let left = encoders::start(&mut common, &program, sm0, p.PIN_10, p.PIN_11);
    let right = encoders::start(&mut common, &program, sm1, p.PIN_12, p.PIN_13);
    let encoders = PioEncoders::new(left, right);

    let low = pwm::Config::default;
    let wheels = WheelPair {
        left: Wheel {
            pwm: Pwm::new_output_ab(p.PWM_SLICE1, p.PIN_2, p.PIN_3, low()),
            c: Output::new(p.PIN_6, Level::Low),
        },
        right: Wheel {
            pwm: Pwm::new_output_ab(p.PWM_SLICE2, p.PIN_4, p.PIN_5, low()),
            c: Output::new(p.PIN_7, Level::Low),
        },
    };
    let bridge = Bridge::new(wheels, Flex::new(p.PIN_8));
    let supply = DividedSupply {
        adc: Adc::new_blocking(p.ADC, adc::Config::default()),
        pin: adc::Channel::new_pin(p.PIN_26, Pull::None),
    };
    // Opens when pressed: a cut wire stops the robot too.
    let stop = PolledInput { pin: Input::new(p.PIN_15, Pull::Up), active: Level::High };
    let fault = PolledInput { pin: Input::new(p.PIN_9, Pull::Up), active: Level::Low };

    let mut line = uart::Config::default();
    line.baudrate = 921_600;
    let link =
        BufferedUart::new(p.UART0, p.PIN_0, p.PIN_1, Irqs, SEND.take(), RECEIVE.take(), line);
    let (writer, reader) = link.split();

    let mut uid = [0; 12];
    uid[..8].copy_from_slice(&embassy_rp::otp::get_chipid().unwrap_or(0).to_be_bytes());
    let board = BoardInfo {
        board: Name::new("Pico 2").unwrap_or_default(),
        uid,
        reset_cause,
        // The store's count of starts has to do.
        random: None,
    };
    let store = FlashStore::new(StoreFlash(Flash::new_blocking(p.FLASH)));

    let shared = SHARED.init_with(Shared::new);
    let once = "a task is started once";
    spawner.spawn(control(shared, encoders, bridge, supply).expect(once));
    spawner.spawn(supervisor(shared, store, board).expect(once));
    spawner.spawn(link_tasks(shared, writer, reader).expect(once));
    spawner.spawn(safety_inputs(shared, stop, fault).expect(once));
    spawner.spawn(heartbeat(shared, watchdog).expect(once));
}

#[embassy_executor::task]
async fn control(
    shared: &'static BoardShared,
    encoders: PioEncoders,
    bridge: Bridge,
    supply: DividedSupply,
) {
    let timer = TickTimer(Ticker::every(Duration::from_hz(CONTROL_HZ.into())));
    let capture = task::capture::run(shared, timer, encoders);
    let profile = task::profile::run(shared);
    let pid = task::pid::run(shared, bridge, supply);
    join3(capture, profile, pid).await;
}

#[embassy_executor::task]
async fn supervisor(shared: &'static BoardShared, store: FlashStore<StoreFlash>, board: BoardInfo) {
    task::supervisor::run(shared, store, board).await;
}

#[embassy_executor::task]
async fn link_tasks(shared: &'static BoardShared, writer: BufferedUartTx, reader: BufferedUartRx) {
    let telemetry = task::telemetry::run(shared);
    join3(task::link::receive(shared, reader), task::link::transmit(shared, writer), telemetry)
        .await;
}

#[embassy_executor::task]
async fn safety_inputs(shared: &'static BoardShared, stop: PolledInput, fault: PolledInput) {
    let stop = task::safety_inputs::emergency_stop(shared, WaitPin(stop));
    embassy_futures::join::join(stop, task::safety_inputs::driver_fault(shared, fault)).await;
}

/// Feeds the watchdog while every safety task and the control tasks run.
#[embassy_executor::task]
async fn heartbeat(shared: &'static BoardShared, watchdog: Watchdog) {
    let watchdog = RefCell::new(watchdog);
    let feed = || {
        if CONTROL_ALIVE.swap(false, Ordering::Relaxed) {
            watchdog.borrow_mut().feed(WATCHDOG);
        }
    };
    task::heartbeat::run(shared, feed).await;
}

/// A restart leaves every pin floating: the resistor on the enable line holds the drivers off.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    defmt::error!("panic");
    cortex_m::peripheral::SCB::sys_reset()
}
