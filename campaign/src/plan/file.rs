//! A plan as a TOML file, to be edited and given back.
//!
//! ```toml
//! acceleration_mps2 = 0.3
//!
//! [[run]]
//! name = "out_and_back_east"
//! kind = "out-and-back"
//! heading_deg = 0                # which way it faces at its start
//! pieces = [
//!   { straight_m = 1.8, speed_mps = 0.12 },          # backwards if negative
//!   { spin_deg = -90, speed_mps = 0.1 },             # speed of the rims; clockwise if negative
//!   { arc_deg = 324, radius_m = 0.4, speed_mps = 0.1 },   # speed of the middle; to the right if negative
//!   { rest_s = 1 },
//! ]
//! ```

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use shared_proto::Config;
use toml::Spanned;

use super::piece::{self, RawPiece, degrees};
use super::{CampaignPlan, DURATION_S_MAX, PlannedRun};
use crate::toml_text::parse_toml;
use crate::{CampaignError, Place, range};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPlan {
    acceleration_mps2: Spanned<f64>,
    #[serde(default)]
    run: Vec<RawRun>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRun {
    name: Spanned<String>,
    #[serde(default)]
    kind: Option<String>,
    #[serde(default)]
    heading_deg: Option<Spanned<f64>>,
    #[serde(default)]
    payload_kg: Option<Spanned<f64>>,
    #[serde(default)]
    held_out: bool,
    #[serde(default)]
    shows: String,
    pieces: Spanned<Vec<Spanned<RawPiece>>>,
}

/// The file with the plan of a campaign: a campaign that is continued follows the same plan.
pub fn plan_path(folder: &Path) -> PathBuf {
    folder.join("plan.toml")
}

impl CampaignPlan {
    /// Reads a plan.
    pub fn read(file: &Path) -> Result<Self, CampaignError> {
        let text = crate::bounded_read::read_keys(file)
            .map_err(|error| CampaignError::io(file, "read it", error))?;
        Self::parse(file, &text)
    }

    /// Reads a plan; `file` is what errors call it.
    pub fn parse(file: &Path, text: &str) -> Result<Self, CampaignError> {
        let raw: RawPlan = parse_toml(
            file,
            text,
            |_| "`beeline campaign plan -o plan.toml` writes one to start from",
        )?;
        let fail = |byte: usize, problem: String, hint: &str| {
            CampaignError::new(Place::of_byte(file, text, byte), problem, hint)
        };
        let acceleration_mps2 = *raw.acceleration_mps2.get_ref();
        check("acceleration_mps2", acceleration_mps2)
            .map_err(|(problem, hint)| fail(raw.acceleration_mps2.span().start, problem, &hint))?;
        if raw.run.is_empty() {
            let problem = "there is no run in this plan";
            return Err(CampaignError::new(Place::whole(file), problem, "add a [[run]]"));
        }
        let mut runs: Vec<PlannedRun> = Vec::new();
        for raw in raw.run {
            let name_at = raw.name.span().start;
            let run = planned(raw, acceleration_mps2, &fail)?;
            if runs.iter().any(|other| other.name == run.name) {
                let problem = format!("there are two runs named `{}`", run.name);
                return Err(fail(name_at, problem, "give each a name of its own"));
            }
            runs.push(run);
        }
        Ok(Self { acceleration_mps2, runs })
    }

    /// Whether both plans drive the same runs, to the digits of their files. What a run is said to show is no part
    /// of what it drives: another version may say it in other words.
    pub fn drives_the_same_as(&self, other: &Self) -> bool {
        let driven = |plan: &Self| {
            let mut plan = plan.clone();
            plan.runs.iter_mut().for_each(|run| run.shows.clear());
            plan.to_toml()
        };
        driven(self) == driven(other)
    }

    /// The plan as TOML, which [`CampaignPlan::parse`] reads back.
    pub fn to_toml(&self) -> String {
        let mut text = format!(
            "# The plan of a campaign: `beeline campaign record FOLDER --plan THIS_FILE` drives it.\n\
             # Metres, seconds, degrees; left and counter-clockwise are positive, backwards is negative.\n\
             acceleration_mps2 = {}    # ramps of the faster wheel\n",
            self.acceleration_mps2
        );
        let quoted = |text: &str| toml::Value::String(text.into()).to_string();
        for run in &self.runs {
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "\n[[run]]\nname = {}\nkind = {}\n",
                quoted(&run.name),
                quoted(&run.kind)
            );
            let heading_deg = degrees(run.heading_rad);
            if heading_deg != 0.0 {
                let _ = writeln!(text, "heading_deg = {heading_deg}");
            }
            if run.payload_kg != 0.0 {
                let _ = writeln!(text, "payload_kg = {}", run.payload_kg);
            }
            if run.held_out {
                text.push_str("held_out = true    # nothing is fitted to this run\n");
            }
            if !run.shows.is_empty() {
                let _ = writeln!(text, "shows = {}", quoted(&run.shows));
            }
            text.push_str("pieces = [\n");
            for piece in &run.pieces {
                let _ = writeln!(text, "  {},", piece::line(piece));
            }
            text.push_str("]\n");
        }
        text
    }
}

