//! The simulated flash: the firmware's store, kept in memory or in a file.
//!
//! ```text
//! # The flash of a simulated robot.
//! # link 5 00112233445566778899aabbccddeeff      how often it started with a key, and the key; or no such line
//! name = "..."                                  the configuration, if one was saved
//! ```

use core::cell::RefCell;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use firmware::hal::{LinkRecord, Store, StoreError};
use shared_proto::{Config, Key};

/// A flash that holds a configuration and a key. Without a file, its content ends with the simulation.
#[derive(Clone)]
pub(crate) struct Flash(Rc<RefCell<FlashState>>);

struct FlashState {
    /// The configuration.
    content: Option<String>,
    link: Result<LinkLine, StoreError>,
    /// The key cannot be changed from outside.
    key_locked: bool,
    file: Option<PathBuf>,
    /// What the file holds, as far as this robot knows.
    known: Option<String>,
    write_protected: bool,
}

/// No flash is larger \[bytes\]: any other file, however large, is refused by its beginning.
const FILE_MAX: u64 = 64 << 10;

fn read_bounded(path: &Path) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(FILE_MAX).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

impl Flash {
    /// A flash with the file's content, or a blank one if there is no file.
    pub(crate) fn new(file: Option<PathBuf>) -> std::io::Result<Self> {
        let content = match &file {
            Some(path) => match read_bounded(path) {
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
        let known = content.clone();
        let (content, link) = content.map_or((None, Ok(LinkLine::default())), LinkLine::split);
        let state =
            FlashState { content, link, key_locked: false, file, known, write_protected: false };
        Ok(Self(Rc::new(RefCell::new(state))))
    }

    /// Puts a key in, for this robot's time; the file does not get it.
    pub(crate) fn lend_key(&self, key: Option<Key>) {
        if let (Some(key), Ok(link)) = (key, &mut self.0.borrow_mut().link) {
            link.lent = Some(key);
        }
    }

    /// Refuses or allows other keys.
    pub(crate) fn lock_key(&self, on: bool) {
        self.0.borrow_mut().key_locked = on;
    }

    /// Whether only holders of a key may talk to the robot.
    pub(crate) fn has_key(&self) -> bool {
        self.0.borrow().link.map_or(true, |link| link.key().is_some())
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
        let text = to_text(config).ok_or(StoreError::Write)?;
        let link = state.link;
        state.write(Some(text), link)
    }

    async fn link(&mut self, change: Option<Option<Key>>) -> Result<LinkRecord, StoreError> {
        let mut state = self.0.borrow_mut();
        let mut link = state.link?;
        if let Some(key) = change {
            if state.key_locked {
                return Err(StoreError::Write);
            }
            (link.kept, link.lent) = (key, None);
        }
        if link.key().is_none() && change.is_none() {
            return Ok(LinkRecord::default());
        }
        link.count += 1;
        let content = state.content.clone();
        match state.write(content, Ok(link)) {
            Err(error) if change.is_some() => Err(error),
            kept => Ok(LinkRecord { key: link.key(), count: kept.ok().map(|()| link.count) }),
        }
    }
}

impl FlashState {
    fn write(
        &mut self,
        content: Option<String>,
        link: Result<LinkLine, StoreError>,
    ) -> Result<(), StoreError> {
        if self.write_protected {
            return Err(StoreError::Write);
        }
        if let Some(path) = &self.file {
            let config = content.as_deref().map_or("", |text| text.trim_start_matches(HEADER));
            // A line that cannot be read is not written over by a configuration.
            let line = link?.line();
            // Another robot may have the same file: what it has saved is not written over.
            if read_bounded(path).ok() != self.known {
                return Err(StoreError::Write);
            }
            let text = format!("{HEADER}{line}{config}");
            write_whole(path, &text).map_err(|_| StoreError::Write)?;
            self.known = Some(text);
        }
        (self.content, self.link) = (content, link);
        Ok(())
    }
}

/// What the flash holds for the link.
#[derive(Clone, Copy, Default)]
struct LinkLine {
    count: u64,
    kept: Option<Key>,
    /// In its place, and never written.
    lent: Option<Key>,
}

impl LinkLine {
    const MARK: &str = "# link ";

    fn key(self) -> Option<Key> {
        self.lent.or(self.kept)
    }

    /// Takes the record out of a file.
    fn split(text: String) -> (Option<String>, Result<Self, StoreError>) {
        let Some((line, config)) = text
            .strip_prefix(HEADER)
            .and_then(|rest| rest.strip_prefix(Self::MARK))
            .and_then(|rest| rest.split_once('\n'))
        else {
            return (Some(text), Ok(Self::default()));
        };
        let content = (!config.is_empty()).then(|| format!("{HEADER}{config}"));
        (content, Self::read(line).ok_or(StoreError::UnknownKey))
    }

    fn read(line: &str) -> Option<Self> {
        let mut words = line.split(' ');
        let count = words.next()?.parse().ok()?;
        let kept = match words.next() {
            None => None,
            Some(key) => Some(Key::from_hex(key)?),
        };
        Some(Self { count, kept, lent: None })
    }

    fn line(self) -> String {
        match (self.count, self.kept) {
            (0, None) => String::new(),
            (count, None) => format!("{}{count}\n", Self::MARK),
            (count, Some(key)) => {
                let hex: String = key.expose().iter().map(|byte| format!("{byte:02x}")).collect();
                format!("{}{count} {hex}\n", Self::MARK)
            }
        }
    }
}

/// The first line of every flash file.
const HEADER: &str = "# The flash of a simulated robot.\n";

fn to_text(config: &Config) -> Option<String> {
    Some(format!("{HEADER}{}", toml::to_string(config).ok()?))
}

/// Writes a new file, syncs it and renames it: the file holds the old text or the new one, never a part.
///
/// What a killed process left beside it is removed first: it may be open to others.
fn write_whole(path: &Path, text: &str) -> std::io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".beeline-part");
    let beside = path.with_file_name(name);
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if text.contains(LinkLine::MARK) {
        // There may be a key in it.
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    match std::fs::remove_file(&beside) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut file = options.open(&beside)?;
    // Synced before the rename, so that the name never refers to missing data.
    let written = file.write_all(text.as_bytes()).and_then(|()| file.sync_all());
    let renamed = written.and_then(|()| std::fs::rename(&beside, path));
    renamed.inspect_err(|_| drop(std::fs::remove_file(&beside)))?;
    sync_folder(path);
    Ok(())
}

/// Makes the rename survive a power failure; outside Unix a folder cannot be opened. Whether that succeeds or not, the
/// file holds the new text: a robot that said "not saved" now would say what is not so.
fn sync_folder(path: &Path) {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(Ok(folder)) =
        cfg!(unix).then(|| std::fs::File::open(folder.unwrap_or(Path::new("."))))
    {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_robot_has_saved_in_the_same_file_is_not_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flash");
        let [first, second] = [(); 2].map(|()| Flash::new(Some(path.clone())).unwrap());
        let save = |flash: &Flash, text: &str| {
            let mut state = flash.0.borrow_mut();
            let link = state.link;
            state.write(Some(text.into()), link)
        };
        assert_eq!(save(&first, "name = \"a\"\n"), Ok(()));
        assert_eq!(save(&first, "name = \"b\"\n"), Ok(()));
        assert_eq!(save(&second, "name = \"c\"\n"), Err(StoreError::Write));
        let third = Flash::new(Some(path.clone())).unwrap();
        assert_eq!(save(&third, "name = \"d\"\n"), Ok(()));
        assert_eq!(save(&first, "name = \"e\"\n"), Err(StoreError::Write));
        assert!(std::fs::read_to_string(&path).unwrap().ends_with("name = \"d\"\n"));
    }
}
