//! What can happen to a board and its robot.

use shared_proto::{Driver, Wheel};

use crate::bug::{Effect, Place};
use crate::lines::{Line, LineFault};

/// Something that happens to a robot at one instant, and lasts until it is mended, unless it has an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// Nothing: the control.
    Nothing,
    /// An encoder's plug is out.
    EncoderUnplugged(Wheel),
    /// One of an encoder's lines is cut or shorted.
    EncoderLine(Wheel, LineFault),
    /// An encoder's A and B are exchanged.
    EncoderSwapped(Wheel),
    /// Interference on an encoder's lines \[counts/s\].
    EncoderNoise(Wheel, f64),
    /// The encoders' plugs are exchanged.
    EncodersExchanged,
    /// The motors' connectors are exchanged.
    MotorsExchanged,
    /// A motor's leads are exchanged.
    MotorReversed(Wheel),
    /// A motor's lead is off.
    MotorCut(Wheel),
    /// A hand holds a wheel.
    WheelBlocked(Wheel),
    /// Something locks a wheel.
    WheelJammed(Wheel),
    /// The motors' supply is off.
    SupplyCut,
    /// The motors' supply falls below its limit, by so much \[V\].
    SupplyLow(f64),
    /// The same for a moment \[V, ms\].
    SupplyDip(f64, u16),
    /// The motors' supply rises above its limit, by so much \[V\].
    SupplyHigh(f64),
    /// The motor driver switches off and says so.
    Driver,
    /// The motor driver is not the configured one, but this.
    WrongName(Driver),
    /// The stop button is pressed for so long \[ms\].
    StopButton(u16),
    /// The stop line opens, as by a cut cable.
    StopLine,
    /// The stop line opens for so long \[us\].
    StopLineBounce(u16),
    /// The link's cable is out.
    LinkCut,
    /// The robot hears nothing, and is heard.
    LinkToRobotCut,
    /// The host hears nothing, and is heard.
    LinkToHostCut,
    /// The host's program ends without a word.
    HostDies,
    /// The host's program renews no motion, and talks on.
    HostHangs,
    /// Noise on the line to the robot for so long \[ms\].
    Garbage(u16),
    /// One task of the firmware stops, and all else runs.
    TaskStops(&'static str),
    /// The core stands still for so long \[ms\], as under a debugger or while flash is erased, and the PWM goes on.
    CoreStands(u16),
    /// The program hangs, panics or faults at this place.
    Program(&'static str, Place, Effect),
    /// The external clock stops.
    ClockFails,
    /// The board's own power fails for a moment.
    PowerCut,
    /// The reset pin is pulled.
    ResetPin,
}

/// The tasks on which safety depends, beside control.
pub const SAFETY_TASKS: [&str; 6] =
    ["supervisor", "receive", "transmit", "emergency_stop", "driver_fault", "heartbeat"];

/// The others: without them the robot is as safe.
pub const OTHER_TASKS: [&str; 3] = ["stop_line", "telemetry", "show"];

/// Registers by which parts of the program are found: the stop button's, the left encoder's, a motor's, and the
/// clock's alarm, which is set with interrupts masked.
const BUTTON: Place = Place::Register(0x4002_0810);
const ENCODER: Place = Place::Register(0x4000_0424);
const PWM: Place = Place::Register(0x4001_003C);
const ALARM: Place = Place::Register(0x4000_0C38);

/// Where the program may go wrong, and how.
pub const PROGRAM: [FaultKind; 10] = [
    FaultKind::Program("task beside control hangs", BUTTON, Effect::Hang),
    FaultKind::Program("encoder capture hangs", ENCODER, Effect::Hang),
    FaultKind::Program("PID hangs", PWM, Effect::Hang),
    FaultKind::Program("link interrupt hangs", Place::Function("USART3"), Effect::Hang),
    FaultKind::Program("clock interrupt hangs", Place::Function("TIM5"), Effect::Hang),
    FaultKind::Program("guard hangs", Place::Function("SysTick"), Effect::Hang),
    FaultKind::Program("hang, interrupts masked", ALARM, Effect::Hang),
    FaultKind::Program("task beside control panics", BUTTON, Effect::Panic),
    FaultKind::Program("PID panics", PWM, Effect::Panic),
    FaultKind::Program("hard fault in PID", PWM, Effect::HardFault),
];

impl FaultKind {
    /// What a table of cases calls it; kinds that differ by numbers or the wheel alone have one name.
    pub fn name(self) -> String {
        match self {
            FaultKind::Nothing => "nothing",
            FaultKind::EncoderUnplugged(_) => "encoder unplugged",
            FaultKind::EncoderLine(_, LineFault::Stuck { line: Line::A, .. }) => {
                "encoder line A stuck"
            }
            FaultKind::EncoderLine(_, LineFault::Stuck { line: Line::B, .. }) => {
                "encoder line B stuck"
            }
            FaultKind::EncoderLine(_, LineFault::Floats(_)) => "encoder line floats",
            FaultKind::EncoderSwapped(_) => "encoder A, B swapped",
            FaultKind::EncoderNoise(..) => "encoder noisy",
            FaultKind::EncodersExchanged => "encoders exchanged",
            FaultKind::MotorsExchanged => "motors exchanged",
            FaultKind::MotorReversed(_) => "motor reversed",
            FaultKind::MotorCut(_) => "motor lead cut",
            FaultKind::WheelBlocked(_) => "wheel blocked by a hand",
            FaultKind::WheelJammed(_) => "wheel jammed",
            FaultKind::SupplyCut => "supply cut",
            FaultKind::SupplyLow(_) => "supply low",
            FaultKind::SupplyDip(..) => "supply dips shortly",
            FaultKind::SupplyHigh(_) => "supply high",
            FaultKind::Driver => "driver's fault line",
            FaultKind::WrongName(_) => "wrong driver.name",
            FaultKind::StopButton(_) => "stop button",
            FaultKind::StopLine => "stop line cut",
            FaultKind::StopLineBounce(_) => "stop line bounces",
            FaultKind::LinkCut => "link cut",
            FaultKind::LinkToRobotCut => "link to robot cut",
            FaultKind::LinkToHostCut => "link to host cut",
            FaultKind::HostDies => "host dies",
            FaultKind::HostHangs => "host hangs, still talks",
            FaultKind::Garbage(_) => "garbage on the link",
            FaultKind::TaskStops(task) => return format!("task stops: {task}"),
            FaultKind::CoreStands(ms) if ms <= CORE_STANDS_MS_MAX => "core stands, shortly",
            FaultKind::CoreStands(_) => "core stands, long",
            FaultKind::Program(what, ..) => what,
            FaultKind::ClockFails => "external clock stops",
            FaultKind::PowerCut => "power cut",
            FaultKind::ResetPin => "reset pin",
        }
        .into()
    }

    /// The same, or a plug that is out instead of interference: the pins show one count at a look, which is too slow for what
    /// no wheel with a fine encoder can turn.
    pub fn without_noise(self) -> Self {
        match self {
            FaultKind::EncoderNoise(wheel, _) => FaultKind::EncoderUnplugged(wheel),
            other => other,
        }
    }

    /// The wheel in question.
    pub fn wheel(self) -> Option<Wheel> {
        match self {
            FaultKind::EncoderUnplugged(w)
            | FaultKind::EncoderLine(w, _)
            | FaultKind::EncoderSwapped(w)
            | FaultKind::EncoderNoise(w, _)
            | FaultKind::MotorReversed(w)
            | FaultKind::MotorCut(w)
            | FaultKind::WheelBlocked(w)
            | FaultKind::WheelJammed(w) => Some(w),
            _ => None,
        }
    }

    /// Whether nothing shows it but a motor that is driven.
    pub fn shows_in_motion_only(self) -> bool {
        self.wheel().is_some()
            || matches!(
                self,
                FaultKind::EncodersExchanged
                    | FaultKind::MotorsExchanged
                    | FaultKind::WrongName(_)
                    | FaultKind::LinkCut
                    | FaultKind::LinkToRobotCut
                    | FaultKind::HostDies
                    | FaultKind::HostHangs
            )
    }

    /// Whether it changes what runs on the chip, so that something else may be seen later than by itself.
    pub fn is_of_the_program(self) -> bool {
        matches!(self, FaultKind::TaskStops(_) | FaultKind::CoreStands(_) | FaultKind::Program(..))
    }

    /// Whether nobody does this to an armed robot: plugs and leads are exchanged at the bench.
    pub fn is_miswired(self) -> bool {
        matches!(
            self,
            FaultKind::EncodersExchanged | FaultKind::MotorsExchanged | FaultKind::MotorReversed(_)
        )
    }

    /// Whether the program must have started: what it changes is not in RAM before.
    pub fn needs_tasks(self) -> bool {
        self.is_of_the_program()
    }
}

/// A core that stands this long is not restarted \[ms\]: the watchdog's 31 ms, less the 10 between two feeds.
pub const CORE_STANDS_MS_MAX: u16 = 20;
