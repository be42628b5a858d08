//! The hysteresis block in one number type: coefficients and memory of the operator that `hysteron-rt` runs a
//! family by.

use hysteron_rt::{
    ActivatedPlays, BoucWen, Branch, BrokenLine, IncrementMemory, ModelError, Operator, Plane, PlayBank,
    Real, SidedPlays, Sides, Turn, Turns,
};

use super::RealiseError;
use crate::hysteresis::{Hysteresis, MeanLine, RuntimeOperator};

/// Turning points that a plane of relays remembers at once.
const TURNS: usize = 64;

/// The numbers of a hysteresis operator.
#[derive(Clone, Copy, Debug)]
pub enum OperatorCoefficients<'a, T> {
    /// v = l\[u\] − Σ zₖ.
    BoucWen(&'a [BoucWen<T>]),
    /// v = l\[u\] + Σ wⱼ yⱼ by one law on each branch ([`Branch`]).
    Branch {
        /// The law.
        law: Branch<T>,
        /// wⱼ.
        weights: &'a [T],
    },
    /// v = l\[u\] + Σ wᵢ F_rᵢ\[u\].
    Plays {
        /// rᵢ \[V\].
        thresholds: &'a [T],
        /// wᵢ \[µm/V\].
        weights: &'a [T],
    },
    /// v = l\[u\] + plays between other sides ([`SidedPlays`]), with a broken line of their mean where it has
    /// slopes ([`BrokenLine`]).
    SidedPlays {
        /// Their sides.
        sides: Sides<T>,
        /// Their thresholds, or the lines of their ramps.
        thresholds: &'a [T],
        /// Their weights.
        weights: &'a [T],
        /// Shares of the plays in the mean.
        shares: &'a [T],
        /// Corners of the line \[V\].
        corners: &'a [T],
        /// Its slopes \[µm/V\], one more; none without a line.
        slopes: &'a [T],
    },
    /// v = l\[u\] + plays with thermally activated edges ([`ActivatedPlays`]).
    ActivatedPlays {
        /// Activation \[V\], and time between samples \[s\].
        pace: (T, T),
        /// Ends of the range of their slopes \[V\].
        range: [T; 2],
        /// Half-widths \[V\].
        thresholds: &'a [T],
        /// Slopes, three a play.
        slopes: &'a [T],
    },
    /// v = l\[u\] + a plane of relays ([`Plane`]).
    Plane {
        /// Its lowest and highest level \[V\].
        range: [T; 2],
        /// Intervals between levels a volt.
        density: T,
        /// Intervals.
        intervals: usize,
        /// Sums over the plane \[µm\].
        everett: &'a [T],
        /// Turning points remembered at once.
        turns: usize,
    },
}

/// Coefficients and memory of an operator.
#[derive(Clone, Debug)]
pub(super) enum OperatorParts<T> {
    BoucWen { operators: Vec<BoucWen<T>>, memory: Vec<IncrementMemory<T>> },
    Branch { law: Branch<T>, weights: Vec<T>, memory: Vec<IncrementMemory<T>> },
    Plays { thresholds: Vec<T>, weights: Vec<T>, states: Vec<T> },
    SidedPlays { sides: Sides<T>, thresholds: Vec<T>, weights: Vec<T>, line: MeanLine<T>, states: Vec<T> },
    ActivatedPlays { pace: (T, T), range: [T; 2], thresholds: Vec<T>, slopes: Vec<T>, states: Vec<T> },
    Plane { range: [T; 2], density: T, intervals: usize, everett: Vec<T>, turns: Vec<Turn<T>> },
}

fn all<T: Real>(numbers: impl IntoIterator<Item = f64>) -> Vec<T> {
    numbers.into_iter().map(T::of).collect()
}

/// Polynomial and operator of a hysteresis block, for so many samples a second.
pub(super) fn parts<T: Real>(
    hysteresis: &Hysteresis,
    sample_rate_hz: f64,
) -> Result<(Vec<T>, OperatorParts<T>), RealiseError> {
    let (polynomial, operator) = hysteresis.runtime(sample_rate_hz);
    let operator = match operator {
        RuntimeOperator::BoucWen(states) => OperatorParts::bouc_wen(&states)?,
        RuntimeOperator::Branch { law, weights } => OperatorParts::branch(law.map(T::of), weights),
        RuntimeOperator::Plays { thresholds, weights } => OperatorParts::plays(thresholds, weights),
        RuntimeOperator::SidedPlays { sides, thresholds, weights, line } => {
            OperatorParts::sided(sides.map(T::of), thresholds, weights, line.map(T::of))
        }
        RuntimeOperator::ActivatedPlays { sigma, interval_s, range, thresholds, slopes } => {
            let states = vec![T::of(0.0); thresholds.len()];
            let (pace, range) = ((T::of(sigma), T::of(interval_s)), range.map(T::of));
            OperatorParts::ActivatedPlays {
                pace,
                range,
                thresholds: all(thresholds),
                slopes: all(slopes),
                states,
            }
        }
        RuntimeOperator::Plane { range, intervals, cells } => OperatorParts::plane(range, intervals, &cells)?,
    };
    Ok((all(polynomial), operator))
}

