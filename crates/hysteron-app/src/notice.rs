//! Events to the pages.

use std::sync::atomic::{AtomicU64, Ordering};

use tokio::sync::broadcast;

use crate::api::{Changed, Job, LiveUpdate, RequestProgress};

/// Events that a slow page may lag behind; beyond it, it misses some and asks again.
const BACKLOG: usize = 64;

/// A list that changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// The records.
    Records,
    /// The models.
    Models,
    /// The reports.
    Reports,
}

/// An event.
#[derive(Clone, Debug)]
pub(crate) enum Notice {
    /// A list changed.
    Changed(Change, Changed),
    /// A job changed.
    Job(Box<Job>),
    /// A running fit.
    Live(Box<LiveUpdate>),
    /// A computation that answers a request.
    Progress(RequestProgress),
}

/// Sender of events and the number of the last change.
pub(crate) struct Notices {
    sender: broadcast::Sender<Notice>,
    change: AtomicU64,
}

impl Default for Notices {
    fn default() -> Self {
        Self { sender: broadcast::Sender::new(BACKLOG), change: AtomicU64::new(0) }
    }
}

impl Notices {
    /// The coming events.
    pub(crate) fn listen(&self) -> broadcast::Receiver<Notice> {
        self.sender.subscribe()
    }

    /// True if a page listens.
    pub(crate) fn is_heard(&self) -> bool {
        self.sender.receiver_count() > 0
    }

    /// Number of the last change.
    pub(crate) fn last_change(&self) -> u64 {
        self.change.load(Ordering::Relaxed)
    }

    /// Tells that a list has changed.
    pub(crate) fn changed(&self, what: Change) {
        let change = self.change.fetch_add(1, Ordering::Relaxed) + 1;
        self.send(Notice::Changed(what, Changed { change }));
    }

    /// Sends an event; without a page it is lost, as the pages ask for the state when they open.
    pub(crate) fn send(&self, notice: Notice) {
        let _ = self.sender.send(notice);
    }
}
