//! A person with a tape measure: where the robot stands before a run, and where after it.
//!
//! Two poses a run, the first at its first sample, the last at its last one: the robot stands still at
//! both. Between the pieces of a run it stands for a blink, which nobody can measure.

use std::path::{Path, PathBuf};

use campaign::how_far;
use campaign::plan::PlannedRun;
use campaign::track::read_track;
use host_link::Clock;
use robot_model::calibration::TrackSample;
use robot_model::checks::doubtful;
use robot_model::kinematics::Pose;
use robot_model::recording::PoseMeasurement;
use sim_target::Lab;

use super::align::Reckoned;
use super::measured::{Go, Seen, Sigma, no_shift, on_robot_clock, stopped};
use crate::error::Result;
use crate::quantity::{Angle, Length, join_units};
use crate::ui;

/// A person who measures.
pub struct Person {
    /// Whether to ask before each run.
    confirm: bool,
    /// Where the robot is a simulated one.
    lab: Option<Lab>,
    /// How well the tape is read.
    sigma: Sigma,
    /// Where the robot stood before the run.
    start: Pose,
    /// The last run was measured with the tape.
    by_tape: bool,
    /// It was said what is asked for.
    told: bool,
}

/// A pose as typed: in metres and radians, the heading if it was read.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reading {
    x_m: f64,
    y_m: f64,
    heading_rad: Option<f64>,
}

/// What was answered after a run.
enum Answer {
    Pose(Reading),
    Track(PathBuf),
    Nothing,
    Repeat,
    Skip,
    Quit,
}

impl Person {
    /// Somebody who reads a tape this well; `lab` is that of a simulated robot.
    pub fn new(confirm: bool, sigma: Sigma, lab: Option<Lab>) -> Self {
        Self { confirm, lab, sigma, start: Pose::ORIGIN, by_tape: false, told: false }
    }

    /// How well the last run was measured, if it was with the tape.
    pub fn sigma(&self) -> Option<Sigma> {
        self.by_tape.then_some(self.sigma)
    }

    /// Has the robot put at the mark of a run, or hears where it stands instead.
    pub async fn place(&mut self, clock: &Clock, run: &PlannedRun, place: &str) -> Result<Go> {
        let mark = Pose::new(0.0, 0.0, run.heading_rad);
        self.start = mark;
        if !self.told && (self.confirm || self.lab.is_some()) {
            self.told = true;
            ui::note(format_args!(
                "  x along the campaign's axis, y to its left, from the start mark to the middle of the axle; \
                 headings to the left\n  good to {} mm and {} mrad, one sigma (--position-sigma, \
                 --heading-sigma)",
                self.sigma.position_m * 1e3,
                self.sigma.heading_rad * 1e3
            ));
        }
        while self.confirm {
            let question = format!(
                "{place} Enter to drive, where it stands if not there (12mm -3mm 1deg), s to skip, q to stop:"
            );
            match ui::ask(&question, clock).await?.to_lowercase().as_str() {
                "" | "y" | "yes" => break,
                "s" | "skip" => return Ok(Go::Skip),
                "q" | "quit" => return Err(stopped()),
                pose => match parse_pose(pose) {
                    Ok(read) => {
                        // A heading that was not read is that of the mark.
                        let heading_rad = read.heading_rad.unwrap_or(mark.heading_rad);
                        self.start = Pose::new(read.x_m, read.y_m, heading_rad);
                        break;
                    }
                    Err(why) => ui::warn(why),
                },
            }
        }
        if let Some(lab) = &self.lab {
            lab.set_payload(run.payload_kg);
            lab.place_on(sim_target::plant::Pose {
                x_m: self.start.x_m,
                y_m: self.start.y_m,
                heading_rad: self.start.heading_rad,
            });
        }
        Ok(Go::Drive)
    }

    /// Asks where the robot stands after a run; `reckoned` is the run by its wheels.
    pub async fn track(&mut self, clock: &Clock, reckoned: &[Reckoned]) -> Result<Seen> {
        if let Some(lab) = &self.lab {
            ui::note(format_args!("  a tape would read {}", as_read(lab.pose())));
        }
        let mut doubted = None;
        loop {
            self.by_tape = false;
            let question = "Where it stands now (1.795m -12mm 3deg), its track's file, Enter for neither, repeat, skip, or q:";
            match parse_answer(&ui::ask(question, clock).await?) {
                Ok(Answer::Pose(read)) => match self.ends(read, reckoned) {
                    Ok(mut track) => {
                        if read.heading_rad.is_none() {
                            match ask_heading(clock).await? {
                                Heading::Read(heading_rad) => track[1].heading_rad = heading_rad,
                                Heading::Repeat => return Ok(Seen::Repeat),
                                Heading::Skip => return Ok(Seen::Skip),
                                Heading::Quit => return Err(stopped()),
                            }
                        }
                        match doubt(&track, reckoned) {
                            Some(why) if doubted.as_ref() != Some(&track) => ui::warn(why),
                            _ => return Ok(Seen::Track(track)),
                        }
                        doubted = Some(track);
                    }
                    Err(why) => ui::warn(why),
                },
                Ok(Answer::Track(path)) => match read_track(&path) {
                    Ok((samples, _)) => match on_robot_clock(samples, reckoned) {
                        Some(track) => return Ok(Seen::Track(track)),
                        None => ui::warn(no_shift(&path)),
                    },
                    Err(error) => ui::warn(error),
                },
                Ok(Answer::Nothing) => return Ok(Seen::Track(Vec::new())),
                Ok(Answer::Repeat) => return Ok(Seen::Repeat),
                Ok(Answer::Skip) => return Ok(Seen::Skip),
                Ok(Answer::Quit) => return Err(stopped()),
                Err(why) => ui::warn(why),
            }
        }
    }

