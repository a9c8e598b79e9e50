//! PID: makes the wheels do what the profile task says.
//!
//! The only task that touches the motors. Whatever latches a fault anywhere, zero duty is set here,
//! at the next control tick at the latest.

use embassy_sync::blocking_mutex::raw::RawMutex;
use shared_proto::{Fault, PidTerms, Telemetry, Wheel, WheelPair, WheelTelemetry};

use crate::hal::{Motors, Supply};
use crate::pid::{PidState, step};
use crate::probe::{Probe, ProbeOutcome};
use crate::profile::Setpoint;
use crate::protection::{Protection, WheelView};
use crate::shared::{Action, ControlEvent, ControlStep, LoopSettings, Measured, Shared, Snapshot};
use crate::units::{Duty, Travel};

/// The supply may be below its bound this long \[ticks\]: a motor that starts makes it dip.
const SUPPLY_LOW_TICKS_MAX: u32 = 20;

/// Drives the motors, for ever.
pub async fn run<M: RawMutex>(
    shared: &Shared<M>,
    mut motors: impl Motors,
    mut supply: impl Supply,
) -> ! {
    let mut control = Control::new(shared.loop_settings.wait().await);
    motors.enable(false);
    loop {
        let step = shared.step.wait().await;
        let measured = step.measured;
        if let Some(settings) = shared.loop_settings.try_take() {
            control = Control::new(settings);
        }
        let supply_mv = supply.millivolts();
        let output = control.step(shared, step, supply_mv);
        // Off before zero is written: no order of the two lets a wheel jerk.
        if !output.enabled {
            motors.enable(false);
        }
        motors.set_duty(control.as_wired(output.duty));
        if output.enabled {
            motors.enable(true);
        }
        publish(shared, &control, &measured, output, supply_mv);
    }
}

/// What the motors get at one tick.
#[derive(Clone, Copy)]
struct Output {
    enabled: bool,
    probing: bool,
    duty: WheelPair<Duty>,
    setpoints: Option<WheelPair<Setpoint>>,
}

impl Output {
    const OFF: Self =
        Self { enabled: false, probing: false, duty: WheelPair::both(Duty::ZERO), setpoints: None };
}

/// Both wheels' loops and what watches them.
struct Control {
    settings: LoopSettings,
    /// The watch as it runs; the settings keep a fresh one.
    protection: Protection,
    states: WheelPair<PidState>,
    probe: Option<Probe>,
    tracking: bool,
    supply_low_ticks: u32,
}

impl Control {
    fn new(settings: LoopSettings) -> Self {
        Self {
            protection: settings.protection.clone(),
            settings,
            states: WheelPair { left: PidState::default(), right: PidState::default() },
            probe: None,
            tracking: false,
            supply_low_ticks: 0,
        }
    }

    fn as_wired(&self, duty: WheelPair<Duty>) -> WheelPair<Duty> {
        duty.zip(self.settings.reversed)
            .map(|(duty, reversed)| if reversed { Duty(-duty.0) } else { duty })
    }

    fn step<M: RawMutex>(
        &mut self,
        shared: &Shared<M>,
        step: ControlStep,
        supply_mv: u16,
    ) -> Output {
        let ControlStep { measured, action } = step;
        if !matches!(action, Action::Off)
            && let Some(fault) = self.watch_supply(supply_mv)
        {
            shared.raise(fault, measured.t_us);
        }
        let output = self.act(shared, &measured, action);
        // Asked last, so that a fault of this very tick counts.
        if shared.fault.cuts_motors() {
            self.forget();
            return Output { setpoints: output.setpoints, ..Output::OFF };
        }
        output
    }

    fn act<M: RawMutex>(
        &mut self,
        shared: &Shared<M>,
        measured: &Measured,
        action: Action,
    ) -> Output {
        match action {
            Action::Off => {
                self.forget();
                Output::OFF
            }
            Action::Rest => {
                self.forget();
                Output { enabled: true, ..Output::OFF }
            }
            Action::Probe { id, start } => {
                if start.is_some() {
                    self.forget();
                    self.probe = start;
                }
                self.step_probe(shared, measured, id)
            }
            Action::Track(setpoints) => self.track(shared, measured, setpoints),
        }
    }

