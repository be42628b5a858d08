//! Feedback laws: PI, PI^λ, integral with a notch, in parallel form.

use std::f64::consts::TAU;

use hysteron_rt::{Feedback, Real};

use super::ControlError;
use crate::dynamics::{Dynamics, TransferFunction};
use crate::fractional::{Scheme, Term};
use crate::hammerstein::Model;
use crate::hysteresis::Hysteresis;
use crate::realise::{LinearParts, LinearRealisation, RealiseOptions, held};
use crate::record::InterSample;
use hysteron_numeric::Complex64;

/// Lowest frequency of a fractional integral, as a share of its corner; below, the integral is of integer
/// order.
const FRACTIONAL_DECADES: f64 = 1e-3;
/// Accuracy of its poles, as a share of its largest gain.
const ACCURACY: f64 = 1e-5;

/// Notch (s² + 2 ζ₀ ω s + ω²)/(s² + 2 ζ₁ ω s + ω²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Notch {
    /// ω/2π \[Hz\].
    pub frequency_hz: f64,
    /// ζ₀, the resonance's damping.
    pub zeros: f64,
    /// ζ₁, the damping that replaces it.
    pub poles: f64,
}

/// Form of a feedback law, without its gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FeedbackKind {
    /// 1/s.
    Integral,
    /// 1 + ω₀/s.
    Pi {
        /// ω₀/2π \[Hz\].
        corner_hz: f64,
    },
    /// 1 + (ω₀/s)^λ, continued by an integer-order integral three decades below ω₀.
    FractionalPi {
        /// ω₀/2π \[Hz\].
        corner_hz: f64,
        /// λ.
        order: f64,
    },
    /// 1/s behind a notch.
    NotchIntegral {
        /// The notch.
        notch: Notch,
    },
}

/// c = k (e + Σ …): a feedback law at one sample rate.
#[derive(Clone, Debug, PartialEq)]
pub struct FeedbackLaw {
    /// Its form.
    pub kind: FeedbackKind,
    /// Gain on the error.
    pub proportional: f64,
    /// Gain on the sum of errors × sample period \[1/s\].
    pub integral_per_s: f64,
    /// Remaining poles.
    pub dynamics: LinearRealisation,
    /// The rate \[Hz\].
    pub sample_rate_hz: f64,
}