/// One run of a plan; `fail` makes an error from a byte, a problem and what to try.
fn planned(
    raw: RawRun,
    acceleration_mps2: f64,
    fail: &dyn Fn(usize, String, &str) -> CampaignError,
) -> Result<PlannedRun, CampaignError> {
    let (name, name_at) = (raw.name.get_ref().clone(), raw.name.span().start);
    let sound = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    if name.is_empty() || !name.chars().all(sound) {
        let problem = format!("`{name}` cannot be the name of a run");
        return Err(fail(name_at, problem, "use letters, digits, - and _"));
    }
    let number = |given: &Option<Spanned<f64>>, key: &str| match given {
        None => Ok(0.0),
        Some(value) => check(key, *value.get_ref())
            .map_err(|(problem, hint)| fail(value.span().start, problem, &hint)),
    };
    let heading_deg = number(&raw.heading_deg, "heading_deg")?;
    let payload_kg = number(&raw.payload_kg, "payload_kg")?;
    if raw.pieces.get_ref().is_empty() {
        let problem = format!("the run `{name}` has no pieces");
        return Err(fail(raw.pieces.span().start, problem, "give it at least one piece"));
    }
    let pieces = raw.pieces.get_ref().iter().map(|raw| {
        piece::parse(raw.get_ref()).map_err(|problem| {
            let hint = "a piece is { straight_m, speed_mps }, { spin_deg, speed_mps }, { arc_deg, radius_m, speed_mps } or { rest_s }";
            fail(raw.span().start, problem, hint)
        })
    });
    let pieces = pieces.collect::<Result<Vec<_>, _>>()?;
    let run = PlannedRun {
        kind: raw.kind.unwrap_or_else(|| "mixed".into()),
        heading_rad: heading_deg.to_radians(),
        payload_kg,
        held_out: raw.held_out,
        shows: raw.shows,
        pieces,
        name,
    };
    // The duration of a spin grows with the track width, which is not known here: a run that is too
    // long for the narrowest track is too long for any. `check_durations` tests with the robot's
    // own.
    let duration_s = run.duration_s(track_width_m_min(), acceleration_mps2);
    if duration_s > DURATION_S_MAX {
        let problem = format!("the run `{}` would take {:.0} s", run.name, duration_s);
        return Err(fail(name_at, problem, "a run may take an hour: check speeds and distances"));
    }
    Ok(run)
}

/// A number of this key; otherwise the problem and what to try.
fn check(key: &str, value: f64) -> Result<f64, (String, String)> {
    match range::of_plan_key(key).filter(|range| !range.contains(value)) {
        None => Ok(value),
        Some(range) => Err((
            format!("{key} = {} is invalid", range::short(value)),
            format!("it must be {range}"),
        )),
    }
}

