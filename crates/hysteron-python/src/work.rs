//! Work with the interpreter released, on threads of this process, with progress reports and stopped by
//! Ctrl-C.

use std::ops::ControlFlow;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use hysteron_identify::{Event, IdentifyError, Stop, Watch};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::{Class, failed, raised};

/// Polling interval for Ctrl-C.
const LOOK: Duration = Duration::from_millis(40);

/// Threads of this process. A forked child has none of its parent's and gets its own.
fn pool(threads: Option<usize>) -> PyResult<Arc<ThreadPool>> {
    type Pools = Vec<(u32, usize, Arc<ThreadPool>)>;
    static POOLS: Mutex<Pools> = Mutex::new(Vec::new());
    let (process, threads) = (std::process::id(), threads.unwrap_or(0));
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((.., pool)) = pools.iter().find(|(of, count, _)| (*of, *count) == (process, threads)) {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = Arc::new(pool.map_err(|e| failed(Class::Identify, e))?);
    pools.push((process, threads, Arc::clone(&pool)));
    Ok(pool)
}

/// Runs short work.
pub fn run<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool(None)?;
    Ok(py.detach(|| pool.install(work)))
}

/// Last progress report.
struct LastProgress {
    stage: String,
    fraction: f64,
    cost: Option<f64>,
}

/// Runs work that may take long. `progress(stage, fraction, cost)` is called from this thread; an exception
/// in it, or a signal, stops the work, whose best so far is returned with the exception.
pub fn watched<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch<'_>) -> Result<T, IdentifyError> + Send,
) -> PyResult<(T, Option<PyErr>)> {
    let pool = pool(threads)?;
    let stop = Stop::new();
    let told: Mutex<Option<LastProgress>> = Mutex::new(None);
    let mut interruption = None;
    let result = std::thread::scope(|scope| {
        let (done, mut ended) = channel();
        let (stopped, told, pool) = (stop.clone(), &told, &pool);
        scope.spawn(move || {
            let tell = |event: &Event<'_>| {
                let event = LastProgress {
                    stage: event.stage.to_owned(),
                    fraction: event.fraction,
                    cost: event.cost,
                };
                *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(event);
                ControlFlow::Continue(())
            };
            let watch = Watch::new(tell).stopped_by(&stopped);
            // The receiver is gone only where this thread panicked.
            let _ = done.send(pool.install(|| work(&watch)));
        });
        loop {
            let ended = &mut ended;
            match py.detach(move || ended.recv_timeout(LOOK)) {
                Ok(result) => return Ok(result),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(failed(Class::Identify, "the work ended without a result"));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            if interruption.is_some() {
                continue;
            }
            let event = told.lock().unwrap_or_else(PoisonError::into_inner).take();
            let call = || match (progress, event) {
                (Some(progress), Some(LastProgress { stage, fraction, cost })) => {
                    progress.call1((stage, fraction, cost)).map(|_| ())
                }
                _ => Ok(()),
            };
            if let Err(e) = py.check_signals().and_then(|()| call()) {
                stop.request();
                interruption = Some(e);
            }
        }
    })?;
    match result {
        Ok(found) => Ok((found, interruption)),
        // Stopped before there was a result.
        Err(e) => Err(interruption.unwrap_or_else(|| raised(e))),
    }
}
