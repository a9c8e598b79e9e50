//! A person with a ruler or a tape measure: where the robot stands before a run, and where after
//! it.
//!
//! After a line this is the distance from the line. A run of a campaign gets two poses, one at its
//! first sample and one at its last: the robot stands still at both. The pauses between the pieces
//! of a run are too short to measure in.

use campaign::how_far;
use campaign::plan::PlannedRun;
use campaign::track::read_track;
use host_link::Clock;
use host_link::wire::Waiting;
use robot_model::calibration::{Deviation, TrackSample};
use robot_model::checks::implausible_end_pose;
use robot_model::kinematics::Pose;
use robot_model::recording::PoseMeasurement;
use sim_target::Testbed;
use sim_target::instruments::EndReading;

use super::align::{Reckoned, on_robot_clock};
use super::bench::Bench;
use super::confirm::confirm;
use super::confirm::{AT_MARK, ask_for, stopped};
use super::reading::{
    Heading, Reading, Reply, as_read, parse_deviation, parse_heading, parse_pose, parse_reply,
};
use super::track_file::no_shift;
use super::{DriveOrSkip, Mark, PoseSource, RunMeasurement, Sigma};
use crate::error::Result;
use crate::quantity::{Length, join_units};
use crate::question::{Choice, Picture, Question};
use crate::ui;

/// A person who measures with a tape or a ruler.
pub struct Tape {
    /// Whether to ask before each run.
    confirm: bool,
    /// The testbed of a simulated robot.
    bench: Option<Bench>,
    /// The uncertainty of a reading.
    sigma: Sigma,
    /// Where the robot stood before the run.
    start: Pose,
    /// Whether the last run was measured with the tape.
    by_tape: bool,
    /// Whether the axes and units were explained.
    explained: bool,
}

/// After a run.
const AFTER_RUN: &[Choice] = &[
    Choice { label: "Not measured", answer: "" },
    Choice { label: "Drive it again", answer: "repeat" },
    Choice { label: "Skip this run", answer: "skip" },
];

/// Lengths as a person types them.
fn millimetres(lengths_m: &[f64]) -> String {
    let typed = |length_m: &f64| format!("{:.1}mm", length_m * 1e3);
    lengths_m.iter().map(typed).collect::<Vec<_>>().join(" ")
}

impl Sigma {
    /// A tape from the start mark to the axle, and the robot's side against a line.
    pub const TAPE: Self = Self { position_m: 0.002, heading_rad: 0.01 };

    /// A ruler whose marks are this far apart \[m\]: rounding to the nearest mark, and parallax.
    pub fn of_ruler(resolution_m: f64) -> Self {
        Self { position_m: resolution_m / 2.0, ..Self::TAPE }
    }
}

impl Tape {
    /// A person who reads with this uncertainty; `bench` is that of a simulated robot.
    pub fn new(confirm: bool, sigma: Sigma, bench: Option<Bench>) -> Self {
        Self { confirm, bench, sigma, start: Pose::ORIGIN, by_tape: false, explained: false }
    }

    /// Has the robot put at the mark of a run, or asks where it stands instead.
    async fn put_at_its_mark(&mut self, clock: &Clock, run: &PlannedRun) -> Result<DriveOrSkip> {
        let place = ask_for(run);
        let mark = Pose::new(0.0, 0.0, run.heading_rad);
        self.start = mark;
        if !self.explained && (self.confirm || self.bench.is_some()) {
            self.explained = true;
            ui::note(format_args!(
                "  x along the campaign's axis, y to its left, from the start mark to the middle of the axle; \
                 headings to the left\n  good to {} mm and {} mrad, one sigma (--position-sigma, \
                 --heading-sigma)",
                self.sigma.position_m * 1e3,
                self.sigma.heading_rad * 1e3
            ));
        }
        while self.confirm {
            let question = Question::new(&place).picture(Picture::Mark).choices(
                AT_MARK,
                " Enter to drive, its pose if it stands elsewhere (12mm -3mm 1deg), s to skip, q to stop:",
            );
            match ui::ask(&question, clock).await?.to_lowercase().as_str() {
                "" | "y" | "yes" => break,
                "s" | "skip" => return Ok(DriveOrSkip::Skip),
                "q" | "quit" => return Err(stopped()),
                pose => match parse_pose(pose) {
                    Ok(read) => {
                        // Without a heading, the mark's is assumed.
                        let heading_rad = read.heading_rad.unwrap_or(mark.heading_rad);
                        self.start = Pose::new(read.x_m, read.y_m, heading_rad);
                        break;
                    }
                    Err(why) => ui::warn(why),
                },
            }
        }
        if let Some(bench) = &self.bench {
            let Pose { x_m, y_m, heading_rad } = self.start;
            let payload_kg = run.payload_kg;
            bench.with(move |testbed| {
                testbed.set_payload(payload_kg);
                testbed.place_on(sim_target::plant::Pose { x_m, y_m, heading_rad });
            })?;
        }
        Ok(DriveOrSkip::Drive)
    }

