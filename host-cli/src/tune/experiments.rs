//! The experiments: voltages that move the robot a little, and then more as its motors become known.
//!
//! | experiment | voltages | what it tells |
//! | --- | --- | --- |
//! | break-away | a slow ramp, both ways | that the motors turn the wheels, and from which voltage on |
//! | steps | three levels, both ways | kS, kV, and kA straight on |
//! | reversal | one level, forwards and at once backwards | the delay, and play |
//! | spin | one level, both ways | kA on the spot |
//!
//! To be recorded, there are as many again: other levels, creeping, and the first ones once more. They tell which effect the
//! motors have besides.
//!
//! Longer than 400 lines because all experiments share one state: where the robot is, and what is known of its motors so far.

use host_link::motion::{VoltageRun, VoltageStep, apply_voltages};
use host_link::session::Session;
use robot_model::drivetrain::{
    self, Drivetrain, DrivetrainFit, FitError, Sample, VoltageRecording,
};
use robot_model::kinematics;
use shared_proto::{Command, Config, Fault, MotionEnd, State, Telemetry, WheelPair};

use super::floor::Floor;
use super::settings::{self, CheckFor};
use crate::error::{Error, Result};
use crate::wheel_angles::{for_model, travel_m};

/// Time between two telemetry frames \[ms\].
const PERIOD_MS: u16 = 5;
/// The break-away ramp: over the supply in so many seconds.
const BREAK_AWAY_S: f64 = 8.0;
/// It ends after this travel \[m\], or so many counts, if that is longer.
const BREAK_AWAY_M: f64 = 0.012;
const BREAK_AWAY_COUNTS: f64 = 8.0;
/// A step changes the voltage over this time from zero to the supply \[s\], where that keeps to the next constant.
const STEP_RISE_S: f64 = 0.03;
/// Faster, tyres may slide, and counts no longer tell how far the robot went \[m/s^2\]: half of the weight on the driven wheels,
/// times 0.5, the grip of rubber on a dusty floor, times g.
const ACCELERATION_MPS2_MAX: f64 = 2.5;
/// Shares of the top speed that is tuned for.
const LEVELS: [f64; 3] = [0.25, 0.55, 0.95];
/// A step takes this long, unless it would need too much floor \[s\].
const STEP_S: f64 = 1.0;
const STEP_S_MIN: f64 = 0.15;
/// Less room than this is none \[m\].
const ROOM_M_MIN: f64 = 0.02;
/// Below this share of the top speed a step is longer, as long as this \[s\].
const CREEPING: f64 = 0.2;
const CREEP_S: f64 = 3.0;
/// Other levels.
const MORE_LEVELS: [(&str, f64); 4] =
    [("creeping", 0.08), ("more steps", 0.15), ("more steps", 0.4), ("more fast steps", 0.75)];
/// The first levels once more, with warm motors.
const AGAIN_LEVELS: [(&str, f64); 5] = [
    ("steps again", LEVELS[1]),
    ("slow steps again", LEVELS[0]),
    ("creeping again", 0.08),
    ("more steps again", 0.15),
    ("more steps again", 0.4),
];
/// To warm the motors: so many turns to and fro on the spot, each so long \[s\]. Nothing takes more current, and it takes no floor.
const WARMING_TURNS: usize = 40;
const WARMING_S: f64 = 0.4;
/// What the encoder check reckons with, one try after the other. A dead encoder lets its wheel roll some centimetres in the last
/// one, and is then named.
const CHECKS: [CheckFor; 4] =
    [check_for(0.5, 1.0), check_for(1.2, 1.0), check_for(2.5, 1.0), check_for(5.0, 1.0)];
/// Two more for long counts, if a wheel has counted: a slow motor uses up the check's distance, which is reckoned with the old
/// constants, before there are enough of them.
const CHECKS_OF_SLOW: [CheckFor; 2] = [check_for(1.2, 4.0), check_for(5.0, 4.0)];
/// The first one.
pub const CHECK_FIRST: CheckFor = CHECKS[0];

const fn check_for(ks_v: f64, slower: f64) -> CheckFor {
    CheckFor { ks_v, slower }
}

/// What to look at where a wheel did not turn, with as much friction as the check can reckon with.
fn stands(check: CheckFor) -> String {
    format!(
        "the check reckoned with up to {:.1} V of friction. Look at that wheel's motor wires, its driver and supply, the encoder's plug, and whether the wheel turns easily by hand; then at counts_per_rev and gear_reduction",
        check.ks_v
    )
}

