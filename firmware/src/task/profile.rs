//! Trapezoidal profile: what each wheel should do at this control tick.
//!
//! Takes the supervisor's orders at a tick boundary, steps the plan, and reports when a motion has
//! settled.

use embassy_sync::blocking_mutex::raw::RawMutex;
use fixed::types::I2F30;
use shared_proto::{Fault, MotionEnd, WheelPair};

use crate::capture::Measured;
use crate::shared::{Action, ControlEvent, ControlOrder, Shared, Tick};
use crate::voltage::{OpenLoop, OpenLoopStep};

/// After a plan's last tick the loop stays closed this long, unless the wheels arrive earlier.
const SETTLE_TICKS_MAX: u32 = 250;

/// A wheel further than this from its target may still roll \[m\]: the loop stays closed longer, until it has stood for so
/// long that protection would say what is wrong with it.
const FAR: I2F30 = I2F30::lit("0.002");
const STOOD_TICKS: u32 = 140;
const FAR_TICKS_MAX: u32 = 1000;

/// A wheel this close to its target has arrived: one count of a coarse encoder \[m\].
const ARRIVED: I2F30 = I2F30::lit("0.000251");

/// How long both wheels must stay that close \[ticks\].
const ARRIVED_TICKS: u32 = 50;

/// Answers every measurement with an action, for ever.
pub async fn run<M: RawMutex>(shared: &Shared<M>) -> ! {
    let mut active = ActiveOrder::Off;
    loop {
        shared.measurement_ready.wait().await;
        let order = shared.order.try_take();
        shared.snapshot.with(|tick| {
            if let Some(order) = order {
                active.take(shared, order, &tick.measured);
            }
            tick.action = active.step(shared, tick);
        });
        shared.action_ready.notify();
    }
}

/// The order that is being carried out.
enum ActiveOrder {
    Off,
    Rest,
    Probe { id: u32 },
    Follow { id: u32, hold_ticks: u32, close_ticks: u32, settle_ticks: u32, stood: Stood },
    Hold { ticks_left: u32 },
    Voltage { id: u32, open_loop: OpenLoop },
}

/// How long both counts have stood.
struct Stood {
    /// Of both, so mixed that it changes with each.
    counts: u32,
    ticks: u32,
}

impl Stood {
    #[inline(always)]
    fn step(&mut self, counts: WheelPair<i64>) -> u32 {
        let counts = (counts.left as u32).wrapping_mul(3).wrapping_add(counts.right as u32);
        self.ticks = if counts == self.counts { self.ticks + 1 } else { 0 };
        self.counts = counts;
        self.ticks
    }
}

impl ActiveOrder {
    fn take<M: RawMutex>(&mut self, shared: &Shared<M>, order: ControlOrder, measured: &Measured) {
        match order {
            ControlOrder::Off => *self = ActiveOrder::Off,
            ControlOrder::Rest => *self = ActiveOrder::Rest,
            ControlOrder::Probe { id } => *self = ActiveOrder::Probe { id },
            ControlOrder::Voltage { id, plan } => match self {
                ActiveOrder::Voltage { id: present, open_loop } => {
                    *present = id;
                    open_loop.replace(plan, measured.travel);
                }
                _ => {
                    let open_loop = OpenLoop::new(plan, measured.travel);
                    *self = ActiveOrder::Voltage { id, open_loop };
                }
            },
            ControlOrder::Halt { id } => match self {
                ActiveOrder::Voltage { id: present, open_loop } => {
                    *present = id;
                    open_loop.halt();
                }
                // They were over when the order came: nothing turns.
                _ => {
                    *self = ActiveOrder::Rest;
                    let rolled = ControlEvent::Rolled(id, MotionEnd::Stopped);
                    let _ = shared.control_events.try_send(rolled);
                }
            },
            ControlOrder::Follow { id, hold_ticks } => {
                let late = shared.profile.with(|profile| {
                    let late = profile.drop_late(measured.tick);
                    if !matches!(self, ActiveOrder::Follow { .. } | ActiveOrder::Hold { .. }) {
                        profile.switch();
                    }
                    late
                });
                // The supervisor plans ahead. A plan that arrives after its first tick would make the wheels jump.
                if late {
                    shared.raise_in_tick(Fault::DeadlineMissed, measured.t_us);
                } else {
                    *self = ActiveOrder::Follow {
                        id,
                        hold_ticks,
                        close_ticks: 0,
                        settle_ticks: 0,
                        stood: Stood { counts: 0, ticks: 0 },
                    };
                }
            }
        }
    }

    #[inline(always)]
    fn step<M: RawMutex>(&mut self, shared: &Shared<M>, tick: &mut Tick) -> Action {
        let Tick { measured, setpoints, loops, .. } = tick;
        match self {
            ActiveOrder::Off => Action::Off,
            ActiveOrder::Rest => Action::Rest,
            ActiveOrder::Probe { id } => Action::Probe { id: *id },
            ActiveOrder::Follow { id, hold_ticks, close_ticks, settle_ticks, stood } => {
                let ended = shared.profile.with(|profile| {
                    // At the tick before: in the tick that ends a plan both wheels change phase already.
                    let ended = profile.has_ended();
                    profile.step(measured.tick, setpoints);
                    ended
                });
                if ended {
                    *settle_ticks += 1;
                    // As the controller saw it at the tick before.
                    let close = loops.as_ref().all(|wheel| wheel.is_within(ARRIVED));
                    *close_ticks = if close { *close_ticks + 1 } else { 0 };
                    let ticks = stood.step(measured.counts);
                    let over = *settle_ticks >= SETTLE_TICKS_MAX
                        && (ticks >= STOOD_TICKS
                            || loops.as_ref().all(|wheel| wheel.is_within(FAR))
                            || *settle_ticks >= FAR_TICKS_MAX);
                    if *close_ticks >= ARRIVED_TICKS || over {
                        let _ = shared.control_events.try_send(ControlEvent::Settled(*id));
                        *self = ActiveOrder::Hold { ticks_left: *hold_ticks };
                    }
                }
                Action::Track
            }
            ActiveOrder::Voltage { .. } => self.step_open_loop(shared, measured),
            ActiveOrder::Hold { ticks_left: 0 } => {
                *self = ActiveOrder::Rest;
                Action::Rest
            }
            ActiveOrder::Hold { ticks_left } => {
                *ticks_left -= 1;
                shared.profile.with(|profile| profile.step(measured.tick, setpoints));
                Action::Track
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn step_open_loop<M: RawMutex>(&mut self, shared: &Shared<M>, measured: &Measured) -> Action {
        let ActiveOrder::Voltage { id, open_loop } = self else { return Action::Rest };
        match open_loop.step(&measured.travel, &measured.speed) {
            OpenLoopStep::Apply(volts) => Action::Voltage(volts),
            OpenLoopStep::Roll => Action::Rest,
            OpenLoopStep::Ended(end) => {
                let _ = shared.control_events.try_send(ControlEvent::Rolled(*id, end));
                *self = ActiveOrder::Rest;
                Action::Rest
            }
        }
    }
}
