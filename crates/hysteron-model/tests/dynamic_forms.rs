//! Promise: a form's transfer function is what its parameters say, and its derivatives are exact.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::f64::consts::TAU;

use hysteron_model::dynamics::{
    Creep, DynamicForm, DynamicsError, Linearised, Modes, SecondOrder, Term, TermTangent, TransferFunction,
    stability,
};
use hysteron_numeric::Complex64;

const MODES: [Modes; 14] = [
    Modes::None,
    Modes::Integer { order: 1 },
    Modes::Integer { order: 2 },
    Modes::Integer { order: 3 },
    Modes::Integer { order: 4 },
    Modes::Fractional,
    Modes::FractionalFreeLowest,
    Modes::TwoFractional,
    Modes::Integer { order: 5 },
    Modes::Integer { order: 12 },
    Modes::Resonances { count: 1, lag: false },
    Modes::Resonances { count: 2, lag: true },
    Modes::Resonances { count: 3, lag: false },
    Modes::Resonances { count: 6, lag: true },
];

const CREEPS: [Creep; 5] = [
    Creep::None,
    Creep::Fractional,
    Creep::Logarithmic,
    Creep::KelvinVoigt { elements: 1 },
    Creep::KelvinVoigt { elements: 4 },
];

/// Every form with parameters of a plausible stage.
fn forms() -> Vec<(DynamicForm, Vec<f64>)> {
    let value = |name: &str| match name {
        "lag" => 4e-4,
        "natural_frequency" => 320.0,
        "damping" => 0.62,
        "order2" => 1.94,
        "order1" => 1.05,
        "order0" => 0.03,
        "natural_frequency_2" => 710.0,
        "damping_2" => 0.21,
        "order2_2" => 1.87,
        "order1_2" => 0.93,
        "share" => 0.7,
        "natural_frequency_3" => 820.0,
        "damping_3" => 0.04,
        "natural_frequency_4" => 1100.0,
        "damping_4" => 0.07,
        "natural_frequency_5" => 1500.0,
        "damping_5" => 0.02,
        "natural_frequency_6" => 2100.0,
        "damping_6" => 0.3,
        "share_2" => 0.2,
        "share_3" => -0.1,
        "share_4" => 0.05,
        "share_5" => 0.1,
        "creep" => 0.08,
        "creep_per_decade" => 0.02,
        "creep_start" => 0.01,
        "creep_1" => 0.05,
        "creep_time_1" => 0.003,
        "creep_2" => 0.03,
        "creep_time_2" => 0.1,
        "creep_3" => 0.02,
        "creep_time_3" => 1.0,
        "creep_4" => 0.01,
        "creep_time_4" => 40.0,
        "creep_order" => 0.12,
        other => panic!("{other}"),
    };
    let all = MODES.into_iter().flat_map(|modes| CREEPS.map(|creep| DynamicForm { modes, creep }));
    all.map(|form| (form, form.parameters().iter().map(|p| value(p.name)).collect())).collect()
}

fn near(found: Complex64, expected: Complex64, tolerance: f64) -> bool {
    (found - expected).norm() <= tolerance * expected.norm()
}

#[test]
fn fractional_is_the_second_order_form() {
    let (f, zeta, alpha2, alpha1) = (318.0, 0.65, 2.0384, 1.0523);
    let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
    let words =
        SecondOrder { gain: 1.0, natural_frequency_hz: f, damping: zeta, alpha2, alpha1, alpha0: 0.0 };
    let (found, expected) =
        (form.transfer_function(&[f, zeta, alpha2, alpha1]).unwrap(), words.to_transfer_function().unwrap());
    assert_eq!(found, expected);
}