/// A longer count may be too few of them for the encoder check, which gives slow motors about a second for two \[m\].
pub const COARSE_M: f64 = 0.005;
/// Share of the supply that is used.
const SUPPLY_SHARE: f64 = 0.9;

/// What the robot does at a steady voltage.
#[derive(Clone, Copy)]
struct Cruise {
    speed_mps: f64,
    /// How far it rolls while the voltage goes to zero and the motors brake it \[m\].
    roll_m: f64,
    /// How fast the voltage may change \[V/s\].
    ramp_v_per_s: f64,
}

/// What the experiments begin from, and what they have learnt.
pub struct Experiments<'a> {
    config: &'a Config,
    supply_v: f64,
    recordings: Vec<VoltageRecording>,
    driven: Vec<DrivenExperiment>,
    /// What is driven now is more than `tune` needs.
    has_identified: bool,
    /// What the encoder check reckons with now: an index into [`CHECKS`], and on into [`CHECKS_OF_SLOW`].
    check: usize,
}

impl<'a> Experiments<'a> {
    pub fn new(config: &'a Config, supply_v: f64) -> Self {
        let (recordings, driven) = (Vec::new(), Vec::new());
        Self { config, supply_v, recordings, driven, has_identified: false, check: 0 }
    }

    /// All experiments, in an order in which each is safe by what those before have told.
    pub async fn run(
        &mut self,
        session: &mut Session,
        floor: &mut Floor,
        doing: &mut dyn FnMut(&str),
    ) -> Result<Vec<VoltageRecording>> {
        doing("break-away");
        let mut volts = 0.0_f64;
        for sign in [1.0, -1.0] {
            volts = volts.max(self.break_away(session, floor, sign).await?);
        }
        // Before the motors are known: a little above what has just turned the wheels.
        let first_v = (1.25 * volts + 0.06 * self.supply_v).min(SUPPLY_SHARE * self.supply_v);
        // The first drives may have ended behind where the robot stood, or far ahead.
        self.go_back(session, floor, first_v).await?;
        for (index, share) in LEVELS.into_iter().enumerate() {
            doing(["slow steps", "steps", "fast steps"][index]);
            for sign in [1.0, -1.0] {
                let (volts, cruise) = match (index, drivetrain::regress(&self.recordings)) {
                    (0, _) | (_, None) => (first_v * (1.0 + index as f64), None),
                    (_, Some(model)) => self.level(&model, share),
                };
                if sign < 0.0 {
                    self.make_room(session, floor, volts, cruise).await?;
                }
                self.steps(session, floor, &[(sign, sign)], volts, cruise).await?;
            }
            self.go_back(session, floor, first_v).await?;
        }
        let model = drivetrain::regress(&self.recordings).ok_or_else(no_motion)?;
        let (volts, cruise) = self.level(&model, LEVELS[1]);
        doing("reversals");
        self.steps(session, floor, &[(1.0, 1.0), (-1.0, -1.0)], volts, cruise).await?;
        doing("turns on the spot");
        for sign in [1.0, -1.0] {
            self.steps(session, floor, &[(-sign, sign)], volts, cruise).await?;
        }
        self.go_back(session, floor, first_v).await?;
        Ok(self.recordings.clone())
    }

    /// As many again, after [`run`](Self::run).
    pub async fn run_more(
        &mut self,
        session: &mut Session,
        floor: &mut Floor,
        doing: &mut dyn FnMut(&str),
    ) -> Result<()> {
        self.has_identified = true;
        let model = drivetrain::regress(&self.recordings).ok_or_else(no_motion)?;
        let back_v = self.level(&model, LEVELS[0]).0;
        doing("break-away again");
        for sign in [1.0, -1.0] {
            self.break_away(session, floor, sign).await?;
        }
        for (what, share) in MORE_LEVELS {
            doing(what);
            self.both_ways(session, floor, self.level(&model, share), back_v).await?;
        }
        doing("reversals and turns again");
        for (first, share) in [(1.0, 0.4), (-1.0, 0.7)] {
            let (volts, cruise) = self.level(&model, share);
            if first < 0.0 {
                // To have room behind.
                self.steps(session, floor, &[(1.0, 1.0)], volts, cruise).await?;
            }
            let signs = [(first, first), (-first, -first)];
            self.steps(session, floor, &signs, volts, cruise).await?;
            self.steps(session, floor, &[(first, -first)], volts, cruise).await?;
            self.go_back(session, floor, back_v).await?;
        }
        doing("warming the motors");
        self.warm_up(session, floor, &model).await?;
        self.go_back(session, floor, back_v).await?;
        for (what, share) in AGAIN_LEVELS {
            doing(what);
            self.both_ways(session, floor, self.level(&model, share), back_v).await?;
        }
        Ok(())
    }

