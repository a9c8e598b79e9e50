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
    let ending = |ending: &str| -> Vec<PathBuf> {
        all.iter().filter(|file| ending_of(file).as_deref() == Some(ending)).cloned().collect()
    };
    // A folder with both has one bag in both formats.
    let bags = [ending("mcap"), ending("db3")].into_iter().find(|bags| !bags.is_empty());
    bags.ok_or_else(|| {
        let hint = "name the files, or the folder of a ROS 2 bag";
        error(path, "no .mcap and no .db3 file is in this folder", hint)
    })
}

fn ending_of(file: &Path) -> Option<String> {
    file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase())
}

/// Whether a file is a bag, by its name.
pub(super) fn is_bag(file: &Path) -> Result<bool, CampaignError> {
    match ending_of(file).as_deref() {
        Some("mcap" | "db3") => Ok(true),
        Some("zstd" | "zst") => {
            Err(error(file, "this file is compressed as a whole", "unpack it with `zstd -d`"))
        }
        Some("bag") => {
            let hint = "make a ROS 2 bag in MCAP of it, for example with `rosbags-convert`";
            Err(error(file, "this is a bag of ROS 1, which is not read", hint))
        }
        _ => Ok(false),
    }
}
