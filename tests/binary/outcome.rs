//! How a run of the program ended, and its output.

use std::io::Read;
use std::process::Child;
use std::time::{Duration, Instant};

use serde_json::Value;

/// A guard against hanging: the longest command takes some seconds, on a busy machine a minute.
const PATIENCE: Duration = Duration::from_secs(120);

/// How a run of the program ended, and its output.
#[derive(Debug)]
pub struct Outcome {
    /// Exit code; `None` if a signal ended it.
    pub code: Option<i32>,
    /// Standard output: the result.
    pub stdout: String,
    /// Standard error: everything else.
    pub stderr: String,
}

impl Outcome {
    /// Requires success.
    #[track_caller]
    pub fn ok(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:#?}");
        self
    }

    /// Requires exactly one JSON value on standard output.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {self:#?}"))
    }

    /// Requires a refusal: exit code 2, no result, one error and a hint. Returns both lines.
    #[track_caller]
    pub fn refused(&self) -> String {
        assert_eq!(self.code, Some(2), "{self:#?}");
        assert_eq!(self.stdout, "", "{self:#?}");
        let errors = self.stderr.lines().filter(|line| line.starts_with("error: ")).count();
        assert_eq!(errors, 1, "{self:#?}");
        let hint = |line: &str| line.starts_with("  try: ") || line.contains("try '--help'");
        assert_eq!(self.stderr.lines().filter(|line| hint(line)).count(), 1, "{self:#?}");
        assert!(!self.stderr.contains("panicked"), "{self:#?}");
        self.stderr.clone()
    }
}

/// Reads the output of a child until it ends.
#[track_caller]
pub fn collect(mut child: Child) -> Outcome {
    let stdout = in_background(child.stdout.take());
    let stderr = in_background(child.stderr.take());
    let give_up = Instant::now() + PATIENCE;
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child can be waited for") {
            break status;
        }
        if Instant::now() > give_up {
            let _ = child.kill();
            let _ = child.wait();
            panic!("still running after {PATIENCE:?}: {:?}", (stdout.join(), stderr.join()));
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    Outcome { code: status.code(), stdout: stdout.join().unwrap(), stderr: stderr.join().unwrap() }
}

/// Polls until there is a value.
#[track_caller]
pub fn wait_for<T>(what: &str, mut poll: impl FnMut() -> Option<T>) -> T {
    let give_up = Instant::now() + PATIENCE;
    loop {
        if let Some(found) = poll() {
            return found;
        }
        assert!(Instant::now() < give_up, "waited {PATIENCE:?} for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn in_background(stream: Option<impl Read + Send + 'static>) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut stream) = stream {
            let _ = stream.read_to_end(&mut bytes);
        }
        String::from_utf8(bytes).expect("the program writes UTF-8")
    })
}
