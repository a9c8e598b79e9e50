//! What is promised for whatever happens: how soon the motors are off, and what it is called. One table,
//! `Promise::table`.

use shared_proto::{Fault, ResetCause, Wheel};

use super::bound::{MotorsOff, Name};
use super::draw::{Case, Phase};
use super::fault_instant::{FaultInstant, Situation};
use super::fault_kind::{CORE_STANDS_MS_MAX, FaultKind};

/// What is promised.
#[derive(Clone, Debug)]
pub struct Promise {
    /// How soon the motors are off.
    pub bound: MotorsOff,
    /// What it may be called.
    pub names: Vec<Name>,
    /// What it may be called besides if a restart forgets the fault that was latched before it.
    pub after_a_restart: Vec<Name>,
}

/// Wheels, encoders and motors at a moving setpoint \[ms\] (docs/safety.md).
const PROTECTION_MS: f64 = 100.0;
/// A wheel without current rolls out first \[ms\] (docs/safety.md, at the paper's cruise).
const ROLL_OUT_MS: f64 = 250.0;
/// Deceleration without current, of the robot with the least friction and the largest load \[m/s^2\].
const COASTS_MPS2: f64 = 0.2;
/// From a higher speed it rolls until it is 20 mm from its setpoint: sqrt(2 x 0.02 / 0.2) \[ms\].
const ROLL_FAR_MS: f64 = 450.0;
/// A wheel that stands off its target is named after two stall times; and a look at it \[ms\].
const STANDS_MS: f64 = 130.0;
const PAPERS_CRUISE_MPS: f64 = 0.12;
/// Both wheels' encoder checks, with a push to the end of each: half of ks to the largest duty in 0.8 s, held for
/// 7 stall times of 60 ms, 40 ticks to roll; and a start time of 250 ms that is waited for \[ms\].
const CHECK_MS: f64 = 2.0 * (800.0 + 420.0 + 40.0) + 250.0;
/// Six counts longer than this are more than a centimetre \[m\].
const LONG_COUNT_M: f64 = 1.7e-3;
/// An input is read every 2 ms, and acted on at the next tick; the rest is for the task to get its turn \[ms\].
const INPUT_MS: f64 = 5.0;
/// The timer itself; the pins are looked at every 0.05 ms \[ms\].
const HARDWARE_MS: f64 = 0.1;
/// 20 ticks below the limit, a conversion, a tick, and the wires' voltage \[ms\].
const SUPPLY_LOW_MS: f64 = 25.0;
/// A conversion, a tick, and the wires' voltage: so old is the supply that arming looks at \[ms\].
const SUPPLY_READ_MS: f64 = 5.0;
/// As for a low supply, for 4 ticks above its limit \[ms\].
const SUPPLY_HIGH_MS: f64 = 10.0;
/// The host's last word, at most 30 ms before, and the silence of 200 ms that is permitted; then the ramp, and 250 ms
/// in which the wheels may settle \[ms\].
const SILENCE_MS: f64 = 250.0;
const SETTLE_MS: f64 = 270.0;
/// Deceleration of a controlled stop \[m/s^2\].
const STOP_MPS2: f64 = 0.5;
/// A safety task's last sign of life reaches the guard up to 15 ms after it stopped; the guard then misses it for
/// 40 ms, and looks every 10 \[ms\].
const TASK_STOPS_MS: f64 = 65.0;
/// The heartbeat's task is put to sleep within 5 ms, and the core then stands: from the watchdog's last feed 31 ms.
const CORE_RESTARTS_MS: f64 = 45.0;

impl Promise {
    /// What is promised at this instant.
    pub(super) fn of(kind: FaultKind, case: &Case, instant: &FaultInstant) -> Self {
        let (bound, names) = Self::table(kind, case, instant);
        let mut promise = Self { bound, names, after_a_restart: Vec::new() };
        if instant.situation == Situation::Latched {
            promise.while_latched();
        }
        promise
    }

