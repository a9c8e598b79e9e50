//! A simulated robot in virtual time, a session with it, and an observer of what really happens.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use futures_lite::future;
use host_link::motion::Motion;
use host_link::session::Session;
use shared_proto::{
    Answer, Command, FaultReport, Key, MotionId, Refusal, State, TravelUnit, WheelPair,
};
use sim_target::plant::Pose;
use sim_target::{HostWire, Options, Scenario, SimTarget, Testbed, now_us, sleep_until_us};

/// Time between two snapshots: a control period \[us\].
const SNAPSHOT_EVERY_US: u64 = 1000;

/// The true state of the robot at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    /// When \[us\].
    pub t_us: u64,
    /// Where the robot is.
    pub pose: Pose,
    /// Travel of each wheel's rim \[m\].
    pub rolled_m: WheelPair<f64>,
    /// Current in each motor \[A\]; exactly zero when its driver is off.
    pub current_a: WheelPair<f64>,
}

/// A robot in its testbed, and a host that has shaken hands with it.
pub struct Robot {
    /// The host's session.
    pub session: Session,
    /// What surrounds the robot.
    pub testbed: Testbed,
    /// The host's end of the line, for what no well-behaved host does.
    pub wire: HostWire,
    key: Option<Key>,
    snapshots: Rc<RefCell<Vec<Snapshot>>>,
}

/// Runs a procedure on a robot in virtual time, while an observer takes snapshots.
pub fn on_robot<T>(scenario: &Scenario, procedure: impl AsyncFnOnce(&mut Robot) -> T) -> T {
    on_robot_with(scenario, Options::default(), procedure)
}

/// As [`on_robot`], with a given flash or configuration.
pub fn on_robot_with<T>(
    scenario: &Scenario,
    options: Options,
    procedure: impl AsyncFnOnce(&mut Robot) -> T,
) -> T {
    let key = options.key;
    let mut target = SimTarget::new(scenario, options).expect("the flash's file can be read");
    let (testbed, wire) = (target.testbed(), target.host_wire());
    let snapshots = Rc::new(RefCell::new(Vec::new()));
    let observer = observer(testbed.clone(), snapshots.clone());
    let mut robot = Robot { session: new_session(&wire, 1, key), testbed, wire, key, snapshots };
    target.run(future::or(
        async {
            robot.session.open().await.expect("the robot answers");
            procedure(&mut robot).await
        },
        observer,
    ))
}

/// As [`on_robot`] without the observer, who takes time: for benchmarks.
pub fn on_unwatched_robot<T>(
    scenario: &Scenario,
    procedure: impl AsyncFnOnce(&mut Session) -> T,
) -> T {
    let mut target = SimTarget::new(scenario, Options::default()).expect("there is no file");
    let mut session = new_session(&target.host_wire(), 1, None);
    target.run(async {
        session.open().await.expect("the robot answers");
        procedure(&mut session).await
    })
}

fn new_session(wire: &HostWire, number: u32, key: Option<Key>) -> Session {
    let mut session = sim_link::session(wire, number, "sim");
    if let Some(key) = key {
        session.use_key(key, own_secret(number));
    }
    session
}

/// What a host of this number draws its nonces from.
pub fn own_secret(number: u32) -> Key {
    Key::new(std::array::from_fn(|i| number.to_le_bytes()[i % 4] ^ i as u8))
}

async fn observer<T>(testbed: Testbed, snapshots: Rc<RefCell<Vec<Snapshot>>>) -> T {
    loop {
        snapshots.borrow_mut().push(snapshot(&testbed));
        sleep_until_us(now_us() + SNAPSHOT_EVERY_US).await;
    }
}

fn snapshot(testbed: &Testbed) -> Snapshot {
    testbed.plant(|plant| Snapshot {
        t_us: plant.t_us(),
        pose: plant.pose(),
        rolled_m: plant
            .wheel_angles_rad()
            .zip(plant.parameters().geometry.wheel_radius_m)
            .map(|(angle_rad, radius_m)| angle_rad * radius_m),
        current_a: plant.currents_a(),
    })
}

impl Snapshot {
    /// Whether a motor carries current.
    pub fn is_powered(&self) -> bool {
        self.current_a.any(|current_a| current_a != 0.0)
    }

