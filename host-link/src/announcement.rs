//! Where the owner of a serial port that is shared listens: told in a file of the user's own.
//!
//! The owner holds a lock beside that file for as long as it lives. An announcement without one is of a program that was
//! killed, and whoever listens at that address by now is somebody else.

use std::fs::{self, File, TryLockError};
use std::io;
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// An owner that does not accept a connection within this time has ended.
const PATIENCE: Duration = Duration::from_millis(500);

/// An announcement, until this value is dropped.
pub struct Announcement {
    file: PathBuf,
    /// Locked until this process ends, however it does.
    _lock: File,
}

impl Announcement {
    /// Announces that this serial port is reached at this address; `None` if the user has no folder for it.
    pub fn new(port: &str, address: &str) -> Option<Self> {
        Self::at(file_of(port)?, address).ok()
    }

    fn at(file: PathBuf, address: &str) -> io::Result<Self> {
        if let Some(folder) = file.parent() {
            fs::create_dir_all(folder)?;
        }
        let lock = File::options().create(true).append(true).open(lock_of(&file))?;
        // Whoever asks holds it for an instant.
        let mut tries = 10;
        while let Err(TryLockError::WouldBlock) = lock.try_lock() {
            tries -= 1;
            if tries == 0 {
                return Err(io::ErrorKind::AlreadyExists.into());
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        // Over what a killed owner left; that of one who lives is not touched.
        fs::write(&file, address)?;
        Ok(Self { file, _lock: lock })
    }
}

impl Drop for Announcement {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.file);
    }
}

/// A connection to the program that owns this serial port, if one does and shares it.
pub fn owner_of(port: &str) -> Option<TcpStream> {
    TcpStream::connect_timeout(&announced(&file_of(port)?)?, PATIENCE).ok()
}

/// The address in an announcement whose owner lives. On a file system without locks, a connection has to show that.
fn announced(file: &Path) -> Option<SocketAddr> {
    // Nobody holds it: the owner has ended without taking its announcement back.
    if File::open(lock_of(file)).ok()?.try_lock_shared().is_ok() {
        return None;
    }
    fs::read_to_string(file).ok()?.trim().strip_prefix("tcp:")?.parse().ok()
}

/// Beside the announcement, as some systems let nobody read what is locked.
fn lock_of(file: &Path) -> PathBuf {
    file.with_extension("lock")
}

/// In a folder that is this user's alone.
fn file_of(port: &str) -> Option<PathBuf> {
    let folder = ["XDG_RUNTIME_DIR", "LOCALAPPDATA"].iter().find_map(std::env::var_os);
    let folder = match folder {
        Some(folder) => PathBuf::from(folder),
        None => Path::new(&std::env::var_os("HOME")?).join(".cache"),
    };
    // Links such as those in /dev/serial/by-id lead to the same device.
    let device = std::fs::canonicalize(port).unwrap_or_else(|_| PathBuf::from(port));
    let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let name: String = device.to_string_lossy().chars().map(letter).collect();
    Some(folder.join("beeline").join(format!("port{name}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_announcement_is_believed_while_its_owner_lives_and_no_longer() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("beeline/port-dev-ttyACM0");
        assert_eq!(announced(&file), None);
        let owner = Announcement::at(file.clone(), "tcp:127.0.0.1:7700").unwrap();
        assert_eq!(announced(&file), Some(([127, 0, 0, 1], 7700).into()));
        assert_eq!(announced(&file), Some(([127, 0, 0, 1], 7700).into()), "asking takes no lock");
        assert!(Announcement::at(file.clone(), "tcp:127.0.0.1:7702").is_err(), "it has an owner");
        assert_eq!(announced(&file), Some(([127, 0, 0, 1], 7700).into()), "who stays announced");
        drop(owner);
        assert_eq!(announced(&file), None);
        assert!(!file.exists());
        // Killed: the file stays, the lock does not. Another program may have that address by now.
        fs::write(&file, "tcp:127.0.0.1:7700").unwrap();
        assert_eq!(announced(&file), None);
        let next = Announcement::at(file.clone(), "tcp:127.0.0.1:7701").unwrap();
        assert_eq!(announced(&file), Some(([127, 0, 0, 1], 7701).into()));
        drop(next);
        assert_eq!(announced(&file), None);
    }
}
