//! Runs a case: one life of the board, from power-on.

use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;
use std::time::Duration;

use futures_lite::future;
use host_link::motion::Motion;
use host_link::session::Session;
use shared_proto::{Command, Fault, MotionEnd, MotionId, Refusal, State, TravelUnit, WheelPair};
use sim_target::{now_us, sleep_until_us};

use super::draw::Case;
use super::fault_injection::{Host, World};
use super::fault_kind::FaultKind;
use super::judge::{Verdict, judge};
use super::observed::{Happened, Observed};
use super::script::Script;
use crate::emulation::Emulation;
use crate::monitor::Bench;
use crate::motor_driver::Wiring;

/// After what happened last the host waits this long before it looks \[us\]: longer than any bound, but a ramp's.
const SETTLE_US: u64 = 300_000;
/// The same where the robot brakes along a ramp: 250 ms, 0.35 m/s at 0.5 m/s^2, 250 ms to settle.
const SETTLE_RAMP_US: u64 = 1_300_000;
/// The drive afterwards: a few centimetres.
const AGAIN: Motion = Motion {
    unit: TravelUnit::Meter,
    distance: WheelPair::both(0.03),
    cruise: 0.1,
    acceleration: 0.5,
};
/// It ends this close to its target, or within two counts \[m\].
const AGAIN_M_MAX: f64 = 0.0015;
/// And with other gains: 2 mm by the counts, and a count at the beginning and at the end.
const SOFT_M_MAX: f64 = 2.5e-3;
/// A wheel that turns less in 3 ms stands \[rad\]: 10 mm/s.
const STANDS_RAD: f64 = 0.03 / 36.0;

/// Runs a case on this image.
pub fn run(image: &Path, case: &Case) -> Result<Verdict, String> {
    let emulation = Emulation {
        wiring: Wiring { driver: case.driver, ..Wiring::default() },
        ..Emulation::of(image, case.scenario.clone())
    };
    let copy = case.clone();
    let ended = emulation
        .run(move |bench: Bench| async move { live(bench, &copy).await })
        .map_err(|error| error.to_string())?;
    let mut observed = ended.found;
    observed.wrong.extend(ended.unexpected);
    Ok(judge(case, &observed))
}

async fn live(mut bench: Bench, case: &Case) -> Observed {
    let world = World {
        testbed: bench.testbed.clone(),
        monitor: bench.monitor.clone(),
        wire: bench.wire.clone(),
        host: Rc::new(Cell::new(Host::Well)),
        supply_v: case.scenario.plant.supply.open_circuit_v,
        driver: case.driver,
        lasting: Rc::default(),
    };
    let (due_us, happened_us) = (Rc::new(Cell::new(None)), Rc::new(Cell::new(None)));
    let mut observed = Observed::default();
    let script = Script {
        session: &mut bench.session,
        case,
        world: world.clone(),
        due_us: due_us.clone(),
        happened_us: happened_us.clone(),
        timeline: Default::default(),
    };
    let (timeline, happened) = future::zip(
        play(script, world.host.clone(), &due_us),
        break_things(case, &world, &due_us, &happened_us),
    )
    .await;
    (observed.timeline, observed.happened) = (timeline, happened);
    if let Some(last) = observed.happened.last() {
        let ramp = observed.happened.iter().any(|happened| may_ramp(happened.kind));
        let settle_us = if ramp { SETTLE_RAMP_US } else { SETTLE_US };
        sleep_until_us(last.at_us + settle_us).await;
    }
    let mut after =
        After { session: bench.session(2), world: &world, case, observed: &mut observed };
    if let Err(error) = after.look().await {
        observed.wrong.push(error);
    }
    observed
}

/// Whether the robot brakes along a ramp for this.
fn may_ramp(kind: FaultKind) -> bool {
    matches!(
        kind,
        FaultKind::LinkCut | FaultKind::LinkToRobotCut | FaultKind::HostDies | FaultKind::HostHangs
    )
}

/// The host's program, until it ends or dies.
async fn play(
    mut script: Script<'_>,
    host: Rc<Cell<Host>>,
    due_us: &Cell<Option<u64>>,
) -> super::observed::Timeline {
    let died = async {
        while host.get() != Host::Dead {
            sleep_until_us(now_us() + 100).await;
        }
    };
    // A robot that does not go along ends the program: it is looked at afterwards.
    let played = async {
        let _ = script.run().await;
    };
    future::or(played, died).await;
    if due_us.get().is_none() {
        // The instant never came, and will not.
        due_us.set(Some(u64::MAX));
    }
    script.timeline
}

