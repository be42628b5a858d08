//! Flags of `hysteron identify` as options of the library.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use hysteron_identify::{Choice, Demands, DynamicsChoice, FamilyChoice, Options};
use hysteron_model::dynamics::Creep;
use hysteron_optimize::Algorithm;

use super::Identify;
use super::arguments::OptimizerArg;
use crate::failure::Failure;

impl Identify {
    pub(super) fn options(&self) -> Result<Options, Failure> {
        Ok(Options {
            method: self.method,
            hysteresis: self.family()?,
            order: self.order,
            creep: self.creep()?,
            initial: self.initial,
            continued: self.continued,
            drift: self.drift,
            dynamics: self.dynamics.unwrap_or(DynamicsChoice::Auto),
            algorithm: self.algorithm()?,
            generations: self.generations.unwrap_or(Options::default().generations),
            seed: self.seed,
            threads: self.threads,
            degree: self.degree.0,
            n: self.n.map_or(Choice::Given(1.0), |n| n.0),
            delay_s: self.delay.0,
            demands: Demands { fixed: self.fix.clone(), bounded: self.bound.clone() },
            start: None,
            scheme: self.scheme.map_or(Choice::Auto, Choice::Given),
            inter_sample: self.inter_sample.map_or(Choice::Auto, |rule| rule.0),
            least_fit_percent: self.least_fit,
        })
    }

    fn family(&self) -> Result<FamilyChoice, Failure> {
        let count = self.elements.unwrap_or_default();
        let family = self.hysteresis.unwrap_or_default().with_elements(self.elements);
        family.map_err(|e| Failure::usage(format!("--elements {count}: {e}")))
    }

    fn creep(&self) -> Result<Creep, Failure> {
        let kind = self.creep.unwrap_or_default();
        self.creep_elements.map_or(Ok(kind), |elements| {
            let belongs = || Failure::usage("--creep-elements belongs to --creep kelvin-voigt");
            kind.with_elements(elements).ok_or_else(belongs)
        })
    }

    fn algorithm(&self) -> Result<Option<Algorithm>, Failure> {
        if self.optimizer == OptimizerArg::Auto {
            return Ok(None);
        }
        let name = self.optimizer.to_possible_value();
        let name = name.as_ref().map_or("", PossibleValue::get_name);
        Algorithm::called(name, self.population).map(Some).map_err(|e| Failure::usage(e.to_string()))
    }
}
