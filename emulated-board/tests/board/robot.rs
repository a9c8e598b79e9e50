//! A robot with the flashed image, as a host drives it.

use std::time::Duration;

use emulated_board::Bench;
use host_link::motion::Motion;
use shared_proto::{Answer, Command, FaultReport, MotionId, Refusal, State, Status, WheelPair};
use sim_target::{now_us, sleep_until_us};

/// The paper's cruise, reached in one second, far enough for everything here.
pub const AHEAD: Motion =
    Motion { distance: WheelPair::both(20.0), acceleration: 0.523, ..Motion::PAPER };

/// A board with a host that knows the protocol's commands.
pub struct Robot(pub Bench);

impl Robot {
    /// Says hello.
    pub async fn meet(mut bench: Bench) -> Self {
        bench.session.open().await.unwrap();
        Self(bench)
    }

    /// Says hello again, after a restart.
    pub async fn meet_again(&mut self, number: u32) {
        // What the robot said to whoever spoke before is not for this host.
        self.listen_to_nobody().await;
        self.0.session = self.0.session(number);
        self.0.session.open().await.unwrap();
    }

    async fn listen_to_nobody(&self) {
        sleep_until_us(now_us() + 5_000).await;
        while self.0.wire.read_now(&mut [0; 256]) > 0 {}
    }

    pub async fn ask(&mut self, command: Command) -> Result<Answer, Refusal> {
        self.0.session.ask(command).await.unwrap()
    }

    pub async fn tell(&mut self, command: Command) -> Answer {
        self.ask(command.clone()).await.unwrap_or_else(|refusal| panic!("{command:?}: {refusal:?}"))
    }

    pub async fn status(&mut self) -> Status {
        self.0.session.status().await.unwrap()
    }

    pub async fn fault(&mut self) -> Option<FaultReport> {
        self.status().await.fault
    }

    pub async fn listen(&mut self, ms: u64) {
        self.0.session.listen(Duration::from_millis(ms)).await.unwrap();
    }

    /// Arms, starts a motion and renews it for this long.
    pub async fn cruise(&mut self, motion: &Motion, ms: u64) -> MotionId {
        self.tell(Command::Arm { take: false }).await;
        let id = self.0.session.new_motion();
        self.tell(Command::Drive(motion.drive_now(id))).await;
        self.renew(id, ms).await;
        id
    }

    /// Keeps a motion alive for this long. Nobody waits for the answers: a restart has none.
    pub async fn renew(&mut self, motion: MotionId, ms: u64) {
        let until_us = now_us() + ms * 1000;
        while now_us() < until_us {
            self.0.session.post(Command::Renew { motion }).await.unwrap();
            let pause_us = (until_us - now_us()).min(30_000);
            // A robot that has restarted says so, which ends the listening, not the life.
            let _ = self.0.session.listen(Duration::from_micros(pause_us)).await;
        }
    }

    /// Stops, and switches the motors off.
    pub async fn rest(&mut self) {
        self.tell(Command::Disarm).await;
        while self.status().await.state != State::Idle {
            self.listen(20).await;
        }
    }
}
