//! A robot on a virtual clock in real time, behind TCP or a pseudo-terminal.
//!
//! The virtual clock follows the world's. Any program that can talk to a serial port can talk to it.
//! [`serve`] does it for the simulator; whoever has another robot uses [`Server`] in a loop of its own.

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use sim_target::{HostWire, Lab, SimTarget};

use crate::cli::Listen;
use crate::error::{Context, Error, Result};
use crate::interrupt;
use crate::ui::note;

/// The simulation catches up with the world this often.
const STEP: Duration = Duration::from_millis(1);

/// What to do besides serving.
#[derive(Clone, Debug, Default)]
pub struct ServeOptions<'a> {
    /// Write the camera's samples to this new file.
    pub camera: Option<&'a Path>,
    /// Put the robot back at its line when a client connects and it stands still.
    pub reset_on_connect: bool,
    /// Stop after this long.
    pub duration: Option<Duration>,
}

/// Serves until Ctrl-C. `listening` is told the port by which to reach the robot.
pub fn serve(
    target: &mut SimTarget,
    listen: &Listen,
    options: &ServeOptions<'_>,
    listening: impl FnOnce(&str),
) -> Result<()> {
    let mut server = Server::open(listen, options, target.host_wire(), target.lab())?;
    listening(server.address());
    let start = Instant::now();
    let start_us = sim_target::now_us();
    while !interrupt::requested() && options.duration.is_none_or(|end| start.elapsed() < end) {
        server.exchange()?;
        target.run_until_us(start_us + start.elapsed().as_micros() as u64);
        server.exchange()?;
        std::thread::sleep(STEP);
    }
    server.close()
}

/// Whether nobody would notice the robot being picked up.
fn stands_still(lab: &Lab) -> bool {
    /// A thousandth of the paper's cruise: what a wheel at rest creeps by \[rad/s\].
    const STILL_RAD_S: f64 = 0.003;
    lab.plant(|plant| {
        let turns = plant.wheel_speeds_rad_s().any(|speed| speed.abs() > STILL_RAD_S);
        let driven = plant.currents_a().any(|current_a| current_a != 0.0);
        !turns && !driven
    })
}

/// One robot behind a port. Whoever has it calls [`exchange`](Self::exchange) every millisecond.
pub struct Server {
    line: Line,
    camera: Option<CameraFile>,
    reset_on_connect: bool,
    wire: HostWire,
    lab: Lab,
}

impl Server {
    /// Opens the port.
    pub fn open(
        listen: &Listen,
        options: &ServeOptions<'_>,
        wire: HostWire,
        lab: Lab,
    ) -> Result<Self> {
        if options.reset_on_connect && *listen == Listen::Pty {
            return Err(Error::new(
                "--reset-on-connect does nothing on a pseudo-terminal: nobody sees a client come",
            )
            .hint("--listen tcp:127.0.0.1:0"));
        }
        let line = Line::open(listen)?;
        let camera = options.camera.map(|path| CameraFile::open(path, lab.clone())).transpose()?;
        Ok(Self { line, camera, reset_on_connect: options.reset_on_connect, wire, lab })
    }

    /// The port by which to reach the robot.
    pub fn address(&self) -> &str {
        &self.line.address
    }

    /// Hands over what client and robot have said since.
    pub fn exchange(&mut self) -> Result<()> {
        if self.line.accept() {
            note("a client connected");
            if self.reset_on_connect {
                if stands_still(&self.lab) {
                    self.lab.place_at_start();
                } else {
                    note("the robot moves, and stays where it is");
                }
            }
        }
        let mut buffer = [0; 1024];
        let len = self.line.read(&mut buffer);
        if len > 0 {
            self.wire.write_now(&buffer[..len]);
        }
        self.line.forward(&self.wire);
        match &mut self.camera {
            Some(camera) => camera.append(),
            None => Ok(()),
        }
    }

    /// Puts what the camera has seen on the disk, and closes the port.
    pub fn close(self) -> Result<()> {
        match self.camera {
            Some(CameraFile { file, path, .. }) => file.sync_all().context(path.display()),
            None => Ok(()),
        }
    }
}

/// One client at a time, as on a cable.
struct Line {
    address: String,
    end: End,
}

enum End {
    Tcp {
        listener: TcpListener,
        client: Option<TcpStream>,
    },
    #[cfg(unix)]
    Pty {
        master: serialport::TTYPort,
        // Held open, so that the terminal outlives its clients.
        _slave: serialport::TTYPort,
    },
}

