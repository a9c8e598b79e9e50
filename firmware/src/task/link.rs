//! The link: frames in, frames out.
//!
//! Two tasks, so that a reply never waits for a request. The receiver checks the handshake and passes
//! requests to the supervisor; the transmitter sends replies and events first, then telemetry.

use core::future::poll_fn;

use embassy_futures::select::select;
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::channel::Channel as Queue;
use embassy_time::Instant;
use embedded_io_async::{Read, Write};
use shared_proto::{
    Channel, Command, Decoder, Encoder, Fault, Frame, FrameError, Hello, Received, Refusal, Reply,
    Request,
};

use crate::liveness::SafetyTask;
use crate::shared::{Outgoing, Shared};

/// Receives frames, for ever.
pub async fn receive<M: RawMutex>(shared: &Shared<M>, mut reader: impl Read) -> ! {
    let mut decoder = Decoder::new();
    let mut handshake = Handshake { sessions: [None; SESSIONS], next: 0 };
    let mut buffer = [0; 64];
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
            handshake.handle(shared, outcome).await;
        }
    }
}

/// So many hosts may talk at once, behind one line.
const SESSIONS: usize = 4;

/// The hosts with which the robot has agreed on the protocol.
struct Handshake {
    sessions: [Option<u32>; SESSIONS],
    /// The one that a further host replaces.
    next: usize,
}

impl Handshake {
    async fn handle<M: RawMutex>(
        &mut self,
        shared: &Shared<M>,
        outcome: Result<Received<'_>, FrameError>,
    ) {
        let Some(frame) = count(shared, outcome) else { return };
        let answer = match frame.channel {
            Channel::Hello => {
                let Some(host) = frame.hello() else { return };
                Outgoing::Hello(self.greet(shared, host))
            }
            Channel::Request => {
                let room = room(&shared.requests);
                shared.liveness.while_waiting(SafetyTask::Receive, room).await;
                match self.pass_on(shared, &frame) {
                    Ok(()) => return,
                    Err((session, refusal)) => Outgoing::Reply(Reply {
                        session,
                        id: 0,
                        t_us: Instant::now().as_micros(),
                        outcome: Err(refusal),
                    }),
                }
            }
            // Only robots send these: another robot is on the line, or an echo.
            Channel::Reply | Channel::Telemetry | Channel::Event => return,
        };
        // Never waits for the line: whoever floods it and does not read would keep the others' requests waiting.
        // A host that hears nothing asks again.
        let _ = shared.outgoing.try_send(answer);
    }

    /// Whether the robot understands this session's requests.
    fn knows(&self, session: u32) -> bool {
        self.sessions.contains(&Some(session))
    }

    /// Notes whether this host speaks our version, and answers with ours.
    #[inline(never)]
    fn greet<M: RawMutex>(&mut self, shared: &Shared<M>, host: Hello) -> Hello {
        let robot = Hello::of_this_build(host.session);
        if !host.agrees_with(&robot) {
            self.sessions.iter_mut().filter(|s| **s == Some(host.session)).for_each(|s| *s = None);
        } else if !self.knows(host.session) {
            // Nobody can push the driver out by saying hello often.
            let driver = shared.driver.get();
            if driver.is_some() && self.sessions[self.next % SESSIONS] == driver {
                self.next = self.next.wrapping_add(1);
            }
            self.sessions[self.next % SESSIONS] = Some(host.session);
            self.next = self.next.wrapping_add(1);
        }
        robot
    }

    /// Hands a request to the supervisor; otherwise whom to refuse, and why.
    #[inline(never)]
    fn pass_on<M: RawMutex>(
        &self,
        shared: &Shared<M>,
        frame: &Received<'_>,
    ) -> Result<(), (u32, Refusal)> {
        if self.sessions.iter().all(Option::is_none) {
            // A request of another protocol version is not decoded.
            return Err((0, Refusal::HelloFirst));
        }
        let request: Request = frame.message().ok_or((0, Refusal::Unreadable))?;
        // Whoever has forgotten the hello, or was forgotten, may stop the robot.
        let stops = matches!(request.command, Command::EmergencyStop | Command::Stop);
        if !self.knows(request.session) && !stops {
            return Err((request.session, Refusal::HelloFirst));
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

/// Sends frames, for ever.
pub async fn transmit<M: RawMutex>(shared: &Shared<M>, mut writer: impl Write) -> ! {
    let mut encoder = Encoder::new();
    loop {
        let ready = select(shared.outgoing.ready_to_receive(), shared.telemetry.ready_to_receive());
        shared.liveness.while_waiting(SafetyTask::Transmit, ready).await;
        let Some(frame) = next_frame(shared, &mut encoder) else { continue };
        // If the line fails, the frame is lost and the host asks again.
        let send = async { writer.write_all(&frame).await.is_ok() && writer.flush().await.is_ok() };
        let sent = shared.liveness.while_waiting(SafetyTask::Transmit, send).await;
        if sent {
            shared.link.update(|link| link.frames_sent = link.frames_sent.wrapping_add(1));
        }
    }
}

/// The next frame to send, if any: telemetry only when nothing else waits.
#[inline(never)]
fn next_frame<M: RawMutex>(shared: &Shared<M>, encoder: &mut Encoder) -> Option<Frame> {
    Some(match shared.outgoing.try_receive() {
        Ok(Outgoing::Hello(hello)) => encoder.hello(hello),
        Ok(Outgoing::Reply(reply)) => encoder.message(&reply),
        Ok(Outgoing::Event(event)) => encoder.message(&event),
        Err(_) => encoder.message(&shared.telemetry.try_receive().ok()?),
    })
}
