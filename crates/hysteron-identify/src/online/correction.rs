//! Adapted coefficients of a model, and their regressors.

use super::Term;
use crate::IdentifyError;
use hysteron_model::Start;
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::Hysteresis;
use hysteron_model::record::range_of;

/// Highest power of the drive that may be corrected.
const HIGHEST_POWER: u32 = 20;

/// A model with N adapted coefficients: y = fixed + φᵀθ, where the nominal θ gives the model's output.
///
/// All regressors follow from the drive alone; no measured output enters them.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction<const N: usize> {
    model: Model,
    terms: [Term; N],
}

/// Regressors of the coefficients of a [`Correction`] over a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Regressors<const N: usize> {
    fixed: Vec<f64>,
    columns: [Vec<f64>; N],
}

/// One sample of [`Regressors`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<const N: usize> {
    /// Part of the output independent of the coefficients \[µm\].
    pub fixed: f64,
    /// φ.
    pub regressors: [f64; N],
}

impl<const N: usize> Correction<N> {
    /// The coefficients of `model` that these terms name.
    ///
    /// # Errors
    /// [`IdentifyError::CorrectionTerm`]: a power outside 1 … 20 or a lag that is not finite and positive;
    /// [`IdentifyError::CorrectionTwice`].
    pub fn new(model: Model, terms: [Term; N]) -> Result<Self, IdentifyError> {
        for (index, term) in terms.iter().enumerate() {
            match *term {
                Term::Power(power) if !(1..=HIGHEST_POWER).contains(&power) => {
                    let (value, must) = (f64::from(power), "1 to 20 (power 0 is the offset)");
                    return Err(IdentifyError::CorrectionTerm { index, name: "the power", value, must });
                }
                Term::Creep { lag_s } if !(lag_s > 0.0 && lag_s.is_finite()) => {
                    let must = "finite and positive";
                    return Err(IdentifyError::CorrectionTerm {
                        index,
                        name: "the lag [s]",
                        value: lag_s,
                        must,
                    });
                }
                _ if terms.iter().take(index).any(|earlier| earlier == term) => {
                    return Err(IdentifyError::CorrectionTwice { index });
                }
                _ => {}
            }
        }
        Ok(Self { model, terms })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Its terms, in the order of the parameters.
    pub fn terms(&self) -> &[Term; N] {
        &self.terms
    }

    /// Nominal θ of the model.
    pub fn nominal(&self) -> [f64; N] {
        self.terms.map(|term| match term {
            Term::Offset => self.model.offset,
            Term::Gain => 1.0,
            Term::Power(_) | Term::Creep { .. } => 0.0,
        })
    }

    /// Regressors over the drive `u` \[V\]. They are causal (except for 1e-9 of the largest, see
    /// [`hysteron_model::dynamics::SimulationPlan`]), except where the model's scheme is `band-limited` or
    /// its drive band-limited between samples.
    ///
    /// # Errors
    /// Those of [`Model::simulate`]; [`IdentifyError::CorrectionNoRate`].
    pub fn regressors(
        &self,
        u: &[f64],
        sample_rate_hz: Option<f64>,
        start: &Start,
    ) -> Result<Regressors<N>, IdentifyError> {
        let without_offset = Model { offset: 0.0, ..self.model.clone() };
        let w = without_offset.simulate(u, sample_rate_hz, start)?;
        let mut columns = [const { Vec::new() }; N];
        for (column, term) in columns.iter_mut().zip(self.terms) {
            *column = match term {
                Term::Offset => vec![1.0; u.len()],
                Term::Gain => w.clone(),
                Term::Power(power) => {
                    let model = Model { hysteresis: power_of_drive(power)?, ..without_offset.clone() };
                    model.simulate(u, sample_rate_hz, &without_memory(start))?
                }
                Term::Creep { lag_s } => {
                    let rate = sample_rate_hz.ok_or(IdentifyError::CorrectionNoRate)?;
                    lagged(&w, 1.0 / (rate * lag_s))
                }
            };
        }
        let offset = if self.terms.contains(&Term::Offset) { 0.0 } else { self.model.offset };
        let gain = if self.terms.contains(&Term::Gain) { 0.0 } else { 1.0 };
        Ok(Regressors { fixed: w.iter().map(|w| offset + gain * w).collect(), columns })
    }

    /// The model with the coefficients `parameters`.
    ///
    /// # Errors
    /// [`IdentifyError::CorrectionCreep`] where a creep coefficient is not 0; [`IdentifyError::Hysteresis`]
    /// where gain or coefficients are invalid for the hysteresis block.
    pub fn corrected(&self, parameters: &[f64; N]) -> Result<Model, IdentifyError> {
        let mut model = self.model.clone();
        let of =
            |wanted: Term| self.terms.iter().zip(parameters).find(|(t, _)| **t == wanted).map(|(_, p)| *p);
        model.offset = of(Term::Offset).unwrap_or(model.offset);
        if let Some(gain) = of(Term::Gain) {
            model.hysteresis = model.hysteresis.scaled(gain)?;
        }
        for (index, (term, &value)) in self.terms.iter().zip(parameters).enumerate() {
            match *term {
                Term::Power(power) => {
                    let polynomial = model.hysteresis.polynomial_mut();
                    let at = power as usize - 1;
                    if polynomial.len() <= at {
                        polynomial.resize(at + 1, 0.0);
                    }
                    polynomial[at] += value;
                }
                Term::Creep { .. } if value != 0.0 => {
                    return Err(IdentifyError::CorrectionCreep { index, value });
                }
                _ => {}
            }
        }
        model.hysteresis.validate()?;
        Ok(model)
    }
}

impl<const N: usize> Regressors<N> {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.fixed.len()
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.fixed.is_empty()
    }

