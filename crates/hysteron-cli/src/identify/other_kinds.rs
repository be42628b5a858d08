//! Flags of oscillators, of modes and of branches as options of the library.

use hysteron_identify::oscillator::Options;
use hysteron_identify::{Choice, FamilyChoice, Initial, Method, Task, coupled, force};
use hysteron_model::record::InterSample;

use super::Identify;
use super::arguments::{ChoiceArg, OptimizerArg};
use crate::failure::Failure;

impl Identify {
    pub(super) fn oscillator(&self) -> Result<Task, Failure> {
        self.refuse_flags_but(
            "oscillator",
            "an oscillator has --initial, --n, --fix (mass, damping, n), --inter-sample, --start",
            &[],
        )?;
        self.oscillator_options().map(Task::Oscillator)
    }

    pub(super) fn force(&self) -> Result<Task, Failure> {
        self.refuse_flags_but(
            "force",
            "a force has --hysteresis, --elements, --degree, --n, --fix",
            &[
                ("--inter-sample", self.inter_sample.is_some()),
                ("--start", self.start.is_some()),
                ("--initial", self.initial != Initial::Auto),
                ("--n free", matches!(self.n, Some(ChoiceArg(Choice::Auto)))),
            ],
        )?;
        let hysteresis = match self.hysteresis {
            Some(FamilyChoice::Given(form)) => Some(match self.elements {
                Some(count) => form
                    .with_elements(count)
                    .map_err(|e| Failure::usage("these --elements cannot be had").because(e))?,
                None => form,
            }),
            Some(FamilyChoice::Auto | FamilyChoice::Usual) => {
                return Err(Failure::usage("--hysteresis auto does not go with --structure force")
                    .hint("name a family, or leave it out"));
            }
            None if self.elements.is_some() => {
                return Err(Failure::usage("--elements needs --hysteresis with --structure force"));
            }
            None => None,
        };
        let mut fixed = self.fix.clone();
        if let Some(ChoiceArg(Choice::Given(n))) = self.n {
            fixed.push(("n".to_owned(), n));
        }
        Ok(Task::Force(force::Options {
            hysteresis,
            degree: match self.degree.0 {
                Choice::Auto => 1,
                Choice::Given(degree) => degree,
            },
            fixed,
            rate_window_s: None,
            least_fit_percent: self.least_fit,
        }))
    }

    pub(super) fn branches(&self) -> Result<Task, Failure> {
        if let Some(flag) = self.modes.given() {
            return Err(Failure::usage(format!("{flag} goes with --structure modes")));
        }
        self.refuse_flags_but(
            "hammerstein and several axes",
            "each of these branches is u − z, dz/du = α − β s z − γ |z|, with a pair of poles and a delay",
            &[
                ("--inter-sample", self.inter_sample.is_some()),
                ("--start", self.start.is_some()),
                ("--fix", !self.fix.is_empty()),
                ("--n", self.n.is_some()),
                ("--initial", self.initial != Initial::Auto),
            ],
        )?;
        Ok(Task::Branches(coupled::Options { least_fit_percent: self.least_fit }))
    }

    pub(super) fn modes(&self) -> Result<Task, Failure> {
        self.refuse_flags_but(
            "modes",
            "modes have --modes, --plays, --linear, --steps, --iterations, --exponent, --ridge, --initial \
             periodic",
            &[
                ("--inter-sample", self.inter_sample.is_some()),
                ("--start", self.start.is_some()),
                ("--fix", !self.fix.is_empty()),
                ("--n", self.n.is_some()),
            ],
        )?;
        let whole_records = match self.initial {
            Initial::Auto => false,
            Initial::Periodic => true,
            _ => {
                return Err(Failure::usage("modes are identified from a steady state")
                    .hint("leave out --initial, or give --initial periodic"));
            }
        };
        Ok(Task::Modes(self.modes.options(whole_records, self.least_fit)))
    }

    /// Refuses flags of the Hammerstein model with another structure, instead of silently ignoring them.
    fn refuse_flags_but(
        &self,
        structure: &str,
        own: &str,
        further: &[(&'static str, bool)],
    ) -> Result<(), Failure> {
        let given = [
            ("--static", !self.static_records.is_empty()),
            ("--dynamic", !self.dynamic_records.is_empty()),
            ("--dynamics", self.dynamics.is_some()),
            ("--method", self.method != Method::Joint),
            ("--order", self.order != 2),
            ("--creep", self.creep.is_some() || self.creep_elements.is_some()),
            ("--continued", self.continued),
            ("--drift", self.drift),
            ("--optimizer", self.optimizer != OptimizerArg::Auto),
            ("--generations", self.generations.is_some()),
            ("--population", self.population.is_some()),
            ("--delay", !matches!(self.delay.0, Choice::Auto)),
            ("--bound", !self.bound.is_empty()),
            ("--scheme", self.scheme.is_some()),
            ("--figures", self.figures.is_some()),
        ];
        let of_force =
            [("--elements", self.elements.is_some()), ("--degree", !matches!(self.degree.0, Choice::Auto))];
        let of_force = of_force.iter().filter(|_| structure != "force");
        match given.iter().chain(of_force).chain(further).find(|(_, given)| *given) {
            None => Ok(()),
            Some((flag, _)) => {
                Err(Failure::usage(format!("{flag} does not go with --structure {structure}"))
                    .hint(format!("leave it out; {own}")))
            }
        }
    }

    fn oscillator_options(&self) -> Result<Options, Failure> {
        let mut fixed = self.fix.clone();
        if let Some(Choice::Given(n)) = self.n.map(|n| n.0) {
            fixed.push(("n".to_owned(), n));
        }
        Ok(Options {
            initial: self.initial,
            inter_sample: match self.inter_sample.map(|rule| rule.0) {
                Some(Choice::Given(rule)) => rule,
                _ => InterSample::BandLimited,
            },
            fixed,
            start: None,
            steps: None,
            least_fit_percent: self.least_fit,
        })
    }
}
