//! `beeline watch` on the whole screen of a pseudo-terminal.

use std::io::{Read, Write};
use std::num::NonZero;
use std::os::fd::OwnedFd;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serialport::{SerialPort, TTYPort};

use super::TCP;
use crate::outcome::wait_for;
use crate::served::{Served, signal};
use crate::temp_folder::TempFolder;

/// A program on a terminal of its own.
struct OnTerminal {
    child: Child,
    outer: TTYPort,
    /// Held, so that the terminal lives as long as the test.
    inner: TTYPort,
    /// What a person sees.
    seen: vt100::Parser,
    bytes: Vec<u8>,
    settings: String,
}

impl OnTerminal {
    fn start(robot: &Served<'_>, temp: &TempFolder, options: &str, colours: bool) -> Self {
        let (mut outer, inner) = TTYPort::pair().unwrap();
        outer.set_timeout(Duration::from_millis(20)).unwrap();
        let name = inner.name().unwrap();
        stty(&name, &["sane", "cols", "80", "rows", "24"]);
        let line = format!("watch --port {} {options}", robot.port());
        let beeline = temp.command(&line.split_whitespace().collect::<Vec<_>>());
        let open = || -> OwnedFd {
            std::fs::OpenOptions::new().read(true).write(true).open(&name).unwrap().into()
        };
        // A terminal tells those that it controls when its size changes.
        let mut command = Command::new("setsid");
        command.args(["--ctty", "--wait"]).arg(beeline.get_program()).args(beeline.get_args());
        let set = beeline.get_envs().filter_map(|(name, value)| Some((name, value?)));
        command.envs(set).env("TERM", "xterm-256color").env_remove("NO_COLOR");
        if !colours {
            command.env("NO_COLOR", "1");
        }
        let settings = stty(&name, &["-a"]);
        let child = command
            .stdin(Stdio::from(open()))
            .stdout(Stdio::from(open()))
            .stderr(Stdio::from(open()))
            .spawn()
            .unwrap();
        let seen = vt100::Parser::new(size(24), size(80), 0);
        Self { child, outer, inner, seen, bytes: Vec::new(), settings }
    }

    fn press(&mut self, keys: &str) {
        self.outer.write_all(keys.as_bytes()).unwrap();
    }

    fn resize(&mut self, columns: u16, rows: u16) {
        let [columns_, rows_] = [columns, rows].map(|size| size.to_string());
        stty(&self.inner.name().unwrap(), &["cols", &columns_, "rows", &rows_]);
        self.seen.screen_mut().set_size(size(rows), size(columns));
    }

    fn is_taken(&self) -> bool {
        self.seen.screen().alternate_screen()
    }

    fn read(&mut self) {
        let mut buffer = [0; 65_536];
        if let Ok(length) = self.outer.read(&mut buffer) {
            self.seen.process(&buffer[..length]);
            self.bytes.extend_from_slice(&buffer[..length]);
        }
    }

    /// Waits until these words are on the screen, and returns all of it.
    fn wait_for(&mut self, words: &str) -> String {
        wait_for(words, || {
            self.read();
            let seen = self.seen.screen().contents();
            seen.contains(words).then_some(seen)
        })
    }

    /// Waits for the end: the terminal must be as it was. Returns the exit code and what is left to be seen.
    fn ended(mut self) -> (Option<i32>, String) {
        let status = wait_for("the end", || {
            self.read();
            self.child.try_wait().unwrap()
        });
        (0..3).for_each(|_| self.read());
        assert!(!self.is_taken() && !self.seen.screen().hide_cursor());
        // But for its size, in the first line.
        let settings = stty(&self.inner.name().unwrap(), &["-a"]);
        assert_eq!(settings.split_once('\n').unwrap().1, self.settings.split_once('\n').unwrap().1);
        (status.code(), self.seen.screen().contents())
    }
}

fn size(cells: u16) -> NonZero<u16> {
    NonZero::new(cells).unwrap()
}