    /// The table.
    fn table(kind: FaultKind, case: &Case, instant: &FaultInstant) -> (MotorsOff, Vec<Name>) {
        use FaultKind as K;
        let fault = |fault| vec![Name::Fault(fault)];
        let restart = |cause| vec![Name::Restart(cause)];
        let harmless = (MotorsOff::NotNeeded, vec![Name::Harmless]);
        match kind {
            K::Nothing | K::Garbage(_) | K::LinkToHostCut => harmless,
            K::EncoderUnplugged(w) | K::EncoderLine(w, _) => {
                instant.of_wheel(PROTECTION_MS, blind, dead(w, instant))
            }
            K::EncoderSwapped(w) | K::MotorReversed(w) => {
                instant.of_wheel(PROTECTION_MS, blind, reversed(w, case))
            }
            // Every tick of a check or a motion tells.
            K::EncoderNoise(w, _) => {
                instant.of_wheel(PROTECTION_MS, blind, fault(Fault::CountRate(w)))
            }
            // The left wheel is pushed first. Electrically both are the same.
            K::EncodersExchanged | K::MotorsExchanged => {
                instant.of_wheel(PROTECTION_MS, blind, fault(Fault::EncodersExchanged(Wheel::Left)))
            }
            K::WrongName(_) => instant.of_wheel(PROTECTION_MS, blind, wrong_name()),
            K::MotorCut(w) => lead_cut(w, case, instant),
            K::WheelBlocked(w) | K::WheelJammed(w) => {
                // Stopped within a few counts: not to be told from a dead wire in time.
                let names = stands(w, &[Fault::Stall(w), Fault::EncoderDead(w)], instant);
                instant.of_wheel(PROTECTION_MS, pushed, names)
            }
            K::SupplyCut | K::SupplyLow(_) | K::SupplyDip(..) | K::SupplyHigh(_) => {
                of_supply(kind, case, instant)
            }
            K::Driver => (MotorsOff::Within(INPUT_MS), fault(Fault::Driver)),
            K::StopLine => (MotorsOff::Within(HARDWARE_MS), fault(Fault::EmergencyStop)),
            K::StopButton(ms) => stop(INPUT_MS, instant, ms.into()),
            K::StopLineBounce(us) => stop(HARDWARE_MS, instant, f64::from(us) / 1000.0),
            K::LinkCut | K::LinkToRobotCut | K::HostDies => {
                (silence(case), instant.if_host_is_needed(Fault::LinkLost))
            }
            K::HostHangs => (silence(case), instant.if_renewals_are_needed(Fault::TimeToLive)),
            K::TaskStops("stop_line" | "telemetry" | "show") => harmless,
            K::TaskStops(_) => (MotorsOff::Within(TASK_STOPS_MS), restart(ResetCause::Watchdog)),
            K::CoreStands(ms) if ms <= CORE_STANDS_MS_MAX => {
                // The task that makes the core stand runs within 5 ms, and a tick has to end.
                let bound = match instant.motors_are_off() {
                    true => MotorsOff::NotNeeded,
                    false => MotorsOff::Within(f64::from(ms) + 5.0 + 2.0),
                };
                (bound, instant.if_motors_are_on(Fault::DeadlineMissed))
            }
            K::CoreStands(_) => {
                (MotorsOff::Within(CORE_RESTARTS_MS), restart(ResetCause::Watchdog))
            }
            K::Program(what, ..) => program(what),
            K::ClockFails if instant.is_at_power_on() => clock_unseen(),
            // A host without an answer to its hello does not know of the restart, and drives.
            K::ClockFails if instant.is_before_the_host() => {
                (MotorsOff::NotNeeded, restart(ResetCause::Panic))
            }
            K::ClockFails => (MotorsOff::Within(HARDWARE_MS), restart(ResetCause::Panic)),
            // The emulator resets the chip by its pin. In the first millisecond the flag of power-on is not cleared yet.
            K::PowerCut | K::ResetPin if instant.is_before_the_host() => {
                let causes = [ResetCause::Pin, ResetCause::PowerOn];
                let told = if instant.is_at_power_on() { 2 } else { 1 };
                (MotorsOff::NotNeeded, causes[..told].iter().copied().map(Name::Restart).collect())
            }
            K::PowerCut | K::ResetPin => (MotorsOff::Within(HARDWARE_MS), restart(ResetCause::Pin)),
        }
    }

    /// The first fault keeps its name, and the motors are off; only a restart forgets it.
    fn while_latched(&mut self) {
        self.after_a_restart = self.names.clone();
        self.after_a_restart.retain(|name| matches!(name, Name::Fault(_)));
        self.names.retain(|name| matches!(name, Name::Restart(_)));
        if self.names.is_empty() {
            self.names.push(Name::Fault(Fault::EmergencyStop));
        }
    }
}

/// A bound by time where the setpoint moves, by the way where it does not yet.
fn blind(ms: f64, way_mm: Option<f64>) -> MotorsOff {
    way_mm.map_or(MotorsOff::Within(ms), |mm| MotorsOff::WithinOrTravel(ms, mm))
}

/// A wheel that does not turn: the check pushes to its end.
fn pushed(ms: f64, way_mm: Option<f64>) -> MotorsOff {
    MotorsOff::Within(if way_mm.is_none() { ms } else { ms.max(CHECK_MS) })
}

/// A count the wrong way. Of an encoder with counts as long as `config set` warns of, it may be known too late.
fn reversed(wheel: Wheel, case: &Case) -> Vec<Name> {
    let mut faults = vec![Fault::EncoderReversed(wheel)];
    if case.count_m() > LONG_COUNT_M {
        faults.push(Fault::FollowingError(wheel));
    }
    faults.into_iter().map(Name::Fault).collect()
}

/// A driver that takes the lines for something else: nothing, less or the opposite. Or for the same, or nearly: where it drives
/// between the pulses and brakes in them, the loop may not bring a wheel to its place.
fn wrong_name() -> Vec<Name> {
    let of_wheels = |fault: fn(Wheel) -> Fault| Wheel::BOTH.map(fault).map(Name::Fault);
    let faults = [Fault::EncoderReversed, Fault::NoResponse, Fault::Stall];
    let faults = faults.into_iter().flat_map(of_wheels);
    faults.chain([Name::Fault(Fault::Driver), Name::Harmless]).collect()
}