    /// One level forwards and backwards, and back.
    async fn both_ways(
        &mut self,
        session: &mut Session,
        floor: &mut Floor,
        (volts, cruise): (f64, Option<Cruise>),
        back_v: f64,
    ) -> Result<()> {
        for sign in [1.0, -1.0] {
            self.steps(session, floor, &[(sign, sign)], volts, cruise).await?;
        }
        self.go_back(session, floor, back_v).await
    }

    /// Turns to and fro on the spot. It is no experiment: it is long, and tells nothing that a spin does not.
    async fn warm_up(
        &mut self,
        session: &mut Session,
        floor: &mut Floor,
        model: &Drivetrain,
    ) -> Result<()> {
        let (volts, _) = self.level(model, LEVELS[2]);
        let step = |turn: usize| {
            let volts = if turn.is_multiple_of(2) { volts } else { -volts };
            VoltageStep { volts: WheelPair::new(-volts, volts), duration_s: WARMING_S }
        };
        let run = VoltageRun {
            steps: (0..WARMING_TURNS).map(step).collect(),
            ramp_v_per_s: self.supply_v / STEP_RISE_S,
            travel_m_max: 1.0,
            speed_mps_max: 1.8 * self.config.limits.speed_mps_max,
            period_ms: PERIOD_MS,
        };
        let (recordings, driven) = (self.recordings.len(), self.driven.len());
        self.apply(session, floor, "warm_up", &run).await?;
        self.recordings.truncate(recordings);
        self.driven.truncate(driven);
        Ok(())
    }

    /// What was driven, for a campaign.
    pub fn driven(self) -> Vec<DrivenExperiment> {
        self.driven
    }

    /// The voltage for a share of the top speed, and what the robot does at it.
    fn level(&self, model: &Drivetrain, share: f64) -> (f64, Option<Cruise>) {
        let kinematics::WheelPair { left, right } = model.wheels;
        let ks_v = [left, right].map(|motor| motor.ks_forward_v.max(motor.ks_backward_v));
        let ks_v = ks_v[0].max(ks_v[1]);
        let kv = left.kv_v_s_per_m.min(right.kv_v_s_per_m);
        let wanted_v = ks_v + kv * share * self.config.limits.speed_mps_max;
        // Of a motor that does not reach the speed: the same share of what it has.
        let reached_v = ks_v + share * (SUPPLY_SHARE * self.supply_v - ks_v).max(0.0);
        let volts = wanted_v.min(reached_v);
        let speed_mps = ((volts - ks_v) / kv).max(1e-3);
        let constant_s = [left, right].map(|motor| motor.ka_v_s2_per_m / motor.kv_v_s_per_m);
        let constant_s = constant_s[0].max(constant_s[1]);
        let ramp_v_per_s = self.ramp_v_per_s(kv, speed_mps / constant_s);
        let roll_m = speed_mps * (constant_s + 0.5 * volts / ramp_v_per_s);
        (volts, Some(Cruise { speed_mps, roll_m, ramp_v_per_s }))
    }

    /// How fast the voltage may change so that no tyre slides, if a sudden change accelerates the robot by this much \[V/s\].
    fn ramp_v_per_s(&self, kv_v_s_per_m: f64, sudden_mps2: f64) -> f64 {
        let steepest = self.supply_v / STEP_RISE_S;
        if sudden_mps2 <= ACCELERATION_MPS2_MAX {
            return steepest;
        }
        steepest.min(ACCELERATION_MPS2_MAX * kv_v_s_per_m)
    }

