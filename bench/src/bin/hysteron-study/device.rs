//! Devices in the model class, with the model that describes each exactly.

use hysteron_model::dynamics::{Dynamics, Scheme, SecondOrder, Term, TransferFunction, stability};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::record::InterSample;
use hysteron_rig::{BoucWenFractional, Plant, PowerTerm, Truth};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::Outcome;

/// Highest voltage of the drives \[V\]; the lowest is 0.
pub const HIGH_V: f64 = 10.0;

/// A device: Bouc–Wen hysteresis, then a fractional pair of gain 1 at zero frequency, then a delay.
#[derive(Clone, Debug)]
pub struct Device {
    pub hysteresis: BoucWen,
    pub dynamics: SecondOrder,
    pub delay_s: f64,
}

impl Device {
    /// The article's device (Table 2, Eq. 13) with the gain at zero frequency put to 1, and a delay.
    pub fn article() -> Outcome<Self> {
        let term = |coefficient, order| Term { coefficient, order };
        let g = TransferFunction {
            numerator: vec![term(5.4955e6, 0.0)],
            denominator: vec![term(5.4955e6, 0.0), term(3081.0, 1.0523), term(1.0, 2.0384)],
        };
        Ok(Self {
            hysteresis: BoucWen::new(vec![2.0, 0.0031], -1.2039, 0.1111, 0.0024, 1.0)?,
            dynamics: g.second_order()?,
            delay_s: 2.3e-4,
        })
    }

    /// A device drawn at random (`seed`) from wide ranges; never an unstable one.
    ///
    /// Stroke 10 to 50 µm at 10 V before hysteresis, bent by up to 15 % and 10 %; loops of either sense, of a
    /// tenth to a half of that, closed on themselves by 0.8 to 12 time constants over the range; 120 to 1500
    /// Hz; orders 1.75 to 2.1 and 0.6 to 1.2; delays up to 0.5 ms.
    pub fn random(seed: u64) -> Outcome<Self> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut uniform = |low: f64, high: f64| {
            const UNIT: f64 = 1.0 / (1u64 << 53) as f64;
            low + (high - low) * ((rng.next_u64() >> 11) as f64 * UNIT)
        };
        loop {
            let linear = log(uniform(0.0, 1.0), 1.0, 5.0);
            let degree = 1 + uniform(0.0, 3.0) as usize;
            let bend = [uniform(-0.15, 0.15) * linear / HIGH_V, uniform(-0.1, 0.1) * linear / HIGH_V.powi(2)];
            let polynomial: Vec<f64> = [linear].into_iter().chain(bend).take(degree).collect();
            let sense = if uniform(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
            let alpha = sense * linear * log(uniform(0.0, 1.0), 0.1, 0.5);
            let beta = log(uniform(0.0, 1.0), 0.08, 1.2);
            let gamma = uniform(-0.8, 0.8) * beta;
            let dynamics = SecondOrder {
                gain: 1.0,
                natural_frequency_hz: log(uniform(0.0, 1.0), 120.0, 1500.0),
                damping: log(uniform(0.0, 1.0), 0.02, 1.0),
                alpha2: uniform(1.75, 2.1),
                alpha1: uniform(0.6, 1.2),
                alpha0: 0.0,
            };
            let delay_s = uniform(0.0, 5e-4);
            if stability(&dynamics.to_transfer_function()?).is_stable() {
                let hysteresis = BoucWen::new(polynomial, alpha, beta, gamma, 1.0)?;
                return Ok(Self { hysteresis, dynamics, delay_s });
            }
        }
    }

    /// The bench with this device and an ideal sensor but for white noise.
    pub fn bench(&self, noise_um: f64) -> Outcome<Truth> {
        let g = self.dynamics.to_transfer_function()?;
        let terms = |terms: &[Term]| -> Vec<PowerTerm> {
            terms.iter().map(|t| PowerTerm { coefficient: t.coefficient, order: t.order }).collect()
        };
        let b = &self.hysteresis;
        let plant = Plant::BoucWenFractional(BoucWenFractional {
            polynomial: b.polynomial.clone(),
            alpha: b.alpha,
            beta: b.beta,
            gamma: b.gamma,
            n: b.n,
            numerator: terms(&g.numerator),
            denominator: terms(&g.denominator),
            delay_s: self.delay_s,
        });
        let mut truth = Truth { plant, ..Truth::default() }.with_ideal_sensor();
        truth.sensor.noise_um = noise_um;
        Ok(truth)
    }

    /// The same as a model to start from.
    pub fn model(&self) -> Outcome<Model> {
        Ok(Model {
            hysteresis: Hysteresis::from(self.hysteresis.clone()),
            dynamics: Dynamics::Fractional(self.dynamics.to_transfer_function()?),
            offset: 0.0,
            delay_s: self.delay_s,
            scheme: Scheme::BandLimited,
            inter_sample: InterSample::Linear,
            sample_rate_hz: None,
        })
    }

    /// The true values by the names of the fit.
    pub fn values(&self) -> Outcome<Vec<(String, f64)>> {
        let (b, g) = (&self.hysteresis, &self.dynamics);
        let transfer = g.to_transfer_function()?;
        let polynomial = ["linear", "quadratic", "cubic"].into_iter().zip(b.polynomial.iter().copied());
        let rest = [
            ("alpha", b.alpha),
            ("beta", b.beta),
            ("gamma", b.gamma),
            ("n", b.n),
            ("natural_frequency", g.natural_frequency_hz),
            ("damping", g.damping),
            ("order2", g.alpha2),
            ("order1", g.alpha1),
            ("b", transfer.numerator[0].coefficient),
            ("c0", transfer.denominator[0].coefficient),
            ("c1", transfer.denominator[1].coefficient),
            ("delay", self.delay_s),
            ("memory_1", 0.0),
            ("memory_2", 0.0),
        ];
        Ok(polynomial.chain(rest).map(|(name, value)| (name.to_owned(), value)).collect())
    }

    /// In one line.
    pub fn describe(&self) -> String {
        let (b, g) = (&self.hysteresis, &self.dynamics);
        format!(
            "l {:.3?}, α {:.3}, β {:.3}, γ {:.3}; {:.0} Hz, ζ {:.3}, orders {:.3}, {:.3}; delay {:.2} ms",
            b.polynomial,
            b.alpha,
            b.beta,
            b.gamma,
            g.natural_frequency_hz,
            g.damping,
            g.alpha2,
            g.alpha1,
            1e3 * self.delay_s
        )
    }
}

/// The value at the share `t` of a logarithmic scale.
fn log(t: f64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(t)
}
