//! The board around the emulated chip: crystal, supply, serial line, and the wiring of the pins.

use std::num::{NonZeroU32, NonZeroU64};

use rigless::device::Level;
use rigless::emulator::{Host, Watch};
use rigless::machine::{Board, Crystal, Target, armv7m};
use rigless::mcu::{Bare, Mcu, Operate};
use rigless::snapshot::store;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::{adc, tim};
use rigless::soc::stm32f427::{CPU, Stm32f427};
use rigless::soc::{Bus, Error, Region, Width};
use rigless::time::VirtualNanos;
use shared_proto::{Wheel, WheelPair};

use crate::motor_driver::{BoardLines, WheelLines, Wiring};
use crate::translations;
use crate::uart_peer::UartPeer;

/// How long the emulated core takes for an instruction \[ns\].
pub const INSTRUCTION_NS: u64 = 8;

/// The core's clock \[Hz\].
const CLOCK_HZ: u64 = 168_000_000;

/// USART3, in the emulator's order of serial ports.
const USART3: usize = 2;

/// Ports, in the emulator's order.
const PORT_C: usize = 2;
const PORT_E: usize = 4;
const PORT_F: usize = 5;

/// The resistors before the converter's pin, as the board's wiring diagram has them.
const DIVIDER: f64 = 10.0 / (47.0 + 10.0);

/// The first bank, which holds the program.
pub(crate) const PROGRAM: Watch = Watch::Writes { address: 0x0800_0000, length: 1 << 20 };

/// The core's memory map. The first bank is writable, so that [`crate::bug`] can inject bugs; a store by the
/// program itself is reported. [`crate::flash_array`] models the second bank's first four sectors, where the
/// firmware keeps its configuration.
static MEMORY: [Region; 6] = [
    Region::ram("flash", 0x0800_0000, 1 << 20).erased_to(0xFF),
    Region::ram("store", crate::flash_array::BASE, crate::flash_array::LEN),
    Region::ram("ccm", 0x1000_0000, 64 << 10),
    Region::system("system", 0x1FFF_0000, 32 << 10),
    Region::ram("sram", 0x2000_0000, 192 << 10),
    Region::ram("backup_sram", 0x4002_4000, 4 << 10),
];

/// A NUCLEO-F429ZI with the wiring of `docs/boards.md`.
#[derive(Debug)]
pub struct Nucleo {
    pub(crate) mcu: Stm32f427,
    /// What the chip says that it is.
    pub(crate) revision: u16,
    /// Whether the core has its MPU.
    mpu: bool,
    /// Only the memory map.
    memory: Bare,
}

impl Nucleo {
    /// The board out of reset.
    pub fn new(revision: u16, wiring: Wiring, mpu: bool) -> Result<Self, Error> {
        let mut mcu = Stm32f427::new()?;
        // The ST-LINK's clock output.
        mcu.rcc.attach_crystals(8_000_000, Crystal::NONE.0);
        mcu.set_supply(3300);
        for converter in &mut mcu.adc {
            converter.set_reference(3300);
            converter.set_backup_battery(3300);
        }
        mcu.usart[USART3].attach(UartPeer::default());
        let memory = Bare::new(Bus::builder(CPU, &MEMORY, []))?;
        let mut board = Self { mcu, revision, mpu, memory };
        board.show_revision();
        board.set_stop_line(VirtualNanos(0), false);
        // Not asserted before the first instruction: the fault line is pulled up, the button down.
        board.set_safety_inputs(VirtualNanos(0), false, true, wiring.enable_inverted);
        Ok(board)
    }

    pub(crate) fn line(&mut self) -> &mut UartPeer {
        self.mcu.usart[USART3].chip_mut().expect("attached in `new`")
    }

    /// The lines to the motor drivers: TIM1's channels, PE10 and PE12, and PF15 for both.
    pub(crate) fn motor_lines(&mut self) -> BoardLines {
        let (port, registers) = self.mcu.port(PORT_F);
        let enable = port.level(pin(15), registers) == Level::High;
        let (port, registers) = self.mcu.port(PORT_E);
        let c = WheelPair { left: 10, right: 12 }
            .map(|number| port.level(pin(number), registers) == Level::High);
        let (timer, registers) = self.mcu.advanced_timer(0);
        let share = |channel| {
            let pulse = timer.pulse(channel_of(channel), registers);
            pulse.map_or(0.0, |pulse| pulse.width.0 as f64 / pulse.period.0 as f64)
        };
        let wheels = WheelPair {
            left: WheelLines { a: share(1), b: share(2), c: c.left },
            right: WheelLines { a: share(3), b: share(4), c: c.right },
        };
        BoardLines { wheels, enable }
    }

