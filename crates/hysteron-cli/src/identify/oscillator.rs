//! `hysteron identify --structure oscillator`: a mass on a hysteretic spring.

use hysteron_identify::Choice;
use hysteron_identify::oscillator::{
    Estimate, Identification, Initial, Options, OscillatorFitError, RecordFit, identify,
};
use hysteron_model::model::Score;
use hysteron_model::model_file::OscillatorFile;
use hysteron_model::record::InterSample;
use hysteron_report::number::with_std_error;
use serde_json::{Value, json};

use super::Identify;
use super::arguments::{InitialArg, InterSampleArg, MethodArg, OptimizerArg};
use crate::console;
use crate::failure::Failure;
use crate::maker::maker;
use crate::model::Loaded;
use crate::output;
use crate::scores;
use hysteron_report::identification::typographic;

const TITLE: &str = "no oscillator was identified";

impl Identify {
    pub(super) fn run_oscillator(&self) -> Result<(), Failure> {
        self.refuse_flags_but(
            "oscillator",
            "an oscillator has --initial, --n, --fix (mass, damping, n), --inter-sample, --start",
            &[],
        )?;
        output::check_file("the model", &self.out)?;
        let options = self.oscillator_options()?;
        let records = self.columns.read_all(&self.records)?;
        let found = self.in_threads(|| identify(&records, &options).map_err(|e| explain(&e)))??;
        let file = found.model_file(&options, &maker());
        let loaded = crate::model::write(&self.out, file.clone())?;
        if self.result.has_report() {
            let page = loaded.report(&found.findings)?;
            self.result.write(|| page)?;
        }
        if self.result.json {
            return console::json(&self.object(&found, &file));
        }
        console::result(&text(&found, &file))?;
        console::message(&format!("model written to {}", self.out.display()));
        Ok(())
    }

    /// Flags of the Hammerstein model mean nothing to another structure; what was asked for is not silently left out.
    pub(super) fn refuse_flags_but(
        &self,
        structure: &str,
        own: &str,
        further: &[(&'static str, bool)],
    ) -> Result<(), Failure> {
        let given = [
            ("--static", !self.static_records.is_empty()),
            ("--dynamic", !self.dynamic_records.is_empty()),
            ("--elements", self.elements.is_some()),
            ("--dynamics", self.dynamics.is_some()),
            ("--method", self.method != MethodArg::Joint),
            ("--order", self.order != 2),
            ("--creep", self.creep.is_some() || self.creep_elements.is_some()),
            ("--drift", self.drift),
            ("--optimizer", self.optimizer != OptimizerArg::Auto),
            ("--generations", self.generations.is_some()),
            ("--population", self.population.is_some()),
            ("--resume", self.resume.is_some()),
            ("--degree", !matches!(self.degree.0, Choice::Auto)),
            ("--delay", !matches!(self.delay.0, Choice::Auto)),
            ("--bound", !self.bound.is_empty()),
            ("--scheme", self.scheme.is_some()),
            ("--figures", self.figures.is_some()),
        ];
        match given.iter().chain(further).find(|(_, given)| *given) {
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
        let start = match &self.start {
            None => None,
            Some(path) => {
                let failure = || Failure::new(format!("cannot start from the model {}", path.display()));
                let loaded = Loaded::read(path)?;
                Some(*loaded.model().as_oscillator().map_err(|e| failure().because(e))?.law())
            }
        };
        Ok(Options {
            initial: match self.initial {
                InitialArg::Auto => Initial::Auto,
                InitialArg::Rest | InitialArg::Zero => Initial::Rest,
                InitialArg::Periodic => Initial::Periodic,
                InitialArg::Free => Initial::Free,
            },
            inter_sample: self.inter_sample.map_or(InterSample::BandLimited, InterSampleArg::into),
            fixed,
            start,
            steps: None,
            least_fit_percent: self.least_fit,
        })
    }

    /// Runs `work` on as many threads as asked for.
    pub(super) fn in_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
        let Some(threads) = self.threads else { return Ok(work()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map(|pool| pool.install(work))
            .map_err(|e| Failure::new(format!("cannot work on {threads} threads")).because(e))
    }

    /// The object of `--json`.
    fn object(&self, found: &Identification, file: &OscillatorFile) -> Value {
        let estimate = |e: &Estimate| {
            json!({
                "name": e.name,
                "value": e.value,
                "unit": unit_of(e, file),
                "std_error": e.std_error,
                "held": e.held,
                "at_limit": e.at_limit,
            })
        };
        json!({
            "model": self.out.display().to_string(),
            "structure": "oscillator",
            "records": scored(found),
            "parameters": found.estimates.iter().map(estimate).collect::<Vec<_>>(),
            "searches": found.shapes.iter().map(|s| ("shape", s)).chain([("output error", &found.search)])
                .map(|(step, s)| json!({"step": step, "cost": s.cost, "evaluations": s.evaluations}))
                .collect::<Vec<_>>(),
            "findings": found.findings,
        })
    }
}

fn scored(found: &Identification) -> Vec<Score> {
    found.records.iter().map(RecordFit::score).collect()
}

/// Unit of an estimate, as in the model file.
fn unit_of(estimate: &Estimate, file: &OscillatorFile) -> String {
    let names = hysteron_model::oscillator::Oscillator::NAMES;
    let parameter = names.iter().zip(file.parameters.all()).find(|(name, _)| **name == estimate.name);
    match (parameter, estimate.name) {
        (Some((_, quantity)), _) if quantity.unit == "1" => String::new(),
        (Some((_, quantity)), _) => quantity.unit.clone(),
        (None, "natural_frequency") => "Hz".to_owned(),
        (None, _) => String::new(),
    }
}

/// The result for people.
fn text(found: &Identification, file: &OscillatorFile) -> String {
    let mut table = console::table(&["parameter", "value", "std. error", "unit"]);
    for e in &found.estimates {
        let (value, error) = with_std_error(e.value, e.std_error);
        let error = match (e.held, e.std_error) {
            (true, _) => "held".to_owned(),
            (false, None) => "-".to_owned(),
            (false, Some(_)) => error,
        };
        table.add_row(vec![e.name.to_owned(), value, error, typographic(&unit_of(e, file))]);
    }
    let mut text = format!("{table}\n\n{}\n\n", scores::table(&scored(found)));
    for finding in &found.findings {
        text += &format!("{finding}\n");
    }
    for line in &found.treatment {
        text += &format!("data: {line}\n");
    }
    text
}

/// The library's error with what to do about it.
fn explain(error: &OscillatorFitError) -> Failure {
    let failure = Failure::new(TITLE).because(error);
    match error {
        OscillatorFitError::Fixed { .. } => Failure::usage(TITLE).because(error),
        OscillatorFitError::NoOscillator { .. } => failure.hint(
            "check the columns (--input is the force, --output the displacement) and their signs; without a resonance in the \
             record identify a Hammerstein model (leave --structure out)",
        ),
        OscillatorFitError::ModelClass { .. } => failure.hint(
            "look at the record with hysteron inspect; --initial free for a record cut out of motion; --least-fit 0 hands \
             the model out all the same",
        ),
        OscillatorFitError::NotUniform { .. } => failure.hint("give --sample-rate HZ"),
        _ => failure,
    }
}
