//! Operators whose state follows a differential equation along each branch: Dahl, Duhem, asymmetric Bouc–Wen, Jiles–Atherton.

mod asymmetric;
mod duhem;
mod jiles_atherton;
mod root;

pub use duhem::{MOST_MOMENTS, moments};
pub use jiles_atherton::{GAUSS_LEGENDRE, MOST_PANELS, langevin, langevin_slope};
pub use root::rising_root;

use crate::increment::IncrementMemory;
use crate::real::Real;
use crate::series::{log_distance, relaxation};
use jiles_atherton::Shape;

/// The law of one branch; states y, weights w, v = Σ wⱼ yⱼ. s = sign Δu.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Branch<T> {
    /// dy/du = (1 − s y/`reach`)^`exponent` (P. R. Dahl 1976, doi:10.2514/3.61511): one state, exact.
    Dahl {
        /// Where y saturates, > 0.
        reach: T,
        /// Exponent, ≥ 0.
        exponent: T,
    },
    /// dyⱼ/du = uʲ − s `rate` yⱼ, j = 0, 1, … (B. D. Coleman, M. L. Hodgdon 1987, doi:10.1007/BF00282052): [`MOST_MOMENTS`] states at most, exact.
    Duhem {
        /// b > 0.
        rate: T,
    },
    /// dy/du = 1 − (β s + γ sgn y) y + δ s u, β ≥ |γ| (W. Zhu, D.-H. Wang 2012, doi:10.1016/j.sna.2012.03.048): one state, exact.
    NonSymmetric {
        /// β > 0.
        beta: T,
        /// γ.
        gamma: T,
        /// δ.
        delta: T,
    },
    /// dy/du = 1 − |y| (β₁ sgn(u̇y) + β₂ sgn(u u̇) + β₃ sgn(uy) + β₄ s + β₅ sgn y + β₆ sgn u) (J. Song, A. Der Kiureghian 2006,
    /// doi:10.1061/(ASCE)0733-9399(2006)132:6(610)): one state, exact.
    SongDerKiureghian {
        /// β₁ … β₆.
        betas: [T; 6],
    },
    /// Quasi-static Jiles–Atherton: one state, the irreversible part p; what is put out is the magnetisation m = p + c (m_an − p),
    /// m_an = coth(h/a) − a/h, h = u + α m, dp/dh = s (m_an − p)/k where s (m_an − p) > 0, otherwise 0 (D. C. Jiles, D. L. Atherton 1986,
    /// doi:10.1016/0304-8853(86)90066-1). Exact to 1e-12 for moves of up to [`MOST_PANELS`] − 2 times the smaller of a and k and twice α; longer ones are
    /// divided into [`MOST_PANELS`] parts whatever their length, eight Gauss points each.
    JilesAtherton {
        /// a > 0.
        anhysteretic: T,
        /// k > 0.
        pinning: T,
        /// c from 0 to 1.
        reversibility: T,
        /// α from 0 to below 3a.
        coupling: T,
    },
}

/// What a move changes states by: yⱼ by ownⱼ − lost yⱼ.
struct Change<T> {
    lost: T,
    own: [T; MOST_MOMENTS],
}

impl<T: Copy> Branch<T> {
    /// The law with other numbers, or with these in another type.
    pub fn map<U>(self, of: impl Fn(T) -> U) -> Branch<U> {
        match self {
            Self::Dahl { reach, exponent } => Branch::Dahl { reach: of(reach), exponent: of(exponent) },
            Self::Duhem { rate } => Branch::Duhem { rate: of(rate) },
            Self::NonSymmetric { beta, gamma, delta } => {
                Branch::NonSymmetric { beta: of(beta), gamma: of(gamma), delta: of(delta) }
            }
            Self::SongDerKiureghian { betas } => Branch::SongDerKiureghian { betas: betas.map(&of) },
            Self::JilesAtherton { anhysteretic, pinning, reversibility, coupling } => Branch::JilesAtherton {
                anhysteretic: of(anhysteretic),
                pinning: of(pinning),
                reversibility: of(reversibility),
                coupling: of(coupling),
            },
        }
    }
}

