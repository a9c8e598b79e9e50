//! The session with the robot: passes telemetry to the page, and the page's wishes to the robot.

use std::time::{Duration, Instant};

use host_link::address::Address;
use host_link::fault_in_words::FaultInWords;
use host_link::motion::Motion;
use host_link::session::LEASE;
use host_link::{Cancel, Error, Session, key_file};
use serde_json::{Value, json};
use shared_proto::{
    Answer, Command, Config, Event, FaultReport, Identity, Key, MotionId, Refusal, State,
    TravelUnit, Velocity, WheelPair,
};

use super::asked::on_page;
use super::robot::{HeldMotion, Hold, Robot, Wish};
use crate::advice;
use crate::escape::seen;

/// Why something was refused is said for so long.
const SAID_FOR: Duration = Duration::from_secs(8);

/// No ramp of a motion from the page takes longer.
const RAMP_MAX: Duration = Duration::from_secs(10);

/// Time between two frames of telemetry \[ms\]: 500 a second, where the line carries them.
const PERIOD_MS: u16 = 2;

/// The same on a serial line below this rate \[baud\], which 500 frames of 70 bytes would fill.
const PERIOD_SLOW_MS: u16 = 10;
const FAST_BAUD: u32 = 900_000;

/// The page's wishes are looked at this often.
const EVERY: Duration = Duration::from_millis(8);

/// The robot's condition is asked this often.
const CONDITION_EVERY: Duration = Duration::from_millis(400);

/// A robot that does not answer is tried again after this long.
const AGAIN_AFTER: Duration = Duration::from_secs(1);

/// Ramps of motions from the page, as a share of the largest acceleration.
const ACCELERATION_SHARE: f64 = 0.5;

/// Keeps a session with the robot at this address until `end` is requested; if it is lost, it is looked for again. At the end a robot that
/// moves because of the page is left standing with its motors off: the error says that it was not.
pub fn keep_session(
    address: &Address,
    key: Option<&Key>,
    robot: &Robot,
    end: &Cancel,
) -> host_link::Result<()> {
    loop {
        let mut moves = false;
        let ended = host_link::connect(address).and_then(|mut session| {
            if let Some(key) = key {
                session.use_key(*key, key_file::random()?);
            }
            host_link::block_on(RobotSession::run(
                &mut session,
                robot,
                period_ms(address),
                end,
                &mut moves,
            ))
        });
        match ended {
            Ok(()) => return Ok(()),
            Err(error) if end.is_requested() && moves => return Err(error),
            Err(error) => robot.tell(json!({
                "problem": error.to_string(),
                "advice": advice::on_link(&error),
                "port": address.to_string(),
            })),
        }
        let again = Instant::now() + AGAIN_AFTER;
        while Instant::now() < again {
            if end.is_requested() {
                return Ok(());
            }
            std::thread::sleep(EVERY);
        }
        // A wish of before must not move a robot that comes back.
        robot.take_wishes();
    }
}

/// How often the robot at this address is asked to speak \[ms\].
fn period_ms(address: &Address) -> u16 {
    match address {
        Address::Serial { baud, .. } if *baud < FAST_BAUD => PERIOD_SLOW_MS,
        _ => PERIOD_MS,
    }
}

/// An open session.
struct RobotSession<'a> {
    session: &'a mut Session,
    robot: &'a Robot,
    period_ms: u16,
    identity: Identity,
    config: Config,
    /// The motion under way.
    driving: Option<Driving>,
    /// Motions up to this number have ended.
    ended: u64,
    /// The motors are on because of the page.
    armed: bool,
    state: State,
    fault: Option<FaultReport>,
    /// What was refused, and when.
    message: Option<(String, Instant)>,
    /// Frames of telemetry since the condition was asked last.
    heard: usize,
}

struct Driving {
    page: u64,
    number: u64,
    id: MotionId,
    held: Instant,
}

impl<'a> RobotSession<'a> {
    /// Until `end` is requested. `moves` says whether the robot may move because of the page.
    async fn run(
        session: &'a mut Session,
        robot: &'a Robot,
        period_ms: u16,
        end: &Cancel,
        moves: &mut bool,
    ) -> host_link::Result<()> {
        session.open().await?;
        let identity = session.identify().await?;
        let config = session.read_config().await?;
        robot.set_config(&config);
        let mut robot_session = Self {
            session,
            robot,
            period_ms,
            identity,
            config,
            driving: None,
            ended: 0,
            armed: false,
            state: State::Boot,
            fault: None,
            message: None,
            heard: 0,
        };
        let mut asked: Option<Instant> = None;
        while !end.is_requested() {
            if asked.is_none_or(|asked| asked.elapsed() > CONDITION_EVERY) {
                robot_session.ask_condition().await?;
                asked = Some(Instant::now());
            }
            for wish in robot.take_wishes() {
                *moves |= matches!(wish, Wish::Hold(_));
                robot_session.carry_out(wish).await?;
            }
            robot_session.session.listen(EVERY).await?;
            robot_session.take_what_came();
            robot_session.leave_off().await?;
            *moves = robot_session.armed || robot_session.driving.is_some();
        }
        robot_session.bring_to_rest().await
    }

