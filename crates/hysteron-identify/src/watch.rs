//! Progress reports of long computations, and their cancellation.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use hysteron_model::Model;
use hysteron_optimize::Stop;

use crate::compared::CandidateSummary;
use crate::searches::{ModesComparisonCheckpoint, Searches};
use crate::structure::ComparisonCheckpoint;

/// Progress report of running work.
#[derive(Clone, Copy)]
pub struct Event<'a> {
    /// Current stage.
    pub stage: &'a str,
    /// Share of the whole work done, 0 to 1, by the usual duration of its stages; it never decreases.
    pub fraction: f64,
    /// Best cost so far: RMSE in the unit of the output, in a joint fit weighted.
    pub cost: Option<f64>,
    state: State<'a>,
}

/// State available on request in an event; computed only then.
#[derive(Clone, Copy, Default)]
pub(crate) struct State<'a> {
    pub model: Option<&'a dyn Fn() -> Option<Model>>,
    pub searches: Option<&'a dyn Fn() -> Searches>,
    pub candidates: Option<&'a dyn Fn() -> Vec<CandidateSummary>>,
}

impl<'a> Event<'a> {
    /// Event of work without intermediate models.
    pub fn new(stage: &'a str, fraction: f64, cost: Option<f64>) -> Self {
        Self { stage, fraction, cost: cost.filter(|cost| cost.is_finite()), state: State::default() }
    }

    pub(crate) fn with(self, state: State<'a>) -> Self {
        Self { state, ..self }
    }

    /// The best model so far, where there is one yet.
    pub fn model(&self) -> Option<Model> {
        self.state.model.and_then(|model| model())
    }

    /// State to resume from, to be saved from time to time; `None` where the work cannot be resumed.
    pub fn searches(&self) -> Option<Searches> {
        self.state.searches.map(|searches| searches())
    }

    /// The candidates of a comparison that are finished, in the order of their error; `None` where none has
    /// finished since the last event.
    pub fn candidates(&self) -> Option<Vec<CandidateSummary>> {
        self.state.candidates.map(|candidates| candidates())
    }

    /// Estimated time left after `elapsed`; `None` at the beginning.
    pub fn time_left(&self, elapsed: Duration) -> Option<Duration> {
        (self.fraction > 0.0)
            .then(|| elapsed.as_secs_f64() * (1.0 - self.fraction) / self.fraction)
            .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
    }
}

type Told<'a> = dyn FnMut(&Event<'_>) -> ControlFlow<()> + Send + 'a;

/// Listener and stop signal of a computation. The listener, by [`ControlFlow::Break`], or any holder of the
/// [`Stop`] can stop it; the best result so far is kept.
pub struct Watch<'a> {
    told: Option<Mutex<Box<Told<'a>>>>,
    stop: Stop,
    furthest: Mutex<f64>,
    /// The stop signal without the time limit, where there is one.
    unlimited: Option<Stop>,
}

impl Default for Watch<'_> {
    fn default() -> Self {
        Self::silent()
    }
}

impl<'a> Watch<'a> {
    /// A watch without a listener.
    pub fn silent() -> Self {
        Self { told: None, stop: Stop::new(), furthest: Mutex::new(0.0), unlimited: None }
    }

