//! Runs are independent of each other: as many at a time as the machine has cores.

use std::thread;

/// The results of a function of each item, in the items' order.
pub(crate) fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = thread::available_parallelism().map_or(1, usize::from).min(items.len().max(1));
    if threads == 1 {
        return items.iter().map(work).collect();
    }
    let work = &work;
    let mut results: Vec<Option<R>> = items.iter().map(|_| None).collect();
    thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|first| {
                scope.spawn(move || {
                    let mine = items.iter().enumerate().skip(first).step_by(threads);
                    mine.map(|(index, item)| (index, work(item))).collect::<Vec<_>>()
                })
            })
            .collect();
        for worker in workers {
            match worker.join() {
                Ok(done) => done.into_iter().for_each(|(index, it)| results[index] = Some(it)),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
    });
    results.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn results_come_in_the_order_of_the_items() {
        let items: Vec<u32> = (0..100).collect();
        let doubled: Vec<u32> = items.iter().map(|it| 2 * it).collect();
        assert_eq!(super::map(&items, |it| 2 * it), doubled);
        assert!(super::map(&[0_u8; 0], |it| *it).is_empty());
    }
}
