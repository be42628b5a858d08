//! Tuning of the feedback from the model, to stated margins.

use super::ControlError;
use super::law::{FeedbackKind, FeedbackLaw, Notch};
use super::margins::Margins;
use crate::realise::LinearRealisation;
use hysteron_numeric::{Complex64, Stopped};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Corners tried: this many per decade, from the lowest to a tenth of the sample rate.
const CORNERS_PER_DECADE: usize = 6;
const LOWEST_CORNER: f64 = 1e-5;
/// Orders tried.
const ORDERS: [f64; 7] = [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
/// Bisections of the search for a gain, and its initial bracket relative to the gain at which the loop
/// crosses 1.
const HALVINGS: usize = 40;
const GAINS: (f64, f64) = (1e-6, 1e2);

/// Required stability margins of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RequiredMargins {
    /// Least gain margin, a factor.
    pub gain: f64,
    /// Least phase margin \[degrees\].
    pub phase_deg: f64,
    /// Least |1 + L|.
    pub modulus: f64,
    /// Frequency \[Hz\] above which the phase of the model is not trusted: there |L| stays below 1/`gain`
    /// whatever its phase. `None`: it is trusted everywhere.
    pub trusted_to_hz: Option<f64>,
}

impl Default for RequiredMargins {
    /// A factor of 2 (6 dB), 60°, sensitivity at most 2.
    fn default() -> Self {
        Self { gain: 2.0, phase_deg: 60.0, modulus: 0.5, trusted_to_hz: None }
    }
}

/// A tuned law with its margins on the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// The law.
    pub law: FeedbackLaw,
    /// Margins of its loop.
    pub margins: Margins,
    /// √Σ |S|²/f over frequencies evenly spread on a logarithmic scale, S = 1/(1 + L): up to a factor, the
    /// residual of a random-walk disturbance (spectrum falling as 1/f²).
    pub left: f64,
}

/// Asked while a law is designed: an error ends the design.
pub type Still<'a> = &'a dyn Fn() -> Result<(), Stopped>;

/// Family of the feedback law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawFamily {
    /// k (1 + ω₀/s), or k/s.
    Pi,
    /// k (1 + (ω₀/s)^λ).
    FractionalPi,
    /// k/s behind a notch on the slowest resonance.
    NotchIntegral,
}

/// The law of a family with the smallest residual of a random-walk disturbance among those that keep the
/// margins.
///
/// Each form (corner, order) gets the largest gain that keeps them (as K. J. Åström, H. Panagopoulos, T.
/// Hägglund, *Automatica* 34 (1998) 585–601, doi:10.1016/S0005-1098(98)00011-9, do for PI with the
/// sensitivity alone; I. Podlubny, *IEEE Trans. Autom. Control* 44 (1999) 208–214, doi:10.1109/9.739144, for
/// PI^λ), the form with the smallest residual is kept. `plant` is the rest of the loop at rising frequencies
/// \[Hz\], the period of the computation included.
///
/// # Errors
/// [`ControlError`]; [`ControlError::Stopped`] where `still` ends it.
pub fn tune(
    family: LawFamily,
    plant: &[(f64, Complex64)],
    dynamics: &LinearRealisation,
    sample_rate_hz: f64,
    wanted: &RequiredMargins,
    still: Still<'_>,
) -> Result<Tuned, ControlError> {
    let decades = (0.1 / LOWEST_CORNER).log10();
    let count = (decades * CORNERS_PER_DECADE as f64).round() as usize;
    let corners = || {
        (0..=count).map(|k| sample_rate_hz * LOWEST_CORNER * 10f64.powf(decades * k as f64 / count as f64))
    };
    let mut best: Option<Tuned> = None;
    let mut consider = |unit: FeedbackLaw, shape: &dyn Fn(f64) -> Complex64| -> Result<(), Stopped> {
        still()?;
        let responses: Vec<(f64, Complex64)> = plant.iter().map(|(f, p)| (*f, shape(*f) * p)).collect();
        if let Some((gain, margins, left)) = largest_gain(&responses, wanted)
            && best.as_ref().is_none_or(|b| left < b.left)
        {
            best = Some(Tuned { law: unit.scaled(gain), margins, left });
        }
        Ok(())
    };
    match family {
        LawFamily::Pi => {
            let integral = FeedbackLaw::new(FeedbackKind::Integral, sample_rate_hz)?;
            consider(integral.clone(), &|f| integral.response(f))?;
            for corner_hz in corners() {
                let law = FeedbackLaw::new(FeedbackKind::Pi { corner_hz }, sample_rate_hz)?;
                consider(law.clone(), &|f| law.response(f))?;
            }
        }
        LawFamily::FractionalPi => {
            for order in ORDERS {
                for corner_hz in corners().step_by(2) {
                    let kind = FeedbackKind::FractionalPi { corner_hz, order };
                    let law = FeedbackLaw::new(kind, sample_rate_hz)?;
                    consider(law.clone(), &|f| law.response(f))?;
                }
            }
        }
        LawFamily::NotchIntegral => {
            let half = 0.5 * sample_rate_hz;
            let (frequency_hz, zeros) = resonance(dynamics, sample_rate_hz)
                .filter(|(f, _)| *f < half)
                .ok_or(ControlError::NoResonance)?;
            for poles in [0.3, 0.5, 0.7, 1.0] {
                let notch = Notch { frequency_hz, zeros, poles };
                let law = FeedbackLaw::new(FeedbackKind::NotchIntegral { notch }, sample_rate_hz)?;
                consider(law.clone(), &|f| law.response(f))?;
            }
        }
    }
    best.ok_or(ControlError::NoGain)
}