    /// Reports events to `told`, from one thread at a time.
    pub fn new(told: impl FnMut(&Event<'_>) -> ControlFlow<()> + Send + 'a) -> Self {
        Self { told: Some(Mutex::new(Box::new(told))), ..Self::silent() }
    }

    /// This watch with `stop` as its stop signal.
    #[must_use]
    pub fn stopped_by(self, stop: &Stop) -> Self {
        Self { stop: stop.clone(), ..self }
    }

    /// A watch that reports to this one and is stopped with it, or at the `limit` by the clock `now`.
    pub fn within(&self, limit: Duration, now: impl Fn() -> Duration + Send + Sync + 'static) -> Watch<'_> {
        let now = Arc::new(now);
        let stop = self.stop.or({
            let now = Arc::clone(&now);
            move || now() >= limit
        });
        let told = move |event: &Event<'_>| {
            let of_time = now().as_secs_f64() / limit.as_secs_f64();
            self.tell(Event { fraction: event.fraction.max(of_time), ..*event })
        };
        let unlimited = Some(self.unlimited.as_ref().unwrap_or(&self.stop).clone());
        Watch { unlimited, ..Watch::new(told).stopped_by(&stop) }
    }

    /// A watch that reports the candidates of a comparison to this one as stages named after `stage`, and keeps
    /// the state at the end of each.
    pub(crate) fn keeping_comparison<'s>(
        &'s self,
        stage: &'s str,
        kept: &'s Mutex<Option<Box<ComparisonCheckpoint>>>,
    ) -> Watch<'s> {
        let told = move |event: &Event<'_>| {
            if event.state.candidates.is_some()
                && let Some(comparison) = event.searches().and_then(|searches| searches.comparison)
            {
                *kept.lock().unwrap_or_else(PoisonError::into_inner) = Some(comparison);
            }
            self.tell(Event { stage: &format!("{stage}: {}", event.stage), ..*event })
        };
        Watch { unlimited: self.unlimited.clone(), ..Watch::new(told).stopped_by(&self.stop) }
    }

    /// A watch that reports to this one, with a finished comparison in every state to resume from.
    pub(crate) fn with_comparison<'s>(&'s self, comparison: Option<&'s ComparisonCheckpoint>) -> Watch<'s> {
        let told = move |event: &Event<'_>| {
            let comparison = || comparison.map(|comparison| Box::new(comparison.clone()));
            let searches = || Searches { comparison: comparison(), ..event.searches().unwrap_or_default() };
            let searches: Option<&dyn Fn() -> Searches> = Some(&searches);
            let state =
                State { searches: searches.filter(|_| event.state.searches.is_some()), ..event.state };
            self.tell(Event { state, ..*event })
        };
        Watch { unlimited: self.unlimited.clone(), ..Watch::new(told).stopped_by(&self.stop) }
    }

    /// A watch that reports to this one, with the finished fits of a comparison of modes in every state to
    /// resume from.
    pub(crate) fn with_fits<'s>(&'s self, fits: &'s ModesComparisonCheckpoint) -> Watch<'s> {
        let told = move |event: &Event<'_>| {
            let modes_comparison = || Some(Box::new(fits.clone()));
            let searches =
                || Searches { modes_comparison: modes_comparison(), ..event.searches().unwrap_or_default() };
            let state = State { searches: Some(&searches), ..event.state };
            self.tell(Event { state, ..*event })
        };
        Watch { unlimited: self.unlimited.clone(), ..Watch::new(told).stopped_by(&self.stop) }
    }

    /// A watch that reports to this one, as the part of the whole work from share `from` to share `to`, and is
    /// stopped with it.
    pub(crate) fn part(&self, from: f64, to: f64) -> Watch<'_> {
        let told = move |event: &Event<'_>| {
            self.tell(Event { fraction: from + (to - from) * event.fraction, ..*event })
        };
        Watch { unlimited: self.unlimited.clone(), ..Watch::new(told).stopped_by(&self.stop) }
    }

    /// This watch as the listener of a computation that has no costs or models to report
    /// ([`hysteron_numeric::Listener::new`]).
    pub fn teller(&self) -> impl Fn(&str, f64) -> ControlFlow<()> + Sync + use<'_, 'a> {
        |stage, fraction| self.tell(Event::new(stage, fraction, None))
    }

    /// True if a stop is requested, other than by a time limit ([`Self::within`]).
    pub fn is_interrupted(&self) -> bool {
        self.unlimited.as_ref().unwrap_or(&self.stop).is_requested()
    }

    /// The stop signal.
    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    /// True if a stop is requested.
    pub fn is_stopped(&self) -> bool {
        self.stop.is_requested()
    }

    /// Reports progress. Threads report in any order; the reported fraction never decreases.
    pub fn tell(&self, event: Event<'_>) -> ControlFlow<()> {
        if let Some(told) = &self.told {
            let fraction = {
                let mut furthest = self.furthest.lock().unwrap_or_else(PoisonError::into_inner);
                *furthest = furthest.max(event.fraction.clamp(0.0, 1.0));
                *furthest
            };
            let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
            if told(&Event { fraction, ..event }).is_break() {
                self.stop.request();
            }
        }
        if self.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Stages of work in their order, each with the share of the time that it usually takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan(pub &'static [(&'static str, f64)]);