    /// A slow ramp until a wheel has turned a little; returns the voltage at which it did.
    async fn break_away(
        &mut self,
        session: &mut Session,
        floor: &mut Floor,
        sign: f64,
    ) -> Result<f64> {
        let most_v = SUPPLY_SHARE * self.supply_v;
        let counts_m = self.config.encoder.map(|e| self.config.meters_per_count(&e));
        let travel_m_max = BREAK_AWAY_M.max(BREAK_AWAY_COUNTS * counts_m.left.max(counts_m.right));
        let run = VoltageRun {
            steps: vec![VoltageStep {
                volts: WheelPair::both(sign * most_v),
                duration_s: BREAK_AWAY_S,
            }],
            ramp_v_per_s: most_v / BREAK_AWAY_S,
            travel_m_max,
            speed_mps_max: 1.5 * self.config.limits.speed_mps_max,
            period_ms: PERIOD_MS,
        };
        let (end, telemetry) = self.apply(session, floor, "break_away", &run).await?;
        if end == MotionEnd::Completed {
            return Err(Error::new(format_args!(
                "no wheel turned at up to {most_v:.1} V: the wheels are blocked, or the motors have no power",
            ))
            .hint("lift the robot and turn the wheels by hand; check the motors' supply and their driver's enable line"));
        }
        let peak = |of: fn(&Telemetry) -> i16| {
            telemetry.iter().map(of).map(|duty| i32::from(duty).abs()).max().unwrap_or(0)
        };
        let duty = peak(|t| t.wheels.left.duty).max(peak(|t| t.wheels.right.duty));
        Ok(f64::from(duty) / 32767.0 * self.supply_v)
    }

    /// One voltage after the other, with these signs.
    async fn steps(
        &mut self,
        session: &mut Session,
        floor: &mut Floor,
        signs: &[(f64, f64)],
        volts: f64,
        cruise: Option<Cruise>,
    ) -> Result<()> {
        let spins = signs[0].0 * signs[0].1 < 0.0;
        let room_m = if spins { 0.5 } else { floor.room_m(signs[0].0 > 0.0) };
        // The robot may roll out after its limit.
        let room_m = room_m - cruise.map_or(0.0, |cruise| cruise.roll_m);
        if room_m < ROOM_M_MIN {
            return Err(too_little_floor());
        }
        // Half of the room for the drive itself: the rest for what the first estimate is off.
        let long_s = cruise.map_or(0.6, |cruise| 0.7 * room_m / cruise.speed_mps);
        // A robot that creeps needs time to turn its wheels at all.
        let creeps = cruise
            .is_some_and(|cruise| cruise.speed_mps < CREEPING * self.config.limits.speed_mps_max);
        let step_s = if creeps { CREEP_S } else { STEP_S };
        let duration_s = long_s.clamp(STEP_S_MIN, step_s);
        let step = |&(left, right): &(f64, f64)| VoltageStep {
            volts: WheelPair::new(left * volts, right * volts),
            duration_s,
        };
        let ramp_v_per_s = cruise.map_or(self.supply_v / STEP_RISE_S, |cruise| cruise.ramp_v_per_s);
        // Down as slowly as up.
        let down = VoltageStep { volts: WheelPair::both(0.0), duration_s: volts / ramp_v_per_s };
        let run = VoltageRun {
            steps: signs.iter().map(step).chain([down]).collect(),
            ramp_v_per_s,
            travel_m_max: room_m,
            speed_mps_max: 1.8 * self.config.limits.speed_mps_max,
            period_ms: PERIOD_MS,
        };
        let name = match signs {
            [_, _, ..] => "reversal",
            _ if spins => "spin",
            _ if creeps => "creep",
            _ => "steps",
        };
        self.apply(session, floor, name, &run).await.map(drop)
    }

    /// Drives forwards once more if the robot is so near the beginning of its floor that it cannot go back.
    async fn make_room(
        &mut self,
        session: &mut Session,
        floor: &mut Floor,
        volts: f64,
        cruise: Option<Cruise>,
    ) -> Result<()> {
        let roll_m = cruise.map_or(0.0, |cruise| cruise.roll_m);
        for _ in 0..2 {
            if floor.room_m(false) - roll_m >= ROOM_M_MIN {
                break;
            }
            self.steps(session, floor, &[(1.0, 1.0)], volts, cruise).await?;
        }
        Ok(())
    }

