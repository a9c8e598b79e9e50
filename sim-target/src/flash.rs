//! The simulated flash: the firmware's configuration store, kept in memory or in a file.

use core::cell::RefCell;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use firmware::hal::{Store, StoreError};
use shared_proto::Config;

/// A flash that holds one configuration. Without a file, its content ends with the simulation.
#[derive(Clone)]
pub(crate) struct Flash(Rc<RefCell<FlashState>>);

struct FlashState {
    content: Option<String>,
    file: Option<PathBuf>,
    write_protected: bool,
}

impl Flash {
    /// A flash with the file's content, or a blank one if there is no file.
    pub(crate) fn new(file: Option<PathBuf>) -> std::io::Result<Self> {
        let content = match &file {
            Some(path) => match std::fs::read_to_string(path) {
                Ok(text) if text.is_empty() || text.starts_with(HEADER) => Some(text),
                // Any other file, such as a scenario, must not be overwritten.
                Ok(_) => {
                    return Err(std::io::Error::other("it is not the flash of a simulated robot"));
                }
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
                Err(error) => return Err(error),
            },
            None => None,
        };
        Ok(Self(Rc::new(RefCell::new(FlashState { content, file, write_protected: false }))))
    }

    pub(crate) fn put(&self, config: &Config) {
        self.0.borrow_mut().content = to_text(config);
    }

    pub(crate) fn content(&self) -> Option<String> {
        self.0.borrow().content.clone()
    }

    pub(crate) fn set_write_protected(&self, on: bool) {
        self.0.borrow_mut().write_protected = on;
    }
}

impl Store for Flash {
    async fn load(&mut self) -> Result<Option<Config>, StoreError> {
        match &self.0.borrow().content {
            None => Ok(None),
            Some(text) if text.is_empty() => Ok(None),
            Some(text) => toml::from_str(text).map(Some).map_err(|_| StoreError::Damaged),
        }
    }

    async fn save(&mut self, config: &Config) -> Result<(), StoreError> {
        // About what a real flash takes to erase and write.
        embassy_time::Timer::after_millis(5).await;
        let mut state = self.0.borrow_mut();
        if state.write_protected {
            return Err(StoreError::Write);
        }
        let text = to_text(config).ok_or(StoreError::Write)?;
        if let Some(path) = &state.file {
            write_whole(path, &text).map_err(|_| StoreError::Write)?;
        }
        state.content = Some(text);
        Ok(())
    }
}

/// The first line of every flash file.
const HEADER: &str = "# The flash of a simulated robot.\n";

fn to_text(config: &Config) -> Option<String> {
    Some(format!("{HEADER}{}", toml::to_string(config).ok()?))
}

/// Writes a new file, syncs it and renames it: the file holds the old text or the new one, never a part.
///
/// What a killed process left beside it is overwritten and renamed by the next save.
fn write_whole(path: &Path, text: &str) -> std::io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".beeline-part");
    let beside = path.with_file_name(name);
    let mut file = std::fs::File::create(&beside)?;
    // Synced before the rename, so that the name never refers to missing data.
    let written = file.write_all(text.as_bytes()).and_then(|()| file.sync_all());
    let renamed = written.and_then(|()| std::fs::rename(&beside, path));
    renamed.inspect_err(|_| drop(std::fs::remove_file(&beside)))?;
    sync_folder(path)
}

/// Makes the rename survive a power failure. Elsewhere a folder cannot be opened.
fn sync_folder(path: &Path) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match cfg!(unix).then(|| std::fs::File::open(folder.unwrap_or(Path::new(".")))) {
        Some(Ok(folder)) => folder.sync_all().or_else(|error| match error.kind() {
            std::io::ErrorKind::InvalidInput | std::io::ErrorKind::Unsupported => Ok(()),
            _ => Err(error),
        }),
        _ => Ok(()),
    }
}
