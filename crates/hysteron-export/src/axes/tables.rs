//! Tables of numbers in C and Rust.

use hysteron_model::axes::ScheduledModes;
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::DecouplingLaw;

use crate::c::rows;
use crate::number::Precision;

/// Language of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Language {
    C,
    Rust,
}

impl Language {
    /// Brackets around a list.
    fn brackets(self) -> (char, char) {
        match self {
            Self::C => ('{', '}'),
            Self::Rust => ('[', ']'),
        }
    }

    /// A list of numbers.
    pub fn row(self, precision: Precision, numbers: &[f64]) -> String {
        let (open, close) = self.brackets();
        let numbers: Vec<String> = numbers.iter().map(|x| self.literal(precision, *x)).collect();
        format!("{open}{}{close}", numbers.join(", "))
    }

    /// A number of the source.
    pub fn literal(self, precision: Precision, x: f64) -> String {
        match self {
            Self::C => precision.c_literal(x),
            Self::Rust => precision.rust_literal(x),
        }
    }
}

/// Limits of an actuator, as numbers of a source: rounded inwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limited {
    pub low: f64,
    pub high: f64,
    /// Largest change from one sample to the next.
    pub step: f64,
}

impl Limited {
    pub fn new(limits: &Limits, sample_rate_hz: f64, precision: Precision) -> Self {
        let (low, high) = (precision.at_least(limits.low), precision.at_most(limits.high));
        let largest = precision.constant("MAX").unwrap_or(f64::MAX);
        let step = limits.slew_v_per_s / sample_rate_hz;
        // Less what the sum with a voltage is rounded by.
        let rounding = match precision {
            Precision::F32 => precision.epsilon() * low.abs().max(high.abs()),
            Precision::F64 => 0.0,
        };
        let step = if step < largest { precision.at_most((step - rounding).max(0.0)) } else { largest };
        Self { low, high, step }
    }
}

/// Declarations, one after the other.
pub(super) struct Tables {
    language: Language,
    precision: Precision,
    text: String,
}

impl Tables {
    pub fn new(language: Language, precision: Precision) -> Self {
        Self { language, precision, text: String::new() }
    }

    pub fn text(self) -> String {
        self.text
    }

    /// The numbers of a model at S.
    pub fn of_model(&mut self, model: &ScheduledModes, s: f64) {
        let (at, n, states) = (model.at(s), model.inputs, model.states());
        self.list("Poles, real and imaginary parts; then the lags.", "TRANSITION", &at.transition);
        self.matrix("States on voltages.", "INPUT", n, &model.input);
        self.matrix("States on strains.", "STRAIN_INPUT", n, &model.strain_input);
        self.matrix("Outputs on states.", "OUTPUT", states, &at.output);
        self.matrix("Outputs on voltages.", "FEEDTHROUGH", n, &at.feedthrough);
        self.matrix("Outputs on strains.", "STRAIN_FEEDTHROUGH", n, &model.strain_feedthrough);
        let Some(feedback) = &model.feedback else { return };
        let signals = [feedback.drive_rows.clone(), feedback.stress_rows.clone()].concat();
        self.matrix("Free strokes, then stresses, on states and voltages.", "ROWS", states + n, &signals);
        let laws: Vec<_> = std::iter::repeat_n(&feedback.drive, n).chain(&feedback.stress).collect();
        let all = |of: &dyn Fn(usize) -> Vec<f64>| (0..laws.len()).flat_map(of).collect::<Vec<f64>>();
        self.matrix("Square and cube.", "POWERS", 2, &all(&|i| laws[i].coefficients[..2].to_vec()));
        self.list("Mean squares.", "VARIANCE", &all(&|i| vec![laws[i].variance]));
        let largest = self.precision.constant("MAX").unwrap_or(f64::MAX);
        self.list(
            "Signals beyond are taken to be there.",
            "REACH",
            &all(&|i| vec![laws[i].reach.min(largest)]),
        );
        let plays = feedback.drive.radii.len();
        if plays > 0 {
            self.matrix("Plays: weights.", "WEIGHTS", plays, &all(&|i| laws[i].coefficients[2..].to_vec()));
            self.matrix("Radii.", "RADII", plays, &all(&|i| laws[i].radii.clone()));
            self.matrix("Mean slopes.", "SLOPES", plays, &all(&|i| laws[i].slopes.clone()));
        }
    }

    /// The numbers of a law and its limits.
    pub fn of_law(&mut self, law: &DecouplingLaw, limits: &[Limited]) {
        let model = &law.held.model;
        let (n, m) = (model.inputs, model.outputs);
        self.matrix("The law: gains on the states.", "LAW_STATES", model.states(), &law.states);
        self.matrix("On the last voltages.", "LAW_LAST", n, &law.recent[0]);
        self.matrix("On those before.", "LAW_BEFORE", n, &law.recent[1]);
        self.matrix("On the strains.", "LAW_STRAINS", n, &law.strains);
        self.matrix("On their change in a sample.", "LAW_RATES", n, &law.strain_rates);
        let (open, close) = self.language.brackets();
        let block = |gains: &Vec<f64>| {
            let rows: Vec<String> =
                gains.chunks(m).map(|row| self.language.row(self.precision, row)).collect();
            format!("    {open}{}{close}", rows.join(", "))
        };
        let content: Vec<String> = law.reference.iter().map(block).collect();
        let comment = "On the references, from the present one to the end of the preview.";
        self.declare(comment, "LAW_REFERENCES", &[law.reference.len(), n, m], &content.join(",\n"));
        let of = |one: fn(&Limited) -> f64| -> Vec<f64> { limits.iter().map(one).collect() };
        let (low, high, step) = (of(|l| l.low), of(|l| l.high), of(|l| l.step));
        self.list("Least voltages.", "LOW", &low);
        self.list("Largest voltages.", "HIGH", &high);
        self.list("Largest changes from one sample to the next.", "STEP", &step);
    }

    fn list(&mut self, comment: &str, name: &str, numbers: &[f64]) {
        let content = rows(numbers.iter().map(|x| self.language.literal(self.precision, *x)));
        self.declare(comment, name, &[numbers.len()], &content);
    }

    fn matrix(&mut self, comment: &str, name: &str, width: usize, numbers: &[f64]) {
        let (open, close) = self.language.brackets();
        let content: Vec<String> = numbers
            .chunks(width)
            .map(|row| {
                format!(
                    "    {open}\n{}\n    {close}",
                    rows(row.iter().map(|x| self.language.literal(self.precision, *x)))
                )
            })
            .collect();
        self.declare(comment, name, &[numbers.len() / width, width], &content.join(",\n"));
    }

    fn declare(&mut self, comment: &str, name: &str, sizes: &[usize], content: &str) {
        self.text += &match self.language {
            Language::C => {
                let sizes: String = sizes.iter().map(|size| format!("[{size}]")).collect();
                format!("/* {comment} */\nstatic const real {name}{sizes} = {{\n{content}\n}};\n")
            }
            Language::Rust => {
                let kind = sizes
                    .iter()
                    .rev()
                    .fold(self.precision.name().to_owned(), |kind, size| format!("[{kind}; {size}]"));
                format!("/// {comment}\nstatic {name}: {kind} = [\n{content},\n];\n")
            }
        };
    }
}
