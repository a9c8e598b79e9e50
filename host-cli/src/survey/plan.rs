//! The runs of a campaign.
//!
//! Each effect of the catalogue shows in some runs and not in others; a campaign that is to tell them
//! apart needs them all. The reasons stand beside the runs, in [`PlannedRun::shows`].

use std::f64::consts::{FRAC_PI_2, TAU};

use robot_model::recording::Piece;

use super::Floor;
use super::piece;
use crate::error::{Error, Result};

/// Standing still before and after each piece \[s\]: the robot settles, and its noise shows.
pub const PAUSE_S: f64 = 0.3;

/// What to drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Steepness of the ramps, of the faster wheel \[m/s^2\].
    pub acceleration_mps2: f64,
    /// The runs, in the order in which they are driven.
    pub runs: Vec<PlannedRun>,
}

/// One run, from rest to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRun {
    /// Its name, which no other run of the plan has.
    pub name: String,
    /// What kind of run, as `explain` calls it.
    pub kind: String,
    /// Which way the robot faces at its start, from the campaign's x axis \[rad\].
    pub heading_rad: f64,
    /// What it carries \[kg\].
    pub payload_kg: f64,
    /// Kept aside: nothing is fitted to it.
    pub held_out: bool,
    /// What it shows.
    pub shows: String,
    /// What it does.
    pub pieces: Vec<Piece>,
}

/// What a campaign is planned for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanSettings {
    /// Free floor, both ways \[m\].
    pub floor_m: [f64; 2],
    /// Slow and fast, of the faster wheel \[m/s\].
    pub speeds_mps: [f64; 2],
    /// Steepness of the ramps, of the faster wheel \[m/s^2\].
    pub acceleration_mps2: f64,
    /// How often everything is driven.
    pub repeats: u16,
    /// A load for one more out-and-back; none, then no run with it.
    pub payload_kg: f64,
    /// Distance between the wheels \[m\].
    pub track_width_m: f64,
}

impl Default for PlanSettings {
    /// A robot of the paper's size on the floor of a small room.
    fn default() -> Self {
        Self {
            floor_m: [3.0, 3.0],
            speeds_mps: [0.12, 0.35],
            acceleration_mps2: 0.3,
            repeats: 1,
            payload_kg: 0.0,
            track_width_m: 0.372,
        }
    }
}

/// Longest run \[s\]: an hour, so that a slip of the pen does not drive for a day.
pub(super) const DURATION_S_MAX: f64 = 3600.0;

/// Longest straight \[m\]: two metres of tape, less a hand.
const STRAIGHT_M_MAX: f64 = 1.8;
/// Shortest straight that is worth driving, in track widths.
const STRAIGHT_TRACKS_MIN: f64 = 1.5;
/// Largest radius of an arc, in track widths.
const RADIUS_TRACKS_MAX: f64 = 2.4;
/// The small radius, of the large one.
const SMALL_RADIUS: f64 = 0.45;
/// Share of a full turn that an arc drives: an end beside its start tells nothing more.
const ARC_TURN_RAD: f64 = 0.9 * TAU;

impl Plan {
    /// The usual campaign on a floor.
    pub fn usual(settings: &PlanSettings) -> Result<Self> {
        let b_m = settings.track_width_m;
        let free_m = settings.floor_m[0].min(settings.floor_m[1]) - 2.0 * b_m;
        let straight_m = STRAIGHT_M_MAX.min(free_m);
        if straight_m < STRAIGHT_TRACKS_MIN * b_m {
            return Err(Error::new(format_args!(
                "a floor of {} m by {} m is too small for a robot with a track of {b_m} m",
                settings.floor_m[0], settings.floor_m[1]
            ))
            .hint(format_args!(
                "--floor {0}mx{0}m is the least; half a metre more in each direction is comfortable",
                ((2.0 + STRAIGHT_TRACKS_MIN) * b_m * 10.0).ceil() / 10.0
            )));
        }
        let large_m = (RADIUS_TRACKS_MAX * b_m).min(free_m / 2.0);
        let once = once(settings, straight_m, [SMALL_RADIUS * large_m, large_m]);
        let mut runs = Vec::new();
        for turn in 1..=settings.repeats {
            runs.extend(once.iter().cloned().map(|run| match turn {
                1 => run,
                _ => PlannedRun { name: format!("{}_{turn}", run.name), ..run },
            }));
        }
        let first = runs[1].clone();
        runs.push(PlannedRun {
            name: format!("{}_again", first.name),
            shows: "drift: the first drive once more, at the end".into(),
            ..first
        });
        Ok(Self { acceleration_mps2: settings.acceleration_mps2, runs })
    }

