//! Frames out.

use embassy_futures::select::select3;
use embassy_sync::blocking_mutex::raw::RawMutex;
use embedded_io_async::Write;
use shared_proto::{Access, Encoder, Frame, Greeting, Key, Nonce, Opened};

use crate::liveness::SafetyTask;
use crate::shared::{Outgoing, Shared};

/// Sends frames, for ever.
pub async fn transmit<M: RawMutex>(shared: &Shared<M>, mut writer: impl Write) -> ! {
    let mut sender = Sender { encoder: Encoder::new(), seal: None, greeted: false };
    loop {
        let ready = select3(
            shared.greetings.ready_to_receive(),
            shared.outgoing.ready_to_receive(),
            shared.telemetry.ready_to_receive(),
        );
        shared.liveness.while_waiting(SafetyTask::Transmit, ready).await;
        let Some(frame) = sender.next_frame(shared) else { continue };
        // If the line fails, the frame is lost and the host asks again.
        let send = async { writer.write_all(&frame).await.is_ok() && writer.flush().await.is_ok() };
        let sent = shared.liveness.while_waiting(SafetyTask::Transmit, send).await;
        if sent {
            shared.link.update(|link| link.frames_sent = link.frames_sent.wrapping_add(1));
        }
    }
}

struct Sender {
    encoder: Encoder,
    /// With a key.
    seal: Option<RobotSeal>,
    /// The last frame was an answer to a new host.
    greeted: bool,
}

/// How the robot seals what it sends.
struct RobotSeal {
    key: Key,
    boot: Nonce,
    /// The last frame's.
    counter: u64,
}

impl Sender {
    /// The next frame to send, if any: telemetry only when nothing else waits. Hosts that say hello without end do not
    /// keep the others' replies waiting.
    #[inline(never)]
    fn next_frame<M: RawMutex>(&mut self, shared: &Shared<M>) -> Option<Frame> {
        self.follow(shared.access.get());
        if !core::mem::take(&mut self.greeted)
            && let Ok(greeting) = shared.greetings.try_receive()
        {
            self.greeted = true;
            return Some(self.greeting(greeting));
        }
        let Self { encoder, seal, .. } = self;
        let by = seal.as_mut().map(RobotSeal::next);
        Some(match shared.outgoing.try_receive() {
            Ok(Outgoing::Reply(reply)) => encoder.reply(&reply, by),
            Ok(Outgoing::Event(event)) => encoder.event(&event, by),
            Err(_) => encoder.telemetry(&shared.telemetry.try_receive().ok()?, by),
        })
    }

    fn greeting(&mut self, greeting: Greeting) -> Frame {
        match greeting {
            Greeting::Hello(hello, None) => self.encoder.hello(hello),
            Greeting::Hello(hello, Some(challenge)) => self.encoder.challenge(hello, challenge),
            Greeting::Opened { opened, session_key } => {
                let counter = self.seal.as_ref().map_or(0, |seal| seal.counter);
                self.encoder.opened(Opened { counter, ..opened }, &session_key)
            }
        }
    }

    /// Seals by the key in use.
    fn follow(&mut self, access: Access) {
        match access {
            Access::Holders { key, boot } => {
                if self.seal.as_ref().is_none_or(|seal| seal.boot != boot) {
                    self.seal = Some(RobotSeal { key: key.of_robot(&boot), boot, counter: 0 });
                }
            }
            Access::Nobody | Access::Everybody => self.seal = None,
        }
    }
}

impl RobotSeal {
    /// Key and counter for the next frame.
    fn next(&mut self) -> (&Key, u64) {
        self.counter += 1;
        (&self.key, self.counter)
    }
}
