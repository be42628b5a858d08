//! A parameter of a family of transfer functions.

/// One parameter of a [`DynamicForm`](super::DynamicForm).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FormParameter {
    /// Name, as on the command line.
    pub name: &'static str,
    /// Kind of the parameter.
    pub kind: ParameterKind,
    /// Symbol; its name where it has none.
    pub symbol: &'static str,
    /// Meaning, in a few words.
    pub meaning: &'static str,
    /// Unit; empty for a number without one.
    pub unit: &'static str,
    /// True if it is positive and naturally searched on a logarithmic scale.
    pub logarithmic: bool,
    range: Range,
}

/// Kind of a parameter of a [`DynamicForm`](super::DynamicForm). Modes and creep elements are counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParameterKind {
    /// Natural frequency ω_n/2π of a mode.
    NaturalFrequency(usize),
    /// Damping ζ of a mode.
    Damping(usize),
    /// Order α₂ of a mode.
    HighestOrder(usize),
    /// Order α₁ of a mode.
    MiddleOrder(usize),
    /// Order α₀.
    LowestOrder,
    /// Share of a mode in the gain at rest.
    Share(usize),
    /// Time constant T of the lag.
    Lag,
    /// Size k of fractional creep.
    CreepSize,
    /// Order μ of fractional creep.
    CreepOrder,
    /// Logarithmic creep γ per decade of time.
    CreepPerDecade,
    /// Time t₀ from which creep is logarithmic.
    CreepStart,
    /// Share of a creep element.
    CreepShare(usize),
    /// Time constant of a creep element.
    CreepTime(usize),
}

impl FormParameter {
    /// The parameter of this name, with the properties of its kind.
    pub(super) const fn new(name: &'static str, kind: ParameterKind) -> Self {
        use ParameterKind as Kind;
        let plain = Self {
            name,
            kind,
            symbol: name,
            meaning: "",
            unit: "",
            logarithmic: false,
            range: Range::Finite,
        };
        let positive = Self { logarithmic: true, range: Range::Positive, ..plain };
        let order = Self { range: Range::NotNegative, ..plain };
        match kind {
            Kind::NaturalFrequency(mode) => Self {
                symbol: "ω_n/2π",
                meaning: if mode == 1 { "natural frequency" } else { "natural frequency of a further mode" },
                unit: "Hz",
                ..positive
            },
            Kind::Damping(mode) => Self {
                symbol: "ζ",
                meaning: if mode == 1 { "damping" } else { "damping of a further mode" },
                logarithmic: true,
                ..plain
            },
            Kind::HighestOrder(mode) => Self {
                symbol: "α₂",
                meaning: if mode == 1 { "highest order" } else { "highest order of the second mode" },
                ..order
            },
            Kind::MiddleOrder(mode) => Self {
                symbol: "α₁",
                meaning: if mode == 1 { "middle order" } else { "middle order of the second mode" },
                ..order
            },
            Kind::LowestOrder => Self { symbol: "α₀", meaning: "lowest order", ..order },
            Kind::Share(1) => Self { meaning: "share of the first mode in the gain at rest", ..plain },
            Kind::Share(_) => {
                Self { meaning: "share of a further mode; the last has the remainder", ..plain }
            }
            Kind::Lag => Self { symbol: "T", meaning: "time constant of the lag", unit: "s", ..positive },
            Kind::CreepSize => {
                Self {
                    symbol: "k", meaning: "size of the creep, factor 1 + k s^−μ", unit: "s^−μ", ..plain
                }
            }
            Kind::CreepOrder => Self { symbol: "μ", meaning: "order of the creep", ..order },
            Kind::CreepPerDecade => {
                Self { symbol: "γ", meaning: "creep per decade of time, as a share of the step", ..plain }
            }
            Kind::CreepStart => {
                Self {
                    symbol: "t₀", meaning: "time from which creep is logarithmic", unit: "s", ..positive
                }
            }
            Kind::CreepShare(_) => {
                let meaning = "share k of a creep element, k/(1 + τ s)";
                Self { meaning, logarithmic: true, range: Range::NotNegative, ..plain }
            }
            Kind::CreepTime(_) => {
                Self { meaning: "time constant τ of a creep element", unit: "s", ..positive }
            }
        }
    }

    /// Checks a value; the error states the allowed values.
    pub(super) fn check(&self, value: f64) -> Result<(), &'static str> {
        let (allowed, inside) = match self.range {
            Range::Positive => ("positive and finite", value > 0.0),
            Range::NotNegative => ("a finite number ≥ 0", value >= 0.0),
            Range::Finite => ("a finite number", true),
        };
        if inside && value.is_finite() { Ok(()) } else { Err(allowed) }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Range {
    Positive,
    NotNegative,
    Finite,
}
