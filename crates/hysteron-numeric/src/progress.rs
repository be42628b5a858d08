//! Progress of a long computation, told to a listener that may stop it.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Receives the stage of a computation and the share done, 0 to 1, from any thread;
/// [`ControlFlow::Break`] stops the computation.
pub type Tell<'a> = dyn Fn(&str, f64) -> ControlFlow<()> + Sync + 'a;

/// A computation that ended early because its listener asked for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

/// Listener of a computation, or of the part of it from one share of the work to another.
#[derive(Clone, Copy)]
pub struct Listener<'a> {
    tell: Option<&'a Tell<'a>>,
    from: f64,
    to: f64,
}

impl fmt::Debug for Listener<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Listener").field("from", &self.from).field("to", &self.to).finish_non_exhaustive()
    }
}

impl<'a> Listener<'a> {
    /// Nobody listens and nobody stops.
    pub fn silent() -> Self {
        Self { tell: None, from: 0.0, to: 1.0 }
    }

    /// Tells `tell`.
    pub fn new(tell: &'a Tell<'a>) -> Self {
        Self { tell: Some(tell), ..Self::silent() }
    }

    /// Listener of the part of this work from the share `from` to the share `to`.
    #[must_use]
    pub fn part(self, from: f64, to: f64) -> Self {
        let at = |share: f64| self.from + (self.to - self.from) * share;
        Self { from: at(from), to: at(to), ..self }
    }

    /// Tells the stage and the share of the work done.
    ///
    /// # Errors
    /// [`Stopped`] where the listener ends the computation.
    pub fn tell(&self, stage: &str, share: f64) -> Result<(), Stopped> {
        let Some(tell) = self.tell else { return Ok(()) };
        match tell(stage, self.from + (self.to - self.from) * share.clamp(0.0, 1.0)) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Stopped),
        }
    }

    /// Counts the samples of a stage of `total` samples.
    pub fn meter(self, stage: &'a str, total: usize) -> Meter<'a> {
        Meter { listener: self, stage, total: total.max(1), done: AtomicUsize::new(0) }
    }
}

/// Counts the samples of a stage, from any thread.
pub struct Meter<'a> {
    listener: Listener<'a>,
    stage: &'a str,
    total: usize,
    done: AtomicUsize,
}

impl Meter<'_> {
    /// Samples between two reports of a loop over samples: a millisecond or so.
    pub const STRIDE: usize = 1024;

    /// Counts for nobody.
    pub fn silent() -> Self {
        Listener::silent().meter("", 1)
    }

    /// Counts `samples` more and tells the share done.
    ///
    /// # Errors
    /// [`Stopped`] where the listener ends the computation.
    pub fn add(&self, samples: usize) -> Result<(), Stopped> {
        let done = self.done.fetch_add(samples, Ordering::Relaxed) + samples;
        self.listener.tell(self.stage, done as f64 / self.total as f64)
    }

    /// [`Self::add`] of a whole stride at the last sample of each.
    ///
    /// # Errors
    /// [`Stopped`].
    #[inline]
    pub fn at_sample(&self, index: usize) -> Result<(), Stopped> {
        if index % Self::STRIDE == Self::STRIDE - 1 { self.add(Self::STRIDE) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn a_part_and_its_meter_tell_the_share_of_the_whole() {
        let told = Mutex::new(Vec::new());
        let tell = |stage: &str, share: f64| {
            told.lock().unwrap().push((stage.to_owned(), share));
            ControlFlow::Continue(())
        };
        let half = Listener::new(&tell).part(0.5, 1.0);
        half.tell("begins", 0.0).unwrap();
        let meter = half.part(0.0, 0.5).meter("counts", 2 * Meter::STRIDE);
        for index in 0..2 * Meter::STRIDE {
            meter.at_sample(index).unwrap();
        }
        let expected = [("begins", 0.5), ("counts", 0.625), ("counts", 0.75)];
        assert_eq!(*told.lock().unwrap(), expected.map(|(stage, share)| (stage.to_owned(), share)));
    }

    #[test]
    fn a_listener_stops_the_work_and_nobody_does_not() {
        let tell = |_: &str, share: f64| {
            if share > 0.5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let meter = Listener::new(&tell).meter("stage", 4);
        assert_eq!([(); 3].map(|()| meter.add(1)), [Ok(()), Ok(()), Err(Stopped)]);
        assert_eq!(Meter::silent().add(1_000_000), Ok(()));
    }
}