    /// How long it takes, without putting the robot at its marks \[s\].
    pub fn duration_s(&self, track_width_m: f64) -> f64 {
        self.runs.iter().map(|run| run.duration_s(track_width_m, self.acceleration_mps2)).sum()
    }

    /// Refuses a run that takes longer than anybody wants.
    pub fn check_durations(&self, track_width_m: f64) -> Result<()> {
        for run in &self.runs {
            let duration_s = run.duration_s(track_width_m, self.acceleration_mps2);
            if duration_s > DURATION_S_MAX {
                return Err(Error::new(format_args!(
                    "the run {} would take {duration_s:.0} s",
                    run.name
                ))
                .hint("an hour is the most: check speeds, distances and turns in the plan"));
            }
        }
        Ok(())
    }

    /// The floor that the whole of it needs if each run starts at the same mark, in its own heading.
    pub fn floor(&self, track_width_m: f64) -> Floor {
        let each = self.runs.iter().map(|run| Floor::of(&run.pieces, track_width_m));
        each.fold(Floor::default(), Floor::with)
    }
}

impl PlannedRun {
    /// How long it takes \[s\].
    pub fn duration_s(&self, track_width_m: f64, acceleration_mps2: f64) -> f64 {
        let each = self.pieces.iter().map(|it| {
            let pauses_s = if matches!(it, Piece::Rest { .. }) { 0.0 } else { 2.0 * PAUSE_S };
            pauses_s + piece::duration_s(it, track_width_m, acceleration_mps2)
        });
        each.sum()
    }
}

