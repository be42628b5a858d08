//! Jiles and Atherton's model: its equation is linear in the effective field, and solved by its integral.

use super::law::{BranchLaw, Change, is_positive, law_numbers, single};
use super::rising_root;
use crate::increment::IncrementMemory;
use crate::real::{Real, Scalar};

law_numbers! {
    /// Quasi-static Jiles–Atherton: one state, the irreversible part p; what is put out is the magnetisation
    /// m = p + c (m_an − p), m_an = coth(h/a) − a/h, h = u + α m, dp/dh = s (m_an − p)/k where s (m_an − p) >
    /// 0, otherwise 0 (D. C. Jiles, D. L. Atherton 1986, doi:10.1016/0304-8853(86)90066-1). Exact to 1e-12
    /// for moves of up to [`MOST_PANELS`] − 2 times the smaller of a and k and twice α; longer ones are
    /// divided into [`MOST_PANELS`] parts whatever their length, eight Gauss points each.
    JilesAtherton {
        /// a > 0.
        anhysteretic,
        /// k > 0.
        pinning,
        /// c from 0 to 1.
        reversibility,
        /// α from 0 to below 3a.
        coupling,
    }
}

impl<T: Real> BranchLaw<T> for JilesAtherton<T> {
    const C: &'static str = include_str!("jiles_atherton.c");

    fn is_sound(&self, states: usize) -> bool {
        let Self { anhysteretic, pinning, reversibility, coupling } = *self;
        let shares = reversibility >= T::of(0.0) && reversibility <= T::of(1.0);
        let couples = coupling >= T::of(0.0) && coupling < T::of(3.0) * anhysteretic;
        states == 1 && is_positive(anhysteretic) && is_positive(pinning) && shares && couples
    }

    #[inline(always)]
    fn virgin(&self, u: T) -> T {
        self.shape().virgin(u)
    }

    #[inline(always)]
    fn output(&self, state: T, u: T) -> T {
        let shape = self.shape();
        shape.magnetisation(shape.frozen_field(u, state), state)
    }

    #[inline(always)]
    fn change(&self, memory: &[IncrementMemory<T>], from: T, to: T) -> Change<T> {
        Change::of_one(self.shape().change(single(memory), from, to))
    }
}

impl<T: Real> JilesAtherton<T> {
    #[inline(always)]
    fn shape(&self) -> Shape<T> {
        let Self { anhysteretic: a, pinning: k, reversibility: c, coupling: alpha } = *self;
        Shape { a, k, c, alpha }
    }
}

/// Parts of a move at most.
pub const MOST_PANELS: u8 = 32;

