//! Faults in the world itself: each must break the invariant that it is planted for.

use shared_proto::{Command, Decoder, Drive, Encoder, Request, Velocity, Voltage};
use sim_target::HostWire;

/// A fault planted in the world, to see the invariant that it breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plant {
    /// The server renews by itself what its host has renewed, for a second.
    ServerThatRenews,
    /// The server repeats by itself the velocity that its host asked for last, for a second.
    VelocityThatGoesOn,
    /// Voltages reach the robot with ten times the time and no limit of travel.
    VoltageThatGoesOn,
    /// Each motion reaches the robot as one that is three times as long.
    DriveObeyedThrice,
    /// Velocities reach the robot doubled, and voltages with limits that are far away.
    LimitsThatAreLifted,
    /// No emergency stop reaches the robot, and it answers as if one had.
    StopThatIsLost,
    /// After a session the flash holds what it held before, and the judge believes in what a robot said it saved.
    ConfigThatIsForgotten,
    /// The same of a key.
    KeyThatIsForgotten,
    /// The same in the middle of a session, with a key.
    CountThatIsForgotten,
    /// What a client does not read is kept for it without end.
    ServerThatHoards,
    /// A file of the campaign is cut short.
    FileThatIsCutShort,
    /// The line stays cut after the storm.
    LineThatStaysCut,
}

/// Puts a frame on the robot's line: where a fault is planted, another one.
pub fn send(wire: &HostWire, frame: &[u8], plant: Option<Plant>) {
    let Some(plant) = plant else { return wire.write_now(frame) };
    match (plant, request(frame)) {
        (Plant::StopThatIsLost, Some(Request { command: Command::EmergencyStop, .. })) => {
            // What asks for the state is answered as well.
            let request = request_like(frame, Command::Status);
            wire.write_now(&request);
        }
        (Plant::DriveObeyedThrice, Some(Request { command: Command::Drive(drive), .. })) => {
            let distance = drive.distance.map(|distance| 3.0 * distance);
            let thrice = Command::Drive(Drive { distance, ..drive });
            wire.write_now(&request_like(frame, thrice));
        }
        (Plant::VoltageThatGoesOn, Some(Request { command: Command::Voltage(asked), .. })) => {
            let duration_s = 10.0 * asked.duration_s;
            let longer = Voltage { duration_s, travel_m_max: 5.0, ..asked };
            wire.write_now(&request_like(frame, Command::Voltage(longer)));
        }
        (Plant::LimitsThatAreLifted, Some(Request { command, .. })) => {
            wire.write_now(&request_like(frame, lifted(command)));
        }
        _ => wire.write_now(frame),
    }
}

/// A command without its limits.
fn lifted(command: Command) -> Command {
    match command {
        Command::Velocity(asked) => {
            Command::Velocity(Velocity { forward_mps: 2.0 * asked.forward_mps, ..asked })
        }
        Command::Voltage(asked) => {
            let (volts, speed_mps_max) = (asked.volts.map(|volts| 2.0 * volts), 0.8);
            Command::Voltage(Voltage { volts, speed_mps_max, travel_m_max: 5.0, ..asked })
        }
        command => command,
    }
}

/// The request in a frame.
pub fn request(frame: &[u8]) -> Option<Request> {
    let mut decoder = Decoder::new();
    let mut request = None;
    for &byte in frame {
        if let Some(Ok(received)) = decoder.push(byte) {
            request = received.message();
        }
    }
    request
}

/// The frame of the same request with another command.
fn request_like(frame: &[u8], command: Command) -> Vec<u8> {
    match request(frame) {
        Some(request) => Encoder::new().message(&Request { command, ..request }).to_vec(),
        None => frame.to_vec(),
    }
}