impl<T: Real> Branch<T> {
    /// Whether the numbers are finite and in order, and the law has so many states.
    pub(crate) fn is_sound(&self, states: usize) -> bool {
        let zero = T::of(0.0);
        let positive = |x: T| x.is_finite() && x > zero;
        let single = states == 1;
        match *self {
            Self::Dahl { reach, exponent } => {
                single && positive(reach) && exponent.is_finite() && exponent >= zero
            }
            Self::Duhem { rate } => positive(rate) && states <= MOST_MOMENTS,
            Self::NonSymmetric { beta, gamma, delta } => {
                single && positive(beta) && beta >= gamma.abs() && delta.is_finite()
            }
            Self::SongDerKiureghian { betas } => single && betas.iter().all(|beta| beta.is_finite()),
            Self::JilesAtherton { anhysteretic, pinning, reversibility, coupling } => {
                let shares = reversibility >= zero && reversibility <= T::of(1.0);
                let couples = coupling >= zero && coupling < T::of(3.0) * anhysteretic;
                single && positive(anhysteretic) && positive(pinning) && shares && couples
            }
        }
    }

    /// The states, virgin at `u`: all the same.
    pub(crate) fn virgin(&self, u: T) -> T {
        match self.magnetic() {
            Some(shape) => shape.virgin(u),
            None => T::of(0.0),
        }
    }

    /// Σ wⱼ yⱼ, virgin at `u`.
    pub(crate) fn output_at_rest(&self, weights: &[T], u: T) -> T {
        let state = self.virgin(u);
        weights.iter().fold(T::of(0.0), |sum, weight| sum + *weight * self.output(state, u))
    }

    /// Σ wⱼ yⱼ after a monotone move from `from` to `to`; nothing is moved.
    #[inline]
    pub(crate) fn look(&self, weights: &[T], memory: &[IncrementMemory<T>], from: T, to: T) -> T {
        let Change { lost, own } = self.change(memory, from, to);
        let states = weights.iter().zip(memory).zip(own);
        states.fold(T::of(0.0), |sum, ((weight, memory), own)| {
            let y = memory.z();
            sum + *weight * self.output(y + (own - lost * y), to)
        })
    }

    /// As [`Self::look`], and the states of the memory make the move.
    #[inline]
    pub(crate) fn advance(&self, weights: &[T], memory: &mut [IncrementMemory<T>], from: T, to: T) -> T {
        let Change { lost, own } = self.change(memory, from, to);
        let mut sum = T::of(0.0);
        for ((weight, memory), own) in weights.iter().zip(memory).zip(own) {
            let y = memory.advance(own - lost * memory.z());
            sum = sum + *weight * self.output(y, to);
        }
        sum
    }

    /// What a state puts out at `u`.
    #[inline(always)]
    fn output(&self, state: T, u: T) -> T {
        match self.magnetic() {
            Some(shape) => shape.magnetisation(shape.frozen_field(u, state), state),
            None => state,
        }
    }

    #[inline(always)]
    fn magnetic(&self) -> Option<Shape<T>> {
        match *self {
            Self::JilesAtherton { anhysteretic: a, pinning: k, reversibility: c, coupling: alpha } => {
                Some(Shape { a, k, c, alpha })
            }
            _ => None,
        }
    }

    #[inline(always)]
    fn change(&self, memory: &[IncrementMemory<T>], from: T, to: T) -> Change<T> {
        let zero = T::of(0.0);
        let first = memory.first().map_or(zero, IncrementMemory::z);
        let mut own = [zero; MOST_MOMENTS];
        let alone = match *self {
            Self::Duhem { rate } => return duhem::change(rate, memory.len(), from, to),
            Self::Dahl { reach, exponent } => dahl([reach, exponent], first, to - from),
            Self::NonSymmetric { beta, gamma, delta } => {
                asymmetric::non_symmetric([beta, gamma, delta], first, from, to)
            }
            Self::SongDerKiureghian { betas } => asymmetric::song_der_kiureghian(betas, first, from, to),
            Self::JilesAtherton { .. } => self.magnetic().map_or(zero, |shape| shape.change(first, from, to)),
        };
        if let Some(slot) = own.first_mut() {
            *slot = alone;
        }
        Change { lost: zero, own }
    }
}

/// With x = 1 − s y/reach: x ← x exp(−ln(1 + (i − 1) q)/(i − 1)), q = xⁱ⁻¹ |Δ|/reach, through i = 1 without a seam; for i < 1 x comes to 0 and stays.
#[inline]
fn dahl<T: Real>([reach, exponent]: [T; 2], y: T, by: T) -> T {
    let (zero, one) = (T::of(0.0), T::of(1.0));
    let turn = |x: T| if by < zero { -x } else { x };
    let x = one - turn(y) / reach;
    if x <= zero {
        return turn(reach * x);
    }
    let over = exponent - one;
    let q = x.powf(over) * (turn(by) / reach);
    let lost = if over * q > -one { relaxation(one, log_distance(over, q)).1 } else { one };
    turn(reach * (x * lost))
}
