//! For how long a motion goes on by itself, and who keeps it alive from moment to moment.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// What the host wants is void after this long, and a motion that is not renewed ends.
pub const LEASE: Duration = Duration::from_millis(200);

/// Signs of life of somebody without whom no motion goes on: no lease ends later than a [`LEASE`] after the last of them.
///
/// Clones share them. They are given on any thread.
#[derive(Clone, Debug)]
pub struct Holder {
    begun: Instant,
    /// Since `begun` \[us\].
    last_us: Arc<AtomicU64>,
}

impl Default for Holder {
    /// Its making is the first sign.
    fn default() -> Self {
        Self { begun: Instant::now(), last_us: Arc::default() }
    }
}

impl Holder {
    /// A sign of life.
    pub fn beat(&self) {
        self.last_us.fetch_max(self.begun.elapsed().as_micros() as u64, Ordering::Relaxed);
    }

    /// What is left of the lease that began with the last sign.
    pub fn left(&self) -> Duration {
        let last = Duration::from_micros(self.last_us.load(Ordering::Relaxed));
        LEASE.saturating_sub(self.begun.elapsed().saturating_sub(last))
    }

    /// Whether there has been no sign for a lease.
    pub fn is_gone(&self) -> bool {
        self.left().is_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_falls_from_each_sign_on_and_ends() {
        let holder = Holder::default();
        assert!(holder.left() <= LEASE);
        std::thread::sleep(LEASE);
        assert!(holder.is_gone());
        holder.clone().beat();
        let left = holder.left();
        assert!(!left.is_zero() && left <= LEASE, "{left:?}");
    }
}
