//! Long computations that do not check for signals themselves, such as decompositions of large matrices.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::error::Interrupted;

/// Models of fewer coordinates are done within the time that a user waits for Ctrl-C.
pub(super) const LARGE: usize = 200;

/// Whether whoever waited for a computation has gone.
#[derive(Clone, Debug, Default)]
pub(super) struct Abandoned(Arc<AtomicBool>);

impl Abandoned {
    /// Stops a computation that nobody waits for.
    pub(super) fn check(&self) -> Result<(), Interrupted> {
        if self.0.load(Ordering::Relaxed) { Err(Interrupted) } else { Ok(()) }
    }
}

/// What `work` returns, which runs in a thread of its own so that this one hears Ctrl-C. Then `work` is left alone:
/// it ends when it next asks whether it is abandoned, or else when it is done, and what it returns is dropped.
pub(super) fn run<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Abandoned) -> T + Send + 'static,
) -> PyResult<T> {
    /// Not noticed by a user who waits.
    const INTERVAL: Duration = Duration::from_millis(50);
    /// As much as the main thread has.
    const STACK: usize = 8 << 20;
    let abandoned = Abandoned::default();
    let (sender, mut receiver) = sync_channel(1);
    let of_thread = abandoned.clone();
    let thread = thread::Builder::new().stack_size(STACK).spawn(move || {
        // Nobody may be there any more to receive it.
        _ = sender.send(work(&of_thread));
    })?;
    loop {
        let received;
        (receiver, received) = py.detach(move || {
            let received = receiver.recv_timeout(INTERVAL);
            (receiver, received)
        });
        match received {
            Ok(value) => return Ok(value),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(error) = py.check_signals() {
                    abandoned.0.store(true, Ordering::Relaxed);
                    return Err(error);
                }
            }
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => resume_unwind(panic),
                Ok(()) => unreachable!("a thread that does not panic sends its result"),
            },
        }
    }
}
