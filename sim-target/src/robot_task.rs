//! The robot's tasks by name, and which of them are stopped.

use core::cell::Cell;
use std::rc::Rc;

/// One of the firmware's tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RobotTask {
    /// Reads the encoders.
    Capture,
    /// Computes the setpoints.
    Profile,
    /// Drives the motors.
    Pid,
    /// Hands over telemetry. No safety depends on it.
    Telemetry,
    /// Sends frames.
    Transmit,
    /// Receives frames.
    Receive,
    /// Watches the emergency stop.
    EmergencyStop,
    /// Watches the motor driver's fault line.
    DriverFault,
    /// Runs the state machine.
    Supervisor,
    /// Shows the guard that the others run.
    Heartbeat,
}

impl RobotTask {
    /// The tasks on which safety depends: all but telemetry.
    pub const SAFETY: [RobotTask; 9] = [
        RobotTask::Capture,
        RobotTask::Profile,
        RobotTask::Pid,
        RobotTask::Transmit,
        RobotTask::Receive,
        RobotTask::EmergencyStop,
        RobotTask::DriverFault,
        RobotTask::Supervisor,
        RobotTask::Heartbeat,
    ];
}

/// The tasks that do not run, whatever wakes them.
#[derive(Clone, Default)]
pub(crate) struct StoppedTasks(Rc<Cell<u16>>);

impl StoppedTasks {
    pub(crate) fn stop(&self, task: RobotTask) {
        self.0.set(self.0.get() | 1 << task as u16);
    }

    /// After a restart all tasks run.
    pub(crate) fn clear(&self) {
        self.0.set(0);
    }

    pub(crate) fn contains(&self, task: RobotTask) -> bool {
        self.0.get() & 1 << task as u16 != 0
    }
}