    /// Slowly towards where the robot stood at first, if it is far from there.
    async fn go_back(
        &mut self,
        session: &mut Session,
        floor: &mut Floor,
        first_v: f64,
    ) -> Result<()> {
        for _ in 0..3 {
            let at_m = floor.at_m();
            // At a voltage that the motors are known to follow, and so that the robot rolls out where it stood.
            let (volts, roll_m) = match drivetrain::regress(&self.recordings) {
                Some(model) => {
                    let (volts, cruise) = self.level(&model, LEVELS[0]);
                    (volts, cruise.map_or(0.0, |cruise| cruise.roll_m))
                }
                // How far it rolls is not known yet: half of the way.
                None => (first_v, 0.5 * at_m.abs()),
            };
            let way_m = at_m.abs() - roll_m;
            if at_m.abs() < 0.04 || way_m < 0.01 {
                break;
            }
            let sign = -at_m.signum();
            let run = VoltageRun {
                steps: vec![VoltageStep { volts: WheelPair::both(sign * volts), duration_s: 6.0 }],
                ramp_v_per_s: self.supply_v / STEP_RISE_S,
                travel_m_max: way_m,
                speed_mps_max: 1.8 * self.config.limits.speed_mps_max,
                period_ms: PERIOD_MS,
            };
            self.apply(session, floor, "back", &run).await?;
        }
        Ok(())
    }

    /// Takes the next try of the encoder check: friction that nobody knows looks like a wheel that is blocked, and so does a slow
    /// motor whose counts are long. None is left if false.
    fn check_again(&mut self, fault: Fault) -> bool {
        let can_be_slow = longer_count_m(self.config) > settings::CHECK_COUNT_M
            && matches!(fault, Fault::NoResponse(_));
        let next = self.check + 1;
        let of_slow = next.checked_sub(CHECKS.len()).and_then(|next| CHECKS_OF_SLOW.get(next));
        if CHECKS.get(next).or(of_slow.filter(|_| can_be_slow)).is_none() {
            return false;
        }
        self.check = next;
        true
    }

    async fn apply(
        &mut self,
        session: &mut Session,
        floor: &mut Floor,
        name: &'static str,
        run: &VoltageRun,
    ) -> Result<(MotionEnd, Vec<Telemetry>)> {
        loop {
            let mut telemetry = Vec::new();
            let end = apply_voltages(session, run, &mut telemetry).await;
            telemetry.sort_by_key(|frame| frame.t_us);
            floor.follow(self.config, &telemetry);
            match end {
                Ok(end) => {
                    if let Some(recording) = recording(self.config, &telemetry) {
                        self.recordings.push(recording);
                        let identifies = !self.has_identified;
                        let one = DrivenExperiment::new(name, identifies, &telemetry);
                        self.driven.extend(one);
                    }
                    return Ok((end, telemetry));
                }
                Err(host_link::Error::Faulted(report))
                    if is_of_check(report.fault) && self.check_again(report.fault) =>
                {
                    session.request(Command::ClearFault { number: report.number }).await?;
                    let check = CHECKS.iter().chain(&CHECKS_OF_SLOW).nth(self.check);
                    let check = check.copied().unwrap_or(CHECK_FIRST);
                    let config = settings::for_experiments(self.config, check);
                    session.write_config(&config).await?;
                }
                Err(host_link::Error::Faulted(report)) if is_of_check(report.fault) => {
                    let check = CHECKS.iter().chain(&CHECKS_OF_SLOW).nth(self.check);
                    let check = check.copied().unwrap_or(CHECK_FIRST);
                    return Err(too_coarse(self.config, report.fault).unwrap_or_else(|| {
                        let is_exchanged = matches!(report.fault, Fault::EncodersExchanged(_));
                        let error = Error::from(host_link::Error::Faulted(report));
                        // What to do about exchanged plugs is no matter of friction.
                        if is_exchanged { error } else { error.hint(stands(check)) }
                    }));
                }
                Err(error) => return Err(error.into()),
            }
        }
    }
}

/// The longer count of both encoders \[m\].
pub fn longer_count_m(config: &Config) -> f64 {
    let counts_m = config.encoder.map(|encoder| config.meters_per_count(&encoder));
    counts_m.left.max(counts_m.right)
}

/// What to say of a fault that the encoder check may have raised because a count is long.
pub fn too_coarse(config: &Config, fault: Fault) -> Option<Error> {
    let count_m = longer_count_m(config);
    (is_of_check(fault) && count_m > COARSE_M).then(|| {
        Error::said_no(format_args!(
            "one count of the encoder is {:.0} mm of travel: the encoder check waits about a second for two of them, saw fewer, and ended with the fault {fault}",
            count_m * 1e3,
        ))
        .hint("an encoder on the motor's shaft counts finer than one on the wheel's; if the wheels did not turn at all, something blocks them")
    })
}

