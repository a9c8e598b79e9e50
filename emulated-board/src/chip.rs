//! What differs from chip to chip, and the inputs of a chip that no robot drives: the stop line, the crystal.

use rigless::device::Level;
use rigless::emulator::{Access, AccessKind};
use rigless::mcu::{Mcu, Operate};
use rigless::soc::Width;
use rigless::soc::stm32f427::generated::dbg::Register;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::time::VirtualNanos;

use crate::board::Nucleo;

/// A revision of the silicon, as the upper half of `DBGMCU_IDCODE` has it (RM0090, 38.6.1).
pub type Revision = u16;

/// The revision of a chip that is bought today.
pub const REVISION: Revision = 0x2003;

/// The lower half: an STM32F42x, and what ST's file has in the reserved bits.
const DEVICE: u64 = 0x6419;

/// Port E, in the emulator's order, and the stop line's pin on it.
const PORT_E: usize = 4;
const STOP_LINE: u8 = 15;

/// Clock control, and in it the clock security system.
const RCC_CR: u64 = 0x4002_3800;
const CSSON: u32 = 1 << 19;

/// Accesses of peripherals that are kept: those of the start.
const EARLY: usize = 20_000;

/// An access of a peripheral's register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegisterAccess {
    /// The register.
    pub address: u64,
    /// What was read or written.
    pub value: u64,
    /// It was written.
    pub written: bool,
}

/// The first accesses of a run.
#[derive(Debug, Default)]
pub(crate) struct EarlyAccesses(pub Vec<RegisterAccess>);

impl EarlyAccesses {
    /// `value`: what was read, or written. Of reads that repeat each other one is kept.
    pub fn on_access(&mut self, access: &Access, value: u64) {
        let written = access.kind == AccessKind::Write;
        let access = RegisterAccess { address: access.address, value, written };
        if self.0.len() < EARLY && (written || self.0.last() != Some(&access)) {
            self.0.push(access);
        }
    }
}

impl Nucleo {
    /// Makes the chip report its revision; a reset of the emulated part makes it forget.
    pub(crate) fn show_revision(&mut self) {
        let value = u64::from(self.revision) << 16 | DEVICE;
        let bus = self.mcu.bus_mut();
        let slot = bus.slot_of("DBG").expect("a chip has an ID code");
        bus.slot_mut(slot).registers_mut().set(Register::DbgmcuIdcode, value);
    }

    /// Opens or closes the stop line (PE15, TIM1's break input; pulled up).
    pub(crate) fn set_stop_line(&mut self, at: VirtualNanos, open: bool) {
        let level = if open { Level::High } else { Level::Low };
        self.mcu.drive_port(at, PORT_E, |port, registers, context| {
            let pin = Pin::new(STOP_LINE).expect("a port has sixteen pins");
            port.drive(pin, Some(level), registers, context);
        });
        self.mcu.drive_advanced_timer(at, 0, |timer, registers, context| {
            timer.drive_break(level, registers, context);
        });
    }

    /// The clock from outside stops. The interrupt that this raises is not emulated:
    /// [`BugInjector::raise_nmi`](crate::bug::BugInjector::raise_nmi) stands in for it.
    pub(crate) fn fail_clock(&mut self, at: VirtualNanos) {
        self.mcu.drive_clocks(at, |clocks, registers, context| {
            clocks.fail_hse(registers, context);
        });
    }

    /// Whether a clock that stops raises an interrupt: the clock security system is on (RM0090, 6.2.7).
    pub(crate) fn watches_clock(&mut self, at: VirtualNanos) -> bool {
        self.register(at, RCC_CR) & CSSON != 0
    }

    /// A register's content; reading has no effect.
    pub(crate) fn register(&mut self, at: VirtualNanos, address: u64) -> u32 {
        self.mcu.peek(at, address, Width::W32).expect("the chip has this register") as u32
    }
}
