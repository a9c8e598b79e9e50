//! Both wheels' encoders: a state machine of the PIO counts each, all four edges of a line.

use embassy_rp::Peri;
use embassy_rp::gpio::Pull;
use embassy_rp::peripherals::PIO0;
use embassy_rp::pio::program::pio_asm;
use embassy_rp::pio::{
    Common, Config, Direction, FifoJoin, LoadedProgram, PioPin, ShiftDirection, StateMachine,
};
use firmware::encoder::CounterExtender;
use firmware::hal::Encoders;
use fixed::traits::ToFixed;
use shared_proto::WheelPair;

/// Instructions a microsecond: a sample of the lines takes up to eleven of them.
const DIVIDER: u32 = 10;

/// Left on state machine 0, right on 1.
pub struct PioEncoders {
    left: StateMachine<'static, PIO0, 0>,
    right: StateMachine<'static, PIO0, 1>,
    extenders: WheelPair<CounterExtender>,
}

/// Loads the program, of which both state machines run a copy.
///
/// X holds the lines as they were, Y the count. The lines before and now are a number from 0 to 15, which is where
/// the program goes on: its first sixteen instructions tell a step up, a step down, and none (two lines that change
/// at once tell nothing). The count is offered after each sample; what nobody takes is dropped.
pub fn program(pio: &mut Common<'static, PIO0>) -> LoadedProgram<'static, PIO0> {
    let program = pio_asm!(
        ".origin 0",
        "jmp offer",
        "jmp up",
        "jmp down",
        "jmp offer",
        "jmp down",
        "jmp offer",
        "jmp offer",
        "jmp up",
        "jmp up",
        "jmp offer",
        "jmp offer",
        "jmp down",
        "jmp offer",
        "jmp down",
        "jmp up",
        "jmp offer",
        "up:",
        "mov y, ~y",
        "jmp y-- turned",
        "turned:",
        "mov y, ~y",
        "jmp offer",
        "down:",
        "jmp y-- offer",
        "offer:",
        "mov isr, y",
        "push noblock",
        ".wrap_target",
        "mov isr, null",
        "in x, 2",
        "in pins, 2",
        "mov x, isr",
        "mov pc, isr",
        ".wrap",
    );
    pio.load_program(&program.program)
}

/// Starts one state machine on two neighbouring pins, A the lower one. An open collector needs a resistor to 3.3 V.
pub fn start<const SM: usize>(
    pio: &mut Common<'static, PIO0>,
    program: &LoadedProgram<'static, PIO0>,
    mut machine: StateMachine<'static, PIO0, SM>,
    a: Peri<'static, impl PioPin>,
    b: Peri<'static, impl PioPin>,
) -> StateMachine<'static, PIO0, SM> {
    let (mut a, mut b) = (pio.make_pio_pin(a), pio.make_pio_pin(b));
    a.set_pull(Pull::None);
    b.set_pull(Pull::None);
    machine.set_pin_dirs(Direction::In, &[&a, &b]);
    let mut config = Config::default();
    config.use_program(program, &[]);
    config.set_in_pins(&[&a, &b]);
    config.shift_in.direction = ShiftDirection::Left;
    config.fifo_join = FifoJoin::RxOnly;
    config.clock_divider = (embassy_rp::clocks::clk_sys_freq() / 1_000_000 / DIVIDER).to_fixed();
    machine.set_config(&config);
    machine.set_enable(true);
    machine
}

impl PioEncoders {
    /// Both wheels, as started.
    pub fn new(
        mut left: StateMachine<'static, PIO0, 0>,
        mut right: StateMachine<'static, PIO0, 1>,
    ) -> Self {
        let now = WheelPair { left: count(&mut left), right: count(&mut right) };
        Self { left, right, extenders: now.map(CounterExtender::new) }
    }
}

/// The count of now: what was offered before is dropped, and the next offer comes within 2 us.
fn count<const SM: usize>(machine: &mut StateMachine<'static, PIO0, SM>) -> u16 {
    let offers = machine.rx();
    while offers.try_pull().is_some() {}
    loop {
        if let Some(count) = offers.try_pull() {
            return count as u16;
        }
    }
}

impl Encoders for PioEncoders {
    fn counts(&mut self) -> WheelPair<i64> {
        let now = WheelPair { left: count(&mut self.left), right: count(&mut self.right) };
        self.extenders.as_mut().zip(now).map(|(extender, count)| extender.extend(count))
    }
}
