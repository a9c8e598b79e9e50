//! The wiring of a robot with a NUCLEO-F429ZI. See `docs/boards/nucleo-f429zi.md` for the connectors.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod wiring {
    use defmt_rtt as _;
    use embassy_executor::Spawner;
    use embassy_stm32::gpio::{AnyPin, Level, Output, Speed};
    use embassy_stm32::interrupt;
    #[cfg(not(feature = "usb"))]
    use embassy_stm32::usart::{self, Uart};
    use embassy_stm32::{Peri, bind_interrupts};
    #[cfg(not(feature = "usb"))]
    use embassy_stm32::{dma, peripherals};
    use firmware::board::bridge::{Bridge, Pins};
    use firmware::board::control_timer::Tim2ControlTimer;
    use firmware::board::encoders::TimerEncoders;
    use firmware::board::flash::StoreFlash;
    use firmware::board::input::PolledInput;
    use firmware::board::leds::Leds;
    use firmware::board::power_on;
    use firmware::board::supply::{DividedSupply, Divider};
    use firmware::board::tasks;
    #[cfg(not(feature = "usb"))]
    use firmware::board::tasks::LINK_BUFFER_LEN;
    use firmware::store::FlashStore;
    #[cfg(not(feature = "usb"))]
    use static_cell::ConstStaticCell;

    #[cfg(feature = "usb")]
    bind_interrupts!(struct Irqs {
        OTG_FS => embassy_stm32::usb::InterruptHandler<embassy_stm32::peripherals::USB_OTG_FS>;
    });

    #[cfg(not(feature = "usb"))]
    bind_interrupts!(struct Irqs {
        USART3 => usart::InterruptHandler<peripherals::USART3>;
        DMA1_STREAM3 => dma::InterruptHandler<peripherals::DMA1_CH3>;
        DMA1_STREAM1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
    });

    /// Received bytes: DMA writes them here until the link task reads them.
    #[cfg(not(feature = "usb"))]
    static LINK: ConstStaticCell<[u8; LINK_BUFFER_LEN]> =
        ConstStaticCell::new([0; LINK_BUFFER_LEN]);

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        let (p, reset_cause) = power_on::start(&[
            interrupt::USART3,
            interrupt::DMA1_STREAM3,
            interrupt::DMA1_STREAM1,
            interrupt::OTG_FS,
        ]);

        let encoders = TimerEncoders::new((p.TIM3, p.PC6, p.PC7), (p.TIM4, p.PD12, p.PD13));
        let pins = Pins {
            left_a: p.PE9,
            left_b: p.PE11,
            left_c: p.PE10,
            right_a: p.PE13,
            right_b: p.PE14,
            right_c: p.PE12,
            enable: p.PF15,
            stop: p.PE15,
        };
        let (motors, stop_line) = Bridge::new(p.TIM1, pins);
        let divider = Divider { upper_ohm: 47_000, lower_ohm: 10_000 };
        let supply = DividedSupply::new(p.ADC1, p.PA3, 3, divider);

        let stop = PolledInput::active_high(p.PC13);
        let driver_fault = PolledInput::active_low(p.PF14);
        let led = |pin: Peri<'static, AnyPin>| Output::new(pin, Level::High, Speed::Low);
        let leds = Leds {
            green: led(p.PB0.into()),
            blue: Some(led(p.PB7.into())),
            red: Some(led(p.PB14.into())),
            lit: Level::High,
        };
        let store = FlashStore::new(StoreFlash::new(p.FLASH));

        let shared = tasks::shared();
        tasks::spawn_control(
            spawner,
            shared,
            Tim2ControlTimer::new(p.TIM2),
            encoders,
            motors,
            supply,
        );
        tasks::spawn_safety_inputs(spawner, shared, stop, stop_line, driver_fault);
        #[cfg(not(feature = "usb"))]
        {
            let mut line = usart::Config::default();
            line.baudrate = 921_600;
            let link = Uart::new(p.USART3, p.PD9, p.PD8, p.DMA1_CH3, p.DMA1_CH1, Irqs, line)
                .expect("921600 baud divides the clock");
            let (transmitter, receiver) = link.split();
            let receiver = receiver.into_ring_buffered(LINK.take());
            tasks::spawn_link(spawner, shared, transmitter, receiver);
        }
        #[cfg(feature = "usb")]
        firmware::board::usb::spawn(spawner, shared, p.USB_OTG_FS, Irqs, p.PA12, p.PA11);
        tasks::spawn_others(spawner, shared, store, reset_cause, leds);
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!(
        "this is a board's image: see `cargo xtask firmware`, or `cargo run --release` in firmware/"
    );
}
