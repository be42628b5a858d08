//! Steppable plant of a validated truth: hysteresis state and partial fractions of the linear dynamics.

use std::f64::consts::TAU;

use rustfft::num_complex::Complex64;

use super::bouc_wen::BoucWenState;
use super::partial_fractions::{PartialFractions, PolePair, RealPole, Splitting};
use super::plays::PlayStates;
use super::roots::{power_sum, upper_zeros};
use super::truth::{BoucWenFractional, Plant, PlayStack};
use super::{PowerTerm, RigError};

/// The hysteresis block with its state.
pub(super) enum HysteresisState<'a> {
    Plays(PlayStates<'a>),
    BoucWen(BoucWenState<'a>),
}

impl HysteresisState<'_> {
    /// Output \[µm\] after the drive went monotonically to `drive_v`.
    pub fn step(&mut self, drive_v: f64) -> f64 {
        match self {
            HysteresisState::Plays(h) => h.step(drive_v),
            HysteresisState::BoucWen(h) => h.step(drive_v),
        }
    }
}

impl Plant {
    /// Virgin hysteresis at 0 V.
    pub(super) fn hysteresis(&self) -> HysteresisState<'_> {
        match self {
            Plant::PlayStack(p) => HysteresisState::Plays(PlayStates::new(
                &p.plays,
                p.linear_um_per_v,
                p.quadratic_per_um,
                p.cubic_per_um2,
            )),
            Plant::BoucWenFractional(p) => {
                HysteresisState::BoucWen(BoucWenState::new(&p.polynomial, p.alpha, p.beta, p.gamma, p.n))
            }
        }
    }

    /// Angular corner of the amplifier \[rad/s\].
    pub(super) fn amplifier_rad_s(&self) -> Option<f64> {
        match self {
            Plant::PlayStack(p) => p.amplifier_corner_hz.map(|f| TAU * f),
            Plant::BoucWenFractional(_) => None,
        }
    }

    /// The linear dynamics without delay, accurate for steps of `step_s`.
    pub(super) fn dynamics(&self, step_s: f64) -> Result<PartialFractions, RigError> {
        let band_rad_s = (1e-3, std::f64::consts::PI / step_s);
        match self {
            Plant::PlayStack(p) => p.dynamics(band_rad_s),
            Plant::BoucWenFractional(p) => p.dynamics(band_rad_s),
        }
    }
}

impl PlayStack {
    fn dynamics(&self, band_rad_s: (f64, f64)) -> Result<PartialFractions, RigError> {
        let total: f64 = self.modes.iter().map(|m| m.share).sum();
        let corner = self.creep.map_or(0.0, |c| TAU * c.corner_hz);
        let creep = |log: Complex64| match self.creep {
            Some(c) => (log * -c.order).exp() * c.strength + 1.0,
            None => Complex64::ONE,
        };
        let mechanics = |s: Complex64| -> Complex64 {
            self.modes
                .iter()
                .map(|m| {
                    let w = TAU * m.frequency_hz;
                    (s * s + s * (2.0 * m.damping * w) + w * w).inv() * (w * w * m.share / total)
                })
                .sum()
        };
        let pairs = self
            .modes
            .iter()
            .map(|m| {
                let w = TAU * m.frequency_hz;
                let damped = w * (1.0 - m.damping * m.damping).sqrt();
                let pole = Complex64::new(-m.damping * w, damped);
                let residue = Complex64::new(0.0, -w * w * m.share / total / (2.0 * damped));
                PolePair { pole, residue: residue * creep((pole + corner).ln()) }
            })
            .collect();
        let active = self.creep.is_some_and(|c| c.strength > 0.0);
        let static_gain = match self.creep {
            Some(c) if active => 1.0 + c.strength * corner.powf(-c.order),
            _ => 1.0,
        };
        PartialFractions::split(&Splitting {
            response: &|log| creep(log) * mechanics(log.exp() - corner),
            corner,
            pairs,
            isolated: Vec::new(),
            has_cut: active,
            static_gain,
            band_rad_s,
        })
    }
}

