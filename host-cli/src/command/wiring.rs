//! `beeline wiring`: turns one wheel after the other, and asks which one turned, and which way.

use std::fmt::Display;

use host_link::Session;
use host_link::motion::{self, Motion, RecordOptions};
use serde_json::{Value, json};
use shared_proto::{Config, TravelUnit, Wheel, WheelPair};

use crate::cli::Common;
use crate::error::{Error, Result};
use crate::port::with_robot;
use crate::pose_source::bench::Bench;
use crate::question::{Choice, Question};
use crate::ui::{self, GOOD, note, paint, say, warn};
use crate::wiring::{Seen, Wiring, turned_round};

/// How far a wheel rolls: enough to be seen, and a robot on the floor turns by less than ten degrees \[m\].
const ROLL_M: f64 = 0.05;
/// \[m/s\]
const CRUISE_MPS: f64 = 0.1;
/// \[m/s^2\]
const ACCELERATION_MPS2: f64 = 0.3;

const READY: &[Choice] = &[Choice { label: "Begin", answer: "" }];
const ANSWERS: &[Choice] = &[
    Choice { label: "The left wheel, ahead", answer: "la" },
    Choice { label: "The left wheel, back", answer: "lb" },
    Choice { label: "The right wheel, ahead", answer: "ra" },
    Choice { label: "The right wheel, back", answer: "rb" },
    Choice { label: "None", answer: "n" },
];

pub(super) fn run(common: &Common) -> Result<()> {
    let (wiring, saved) = with_robot(&common.port, &common.sim(), async |session, bench| {
        let config = session.read_config().await?;
        if session.identify().await?.unsaved {
            // They would be saved along with what is mended.
            return Err(Error::new("the configuration has changes that are not saved")
                .hint("`beeline config save` keeps them, `beeline config restore` drops them"));
        }
        note(format_args!(
            "Each wheel rolls {:.0} cm, one after the other. Lift the wheels, or leave room; look at them from behind.",
            ROLL_M * 100.0
        ));
        let ready =
            Question::new("Are the wheels free?").choices(READY, "(Enter to begin)").not_typed();
        if !ui::ask(&ready, &session.clock()).await?.is_empty() {
            return Err(Error::interrupted("nothing was driven"));
        }
        let mut onlooker = Onlooker { session, config: &config, bench };
        let wiring = onlooker.look().await?;
        let Wiring::Reversed(wheels) = wiring else { return Ok((wiring, false)) };
        note(format_args!("{} Both are turned round now; once more:", reversed(wheels)));
        onlooker.session.write_config(&turned_round(&config, wheels)).await?;
        // Only what was seen to be right is kept.
        let found = onlooker.look().await;
        if matches!(found, Ok(Wiring::Right)) {
            session.save_config().await?;
            return Ok((wiring, true));
        }
        session.write_config(&config).await?;
        Ok((found?, false))
    })?;
    report(common, wiring, saved)
}

/// Turns wheels, and asks what was seen.
struct Onlooker<'a> {
    session: &'a mut Session,
    config: &'a Config,
    /// Of a simulated robot, which knows the answer.
    bench: Option<Bench>,
}

