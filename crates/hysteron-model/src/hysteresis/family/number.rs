//! The numbers of a family: their names, units, meanings and search ranges.

/// Unit of a number: powers of the output's and of the input's unit, and of the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberUnit {
    /// Power of the output's unit.
    pub output: i32,
    /// Power of the input's unit.
    pub input: i32,
    /// Power of the second.
    pub time: i32,
    /// The power of the output's unit is less by n − 1, n being the family's exponent.
    pub falls_with_exponent: bool,
}

impl NumberUnit {
    pub(in crate::hysteresis) const NONE: Self =
        Self { output: 0, input: 0, time: 0, falls_with_exponent: false };
    pub(in crate::hysteresis) const INPUT: Self = Self { input: 1, ..Self::NONE };
    pub(in crate::hysteresis) const PER_INPUT: Self = Self { input: -1, ..Self::NONE };
    pub(in crate::hysteresis) const PER_INPUT_OF_EXPONENT: Self =
        Self { falls_with_exponent: true, ..Self::PER_INPUT };
    pub(in crate::hysteresis) const OUTPUT: Self = Self { output: 1, ..Self::NONE };
    pub(in crate::hysteresis) const SLOPE: Self = Self { output: 1, input: -1, ..Self::NONE };
    pub(in crate::hysteresis) const TIME: Self = Self { time: 1, ..Self::NONE };

    /// The unit in text, for signals in these units: `um/V^2`, say, or `um^(1-n)/V`.
    pub fn of(self, input: &str, output: &str) -> String {
        if self.falls_with_exponent {
            return format!("{output}^({}-n)/{input}", self.output + 1);
        }
        self.text(input, output)
    }

    /// [`Self::of`] where the exponent n is known.
    pub fn of_exponent(self, n: f64, input: &str, output: &str) -> String {
        if self.falls_with_exponent && n != 1.0 {
            return format!("{output}^{}/{input}", self.power_of_output(n));
        }
        self.text(input, output)
    }

    /// Power of the output's unit, and so of a factor of the output, at the exponent n.
    pub fn power_of_output(self, n: f64) -> f64 {
        f64::from(self.output) + if self.falls_with_exponent { 1.0 - n } else { 0.0 }
    }

    fn text(self, input: &str, output: &str) -> String {
        let power = |name: &str, power: i32| match power {
            0 => "1".to_owned(),
            1 => name.to_owned(),
            _ => format!("{name}^{power}"),
        };
        let outputs = power(output, self.output);
        match self.input {
            0 if self.output == 0 => power("s", self.time),
            0 => outputs,
            inputs if inputs < 0 => format!("{outputs}/{}", power(input, -inputs)),
            inputs if self.output == 0 => power(input, inputs),
            inputs => format!("{outputs}*{}", power(input, inputs)),
        }
    }
}

/// A number of a model of a family, beside its polynomial.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelNumber {
    /// Name, as in model files.
    pub name: String,
    /// Unit.
    pub unit: NumberUnit,
    /// Among which numbers of the model it stands.
    pub place: Place,
}

/// Place of a number in a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Index among the shape numbers.
    Shape(usize),
    /// Index among the weights.
    Weight(usize),
}

/// A shape number θ of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeNumber {
    /// Name, as in model files.
    pub name: String,
    /// Unit.
    pub unit: NumberUnit,
    /// Meaning, in a few words.
    pub meaning: &'static str,
    /// Search range of a fit.
    pub search: Search,
}

impl ShapeNumber {
    pub(in crate::hysteresis) fn new(
        name: impl Into<String>,
        unit: NumberUnit,
        meaning: &'static str,
        search: Search,
    ) -> Self {
        Self { name: name.into(), unit, meaning, search }
    }