#[test]
fn forms_are_the_products_and_sums_they_say() {
    for s in [Complex64::new(0.0, TAU * 3.0), Complex64::new(0.0, 2500.0), Complex64::new(300.0, 900.0)] {
        let pair = |f: f64, zeta: f64, a2: f64, a1: f64, a0: f64| {
            let omega = TAU * f;
            s.powf(a2) + 2.0 * zeta * omega.powf(a2 - a1) * s.powf(a1) + omega.powf(a2 - a0) * s.powf(a0)
        };
        let mode = |f: f64, zeta: f64, a2: f64, a1: f64| (TAU * f).powf(a2) / pair(f, zeta, a2, a1, 0.0);
        let lag = 1.0 / (1.0 + 4e-4 * s);
        let free = {
            let at = |s: Complex64| {
                let omega = TAU * 320.0;
                s.powf(1.94) + 1.24 * omega.powf(0.89) * s.powf(1.05) + omega.powf(1.91) * s.powf(0.03)
            };
            at(Complex64::new(0.0, TAU)).norm() / at(s)
        };
        let relaxation = |k: f64, tau: f64| k / (1.0 + tau * s);
        let creep = |creep| match creep {
            Creep::None => Complex64::ONE,
            Creep::Fractional => 1.0 + 0.08 * s.powf(-0.12),
            // ½ γ e^(−t₀/τ)/(1 + τ s) for τ = t₀ 10^(−1/2) … t₀ 10^6, the last with what lies beyond it.
            Creep::Logarithmic => (-1..=12).fold(Complex64::ONE, |sum, j| {
                let ratio = 10f64.powf(0.5 * f64::from(j));
                let tail = if j == 12 { 1.0 / (10f64.sqrt() - 1.0) } else { 0.0 };
                sum + relaxation(0.02 * 0.5 * (-1.0 / ratio).exp() * (1.0 + tail), 0.01 * ratio)
            }),
            Creep::KelvinVoigt { elements } => {
                let all = [(0.05, 0.003), (0.03, 0.1), (0.02, 1.0), (0.01, 40.0)];
                all[..elements].iter().fold(Complex64::ONE, |sum, &(k, tau)| sum + relaxation(k, tau))
            }
        };
        let resonance = |k: usize| {
            let (f, zeta) =
                [(320.0, 0.62), (710.0, 0.21), (820.0, 0.04), (1100.0, 0.07), (1500.0, 0.02), (2100.0, 0.3)]
                    [k];
            mode(f, zeta, 2.0, 1.0)
        };
        let fast = |modes| match modes {
            Modes::None => Complex64::ONE,
            Modes::Integer { order: 1 } => lag,
            Modes::Integer { order: 2 } => mode(320.0, 0.62, 2.0, 1.0),
            Modes::Integer { order } => {
                let pairs: Complex64 = (0..order / 2).map(resonance).product();
                if order % 2 == 1 { pairs * lag } else { pairs }
            }
            Modes::Resonances { count, lag: with_lag } => {
                let shares = [0.7, 0.2, -0.1, 0.05, 0.1];
                let last = 1.0 - shares[..count - 1].iter().sum::<f64>();
                let all = shares[..count - 1].iter().chain([&last]).enumerate();
                let sum: Complex64 = all.map(|(k, share)| share * resonance(k)).sum();
                if with_lag { sum * lag } else { sum }
            }
            Modes::Fractional => mode(320.0, 0.62, 1.94, 1.05),
            Modes::FractionalFreeLowest => free,
            Modes::TwoFractional => 0.7 * mode(320.0, 0.62, 1.94, 1.05) + 0.3 * mode(710.0, 0.21, 1.87, 0.93),
        };
        for (form, p) in forms() {
            let tf = form.transfer_function(&p).unwrap();
            let expected = fast(form.modes) * creep(form.creep);
            assert!(near(tf.response_at(s), expected, 1e-12), "{form:?} {s}: {tf}");
            assert!(form.creep != Creep::Fractional || tf.dc_gain().is_infinite());
            assert!(
                form.creep != Creep::None
                    || form.modes == Modes::FractionalFreeLowest
                    || (tf.dc_gain() - 1.0).abs() < 1e-14
            );
            assert!(!format!("{:?}", stability(&tf)).contains("Unstable"), "{form:?}");
        }
    }
}

#[test]
fn free_lowest_order_has_gain_one_at_one_hertz() {
    let form = DynamicForm { modes: Modes::FractionalFreeLowest, creep: Creep::None };
    let tf = form.transfer_function(&[320.0, 0.62, 1.94, 1.05, 0.036]).unwrap();
    assert!((tf.response_at(Complex64::new(0.0, TAU)).norm() - 1.0).abs() < 1e-14);
}

/// Eighth-order central difference of `f` at `x`, step `h`.
fn difference(f: impl Fn(f64) -> Complex64, x: f64, h: f64) -> Complex64 {
    let pair = |k: f64| f(x + k * h) - f(x - k * h);
    (pair(1.0) * 0.8 - pair(2.0) * 0.2 + pair(3.0) * (4.0 / 105.0) - pair(4.0) / 280.0) / h
}

/// dG at s along parameter `which`, from the derivatives of the terms.
fn tangent(linearised: &Linearised, which: usize, s: Complex64) -> Complex64 {
    let log = s.ln();
    let of = |terms: &[Term], tangents: &dyn Fn(usize) -> TermTangent| {
        let mut sums = (Complex64::ZERO, Complex64::ZERO);
        for (i, term) in terms.iter().enumerate() {
            let (power, t) = ((log * term.order).exp(), tangents(i));
            sums.0 += power * term.coefficient;
            sums.1 += power * (t.coefficient + log * t.weighted_order);
        }
        sums
    };
    let tf = &linearised.transfer_function;
    let (n, dn) = of(&tf.numerator, &|i| linearised.numerator_term(i)[which]);
    let (d, dd) = of(&tf.denominator, &|i| linearised.denominator_term(i)[which]);
    (dn - n / d * dd) / d
}