fn stty(terminal: &str, what: &[&str]) -> String {
    let output = Command::new("stty").args(["-F", terminal]).args(what).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_whole_screen_shows_the_robot_stops_it_pauses_and_is_given_back() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let mut screen = OnTerminal::start(&robot, &temp, "", true);
    let seen = screen.wait_for("driven by nobody");
    assert!(screen.is_taken(), "{seen}");
    for words in ["IDLE: motors off", "left wheel", "right wheel", "q  quit"] {
        screen.wait_for(words);
    }
    screen.wait_for("telemetry: 50 a second");
    // Another host drives.
    let mut driver = robot.spawn("drive straight 8rev");
    screen.wait_for("driven by another host");
    screen.wait_for("DRIVING");
    // Telemetry that another host asked for instead is not lost.
    let seen = screen.wait_for("driven by another host");
    assert!(seen.contains(" 0 frames lost"), "{seen}");
    screen.press("p");
    screen.wait_for("PAUSED");
    screen.press("p");
    screen.press("s");
    println!("{}", screen.wait_for("FAULTED: motors off"));
    assert!(!driver.wait().unwrap().success(), "whoever watches may stop");
    screen.wait_for("what to do:");
    assert!(robot.identify()["status"]["fault"]["fault"].as_str().unwrap().contains("stop"));
    // Drawn anew for the narrower screen: what happened has no room beside the path.
    screen.wait_for("what happened");
    screen.resize(60, 30);
    let narrow = wait_for("the narrow screen", || {
        screen.read();
        let seen = screen.seen.screen().contents();
        (!seen.contains("what happened") && seen.contains("right wheel")).then_some(seen)
    });
    println!("{narrow}");
    for words in ["FAULTED", "what to do:", "duty", "path:", "q  quit"] {
        screen.wait_for(words);
    }
    screen.press("q");
    assert_eq!(screen.ended().0, Some(0));
}

#[test]
fn a_terminal_is_given_back_after_ctrl_c_a_signal_the_time_and_a_lost_link() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    for (options, end) in [("", "ctrl-c"), ("", "signal"), ("--for 500ms", "time")] {
        let mut screen = OnTerminal::start(&robot, &temp, options, false);
        screen.wait_for("driven by nobody");
        let bytes = String::from_utf8_lossy(&screen.bytes);
        assert!(
            !bytes.contains("\x1b[38;") && !bytes.contains("\x1b[48;"),
            "no colours: {bytes:?}"
        );
        match end {
            "ctrl-c" => screen.press("\x03"),
            "signal" => {
                let id = wait_for("its child", || child_of(screen.child.id()));
                signal(id, "TERM");
            }
            _ => {}
        }
        assert_eq!(screen.ended().0, Some(0), "{end}");
    }
    let mut screen = OnTerminal::start(&robot, &temp, "", true);
    screen.wait_for("driven by nobody");
    drop(robot);
    let (code, after) = screen.ended();
    assert_eq!(code, Some(2));
    assert!(after.contains("error:"), "{after:?}");
}

/// The process that `setsid` waits for.
fn child_of(id: u32) -> Option<u32> {
    let children = std::fs::read_to_string(format!("/proc/{id}/task/{id}/children")).ok()?;
    match children.split_whitespace().next() {
        Some(child) => child.parse().ok(),
        // It has become the program itself.
        None => Some(id),
    }
}

#[test]
fn lines_are_printed_where_they_are_asked_for_even_on_a_terminal() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    for (options, words) in [("--plain", "L mm/s"), ("--columns time,left-counts", "L counts")] {
        let options = format!("{options} --for 300ms");
        let mut screen = OnTerminal::start(&robot, &temp, &options, true);
        let shown = screen.wait_for(words);
        assert!(!screen.is_taken(), "{shown}");
        wait_for("the end", || {
            screen.read();
            screen.child.try_wait().unwrap()
        });
    }
    let lines = robot.run("watch --for 300ms").ok().stdout;
    assert!(lines.lines().count() > 2, "{lines}");
    assert!(lines.lines().all(|line| line.chars().count() < 80), "{lines}");
    let counts = robot.run("watch --columns time,left-counts --for 300ms").ok().stdout;
    assert_eq!(counts.lines().next().unwrap().split_whitespace().count(), 4, "{counts}");
    assert_eq!(counts.lines().nth(1).unwrap().split_whitespace().count(), 2, "{counts}");
    let refused = robot.run("watch --columns speed").refused();
    assert!(refused.contains("left-speed"), "{refused}");
}
