//! The model's operator in the sources: flags and sizes of the templates, and its numbers in tables. A new
//! operator of the runtime is written here and in the template of the Rust crate; its C stands beside it in
//! `hysteron-rt`.

use hysteron_model::hysteresis::{NumberUnit, RuntimeOperator};
use hysteron_model::realise::TURNS;
use hysteron_rt::{Branch, Real, Sides};

use crate::template::Filling;

/// A table of numbers.
#[derive(Clone, Debug)]
pub(crate) struct Table<T> {
    pub comment: &'static str,
    pub name: &'static str,
    pub numbers: Vec<T>,
}

/// A single number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constant<T> {
    pub comment: &'static str,
    pub name: &'static str,
    pub value: T,
}

/// The numbers of an operator.
#[derive(Clone, Debug)]
pub(crate) struct OperatorNumbers<T> {
    /// Parameters of states in parallel, and their units.
    pub states: Option<(Vec<[T; 4]>, [NumberUnit; 4])>,
    /// The law of a branch.
    pub law: Option<Branch<T>>,
    /// Tunable weights, and their owner, `state` or `play`.
    pub weights: Option<(&'static str, Vec<T>)>,
    /// Tables that are not tunable.
    pub tables: Vec<Table<T>>,
    /// Numbers that are not tunable.
    pub constants: Vec<Constant<T>>,
    /// Those used only in C, and only in Rust.
    pub of_c: Vec<Constant<T>>,
    pub of_rust: Vec<Constant<T>>,
}

impl<T: Real> OperatorNumbers<T> {
    pub fn new(operator: &RuntimeOperator<T>) -> Self {
        let mut all = Self {
            states: None,
            law: None,
            weights: None,
            tables: Vec::new(),
            constants: Vec::new(),
            of_c: Vec::new(),
            of_rust: Vec::new(),
        };
        let constant = |comment, name, value| Constant { comment, name, value };
        match operator {
            RuntimeOperator::States { parameters, units } => all.states = Some((parameters.clone(), *units)),
            RuntimeOperator::Branch { law, weights } => {
                all.law = Some(*law);
                all.weights = Some(("state", weights.clone()));
            }
            RuntimeOperator::Plays { thresholds, weights } => {
                all.table("Half-widths of the plays.", "THRESHOLD", thresholds);
                all.weights = Some(("play", weights.clone()));
            }
            RuntimeOperator::SidedPlays { sides, thresholds, weights, line } => {
                all.weights = Some(("play", weights.clone()));
                let mut of_thresholds = "Half-widths of the plays.";
                match *sides {
                    Sides::Even { widening } if widening > T::of(0.0) => {
                        let comment = "Growth of a half-width for a move of 1 per sample.";
                        all.constants.push(constant(comment, "WIDENING", widening));
                    }
                    Sides::Even { .. } | Sides::Below => {}
                    Sides::Envelopes { right, left } => {
                        all.table("Rise and centre of the right envelope.", "RIGHT", &right);
                        all.table("Rise and centre of the left envelope.", "LEFT", &left);
                    }
                    Sides::Ramps { steepness } => {
                        of_thresholds = "Lines of the grid.";
                        all.constants.push(constant("Slope of a ramp.", "STEEPNESS", steepness));
                    }
                }
                all.table(of_thresholds, "THRESHOLD", thresholds);
                if !line.slopes.is_empty() {
                    all.table("Shares of the plays in their mean.", "SHARE", &line.shares);
                    all.table("Corners of the line that the mean goes through.", "CORNER", &line.corners);
                    all.table("Slopes between them, one more.", "SLOPE", &line.slopes);
                }
            }
            RuntimeOperator::RelaxingPlays { pace: (sigma, interval), range, thresholds, slopes } => {
                all.table("Half-widths of the plays.", "THRESHOLD", thresholds);
                all.table("Slopes of the play outputs, three per play.", "SLOPE", slopes);
                all.table("Ends of the range over which these hold.", "RANGE", range);
                all.constants.push(constant("Activation of the plays.", "SIGMA", *sigma));
                all.constants.push(constant("Seconds from sample to sample.", "INTERVAL", *interval));
            }
            RuntimeOperator::Plane { range: [low, high], intervals, everett } => {
                let comment = "Sums over the relays between two levels: (1, 0), (2, 0), (2, 1), (3, 0), ...";
                all.table(comment, "EVERETT", everett);
                all.constants.push(constant("Lowest level.", "LOWEST", *low));
                let density = T::of(*intervals as f64) / (*high - *low);
                all.of_c.push(constant("Intervals between levels a unit of voltage.", "DENSITY", density));
                all.of_rust.push(constant("Highest level.", "HIGHEST", *high));
            }
        }
        all
    }

    fn table(&mut self, comment: &'static str, name: &'static str, numbers: &[T]) {
        self.tables.push(Table { comment, name, numbers: numbers.to_vec() });
    }

