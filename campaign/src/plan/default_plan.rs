//! Which runs a campaign drives unless the user plans others.
//!
//! Each effect of the catalogue shows in some runs and not in others; a campaign that is to tell
//! the effects apart needs all these runs. The reasons are beside the runs, in
//! [`PlannedRun::shows`].

use std::f64::consts::{FRAC_PI_2, TAU};

use robot_model::recording::Piece;

use super::{CampaignPlan, PlanError, PlannedRun};

/// The floor, the speeds and the robot for which a campaign is planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanSettings {
    /// Free floor, length and width \[m\].
    pub floor_m: [f64; 2],
    /// The slow and the fast speed, of the faster wheel \[m/s\].
    pub speeds_mps: [f64; 2],
    /// Steepness of the ramps, of the faster wheel \[m/s^2\].
    pub acceleration_mps2: f64,
    /// How often each run is driven.
    pub repeats: u16,
    /// The load of one more out-and-back \[kg\]; zero: no such run.
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

/// Longest straight \[m\]: a tape of two metres, less a hand's width.
const STRAIGHT_M_MAX: f64 = 1.8;
/// Shortest straight that is worth driving, in track widths.
const STRAIGHT_TRACKS_MIN: f64 = 1.5;
/// Largest radius of an arc, in track widths.
const RADIUS_TRACKS_MAX: f64 = 2.4;
/// The small radius, as a share of the large one.
const SMALL_RADIUS: f64 = 0.45;
/// How far an arc turns: nine tenths of a circle, as an end beside the start adds no information.
const ARC_TURN_RAD: f64 = 0.9 * TAU;

impl CampaignPlan {
    /// The usual campaign on a floor.
    pub fn usual(settings: &PlanSettings) -> Result<Self, PlanError> {
        let b_m = settings.track_width_m;
        let free_m = settings.floor_m[0].min(settings.floor_m[1]) - 2.0 * b_m;
        let straight_m = STRAIGHT_M_MAX.min(free_m);
        if straight_m < STRAIGHT_TRACKS_MIN * b_m {
            return Err(PlanError::FloorTooSmall {
                floor_m: settings.floor_m,
                track_width_m: b_m,
                least_m: ((2.0 + STRAIGHT_TRACKS_MIN) * b_m * 10.0).ceil() / 10.0,
            });
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
            shows: "drift: the first drive again, at the end".into(),
            ..first
        });
        Ok(Self { acceleration_mps2: settings.acceleration_mps2, runs })
    }
}

/// Each run once.
fn once(settings: &PlanSettings, straight_m: f64, radii_m: [f64; 2]) -> Vec<PlannedRun> {
    let [slow_mps, fast_mps] = settings.speeds_mps;
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
                1 => "the same, fast: ramps, growth with speed",
                _ => "slope and carpet, which depend on the heading",
            },
            out_and_back(speed_mps),
        ));
    }
    runs.extend(turning(settings, straight_m, radii_m));
    if settings.payload_kg > 0.0 {
        runs.push(PlannedRun {
            payload_kg: settings.payload_kg,
            ..run(
                "out_and_back_loaded".into(),
                "out-and-back",
                0.0,
                "tyres flattened by a load",
                out_and_back(slow_mps),
            )
        });
    }
    runs
}

/// Spins, arcs and squares, both ways.
fn turning(settings: &PlanSettings, straight_m: f64, radii_m: [f64; 2]) -> Vec<PlannedRun> {
    let [slow_mps, fast_mps] = settings.speeds_mps;
    let half_m = settings.track_width_m / 2.0;
    let mut runs = Vec::new();
    let ways = [("left", 1.0), ("right", -1.0)];
    for (pace, speed_mps) in [("slow", slow_mps), ("fast", fast_mps)] {
        for (way, sign) in ways {
            let turn_rad = sign * 2.0 * TAU;
            runs.push(run(
                format!("spin_{pace}_{way}"),
                "spin",
                0.0,
                if sign > 0.0 { "track width" } else { "uneven turns; a marker off the centre" },
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
                        ("small", _) => "side slip, against the slow arc",
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
        let shows = "held out: does the model predict it?";
        let square = run(format!("square_{way}"), "square", 0.0, shows, side.repeat(4));
        runs.push(PlannedRun { held_out: true, ..square });
    }
    runs
}

/// A run without a load, to which a model is fitted.
fn run(name: String, kind: &str, heading_rad: f64, shows: &str, pieces: Vec<Piece>) -> PlannedRun {
    PlannedRun {
        name,
        kind: kind.into(),
        heading_rad,
        payload_kg: 0.0,
        held_out: false,
        shows: shows.into(),
        pieces,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Floor;

    #[test]
    fn the_usual_campaign_has_every_kind_that_tells_effects_apart_and_distinct_names() {
        let plan =
            CampaignPlan::usual(&PlanSettings { payload_kg: 3.0, ..PlanSettings::default() })
                .unwrap();
        let count = |kind: &str| plan.runs.iter().filter(|run| run.kind == kind).count();
        let kinds = ["rest", "out-and-back", "spin", "arc", "square"].map(count);
        // Four headings, one with a load, one again; both ways at two speeds; of two radii.
        assert_eq!(kinds, [1, 6, 4, 8, 2]);
        let mut names: Vec<_> = plan.runs.iter().map(|run| &run.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), plan.runs.len());
        // The squares, and no other runs, are held out to test the model.
        assert!(plan.runs.iter().all(|run| run.held_out == (run.kind == "square")));
    }

    #[test]
    fn every_run_stays_on_its_floor_at_its_speeds() {
        for floor_m in [[1.4, 9.0], [2.0, 2.0], [3.0, 2.5], [8.0, 8.0]] {
            let settings = PlanSettings { floor_m, ..PlanSettings::default() };
            let plan = CampaignPlan::usual(&settings).unwrap();
            for run in &plan.runs {
                let size_m = Floor::of(&run.pieces, settings.track_width_m).size_m();
                let least_m = floor_m[0].min(floor_m[1]) + 1e-9;
                assert!(size_m[0] <= least_m && size_m[1] <= least_m, "{} {size_m:?}", run.name);
                for piece in &run.pieces {
                    let (_, wheel_mps) = piece.wheels(settings.track_width_m);
                    assert!(wheel_mps <= 0.35 + 1e-9, "{}", run.name);
                }
            }
        }
    }

    #[test]
    fn a_floor_on_which_nothing_can_be_driven_is_refused_with_the_one_that_will_do() {
        let settings = PlanSettings { floor_m: [3.0, 1.0], ..PlanSettings::default() };
        let error = CampaignPlan::usual(&settings).unwrap_err();
        assert!(matches!(error, PlanError::FloorTooSmall { least_m: 1.4, .. }), "{error:?}");
        assert!(CampaignPlan::usual(&PlanSettings { floor_m: [1.4, 1.4], ..settings }).is_ok());
    }
}