    /// Both ends of a run as poses; refuses an end that the wheels cannot have reached.
    fn ends(
        &mut self,
        end: Reading,
        reckoned: &[Reckoned],
    ) -> std::result::Result<Vec<TrackSample>, String> {
        /// Wheels that are larger than they are said to be, and a crooked tape.
        const FARTHER: f64 = 1.25;
        const MARGIN_M: f64 = 0.1;
        let (Some(first), Some(last)) = (reckoned.first(), reckoned.last()) else {
            return Err("the robot sent no telemetry during the run".into());
        };
        let rolled_m: f64 = reckoned
            .windows(2)
            .map(|it| {
                let (a, b) = (it[0].pose, it[1].pose);
                (b.x_m - a.x_m).hypot(b.y_m - a.y_m)
            })
            .sum();
        let moved_m = (end.x_m - self.start.x_m).hypot(end.y_m - self.start.y_m);
        if moved_m > FARTHER * rolled_m + MARGIN_M {
            return Err(format!(
                "that is {moved_m:.2} m from where it started, and its wheels rolled {rolled_m:.2} m: check signs and units"
            ));
        }
        self.by_tape = true;
        let at = |t_s: f64, x_m, y_m, heading_rad| TrackSample { t_s, x_m, y_m, heading_rad };
        let start = self.start;
        Ok(vec![
            at(first.t_s, start.x_m, start.y_m, Some(start.heading_rad)),
            at(last.t_s, end.x_m, end.y_m, end.heading_rad),
        ])
    }
}

/// Why both ends of a run, as read, cannot well be those of the wheels: a digit, a sign.
fn doubt(track: &[TrackSample], reckoned: &[Reckoned]) -> Option<String> {
    let sight = |it: &TrackSample| PoseMeasurement {
        t_s: it.t_s,
        position_m: Some([it.x_m, it.y_m]),
        heading_rad: it.heading_rad,
    };
    let wheels: Vec<Pose> = reckoned.iter().map(|it| it.pose).collect();
    let off = doubtful(&sight(track.first()?), &sight(track.last()?), &wheels)?;
    Some(format!(
        "that is {} from where its wheels led: read it again; what is typed a second time is taken",
        how_far(off.position_m, off.heading_rad)
    ))
}

/// What was answered when the heading alone was asked for.
enum Heading {
    /// \[rad\], if it was read.
    Read(Option<f64>),
    Repeat,
    Skip,
    Quit,
}

/// Asks for the heading alone.
async fn ask_heading(clock: &Clock) -> Result<Heading> {
    loop {
        let question = "Its heading, to the left (3deg), Enter for none, repeat, skip, or q:";
        match parse_heading(&ui::ask(question, clock).await?) {
            Ok(heading) => return Ok(heading),
            Err(why) => ui::warn(why),
        }
    }
}

fn parse_heading(text: &str) -> std::result::Result<Heading, String> {
    Ok(match text.to_lowercase().as_str() {
        "" => Heading::Read(None),
        "r" | "repeat" => Heading::Repeat,
        "s" | "skip" => Heading::Skip,
        "q" | "quit" => Heading::Quit,
        angle => {
            no_decimal_comma(angle)?;
            let angle = angle.parse::<Angle>().map_err(|it| it.to_string())?;
            Heading::Read(Some(angle.rad))
        }
    })
}

/// Refuses `1,795m`, as some write it: elsewhere a comma ends a number.
fn no_decimal_comma(text: &str) -> std::result::Result<(), String> {
    let digits = text
        .as_bytes()
        .windows(3)
        .any(|it| it[1] == b',' && it[0].is_ascii_digit() && it[2].is_ascii_digit());
    if digits { Err(format!("`{text}`: write 1.8m, with a point, not 1,8m")) } else { Ok(()) }
}