/// The eight Gauss–Legendre points on \[0, 1\] with their weights.
pub const GAUSS_LEGENDRE: [(f64, f64); 8] = [
    (0.019_855_071_751_231_884, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

/// a, k, c, α.
#[derive(Clone, Copy)]
struct Shape<T> {
    a: T,
    k: T,
    c: T,
    alpha: T,
}

impl<T: Real> Shape<T> {
    fn anhysteretic(self, field: T) -> T {
        langevin(field / self.a)
    }

    fn magnetisation(self, field: T, p: T) -> T {
        p + self.c * (self.anhysteretic(field) - p)
    }

    /// dm_an/dh.
    fn slope(self, field: T) -> T {
        langevin_slope(field / self.a) / self.a
    }

    /// p, virgin at `u`: on the anhysteretic curve, which is m where c = 1.
    fn virgin(self, u: T) -> T {
        let reversible = Shape { c: T::of(1.0), ..self };
        self.anhysteretic(reversible.frozen_field(u, T::of(0.0)))
    }

    /// h at the voltage u while p stays.
    fn frozen_field(self, u: T, p: T) -> T {
        let one = T::of(1.0);
        let most = if p.abs() > one { p.abs() } else { one };
        let reach = self.alpha * most * (one + T::of(16.0) * T::EPSILON);
        if reach <= T::of(0.0) {
            return u;
        }
        let excess =
            |h: T| (h - u - self.alpha * self.magnetisation(h, p), one - self.alpha * self.c * self.slope(h));
        rising_root(excess, u - reach, u + reach, u)
    }

    /// Δp while h moves by `way` from `field` in the direction of `sign`: x ∫ e^(−x(1−θ)) (m_an − p) dθ, x =
    /// way/k.
    fn relaxed(self, field: T, p: T, sign: T, way: T) -> T {
        let x = way / self.k;
        let mut sum = T::of(0.0);
        for (theta, weight) in GAUSS_LEGENDRE {
            let drawn = self.anhysteretic(field + sign * way * T::of(theta)) - p;
            sum = sum + (-(x * T::of(1.0 - theta))).exp() * drawn * T::of(weight);
        }
        x * sum
    }

    /// Δp of a move of the voltage.
    fn change(self, p: T, from: T, to: T) -> T {
        let (zero, one) = (T::of(0.0), T::of(1.0));
        let sign = if to < from { -one } else { one };
        let mut field = self.frozen_field(from, p);
        // Voltage still to go.
        let mut left = sign * (to - from);
        if sign * (self.anhysteretic(field) - p) < zero {
            // Frozen until m_an = p, where m = p as well.
            let frozen = self.frozen_field(to, p);
            if sign * (self.anhysteretic(frozen) - p) <= zero {
                return zero;
            }
            let (low, high) = if field < frozen { (field, frozen) } else { (frozen, field) };
            let meets = |h: T| (self.anhysteretic(h) - p, self.slope(h));
            field = rising_root(meets, low, high, T::of(0.5) * low + T::of(0.5) * high);
            left = sign * (to - (field - self.alpha * p));
        }
        // h moves as far as u and twice α at most.
        let shortest = if self.a < self.k { self.a } else { self.k };
        let part = (left.abs() + T::of(2.0) * self.alpha) / T::of(f64::from(MOST_PANELS));
        let panel = if part > shortest { part } else { shortest };
        let mut change = zero;
        for _ in 0..MOST_PANELS + 2 {
            let (start, now) = (self.anhysteretic(field), p + change);
            // What the voltage has passed `left` by once h has moved by `way`, and the slope.
            let gone = |way: T| {
                let h = field + sign * way;
                let moved = self.relaxed(field, now, sign, way);
                let drawn = self.anhysteretic(h);
                let magnetised = (one - self.c) * moved + self.c * (drawn - start);
                let frozen = one - self.alpha * self.c * self.slope(h);
                let slope = frozen - self.alpha * (one - self.c) * (drawn - now - moved) * sign / self.k;
                (way - self.alpha * sign * magnetised - left, slope)
            };
            let (beyond, _) = gone(panel);
            if beyond < zero {
                change = change + self.relaxed(field, now, sign, panel);
                field = field + sign * panel;
                left = -beyond;
                continue;
            }
            let way = rising_root(gone, zero, panel, left);
            return change + self.relaxed(field, now, sign, way);
        }
        T::of(f64::INFINITY)
    }
}

/// Langevin's function L(x) = coth x − 1/x; by its continued fraction x/(3 + x²/(5 + x²/(7 + …))) where that
/// settles soon.
#[inline]
pub fn langevin<S: Scalar>(x: S) -> S {
    let of = |x: f64| S::Real::of(x);
    if x.value().abs() < of(2.0) {
        let square = x * x;
        let tail = (1..=12_u8)
            .rev()
            .fold(S::constant(of(27.0)), |tail, k| (square / tail).shift(of(f64::from(2 * k + 1))));
        x / tail
    } else {
        let one = S::constant(of(1.0));
        one / x.tanh() - one / x
    }
}

/// L'(x) = 1 − L² − 2 L/x; 1/x² where the rest, 4 e^(−2|x|), is far below the last place.
pub fn langevin_slope<T: Real>(x: T) -> T {
    let (one, two) = (T::of(1.0), T::of(2.0));
    if x.abs() > T::of(50.0) {
        return one / (x * x);
    }
    let value = langevin(x);
    let ratio = if x.abs() < T::of(1e-8) { T::of(1.0 / 3.0) } else { value / x };
    one - value * value - two * ratio
}