impl Plan {
    /// Names of the stages in their order.
    pub(crate) fn names(self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|(name, _)| *name)
    }

    /// Share of the whole work done when the share `within` of a stage is; `None` for a stage that is not in
    /// the plan. A stage is matched by the beginning of its name.
    pub(crate) fn fraction(&self, stage: &str, within: f64) -> Option<f64> {
        let whole: f64 = self.0.iter().map(|(_, share)| share).sum();
        let begins = |(name, _): &&(&str, f64)| stage.starts_with(name);
        let longest = self.0.iter().filter(begins).max_by_key(|(name, _)| name.len())?;
        let before: f64 =
            self.0.iter().take_while(|(name, _)| *name != longest.0).map(|(_, share)| share).sum();
        Some((before + longest.1 * within.clamp(0.0, 1.0)) / whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fraction_is_of_the_whole_work_and_never_falls() {
        let plan = Plan(&[("starts", 1.0), ("joint fit", 2.0), ("joint fit, others", 1.0)]);
        assert_eq!(plan.fraction("joint fit", 0.5), Some(0.5));
        assert_eq!(plan.fraction("joint fit, others", 0.0), Some(0.75));
        assert_eq!(plan.fraction("elsewhere", 0.5), None);
        let mut told = Vec::new();
        let watch = Watch::new(|event: &Event<'_>| {
            told.push(event.fraction);
            ControlFlow::Continue(())
        });
        for fraction in [0.1, 0.5, 0.3, 2.0] {
            assert!(watch.tell(Event::new("stage", fraction, None)).is_continue());
        }
        drop(watch);
        assert_eq!(told, [0.1, 0.5, 0.5, 1.0]);
    }

    #[test]
    fn a_part_reports_its_share_and_stops_with_the_whole() {
        let mut told = Vec::new();
        let watch = Watch::new(|event: &Event<'_>| {
            told.push(event.fraction);
            ControlFlow::Continue(())
        });
        for (from, to) in [(0.0, 0.6), (0.6, 1.0)] {
            let part = watch.part(from, to);
            for fraction in [0.0, 0.5, 1.0] {
                assert!(part.tell(Event::new("stage", fraction, None)).is_continue());
            }
        }
        watch.stop().request();
        assert!(watch.part(0.6, 1.0).is_stopped());
        drop(watch);
        assert_eq!(told, [0.0, 0.3, 0.6, 0.6, 0.8, 1.0]);
    }

    #[test]
    fn either_side_stops() {
        let watch = Watch::new(|_: &Event<'_>| ControlFlow::Break(()));
        assert!(watch.tell(Event::new("stage", 0.1, None)).is_break() && watch.is_stopped());
        let stop = Stop::new();
        let watch = Watch::silent().stopped_by(&stop);
        assert!(!watch.is_stopped());
        stop.request();
        assert!(watch.tell(Event::new("stage", 0.1, None)).is_break());
    }

    #[test]
    fn time_left_follows_from_the_time_taken() {
        let event = Event::new("stage", 0.25, Some(f64::NAN));
        assert_eq!(event.cost, None);
        assert_eq!(event.time_left(Duration::from_secs(10)), Some(Duration::from_secs(30)));
        assert_eq!(Event::new("stage", 0.0, None).time_left(Duration::from_secs(10)), None);
    }
}
