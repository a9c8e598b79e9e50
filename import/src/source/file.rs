//! Which files a path stands for, and which of them are bags.

use std::fs;
use std::path::{Path, PathBuf};

use campaign::CampaignError;

use crate::log::error;

/// The files of a path: itself, or the bags of a folder, as ROS 2 splits them.
pub(super) fn files(path: &Path) -> Result<Vec<PathBuf>, CampaignError> {
    let cannot = |cause| CampaignError::io(path, "read it", cause);
    if !fs::metadata(path).map_err(cannot)?.is_dir() {
        return Ok(vec![path.into()]);
    }
    let entries =
        fs::read_dir(path).map_err(cannot)?.collect::<Result<Vec<_>, _>>().map_err(cannot)?;
    let mut all: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    all.sort();
    let ends = |file: &Path, ending: &str| {
        file.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending))
    };
    let bags: Vec<PathBuf> = all.iter().filter(|file| ends(file, "mcap")).cloned().collect();
    if bags.is_empty() {
        let hint = match all.iter().any(|file| ends(file, "db3")) {
            true => "this bag is in sqlite3: make one in MCAP with `ros2 bag convert`",
            false => "name the files, or the folder of a ROS 2 bag",
        };
        return Err(error(path, "no .mcap file is in this folder", hint));
    }
    Ok(bags)
}

/// Whether a file is a bag, by its name or its first byte.
pub(super) fn is_bag(file: &Path) -> Result<bool, CampaignError> {
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("mcap") => Ok(true),
        Some("db3") => {
            let hint = "make a bag in MCAP of it with `ros2 bag convert`";
            Err(error(file, "this bag is in sqlite3, which is not read", hint))
        }
        Some("bag") => {
            let hint = "make a ROS 2 bag in MCAP of it, for example with `rosbags-convert`";
            Err(error(file, "this is a bag of ROS 1, which is not read", hint))
        }
        _ => Ok(false),
    }
}