    /// What the ruler of a simulated robot reads, in words.
    fn read_ruler(&self, words: fn(&EndReading) -> String) -> Result<Option<String>> {
        let Some(bench) = &self.bench else { return Ok(None) };
        let read = words(&bench.with(Testbed::read_offset)?);
        ui::note(format_args!("  a ruler would read {read}"));
        Ok(Some(read))
    }

    /// Asks where the robot stands after a run; `reckoned` is the run by dead reckoning.
    async fn ask_where(&mut self, clock: &Clock, reckoned: &[Reckoned]) -> Result<RunMeasurement> {
        let suggested = match &self.bench {
            Some(bench) => Some(as_read(bench.with(Testbed::pose)?)),
            None => None,
        };
        if let Some(read) = &suggested {
            ui::note(format_args!("  a tape would read {read}"));
        }
        let mut doubted = None;
        loop {
            self.by_tape = false;
            let question = Question::new("Its pose now (1.795m -12mm 3deg), or a track file")
                .picture(Picture::Pose)
                .suggested(suggested.clone())
                .choices(AFTER_RUN, "; Enter for neither, repeat, skip, or q:");
            match parse_reply(&ui::ask(&question, clock).await?) {
                Ok(Reply::Pose(read)) => match self.ends(read, reckoned) {
                    Ok(mut track) => {
                        if read.heading_rad.is_none() {
                            match ask_heading(clock).await? {
                                Heading::Read(heading_rad) => track[1].heading_rad = heading_rad,
                                Heading::Repeat => return Ok(RunMeasurement::Repeat),
                                Heading::Skip => return Ok(RunMeasurement::Skip),
                                Heading::Quit => return Err(stopped()),
                            }
                        }
                        match doubt(&track, reckoned) {
                            Some(why) if doubted.as_ref() != Some(&track) => ui::warn(why),
                            _ => return Ok(RunMeasurement::Track(track)),
                        }
                        doubted = Some(track);
                    }
                    Err(why) => ui::warn(why),
                },
                Ok(Reply::Track(path)) => match read_track(&path) {
                    Ok((samples, _)) => match on_robot_clock(samples, reckoned) {
                        Some(track) => return Ok(RunMeasurement::Track(track)),
                        None => ui::warn(no_shift(&path)),
                    },
                    Err(error) => ui::warn(error),
                },
                Ok(Reply::Nothing) => return Ok(RunMeasurement::Track(Vec::new())),
                Ok(Reply::Repeat) => return Ok(RunMeasurement::Repeat),
                Ok(Reply::Skip) => return Ok(RunMeasurement::Skip),
                Ok(Reply::Quit) => return Err(stopped()),
                Err(why) => ui::warn(why),
            }
        }
    }

