//! Ranges of the options of an identification.

use hysteron_model::dynamics::{Creep, MOST_CREEP_ELEMENTS, MOST_INTEGER_POLES};

use super::IdentifyError;
use super::options::{Choice, DynamicsChoice, HIGHEST_DEGREE, Options};

/// Most generations of a search.
const MOST_GENERATIONS: usize = 10_000_000;
/// Most threads of a fit.
const MOST_THREADS: usize = 1024;

impl Options {
    /// Whether every option is in its range.
    ///
    /// # Errors
    /// [`IdentifyError::Option`] names the first one that is not.
    pub fn validate(&self) -> Result<(), IdentifyError> {
        let refuse = |option, value, wanted| Err(IdentifyError::Option { option, value, wanted });
        if let Choice::Given(degree) = self.degree
            && !(1..=HIGHEST_DEGREE).contains(&degree)
        {
            return refuse("degree", degree as f64, "a whole number from 1 to 9");
        }
        if !(1..=MOST_INTEGER_POLES).contains(&self.order) {
            return refuse("order", self.order as f64, "a whole number from 1 to 12");
        }
        if self.dynamics == DynamicsChoice::Modes && self.order < 2 {
            return refuse("order", self.order as f64, "for modes a whole number from 2 to 12");
        }
        if let Creep::KelvinVoigt { elements } = self.creep
            && !(1..=MOST_CREEP_ELEMENTS).contains(&elements)
        {
            return refuse("creep elements", elements as f64, "a whole number from 1 to 4");
        }
        if let Choice::Given(n) = self.n
            && !(1.0..=10.0).contains(&n)
        {
            return refuse("n", n, "1 ≤ n ≤ 10");
        }
        if let Choice::Given(delay) = self.delay_s
            && !(0.0..=10.0).contains(&delay)
        {
            return refuse("delay", delay, "0 to 10 seconds");
        }
        if self.least_fit_percent.is_nan() || self.least_fit_percent > 100.0 {
            return refuse("least fit", self.least_fit_percent, "at most 100 %");
        }
        if self.generations == 0 || self.generations > MOST_GENERATIONS {
            return refuse("generations", self.generations as f64, "a whole number from 1 to 10000000");
        }
        if let Some(threads) = self.threads
            && !(1..=MOST_THREADS).contains(&threads)
        {
            return refuse("threads", threads as f64, "a whole number from 1 to 1024");
        }
        Ok(())
    }
}
