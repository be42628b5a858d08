//! Jiles and Atherton's model: its equation is linear in the effective field, and solved by its integral.

use super::law::{BranchLaw, finite, law_numbers, number, positive};
use super::root::rising_root;
use crate::ParameterError;
use crate::real::{Real, Scalar};
use crate::series::signed;

law_numbers! {
    /// Quasi-static Jiles–Atherton: one state, the irreversible part p; the output is the magnetisation m =
    /// p + c (m_an − p), m_an = coth(h/a) − a/h, h = u + α m, dp/dh = s (m_an − p)/k where s (m_an − p) > 0,
    /// otherwise 0 (D. C. Jiles, D. L. Atherton 1986, doi:10.1016/0304-8853(86)90066-1). A move
    /// is divided into panels as long as the smaller of a and k, eight Gauss points each, and is exact to
    /// 1e-12 where |Δu| + 2α is up to [`MOST_PANELS`] times that length; longer ones are divided into
    /// [`MOST_PANELS`] longer panels. Panels of up to a tenth of that length have four points.
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

impl<S: Scalar> BranchLaw<S> for JilesAtherton<S> {
    const C: &'static str = include_str!("jiles_atherton.c");

    fn check(&self) -> Result<(), ParameterError<S::Real>> {
        let JilesAtherton { anhysteretic: a, pinning, reversibility: c, coupling: alpha } =
            self.map(S::value);
        let [zero, one, three] = [0.0, 1.0, 3.0].map(S::Real::of);
        positive("Jiles–Atherton a", a)?;
        positive("Jiles–Atherton k", pinning)?;
        finite("Jiles–Atherton coupling α", alpha)?;
        number("Jiles–Atherton c", c, c >= zero && c <= one, "from 0 to 1")?;
        let couples = alpha >= zero && alpha < three * a;
        number("Jiles–Atherton coupling α", alpha, couples, "at least 0 and less than 3a")
    }

    /// The demagnetised state lies on the anhysteretic curve, which is m where c = 1.
    #[inline]
    fn virgin(&self, u: S) -> S {
        let [zero, one] = [0.0, 1.0].map(|x| S::constant(S::Real::of(x)));
        self.m_an(JilesAtherton { reversibility: one, ..*self }.field(u, zero, u.value()))
    }

    #[inline]
    fn output(&self, p: S, u: S) -> S {
        self.magnetisation(self.field(u, p, u.value()), p)
    }

    #[inline]
    fn increment(&self, p: S, from: S, to: S) -> S {
        let field = self.field(from, p, from.value());
        let moved = self.magnetise(p, field, (from, to), MOST_PANELS);
        moved.map_or(S::constant(S::Real::of(f64::INFINITY)), |(increment, _)| increment)
    }
}

/// Most panels of a move.
pub const MOST_PANELS: u16 = 32;

/// The four Gauss–Legendre points on \[0, 1\] with their weights, enough for a panel of a tenth of the
/// smaller of a and k.
const FOUR: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The eight Gauss–Legendre points on \[0, 1\] with their weights.
const GAUSS_LEGENDRE: [(f64, f64); 8] = [
    (0.019_855_071_751_231_884, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

impl<S: Scalar> JilesAtherton<S> {
    /// m_an.
    #[inline]
    fn m_an(&self, field: S) -> S {
        langevin(field / self.anhysteretic)
    }

    /// m.
    #[inline]
    pub fn magnetisation(&self, field: S, p: S) -> S {
        p + self.reversibility * (self.m_an(field) - p)
    }

    /// h at the voltage u for constant p; Newton's method starts from `near`.
    #[inline]
    pub fn field(&self, u: S, p: S, near: S::Real) -> S {
        let one = S::Real::of(1.0);
        let law = self.map(S::value);
        let (at, own) = (u.value(), p.value());
        let most = if own.abs() > one { own.abs() } else { one };
        let reach = law.coupling * most * (one + S::Real::of(16.0) * S::Real::EPSILON);
        let root = if reach > S::Real::of(0.0) {
            let excess = |h| {
                let (m_an, slope) = law.m_an_with_slope(h);
                let m = own + law.reversibility * (m_an - own);
                (h - at - law.coupling * m, one - law.coupling * law.reversibility * slope)
            };
            rising_root(excess, at - reach, at + reach, near)
        } else {
            at
        };
        let slope = || one - law.coupling * law.reversibility * law.m_an_with_slope(root).1;
        S::implicit(root, slope, |h| h - u - self.coupling * self.magnetisation(h, p))
    }

    /// Δp while h moves by `way` from `field`: x ∫ e^(−x(1−θ)) (m_an − p) dθ, x = way/k.
    #[inline]
    fn relaxed(&self, field: S, p: S, down: bool, way: S) -> S {
        if way.value() <= S::Real::of(0.1) * self.shortest() {
            self.relaxed_by(&FOUR, field, p, (down, way))
        } else {
            self.relaxed_by(&GAUSS_LEGENDRE, field, p, (down, way))
        }
    }

    /// [`Self::relaxed`] by quadrature at these points.
    #[inline]
    fn relaxed_by<const N: usize>(
        &self,
        points: &[(f64, f64); N],
        field: S,
        p: S,
        (down, way): (bool, S),
    ) -> S {
        let x = way / self.pinning;
        let way = signed(way, down);
        let mut sum = S::constant(S::Real::of(0.0));
        for &(theta, weight) in points {
            let drawn = self.m_an(field + way.scale(S::Real::of(theta))) - p;
            let left = x.scale(S::Real::of(theta - 1.0)).exp();
            sum = sum + (left * drawn).scale(S::Real::of(weight));
        }
        x * sum
    }

    /// Δp, final m_an and change of the voltage for a change of the field by `way` from `field`, where m_an
    /// is `start`.
    #[inline(always)]
    fn gone(&self, [field, p, start, way]: [S; 4], down: bool) -> [S; 3] {
        let c = self.reversibility;
        let moved = self.relaxed(field, p, down, way);
        let m_an = self.m_an(field + signed(way, down));
        let magnetised = self.coupling * ((-c).shift(S::Real::of(1.0)) * moved + c * (m_an - start));
        [moved, m_an, way - signed(magnetised, down)]
    }

    /// The smaller of a and k.
    #[inline(always)]
    fn shortest(&self) -> S::Real {
        let (a, k) = (self.anhysteretic.value(), self.pinning.value());
        if a < k { a } else { k }
    }

    /// Δp and final field of a monotone move from `field`, in at most about `most_panels` panels as long as
    /// the smaller of a and k, or in so many equal, longer ones.
    #[inline]
    pub fn magnetise(&self, p: S, field: S, (from, to): (S, S), most_panels: u16) -> Option<(S, S)> {
        let [zero, one, half] = [0.0, 1.0, 0.5].map(S::Real::of);
        let law = self.map(S::value);
        let down = to.value() < from.value();
        let sign = signed(one, down);
        let drawn = |field: S, p: S| sign * (law.m_an(field.value()) - p.value());
        let mut field = field;
        // Remaining voltage.
        let mut left = signed(to - from, down);
        if drawn(field, p) < zero {
            // Frozen until m_an = p, where m = p as well.
            let frozen = self.field(to, p, field.value() + (to.value() - from.value()));
            if drawn(frozen, p) <= zero {
                return Some((S::constant(zero), frozen));
            }
            let (start, end, own) = (field.value(), frozen.value(), p.value());
            let (low, high) = if start < end { (start, end) } else { (end, start) };
            let meets = |h| {
                let (m_an, slope) = law.m_an_with_slope(h);
                (m_an - own, slope)
            };
            let root = rising_root(meets, low, high, half * low + half * high);
            field = S::implicit(root, || meets(root).1, |h| self.m_an(h) - p);
            left = signed(to - (field - self.coupling * p), down);
        }
        // |Δh| ≤ |Δu| + 2α.
        let part =
            (left.value().abs() + S::Real::of(2.0) * law.coupling) / S::Real::of(f64::from(most_panels));
        let panel = if part > self.shortest() { part } else { self.shortest() };
        let mut change = S::constant(zero);
        for _ in 0..most_panels.saturating_add(2) {
            let (start, now) = (self.m_an(field), p + change);
            let (from, own, wanted) = (field.value(), now.value(), left.value());
            let slope = |(m_an, m_an_slope): (S::Real, S::Real), moved: S::Real| {
                let frozen = one - law.coupling * law.reversibility * m_an_slope;
                let pulled = (m_an - own - moved) * sign / law.pinning;
                frozen - law.coupling * (one - law.reversibility) * pulled
            };
            // Voltage change for a change of the field, less the remaining voltage, and its slope.
            let excess = |way: S::Real| {
                let [moved, m_an, voltage] = law.gone([from, own, start.value(), way], down);
                let there = (m_an, slope_at((from + sign * way) / law.anhysteretic, m_an) / law.anhysteretic);
                (voltage - wanted, slope(there, moved))
            };
            let ends_within = excess(panel).0 >= zero;
            let way = if ends_within {
                let root = rising_root(excess, zero, panel, wanted);
                let function = |way| {
                    let [_, _, voltage] = self.gone([field, now, start, way], down);
                    voltage - left
                };
                S::implicit(root, || excess(root).1, function)
            } else {
                S::constant(panel)
            };
            let [moved, _, voltage] = self.gone([field, now, start, way], down);
            change = change + moved;
            field = field + signed(way, down);
            if ends_within {
                return Some((change, field));
            }
            left = left - voltage;
        }
        None
    }
}

impl<T: Real> JilesAtherton<T> {
    /// m_an and dm_an/dh.
    #[inline]
    fn m_an_with_slope(&self, field: T) -> (T, T) {
        let x = field / self.anhysteretic;
        let value = langevin(x);
        (value, slope_at(x, value) / self.anhysteretic)
    }
}

/// Langevin's function L(x) = coth x − 1/x; by its continued fraction x/(3 + x²/(5 + x²/(7 + …))) where that
/// converges fast.
#[inline]
fn langevin<S: Scalar>(x: S) -> S {
    let of = S::Real::of;
    let at = x.value();
    let value = if at.abs() < of(2.0) {
        let square = at * at;
        let tail = (1..=12_u8).rev().fold(of(27.0), |tail, k| square / tail + of(f64::from(2 * k + 1)));
        at / tail
    } else {
        of(1.0) / at.tanh() - of(1.0) / at
    };
    x.chain(value, slope_at(at, value))
}

/// L'(x) = 1 − L² − 2 L/x from L; 1/x² where the rest, 4 e^(−2|x|), is far below the last place.
#[inline(always)]
fn slope_at<T: Real>(x: T, value: T) -> T {
    let (one, two) = (T::of(1.0), T::of(2.0));
    if x.abs() > T::of(50.0) {
        return one / (x * x);
    }
    let ratio = if x.abs() < T::of(1e-8) { T::of(1.0 / 3.0) } else { value / x };
    one - value * value - two * ratio
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    /// A loop much wider than a and k: long panels and parts of short ones.
    #[test]
    fn a_move_is_the_sum_of_its_parts() {
        let law = JilesAtherton { anhysteretic: 0.2_f64, pinning: 0.1, reversibility: 0.3, coupling: 0.05 };
        let (mut p, mut u) = (0.0, 0.0);
        for to in [0.5, -0.3, 0.4] {
            let whole = law.increment(p, u, to);
            let (start, from) = (p, u);
            for k in 1..=400 {
                let next = from + (to - from) * f64::from(k) / 400.0;
                p += law.increment(p, u, next);
                u = next;
            }
            assert!((p - start - whole).abs() < 1e-11, "to {to}: {:e}", p - start - whole);
        }
    }

    #[test]
    fn derivatives_are_central_differences() {
        let numbers = [1.0, 0.5, 0.2, 0.8, 1.3];
        let moved = |[anhysteretic, pinning, reversibility, coupling, to]: [f64; 5]| {
            JilesAtherton { anhysteretic, pinning, reversibility, coupling }.increment(0.1, 0.2, to)
        };
        let at = |index: usize| Dual::<f64, 5>::variable(numbers[index], index);
        let law =
            JilesAtherton { anhysteretic: at(0), pinning: at(1), reversibility: at(2), coupling: at(3) };
        let found = law.increment(Dual::constant(0.1), Dual::constant(0.2), at(4));
        assert!((found.value - moved(numbers)).abs() < 1e-14);
        for (k, slope) in found.partials.into_iter().enumerate() {
            let beside = |step: f64| {
                let mut numbers = numbers;
                numbers[k] += step;
                moved(numbers)
            };
            let want = (beside(1e-5) - beside(-1e-5)) / 2e-5;
            assert!((slope - want).abs() < 1e-8, "{k}: {slope} {want}");
        }
    }

    #[test]
    fn langevin_function_by_its_series_and_by_its_definition() {
        for k in -400..=400_i32 {
            let x = f64::from(k) / 100.0;
            let value = langevin(x);
            let slope = slope_at(x, value);
            if x.abs() <= 0.5 {
                // x/3 − x³/45 + 2x⁵/945 − x⁷/4725 + 2x⁹/93555 − 1382x¹¹/638512875 …, next term 4x¹³/18243225.
                let c = [
                    1.0 / 3.0,
                    -1.0 / 45.0,
                    2.0 / 945.0,
                    -1.0 / 4725.0,
                    2.0 / 93555.0,
                    -1382.0 / 638_512_875.0,
                ];
                let want = x * c.iter().rev().fold(0.0, |sum, c| sum * x * x + c);
                assert!((value - want).abs() < 3e-11, "{x}");
            } else {
                assert!((value - (1.0 / x.tanh() - 1.0 / x)).abs() < 2e-15, "{x}");
                let want = 1.0 / (x * x) - 1.0 / libm::pow(libm::sinh(x), 2.0);
                assert!((slope - want).abs() < 1e-14, "{x}");
            }
        }
        assert_eq!((langevin(0.0), slope_at(0.0, 0.0)), (0.0, 1.0 - 2.0 / 3.0));
    }
}