/// Everything once.
fn once(settings: &PlanSettings, straight_m: f64, radii_m: [f64; 2]) -> Vec<PlannedRun> {
    let [slow_mps, fast_mps] = settings.speeds_mps;
    let half_m = settings.track_width_m / 2.0;
    let run = |name: String, kind: &str, heading_rad: f64, shows: &str, pieces| PlannedRun {
        name,
        kind: kind.into(),
        heading_rad,
        payload_kg: 0.0,
        held_out: false,
        shows: shows.into(),
        pieces,
    };
    let out_and_back = |speed_mps: f64| {
        vec![
            Piece::Straight { travel_m: straight_m, speed_mps },
            Piece::Straight { travel_m: -straight_m, speed_mps },
        ]
    };
    let mut runs = vec![run(
        "rest".into(),
        "rest",
        0.0,
        "noise of the measured pose",
        vec![Piece::Rest { duration_s: 5.0 }],
    )];
    let headings =
        [("east", slow_mps), ("north", fast_mps), ("west", slow_mps), ("south", fast_mps)];
    for (quarter, (name, speed_mps)) in headings.into_iter().enumerate() {
        runs.push(run(
            format!("out_and_back_{name}"),
            "out-and-back",
            quarter as f64 * FRAC_PI_2,
            match quarter {
                0 => "wheel radii against a pull; reversing",
                1 => "the same fast: ramps, growth with speed",
                _ => "slope and carpet, which know north from south",
            },
            out_and_back(speed_mps),
        ));
    }
    let ways = [("left", 1.0), ("right", -1.0)];
    for (pace, speed_mps) in [("slow", slow_mps), ("fast", fast_mps)] {
        for (way, sign) in ways {
            let turn_rad = sign * 2.0 * TAU;
            runs.push(run(
                format!("spin_{pace}_{way}"),
                "spin",
                0.0,
                if sign > 0.0 { "track width" } else { "uneven turns; a marker off the middle" },
                vec![Piece::Spin { turn_rad, speed_mps }],
            ));
        }
    }
    for (size, radius_m) in [("small", radii_m[0]), ("large", radii_m[1])] {
        for (pace, wheel_mps) in [("slow", slow_mps), ("fast", fast_mps)] {
            let speed_mps = wheel_mps / (1.0 + half_m / radius_m);
            for (way, sign) in ways {
                let turn_rad = sign * ARC_TURN_RAD;
                runs.push(run(
                    format!("arc_{size}_{pace}_{way}"),
                    "arc",
                    0.0,
                    match (size, pace) {
                        ("small", "slow") => "scrub, against spins and wide arcs",
                        ("small", _) => "side slip, against the slow one",
                        (_, "slow") => "scrub, against the small arc",
                        _ => "load transfer in fast turns",
                    },
                    vec![Piece::Arc { radius_m, turn_rad, speed_mps }],
                ));
            }
        }
    }
    let side_m = straight_m.min(1.0);
    for (way, sign) in ways {
        let side = [
            Piece::Straight { travel_m: side_m, speed_mps: 0.7 * fast_mps },
            Piece::Spin { turn_rad: sign * FRAC_PI_2, speed_mps: slow_mps },
        ];
        let shows = "kept aside: whether the model predicts it";
        let square = run(format!("square_{way}"), "square", 0.0, shows, side.repeat(4));
        runs.push(PlannedRun { held_out: true, ..square });
    }
    if settings.payload_kg > 0.0 {
        runs.push(PlannedRun {
            payload_kg: settings.payload_kg,
            ..run(
                "out_and_back_loaded".into(),
                "out-and-back",
                0.0,
                "tyres that give under a load",
                out_and_back(slow_mps),
            )
        });
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_campaign_has_every_kind_that_tells_effects_apart_and_distinct_names() {
        let plan =
            Plan::usual(&PlanSettings { payload_kg: 3.0, ..PlanSettings::default() }).unwrap();
        let count = |kind: &str| plan.runs.iter().filter(|run| run.kind == kind).count();
        let kinds = ["rest", "out-and-back", "spin", "arc", "square"].map(count);
        // Four headings, one with a load, one again; both ways at two speeds; of two radii.
        assert_eq!(kinds, [1, 6, 4, 8, 2]);
        let mut names: Vec<_> = plan.runs.iter().map(|run| &run.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), plan.runs.len());
        // The squares, and nothing else, are for a model to be judged by.
        assert!(plan.runs.iter().all(|run| run.held_out == (run.kind == "square")));
    }

    #[test]
    fn every_run_stays_on_its_floor_at_its_speeds() {
        for floor_m in [[1.4, 9.0], [2.0, 2.0], [3.0, 2.5], [8.0, 8.0]] {
            let settings = PlanSettings { floor_m, ..PlanSettings::default() };
            let plan = Plan::usual(&settings).unwrap();
            for run in &plan.runs {
                let size_m = Floor::of(&run.pieces, settings.track_width_m).size_m();
                let least_m = floor_m[0].min(floor_m[1]) + 1e-9;
                assert!(size_m[0] <= least_m && size_m[1] <= least_m, "{} {size_m:?}", run.name);
                for piece in &run.pieces {
                    let motion = piece::motion(piece, settings.track_width_m, 0.3);
                    assert!(motion.is_none_or(|it| it.cruise <= 0.35 + 1e-9), "{}", run.name);
                }
            }
        }
    }

    #[test]
    fn a_floor_on_which_nothing_can_be_driven_is_refused_with_the_one_that_will_do() {
        let settings = PlanSettings { floor_m: [3.0, 1.0], ..PlanSettings::default() };
        let error = Plan::usual(&settings).unwrap_err();
        assert!(error.hint_text().unwrap().starts_with("--floor 1.4mx1.4m"), "{error:?}");
        assert!(Plan::usual(&PlanSettings { floor_m: [1.4, 1.4], ..settings }).is_ok());
    }
}
