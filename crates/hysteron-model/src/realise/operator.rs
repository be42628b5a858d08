//! The hysteresis block in one number type: numbers and memory of the operator of `hysteron-rt` for a family.

use hysteron_rt::{
    BrokenLine, IncrementMemory, ModelError, Operator, Plane, PlayBank, Real, RelaxingPlays, SidedPlays,
    StateLaw, Turn, Turns,
};

use super::RealiseError;
use crate::hysteresis::{Hysteresis, RuntimeOperator};

/// Turning points that a plane of relays remembers at once.
pub const TURNS: usize = 64;

/// An operator with its memory.
#[derive(Clone, Debug)]
pub(super) struct OperatorParts<T> {
    numbers: RuntimeOperator<T>,
    /// Laws of states in parallel.
    laws: Vec<StateLaw<T>>,
    /// Memory of states that move by increments.
    increments: Vec<IncrementMemory<T>>,
    /// States of plays.
    states: Vec<T>,
    /// Memory of a plane.
    turns: Vec<Turn<T>>,
}

/// Polynomial and operator of a hysteresis block at this sample rate.
pub(super) fn parts<T: Real>(
    hysteresis: &Hysteresis,
    sample_rate_hz: f64,
) -> Result<(Vec<T>, OperatorParts<T>), RealiseError> {
    let (polynomial, operator) = hysteresis.runtime(sample_rate_hz);
    let polynomial = polynomial.into_iter().map(T::of).collect();
    Ok((polynomial, OperatorParts::new(operator.rounded())?))
}

impl<T: Real> OperatorParts<T> {
    fn new(numbers: RuntimeOperator<T>) -> Result<Self, RealiseError> {
        let mut laws = Vec::new();
        let [mut increments, mut plays, mut turns] = [0; 3];
        match &numbers {
            RuntimeOperator::States { parameters, .. } => {
                for own in parameters {
                    laws.push(StateLaw::of(*own).map_err(|_| RealiseError::Rounded)?);
                }
                increments = parameters.len();
            }
            RuntimeOperator::Branch { weights, .. } => increments = weights.len(),
            RuntimeOperator::Plays { weights, .. } | RuntimeOperator::SidedPlays { weights, .. } => {
                plays = weights.len();
            }
            RuntimeOperator::RelaxingPlays { thresholds, .. } => plays = thresholds.len(),
            RuntimeOperator::Plane { range, intervals, everett } => {
                Plane::new(*range, *intervals, everett).map_err(|_| RealiseError::Rounded)?;
                turns = TURNS;
            }
        }
        Ok(Self {
            numbers,
            laws,
            increments: vec![IncrementMemory::new(T::of(0.0)); increments],
            states: vec![T::of(0.0); plays],
            turns: vec![Turn::none(); turns],
        })
    }

    /// The numbers, without the memory.
    pub(super) fn numbers(&self) -> &RuntimeOperator<T> {
        &self.numbers
    }

    /// The operator on its memory.
    pub(super) fn operator(&mut self) -> Result<Operator<'_, T>, RealiseError> {
        let rounded = |_| RealiseError::Rounded;
        let (memory, states) = (&mut self.increments[..], &mut self.states[..]);
        Ok(match &self.numbers {
            RuntimeOperator::States { .. } => Operator::States { laws: &self.laws, memory },
            RuntimeOperator::Branch { law, weights } => Operator::Branch { law: *law, weights, memory },
            RuntimeOperator::Plays { thresholds, weights } => {
                Operator::Plays { bank: PlayBank::new(thresholds, weights).map_err(rounded)?, states }
            }
            RuntimeOperator::SidedPlays { sides, thresholds, weights, line } => {
                let mut plays = SidedPlays::new(*sides, thresholds, weights).map_err(rounded)?;
                if !line.slopes.is_empty() {
                    let line = BrokenLine::new(&line.shares, &line.corners, &line.slopes).map_err(rounded)?;
                    plays = plays.with_line(line).map_err(rounded)?;
                }
                Operator::SidedPlays { plays, states }
            }
            RuntimeOperator::RelaxingPlays { pace, range, thresholds, slopes } => Operator::RelaxingPlays {
                plays: RelaxingPlays::new(*pace, *range, thresholds, slopes).map_err(rounded)?,
                states,
            },
            RuntimeOperator::Plane { range, intervals, everett } => Operator::Plane {
                plane: Plane::new(*range, *intervals, everett).map_err(|_| RealiseError::Rounded)?,
                turns: Turns::new(&mut self.turns),
            },
        })
    }

    /// The hysteresis block, virgin at 0 V.
    pub(super) fn block<'a>(
        &'a mut self,
        polynomial: &'a [T],
    ) -> Result<hysteron_rt::Hysteresis<'a, T>, RealiseError> {
        hysteron_rt::Hysteresis::new(polynomial, self.operator()?)
            .map_err(|_: ModelError<T>| RealiseError::Rounded)
    }
}
