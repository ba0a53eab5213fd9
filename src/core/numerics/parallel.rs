//! Work shared by threads.
//!
//! [`for_each`] distributes items over threads that end with the call. If the work on an item touches no
//! other item, the results do not depend on the number of threads.
//!
//! ```
//! let mut numbers: Vec<u64> = (0..1000).collect();
//! lissom::parallel::for_each(&mut numbers, 2, |n, _| { *n *= *n; Ok(()) }, &mut || Ok(()))?;
//! assert_eq!(numbers[31], 961);
//! # Ok::<(), lissom::error::Interrupted>(())
//! ```

use std::num::NonZero;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use crate::error::Interrupted;

/// A thread takes this fraction of its share of the remaining items: large pieces first, which need few
/// locks, and small pieces at the end, so that no thread idles (guided self-scheduling; Polychronopoulos and
/// Kuck 1987).
const SHARE_OF_REST: usize = 8;

/// Interval between calls of `watch`, too short for a waiting user to notice.
const INTERVAL: Duration = Duration::from_millis(50);

/// Number of processors available to this process.
pub fn processors() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

/// Calls `work` on every item in `workers` threads, which end with this call. The assignment of items to
/// threads is not deterministic; the results must not depend on it.
///
/// `watch` is called about twenty times a second. When it, or the work on an item, requests a stop, no
/// further item is started and the flag passed to `work` is set. This function returns once all threads have
/// ended.
pub fn for_each<T: Send>(
    items: &mut [T],
    workers: usize,
    work: impl Fn(&mut T, &AtomicBool) -> Result<(), Interrupted> + Sync,
    watch: &mut dyn FnMut() -> Result<(), Interrupted>,
) -> Result<(), Interrupted> {
    let workers = workers.min(items.len()).max(1);
    let queue = Mutex::new(items);
    let is_over = AtomicBool::new(false);
    // Carries no messages: the channel closes once the last worker has ended.
    let (working, is_working) = channel::<()>();
    thread::scope(|scope| {
        for _ in 0..workers {
            let _working = working.clone();
            let (queue, is_over, work) = (&queue, &is_over, &work);
            scope.spawn(move || {
                let _working = _working;
                loop {
                    let items = next_piece(queue, workers);
                    if items.is_empty() {
                        return;
                    }
                    for item in items {
                        if is_over.load(Ordering::Relaxed) {
                            return;
                        }
                        if work(item, is_over).is_err() {
                            is_over.store(true, Ordering::Relaxed);
                        }
                    }
                }
            });
        }
        drop(working);
        while is_working.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
            if watch().is_err() {
                is_over.store(true, Ordering::Relaxed);
            }
        }
    });
    if is_over.into_inner() { Err(Interrupted) } else { Ok(()) }
}

/// Takes the next items from the queue; returns an empty slice if none are left.
fn next_piece<'a, T>(queue: &Mutex<&'a mut [T]>, workers: usize) -> &'a mut [T] {
    let mut left = queue.lock().unwrap_or_else(PoisonError::into_inner);
    let rest = std::mem::take(&mut *left);
    let (piece, rest) = rest.split_at_mut(rest.len().div_ceil(workers * SHARE_OF_REST));
    *left = rest;
    piece
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;
    use std::time::Instant;

    fn never_interrupt() -> Result<(), Interrupted> {
        Ok(())
    }

    #[test]
    fn every_item_is_worked_on_once() {
        for count in [0, 1, 2, 7, 1000] {
            for workers in [0, 1, 2, 5, 2000] {
                let mut items: Vec<usize> = (0..count).collect();
                let work = |item: &mut usize, _: &AtomicBool| {
                    *item += 1;
                    Ok(())
                };
                for_each(&mut items, workers, work, &mut never_interrupt).unwrap();
                assert_eq!(items, (1..=count).collect::<Vec<_>>(), "{count} items, {workers} workers");
            }
        }
    }

    #[test]
    fn an_item_that_asks_for_an_end_leaves_those_not_begun() {
        let done = AtomicUsize::new(0);
        let work = |item: &mut usize, _: &AtomicBool| {
            done.fetch_add(1, Ordering::Relaxed);
            if *item == 3 { Err(Interrupted) } else { Ok(()) }
        };
        let mut items: Vec<usize> = (0..1000).collect();
        assert!(for_each(&mut items, 1, work, &mut never_interrupt).is_err());
        assert_eq!(done.into_inner(), 4);
    }

    #[test]
    fn who_watches_ends_long_work() {
        let begun = Instant::now();
        let work = |_: &mut usize, is_over: &AtomicBool| {
            while !is_over.load(Ordering::Relaxed) {
                thread::yield_now();
            }
            Err(Interrupted)
        };
        assert!(for_each(&mut [0, 1, 2], 2, work, &mut || Err(Interrupted)).is_err());
        assert!(begun.elapsed() < 20 * INTERVAL);
    }

    #[test]
    fn a_panic_comes_through() {
        let work = |item: &mut usize, _: &AtomicBool| {
            assert!(*item < 2, "the work on an item fails");
            Ok(())
        };
        let outcome = std::panic::catch_unwind(|| for_each(&mut [0, 1, 2, 3], 2, work, &mut never_interrupt));
        assert!(outcome.is_err());
    }
}