impl FeedbackLaw {
    /// The form with the gain 1 (1/s for the integrals).
    ///
    /// # Errors
    /// [`ControlError`]: a number out of range, poles that were not found.
    pub fn new(kind: FeedbackKind, sample_rate_hz: f64) -> Result<Self, ControlError> {
        if !(sample_rate_hz.is_finite() && sample_rate_hz > 0.0) {
            return Err(ControlError::Number { name: "sample rate [Hz]", value: sample_rate_hz });
        }
        let below_half = |name, f: f64| {
            let sound = f > 0.0 && f < 0.5 * sample_rate_hz;
            if sound { Ok(TAU * f) } else { Err(ControlError::Number { name, value: f }) }
        };
        let (proportional, integral_per_s, dynamics) = match kind {
            FeedbackKind::Integral => (0.0, 1.0, None),
            FeedbackKind::Pi { corner_hz } => (1.0, below_half("corner [Hz]", corner_hz)?, None),
            FeedbackKind::FractionalPi { corner_hz, order } => {
                if !(order > 0.0 && order < 1.0) {
                    return Err(ControlError::Number { name: "order of the integral", value: order });
                }
                let corner = below_half("corner [Hz]", corner_hz)?;
                let low = FRACTIONAL_DECADES * corner_hz;
                // Equal magnitudes where the integer-order integral takes over.
                let rest = (TAU * low) * (corner / (TAU * low)).powf(order);
                let shape =
                    TransferFunction::new(vec![term(corner.powf(order), 0.0)], vec![term(1.0, order)])?;
                (1.0, rest, Some((shape, Some(low))))
            }
            FeedbackKind::NotchIntegral { notch } => {
                let omega = below_half("notch [Hz]", notch.frequency_hz)?;
                for (name, value) in
                    [("damping of the zeros", notch.zeros), ("damping of the poles", notch.poles)]
                {
                    if !(value >= 0.0 && value.is_finite()) {
                        return Err(ControlError::Number { name, value });
                    }
                }
                // N/s = 1/s + 2 (ζ₀ − ζ₁) ω/(s² + 2 ζ₁ ω s + ω²).
                let shape = TransferFunction::new(
                    vec![term(2.0 * (notch.zeros - notch.poles) * omega, 0.0)],
                    vec![term(omega * omega, 0.0), term(2.0 * notch.poles * omega, 1.0), term(1.0, 2.0)],
                )?;
                (0.0, 1.0, Some((shape, None)))
            }
        };
        let model = |dynamics| -> Result<Model, ControlError> {
            Ok(Model {
                hysteresis: Hysteresis::without_memory(vec![1.0])?,
                dynamics,
                offset: 0.0,
                delay_s: 0.0,
                scheme: Scheme::BandLimited,
                inter_sample: InterSample::Hold,
                sample_rate_hz: None,
            })
        };
        let (dynamics, lowest_frequency_hz) = match dynamics {
            None => (Dynamics::None, None),
            Some((shape, low)) if shape.denominator.iter().all(|t| t.order.fract() == 0.0) => {
                (Dynamics::Integer(shape), low)
            }
            Some((shape, low)) => (Dynamics::Fractional(shape), low),
        };
        let is_none = dynamics == Dynamics::None;
        let options = RealiseOptions { accuracy: ACCURACY, lowest_frequency_hz };
        let mut dynamics = held(&model(dynamics)?, sample_rate_hz, &options)?;
        if is_none {
            dynamics.taps = vec![0.0];
        }
        Ok(Self { kind, proportional, integral_per_s, dynamics, sample_rate_hz })
    }

    /// This law with `gain` times the gain.
    #[must_use]
    pub fn scaled(mut self, gain: f64) -> Self {
        self.proportional *= gain;
        self.integral_per_s *= gain;
        self.dynamics.taps.iter_mut().for_each(|tap| *tap *= gain);
        self.dynamics.sections.iter_mut().for_each(|section| section.weight *= gain);
        self.dynamics.reference_gain *= gain.abs();
        self.dynamics.rest_gain *= gain;
        self
    }

    /// Response from error to correction at a frequency \[Hz\], without the one-period computation delay.
    pub fn response(&self, frequency_hz: f64) -> Complex64 {
        let theta = TAU * frequency_hz / self.sample_rate_hz;
        let late = Complex64::from_polar(1.0, -theta);
        self.proportional
            + self.integral_per_s / self.sample_rate_hz / (1.0 - late)
            + self.dynamics.response(frequency_hz, self.sample_rate_hz)
    }
}

fn term(coefficient: f64, order: f64) -> Term {
    Term { coefficient, order }
}

/// Coefficients and memory of a feedback law in one number type.
#[derive(Clone, Debug)]
pub struct FeedbackParts<T> {
    proportional: T,
    integral: T,
    dynamics: LinearParts<T>,
}

impl<T: Real> FeedbackParts<T> {
    /// The parts of a law, rounded to `T`.
    pub fn new(law: &FeedbackLaw) -> Self {
        Self {
            proportional: T::of(law.proportional),
            integral: T::of(law.integral_per_s / law.sample_rate_hz),
            dynamics: LinearParts::new(&law.dynamics),
        }
    }

    /// The controller, at rest.
    ///
    /// # Errors
    /// [`ControlError::Realise`] where the coefficients are not finite in this number type.
    pub fn feedback(&mut self) -> Result<Feedback<'_, T>, ControlError> {
        let rounded = |_| ControlError::Realise(crate::realise::RealiseError::Rounded);
        let dynamics = self.dynamics.block().map_err(rounded)?;
        Feedback::new(self.proportional, self.integral, dynamics).map_err(rounded)
    }
}