    /// The period of the PWM \[ns\]; `None` while the timer lets no pulse out.
    pub(crate) fn pwm_period_ns(&mut self) -> Option<u64> {
        let (timer, registers) = self.mcu.advanced_timer(0);
        timer.pulse(channel_of(1), registers).map(|pulse| pulse.period.0)
    }

    /// Puts the levels of an encoder's lines at a count on its timer's pins.
    pub(crate) fn turn_encoder(&mut self, at: VirtualNanos, wheel: Wheel, [a, b]: [Level; 2]) {
        let timer = match wheel {
            Wheel::Left => 1,
            Wheel::Right => 2,
        };
        self.mcu.drive_timer(at, timer, |timer, registers, context| {
            timer.drive_input(channel_of(1), a, registers, context);
            timer.drive_input(channel_of(2), b, registers, context);
        });
    }

    /// Applies the supply to the divider.
    pub(crate) fn set_supply_v(&mut self, supply_v: f64) {
        let channel = adc::Channel::new(3).expect("a pin's channel");
        self.mcu.adc[0].set_input(channel, (supply_v * DIVIDER * 1000.0).round().max(0.0) as u32);
    }

    /// Presses the button (PC13, high when pressed), sets the driver's fault line (PF14), and the resistor on the
    /// enable line.
    pub(crate) fn set_safety_inputs(
        &mut self,
        at: VirtualNanos,
        button: bool,
        fault_line_high: bool,
        enable_pull: bool,
    ) {
        let level = |high| Some(if high { Level::High } else { Level::Low });
        self.mcu.drive_port(at, PORT_C, |port, registers, context| {
            port.drive(pin(13), level(button), registers, context);
        });
        self.mcu.drive_port(at, PORT_F, |port, registers, context| {
            port.drive(pin(14), level(fault_line_high), registers, context);
            // The enable line's resistor; the chip's output overrides it.
            port.drive(pin(15), level(enable_pull), registers, context);
        });
    }
}

/// Overwrites RAM, as after a power-off: the first 64 KiB of 192, which hold stack and statics.
pub(crate) fn forget_ram(host: &mut dyn Host) {
    for address in (0x2000_0000..0x2001_0000).step_by(8) {
        host.write(address, Width::W64, 0xA5A5_A5A5_A5A5_A5A5).expect("it is memory");
    }
}

fn pin(number: u8) -> Pin {
    Pin::new(number).expect("a port has sixteen pins")
}

fn channel_of(number: u8) -> tim::Channel {
    tim::Channel::new(number).expect("a timer's channel")
}

store!(Nucleo { values: [revision, mpu], parts: [mcu], built: [memory] });

impl Board for Nucleo {
    fn name(&self) -> &'static str {
        "nucleo-f429zi"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec!["stm32f429zi"]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.mcu)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let lines = u32::from(Operate::cpu(&self.mcu).interrupt_lines);
        let mut core = armv7m::Core {
            variant: armv7m::Variant::M4,
            clock_hz: NonZeroU64::new(CLOCK_HZ).expect("a running clock"),
            interrupt_lines: NonZeroU32::new(lines).expect("a chip with interrupts"),
            // As in ST's PM0214 and RM0090.
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8).expect("a divider divides"),
            instructions_per_second: NonZeroU64::new(1_000_000_000 / INSTRUCTION_NS)
                .expect("a running core"),
            boot: "flash",
        }
        .spec_with_parts(
            &rigless::cpu::armv7m::windows(Mcu::bus(&self.mcu)),
            armv7m::Fpu::FpV4Sp,
            if self.mpu { armv7m::MpuRegions::Eight } else { armv7m::MpuRegions::None },
        );
        if !self.mpu {
            core.processor = translations::kept(core.processor);
        }
        vec![Target::new("stm32f429zi", &mut self.memory, core)]
    }
}
