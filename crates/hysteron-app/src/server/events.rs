//! Events to a page, as a stream of server-sent events.

use std::convert::Infallible;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::response::Sse;
use axum::response::sse::{Event, KeepAlive};
use futures_util::future::{Either, select};
use futures_util::stream::{Stream, unfold};
use tokio::sync::broadcast::error::RecvError;

use super::Shared;
use crate::notice::{Change, Notice};

/// Time after which a silent stream shows that it lives.
const ALIVE: Duration = Duration::from_secs(15);

/// The coming events, until the page leaves or the program ends.
pub(super) async fn events(
    State(shared): State<Arc<Shared>>,
) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let coming = (shared.workspace.notices.listen(), shared.closing.clone());
    let stream = unfold(coming, |(mut notices, mut closing)| async {
        let next = {
            let ends = pin!(closing.wait_for(|closing| *closing));
            match select(pin!(notices.recv()), ends).await {
                Either::Left((next, _)) => next,
                Either::Right(_) => return None,
            }
        };
        let event = match next {
            Ok(notice) => event(&notice),
            // The page asks for everything again.
            Err(RecvError::Lagged(_)) => Event::default().event("lagged").data("{}"),
            Err(RecvError::Closed) => return None,
        };
        Some((Ok(event), (notices, closing)))
    });
    Sse::new(stream).keep_alive(KeepAlive::new().interval(ALIVE))
}

fn event(notice: &Notice) -> Event {
    let (name, data) = match notice {
        Notice::Changed(change, data) => {
            let name = match change {
                Change::Records => "records",
                Change::Models => "models",
                Change::Reports => "reports",
            };
            (name, serde_json::to_string(data))
        }
        Notice::Job(job) => ("job", serde_json::to_string(job)),
        Notice::Live(update) => ("live", serde_json::to_string(update)),
        Notice::Progress(progress) => ("progress", serde_json::to_string(progress)),
    };
    Event::default().event(name).data(data.unwrap_or_default())
}