    /// The exponent of states in parallel: one for all, several have n = 1.
    fn exponent(&self) -> Option<T> {
        self.states.as_ref()?.0.first().map(|&[.., n]| n)
    }

    /// The law of a branch in C; empty for other operators.
    pub fn c_fragment(&self) -> &'static str {
        self.law.map_or("", |law| law.c_fragment())
    }

    /// Whether the law of a branch in C contains this name.
    pub fn names(&self, name: &str) -> bool {
        let is_end = |c: char| !(c.is_alphanumeric() || c == '_');
        self.c_fragment().split(is_end).any(|word| word == name)
    }
}

/// Sets flags and sizes of an operator.
pub(crate) fn fill<T: Real>(filling: &mut Filling, operator: &RuntimeOperator<T>) {
    let numbers = OperatorNumbers::new(operator);
    let exponent = numbers.exponent();
    let [linear, quadratic] = [1.0, 2.0].map(|n| exponent.is_some_and(|own| own == T::of(n)));
    let power = exponent.is_some() && !linear && !quadratic;
    let linear_law = linear || numbers.names("increment");
    let fragment = numbers.c_fragment();
    filling
        .part("law of a branch", if fragment.is_empty() { String::new() } else { format!("{fragment}\n") })
        .flag("own_output", numbers.names("branch_output"))
        .flag("own_virgin", numbers.names("branch_virgin"))
        .flag("moments", numbers.names("moments"))
        .flag("roots", numbers.names("rising_root"))
        .flag("state_law", exponent.is_some() || numbers.names("state_law"))
        .flag("linear_law", linear_law)
        .flag("quadratic_law", quadratic)
        .flag("power_law", power)
        .flag("logs", linear_law || numbers.names("log_distance"))
        .flag("relaxes", linear_law || power || numbers.names("relaxation"))
        .key("N_PLAYS", numbers.weights.as_ref().map_or(0, |(_, weights)| weights.len()));
    for key in [
        "RATE_PARAMETER",
        "RATE_IN_WORDS",
        "THROUGH_PARAMETER",
        "THROUGH_IN_WORDS",
        "AT_HALF",
        "AT_END",
        "AT_REST",
        "AWAY",
    ] {
        filling.key(key, "");
    }
    match operator {
        RuntimeOperator::States { parameters, .. } => {
            let none = parameters.is_empty();
            filling.flag("states", !none).flag("memoryless", none).flag("accumulates", !none);
            filling.key("N_STATE_LAWS", parameters.len());
        }
        RuntimeOperator::Branch { weights, .. } => {
            filling.flag("branch", true).flag("accumulates", true).key("N_STATES", weights.len());
        }
        RuntimeOperator::Plays { weights, .. } => {
            filling.flag("plays", !weights.is_empty()).flag("memoryless", weights.is_empty());
        }
        RuntimeOperator::SidedPlays { sides, thresholds, line, .. } => {
            let kind = match *sides {
                Sides::Even { widening } if widening > T::of(0.0) => "rate",
                Sides::Even { .. } => "even",
                Sides::Below => "below",
                Sides::Envelopes { .. } => "envelopes",
                Sides::Ramps { .. } => "ramps",
            };
            filling
                .flag("sided", true)
                .flag(kind, true)
                .flag("line", !line.slopes.is_empty())
                .key("N_THRESHOLDS", thresholds.len())
                .key("N_CORNERS", line.corners.len());
            if kind == "rate" {
                filling
                    .flag("moves_at_rest", true)
                    .key("AT_HALF", ", voltage - state->voltage")
                    .key("AT_END", ", voltage - state->voltage")
                    .key("AT_REST", ", 0")
                    .key("AWAY", ", away")
                    .key("RATE_PARAMETER", ", real du")
                    .key("RATE_IN_WORDS", " in a sample that moves by du")
                    .key("THROUGH_PARAMETER", "real middle, real du, ")
                    .key("THROUGH_IN_WORDS", " through `middle`, in a sample that moves by du,");
            }
        }
        RuntimeOperator::RelaxingPlays { thresholds, .. } => {
            filling
                .flag("relaxing", true)
                .flag("relaxes", true)
                .flag("moves_at_rest", true)
                .key("N_PLAYS", thresholds.len())
                .key("AT_HALF", ", (real)0.5")
                .key("AT_END", ", 1")
                .key("AT_REST", ", 1")
                .key("AWAY", ", 1")
                .key("RATE_PARAMETER", ", real share")
                .key("RATE_IN_WORDS", " after that share of a sample");
        }
        RuntimeOperator::Plane { intervals, .. } => {
            filling.flag("plane", true).key("N_INTERVALS", intervals).key("N_TURNS", TURNS);
            filling.number("REAL_INTERVALS", *intervals as f64);
        }
    }
}