/// The narrowest track that a configuration may have \[m\].
fn track_width_m_min() -> f64 {
    let track = Config::FIELDS.iter().find(|field| field.path == "geometry.track_width_m");
    track.map_or(0.0, |field| field.min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::PlanSettings;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<CampaignPlan, CampaignError> {
        CampaignPlan::parse(Path::new("plan.toml"), text)
    }

    #[test]
    fn a_written_plan_reads_back_as_it_was() {
        let plan =
            CampaignPlan::usual(&PlanSettings { payload_kg: 2.5, ..PlanSettings::default() })
                .unwrap();
        let back = parse(&plan.to_toml()).unwrap();
        assert_eq!(back.runs.len(), plan.runs.len());
        for (a, b) in plan.runs.iter().zip(&back.runs) {
            assert_eq!((&a.name, &a.kind, &a.shows), (&b.name, &b.kind, &b.shows));
            assert_eq!((a.payload_kg, a.held_out), (b.payload_kg, b.held_out));
            // Through degrees and back: nine digits.
            assert!((a.heading_rad - b.heading_rad).abs() < 1e-10);
            assert_eq!(piece::line(&a.pieces[0]), piece::line(&b.pieces[0]));
            assert_eq!(a.pieces.len(), b.pieces.len());
        }
        assert_eq!(back.to_toml(), plan.to_toml());
    }

    #[test]
    fn a_plan_with_more_digits_than_are_written_reads_back_as_it_was() {
        let plan = parse(
            "acceleration_mps2 = 0.3\n[[run]]\nname = \"a\"\nheading_deg = 1e-12\npieces = [\n\
             { straight_m = 0.0024, speed_mps = 1.4e-6 }, { spin_deg = 1.0000000004, speed_mps = 0.1 }]\n",
        )
        .unwrap();
        let back = parse(&plan.to_toml()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(back.to_toml(), plan.to_toml());
        assert_eq!(back.runs[0].pieces[0], plan.runs[0].pieces[0]);
    }

    #[test]
    fn a_plan_is_the_same_in_other_words_and_another_one_with_another_piece() {
        let plan = CampaignPlan::usual(&PlanSettings::default()).unwrap();
        let mut other = parse(&plan.to_toml()).unwrap();
        other.runs[3].shows = "other words".into();
        assert!(plan.drives_the_same_as(&other));
        other.runs[3].pieces.truncate(1);
        other.runs[3].heading_rad += 0.1;
        assert!(!plan.drives_the_same_as(&other));
    }

    #[test]
    fn an_error_in_a_plan_has_its_line_and_column() {
        let run =
            |pieces: &str| format!("acceleration_mps2 = 0.3\n[[run]]\nname = \"a\"\n{pieces}\n");
        let cases = [
            ("acceleration_mps2 = -1\n".to_owned(), 1, 21, "is invalid"),
            ("acceleration_mps2 = 0.3\nspeed = 2\n".to_owned(), 2, 1, "unknown field"),
            ("acceleration_mps2 = 0.3\n".to_owned(), 0, 0, "no run"),
            (run("pieces = [{ straight_m = 1 }]"), 4, 11, "speed_mps is missing"),
            (run("pieces = [\n  { spin_deg = 0, speed_mps = 1 }]"), 5, 3, "not zero"),
            (run("pieces = [{ arc_deg = 9, speed_mps = 1 }]"), 4, 11, "radius_m"),
            (run("pieces = [{ rest_s = 1, speed_mps = 1 }]"), 4, 11, "no speed"),
            (run("pieces = [{ straight_m = 1, rest_s = 1 }]"), 4, 11, "one of"),
            (run("pieces = [{ straight_m = 1, speed_mps = 1e-4 }]"), 3, 8, "would take"),
            (
                run("pieces = [{ straight_m = 1, speed_mps = 1e-9 }]"),
                4,
                11,
                "from 1e-6 to 1000 m/s",
            ),
            (
                run("pieces = [{ straight_m = 1, speed_mps = 1e84 }]"),
                4,
                11,
                "from 1e-6 to 1000 m/s",
            ),
            (run("pieces = [{ straight_m = -1e-7, speed_mps = 1 }]"), 4, 11, "either way"),
            (
                run("payload_kg = 1e200\npieces = [{ rest_s = 1 }]"),
                4,
                14,
                "payload_kg = 1e200 is invalid",
            ),
            (run("pieces = [{ spin_deg = 900000, speed_mps = 0.02 }]"), 3, 8, "would take"),
            (run("pieces = []"), 4, 10, "has no pieces"),
            (run("held_out = 1\npieces = [{ rest_s = 1 }]"), 4, 12, "expected a boolean"),
            (run("payload_kg = nan\npieces = [{ rest_s = 1 }]"), 4, 14, "is invalid"),
            (run("pieces = [{ straight_m = 1, speed_mps = fast }]"), 4, 41, ""),
            (run("").replace("\"a\"", "\"../a\"") + "pieces = []", 3, 8, "name of a run"),
        ];
        for (text, line, column, problem) in cases {
            let error = parse(&text).unwrap_err();
            assert_eq!((error.place.line, error.place.column), (line, column), "{text}{error}");
            assert!(error.problem.contains(problem), "{error}");
            assert!(!error.hint.is_empty());
        }
        let twice =
            run("pieces = [{ rest_s = 1 }]\n[[run]]\nname = \"a\"\npieces = [{ rest_s = 1 }]");
        assert!(parse(&twice).unwrap_err().problem.contains("two runs"));
    }

    #[test]
    fn the_duration_of_a_spin_depends_on_the_track_width() {
        // 100 turns of 0.37 m are 117 m at 0.02 m/s; of a robot with a tenth of that track 12 m.
        let plan = parse(
            "acceleration_mps2 = 0.3\n[[run]]\nname = \"a\"\n\
             pieces = [{ spin_deg = 36000, speed_mps = 0.02 }]\n",
        )
        .unwrap();
        assert!(plan.check_durations(0.0372).is_ok());
        let error = plan.check_durations(0.372).unwrap_err().to_string();
        assert!(error.contains("the run a would take 58"), "{error}");
    }

    proptest! {
        #[test]
        fn mangled_plans_are_read_or_refused_and_nothing_panics(
            cut in 0_usize..3000, insert in "\\PC{0,6}", drop in 0_usize..40
        ) {
            let mut text = CampaignPlan::usual(&PlanSettings::default()).unwrap().to_toml();
            let cut = text.floor_char_boundary(cut.min(text.len()));
            let end = text.floor_char_boundary((cut + drop).min(text.len()));
            text.replace_range(cut..end, &insert);
            let _ = parse(&text);
        }
    }
}
