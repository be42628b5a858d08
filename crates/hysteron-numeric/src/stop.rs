//! The request that a run ends, from another thread.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Asks work to end soon, from any thread; its clones ask the same work.
///
/// Running work checks it before every evaluation of a model, and within the long ones.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<Request>);

#[derive(Debug, Default)]
struct Request {
    made: AtomicBool,
    countdown: Option<Countdown>,
    also: Option<Also>,
}

/// Another stop, and a condition, each of which makes the request.
struct Also {
    stop: Stop,
    is_over: Box<dyn Fn() -> bool + Send + Sync>,
}

impl fmt::Debug for Also {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Also").field("stop", &self.stop).finish_non_exhaustive()
    }
}

/// Checks until the request is made.
#[derive(Debug)]
struct Countdown {
    after: usize,
    checks: AtomicUsize,
}

impl Stop {
    /// Not requested yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Requests itself at the check after `checks` of them: an interruption that a test can repeat.
    pub fn after(checks: usize) -> Self {
        let countdown = Countdown { after: checks, checks: AtomicUsize::new(0) };
        Self(Arc::new(Request { countdown: Some(countdown), ..Request::default() }))
    }

    /// Requested when this one is, or once `is_over`: a time limit.
    #[must_use]
    pub fn or(&self, is_over: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        let also = Also { stop: self.clone(), is_over: Box::new(is_over) };
        Self(Arc::new(Request { also: Some(also), ..Request::default() }))
    }

    /// Requests the stop; it cannot be taken back.
    pub fn request(&self) {
        self.0.made.store(true, Ordering::Relaxed);
    }

    /// Whether the stop is requested.
    pub fn is_requested(&self) -> bool {
        if let Some(Countdown { after, checks }) = &self.0.countdown
            && checks.fetch_add(1, Ordering::Relaxed) >= *after
        {
            self.request();
        }
        if let Some(Also { stop, is_over }) = &self.0.also
            && (stop.is_requested() || is_over())
        {
            self.request();
        }
        self.0.made.load(Ordering::Relaxed)
    }

    /// Checks so far of a stop that counts them ([`Self::after`]); 0 for any other.
    pub fn checks(&self) -> usize {
        self.0.countdown.as_ref().map_or(0, |countdown| countdown.checks.load(Ordering::Relaxed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limited_stop_is_requested_by_its_limit_or_by_the_other_which_it_leaves_alone() {
        let whole = Stop::new();
        let over = Stop::new();
        let [by_limit, by_other] =
            [over.clone(), Stop::new()].map(|over| whole.or(move || over.is_requested()));
        assert!(!by_limit.is_requested() && !by_other.is_requested());
        over.request();
        assert!(by_limit.is_requested() && !by_other.is_requested() && !whole.is_requested());
        whole.request();
        assert!(by_other.is_requested());
    }

    #[test]
    fn a_stop_is_requested_for_every_clone_or_after_so_many_checks() {
        let stop = Stop::new();
        let clone = stop.clone();
        assert!(!clone.is_requested() && clone.checks() == 0);
        stop.request();
        assert!(clone.is_requested());
        let third = Stop::after(2);
        assert_eq!([(); 4].map(|()| third.clone().is_requested()), [false, false, true, true]);
        assert_eq!(third.checks(), 4);
    }
}
