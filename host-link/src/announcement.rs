//! Where the owner of a serial port that is shared listens: told in a file of the user's own.

use std::io;
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// An owner that does not accept a connection within this time has ended.
const PATIENCE: Duration = Duration::from_millis(500);

/// An announcement, until this value is dropped.
pub struct Announcement(PathBuf);

impl Announcement {
    /// Announces that this serial port is reached at this address; `None` if the user has no folder for it.
    pub fn new(port: &str, address: &str) -> Option<Self> {
        let file = file_of(port)?;
        announce(&file, address).ok().map(|()| Self(file))
    }
}

impl Drop for Announcement {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A connection to the program that owns this serial port, if one does and shares it.
pub fn owner_of(port: &str) -> Option<TcpStream> {
    let address = std::fs::read_to_string(file_of(port)?).ok()?;
    // One that ended without taking its announcement back does not answer.
    let address = address.trim().strip_prefix("tcp:")?.parse().ok()?;
    TcpStream::connect_timeout(&address, PATIENCE).ok()
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

fn announce(file: &Path, address: &str) -> io::Result<()> {
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(file, address)
}
