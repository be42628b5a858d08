//! The operator of `hysteron-rt` that runs a family, in its numbers.

use hysteron_rt::{Branch, Real, Sides};

use super::NumberUnit;

/// An operator of the runtime, in one type of numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum RuntimeOperator<T = f64> {
    /// v = l\[u\] − Σ zₖ, states in parallel ([`hysteron_rt::StateLaw`]).
    States {
        /// The parameters of each, in the order of [`hysteron_rt::StateLaw::PARAMETERS`].
        parameters: Vec<[T; 4]>,
        /// Their units.
        units: [NumberUnit; 4],
    },
    /// v = l\[u\] + Σ wⱼ yⱼ by one law on each branch.
    Branch {
        /// The law.
        law: Branch<T>,
        /// Weights wⱼ of its states.
        weights: Vec<T>,
    },
    /// v = l\[u\] + Σ wᵢ F_rᵢ\[u\], plays.
    Plays {
        /// Half-widths rᵢ \[V\].
        thresholds: Vec<T>,
        /// Weights wᵢ \[µm/V\].
        weights: Vec<T>,
    },
    /// v = l\[u\] + plays between other sides ([`hysteron_rt::SidedPlays`]), with a broken line of their mean
    /// where it has slopes.
    SidedPlays {
        /// Their sides.
        sides: Sides<T>,
        /// Thresholds, or the lines of their ramps.
        thresholds: Vec<T>,
        /// Weights.
        weights: Vec<T>,
        /// The broken line.
        line: MeanLine<T>,
    },
    /// v = l\[u\] + plays with thermally activated edges ([`hysteron_rt::RelaxingPlays`]).
    RelaxingPlays {
        /// Activation \[V\], and time between samples \[s\].
        pace: (T, T),
        /// Ends of the range of their slopes \[V\].
        range: [T; 2],
        /// Half-widths \[V\].
        thresholds: Vec<T>,
        /// Slopes, three per play.
        slopes: Vec<T>,
    },
    /// v = l\[u\] + a plane of relays ([`hysteron_rt::Plane`]).
    Plane {
        /// Lowest and highest level \[V\].
        range: [T; 2],
        /// Intervals between levels.
        intervals: usize,
        /// Sums of the cells with levels from q to p: (1, 0), (2, 0), (2, 1), (3, 0), … \[µm\].
        everett: Vec<T>,
    },
}

/// A broken line of the mean of plays; none without slopes.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanLine<T> {
    /// Shares of the plays in the mean.
    pub shares: Vec<T>,
    /// Corners \[V\].
    pub corners: Vec<T>,
    /// Slopes \[µm/V\], one more than corners.
    pub slopes: Vec<T>,
}

impl<T> MeanLine<T> {
    pub(in crate::hysteresis) fn none() -> Self {
        Self { shares: Vec::new(), corners: Vec::new(), slopes: Vec::new() }
    }
}

impl RuntimeOperator {
    pub(in crate::hysteresis) fn branch(law: impl Into<Branch<f64>>, weights: &[f64]) -> Self {
        Self::Branch { law: law.into(), weights: weights.to_vec() }
    }

    /// States of α \[µm/V\], β and γ \[µm¹⁻ⁿ/V\], and n.
    pub(in crate::hysteresis) fn states(parameters: Vec<[f64; 4]>) -> Self {
        let rate = NumberUnit::PER_INPUT_OF_EXPONENT;
        Self::States { parameters, units: [NumberUnit::SLOPE, rate, rate, NumberUnit::NONE] }
    }

    pub(in crate::hysteresis) fn sided(sides: Sides<f64>, thresholds: Vec<f64>, weights: &[f64]) -> Self {
        Self::SidedPlays { sides, thresholds, weights: weights.to_vec(), line: MeanLine::none() }
    }

    /// Weights of the `cells` in the order (0, 0), (1, 0), (1, 1), (2, 0), ….
    pub(in crate::hysteresis) fn plane(range: [f64; 2], intervals: usize, cells: &[f64]) -> Self {
        Self::Plane { range, intervals, everett: everett(intervals, cells) }
    }

    /// The numbers rounded to another type.
    pub(crate) fn rounded<T: Real>(self) -> RuntimeOperator<T> {
        let all = |numbers: Vec<f64>| numbers.into_iter().map(T::of).collect::<Vec<_>>();
        match self {
            Self::States { parameters, units } => RuntimeOperator::States {
                parameters: parameters.into_iter().map(|own| own.map(T::of)).collect(),
                units,
            },
            Self::Branch { law, weights } => {
                RuntimeOperator::Branch { law: law.map(T::of), weights: all(weights) }
            }
            Self::Plays { thresholds, weights } => {
                RuntimeOperator::Plays { thresholds: all(thresholds), weights: all(weights) }
            }
            Self::SidedPlays { sides, thresholds, weights, line } => RuntimeOperator::SidedPlays {
                sides: sides.map(T::of),
                thresholds: all(thresholds),
                weights: all(weights),
                line: MeanLine {
                    shares: all(line.shares),
                    corners: all(line.corners),
                    slopes: all(line.slopes),
                },
            },
            Self::RelaxingPlays { pace: (sigma, interval_s), range, thresholds, slopes } => {
                RuntimeOperator::RelaxingPlays {
                    pace: (T::of(sigma), T::of(interval_s)),
                    range: range.map(T::of),
                    thresholds: all(thresholds),
                    slopes: all(slopes),
                }
            }
            Self::Plane { range, intervals, everett } => {
                RuntimeOperator::Plane { range: range.map(T::of), intervals, everett: all(everett) }
            }
        }
    }
}

/// Σ of the cells with levels from q to p, in the order (1, 0), (2, 0), (2, 1), (3, 0), …; cells in theirs:
/// (0, 0), (1, 0), (1, 1), (2, 0), ….
fn everett(intervals: usize, cells: &[f64]) -> Vec<f64> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_over_the_plane_by_counting_cells() {
        // Cells (0,0) 1; (1,0) 2, (1,1) 4; (2,0) 8, (2,1) 16, (2,2) 32.
        let got = everett(3, &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0]);
        assert_eq!(got, [1.0, 7.0, 4.0, 63.0, 52.0, 32.0]);
    }
}
