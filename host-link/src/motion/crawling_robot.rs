//! A robot that answers every request and never stops driving, and whose clock is a thousand times too slow.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::future::pending;
use std::rc::Rc;

use futures_lite::future::block_on;
use shared_proto::{
    Answer, Channel, Command, Decoder, Encoder, Fault, FaultReport, Hello, LinkStatistics,
    MotionEnd, Pose, PoseDeviation, Reply, Request, State, Status, Telemetry, WheelAtFault,
    WheelPair, WheelTelemetry,
};

use super::rest::faulted;
use super::{Motion, RecordOptions, drive};
use crate::clock::{Clock, TimeSource};
use crate::error::Error;
use crate::lease::{Holder, LEASE};
use crate::session::Session;
use crate::wire::{Waiting, Wire};

/// How many times slower its clock is.
const SLOWER: u64 = 1000;

/// Time that passes as it is waited for.
#[derive(Clone, Default)]
struct Time(Rc<Cell<u64>>);

impl TimeSource for Time {
    fn now_us(&self) -> u64 {
        self.0.get()
    }

    fn sleep_until_us(&self, t_us: u64) -> Waiting<'_, ()> {
        self.0.set(self.0.get().max(t_us) + 1);
        Box::pin(async {})
    }

    fn is_virtual(&self) -> bool {
        true
    }
}

struct Robot {
    time: Time,
    decoder: Decoder,
    encoder: Encoder,
    state: Rc<Cell<State>>,
    renewals: Rc<RefCell<u64>>,
    number: u32,
    sent: VecDeque<Vec<u8>>,
}

impl Robot {
    fn status(&self) -> Status {
        Status {
            t_us: self.time.now_us() / SLOWER,
            state: self.state.get(),
            motion: None,
            motion_end: Some(MotionEnd::Stopped),
            fault: None,
            supply_mv: 12_000,
            link: LinkStatistics::default(),
            ticks: 0,
            tick_delay_us_max: 0,
            ticks_lost: 0,
        }
    }

    fn answer(&mut self, request: &Request) {
        match request.command {
            Command::Arm { .. } => self.state.set(State::Armed),
            Command::Drive(_) => self.state.set(State::Driving),
            Command::Renew { .. } => *self.renewals.borrow_mut() += 1,
            Command::Stop | Command::EmergencyStop | Command::Disarm => self.state.set(State::Idle),
            _ => {}
        }
        let answer = match request.command {
            Command::Status => Answer::Status(self.status()),
            _ => Answer::Done,
        };
        let reply = Reply {
            session: request.session,
            id: request.id,
            t_us: self.time.now_us() / SLOWER,
            outcome: Ok(answer),
        };
        self.sent.push_back(self.encoder.message(&reply).to_vec());
        let telemetry = Telemetry {
            number: self.number,
            t_us: self.time.now_us() / SLOWER,
            state: self.state.get(),
            probing: false,
            wheels: WheelPair::both(WheelTelemetry::default()),
            supply_mv: 12_000,
            pose: Pose::default(),
            deviation: PoseDeviation::default(),
        };
        self.number += 1;
        self.sent.push_back(self.encoder.message(&telemetry).to_vec());
    }
}

impl Wire for Robot {
    fn write<'a>(&'a mut self, bytes: &'a [u8]) -> Waiting<'a, std::io::Result<()>> {
        for byte in bytes {
            let Some(Ok(frame)) = self.decoder.push(*byte) else { continue };
            let hello = (frame.channel == Channel::Hello).then(|| frame.hello()).flatten();
            let request = frame.message::<Request>();
            if let Some(hello) = hello {
                self.sent
                    .push_back(self.encoder.hello(Hello::of_this_build(hello.session)).to_vec());
            }
            if let Some(request) = request {
                self.answer(&request);
            }
        }
        Box::pin(async { Ok(()) })
    }

    fn read(&mut self) -> Waiting<'_, std::io::Result<Vec<u8>>> {
        Box::pin(async {
            match self.sent.pop_front() {
                Some(bytes) => Ok(bytes),
                None => pending().await,
            }
        })
    }
}

fn session(robot: Robot) -> Session {
    let clock = Clock::new(robot.time.clone());
    Session::new(robot, clock, 1, "test".into())
}

impl Default for Robot {
    fn default() -> Self {
        Self {
            time: Time::default(),
            decoder: Decoder::new(),
            encoder: Encoder::new(),
            state: Rc::new(Cell::new(State::Idle)),
            renewals: Rc::default(),
            number: 0,
            sent: VecDeque::new(),
        }
    }
}

#[test]
fn a_motion_that_nobody_renewed_was_ended_by_the_silent_holder() {
    let mut session = session(Robot::default());
    let report = |fault| FaultReport {
        fault,
        number: 1,
        t_us: 0,
        followed_by: 0,
        wheels: WheelPair::both(WheelAtFault::default()),
        supply_mv: 12_000,
    };
    let is_cancelled = |session: &Session, fault| faulted(session, report(fault)).is_cancelled();
    assert!(!is_cancelled(&session, Fault::TimeToLive));
    let holder = Holder::default();
    session.hold_by(&holder);
    std::thread::sleep(LEASE * 4 / 5);
    assert!(is_cancelled(&session, Fault::TimeToLive));
    assert!(!is_cancelled(&session, Fault::SupplyLow));
}

#[test]
fn a_motion_is_not_renewed_for_ever_for_a_robot_whose_clock_crawls() {
    let robot = Robot::default();
    let (time, state, renewals) =
        (robot.time.clone(), Rc::clone(&robot.state), Rc::clone(&robot.renewals));
    let mut session = session(robot);
    let motion = Motion { distance: WheelPair::both(1.0), ..Motion::PAPER };
    let driven = block_on(async {
        session.open().await?;
        drive(&mut session, &motion, RecordOptions::default(), &mut |_| ()).await
    });
    let error = driven.unwrap_err();
    assert!(matches!(error, Error::ClockCrawls { .. }), "{error}");
    // Told to stop, and not a minute after it should have: some seven seconds of motion.
    assert_eq!(state.get(), State::Idle);
    assert!(*renewals.borrow() > 0 && time.now_us() < 120_000_000, "{} us", time.now_us());
}
