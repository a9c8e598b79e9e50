//! `beeline drive velocity`.

use std::io::BufRead;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use host_link::motion::{Twist, drive_at};
use serde_json::json;

use crate::cli::{Common, VelocitySource};
use crate::error::{Error, Result};
use crate::port::with_robot;
use crate::quantity::{Acceleration, Time, TurnRate};
use crate::ui::tell;

/// A velocity from standard input is driven this long without a new one \[s\].
const HOLD_S: f64 = 0.5;

pub(super) fn run(
    common: &Common,
    forward: VelocitySource,
    turn: TurnRate,
    duration: Option<Time>,
    acceleration: Acceleration,
) -> Result<()> {
    if matches!(forward, VelocitySource::Stdin) && turn.rad_s != 0.0 {
        return Err(Error::new("--turn is not for velocities from standard input")
            .hint("each line gives a forward speed and a turn rate"));
    }
    let lines = match forward {
        VelocitySource::Stdin => Some(Lines::of_stdin()),
        VelocitySource::Speed(_) => None,
    };
    let failed = with_robot(&common.port, &common.sim(), async |session, _| {
        if session.clock().is_virtual() && (lines.is_some() || duration.is_none()) {
            return Err(Error::new("the simulator in this process runs faster than real time")
                .hint("give a speed and --for TIME; or `beeline sim --listen tcp:127.0.0.1:7700`, and --port with its address"));
        }
        let config = session.read_config().await?;
        let radius_m = config.geometry.wheel_radius_m;
        let end_s = duration.map_or(f64::INFINITY, |duration| duration.s);
        let mut lines = lines;
        let mut failed = None;
        let mut wanted = |elapsed_s: f64| match (forward, &mut lines) {
            _ if elapsed_s >= end_s => None,
            (VelocitySource::Speed(speed), _) => {
                Some(Twist { forward_mps: speed.mps(radius_m), turn_rad_s: turn.rad_s })
            }
            (VelocitySource::Stdin, Some(lines)) => lines.now(elapsed_s).unwrap_or_else(|error| {
                failed = Some(error);
                None
            }),
            (VelocitySource::Stdin, None) => None,
        };
        let driven = drive_at(session, acceleration.mps2(radius_m), &mut wanted).await;
        driven.map_err(|error| match (&error, &lines) {
            (host_link::Error::Refused { request: "drive", .. }, Some(lines)) => {
                lines.refused(error)
            }
            _ => error.into(),
        })?;
        Ok(failed)
    })?;
    if let Some(error) = failed {
        return Err(error);
    }
    tell(common.json, json!({ "end": "completed" }), "done");
    Ok(())
}

/// Velocities that come line by line.
struct Lines {
    lines: Receiver<std::io::Result<String>>,
    number: usize,
    latest: Twist,
    /// The line of that.
    latest_number: usize,
    /// When the latest one came \[s\].
    at_s: f64,
    ended: bool,
}

const STILL: Twist = Twist { forward_mps: 0.0, turn_rad_s: 0.0 };

impl Lines {
    /// Reads standard input beside the drive. A program that writes faster than they are read has to wait.
    fn of_stdin() -> Self {
        let (sender, lines) = sync_channel(64);
        std::thread::spawn(move || {
            for line in std::io::stdin().lock().lines() {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        Self { lines, number: 0, latest: STILL, latest_number: 0, at_s: 0.0, ended: false }
    }

    /// The robot has refused the velocity of the latest line.
    fn refused(&self, error: host_link::Error) -> Error {
        let refused = Error::from(error);
        let named =
            Error::new(format_args!("line {} of standard input: {refused}", self.latest_number));
        match refused.hint_text() {
            Some(hint) => named.hint(hint),
            None => named,
        }
    }

    /// The velocity now; none after the last line.
    fn now(&mut self, elapsed_s: f64) -> Result<Option<Twist>> {
        loop {
            match self.lines.try_recv() {
                Ok(line) => {
                    self.number += 1;
                    let line = line.map_err(|error| {
                        Error::new(format_args!("line {} of standard input: {error}", self.number))
                    })?;
                    if !line.trim().is_empty() {
                        self.latest = twist(&line, self.number)?;
                        self.latest_number = self.number;
                        self.at_s = elapsed_s;
                    }
                }
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    self.ended = true;
                    break;
                }
            }
        }
        let held = elapsed_s - self.at_s < HOLD_S;
        Ok(match (held, self.ended) {
            (true, _) => Some(self.latest),
            (false, false) => Some(STILL),
            (false, true) => None,
        })
    }
}

fn twist(line: &str, number: usize) -> Result<Twist> {
    let numbers: Option<Vec<f64>> = line
        .split([' ', '\t', ','])
        .filter(|word| !word.is_empty())
        .map(|word| word.parse().ok().filter(|value: &f64| value.is_finite()))
        .collect();
    match numbers.as_deref() {
        Some(&[forward_mps, turn_rad_s]) => Ok(Twist { forward_mps, turn_rad_s }),
        _ => Err(Error::new(format_args!(
            "line {number} of standard input is not two numbers: {:?}",
            line.chars().take(60).collect::<String>()
        ))
        .hint("a line is a forward speed in m/s and a turn rate in rad/s: 0.2 -0.5")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_two_numbers_and_anything_else_is_named_with_its_place() {
        let expected = Twist { forward_mps: 0.2, turn_rad_s: -0.5 };
        for line in ["0.2 -0.5", " 0.2,-0.5 ", "2e-1\t-5e-1"] {
            assert_eq!(twist(line, 1).unwrap(), expected, "{line}");
        }
        for line in ["0.2", "0.2 0.1 0.3", "NaN 0", "inf 1", "fast left", "0.2m/s 0"] {
            let message = twist(line, 7).unwrap_err().to_string();
            assert!(message.starts_with("line 7 of standard input"), "{message}");
        }
    }

    #[test]
    fn a_line_is_driven_until_the_next_and_no_longer_than_half_a_second() {
        let (sender, lines) = sync_channel(8);
        let mut lines =
            Lines { lines, number: 0, latest: STILL, latest_number: 0, at_s: 0.0, ended: false };
        let half = Twist { forward_mps: 0.5, turn_rad_s: 0.0 };
        let send = |line: &str| sender.send(Ok(line.into())).unwrap();
        assert_eq!(lines.now(0.0).unwrap(), Some(STILL));
        send("0.1 1");
        send("0.5 0");
        assert_eq!(lines.now(1.0).unwrap(), Some(half), "the newest counts");
        assert_eq!(lines.now(1.4).unwrap(), Some(half));
        assert_eq!(lines.now(1.6).unwrap(), Some(STILL));
        send("0.5 0");
        assert_eq!(lines.now(2.0).unwrap(), Some(half));
        drop(sender);
        assert_eq!(lines.now(2.4).unwrap(), Some(half));
        assert_eq!(lines.now(2.6).unwrap(), None, "the last one has been driven");
    }
}
