//! Trapezoidal profile: what each wheel should do at this control tick.
//!
//! Takes the supervisor's orders over at a tick boundary, steps the plan, and says when a motion
//! has come to its end.

use embassy_sync::blocking_mutex::raw::RawMutex;
use fixed::types::I2F30;
use shared_proto::Fault;

use crate::probe::Probe;
use crate::profile::Profile;
use crate::shared::{Action, ControlEvent, ControlStep, Measured, Order, Shared};

/// After a plan's last tick the loop stays closed this long, unless the wheels arrive earlier.
const SETTLE_TICKS_MAX: u32 = 250;

/// A wheel has arrived when it is this close to its target: what a count of a coarse encoder is.
const ARRIVED: I2F30 = I2F30::lit("0.000251");

/// A wheel has arrived only after it was close for this long.
const ARRIVED_TICKS: u32 = 50;

/// Answers every measurement with an action, for ever.
pub async fn run<M: RawMutex>(shared: &Shared<M>) -> ! {
    let mut stage = Stage::Off;
    loop {
        let measured = shared.measured.wait().await;
        if let Some(order) = shared.order.try_take() {
            stage.take(shared, order, &measured);
        }
        let action = stage.step(shared, &measured);
        shared.step.signal(ControlStep { measured, action });
    }
}

/// The order that is being carried out.
#[allow(clippy::large_enum_variant, reason = "no allocator on the board; one lives at a time")]
enum Stage {
    Off,
    Rest,
    ProbeStarts { id: u32, probe: Probe },
    Probe { id: u32 },
    Follow { id: u32, profile: Profile, close_ticks: u32, settle_ticks: u32 },
}

impl Stage {
    fn take<M: RawMutex>(&mut self, shared: &Shared<M>, order: Order, measured: &Measured) {
        match order {
            Order::Off => *self = Stage::Off,
            Order::Rest => *self = Stage::Rest,
            Order::Probe { id, probe } => *self = Stage::ProbeStarts { id, probe },
            Order::Follow { id, plan } => {
                // The supervisor plans ahead. A plan that comes after its first tick would jump.
                if plan.start_tick().wrapping_sub(measured.tick) > u32::MAX / 2 {
                    shared.raise(Fault::DeadlineMissed, measured.t_us);
                    return;
                }
                match self {
                    Stage::Follow { id: current, profile, close_ticks, settle_ticks } => {
                        profile.replace(plan);
                        *current = id;
                        *close_ticks = 0;
                        *settle_ticks = 0;
                    }
                    _ => {
                        let profile = Profile::new(plan);
                        *self = Stage::Follow { id, profile, close_ticks: 0, settle_ticks: 0 };
                    }
                }
            }
        }
    }

    fn step<M: RawMutex>(&mut self, shared: &Shared<M>, measured: &Measured) -> Action {
        match self {
            Stage::Off => Action::Off,
            Stage::Rest => Action::Rest,
            Stage::ProbeStarts { id, probe } => {
                let (id, start) = (*id, Some(probe.clone()));
                *self = Stage::Probe { id };
                Action::Probe { id, start }
            }
            Stage::Probe { id } => Action::Probe { id: *id, start: None },
            Stage::Follow { id, profile, close_ticks, settle_ticks } => {
                let setpoints = profile.step(measured.tick);
                if profile.finished(measured.tick) {
                    *settle_ticks += 1;
                    let close = measured.travel.zip(setpoints).all(|(travel, setpoint)| {
                        travel.error_from(setpoint.travel).abs() <= ARRIVED
                    });
                    *close_ticks = if close { *close_ticks + 1 } else { 0 };
                    let over = *settle_ticks >= SETTLE_TICKS_MAX;
                    if *close_ticks >= ARRIVED_TICKS || over {
                        let _ = shared.control_events.try_send(ControlEvent::Settled(*id));
                        *self = Stage::Rest;
                    }
                }
                Action::Track(setpoints)
            }
        }
    }
}
