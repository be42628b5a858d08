//! Operators whose states follow a differential equation along each branch. A new law needs a file with its C
//! fragment beside it, a `mod` line and a line in the list.

mod dahl;
mod duhem;
mod jiles_atherton;
mod law;
mod moments;
mod non_symmetric_bouc_wen;
mod root;
mod song_der_kiureghian;
mod takacs;

pub use jiles_atherton::MOST_PANELS;
pub use law::BranchLaw;
pub use moments::MOST_MOMENTS;

use crate::increment::IncrementMemory;
use crate::real::Real;

law::branch_laws! {
    dahl::Dahl,
    duhem::Duhem,
    non_symmetric_bouc_wen::NonSymmetricBoucWen,
    song_der_kiureghian::SongDerKiureghian,
    jiles_atherton::JilesAtherton,
    takacs::Takacs,
}

impl<T: Real> Branch<T> {
    /// Σ wⱼ yⱼ, virgin at `u`.
    pub(crate) fn output_at_rest(&self, weights: &[T], u: T) -> T {
        let state = self.virgin(u);
        weights.iter().fold(T::of(0.0), |sum, weight| sum + *weight * self.output(state, u))
    }

    /// Σ wⱼ yⱼ after a monotone move from `from` to `to`; no state changes.
    #[inline]
    pub(crate) fn look(&self, weights: &[T], memory: &[IncrementMemory<T>], from: T, to: T) -> T {
        let increments = self.increments_of(memory, from, to);
        let states = weights.iter().zip(memory).zip(increments);
        states.fold(T::of(0.0), |sum, ((weight, memory), increment)| {
            sum + *weight * self.output(memory.z() + increment, to)
        })
    }

    /// [`Self::look`] that also advances the states of the memory.
    #[inline]
    pub(crate) fn advance(&self, weights: &[T], memory: &mut [IncrementMemory<T>], from: T, to: T) -> T {
        let increments = self.increments_of(memory, from, to);
        let mut sum = T::of(0.0);
        for ((weight, memory), increment) in weights.iter().zip(memory).zip(increments) {
            sum = sum + *weight * self.output(memory.advance(increment), to);
        }
        sum
    }

    /// Change of every state along a monotone move.
    #[inline(always)]
    fn increments_of(&self, memory: &[IncrementMemory<T>], from: T, to: T) -> [T; MOST_MOMENTS] {
        let mut states = [T::of(0.0); MOST_MOMENTS];
        for (state, memory) in states.iter_mut().zip(memory) {
            *state = memory.z();
        }
        if let Some(states) = states.get_mut(..memory.len()) {
            self.increments(states, from, to);
        }
        states
    }
}