impl Line {
    fn open(listen: &Listen) -> Result<Self> {
        match listen {
            Listen::Tcp(address) => {
                let listener = TcpListener::bind(address).map_err(|error| {
                    Error::new(format_args!("cannot listen on tcp:{address}: {error}"))
                        .hint("port 0 takes any that is free: --listen tcp:127.0.0.1:0")
                })?;
                listener.set_nonblocking(true).context("cannot listen")?;
                let address = listener.local_addr().context("cannot listen")?;
                Ok(Self {
                    address: format!("tcp:{address}"),
                    end: End::Tcp { listener, client: None },
                })
            }
            #[cfg(unix)]
            Listen::Pty => {
                use serialport::SerialPort;
                let (mut master, slave) =
                    serialport::TTYPort::pair().context("cannot open a pseudo-terminal")?;
                master.set_timeout(Duration::from_millis(1)).context("the pseudo-terminal")?;
                let address = slave.name().unwrap_or_default();
                Ok(Self { address, end: End::Pty { master, _slave: slave } })
            }
            #[cfg(not(unix))]
            Listen::Pty => {
                Err(Error::new("this system has no pseudo-terminals")
                    .hint("--listen tcp:127.0.0.1:0"))
            }
        }
    }

    /// Takes a new client, who replaces the one before. True if one came.
    fn accept(&mut self) -> bool {
        match &mut self.end {
            End::Tcp { listener, client } => match listener.accept() {
                Ok((stream, _)) => {
                    if stream.set_nonblocking(true).is_err() || stream.set_nodelay(true).is_err() {
                        return false;
                    }
                    *client = Some(stream);
                    true
                }
                Err(_) => false,
            },
            #[cfg(unix)]
            End::Pty { .. } => false,
        }
    }

    /// Bytes from the client, if there are any now.
    fn read(&mut self, buffer: &mut [u8]) -> usize {
        match &mut self.end {
            End::Tcp { client, .. } => {
                let Some(stream) = client else { return 0 };
                match stream.read(buffer) {
                    Ok(0) => {
                        *client = None;
                        note("the client went away");
                        0
                    }
                    Ok(len) => len,
                    Err(error) if error.kind() == ErrorKind::WouldBlock => 0,
                    Err(_) => {
                        *client = None;
                        note("the client went away");
                        0
                    }
                }
            }
            #[cfg(unix)]
            End::Pty { master, .. } => {
                use serialport::SerialPort;
                match master.bytes_to_read() {
                    Ok(0) | Err(_) => 0,
                    Ok(_) => master.read(buffer).unwrap_or(0),
                }
            }
        }
    }

    /// Whatever the robot has said goes to the client; without one, it is lost, as on a cable.
    fn forward(&mut self, wire: &HostWire) {
        let mut buffer = [0; 1024];
        loop {
            let len = wire.read_now(&mut buffer);
            if len == 0 {
                return;
            }
            match &mut self.end {
                End::Tcp { client, .. } => {
                    if let Some(stream) = client
                        && write_all_patiently(stream, &buffer[..len]).is_err()
                    {
                        *client = None;
                    }
                }
                #[cfg(unix)]
                End::Pty { master, .. } => {
                    // A full terminal buffer: nobody reads.
                    let _ = master.write_all(&buffer[..len]);
                }
            }
        }
    }
}

/// Writes to a socket that does not block; gives up on a client that does not read for a second.
fn write_all_patiently(stream: &mut TcpStream, mut bytes: &[u8]) -> std::io::Result<()> {
    let give_up = Instant::now() + Duration::from_secs(1);
    while !bytes.is_empty() {
        match stream.write(bytes) {
            Ok(len) => bytes = &bytes[len..],
            Err(error) if error.kind() == ErrorKind::WouldBlock && Instant::now() < give_up => {
                std::thread::sleep(STEP);
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// The camera's samples as a growing track file.
struct CameraFile {
    file: File,
    path: PathBuf,
    lab: Lab,
    written: usize,
}

impl CameraFile {
    fn open(path: &Path, lab: Lab) -> Result<Self> {
        let mut file = File::create_new(path).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => Error::new(format_args!("{} exists", path.display()))
                .hint("--camera FILE makes a new track: name another one, or move this one away"),
            _ => Error::new(format_args!("cannot write {}: {error}", path.display()))
                .hint("--camera names the track file to write"),
        })?;
        writeln!(file, "t_s,x_m,y_m,heading_rad").context(path.display())?;
        Ok(Self { file, path: path.into(), lab, written: 0 })
    }

    fn append(&mut self) -> Result<()> {
        if self.lab.camera_len() == self.written {
            return Ok(());
        }
        let samples = self.lab.camera_samples_from(self.written);
        self.written += samples.len();
        let lines: String = samples
            .iter()
            .map(|s| format!("{:.6},{:.7},{:.7},{:.7}\n", s.t_s, s.x_m, s.y_m, s.heading_rad))
            .collect();
        self.file.write_all(lines.as_bytes()).map_err(|error| {
            Error::new(format_args!("cannot write {}: {error}", self.path.display()))
                .hint("the camera's track goes there: is its disk full?")
        })
    }
}