    /// The poses at both ends of a run; an error if the wheels cannot have reached the end.
    fn ends(
        &mut self,
        end: Reading,
        reckoned: &[Reckoned],
    ) -> std::result::Result<Vec<TrackSample>, String> {
        /// Allows for wheels that are larger than nominal, and for a crooked tape.
        const FARTHER: f64 = 1.25;
        const MARGIN_M: f64 = 0.1;
        let (Some(first), Some(last)) = (reckoned.first(), reckoned.last()) else {
            return Err("the robot sent no telemetry during the run".into());
        };
        let rolled_m: f64 = reckoned
            .windows(2)
            .map(|pair| {
                let (a, b) = (pair[0].pose, pair[1].pose);
                (b.x_m - a.x_m).hypot(b.y_m - a.y_m)
            })
            .sum();
        let moved_m = (end.x_m - self.start.x_m).hypot(end.y_m - self.start.y_m);
        if moved_m > FARTHER * rolled_m + MARGIN_M {
            return Err(format!(
                "that is {moved_m:.2} m from its start, but the wheels rolled {rolled_m:.2} m: check signs and units"
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

impl PoseSource for Tape {
    fn place<'a>(
        &'a mut self,
        clock: &'a Clock,
        mark: Mark<'a>,
    ) -> Waiting<'a, Result<DriveOrSkip>> {
        Box::pin(async move {
            match mark {
                Mark::Run(run) => self.put_at_its_mark(clock, run).await,
                Mark::Line(_) => {
                    if self.confirm {
                        confirm(clock, mark).await?;
                    }
                    if let Some(bench) = &self.bench {
                        bench.with(Testbed::place_at_start)?;
                    }
                    Ok(DriveOrSkip::Drive)
                }
            }
        })
    }

    fn read_deviation<'a>(
        &'a mut self,
        clock: &'a Clock,
        accept: &'a mut dyn FnMut(Deviation) -> Result<()>,
    ) -> Waiting<'a, Result<()>> {
        const QUESTION: &str = "Its offset from the line, left positive (-36mm), or dx and dy of the trace (2.525cm 1mm):";
        Box::pin(async move {
            loop {
                let suggested = self.read_ruler(|read| millimetres(&[read.left_m]))?;
                let question =
                    Question::new(QUESTION).picture(Picture::Offset).suggested(suggested);
                let answer = ui::ask(&question, clock).await?;
                let accepted = parse_deviation(&answer, self.sigma.position_m)
                    .and_then(|read| accept(read).map_err(|error| error.to_string()));
                match accepted {
                    Ok(()) => return Ok(()),
                    Err(why) => ui::warn(why),
                }
            }
        })
    }

    fn read_offset<'a>(&'a mut self, clock: &'a Clock) -> Waiting<'a, Result<[f64; 2]>> {
        const QUESTION: &str =
            "How far is it ahead of its mark, and to the left of it (-12mm 5mm)?";
        Box::pin(async move {
            loop {
                let suggested =
                    self.read_ruler(|read| millimetres(&[read.forward_m, read.left_m]))?;
                let question =
                    Question::new(QUESTION).picture(Picture::AheadLeft).suggested(suggested);
                let answer = ui::ask(&question, clock).await?;
                let lengths: std::result::Result<Vec<Length>, _> =
                    join_units(&answer).iter().map(|length| length.parse()).collect();
                match lengths.as_deref() {
                    Ok([ahead, left]) => return Ok([ahead.m, left.m]),
                    _ => ui::warn("give two lengths with their units: ahead and left, -12mm 5mm"),
                }
            }
        })
    }

    fn measure<'a>(
        &'a mut self,
        clock: &'a Clock,
        _: usize,
        _: &'a PlannedRun,
        reckoned: &'a [Reckoned],
    ) -> Waiting<'a, Result<RunMeasurement>> {
        Box::pin(self.ask_where(clock, reckoned))
    }

    fn reading_sigma(&self) -> Option<Sigma> {
        self.by_tape.then_some(self.sigma)
    }
}

/// Why the ends of a run, as read, hardly agree with the wheels: perhaps a wrong digit or sign.
fn doubt(track: &[TrackSample], reckoned: &[Reckoned]) -> Option<String> {
    let measured = |sample: &TrackSample| PoseMeasurement {
        t_s: sample.t_s,
        position_m: Some([sample.x_m, sample.y_m]),
        heading_rad: sample.heading_rad,
    };
    let wheels: Vec<Pose> = reckoned.iter().map(|reckoned| reckoned.pose).collect();
    let off = implausible_end_pose(&measured(track.first()?), &measured(track.last()?), &wheels)?;
    Some(format!(
        "that is {} off the pose by dead reckoning: read it again; the second reading is accepted",
        how_far(off.position_m, off.heading_rad)
    ))
}

/// Asks for the heading alone.
async fn ask_heading(clock: &Clock) -> Result<Heading> {
    loop {
        let question = Question::new("Its heading, to the left (3deg)")
            .picture(Picture::Heading)
            .choices(AFTER_RUN, ", Enter for none, repeat, skip, or q:");
        match parse_heading(&ui::ask(&question, clock).await?) {
            Ok(heading) => return Ok(heading),
            Err(why) => ui::warn(why),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_that_the_wheels_cannot_have_reached_is_refused() {
        let at = |t_s: f64, x_m: f64| Reckoned { t_s, pose: Pose::new(x_m, 0.0, 0.0) };
        // Out and back: the robot ends near its start, although its wheels rolled far.
        let reckoned = [at(5.0, 0.0), at(6.0, 0.9), at(8.0, 0.0)];
        let mut tape = Tape::new(true, Sigma::TAPE, None);
        let end = |x_m: f64| Reading { x_m, y_m: 0.0, heading_rad: None };
        let said = tape.ends(end(18.0), &reckoned).unwrap_err();
        assert!(said.contains("18.00 m from its start") && said.contains("1.80 m"), "{said}");
        assert_eq!(tape.reading_sigma(), None);
        let track = tape.ends(end(1.8), &reckoned).unwrap();
        assert_eq!(track.iter().map(|sample| sample.t_s).collect::<Vec<_>>(), [5.0, 8.0]);
        assert_eq!(tape.reading_sigma(), Some(Sigma::TAPE));
    }
}