    /// Brakes, and switches the motors off, if they are on because of the page.
    async fn bring_to_rest(&mut self) -> host_link::Result<()> {
        if !self.armed && self.driving.is_none() {
            return Ok(());
        }
        // Refused by a robot that a fault has stopped, or that somebody else drives by now.
        let _ = self.session.ask(Command::Stop).await?;
        let _ = self.session.ask(Command::Disarm).await?;
        let begun = Instant::now();
        while begun.elapsed() < RAMP_MAX {
            let status = self.session.status().await?;
            if matches!(status.state, State::Boot | State::Idle | State::Faulted) {
                return Ok(());
            }
            if let Some(motion) = status.motion {
                self.session.post(Command::Renew { motion }).await?;
            }
            self.session.listen(EVERY).await?;
        }
        Err(Error::NeverStands)
    }

    /// State and fault; and telemetry, if none has come, as another host may have ended it, or if the robot moves without
    /// our doing: then the answer says whether another host drives it.
    async fn ask_condition(&mut self) -> host_link::Result<()> {
        let status = self.session.status().await?;
        (self.state, self.fault) = (status.state, status.fault);
        self.message.take_if(|(_, said)| said.elapsed() > SAID_FOR);
        let moves = !matches!(self.state, State::Boot | State::Idle | State::Faulted);
        let is_ours = self.armed || self.driving.is_some();
        let silent = std::mem::take(&mut self.heard) == 0;
        if silent || self.session.overhears() || (moves && !is_ours) {
            match self.session.ask(Command::Subscribe { period_ms: self.period_ms }).await? {
                // A robot that another host drives is watched.
                Err(Refusal::Driven) => self.session.overhear(),
                Err(refusal) => return Err(Error::Refused { request: "send telemetry", refusal }),
                Ok(_) => {}
            }
        }
        self.tell();
        Ok(())
    }

    fn take_what_came(&mut self) {
        let mut last = None;
        let frames: Vec<_> = self.session.take_telemetry().collect();
        if let Some(frame) = frames.last() {
            last = Some(frame.state);
        }
        self.heard += frames.len();
        self.robot.push(frames.into_iter());
        let events: Vec<Event> = self.session.take_events().collect();
        for event in events {
            match event {
                Event::Fault(report) => self.fault = Some(report),
                Event::MotionEnded { motion, .. } => self.end(|driving| driving.id == motion),
                Event::State { state, .. } => last = Some(state),
            }
        }
        if let Some(state) = last.filter(|state| *state != self.state) {
            self.state = state;
            self.tell();
        }
    }

    fn end(&mut self, which: impl Fn(&Driving) -> bool) {
        if let Some(driving) = self.driving.take_if(|driving| which(driving)) {
            self.ended = driving.number;
        }
    }

    /// What nobody holds any more has ended; a robot that then stands still gets its motors switched off.
    async fn leave_off(&mut self) -> host_link::Result<()> {
        self.end(|driving| driving.held.elapsed() > 2 * LEASE);
        if self.armed && self.driving.is_none() && self.state == State::Armed {
            self.armed = false;
            // Refused by a robot that somebody else drives by now.
            let _ = self.session.ask(Command::Disarm).await?;
        }
        Ok(())
    }

    async fn carry_out(&mut self, wish: Wish) -> host_link::Result<()> {
        if !matches!(wish, Wish::Hold(_)) {
            self.message = None;
        }
        let outcome = match wish {
            Wish::Hold(hold) => return self.hold(hold).await,
            Wish::Stop => {
                self.end(|_| true);
                self.session.ask(Command::Stop).await?
            }
            Wish::CutMotors => {
                self.end(|_| true);
                self.session.ask(Command::EmergencyStop).await?
            }
            Wish::Clear => match self.fault {
                Some(report) => {
                    self.session.ask(Command::ClearFault { number: report.number }).await?
                }
                None => return Ok(()),
            },
        };
        self.note("do that", outcome);
        self.ask_condition().await
    }

