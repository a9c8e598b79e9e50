//! A request to end a procedure in good order.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Asks the procedures of a session to end in good order: the robot is left standing still.
///
/// Clones share one request. It can be made on any thread, and in a signal handler.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Makes the request.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the request was made.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