    /// Farthest that a wheel's rim or the robot's middle has moved since an earlier snapshot \[m\].
    pub fn moved_since_m(&self, earlier: &Snapshot) -> f64 {
        let rims_m =
            self.rolled_m.zip(earlier.rolled_m).map(|(now_m, then_m)| (now_m - then_m).abs());
        let way = self.pose.relative_to(earlier.pose);
        rims_m.left.max(rims_m.right).max(way.x_m.hypot(way.y_m))
    }
}

impl Robot {
    /// The true state now.
    pub fn snapshot(&self) -> Snapshot {
        snapshot(&self.testbed)
    }

    /// All snapshots from this time on.
    pub fn snapshots_from(&self, t_us: u64) -> Vec<Snapshot> {
        self.snapshots.borrow().iter().copied().filter(|snapshot| snapshot.t_us >= t_us).collect()
    }

    /// Forgets all snapshots, in a test that takes long.
    pub fn forget_snapshots(&self) {
        self.snapshots.borrow_mut().clear();
    }

    /// The last time at which a motor carried current, after `t_us` \[us\].
    pub fn last_powered_us(&self, t_us: u64) -> Option<u64> {
        self.snapshots_from(t_us)
            .iter()
            .rev()
            .find(|snapshot| snapshot.is_powered())
            .map(|snapshot| snapshot.t_us)
    }

    /// Does nothing for this long; messages from the robot are kept.
    pub async fn listen(&mut self, s: f64) {
        self.session.listen(Duration::from_secs_f64(s)).await.expect("the line is there");
    }

    /// Sends a command; a refusal is an answer.
    pub async fn ask(&mut self, command: Command) -> Result<Answer, Refusal> {
        self.session.ask(command).await.expect("the robot answers")
    }

    /// Sends a command that must succeed.
    pub async fn tell(&mut self, command: Command) -> Answer {
        self.ask(command.clone()).await.unwrap_or_else(|refusal| panic!("{command:?}: {refusal:?}"))
    }

    /// The robot's state.
    pub async fn state(&mut self) -> State {
        self.session.status().await.expect("the robot answers").state
    }

    /// The latched fault.
    pub async fn fault(&mut self) -> Option<FaultReport> {
        self.session.status().await.expect("the robot answers").fault
    }

    /// Starts a motion with the motors on; it lives for [`LEASE`](host_link::session::LEASE).
    pub async fn drive(&mut self, motion: &Motion) -> Result<MotionId, Refusal> {
        let id = self.session.new_motion();
        self.ask(Command::Drive(motion.drive_now(id))).await.map(|_| id)
    }

    /// Arms, starts a motion and renews it for this long \[s\].
    pub async fn cruise(&mut self, motion: &Motion, s: f64) -> MotionId {
        self.tell(Command::Arm { take: false }).await;
        let id = self.drive(motion).await.expect("the robot drives");
        self.renew(id, s).await;
        id
    }

    /// Keeps a motion alive for this long \[s\].
    pub async fn renew(&mut self, motion: MotionId, s: f64) {
        let until_us = now_us() + (s * 1e6).round() as u64;
        while now_us() < until_us {
            // It is for the caller to notice a motion that has ended by itself or by a fault.
            let _ = self.ask(Command::Renew { motion }).await;
            // To the microsecond: what follows has to happen at exactly that time.
            let pause_us = until_us.saturating_sub(now_us()).min(50_000);
            self.session.listen(Duration::from_micros(pause_us)).await.expect("the line is there");
        }
    }

    /// Renews a motion until the robot stands still.
    pub async fn finish(&mut self, motion: MotionId) {
        while matches!(self.state().await, State::Driving | State::Stopping) {
            self.renew(motion, 0.05).await;
        }
    }

    /// A new host on the same line, after the last one was killed.
    pub async fn reconnect(&mut self, number: u32) {
        let _killed = self.another_host(number).await;
    }

    /// Another host on the same line takes the place of this one, which is returned.
    pub async fn another_host(&mut self, number: u32) -> Session {
        let before =
            std::mem::replace(&mut self.session, new_session(&self.wire, number, self.key));
        self.session.open().await.expect("the robot answers");
        before
    }
}

/// A motion in metres.
pub const fn meters(left: f64, right: f64, cruise: f64, acceleration: f64) -> Motion {
    let distance = WheelPair::new(left, right);
    Motion { unit: TravelUnit::Meter, distance, cruise, acceleration }
}