/// A count that stands whatever the wheel does. At rest the loop then pushes the wheel towards its place, and nothing tells that
/// it turns.
fn dead(wheel: Wheel, instant: &FaultInstant) -> Vec<Name> {
    let mut names = stands(wheel, &[Fault::EncoderDead(wheel)], instant);
    if instant.comes_to_rest() {
        names.push(Name::Fault(Fault::Stall(wheel)));
    }
    names
}

/// What a wheel or count that stands is called: whatever it is, no response if the counts before it do not tell.
fn stands(wheel: Wheel, faults: &[Fault], instant: &FaultInstant) -> Vec<Name> {
    let mut names: Vec<Name> = faults.iter().copied().map(Name::Fault).collect();
    if instant.counts_tell_nothing(wheel) {
        names.push(Name::Fault(Fault::NoResponse(wheel)));
    }
    names
}

/// The clock fails before the program watches it. A chip's core would stand, its motors off; the emulated one goes on.
fn clock_unseen() -> (MotorsOff, Vec<Name>) {
    (MotorsOff::NotNeeded, vec![Name::Harmless, Name::Restart(ResetCause::Panic)])
}

/// A motor without current. While its setpoint brakes, the wheel may roll out along with it: what it is off shows at the latest
/// once it stands. If that is nothing, the next motion names it (`judge`).
fn lead_cut(wheel: Wheel, case: &Case, instant: &FaultInstant) -> (MotorsOff, Vec<Name>) {
    let slow = case.motion.cruise <= PAPERS_CRUISE_MPS;
    let ms = if slow { ROLL_OUT_MS } else { ROLL_FAR_MS };
    let (bound, mut names) = instant.of_wheel(ms, pushed, stalls(wheel, slow, instant));
    let Some(speed_mps) = instant.rolls_out(wheel, ms) else { return (bound, names) };
    if instant.arrived(wheel) {
        names.push(Name::Harmless);
    }
    match bound {
        MotorsOff::Within(ms) => {
            (MotorsOff::Within(ms.max(speed_mps / COASTS_MPS2 * 1000.0 + STANDS_MS)), names)
        }
        _ => (bound, names),
    }
}

/// A wheel that its motor no longer turns.
fn stalls(wheel: Wheel, slow: bool, instant: &FaultInstant) -> Vec<Name> {
    let mut names = stands(wheel, &[Fault::Stall(wheel)], instant);
    if !slow {
        // While it rolls on, nothing tells but how far it is from its setpoint.
        names.push(Name::Fault(Fault::FollowingError(wheel)));
    }
    names
}

/// A stop for so long \[ms\]. One that was over before the program looked at it is none.
fn stop(within_ms: f64, instant: &FaultInstant, lasts_ms: f64) -> (MotorsOff, Vec<Name>) {
    let names = instant.unless_over(Fault::EmergencyStop, lasts_ms);
    let seen = !names.contains(&Name::Harmless);
    (if seen { MotorsOff::Within(within_ms) } else { MotorsOff::NotNeeded }, names)
}

/// The ramp of a controlled stop.
fn silence(case: &Case) -> MotorsOff {
    MotorsOff::Within(SILENCE_MS + case.motion.cruise / STOP_MPS2 * 1000.0 + SETTLE_MS)
}

/// A supply that fails. A dip is shorter than the 20 ticks that a starting motor may take; but arming looks at once.
fn of_supply(kind: FaultKind, case: &Case, instant: &FaultInstant) -> (MotorsOff, Vec<Name>) {
    match kind {
        FaultKind::SupplyDip(_, ms)
            if case.phase == Phase::Arming
                || instant.lasts_when_armed(f64::from(ms) + SUPPLY_READ_MS) =>
        {
            (MotorsOff::NotNeeded, vec![Name::Harmless, Name::Fault(Fault::SupplyLow)])
        }
        FaultKind::SupplyDip(..) => (MotorsOff::NotNeeded, vec![Name::Harmless]),
        FaultKind::SupplyHigh(_) => {
            (MotorsOff::Within(SUPPLY_HIGH_MS), instant.if_armed(Fault::SupplyHigh))
        }
        _ => (MotorsOff::Within(SUPPLY_LOW_MS), instant.if_armed(Fault::SupplyLow)),
    }
}

/// Bounds as in `emulated-board/tests/board/hang.rs`.
fn program(what: &str) -> (MotorsOff, Vec<Name>) {
    let (ms, cause) = match what {
        "encoder capture hangs" | "PID hangs" => (33.0, ResetCause::Watchdog),
        // The interrupt comes with the next byte, which may be the host's, 30 ms later.
        "link interrupt hangs" => (50.0 + 35.0, ResetCause::Watchdog),
        "guard hangs" | "hang, interrupts masked" => (45.0, ResetCause::Watchdog),
        "task beside control panics" => (5.0, ResetCause::Panic),
        "PID panics" | "hard fault in PID" => (3.0, ResetCause::Panic),
        _ => (50.0, ResetCause::Watchdog),
    };
    (MotorsOff::Within(ms), vec![Name::Restart(cause)])
}
