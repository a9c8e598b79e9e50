//! The link: frames in, frames out.
//!
//! Two tasks, so that a reply never waits for a request. The receiver checks who sends ([`Sessions`]) and passes
//! requests to the supervisor; the transmitter sends answers to new hosts, replies and events first, then telemetry.

mod transmit;

use core::future::poll_fn;

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::channel::Channel as Queue;
use embassy_time::{Duration, Instant, Timer};
use embedded_io_async::Read;
use shared_proto::{
    Channel, Command, Decoder, Fault, FrameError, Received, Refusal, Refused, Reply, Request,
    Sender, Sessions, State,
};

pub use transmit::transmit;

use crate::liveness::SafetyTask;
use crate::shared::{Outgoing, Shared};

/// How often the receiver looks whether the robot has booted.
const BOOT_POLL: Duration = Duration::from_millis(1);

/// Receives frames, for ever.
pub async fn receive<M: RawMutex>(shared: &Shared<M>, mut reader: impl Read) -> ! {
    let mut decoder = Decoder::new();
    let mut sessions = Sessions::new();
    let mut buffer = [0; 64];
    // Whom the robot obeys is known once its store has been read; what a host says before waits in the line.
    let booted = async {
        while shared.state.get() == State::Boot {
            Timer::after(BOOT_POLL).await;
        }
    };
    shared.liveness.while_waiting(SafetyTask::Receive, booted).await;
    loop {
        let read = reader.read(&mut buffer);
        let len = match shared.liveness.while_waiting(SafetyTask::Receive, read).await {
            Ok(len) => len,
            // An overrun or a line break: the present frame will fail its checksum.
            Err(_) => {
                embassy_futures::yield_now().await;
                continue;
            }
        };
        for &byte in &buffer[..len] {
            let Some(outcome) = decoder.push(byte) else { continue };
            handle(shared, &mut sessions, outcome).await;
        }
    }
}

async fn handle<M: RawMutex>(
    shared: &Shared<M>,
    sessions: &mut Sessions,
    outcome: Result<Received<'_>, FrameError>,
) {
    let Some(frame) = count(shared, outcome) else { return };
    let refused = match frame.channel {
        Channel::Hello => {
            greet(shared, sessions, &frame);
            return;
        }
        Channel::Open => open(shared, sessions, &frame),
        Channel::Request => match sessions.check(shared.access.get(), &frame) {
            Ok(sender) => {
                let room = room(&shared.requests);
                shared.liveness.while_waiting(SafetyTask::Receive, room).await;
                pass_on(shared, sessions, &frame, sender)
            }
            Err(refused) => Err(refused),
        },
        // Only robots send these: another robot is on the line, or an echo.
        Channel::Reply | Channel::Telemetry | Channel::Event | Channel::Opened => return,
    };
    if let Err(refused) = refused {
        refuse(shared, refused);
    }
}

#[inline(never)]
fn refuse<M: RawMutex>(shared: &Shared<M>, refused: Refused) {
    if !matches!(refused, Refused::HelloFirst(_) | Refused::Unreadable) {
        shared.link.update(|link| link.frames_refused = link.frames_refused.wrapping_add(1));
    }
    let (session, refusal) = match refused {
        Refused::Stranger(session) => (session, Refusal::Key),
        Refused::WrongKey(session) => (session, Refusal::WrongKey),
        Refused::Gone(session) | Refused::HelloFirst(session) => (session, Refusal::HelloFirst),
        Refused::Unreadable => (0, Refusal::Unreadable),
        Refused::Again => return,
    };
    let t_us = Instant::now().as_micros();
    let reply = Reply { session, id: 0, t_us, outcome: Err(refusal) };
    // Never waits for the line: whoever floods it and does not read would keep the others' requests waiting.
    // A host that hears nothing asks again.
    let _ = shared.outgoing.try_send(Outgoing::Reply(reply));
}

/// Answers a hello.
#[inline(never)]
fn greet<M: RawMutex>(shared: &Shared<M>, sessions: &mut Sessions, frame: &Received<'_>) {
    let Some(host) = frame.hello() else { return };
    let driver = shared.driver.get();
    if let Some(greeting) = sessions.greet(shared.access.get(), host, driver) {
        let _ = shared.greetings.try_send(greeting);
    }
}

/// Lets a host in that shows that it holds the key.
#[inline(never)]
fn open<M: RawMutex>(
    shared: &Shared<M>,
    sessions: &mut Sessions,
    frame: &Received<'_>,
) -> Result<(), Refused> {
    let Some(open) = frame.open() else { return Err(Refused::Unreadable) };
    let driver = shared.driver.get();
    let greeting = sessions.open(shared.access.get(), open, frame, driver)?;
    let _ = shared.greetings.try_send(greeting);
    Ok(())
}

fn is_stop(command: &Command) -> bool {
    matches!(command, Command::EmergencyStop | Command::Stop | Command::Disarm)
}

/// Hands a request to the supervisor.
#[inline(never)]
fn pass_on<M: RawMutex>(
    shared: &Shared<M>,
    sessions: &mut Sessions,
    frame: &Received<'_>,
    sender: Sender,
) -> Result<(), Refused> {
    let mut request: Request = frame.request().ok_or(Refused::Unreadable)?;
    match sender {
        Sender::Holder(session_key) => {
            if let Command::SetKey { key: Some(key) } = &mut request.command {
                *key = session_key.masked(key, request.id);
            }
        }
        // Whoever has forgotten the hello, or was forgotten, may stop the robot.
        Sender::Anybody
            if !matches!(request.command, Command::EmergencyStop | Command::Stop)
                && !sessions.knows(request.session) =>
        {
            return Err(Refused::HelloFirst(request.session));
        }
        Sender::Anybody => {
            let changes = request.command.needs_lease();
            // What was sent before a stop has no turn after it; the stop itself is obeyed whenever it comes.
            let counts = changes || is_stop(&request.command);
            let in_order = !counts || sessions.accept_in_order(request.session, request.id);
            if changes && !in_order {
                return Err(Refused::Again);
            }
        }
    }
    let now_us = Instant::now().as_micros();
    if request.command == Command::EmergencyStop {
        // Before everything that the supervisor still has to do.
        shared.raise(Fault::EmergencyStop, now_us);
    }
    if shared.driver.get().is_none_or(|driver| driver == request.session) {
        shared.heard_us.set(now_us);
    }
    let _ = shared.requests.try_send(request);
    Ok(())
}

/// Waits until a channel has room. No other task can take that room in between, since tasks beside control
/// do not interrupt one another. The message is made only then, so waiting takes no memory.
async fn room<M: RawMutex, T, const N: usize>(channel: &Queue<M, T, N>) {
    poll_fn(|context| channel.poll_ready_to_send(context)).await;
}

/// Counts a frame; returns the frame if it is good.
#[inline(never)]
fn count<'a, M: RawMutex>(
    shared: &Shared<M>,
    outcome: Result<Received<'a>, FrameError>,
) -> Option<Received<'a>> {
    shared.link.update(|link| match &outcome {
        Ok(frame) => {
            link.frames_received = link.frames_received.wrapping_add(1);
            link.frames_lost = link.frames_lost.wrapping_add(u32::from(frame.lost));
        }
        Err(_) => link.frames_damaged = link.frames_damaged.wrapping_add(1),
    });
    outcome.ok()
}