/// Frequency \[Hz\] and damping of the least damped pair of poles.
fn resonance(dynamics: &LinearRealisation, sample_rate_hz: f64) -> Option<(f64, f64)> {
    let pairs = dynamics.sections.iter().filter(|s| s.is_pair()).map(|s| {
        let pole = (1.0 - s.gain).ln() * sample_rate_hz;
        (pole.norm() / std::f64::consts::TAU, -pole.re / pole.norm())
    });
    pairs.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Largest gain up to which all margins are kept, those margins, and [`Tuned::left`].
fn largest_gain(shape: &[(f64, Complex64)], wanted: &RequiredMargins) -> Option<(f64, Margins, f64)> {
    // A scale: the gain at which the loop crosses 1 near a tenth of the sample rate.
    let middle = shape.get(shape.len() / 2)?.1.norm();
    let loops = |gain: f64| shape.iter().map(move |(f, l)| (*f, gain * l)).collect::<Vec<_>>();
    let keeps = |gain: f64| kept(&Margins::of(&loops(gain)), shape, gain, wanted);
    let (mut low, mut high) = (GAINS.0 / middle, GAINS.1 / middle);
    if !(low > 0.0 && high.is_finite() && keeps(low)) {
        return None;
    }
    for _ in 0..HALVINGS {
        let between = (low * high).sqrt();
        if keeps(between) {
            low = between
        } else {
            high = between
        }
        if high / low < 1.0 + 1e-6 {
            break;
        }
    }
    Some((low, Margins::of(&loops(low)), left(&loops(low))))
}

fn kept(margins: &Margins, shape: &[(f64, Complex64)], gain: f64, wanted: &RequiredMargins) -> bool {
    let trusted = wanted.trusted_to_hz.is_none_or(|from| {
        shape.iter().filter(|(f, _)| *f > from).all(|(_, l)| (gain * l).norm() <= 1.0 / wanted.gain)
    });
    trusted
        && margins.is_stable
        && margins.gain >= wanted.gain
        && margins.phase_deg >= wanted.phase_deg
        && margins.modulus >= wanted.modulus
}

fn left(points: &[(f64, Complex64)]) -> f64 {
    // ∫ |S|²/f² df, by the trapezoidal rule.
    let density = |(f, l): &(f64, Complex64)| (1.0 + l).norm_sqr().recip() / (f * f);
    points.windows(2).map(|p| 0.5 * (density(&p[0]) + density(&p[1])) * (p[1].0 - p[0].0)).sum::<f64>().sqrt()
}

/// The largest gain of a disturbance observer that keeps the margins, and the margins of its loop: S = 1 − G
/// g q/(1 − (1 − g) q), G the response of the displacement to its correction, q the one-period computation
/// delay. On the model it is stable at any gain; the margins bound the error of the model.
///
/// # Errors
/// [`ControlError::NoGain`].
pub fn tune_observer(
    correction: &[(f64, Complex64)],
    sample_rate_hz: f64,
    wanted: &RequiredMargins,
) -> Result<(f64, Margins), ControlError> {
    let margins = |gain: f64| {
        let loops: Vec<(f64, Complex64)> = correction
            .iter()
            .map(|(f, g)| {
                let late = Complex64::from_polar(1.0, -std::f64::consts::TAU * f / sample_rate_hz);
                let rejected = g * late * gain / (1.0 - (1.0 - gain) * late);
                (*f, rejected / (1.0 - rejected))
            })
            .collect();
        let found = Margins { is_stable: true, ..Margins::of(&loops) };
        (kept(&found, &loops, 1.0, wanted), found)
    };
    let (mut low, mut high) = (1e-6_f64, 1.0);
    if margins(high).0 {
        return Ok((high, margins(high).1));
    }
    if !margins(low).0 {
        return Err(ControlError::NoGain);
    }
    for _ in 0..HALVINGS {
        let between = (low * high).sqrt();
        if margins(between).0 { low = between } else { high = between }
    }
    Ok((low, margins(low).1))
}
