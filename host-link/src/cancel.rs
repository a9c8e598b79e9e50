//! A request to end in good order.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Asks the procedures of a session to end in good order: the robot is left standing still.
///
/// Clones are the same request. It may be made on any thread, and in a signal handler.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Makes the request.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was made.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