impl BoucWenFractional {
    fn dynamics(&self, band_rad_s: (f64, f64)) -> Result<PartialFractions, RigError> {
        let lowest = |terms: &[PowerTerm]| {
            terms
                .iter()
                .filter(|t| t.coefficient != 0.0)
                .min_by(|a, b| a.order.total_cmp(&b.order))
                .copied()
                .unwrap_or(PowerTerm { coefficient: 0.0, order: 0.0 })
        };
        let (first_up, first_down) = (lowest(&self.numerator), lowest(&self.denominator));
        let rise = first_down.order - first_up.order;
        if rise >= 1.0 {
            return Err(RigError::Unstable { re: 0.0, im: 0.0 });
        }
        let static_gain = if rise > 0.0 {
            f64::INFINITY
        } else if rise < 0.0 {
            0.0
        } else {
            first_up.coefficient / first_down.coefficient
        };
        let has_cut = self.numerator.iter().chain(&self.denominator).any(|t| t.order.fract() != 0.0);
        let mut pairs = Vec::new();
        let mut isolated = Vec::new();
        for log_pole in upper_zeros(&self.denominator) {
            let pole = log_pole.exp();
            if log_pole.im.abs() <= std::f64::consts::FRAC_PI_2 {
                return Err(RigError::Unstable { re: pole.re, im: pole.im });
            }
            // dD/ds = (dD/dL)/s.
            let (_, slope) = power_sum(&self.denominator, log_pole);
            let residue = power_sum(&self.numerator, log_pole).0 * pole / slope;
            if (log_pole.im - std::f64::consts::PI).abs() < 1e-9 {
                isolated.push(RealPole { rate: -pole.re, weight: residue.re });
            } else {
                pairs.push(PolePair { pole, residue });
            }
        }
        PartialFractions::split(&Splitting {
            response: &|log| power_sum(&self.numerator, log).0 / power_sum(&self.denominator, log).0,
            corner: 0.0,
            pairs,
            isolated,
            has_cut,
            static_gain,
            band_rad_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::truth::Truth;
    use super::*;

    const STEP_S: f64 = 5e-6;

    /// Unit step response of article Eq. 13, 16 digits, as in `step_response.rs` of `hysteron-model`.
    #[test]
    fn article_plant_has_the_reference_step_response() {
        let g = Truth::article().plant.dynamics(STEP_S).unwrap();
        let reference = [
            (1e-3, 0.6425473727342575),
            (5e-3, 0.9669591601584735),
            (1e-2, 0.9609188729670224),
            (5e-2, 0.9575970251960186),
            (1e-1, 0.9572563930286222),
        ];
        for (t, y) in reference {
            let error = g.step_response(t) / y - 1.0;
            assert!(error.abs() < 1e-8, "at {t} s relative error {error:e}");
        }
    }

    #[test]
    fn poles_and_cut_add_up_to_the_creeping_two_mode_plant() {
        let stack = PlayStack::default();
        let g = Plant::PlayStack(stack.clone()).dynamics(STEP_S).unwrap();
        let creep = stack.creep.unwrap();
        for f in [1e-3, 0.1, 1.0, 33.0, 474.0, 480.0, 1100.0, 3e4] {
            let s = Complex64::new(0.0, TAU * f);
            let mechanics: Complex64 = [(475.0, 0.03, 0.93), (1100.0, 0.02, 0.07)]
                .iter()
                .map(|&(f, z, share)| {
                    let w = TAU * f;
                    (s * s + s * (2.0 * z * w) + w * w).inv() * (w * w * share)
                })
                .sum();
            let slow = (s + TAU * creep.corner_hz).powf(-creep.order) * creep.strength + 1.0;
            let expected = slow * mechanics;
            // Tolerance relative to the resonance peak, about 16.
            assert!((g.response(s) - expected).norm() < 2e-8, "at {f} Hz");
        }
        assert!((g.response(Complex64::ZERO).re / g.static_gain - 1.0).abs() < 1e-6);
    }

    #[test]
    fn one_mode_has_the_textbook_step_response() {
        let stack = PlayStack {
            creep: None,
            modes: vec![super::super::Mode { frequency_hz: 475.0, damping: 0.03, share: 2.0 }],
            ..PlayStack::default()
        };
        let g = Plant::PlayStack(stack).dynamics(STEP_S).unwrap();
        let (w, z): (f64, f64) = (TAU * 475.0, 0.03);
        let wd = w * (1.0 - z * z).sqrt();
        for k in 0..60 {
            let t = f64::from(k) * 2.1e-4;
            let exact = 1.0 - (-z * w * t).exp() * ((wd * t).cos() + z * w / wd * (wd * t).sin());
            assert!((g.step_response(t) - exact).abs() < 1e-12);
        }
    }

    fn fractional(numerator: &[(f64, f64)], denominator: &[(f64, f64)]) -> Plant {
        let terms = |list: &[(f64, f64)]| {
            list.iter().map(|&(coefficient, order)| PowerTerm { coefficient, order }).collect()
        };
        Plant::BoucWenFractional(BoucWenFractional {
            polynomial: vec![1.0],
            alpha: 0.0,
            beta: 0.0,
            gamma: 0.0,
            n: 1.0,
            numerator: terms(numerator),
            denominator: terms(denominator),
            delay_s: 0.0,
        })
    }

    /// 1/(1 + √(s)): step response 1 − e^t erfc(√t); values to 16 digits from e·erfc(1) and e^0.25·erfc(0.5).
    #[test]
    fn half_order_relaxation_has_the_error_function_step_response() {
        let g = fractional(&[(1.0, 0.0)], &[(1.0, 0.0), (1.0, 0.5)]).dynamics(STEP_S).unwrap();
        assert!((g.step_response(1.0) - (1.0 - 0.427583576155807)).abs() < 1e-8);
        assert!((g.step_response(0.25) - (1.0 - 0.6156903441929259)).abs() < 1e-8);
    }

    #[test]
    fn biproper_free_lowest_order_and_rational_plants_are_split() {
        // (s^1.2 + 50)/(2 s^1.2 + 7 s^0.4 + 100) keeps a feedthrough of ½.
        let g = fractional(&[(50.0, 0.0), (1.0, 1.2)], &[(100.0, 0.0), (7.0, 0.4), (2.0, 1.2)]);
        let g = g.dynamics(STEP_S).unwrap();
        assert!((g.static_gain - 0.5).abs() < 1e-15);
        // Free lowest order: no finite static gain.
        let g = fractional(&[(5e6, 0.0)], &[(5.5e6, 0.036), (3081.0, 1.05), (1.0, 2.04)]);
        assert_eq!(g.dynamics(STEP_S).unwrap().static_gain, f64::INFINITY);
        // Rational, with a real pole: 6/((s + 1)(s + 2)): step 3 − 6e^(−t) + 3e^(−2t).
        let g = fractional(&[(6.0, 0.0)], &[(2.0, 0.0), (3.0, 1.0), (1.0, 2.0)]).dynamics(STEP_S).unwrap();
        let t: f64 = 0.8;
        let exact = 3.0 - 6.0 * (-t).exp() + 3.0 * (-2.0 * t).exp();
        assert!((g.step_response(t) - exact).abs() < 1e-12);
    }

    #[test]
    fn unstable_plants_are_refused() {
        let unstable = [
            fractional(&[(1.0, 0.0)], &[(-2.0, 0.0), (1.0, 1.0)]),
            fractional(&[(1.0, 0.0)], &[(1.0, 0.0), (-0.5, 1.1), (1.0, 2.1)]),
            fractional(&[(1.0, 0.0)], &[(1.0, 1.0), (1.0, 2.0)]),
        ];
        for plant in unstable {
            let error = plant.dynamics(STEP_S).unwrap_err();
            assert!(matches!(error, RigError::Unstable { .. }), "{error}");
        }
    }
}
