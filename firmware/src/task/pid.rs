//! PID: makes the wheels follow the profile task's setpoints.
//!
//! The only task that writes to the motors. Whichever task latches a fault, this one sets zero duty, at the
//! next control tick at the latest. It also counts down the dead-man itself: without the supervisor's
//! word no motion goes on.

use embassy_sync::blocking_mutex::raw::RawMutex;
use fixed::types::I32F32;
use shared_proto::{AtFault, DriverConfig, Fault, WheelPair};

use crate::capture::Measured;
use crate::hal::{Motors, Supply};
use crate::pid::{Gains, PidState, step_both};
use crate::probe::ProbeOutcome;
use crate::protection::Protection;
use crate::shared::{Action, ControlEvent, LoopSettings, Shared, SupplyLimits, Tick};
use crate::supply::SupplyScale;
use crate::switching_on::{SwitchingOn, rolls};
use crate::units::{Duty, Travel};
use crate::voltage::duty_of;

/// The supply may stay below its limit this long \[ticks\]: a starting motor makes the voltage dip.
const SUPPLY_LOW_TICKS_MAX: u32 = 20;

/// Drives the motors, for ever.
pub async fn run<M: RawMutex>(
    shared: &Shared<M>,
    mut motors: impl Motors,
    mut supply: impl Supply,
) -> ! {
    let mut control = Control::new(shared.loop_settings.next().await);
    motors.configure(&control.driver);
    loop {
        shared.action_ready.wait().await;
        shared.loop_settings.if_new(|settings| {
            if control.driver != settings.driver {
                motors.configure(&settings.driver);
                control.enabled = false;
            }
            control.adopt(settings);
        });
        let supply_mv = supply.millivolts();
        shared.snapshot.with(|tick| {
            tick.supply_mv = supply_mv;
            // What was on the motors until now, at the supply under that load: the sum is one up to this tick's counts.
            tick.applied.add(tick.duty, control.supply_mv.known(supply_mv));
            let output = control.step(shared, tick);
            // Disable before writing zero, enable after writing the duty: neither order can jerk a wheel.
            if !output.enabled {
                motors.enable(false);
            }
            motors.set_duty(control.as_wired(output.duty));
            if output.enabled {
                motors.enable(true);
            }
            tick.duty = output.duty;
            tick.probing = output.probing;
        });
    }
}

/// The motors' commands at one tick.
#[derive(Clone, Copy)]
struct Output {
    enabled: bool,
    probing: bool,
    duty: WheelPair<Duty>,
}

impl Output {
    const OFF: Self = Self { enabled: false, probing: false, duty: WheelPair::both(Duty::ZERO) };
}

/// The supply may stay above its limit this long \[ticks\]: noise passes, and a bridge is not kept waiting.
const SUPPLY_HIGH_TICKS_MAX: u32 = 4;

/// Both wheels' control loops and their protection.
struct Control {
    gains: WheelPair<Gains>,
    /// Whether positive duty turns a wheel backwards.
    reversed: WheelPair<bool>,
    supply_mv: SupplyLimits,
    supply_scale: SupplyScale,
    protection: Protection,
    /// The last encoder check that was started.
    probe_id: Option<u32>,
    /// Where the wheels stood before it pushed one.
    stood: WheelPair<Travel>,
    tracking: bool,
    switching_on: SwitchingOn,
    supply_low_ticks: u32,
    supply_high_ticks: u32,
    driver: DriverConfig,
    /// The drivers are on.
    enabled: bool,
}

impl Control {
    fn new(settings: LoopSettings) -> Self {
        Self {
            gains: settings.gains,
            reversed: settings.reversed,
            supply_mv: settings.supply_mv,
            supply_scale: SupplyScale::new(settings.supply_mv.nominal),
            protection: Protection::with(settings.thresholds),
            probe_id: None,
            stood: WheelPair::both(Travel(I32F32::ZERO)),
            tracking: false,
            switching_on: SwitchingOn::OVER,
            supply_low_ticks: 0,
            supply_high_ticks: 0,
            driver: settings.driver,
            enabled: false,
        }
    }