impl Onlooker<'_> {
    async fn look(&mut self) -> Result<Wiring> {
        let left = self.turn(Wheel::Left).await?;
        let right = self.turn(Wheel::Right).await?;
        Ok(Wiring::of(WheelPair { left, right }))
    }

    async fn turn(&mut self, wheel: Wheel) -> Result<Seen> {
        let limits = &self.config.limits;
        let mut distance = WheelPair::both(0.0);
        *distance.get_mut(wheel) = ROLL_M;
        let motion = Motion {
            unit: TravelUnit::Meter,
            distance,
            cruise: CRUISE_MPS.min(limits.speed_mps_max),
            acceleration: ACCELERATION_MPS2.min(limits.acceleration_mps2_max),
        };
        let before = self.angles_rad()?;
        motion::drive(self.session, &motion, RecordOptions::default(), &mut |_| ()).await?;
        let turned = before.zip(self.angles_rad()?).map(|(before, after)| {
            after
                .zip(before)
                .map(|(after, before)| (after - before) * self.config.geometry.wheel_radius_m)
        });
        self.ask(turned.map(Seen::of_ways)).await
    }

    fn angles_rad(&self) -> Result<Option<WheelPair<f64>>> {
        let angles =
            |bench: &Bench| bench.with(|testbed| testbed.plant(|plant| plant.wheel_angles_rad()));
        self.bench.as_ref().map(angles).transpose()
    }

    async fn ask(&self, known: Option<Seen>) -> Result<Seen> {
        let suggested = known.map(|seen| seen.letters().to_owned());
        let how = match known {
            Some(_) => {
                "(la: left ahead, lb: left back, ra, rb: right, n: none; Enter: what the simulator shows)"
            }
            None => "(la: left ahead, lb: left back, ra, rb: right, n: none)",
        };
        let question = Question::new("Which wheel turned, and which way?")
            .choices(ANSWERS, how)
            .suggested(suggested)
            .not_typed();
        let clock = self.session.clock();
        loop {
            let answer = ui::ask(&question, &clock).await?;
            match (Seen::parse(&answer), known) {
                (Some(seen), _) => return Ok(seen),
                (None, Some(seen)) if answer.is_empty() => return Ok(seen),
                _ => warn("answer la, lb, ra, rb or n"),
            }
        }
    }
}

/// Which wheels turn backwards and count backwards.
fn reversed(wheels: WheelPair<bool>) -> &'static str {
    match (wheels.left, wheels.right) {
        (true, true) => "Forward is backward: both motors and both encoders are reversed.",
        (true, false) => "The left motor and its encoder are reversed.",
        _ => "The right motor and its encoder are reversed.",
    }
}

fn report(common: &Common, wiring: Wiring, saved: bool) -> Result<()> {
    let mut value = wiring.to_json();
    value["saved"] = json!(saved);
    let (what, hint) = match wiring {
        Wiring::Right => {
            answer(common, value, paint(GOOD, "Left is left, and forward is forward."));
            return Ok(());
        }
        Wiring::Reversed(wheels) if saved => {
            if common.robot_forgets() {
                warn(
                    "this simulated robot forgets when the command ends; --flash FILE gives it a memory",
                );
            }
            let line = format!("{} Mended and saved: forward is forward.", reversed(wheels));
            answer(common, value, line);
            return Ok(());
        }
        Wiring::Reversed(_) => (
            "turned round, the wheels are still the wrong way round".into(),
            "repeat it, and look at the wheels from behind the robot",
        ),
        // Seen from its other end, such a robot is as it should be.
        Wiring::Exchanged(WheelPair { left: true, right: true }) => (
            "the robot takes its other end for the front".into(),
            "take the other end for the front: then all is right; or exchange the motors' connectors and the encoders' plugs, and run this again",
        ),
        Wiring::Exchanged(_) => (
            "left and right are exchanged, motors and encoders alike".into(),
            "exchange the motors' connectors and the encoders' plugs, and run this again: it then mends what else is the wrong way round",
        ),
        Wiring::OneWheel(wheel) => (
            format!("the {} wheel cannot have turned both times", wheel.name()),
            "each wheel is turned once: run it again and watch both",
        ),
        Wiring::NoWheel(wheel) => (
            format!(
                "the {} encoder counted {:.0} cm, and no wheel turned",
                wheel.name(),
                ROLL_M * 100.0
            ),
            "repeat it and look closely; if it is so, that encoder is not on a wheel that this motor turns",
        ),
    };
    Err(Error::said_no(format_args!("{what}; nothing was changed")).hint(hint).details(value))
}

fn answer(common: &Common, value: Value, line: impl Display) {
    match common.json {
        true => say(value),
        false => say(line),
    }
}
