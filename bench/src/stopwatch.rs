//! Wall-clock time of repetitions.

use std::time::Instant;

use crate::allocations;

/// Times of the repetitions of a piece of work.
#[derive(Debug)]
pub struct Timing {
    /// Wall-clock time of each repetition \[s\].
    pub seconds: Vec<f64>,
    /// Allocations of all repetitions together.
    pub allocations: usize,
}

/// Does `work` so many times.
pub fn time<E>(repetitions: usize, mut work: impl FnMut() -> Result<(), E>) -> Result<Timing, E> {
    let mut seconds = Vec::with_capacity(repetitions);
    let before = allocations::count();
    for _ in 0..repetitions {
        let start = Instant::now();
        work()?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    Ok(Timing { seconds, allocations: allocations::count() - before })
}