    /// Adopts new settings; the loop opens.
    #[inline(never)]
    fn adopt(&mut self, settings: &LoopSettings) {
        self.gains = settings.gains;
        self.reversed = settings.reversed;
        self.supply_mv = settings.supply_mv;
        self.supply_scale.set_nominal(settings.supply_mv.nominal);
        self.protection.adopt(&settings.thresholds);
        self.driver = settings.driver;
        self.tracking = false;
        (self.supply_low_ticks, self.supply_high_ticks) = (0, 0);
    }

    fn as_wired(&self, duty: WheelPair<Duty>) -> WheelPair<Duty> {
        duty.zip(self.reversed).map(|(duty, reversed)| if reversed { Duty(-duty.0) } else { duty })
    }

    fn step<M: RawMutex>(&mut self, shared: &Shared<M>, tick: &mut Tick) -> Output {
        let Tick { measured, action, supply_mv, loops, .. } = &mut *tick;
        if !matches!(action, Action::Off)
            && let Some(fault) = self.watch_supply(*supply_mv)
        {
            shared.raise_in_tick(fault, measured.t_us);
        }
        if matches!(action, Action::Probe { .. } | Action::Track | Action::Voltage(_))
            && !shared.dead_man.spend()
        {
            shared.raise_in_tick(Fault::Unsupervised, measured.t_us);
        }
        let supply_scale = self.supply_scale.step(*supply_mv);
        let output = match action {
            Action::Voltage(volts) => self.apply(*volts, *supply_mv, loops),
            _ => self.act(shared, tick, supply_scale),
        };
        // Checked last, so that a fault of this very tick counts.
        let output =
            if shared.fault.forces_motors_off() { self.stop(shared, tick) } else { output };
        self.enabled = output.enabled;
        output
    }

    /// A fault forbids any duty. Motors that are on brake until it is cleared, if that is what is configured.
    #[cold]
    #[inline(never)]
    fn stop<M: RawMutex>(&mut self, shared: &Shared<M>, tick: &mut Tick) -> Output {
        shared.fault.note(tick);
        self.reset(&mut tick.loops);
        let brake = self.driver.at_fault == AtFault::Brake;
        Output { enabled: self.enabled && brake, ..Output::OFF }
    }

    fn act<M: RawMutex>(
        &mut self,
        shared: &Shared<M>,
        tick: &mut Tick,
        supply_scale: i32,
    ) -> Output {
        match tick.action {
            // A voltage needs no loop: see `apply`.
            Action::Off | Action::Voltage(_) => {
                self.reset(&mut tick.loops);
                Output::OFF
            }
            Action::Rest => self.stand(shared, tick),
            Action::Probe { id } => {
                if self.probe_id != Some(id) {
                    self.reset(&mut tick.loops);
                    self.probe_id = Some(id);
                    self.stood = tick.measured.travel;
                }
                if !self.switching_on.lets_check() || !(self.enabled || rolls(&tick.measured)) {
                    return Output { probing: true, ..self.stand(shared, tick) };
                }
                self.switching_on = SwitchingOn::OVER;
                self.step_probe(shared, &tick.measured, id, supply_scale)
            }
            Action::Track => self.track(shared, tick, supply_scale),
        }
    }

    /// Zero duty, drivers on. They are switched on while the wheels stand. To a driver of another kind than the configured one
    /// zero may be full duty: a wheel that moves as soon as they are on is a fault, and they go off, whatever is configured.
    #[cold]
    #[inline(never)]
    fn stand<M: RawMutex>(&mut self, shared: &Shared<M>, tick: &mut Tick) -> Output {
        self.reset(&mut tick.loops);
        let measured = &tick.measured;
        if !self.enabled {
            if rolls(measured) {
                self.switching_on = SwitchingOn::OVER;
                return Output::OFF;
            }
            self.switching_on = SwitchingOn::begin();
        } else if let Some(fault) =
            self.switching_on.step(self.protection.thresholds(), measured.counts)
        {
            self.enabled = false;
            shared.raise_in_tick(fault, measured.t_us);
        }
        Output { enabled: true, ..Output::OFF }
    }

