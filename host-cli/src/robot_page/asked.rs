//! Which procedure the page asks for, as a command line.

use std::path::PathBuf;

use serde::Deserialize;

/// The drawing of a calibration, in the folder in which the page is served.
const DRAWING: &str = "beeline-calibration.svg";

/// A procedure, with its options as they are typed on a terminal.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind", content = "options")]
pub enum Asked {
    /// `beeline calibrate`
    Calibrate(Calibrate),
    /// `beeline tune`
    Tune(Tune),
    /// `beeline campaign record`
    Campaign(Campaign),
}

/// Options of a calibration.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Calibrate {
    distance: Option<String>,
    runs: Option<String>,
    measure: Option<String>,
    out_and_back: bool,
    undo: bool,
}

/// Options of the tuning.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tune {
    floor: Option<String>,
    stiffness: Option<String>,
    undo: bool,
}

/// Options of a campaign.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Campaign {
    folder: String,
    floor: Option<String>,
    measure: Option<String>,
    run: Option<String>,
}

impl Asked {
    /// What the page calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Calibrate(_) => "calibrate",
            Self::Tune(_) => "tune",
            Self::Campaign(_) => "campaign",
        }
    }

    /// The folder of a campaign.
    pub fn folder(&self) -> Option<PathBuf> {
        match self {
            Self::Campaign(campaign) => Some(PathBuf::from(&campaign.folder)),
            _ => None,
        }
    }

    /// The file into which a calibration is drawn.
    pub fn drawing(&self) -> Option<PathBuf> {
        match self {
            Self::Calibrate(calibrate) if !calibrate.undo => Some(DRAWING.into()),
            _ => None,
        }
    }

    /// The words of the command line, after the program's name; the error says which option is wrong.
    pub fn args(&self) -> Result<Vec<String>, String> {
        // A value is never an option, whatever it begins with.
        let option = |name: &str, value: &Option<String>| {
            value.as_ref().map(|value| format!("--{name}={value}"))
        };
        let flag = |name: &str, is_on: bool| is_on.then(|| format!("--{name}"));
        let words = match self {
            Self::Calibrate(Calibrate { undo: true, .. }) => {
                vec![Some("calibrate".to_owned()), flag("undo", true)]
            }
            Self::Calibrate(Calibrate { distance, runs, measure, out_and_back, undo: false }) => {
                vec![
                    Some("calibrate".to_owned()),
                    option("distance", distance),
                    option("runs", runs),
                    option("measure", &measured(measure)?),
                    flag("out-and-back", *out_and_back),
                    Some(format!("--output={DRAWING}")),
                ]
            }
            Self::Tune(Tune { undo: true, .. }) => {
                vec![Some("tune".to_owned()), flag("undo", true)]
            }
            Self::Tune(Tune { floor, stiffness, undo: false }) => vec![
                Some("tune".to_owned()),
                option("floor", floor),
                option("stiffness", stiffness),
            ],
            Self::Campaign(Campaign { folder, floor, measure, run }) => {
                check_folder(folder)?;
                vec![
                    Some("campaign".to_owned()),
                    Some("record".to_owned()),
                    Some(folder.clone()),
                    option("floor", floor),
                    option("measure", &measured(measure)?),
                    option("run", run),
                ]
            }
        };
        Ok(words.into_iter().flatten().collect())
    }
}

/// What a page calls what a terminal types, longest first.
const NAMES: [(&str, &str); 14] = [
    (
        "check the distance, --cruise and --acceleration",
        "check the distance or angle, and the speed",
    ),
    ("`beeline clear`", "\u{201c}Clear the fault\u{201d}"),
    ("--out-and-back", "\u{201c}Also drive back\u{201d}"),
    ("--position-sigma, --heading-sigma", "set on a terminal: --position-sigma, --heading-sigma"),
    ("--measure ask, or --measure track:FILE", "measured by you"),
    ("'--distance <DISTANCE>'", "the distance"),
    ("--distance", "\u{201c}Distance\u{201d}"),
    ("--runs", "\u{201c}Runs\u{201d}"),
    ("--stiffness", "\u{201c}Stiffness\u{201d}"),
    ("--floor", "\u{201c}Free floor\u{201d}"),
    ("'\u{201c}Free floor\u{201d} <LENGTH>'", "the free floor"),
    ("'\u{201c}Free floor\u{201d} <LENGTHxLENGTH>'", "the free floor"),
    ("--fast", "the fast speed of the plan"),
    ("`beeline --help`", "the fields of this page"),
];

/// What a command says, in the words of the page.
pub(super) fn on_page(text: &str) -> String {
    NAMES.iter().fold(text.to_owned(), |text, (typed, shown)| text.replace(typed, shown))
}

/// What a page may have measured: files of this machine are for the terminal.
fn measured(measure: &Option<String>) -> Result<Option<String>, String> {
    match measure.as_deref() {
        None | Some("ask" | "camera" | "none") => Ok(measure.clone()),
        Some(_) => Err("on the page, it is measured by `ask`, `camera` or `none`".to_owned()),
    }
}

/// A page writes into folders beside the program, nowhere else.
fn check_folder(folder: &str) -> Result<(), String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let begins = folder.chars().next().is_some_and(|c| c.is_ascii_alphanumeric());
    if begins && folder.len() <= 60 && folder.chars().all(is_plain) {
        return Ok(());
    }
    Err("name the campaign with letters, digits, - and _, 60 at most".to_owned())
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn args(kind: &str, options: Value) -> Result<Vec<String>, String> {
        let asked: Asked = serde_json::from_value(json!({"kind": kind, "options": options}))
            .map_err(|error| error.to_string())?;
        asked.args()
    }

    #[test]
    fn a_procedure_is_a_command_line_and_no_value_is_an_option() {
        let line = args("calibrate", json!({"distance": "-o x", "out_and_back": true})).unwrap();
        let expected =
            ["calibrate", "--distance=-o x", "--out-and-back", "--output=beeline-calibration.svg"];
        assert_eq!(line, expected);
        let line = args("tune", json!({"undo": true, "floor": "2m"})).unwrap();
        assert_eq!(line, ["tune", "--undo"]);
        let line = args("campaign", json!({"folder": "my-robot", "run": "spin"})).unwrap();
        assert_eq!(line, ["campaign", "record", "my-robot", "--run=spin"]);
    }

    #[test]
    fn options_have_the_names_of_the_fields() {
        let shown = on_page("use at least --floor 30cm; --runs 4 takes a mean");
        assert_eq!(
            shown,
            "use at least \u{201c}Free floor\u{201d} 30cm; \u{201c}Runs\u{201d} 4 takes a mean"
        );
        assert!(!on_page("then `beeline clear`").contains('`'));
    }

    #[test]
    fn a_page_reads_no_file_and_writes_nowhere_else() {
        for folder in ["", "../x", "/tmp/x", "a/b", "-p", ".hidden", "a b", "x\0"] {
            assert!(args("campaign", json!({"folder": folder})).is_err(), "{folder}");
        }
        for measure in ["track:/etc/passwd", "ruler", ""] {
            assert!(args("calibrate", json!({"measure": measure})).is_err(), "{measure}");
        }
        assert!(args("calibrate", json!({"output": "/tmp/x"})).is_err());
        assert!(args("sim", json!({})).is_err());
    }
}
