//! Columns that are sums of plays, over a record.

mod bank;

use hysteron_rt::Scalar;

use super::HysteresisError;
use super::outputs::{self, Columns, PlayCourse};
use super::pass::{Every, at_rest};
use crate::record::range_of;
use crate::start::Start;
use bank::PlaysAbreast;

pub(in crate::hysteresis) use bank::STRETCH;

/// Checkpoints of a run are apart by this part of their distance from its beginning.
const APART: usize = 4;

/// Columns Hⱼ = Σᵢ Tᵢⱼ F_rᵢ\[u\] of plays in intervals: those of interval j have shares in columns j − 1 and j.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlaySums {
    /// Plays in an interval.
    pub(super) parts: usize,
    pub(super) thresholds: Vec<f64>,
    /// Tᵢⱼ of each play, in the columns below and above it.
    pub(super) shares: Vec<[f64; 2]>,
}

impl PlaySums {
    /// Columns of one play each.
    pub(super) fn single(thresholds: &[f64]) -> Self {
        Self { parts: 1, thresholds: thresholds.to_vec(), shares: vec![[0.0, 1.0]; thresholds.len()] }
    }

    fn columns(&self) -> usize {
        self.thresholds.len() / self.parts.max(1)
    }

    /// Sums of `plays` in every column.
    pub(super) fn sum<S: Scalar<Real = f64>>(&self, plays: &[S], out: &mut [S]) {
        out.fill(S::constant(0.0));
        for (index, (play, [below, above])) in plays.iter().zip(&self.shares).enumerate() {
            let interval = index / self.parts;
            if let Some(column) = interval.checked_sub(1) {
                out[column] = out[column] + play.scale(*below);
            }
            out[interval] = out[interval] + play.scale(*above);
        }
    }

    /// The plays before the first sample; `are_followed`: it is known which of them are still at a memory.
    fn at_start(
        &self,
        start: Start<f64>,
        u: &[f64],
        are_followed: bool,
    ) -> Result<PlaysAbreast, HysteresisError> {
        let at = |voltage, is_memory| {
            PlaysAbreast::new(self.parts, (&self.thresholds, &self.shares), (voltage, is_memory))
        };
        let plays = match at_rest(start, u)? {
            Some((rest, memory)) => {
                let mut plays = at(memory.unwrap_or(rest), are_followed && memory.is_some());
                plays.advance(&[rest], 1);
                plays
            }
            None => {
                // Exact after one period; plays that the drive never moves stay in the middle.
                let (low, high) = range_of(u);
                let mut plays = at(0.5 * low + 0.5 * high, false);
                plays.advance(u, u.len());
                plays
            }
        };
        if plays.is_finite() { Ok(plays) } else { Err(HysteresisError::Drive { index: 0 }) }
    }

    /// Runs the plays into the leading columns of `out`, which has the size of the record. In plain numbers:
    /// the derivative of a play with respect to the memory is 1 until the drive moves it, 0 from then on.
    pub(super) fn run(
        &self,
        factor: usize,
        u: &[f64],
        start: Start<f64>,
        derivatives: bool,
        out: &mut Columns,
    ) -> Result<(), HysteresisError> {
        let is_again = out.is_again;
        let before = out.course.take().filter(|before| is_again && before.thresholds == self.thresholds);
        if let Some(index) = u.iter().position(|u| !u.is_finite()) {
            return Err(HysteresisError::Drive { index });
        }
        let count = self.columns();
        let mut plays = self.at_start(start, u, true)?;
        let mut standing = Vec::new();
        if let Some((voltage, _)) = at_rest(start, u)? {
            let constants;
            (standing, constants) = plays.without_standing(range_of(u));
            plays.advance(&[voltage], 1);
            out.standing[..count].copy_from_slice(&constants[0]);
            out.standing_by_memory[..count].copy_from_slice(&constants[1]);
            let of = |values: &mut dyn Iterator<Item = f64>| values.last().unwrap_or(0.0);
            for column in 0..count {
                out.rest[column] = of(&mut plays.values(column));
                out.rest_by_memory[column] = of(&mut plays.by_memory(column));
            }
        }
        let is_known = |before: &PlayCourse| before.start == start && (before.is_derived || !derivatives);
        if before.as_ref().is_some_and(is_known) {
            out.course = before;
            out.changed.resize(count, 0);
            return Ok(());
        }
        let before = before.filter(|before| before.standing == standing);
        let mut states: Vec<Vec<f64>> = Vec::new();
        let Columns { values, by_memory, stop, .. } = out;
        let (values, by_memory) = (&mut values[..count], &mut by_memory[..count]);
        by_memory.iter_mut().for_each(Vec::clear);
        let mut changed = values.first().map_or(0, Vec::len);
        let mut next = 1;
        for (stretch, u) in u.chunks(STRETCH * factor).enumerate() {
            outputs::look(stop.as_ref())?;
            if stretch == next {
                let other = before.as_ref().and_then(|before| before.states.get(states.len()..));
                // From here on the values are those of the other memory.
                if let Some(rest @ [same, ..]) = other
                    && same == plays.states()
                    && !plays.are_some_still()
                {
                    states.extend_from_slice(rest);
                    changed = stretch * STRETCH;
                    break;
                }
                states.push(plays.states().to_vec());
                next = (next + 1).max(next + next / APART);
            }
            plays.advance(u, factor);
            for (column, values) in values.iter_mut().enumerate() {
                let here = &mut values[stretch * STRETCH..];
                here.iter_mut().zip(plays.values(column)).for_each(|(here, value)| *here = value);
            }
            if derivatives {
                for (column, values) in by_memory.iter_mut().enumerate() {
                    values.extend(plays.by_memory(column));
                }
            }
        }
        out.changed.resize(count, changed);
        let thresholds = self.thresholds.clone();
        out.course = Some(PlayCourse { thresholds, start, is_derived: derivatives, standing, states });
        Ok(())
    }
}

/// Columns that share the plays of a weighted sum, which the bank moves abreast.
const SHARING: usize = 8;

/// Adds the weighted sum of plays at every `factor`-th sample of the drive to `out`.
pub(super) fn add_weighted(
    (thresholds, weights): (&[f64], &[f64]),
    factor: usize,
    u: &[f64],
    start: Start<f64>,
    out: &mut [f64],
) -> Result<(), HysteresisError> {
    Every::new(factor)?;
    let expected = u.len().div_ceil(factor);
    if out.len() != expected {
        return Err(HysteresisError::Lengths { expected, found: out.len() });
    }
    if let Some(index) = u.iter().position(|u| !u.is_finite()) {
        return Err(HysteresisError::Drive { index });
    }
    // Filled up with plays of no weight.
    let parts = thresholds.len().div_ceil(SHARING).max(1);
    let of = |numbers: &[f64], play: usize| numbers.get(play).copied().unwrap_or(0.0);
    let all = 0..parts * SHARING;
    let sums = PlaySums {
        parts,
        thresholds: all.clone().map(|play| of(thresholds, play)).collect(),
        shares: all.map(|play| [0.0, of(weights, play)]).collect(),
    };
    let mut plays = sums.at_start(start, u, false)?;
    for ((out, u), stretch) in out.chunks_mut(STRETCH).zip(u.chunks(STRETCH * factor)).zip(0..) {
        plays.advance(u, factor);
        for column in 0..SHARING {
            out.iter_mut().zip(plays.values(column)).for_each(|(out, value)| *out += value);
        }
        if let Some(index) = out.iter().position(|out| !out.is_finite()) {
            return Err(HysteresisError::Overflow { index: (stretch * STRETCH + index) * factor });
        }
    }
    Ok(())
}
