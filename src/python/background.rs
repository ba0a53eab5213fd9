//! Long computations that do not check for signals, such as decompositions of large matrices.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::error::Interrupted;

/// Models with fewer coordinates finish before a user would miss a response to Ctrl-C.
pub(super) const LARGE: usize = 200;

/// Whether the caller of a computation has stopped waiting.
#[derive(Clone, Debug, Default)]
pub(super) struct Abandoned(Arc<AtomicBool>);

impl Abandoned {
    /// Stops an abandoned computation.
    pub(super) fn check(&self) -> Result<(), Interrupted> {
        if self.0.load(Ordering::Relaxed) { Err(Interrupted) } else { Ok(()) }
    }
}

/// Runs `work` in a separate thread and returns its result, so that this thread can respond to Ctrl-C. After
/// an interruption `work` is abandoned: it ends at its next check, or when it is done, and its result is
/// dropped.
pub(super) fn run<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Abandoned) -> T + Send + 'static,
) -> PyResult<T> {
    /// Too short for a waiting user to notice.
    const INTERVAL: Duration = Duration::from_millis(50);
    /// Stack size of the main thread.
    const STACK: usize = 8 << 20;
    let abandoned = Abandoned::default();
    let (sender, mut receiver) = sync_channel(1);
    let of_thread = abandoned.clone();
    let thread = thread::Builder::new().stack_size(STACK).spawn(move || {
        // The receiver may be gone.
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