    /// Range of each regressor over the record, or 1 where it is constant (that of the offset). A coefficient
    /// change of d over this span changes the output by d.
    pub fn spans(&self) -> [f64; N] {
        self.columns.each_ref().map(|column| {
            let (low, high) = range_of(column);
            if high > low { high - low } else { 1.0 }
        })
    }

    /// Sample by sample.
    pub fn rows(&self) -> impl Iterator<Item = Row<N>> + '_ {
        self.fixed.iter().enumerate().map(|(k, &fixed)| Row {
            fixed,
            regressors: self.columns.each_ref().map(|column| column.get(k).copied().unwrap_or(0.0)),
        })
    }
}

impl<const N: usize> Row<N> {
    /// fixed + φᵀθ \[µm\].
    pub fn output(&self, parameters: &[f64; N]) -> f64 {
        self.regressors.iter().zip(parameters).fold(self.fixed, |sum, (x, p)| sum + x * p)
    }
}

/// v = uⁿ, without hysteresis.
fn power_of_drive(power: u32) -> Result<Hysteresis, IdentifyError> {
    let mut polynomial = vec![0.0; power as usize];
    if let Some(last) = polynomial.last_mut() {
        *last = 1.0;
    }
    Ok(Hysteresis::without_memory(polynomial)?)
}

fn without_memory(start: &Start) -> Start {
    match *start {
        Start::Remembering { voltage_v, .. } => Start::Rest { voltage_v },
        other => other,
    }
}

/// x' = (w − x)/τ, x = w at the first sample, exact for linearly interpolated w; z = h/τ.
fn lagged(w: &[f64], z: f64) -> Vec<f64> {
    let filled = -(-z).exp_m1();
    let from_end = 1.0 - filled / z;
    let from_start = filled - from_end;
    let mut state = w.first().copied().unwrap_or(0.0);
    let mut before = state;
    let step = |&w: &f64| {
        state += from_start * (before - state) + from_end * (w - state);
        before = w;
        state
    };
    w.iter().map(step).collect()
}