fn check_derivatives(form: DynamicForm, p: &[f64]) {
    let mut linearised = Linearised::new();
    form.linearise(p, &mut linearised).unwrap();
    assert_eq!(linearised.transfer_function, form.transfer_function(p).unwrap(), "{form:?}");
    assert_eq!(linearised.parameters(), p.len());
    for s in [Complex64::new(0.0, TAU * 3.0), Complex64::new(40.0, 2500.0)] {
        for (which, parameter) in form.parameters().iter().enumerate() {
            let at = |x: f64| {
                let mut p = p.to_vec();
                p[which] = x;
                form.transfer_function(&p).unwrap().response_at(s)
            };
            let expected = difference(at, p[which], 4e-3 * p[which]);
            let found = tangent(&linearised, which, s);
            // Rounding of G's terms over the step is what limits a derivative that is small beside them.
            let tf = &linearised.transfer_function;
            let size = |terms: &[Term]| -> f64 {
                terms.iter().map(|t| t.coefficient.abs() * s.norm().powf(t.order)).sum()
            };
            let below: Complex64 = tf.denominator.iter().map(|t| t.coefficient * s.powf(t.order)).sum();
            let g = at(p[which]).norm();
            let rounding = (size(&tf.numerator) + g * size(&tf.denominator)) / below.norm();
            let allowed = 1e-9 * expected.norm() + 1e-13 * rounding / p[which].abs();
            assert!((found - expected).norm() <= allowed, "{form:?} {}: {found} {expected}", parameter.name);
        }
    }
}

#[test]
fn derivatives_are_those_of_the_transfer_function() {
    for (form, p) in forms() {
        check_derivatives(form, &p);
    }
}

#[test]
fn coinciding_orders_are_merged_and_their_derivatives_stay_exact() {
    let form = DynamicForm { modes: Modes::TwoFractional, creep: Creep::Fractional };
    // Equal orders of both modes, and sums that meet: 1.5 + 0.5 = 2, 0.5 + 0.5 = 1.
    let p = [320.0, 0.62, 1.5, 0.5, 710.0, 0.21, 1.5, 0.5, 0.7, 0.08, 0.5];
    let tf = form.transfer_function(&p).unwrap();
    let orders: Vec<f64> = tf.denominator.iter().map(|term| term.order).collect();
    assert_eq!(orders, [0.5, 1.0, 1.5, 2.0, 2.5, 3.5]);
    check_derivatives(form, &p);
    // Middle and highest order in reverse, and equal.
    let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
    check_derivatives(form, &[320.0, 0.62, 0.8, 1.3]);
    check_derivatives(form, &[320.0, 0.62, 1.3, 1.3]);
}

#[test]
fn buffers_take_any_form_in_turn() {
    let (mut tf, mut linearised) = (TransferFunction::article_eq13(), Linearised::new());
    for (form, p) in forms().into_iter().chain(forms().into_iter().rev()) {
        form.write_to(&p, &mut tf).unwrap();
        form.linearise(&p, &mut linearised).unwrap();
        let mut fresh = Linearised::default();
        form.linearise(&p, &mut fresh).unwrap();
        assert_eq!((&tf, &linearised), (&fresh.transfer_function, &fresh), "{form:?}");
        assert_eq!(linearised.numerator_term(99), []);
    }
}

#[test]
fn refuses_what_is_no_candidate() {
    let fractional = DynamicForm { modes: Modes::Fractional, creep: Creep::Fractional };
    let good = [320.0, 0.62, 1.94, 1.05, 0.08, 0.12];
    assert!(fractional.transfer_function(&good).is_ok());
    let count = fractional.transfer_function(&good[..5]);
    assert_eq!(count, Err(DynamicsError::ParameterCount { expected: 6, found: 5 }));
    for (index, bad) in [(0, 0.0), (0, f64::INFINITY), (1, f64::NAN), (2, -0.1), (3, -1.0), (5, -0.1)] {
        let mut p = good;
        p[index] = bad;
        let name = fractional.parameters()[index].name;
        match fractional.transfer_function(&p) {
            Err(DynamicsError::Parameter { name: found, .. }) => assert_eq!(found, name),
            other => panic!("{name} {bad}: {other:?}"),
        }
        assert!(fractional.linearise(&p, &mut Linearised::new()).is_err());
    }
    for order in [0, 13] {
        let form = DynamicForm { modes: Modes::Integer { order }, creep: Creep::None };
        assert!(form.parameters().is_empty());
        assert!(matches!(form.transfer_function(&[]), Err(DynamicsError::Parameter { name: "order", .. })));
    }
    for number in [0, 7] {
        let modes = Modes::Resonances { count: number, lag: true };
        let creep = Creep::KelvinVoigt { elements: number };
        for form in [DynamicForm { modes, creep: Creep::None }, DynamicForm { modes: Modes::None, creep }] {
            let p = vec![1.0; form.parameter_count()];
            assert!(matches!(form.transfer_function(&p), Err(DynamicsError::Parameter { .. })), "{form:?}");
            assert!(matches!(
                form.linearise(&p, &mut Linearised::new()),
                Err(DynamicsError::Parameter { .. })
            ));
        }
    }
    let creep = DynamicForm { modes: Modes::None, creep: Creep::KelvinVoigt { elements: 1 } };
    assert!(creep.transfer_function(&[0.0, 1.0]).is_ok());
    for bad in [[-0.1, 1.0], [0.1, 0.0], [0.1, f64::INFINITY]] {
        assert!(matches!(creep.transfer_function(&bad), Err(DynamicsError::Parameter { .. })));
    }
}
