//! The two inputs that stop the robot: emergency stop, and the motor driver's fault line.
//!
//! ```text
//! emergency stop   pressed: zero duty, latched as a fault
//!                  later pressed again, held for 2 s and released: that fault is cleared, the robot idle
//! ```
//! The press that latched the fault never clears it, however long it lasts: a stop that is pressed for an
//! hour and then released stays latched. Nothing moves until a host arms the robot again.
//!
//! A board may have a stop line besides: a switch that opens when pressed and stops the motors in hardware.
//! Its fault is the same, but closing the line clears nothing.
//!
//! The stop inputs are active low: an emergency stop that pulls to ground needs a pull-up. A board whose button
//! is active high inverts the input. The driver's fault line is as configured ([`FaultLine`]).

use embassy_futures::select::select;
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Duration, Instant, Timer};
use embedded_hal_async::digital::Wait;
use shared_proto::Fault;

use crate::hal::{Level, WaitPin};
use crate::liveness::SafetyTask;
use crate::shared::{ControlEvent, FaultLine, Shared, SharedCell};

/// Holding the emergency stop's button for this long clears its own fault.
const HOLD: Duration = Duration::from_secs(2);

/// A press this soon after a release is contact bounce.
const BOUNCE: Duration = Duration::from_millis(200);

/// How soon a fault line that was configured differently is looked at again.
const LOOK_AGAIN: Duration = Duration::from_millis(10);

/// Watches the emergency stop, for ever.
pub async fn emergency_stop<M: RawMutex>(shared: &Shared<M>, mut pin: impl Wait) -> ! {
    let mut released = None;
    let alive = SafetyTask::EmergencyStop;
    loop {
        let _ = shared.liveness.while_waiting(alive, pin.wait_for_low()).await;
        let pressed = Instant::now();
        let latched_before =
            shared.fault.report().is_some_and(|report| report.fault == Fault::EmergencyStop);
        let anew = released.is_none_or(|released| pressed > released + BOUNCE);
        shared.safety_inputs.update(|inputs| inputs.emergency_stop = true);
        shared.raise(Fault::EmergencyStop, pressed.as_micros());
        shared.liveness.while_waiting(alive, wait_until_released(&mut pin)).await;
        shared.safety_inputs.update(|inputs| inputs.emergency_stop = false);
        released = Some(Instant::now());
        if latched_before && anew && pressed.elapsed() >= HOLD {
            // If the queue is full, the request is lost; the user can hold the button again.
            let _ = shared.control_events.try_send(ControlEvent::ClearRequested);
        }
    }
}

/// Watches the stop line, for ever. The hardware has stopped the motors already; this names it, and keeps the
/// fault until the line is closed and somebody clears it by another way than this switch. Nobody has to watch this task:
/// without it the motors stop all the same.
pub async fn stop_line<M: RawMutex>(shared: &Shared<M>, mut pin: impl Wait) -> ! {
    loop {
        let _ = pin.wait_for_low().await;
        shared.safety_inputs.update(|inputs| inputs.stop_line = true);
        shared.raise(Fault::EmergencyStop, Instant::now().as_micros());
        wait_until_released(&mut pin).await;
        shared.safety_inputs.update(|inputs| inputs.stop_line = false);
    }
}

/// The driver's fault line, low at a fault whatever the driver is.
struct Asserted<'a, M: RawMutex, L> {
    line: &'a SharedCell<M, FaultLine>,
    pin: L,
}

impl<M: RawMutex, L: Level> Level for Asserted<'_, M, L> {
    fn is_low(&self) -> bool {
        match self.line.get() {
            FaultLine::None => false,
            FaultLine::ActiveLow => self.pin.is_low(),
            FaultLine::ActiveHigh => !self.pin.is_low(),
        }
    }

    async fn wait_until(&self, low: bool) {
        while self.is_low() != low {
            // What the line means may change meanwhile.
            let change = self.pin.wait_until(!self.pin.is_low());
            select(change, Timer::after(LOOK_AGAIN)).await;
        }
    }
}

/// Watches the motor driver's fault line, for ever.
pub async fn driver_fault<M: RawMutex>(shared: &Shared<M>, pin: impl Level) -> ! {
    let mut pin = WaitPin(Asserted { line: &shared.fault_line, pin });
    let alive = SafetyTask::DriverFault;
    loop {
        // A pin that cannot be read is treated as asserted: the robot does not drive blind.
        let _ = shared.liveness.while_waiting(alive, pin.wait_for_low()).await;
        shared.safety_inputs.update(|inputs| inputs.driver_fault = true);
        shared.raise(Fault::Driver, Instant::now().as_micros());
        shared.liveness.while_waiting(alive, wait_until_released(&mut pin)).await;
        shared.safety_inputs.update(|inputs| inputs.driver_fault = false);
    }
}

/// Waits for the release. A pin that cannot be read stays asserted.
async fn wait_until_released(pin: &mut impl Wait) {
    if pin.wait_for_high().await.is_err() {
        core::future::pending::<()>().await;
    }
}