/// Whether the encoder check may have raised it for friction that it did not reckon with.
fn is_of_check(fault: Fault) -> bool {
    matches!(fault, Fault::NoResponse(_) | Fault::EncoderDead(_) | Fault::EncodersExchanged(_))
}

/// One experiment as it was driven, from the last frame at rest on: the encoder check is a part of it.
#[derive(Clone, Debug)]
pub struct DrivenExperiment {
    /// What it is, in a word.
    pub name: &'static str,
    /// Whether `tune` identifies the motors from it; the others are driven for a campaign alone.
    pub identifies: bool,
    /// Its frames.
    pub telemetry: Vec<Telemetry>,
}

impl DrivenExperiment {
    fn new(name: &'static str, identifies: bool, telemetry: &[Telemetry]) -> Option<Self> {
        let telemetry = telemetry[begins(telemetry)?..].to_vec();
        Some(Self { name, identifies, telemetry })
    }

    /// As the model takes it; None if it is too short.
    pub fn recording(&self, config: &Config) -> Option<VoltageRecording> {
        recording(config, &self.telemetry)
    }
}

/// The last frame before the first voltage, which is the encoder check's: a wheel may still turn when the check ends.
fn begins(telemetry: &[Telemetry]) -> Option<usize> {
    let begins = telemetry.iter().position(|frame| frame.state == State::Driving);
    Some(begins?.saturating_sub(1))
}

/// From the last frame before the first voltage on.
fn recording(config: &Config, telemetry: &[Telemetry]) -> Option<VoltageRecording> {
    let from = begins(telemetry)?;
    let first = &telemetry[from];
    let recording = VoltageRecording::new(telemetry[from..].iter().map(|frame| {
        let travel = travel_m(config, first, frame);
        let applied = first
            .wheels
            .zip(frame.wheels)
            .map(|(first, now)| now.applied_uvs.wrapping_sub(first.applied_uvs) as f64 * 1e-6);
        Sample {
            t_s: frame.t_us.saturating_sub(first.t_us) as f64 * 1e-6,
            travel_m: for_model(travel),
            applied_vs: for_model(applied),
        }
    }))?;
    let counts_m = config.encoder.map(|encoder| config.meters_per_count(&encoder));
    Some(recording.with_counts_of(for_model(counts_m)))
}

/// The motors' constants.
pub fn identify(recordings: &[VoltageRecording]) -> Result<DrivetrainFit> {
    drivetrain::fit(recordings).map_err(|error| match error {
        FitError::TooFew | FitError::NoMotion => no_motion(),
        FitError::Delay => Error::said_no(
            "these wheels answer 50 ms or more after their voltage: no loop on such motors keeps its margin",
        )
        .hint("a driver with a filter or a soft start, or a motor controller on a slow bus, lies between; set it to act at once"),
        FitError::NoConstants => {
            Error::new("these wheels did not respond to the voltages as motors do")
                .hint("is somebody holding the robot? Is a wheel off the ground, or slipping?")
        }
    })
}

fn no_motion() -> Error {
    Error::new("the wheels hardly turned: motor constants cannot be told from friction")
        .hint("is the supply on, and strong enough? Does something rub?")
}

fn too_little_floor() -> Error {
    Error::new("the robot has too little floor left for its next experiment")
        .hint("give more with --floor, and put the robot at its beginning")
}

#[cfg(test)]
mod tests {
    use shared_proto::Wheel;

    use super::*;

    /// So often the check is tried again.
    fn tries(counts_per_rev: f64, fault: Fault) -> usize {
        let mut config = Config::default();
        config.encoder.left.counts_per_rev = counts_per_rev;
        config.encoder.right.counts_per_rev = counts_per_rev;
        let mut experiments = Experiments::new(&config, 12.0);
        std::iter::repeat_with(|| experiments.check_again(fault)).take_while(|again| *again).count()
    }

    #[test]
    fn the_longer_check_is_for_slow_motors_with_long_counts_and_no_other_fault() {
        let [no_response, dead] = [Fault::NoResponse, Fault::EncoderDead].map(|of| of(Wheel::Left));
        let more = CHECKS.len() - 1;
        assert_eq!(tries(30.0, no_response), more + CHECKS_OF_SLOW.len());
        assert_eq!(tries(30.0, dead), more);
        assert_eq!(tries(900.0, no_response), more);
    }
}
