//! Computations that answer a request: the pages hear how far one is, and it ends with its request.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use hysteron_identify::{Event, Listener, Stop};

use super::Shared;
use super::answer::run;
use crate::api::RequestProgress;
use crate::notice::Notice;
use crate::refused::{Answer, Refused};

/// Header by which a page names a request, to know its progress among the events.
const HEADER: &str = "x-request";
/// Longest such name.
const LONGEST: usize = 64;
/// Time between two events.
const BETWEEN: Duration = Duration::from_millis(150);

/// The name of a request; `None`: nobody waits for its progress.
pub(super) struct Named(Option<String>);

impl<S: Send + Sync> FromRequestParts<S> for Named {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        let name = parts.headers.get(HEADER).and_then(|name| name.to_str().ok());
        Ok(Self(name.filter(|name| name.len() <= LONGEST).map(str::to_owned)))
    }
}

/// Stops the computation of a request that is dropped: its client has gone.
struct Ends(Stop);

impl Drop for Ends {
    fn drop(&mut self) {
        self.0.request();
    }
}

/// Runs a computation beside the server, tells the pages its progress, and ends it where the client closes
/// the connection before the answer.
///
/// # Errors
/// Those of the computation.
pub(super) async fn run_told<T: Send + 'static>(
    shared: Arc<Shared>,
    Named(request): Named,
    work: impl FnOnce(&Shared, Listener<'_>) -> Answer<T> + Send + 'static,
) -> Answer<T> {
    let stop = Stop::new();
    let _ends = Ends(stop.clone());
    run(move || {
        let begun = Instant::now();
        let last: Mutex<Option<Instant>> = Mutex::new(None);
        let tell = |stage: &str, fraction: f64| {
            if stop.is_requested() {
                return ControlFlow::Break(());
            }
            let Some(request) = &request else { return ControlFlow::Continue(()) };
            let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
            if last.is_none_or(|last| last.elapsed() >= BETWEEN) {
                *last = Some(Instant::now());
                let left = Event::new(stage, fraction, None).time_left(begun.elapsed());
                shared.workspace.notices.send(Notice::Progress(RequestProgress {
                    request: request.clone(),
                    stage: stage.to_owned(),
                    fraction,
                    left_s: left.map(|left| left.as_secs_f64()),
                }));
            }
            ControlFlow::Continue(())
        };
        let answer = work(&shared, Listener::new(&tell));
        // What a stop leaves unfinished may fail in any way.
        answer.map_err(|e| if stop.is_requested() { Refused::bad("it was stopped") } else { e })
    })
    .await
}
