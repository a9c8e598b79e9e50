//! Every command that writes, and what it starts from.

use crate::temp_folder::TempFolder;

use super::tree::{KEYS, Tree};

/// A command that writes, and the commands that make the folder it starts from.
pub struct Writing {
    pub line: &'static str,
    pub before: &'static [&'static str],
    pub writers: Writers,
    /// A file that must be there before another one changes: `(first, then)`.
    pub order: Option<(&'static str, &'static str)>,
    /// A picture that may be missing: of a drive after which the robot is straight already, and drives no more.
    pub picture: Option<&'static str>,
}

/// What of a second process that gives the same command at the same time.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Writers {
    /// Nothing is promised.
    One,
    /// Both write the same, whoever comes first.
    Alike,
    /// The campaign folder `robot` has one writer at a time.
    Locked,
}

const fn writing(line: &'static str, before: &'static [&'static str]) -> Writing {
    Writing { line, before, writers: Writers::One, order: None, picture: None }
}

const fn locking(line: &'static str, before: &'static [&'static str]) -> Writing {
    Writing { writers: Writers::Locked, ..writing(line, before) }
}

const RECORD: &str = "campaign record robot --plan plan.toml";
const SAVE: &str = "config set geometry.wheel_weight 0.995 --save --flash flash";
const EXPORT: &str = "config export robot.toml --flash flash";
const ADD: &str = "model add wheel_radius_ratio robot";
const CALIBRATE: &str = "calibrate --flash flash -o picture.svg";
const KEY_SET: &str = "key set robot.key --flash flash";
const TUNE: &str = "tune --flash flash";
const EXPORT_BAG: &str = "export robot --to mcap -o runs.mcap";
const APPLY: &str = "apply robot --yes --flash flash";

/// All of them.
pub const ALL: &[Writing] = &[
    locking("record robot straight 0.3m", &[]),
    locking("record robot straight 0.3m", &["record robot straight 0.3m"]),
    // What the robot compensates goes into a model.
    locking("record robot straight 0.3m --flash flash", &[SAVE]),
    locking(RECORD, &[]),
    locking(RECORD, &["record robot straight 0.3m --name a"]),
    locking("campaign record robot --run straight", &[RECORD]),
    writing("campaign plan -o new.toml", &[]),
    locking(ADD, &[RECORD]),
    locking("model add wheel_radius_scale robot", &[RECORD, ADD]),
    locking("model remove wheel_radius_ratio robot", &[RECORD, ADD]),
    locking("model fit robot", &[RECORD, ADD, "record robot straight 0.3m"]),
    writing("explain robot --save found.toml", &[RECORD]),
    writing("report robot -o report.html", &[RECORD]),
    writing(SAVE, &[]),
    writing("config import robot.toml --save --flash flash", &[SAVE, EXPORT]),
    writing(EXPORT, &[SAVE]),
    writing("config export robot.toml --force --flash flash", &["config export robot.toml", SAVE]),
    writing("config save --flash flash", &[]),
    Writing {
        order: Some(("state", "flash")),
        picture: Some("picture.svg"),
        ..writing(CALIBRATE, &["config save --flash flash"])
    },
    writing("calibrate --undo --flash flash", &["config save --flash flash", CALIBRATE]),
    Writing {
        order: Some(("state", "flash")),
        ..writing(APPLY, &["config save --flash flash", RECORD, ADD])
    },
    writing("apply --undo --flash flash", &["config save --flash flash", RECORD, ADD, APPLY]),
    Writing { order: Some(("state", "flash")), ..writing(TUNE, &["config save --flash flash"]) },
    writing("tune --undo --flash flash", &["config save --flash flash", TUNE]),
    writing("export robot --to csv -o runs.csv", &[RECORD]),
    writing(EXPORT_BAG, &[RECORD]),
    writing("export robot --to tum -o tum", &[RECORD]),
    Writing {
        writers: Writers::Alike,
        ..writing("import runs.mcap -o again --track-width 37.2cm", &[RECORD, EXPORT_BAG])
    },
    locking("import runs.mcap -o robot --add", &[RECORD, EXPORT_BAG]),
    // The page is that of an earlier import until this one is complete.
    Writing {
        writers: Writers::Alike,
        ..writing(
            "import more.mcap -o again --add",
            &[
                RECORD,
                EXPORT_BAG,
                "import runs.mcap -o again --track-width 37.2cm",
                "record robot straight 0.5m",
                "export robot --to mcap -o more.mcap",
            ],
        )
    },
    // By its name it is of that day, whenever its files were written.
    writing(
        "fleet robots -o fleet.html --table fleet.csv",
        &[RECORD, EXPORT_BAG, "import runs.mcap -o robots/2025-03-01 --track-width 37.2cm"],
    ),
    writing("key new new.key", &[]),
    writing(KEY_SET, &["config save --flash flash"]),
    writing("key set other.key --flash flash --key-file robot.key", &[SAVE, KEY_SET]),
    writing("key clear --flash flash --key-file robot.key", &[SAVE, KEY_SET]),
];

/// Two runs, one of them with facts; and enough of a drive to fit the ratio of the radii to.
const PLAN: &str = "\
acceleration_mps2 = 0.3
[[run]]
name = \"a\"
payload_kg = 2.5
held_out = true
pieces = [{ straight_m = 0.3, speed_mps = 0.2 }]
[[run]]
name = \"b\"
pieces = [{ straight_m = 1, speed_mps = 0.2 }]
";

impl Writing {
    /// What it starts from.
    pub fn start(&self) -> Tree {
        let temp = TempFolder::new();
        temp.write("plan.toml", PLAN);
        let [robot, other] = KEYS.map(Into::into);
        Tree([("robot.key".into(), robot), ("other.key".into(), other)].into())
            .write(&temp.path(""));
        for line in self.before {
            temp.run(line).ok();
        }
        Tree::of(&temp.path(""))
    }
}

/// A folder with these files.
pub fn folder(tree: &Tree) -> TempFolder {
    let temp = TempFolder::new();
    tree.write(&temp.path(""));
    temp
}