    fn step_probe<M: RawMutex>(
        &mut self,
        shared: &Shared<M>,
        measured: &Measured,
        id: u32,
    ) -> Output {
        let mut output = Output { enabled: true, probing: true, ..Output::OFF };
        match self.probe.as_mut().map(|probe| probe.step(measured.counts)) {
            Some(ProbeOutcome::Running(duty)) => output.duty = duty,
            Some(ProbeOutcome::Done) => {
                self.probe = None;
                let _ = shared.control_events.try_send(ControlEvent::Probed(id));
            }
            Some(ProbeOutcome::Failed(fault)) => shared.raise(fault, measured.t_us),
            // Done; the supervisor's next order is on its way.
            None => {}
        }
        output
    }

    fn track<M: RawMutex>(
        &mut self,
        shared: &Shared<M>,
        measured: &Measured,
        setpoints: WheelPair<Setpoint>,
    ) -> Output {
        if !self.tracking {
            self.forget();
            self.tracking = true;
        }
        let gains = &self.settings.gains;
        let wheels = setpoints.zip(measured.travel.zip(measured.speed));
        let duty = self.states.as_mut().zip(wheels).map(|(state, (setpoint, (travel, speed)))| {
            step(gains, state, &setpoint, travel, speed)
        });
        let views = setpoints
            .zip(measured.travel.zip(measured.speed))
            .zip(measured.counts.zip(duty))
            .map(|((setpoint, (travel, speed)), (counts, duty))| WheelView {
                setpoint,
                travel,
                counts,
                speed,
                duty,
            });
        if let Some(fault) = self.protection.step(&views) {
            shared.raise(fault, measured.t_us);
        }
        Output { enabled: true, probing: false, duty, setpoints: Some(setpoints) }
    }

    /// A loop that opens forgets its sums, so that it does not jump when it closes again.
    fn forget(&mut self) {
        self.probe = None;
        if self.tracking {
            self.tracking = false;
            self.protection = self.settings.protection.clone();
        }
        self.states = WheelPair { left: PidState::default(), right: PidState::default() };
    }

    fn watch_supply(&mut self, supply_mv: u16) -> Option<Fault> {
        if supply_mv >= self.settings.supply_mv_min {
            self.supply_low_ticks = 0;
            return None;
        }
        self.supply_low_ticks += 1;
        (self.supply_low_ticks > SUPPLY_LOW_TICKS_MAX).then_some(Fault::SupplyLow)
    }
}

fn error_um(setpoint: Travel, travel: Travel) -> i32 {
    ((i64::from(setpoint.error_from(travel).to_bits()) * 1_000_000) >> 30) as i32
}

fn publish<M: RawMutex>(
    shared: &Shared<M>,
    control: &Control,
    measured: &Measured,
    output: Output,
    supply_mv: u16,
) {
    let wheel = |wheel: Wheel| {
        let travel = *measured.travel.get(wheel);
        let setpoint = output.setpoints.map_or(travel, |pair| pair.get(wheel).travel);
        WheelTelemetry {
            counts: *measured.counts.get(wheel),
            setpoint_um: setpoint.to_um(),
            error_um: error_um(setpoint, travel),
            speed_um_s: measured.speed.get(wheel).to_um_s(),
            terms: if control.tracking {
                control.states.get(wheel).terms()
            } else {
                PidTerms::default()
            },
            duty: output.duty.get(wheel).to_i16(),
        }
    };
    let wheels = WheelPair { left: wheel(Wheel::Left), right: wheel(Wheel::Right) };
    shared.snapshot.set(Snapshot { measured: *measured, wheels, supply_mv });
    let period = shared.telemetry_period.get();
    if period != 0 && measured.tick.is_multiple_of(period) {
        shared.telemetry_due.signal(Telemetry {
            number: measured.tick / period,
            t_us: measured.t_us,
            state: shared.state.get(),
            probing: output.probing,
            wheels,
            supply_mv,
        });
    }
}