fn parse_answer(text: &str) -> std::result::Result<Answer, String> {
    match text.to_lowercase().as_str() {
        "" => return Ok(Answer::Nothing),
        "r" | "repeat" => return Ok(Answer::Repeat),
        "s" | "skip" => return Ok(Answer::Skip),
        "q" | "quit" => return Ok(Answer::Quit),
        _ => {}
    }
    let number = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    if number && !Path::new(text).exists() && !text.ends_with(".csv") {
        return parse_pose(text).map(Answer::Pose);
    }
    Ok(Answer::Track(text.into()))
}

/// `1.795m -12mm`, `1.795m -12mm 3deg`.
fn parse_pose(text: &str) -> std::result::Result<Reading, String> {
    no_decimal_comma(text)?;
    let parts = join_units(text);
    let length = |text: &str| text.parse::<Length>().map(|it| it.m).map_err(|it| it.to_string());
    let angle = |text: &str| text.parse::<Angle>().map(|it| it.rad).map_err(|it| it.to_string());
    let (x, y, heading) = match parts.as_slice() {
        [x, y] => (x, y, None),
        [x, y, heading] => (x, y, Some(heading)),
        _ => {
            return Err(format!(
                "`{text}` is no pose: give x and y, and the heading if you can: 1.795m -12mm 3deg"
            ));
        }
    };
    Ok(Reading {
        x_m: length(x)?,
        y_m: length(y)?,
        heading_rad: heading.map(|it| angle(it)).transpose()?,
    })
}

/// A pose to the millimetre and the tenth of a degree.
fn as_read(pose: sim_target::plant::Pose) -> String {
    let deg = (pose.heading_rad.to_degrees() + 180.0).rem_euclid(360.0) - 180.0;
    // Adding zero makes -0 a 0.
    let mm = |m: f64| (m * 1e3).round() + 0.0;
    let tenth = (deg * 10.0).round() / 10.0 + 0.0;
    format!("{}mm {}mm {tenth}deg", mm(pose.x_m), mm(pose.y_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_takes_units_and_leaves_its_heading_out() {
        let read = parse_pose("1.795 m, -12mm 3deg").unwrap();
        assert!((read.x_m - 1.795).abs() < 1e-12 && (read.y_m + 0.012).abs() < 1e-12);
        assert!((read.heading_rad.unwrap() - 3f64.to_radians()).abs() < 1e-12);
        assert_eq!(parse_pose("1in 0mm").unwrap().heading_rad, None);
        for (bad, why) in [
            ("1.8m", "no pose"),
            ("1mm 2mm 3deg 4deg", "no pose"),
            ("1.8 2", "unit"),
            ("1m 2deg", "unit"),
            ("1m 2m 3m", "unit"),
            ("1,795m 2mm", "with a point"),
        ] {
            let said = parse_pose(bad).unwrap_err();
            assert!(said.contains(why) && !said.contains('\n'), "{bad}: {said}");
        }
    }

    #[test]
    fn whoever_is_asked_for_the_heading_may_as_well_leave() {
        assert!(matches!(parse_heading("3deg"), Ok(Heading::Read(Some(rad))) if rad > 0.05));
        assert!(matches!(parse_heading(""), Ok(Heading::Read(None))));
        assert!(matches!(parse_heading("Q"), Ok(Heading::Quit)));
        assert!(matches!(parse_heading("skip"), Ok(Heading::Skip)));
        assert!(matches!(parse_heading("r"), Ok(Heading::Repeat)));
        for bad in ["3", "3,5deg", "quite"] {
            assert!(parse_heading(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn what_a_tape_would_read_is_what_is_understood() {
        let pose = sim_target::plant::Pose { x_m: 1.7949, y_m: -0.0002, heading_rad: 12.5 };
        assert_eq!(as_read(pose), "1795mm 0mm -3.8deg");
        let read = parse_pose(&as_read(pose)).unwrap();
        assert!((read.heading_rad.unwrap() + 3.8f64.to_radians()).abs() < 1e-12);
    }

    #[test]
    fn an_end_that_the_wheels_cannot_have_reached_is_refused() {
        let at = |t_s: f64, x_m: f64| Reckoned { t_s, pose: Pose::new(x_m, 0.0, 0.0) };
        // Out and back: where it stands is near, however far it rolled.
        let reckoned = [at(5.0, 0.0), at(6.0, 0.9), at(8.0, 0.0)];
        let mut person = Person::new(true, Sigma::TAPE, None);
        let end = |x_m: f64| Reading { x_m, y_m: 0.0, heading_rad: None };
        let said = person.ends(end(18.0), &reckoned).unwrap_err();
        assert!(
            said.contains("18.00 m from where it started") && said.contains("1.80 m"),
            "{said}"
        );
        assert_eq!(person.sigma(), None);
        let track = person.ends(end(1.8), &reckoned).unwrap();
        assert_eq!(track.iter().map(|it| it.t_s).collect::<Vec<_>>(), [5.0, 8.0]);
        assert_eq!(person.sigma(), Some(Sigma::TAPE));
    }
}
