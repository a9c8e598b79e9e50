//! A function of each simulated robot, on all cores.
//!
//! Plain threads and no work stealing: a simulator's clock belongs to its thread, and a thread that waits for a fit
//! must not begin another robot meanwhile.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The results of a function of each item, in the items' order; each thread takes the next free item.
pub fn in_order<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<R>>> = items.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let index = next.fetch_add(1, Ordering::Relaxed)
                    && let Some(item) = items.get(index)
                {
                    let result = work(item);
                    *results[index].lock().expect("no thread panicked") = Some(result);
                }
            });
        }
    });
    let done = results.into_iter().map(|slot| slot.into_inner().expect("no thread panicked"));
    done.map(|result| result.expect("every item was worked on")).collect()
}
