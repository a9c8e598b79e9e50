//! Ctrl-C, or the system's request to end: the first asks the procedure to end in good order, a
//! second ends the program at once.
//!
//! How a procedure ends in good order is left to `host-link`.

use std::sync::{LazyLock, OnceLock};
use std::time::{Duration, Instant};

use host_link::Cancel;

use crate::dialogue;

static PRESSED: OnceLock<Instant> = OnceLock::new();
static CANCEL: LazyLock<Cancel> = LazyLock::new(Cancel::default);

/// A second signal within this time is the same one: shells and `timeout` send it to a process and
/// to its group.
const SAME: Duration = Duration::from_millis(500);

/// Starts to handle Ctrl-C. Without this, Ctrl-C ends the program at once.
pub fn listen() {
    // If there is a handler already, it stays.
    let cancel = CANCEL.clone();
    let _ = ctrlc::set_handler(move || {
        cancel.request();
        if PRESSED.get_or_init(Instant::now).elapsed() > SAME {
            eprintln!(
                "ended at once: the robot brakes by itself, as nobody renews its motion; the configuration in \
                 use may differ from the saved one (`beeline config restore`)"
            );
            std::process::exit(130);
        }
    });
}

/// The user's request to end, for procedures; of a command that a page runs, the page's.
pub fn cancel() -> Cancel {
    dialogue::current().map_or_else(|| CANCEL.clone(), |dialogue| dialogue.cancel().clone())
}

/// Whether the user has requested an end.
pub fn requested() -> bool {
    cancel().is_requested()
}

/// Who has ended the command, and how.
pub fn words() -> &'static str {
    match dialogue::current() {
        None => "stopped by Ctrl-C",
        Some(dialogue) if dialogue.cancel().is_requested() => "stopped on the page",
        Some(_) => "stopped, because the page was not in front, or its messages came late",
    }
}
