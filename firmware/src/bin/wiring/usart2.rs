//! The wiring of boards with a chip of 64 or 48 pins, whose link is USART2: they differ in the pins and the DMA of the
//! macro's call.

/// Defines the image's `main`.
macro_rules! robot {
    (
        left_encoder: $left_a:ident $left_b:ident,
        lines_c: $left_c:ident $right_c:ident,
        supply: $supply:ident channel $channel:literal,
        button: $button:ident $active:ident,
        led: $led:ident lit $lit:ident,
        transmit: $transmit:ident $transmit_irq:ident,
        receive: $receive:ident $receive_irq:ident $(,)?
    ) => {
        use defmt_rtt as _;
        use embassy_executor::Spawner;
        use embassy_stm32::gpio::{Level, Output, Speed};
        use embassy_stm32::interrupt;
        use embassy_stm32::usart::{self, Uart};
        use embassy_stm32::{bind_interrupts, dma, peripherals};
        use firmware::board::bridge::{Bridge, Pins};
        use firmware::board::control_timer::Tim2ControlTimer;
        use firmware::board::encoders::TimerEncoders;
        use firmware::board::flash::StoreFlash;
        use firmware::board::input::PolledInput;
        use firmware::board::leds::Leds;
        use firmware::board::power_on;
        use firmware::board::supply::{DividedSupply, Divider};
        use firmware::board::tasks::{self, LINK_BUFFER_LEN};
        use firmware::store::FlashStore;
        use static_cell::ConstStaticCell;

        bind_interrupts!(struct Irqs {
            USART2 => usart::InterruptHandler<peripherals::USART2>;
            $transmit_irq => dma::InterruptHandler<peripherals::$transmit>;
            $receive_irq => dma::InterruptHandler<peripherals::$receive>;
        });

        /// Received bytes: DMA writes them here until the link task reads them.
        static LINK: ConstStaticCell<[u8; LINK_BUFFER_LEN]> = ConstStaticCell::new([0; LINK_BUFFER_LEN]);

        #[embassy_executor::main]
        async fn main(spawner: Spawner) {
            let irqs = [interrupt::USART2, interrupt::$transmit_irq, interrupt::$receive_irq];
            let (p, reset_cause) = power_on::start(&irqs);

            let encoders = TimerEncoders::new((p.TIM3, p.$left_a, p.$left_b), (p.TIM4, p.PB6, p.PB7));
            let pins = Pins {
                left_a: p.PA8,
                left_b: p.PA9,
                left_c: p.$left_c,
                right_a: p.PA10,
                right_b: p.PA11,
                right_c: p.$right_c,
                enable: p.PB10,
                stop: p.PB12,
            };
            let (motors, stop_line) = Bridge::new(p.TIM1, pins);
            let divider = Divider { upper_ohm: 47_000, lower_ohm: 10_000 };
            let supply = DividedSupply::new(p.ADC1, p.$supply, $channel, divider);

            let stop = PolledInput::$active(p.$button);
            let driver_fault = PolledInput::active_low(p.PB5);
            let leds = Leds {
                green: Output::new(p.$led, Level::$lit, Speed::Low),
                blue: None,
                red: None,
                lit: Level::$lit,
            };
            let store = FlashStore::new(StoreFlash::new(p.FLASH));

            let mut line = usart::Config::default();
            line.baudrate = 921_600;
            let link = Uart::new(p.USART2, p.PA3, p.PA2, p.$transmit, p.$receive, Irqs, line)
                .expect("921600 baud divides the clock");
            let (transmitter, receiver) = link.split();

            let shared = tasks::shared();
            tasks::spawn_control(spawner, shared, Tim2ControlTimer::new(p.TIM2), encoders, motors, supply);
            tasks::spawn_safety_inputs(spawner, shared, stop, stop_line, driver_fault);
            tasks::spawn_link(spawner, shared, transmitter, receiver.into_ring_buffered(LINK.take()));
            tasks::spawn_others(spawner, shared, store, reset_cause, leds);
        }
    };
}
