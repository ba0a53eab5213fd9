//! Long computations that do not check for signals, such as decompositions of large matrices.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

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
    let (value, raised) = run_to_check(py, Duration::ZERO, work)?;
    raised.map(|()| value)
}

/// The same for work that checks often. After an interruption its result is awaited for so long, and returned
/// with the exception; another Ctrl-C ends the wait.
pub(super) fn run_to_check<T: Send + 'static>(
    py: Python<'_>,
    patience: Duration,
    work: impl FnOnce(&Abandoned) -> T + Send + 'static,
) -> PyResult<(T, PyResult<()>)> {
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
    let mut raised: Option<(PyErr, Instant)> = None;
    loop {
        let received;
        (receiver, received) = py.detach(move || {
            let received = receiver.recv_timeout(INTERVAL);
            (receiver, received)
        });
        match received {
            Ok(value) => return Ok((value, raised.map_or(Ok(()), |(error, _)| Err(error)))),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(error) = py.check_signals() {
                    abandoned.0.store(true, Ordering::Relaxed);
                    if raised.is_some() {
                        return Err(error);
                    }
                    raised = Some((error, Instant::now()));
                }
                if let Some((error, _)) = raised.take_if(|(_, since)| since.elapsed() >= patience) {
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