    /// Voltages without feedback. What watches the loop needs a setpoint: the voltages' own limits watch instead.
    #[cold]
    #[inline(never)]
    fn apply(
        &mut self,
        volts: WheelPair<i32>,
        supply_mv: u16,
        loops: &mut WheelPair<PidState>,
    ) -> Output {
        self.reset(loops);
        let duty = duty_of(volts, self.supply_mv.known(supply_mv), self.gains.left.duty_max());
        Output { enabled: true, probing: false, duty }
    }

    #[inline(never)]
    fn step_probe<M: RawMutex>(
        &mut self,
        shared: &Shared<M>,
        measured: &Measured,
        id: u32,
        supply_scale: i32,
    ) -> Output {
        // Wheels that still roll are waited for with the drivers as they are.
        let mut output = Output { enabled: self.enabled, probing: true, ..Output::OFF };
        // In place: to copy it takes longer than to step it.
        let mut waits = false;
        let outcome = shared.probe.with(|probe| {
            let check = probe.as_mut()?;
            let outcome = check.step(measured.counts);
            waits = check.waits();
            if waits {
                self.stood = measured.travel;
            }
            if !matches!(outcome, ProbeOutcome::Running(_)) {
                *probe = None;
            }
            Some(outcome)
        });
        match outcome {
            Some(ProbeOutcome::Running(duty)) => {
                output.enabled |= !waits;
                // On a full battery, too, an unplugged encoder is found before the robot has rolled far.
                output.duty = duty.map(|duty| self.gains.left.at_supply(duty, supply_scale));
            }
            Some(ProbeOutcome::Done) => {
                let _ = shared.control_events.try_send(ControlEvent::Probed(id, self.stood));
            }
            Some(ProbeOutcome::Failed(fault)) => shared.raise_in_tick(fault, measured.t_us),
            // The check is done and the supervisor's next order has not arrived yet.
            None => {}
        }
        output
    }

    fn track<M: RawMutex>(
        &mut self,
        shared: &Shared<M>,
        tick: &mut Tick,
        supply_scale: i32,
    ) -> Output {
        let Tick { measured, setpoints, loops, .. } = tick;
        if !self.tracking {
            self.reset(loops);
            self.tracking = true;
        }
        let Measured { travel, speed, .. } = &*measured;
        let duty = step_both(&self.gains, loops, setpoints, travel, speed, supply_scale);
        if let Some(fault) = self.protection.step(setpoints, measured, loops, supply_scale) {
            shared.raise_in_tick(fault, measured.t_us);
        }
        Output { enabled: true, probing: false, duty }
    }

    /// Resets the controllers: a loop that closes again must not start from old integrals.
    fn reset(&mut self, loops: &mut WheelPair<PidState>) {
        self.tracking = false;
        self.protection.restart();
        *loops = WheelPair::both(PidState::ZERO);
    }

    #[inline(always)]
    fn watch_supply(&mut self, supply_mv: u16) -> Option<Fault> {
        if self.supply_mv.admits(supply_mv) {
            (self.supply_low_ticks, self.supply_high_ticks) = (0, 0);
            return None;
        }
        if u32::from(supply_mv) < self.supply_mv.min {
            self.supply_low_ticks += 1;
            return (self.supply_low_ticks > SUPPLY_LOW_TICKS_MAX).then_some(Fault::SupplyLow);
        }
        self.supply_high_ticks += 1;
        (self.supply_high_ticks > SUPPLY_HIGH_TICKS_MAX).then_some(Fault::SupplyHigh)
    }
}
