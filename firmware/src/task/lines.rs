//! The two inputs that stop the robot: emergency stop, and the motor driver's fault line.
//!
//! Both are active low: a driver's fault output is an open drain, and a loop that an emergency
//! stop pulls to ground wants a pull-up. A board whose button works the other way round inverts it.

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::Instant;
use embedded_hal_async::digital::Wait;
use shared_proto::Fault;

use crate::shared::{Lines, Shared};

/// Watches the emergency stop, for ever.
pub async fn emergency_stop<M: RawMutex>(shared: &Shared<M>, pin: impl Wait) -> ! {
    watch(shared, pin, Fault::EmergencyStop, |lines, on| lines.emergency_stop = on).await
}

/// Watches the motor driver's fault line, for ever.
pub async fn driver_fault<M: RawMutex>(shared: &Shared<M>, pin: impl Wait) -> ! {
    watch(shared, pin, Fault::Driver, |lines, on| lines.driver_fault = on).await
}

async fn watch<M: RawMutex>(
    shared: &Shared<M>,
    mut pin: impl Wait,
    fault: Fault,
    mark: fn(&mut Lines, bool),
) -> ! {
    loop {
        // A pin that cannot be read is treated as asserted: the robot does not drive blind.
        let _ = pin.wait_for_low().await;
        shared.lines.update(|lines| mark(lines, true));
        shared.raise(fault, Instant::now().as_micros());
        if pin.wait_for_high().await.is_err() {
            core::future::pending::<()>().await;
        }
        shared.lines.update(|lines| mark(lines, false));
    }
}
