//! The link: frames in, frames out.
//!
//! Two halves, so that a reply never waits for a request. The receiver checks the handshake and
//! passes requests to the supervisor; the transmitter sends what the others have to say, replies
//! and events before telemetry.

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::Instant;
use embedded_io_async::{Read, Write};
use shared_proto::{
    Channel, Decoder, Encoder, FrameError, Hello, Received, Refusal, Reply, Request,
};

use crate::shared::{Outgoing, Shared};

/// Receives frames, for ever.
pub async fn receive<M: RawMutex>(shared: &Shared<M>, mut reader: impl Read) -> ! {
    let mut decoder = Decoder::new();
    let mut session = Session { agreed: false };
    let mut buffer = [0; 64];
    loop {
        let len = match reader.read(&mut buffer).await {
            Ok(len) => len,
            // An overrun or a line break: the frame under way fails its checksum.
            Err(_) => {
                embassy_futures::yield_now().await;
                continue;
            }
        };
        for &byte in &buffer[..len] {
            let Some(outcome) = decoder.push(byte) else { continue };
            session.handle(shared, outcome).await;
        }
    }
}

/// What the receiver remembers of the host.
struct Session {
    agreed: bool,
}

impl Session {
    async fn handle<M: RawMutex>(
        &mut self,
        shared: &Shared<M>,
        outcome: Result<Received<'_>, FrameError>,
    ) {
        let frame = match outcome {
            Ok(frame) => frame,
            Err(_) => {
                shared
                    .link
                    .update(|link| link.frames_damaged = link.frames_damaged.wrapping_add(1));
                return;
            }
        };
        shared.link.update(|link| {
            link.frames_received = link.frames_received.wrapping_add(1);
            link.frames_lost = link.frames_lost.wrapping_add(u32::from(frame.lost));
        });
        match frame.channel {
            Channel::Hello => {
                let Some(host) = frame.hello() else { return };
                let robot = Hello::of_this_build(host.session);
                self.agreed = host.agrees_with(&robot);
                shared.outgoing.send(Outgoing::Hello(robot)).await;
            }
            Channel::Request => {
                let refusal = if !self.agreed {
                    // A request of another protocol version is not even looked into.
                    Refusal::HelloFirst
                } else if let Some(request) = frame.message::<Request>() {
                    shared.heard_us.set(Instant::now().as_micros());
                    shared.requests.send(request).await;
                    return;
                } else {
                    Refusal::Unreadable
                };
                let reply = Reply { id: 0, outcome: Err(refusal) };
                shared.outgoing.send(Outgoing::Reply(reply)).await;
            }
            // What a robot says, not what it hears: another robot, or an echo.
            Channel::Reply | Channel::Telemetry | Channel::Event => {}
        }
    }
}

/// Sends frames, for ever.
pub async fn transmit<M: RawMutex>(shared: &Shared<M>, mut writer: impl Write) -> ! {
    let mut encoder = Encoder::new();
    loop {
        // `select` asks its first future first: telemetry is sent when nothing else waits.
        let frame = match select(shared.outgoing.receive(), shared.telemetry.receive()).await {
            Either::First(Outgoing::Hello(hello)) => encoder.hello(hello),
            Either::First(Outgoing::Reply(reply)) => encoder.message(&reply),
            Either::First(Outgoing::Event(event)) => encoder.message(&event),
            Either::Second(telemetry) => encoder.message(&telemetry),
        };
        // A line that takes nothing loses the frame; the host asks again.
        let sent = writer.write_all(&frame).await.is_ok() && writer.flush().await.is_ok();
        if sent {
            shared.link.update(|link| link.frames_sent = link.frames_sent.wrapping_add(1));
        }
    }
}