    /// `low` and `high`, the ends of the voltages that a family's grid spans, with which its shape begins;
    /// [`ends`] are their values.
    pub(in crate::hysteresis) fn of_ends(span: &DriveSpan) -> [Self; 2] {
        let [low, high] = span.grid;
        [
            Self::new("low", NumberUnit::INPUT, "lower end of the grid", Search::Held(low)),
            Self::new("high", NumberUnit::INPUT, "upper end of the grid", Search::Held(high)),
        ]
    }
}

/// Search range of a number in a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Search {
    /// Held at this value.
    Held(f64),
    /// Held at this value, or searched within these limits where bounds are requested.
    HeldUnlessBounded(f64, [f64; 2]),
    /// Searched between these ends, on a linear scale.
    Linear(f64, f64),
    /// Searched between these ends, on a logarithmic scale.
    Logarithmic(f64, f64),
}

/// Span of the drives of a fit, which sets the ranges of a family's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveSpan {
    /// Stroke of the drives \[V\].
    pub stroke: f64,
    /// Least and largest voltage \[V\].
    pub ends: [f64; 2],
    /// Ends of what a family's grid covers \[V\].
    pub grid: [f64; 2],
    /// Largest half-width of a play that the drives may move \[V\].
    pub reach: f64,
    /// Rate of the fastest drive at its mean, for a drive of half the stroke to either side \[1/s\].
    pub fastest_rate: f64,
    /// Exponent of a family that has one, to start from.
    pub exponent: f64,
    /// True if it is held there.
    pub holds_exponent: bool,
    /// True if all weights are held at 0, so that nothing shapes a loop.
    pub is_straight: bool,
}

impl DriveSpan {
    /// From 0 to 1 V within a second: for results that do not depend on the span.
    pub const UNIT: Self = Self {
        stroke: 1.0,
        ends: [0.0, 1.0],
        grid: [0.0, 1.0],
        reach: 1.0,
        fastest_rate: 1.0,
        exponent: 1.0,
        holds_exponent: true,
        is_straight: false,
    };

    /// Largest relaxation searched: a sharper one is a switch \[1/V\].
    pub(in crate::hysteresis) fn sharpest(&self) -> f64 {
        20.0 / self.stroke
    }

    /// Smallest relaxation searched: a blunter one hardly bends a loop \[1/V\].
    pub(in crate::hysteresis) fn bluntest(&self) -> f64 {
        1e-3 / self.stroke
    }

    /// Relaxations to start from \[1/V\].
    pub(in crate::hysteresis) fn bends(&self) -> [f64; 6] {
        [0.5, 1.0, 2.0, 4.0, 8.0, 16.0].map(|bends| bends / self.stroke)
    }

    pub(in crate::hysteresis) fn middle(&self) -> f64 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    /// Search range of a relaxation, from blunt to sharp.
    pub(in crate::hysteresis) fn relaxation(&self) -> Search {
        Search::Linear(self.bluntest(), self.sharpest())
    }

    /// Search range of a skew, up to the sharpest relaxation on either side.
    pub(in crate::hysteresis) fn skew(&self) -> Search {
        Search::Linear(-self.sharpest(), self.sharpest())
    }

    /// Search range of voltages, up to a stroke beyond the ends.
    pub(in crate::hysteresis) fn around(&self) -> Search {
        Search::Linear(self.ends[0] - self.stroke, self.ends[1] + self.stroke)
    }

    /// Search range in strokes, on a logarithmic scale.
    pub(in crate::hysteresis) fn strokes(&self, least: f64, most: f64) -> Search {
        Search::Logarithmic(least * self.stroke, most * self.stroke)
    }
}

/// Skews of a relaxation to start from, as shares of it.
pub(in crate::hysteresis) const SKEWS: [f64; 3] = [-0.7, 0.0, 0.7];

/// Ends of the grid of a family whose shape begins with them.
pub(in crate::hysteresis) fn ends(shape: &[f64]) -> [f64; 2] {
    [0, 1].map(|index| shape.get(index).copied().unwrap_or(f64::NAN))
}