/// Makes everything happen at its instant.
async fn break_things(
    case: &Case,
    world: &World,
    due_us: &Cell<Option<u64>>,
    happened_us: &Cell<Option<u64>>,
) -> Vec<Happened> {
    let at_us = loop {
        match due_us.get() {
            Some(u64::MAX) => return Vec::new(),
            Some(at_us) => break at_us,
            None => sleep_until_us(now_us() + 200).await,
        }
    };
    let happen = |kind, at_us: u64| async move {
        sleep_until_us(at_us).await;
        let angles_rad = world.testbed.plant(|plant| plant.wheel_angles_rad());
        let happened = Happened { kind, at_us: now_us(), angles_rad };
        if happened_us.get().is_none() {
            happened_us.set(Some(happened.at_us));
        }
        world.inject(kind).await;
        happened
    };
    match case.second {
        None => vec![happen(case.first, at_us).await],
        Some((second, later_us)) => {
            let (first, second) =
                future::zip(happen(case.first, at_us), happen(second, at_us + later_us)).await;
            vec![first, second]
        }
    }
}

/// The host that comes to look.
struct After<'a> {
    session: Session,
    world: &'a World,
    case: &'a Case,
    observed: &'a mut Observed,
}

impl After<'_> {
    async fn look(&mut self) -> Result<(), String> {
        // The host has a cable again, or is another one. All else remains.
        self.world.wire.set_cut(false);
        self.world.host.set(Host::Well);
        sleep_until_us(now_us() + 5_000).await;
        while self.world.wire.read_now(&mut [0; 256]) > 0 {}
        self.session.open().await.map_err(|error| format!("does not answer: {error}"))?;
        let mut status = self.status().await?;
        for _ in 0..60 {
            // A host that has disarmed a robot in motion has begun a stop.
            if status.state != State::Stopping {
                break;
            }
            self.listen(20).await?;
            status = self.status().await?;
        }
        let monitor = &self.world.monitor;
        self.observed.powered = monitor.powered();
        self.observed.resets_us = monitor.resets_us();
        self.observed.fault = status.fault.map(|report| report.fault);
        self.observed.motion_end = status.motion_end;
        self.observed.drives_unanswered =
            status.state == State::Driving && status.motion != self.observed.timeline.followed;
        let identity = self.session.identify().await.map_err(|error| error.to_string())?;
        self.observed.cause = Some(identity.reset_cause);
        let mut latched = status.fault.map(|report| report.number);
        if let Some(number) = latched {
            self.must_be_latched(number).await?;
        } else if self.a_motor_has_no_current() {
            latched = self.drive_on().await?;
        }
        if self.stop_line_stays_unseen() {
            return Ok(());
        }
        self.mend(latched).await?;
        self.drive_again().await
    }

    /// The task that would see the stop line closed again has stopped: the robot stays off until it is reset.
    fn stop_line_stays_unseen(&self) -> bool {
        let stops = |happened: &Happened| happened.kind == FaultKind::TaskStops("stop_line");
        self.observed.fault == Some(Fault::EmergencyStop)
            && self.observed.happened.iter().any(stops)
    }

    fn a_motor_has_no_current(&self) -> bool {
        let happened = &self.observed.happened;
        let cut = |happened: &Happened| matches!(happened.kind, FaultKind::MotorCut(_));
        matches!(happened[..], [only] if cut(&only))
            && self.observed.timeline.commanded_us.is_some()
    }

    /// Drives once more with what is broken; notes the fault, and returns its number.
    async fn drive_on(&mut self) -> Result<Option<u32>, String> {
        self.rest().await?;
        if let Err(refusal) = self.ask(Command::Arm { take: false }).await? {
            return Err(format!("cannot be armed: {refusal:?}"));
        }
        let motion = self.session.new_motion();
        if let Err(refusal) = self.ask(Command::Drive(AGAIN.drive_now(motion))).await? {
            return Err(format!("does not drive: {refusal:?}"));
        }
        let status = self.until_it_ends(motion).await?;
        self.observed.next_fault = status.fault.map(|report| report.fault);
        Ok(status.fault.map(|report| report.number))
    }

    async fn status(&mut self) -> Result<shared_proto::Status, String> {
        self.session.status().await.map_err(|error| error.to_string())
    }

    async fn ask(&mut self, command: Command) -> Result<Result<(), Refusal>, String> {
        let answer = self.session.ask(command).await.map_err(|error| error.to_string())?;
        Ok(answer.map(drop))
    }

    /// A latched fault refuses an arming, and nothing drives a motor.
    async fn must_be_latched(&mut self, number: u32) -> Result<(), String> {
        let before_us = self.world.monitor.last_powered_us();
        let armed = self.ask(Command::Arm { take: false }).await?;
        if !matches!(armed, Err(Refusal::Faulted(report)) if report.number == number) {
            self.observed.wrong.push(format!("arming while faulted: {armed:?}"));
        }
        self.listen(60).await?;
        if self.world.monitor.last_powered_us() != before_us {
            self.observed.wrong.push("driven again while faulted".into());
        }
        let again = self.status().await?;
        if again.fault.map(|report| report.number) != Some(number) {
            self.observed.wrong.push(format!("not latched: {:?}", again.fault));
        }
        Ok(())
    }

    /// Removes every cause, and clears the fault.
    async fn mend(&mut self, number: Option<u32>) -> Result<(), String> {
        for happened in &self.observed.happened {
            self.world.mend(happened.kind);
        }
        self.listen(40).await?;
        let before_us = self.world.monitor.last_powered_us();
        match number {
            Some(number) => {
                if let Err(refusal) = self.ask(Command::ClearFault { number }).await? {
                    return Err(format!("the fault cannot be cleared: {refusal:?}"));
                }
                self.listen(40).await?;
                if self.world.monitor.last_powered_us() != before_us {
                    self.observed.wrong.push("driven by clearing the fault".into());
                }
            }
            None => self.rest().await?,
        }
        let status = self.status().await?;
        if (status.state, status.fault) != (State::Idle, None) {
            return Err(format!("not idle afterwards: {:?}, {:?}", status.state, status.fault));
        }
        Ok(())
    }

    /// Disarms, whatever the robot does.
    async fn rest(&mut self) -> Result<(), String> {
        let _ = self.ask(Command::Disarm).await?;
        for _ in 0..60 {
            if self.status().await?.state == State::Idle {
                break;
            }
            self.listen(20).await?;
        }
        Ok(())
    }

    /// Renews a motion until it ends.
    async fn until_it_ends(&mut self, motion: MotionId) -> Result<shared_proto::Status, String> {
        let mut status = self.status().await?;
        for _ in 0..130 {
            if status.state != State::Driving {
                break;
            }
            let _ = self.ask(Command::Renew { motion }).await?;
            self.listen(30).await?;
            status = self.status().await?;
        }
        Ok(status)
    }

    fn angles_rad(&self) -> WheelPair<f64> {
        self.world.testbed.plant(|plant| plant.wheel_angles_rad())
    }

    /// Renews a motion, which begins only when wheels that roll stand: where that is \[rad\].
    async fn once_it_stands(&mut self, motion: MotionId) -> Result<WheelPair<f64>, String> {
        let mut at_rad = self.angles_rad();
        for look in 0..1000 {
            if look % 6 == 0 {
                let _ = self.ask(Command::Renew { motion }).await?;
            }
            self.listen(3).await?;
            let before_rad = std::mem::replace(&mut at_rad, self.angles_rad());
            if at_rad.zip(before_rad).all(|(now, before)| (now - before).abs() < STANDS_RAD) {
                break;
            }
        }
        Ok(at_rad)
    }

    async fn listen(&mut self, ms: u64) -> Result<(), String> {
        self.session.listen(Duration::from_millis(ms)).await.map_err(|error| error.to_string())
    }

    /// A few centimetres.
    async fn drive_again(&mut self) -> Result<(), String> {
        if let Some(config) = &self.case.config {
            self.session.write_config(config).await.map_err(|error| error.to_string())?;
        }
        if let Err(refusal) = self.ask(Command::Arm { take: false }).await? {
            return Err(format!("cannot be armed again: {refusal:?}"));
        }
        let motion = self.session.new_motion();
        if let Err(refusal) = self.ask(Command::Drive(AGAIN.drive_now(motion))).await? {
            return Err(format!("does not drive again: {refusal:?}"));
        }
        let start_rad = self.once_it_stands(motion).await?;
        let status = self.until_it_ends(motion).await?;
        if status.motion_end != Some(MotionEnd::Completed) {
            return Err(format!("drives no more: {:?}, {:?}", status.state, status.fault));
        }
        // The robot takes both wheels for equal.
        let radius_m = shared_proto::Config::default().geometry.wheel_radius_m;
        let driven_m = self.angles_rad().zip(start_rad).map(|(to, from)| (to - from) * radius_m);
        let m_max = AGAIN_M_MAX.max(2.0 * self.case.count_m());
        // A loop as soft as the user wants it ends where friction holds the wheel, or where docs/safety.md has a wheel that stands
        // off its target begin.
        let m_max = match self.case.has_other_gains() {
            true => m_max.max(SOFT_M_MAX).max(self.case.held_off_m() + self.case.count_m()),
            false => m_max,
        };
        if driven_m.any(|m| (m - AGAIN.distance.left).abs() > m_max) {
            return Err(format!("drives wrong afterwards: {driven_m:?} m"));
        }
        Ok(())
    }
}
