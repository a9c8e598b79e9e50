//! Ctrl-C, or the request of the system to end: asks a procedure to end in good order; the second one
//! ends the program at once.

use std::sync::atomic::{AtomicU8, Ordering};

static PRESSED: AtomicU8 = AtomicU8::new(0);

/// Starts to listen. Without this, Ctrl-C ends the program at once.
pub fn listen() {
    // If there is a handler already, that one is in charge.
    let _ = ctrlc::set_handler(|| {
        if PRESSED.fetch_add(1, Ordering::Relaxed) > 0 {
            std::process::exit(130);
        }
    });
}

/// Whether the user wants this to end.
pub fn requested() -> bool {
    PRESSED.load(Ordering::Relaxed) > 0
}