    /// Begins a motion, or gives it another lease.
    async fn hold(&mut self, hold: Hold) -> host_link::Result<()> {
        if hold.number <= self.ended {
            return Ok(());
        }
        // Another page drives: it has to let go first.
        if self.driving.as_ref().is_some_and(|driving| driving.page != hold.page) {
            return Ok(());
        }
        if let Some(driving) = self.driving.as_mut().filter(|one| one.number == hold.number) {
            driving.held = Instant::now();
            let motion = driving.id;
            let command = match hold.motion {
                HeldMotion::Velocity { .. } => self.command(hold.motion, motion),
                _ => Command::Renew { motion },
            };
            return self.session.post(command).await;
        }
        let armed = self.session.ask(Command::Arm { take: false }).await?;
        self.armed |= armed.is_ok();
        let id = self.session.new_motion();
        let begun = match armed {
            Ok(_) => {
                // The robot tells others that it is driven, if its driver takes the telemetry.
                let subscribe = Command::Subscribe { period_ms: self.period_ms };
                let _ = self.session.ask(subscribe).await?;
                let command = self.command(hold.motion, id);
                self.session.ask(command).await?
            }
            refused => refused,
        };
        match begun.is_ok() {
            true => {
                let (page, number) = (hold.page, hold.number);
                self.driving = Some(Driving { page, number, id, held: Instant::now() });
                self.message = None;
                self.tell();
            }
            // It is asked once: the page counts on for the next.
            false => self.ended = hold.number,
        }
        self.note("drive", begun);
        Ok(())
    }

    fn command(&self, wanted: HeldMotion, motion: MotionId) -> Command {
        let acceleration = ACCELERATION_SHARE * self.config.limits.acceleration_mps2_max;
        let drive = |distance: WheelPair<f64>, cruise: f64| {
            let profile = Motion { unit: TravelUnit::Meter, distance, cruise, acceleration };
            Command::Drive(profile.drive_now(motion))
        };
        match wanted {
            HeldMotion::Velocity { forward_mps, turn_rad_s } => Command::Velocity(Velocity {
                motion,
                forward_mps,
                turn_rad_s,
                acceleration_mps2: acceleration,
            }),
            HeldMotion::Straight { distance_m, speed_mps } => {
                drive(WheelPair::both(distance_m), speed_mps)
            }
            HeldMotion::Arc { radius_m, angle_rad, speed_mps } => {
                let half_m = angle_rad.signum() * self.config.geometry.track_width_m / 2.0;
                let travel_m = |wheel_radius_m: f64| angle_rad.abs() * wheel_radius_m;
                let wheels =
                    WheelPair::new(travel_m(radius_m - half_m), travel_m(radius_m + half_m));
                drive(wheels, speed_mps)
            }
            HeldMotion::Spin { angle_rad, speed_mps } => {
                let travel_m = angle_rad * self.config.geometry.track_width_m / 2.0;
                drive(WheelPair::new(-travel_m, travel_m), speed_mps)
            }
        }
    }

    /// Says on the page why the robot refuses something.
    fn note(&mut self, request: &'static str, outcome: Result<Answer, Refusal>) {
        if let Err(refusal) = outcome {
            let error = Error::Refused { request, refusal };
            let advice =
                advice::on_link(&error).map_or_else(String::new, |words| format!("; {words}"));
            self.message = Some((on_page(&format!("{error}{advice}")), Instant::now()));
            self.tell();
        }
    }

    fn tell(&self) {
        let Identity { name, board, firmware, limits, .. } = &self.identity;
        let fault = self.fault.as_ref().map(|report| {
            json!({"words": FaultInWords(report).to_string(), "remedy": report.fault.remedy()})
        });
        let [major, minor, patch] = firmware;
        self.robot.tell(json!({
            "problem": Value::Null,
            "name": seen(name.as_str()),
            "board": seen(board.as_str()),
            "firmware": format!("{major}.{minor}.{patch}"),
            "state": self.state.name(),
            "fault": fault,
            "message": self.message.as_ref().map(|(words, _)| words),
            "driven_by_another": self.session.overhears(),
            "ended": self.ended,
            "page": self.driving.as_ref().map(|driving| driving.page),
            "track_width_m": self.config.geometry.track_width_m,
            "speed_mps_max": limits.speed_mps_max,
            "acceleration_mps2": ACCELERATION_SHARE * limits.acceleration_mps2_max,
            "frames_lost": self.session.statistics().telemetry_lost,
        }));
    }
}