/// Σ of the cells with levels from q to p, in the order (1, 0), (2, 0), (2, 1), (3, 0), …; cells in theirs:
/// (0, 0), (1, 0), (1, 1), (2, 0), ….
fn sums(intervals: usize, cells: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(cells.len());
    let mut below = vec![0.0; intervals];
    for row in 0..intervals {
        let begin = row * (row + 1) / 2;
        let mut along = 0.0;
        for column in (0..=row).rev() {
            along += cells.get(begin + column).copied().unwrap_or(0.0);
            if let Some(sum) = below.get_mut(column) {
                *sum += along;
            }
        }
        out.extend(below.iter().take(row + 1));
    }
    out
}

impl<T: Real> OperatorParts<T> {
    fn bouc_wen(parameters: &[[f64; 4]]) -> Result<Self, RealiseError> {
        let operators: Result<Vec<_>, _> = parameters
            .iter()
            .map(|numbers| {
                let [alpha, beta, gamma, n] = numbers.map(T::of);
                BoucWen::new(alpha, beta, gamma, n)
            })
            .collect();
        let operators = operators.map_err(|_| RealiseError::Rounded)?;
        let memory = vec![IncrementMemory::new(T::of(0.0)); operators.len()];
        Ok(Self::BoucWen { operators, memory })
    }

    fn branch(law: Branch<T>, weights: impl IntoIterator<Item = f64>) -> Self {
        let weights = all(weights);
        let memory = vec![IncrementMemory::new(T::of(0.0)); weights.len()];
        Self::Branch { law, weights, memory }
    }

    fn plays(thresholds: impl IntoIterator<Item = f64>, weights: impl IntoIterator<Item = f64>) -> Self {
        let weights = all(weights);
        let states = vec![T::of(0.0); weights.len()];
        Self::Plays { thresholds: all(thresholds), weights, states }
    }

    fn sided(
        sides: Sides<T>,
        thresholds: impl IntoIterator<Item = f64>,
        weights: impl IntoIterator<Item = f64>,
        line: MeanLine<T>,
    ) -> Self {
        let weights = all(weights);
        let states = vec![T::of(0.0); weights.len()];
        Self::SidedPlays { sides, thresholds: all(thresholds), weights, line, states }
    }

    fn plane(range: [f64; 2], intervals: usize, cells: &[f64]) -> Result<Self, RealiseError> {
        let everett = all(sums(intervals, cells));
        let range = range.map(T::of);
        let density = Plane::new(range, intervals, &everett).map_err(|_| RealiseError::Rounded)?.density();
        Ok(Self::Plane { range, density, intervals, everett, turns: vec![Turn::none(); TURNS] })
    }

    /// The numbers, without the memory.
    pub(super) fn coefficients(&self) -> OperatorCoefficients<'_, T> {
        match self {
            Self::BoucWen { operators, .. } => OperatorCoefficients::BoucWen(operators),
            Self::Branch { law, weights, .. } => OperatorCoefficients::Branch { law: *law, weights },
            Self::Plays { thresholds, weights, .. } => OperatorCoefficients::Plays { thresholds, weights },
            Self::SidedPlays { sides, thresholds, weights, line, .. } => OperatorCoefficients::SidedPlays {
                sides: *sides,
                thresholds,
                weights,
                shares: &line.shares,
                corners: &line.corners,
                slopes: &line.slopes,
            },
            Self::ActivatedPlays { pace, range, thresholds, slopes, .. } => {
                OperatorCoefficients::ActivatedPlays { pace: *pace, range: *range, thresholds, slopes }
            }
            Self::Plane { range, density, intervals, everett, turns } => OperatorCoefficients::Plane {
                range: *range,
                density: *density,
                intervals: *intervals,
                everett,
                turns: turns.len(),
            },
        }
    }

    /// The operator on its memory.
    pub(super) fn operator(&mut self) -> Result<Operator<'_, T>, RealiseError> {
        let rounded = |_| RealiseError::Rounded;
        Ok(match self {
            Self::BoucWen { operators, memory } => Operator::BoucWen { operators, memory },
            Self::Branch { law, weights, memory } => Operator::Branch { law: *law, weights, memory },
            Self::Plays { thresholds, weights, states } => {
                Operator::Plays { bank: PlayBank::new(thresholds, weights).map_err(rounded)?, states }
            }
            Self::SidedPlays { sides, thresholds, weights, line, states } => {
                let mut plays = SidedPlays::new(*sides, thresholds, weights).map_err(rounded)?;
                if !line.slopes.is_empty() {
                    let line = BrokenLine::new(&line.shares, &line.corners, &line.slopes).map_err(rounded)?;
                    plays = plays.with_line(line).map_err(rounded)?;
                }
                Operator::SidedPlays { plays, states }
            }
            Self::ActivatedPlays { pace, range, thresholds, slopes, states } => Operator::ActivatedPlays {
                plays: ActivatedPlays::new(*pace, *range, thresholds, slopes).map_err(rounded)?,
                states,
            },
            Self::Plane { range, intervals, everett, turns, .. } => Operator::Plane {
                plane: Plane::new(*range, *intervals, everett).map_err(|_| RealiseError::Rounded)?,
                turns: Turns::new(turns),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_over_the_plane_by_counting_cells() {
        // Cells (0,0) 1; (1,0) 2, (1,1) 4; (2,0) 8, (2,1) 16, (2,2) 32.
        let got = sums(3, &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0]);
        assert_eq!(got, [1.0, 7.0, 4.0, 63.0, 52.0, 32.0]);
    }
}
