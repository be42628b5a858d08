//! Factors on a plan's frequencies: e^(−s x h) for a delay of x samples, and the inter-sample behaviour of
//! the input.

use std::f64::consts::{PI, TAU};

use super::blocks::BLOCK;
use super::delay::shift as delay_in_samples;
use super::images::Images;
use super::{DynamicsError, Sampling, Scheme, SimulationPlan};
use crate::record::InterSample;
use hysteron_numeric::{Complex64, InstructionSet, multiply_by, rotate, rotate_and_add};

/// z^x on the frequencies z = e^(−damping − 2πi·bin/length).
///
/// Phases are reduced to turns with whole samples in whole numbers, so they are as accurate for 10⁵ samples
/// as for one.
struct Shift {
    whole: usize,
    fraction: f64,
    length: usize,
    size: f64,
    /// e^(−2πi·j·x/length), j < BLOCK.
    fine: [Complex64; BLOCK],
}

impl Shift {
    fn new(whole: usize, fraction: f64, damping: f64, length: usize) -> Self {
        let size = (-damping * (whole as f64 + fraction)).exp();
        let mut shift = Self { whole: whole % length, fraction, length, size, fine: [Complex64::ONE; BLOCK] };
        // Of sixteen at a time the first and their common turns: an angle each, and a product for the others.
        const STEP: usize = 16;
        let turns: [Complex64; STEP] = std::array::from_fn(|j| shift.turn(j));
        for first in (0..BLOCK).step_by(STEP) {
            let start = shift.turn(first);
            for (fine, turn) in shift.fine[first..].iter_mut().zip(turns) {
                *fine = start * turn;
            }
        }
        shift
    }

    /// e^(−2πi·bin·x/length).
    fn turn(&self, bin: usize) -> Complex64 {
        let whole = match bin.checked_mul(self.whole) {
            Some(product) => (product % self.length) as f64,
            None => (bin as u128 * self.whole as u128 % self.length as u128) as f64,
        };
        let turns = (whole + bin as f64 * self.fraction) / self.length as f64;
        let (sin, cos) = (TAU * (turns - turns.floor())).sin_cos();
        Complex64::new(cos, -sin)
    }

    /// `weight` times the factors of the bins from `first` on.
    fn write(&self, set: InstructionSet, first: usize, weight: f64, out: &mut [Complex64]) {
        rotate(set, self.turn(first) * (self.size * weight), &self.fine, out);
    }

    /// [`Self::write`], added to what is there.
    fn add(&self, set: InstructionSet, first: usize, weight: f64, out: &mut [Complex64]) {
        rotate_and_add(set, self.turn(first) * (self.size * weight), &self.fine, out);
    }
}

impl SimulationPlan {
    /// The plan for decimated inputs (low-passed, every `factor`-th sample kept):
    /// [`Sampling::reconstruction`] applies between their original samples, a `factor`-th of a period apart.
    #[must_use]
    pub fn of_thinned_inputs(mut self, factor: usize) -> Self {
        self.drive_period = 1.0 / factor.max(1) as f64;
        (self.held, self.straight) = Default::default();
        self
    }

    /// Frees the tables of responses: as much memory as two signals. The next response makes them anew.
    pub fn forget_tables(&mut self) {
        (self.unit_circle, self.held, self.straight) = Default::default();
    }
}

/// E: the factor of delay and reconstruction, and its derivative in the delay.
///
/// With a delay of m + f samples, m whole: z^⌈m + f⌉ held, (1 − f) z^m + f z^(m + 1) on straight lines,
/// z^(m + f) band-limited.
pub(super) struct InputFactor<'a> {
    rule: InterSample,
    /// z^⌈m + f⌉, z^m or z^(m + f).
    shift: Shift,
    /// z^(m + 1), on straight lines.
    next: Option<Shift>,
    fraction: f64,
    /// ln z = −(damping + i·step·bin).
    damping: f64,
    step: f64,
    sample_rate_hz: f64,
    reconstruction: Option<&'a Reconstruction>,
    /// Delay in sample periods of the drive, where it is taken at the s of every image.
    turns: Option<f64>,
    set: InstructionSet,
}

/// Spectral factors and images of a held or piecewise linear input.
#[derive(Debug)]
pub(super) struct Reconstruction {
    table: Vec<Complex64>,
    pub(super) images: Images,
}

impl<'a> InputFactor<'a> {
    /// # Errors
    /// [`DynamicsError::Parameter`] for a delay that is negative or not finite.
    pub(super) fn new(
        plan: &'a SimulationPlan,
        delay_s: f64,
        sampling: Sampling,
    ) -> Result<Self, DynamicsError> {
        let (damping, length) = (plan.damping, plan.transform_length());
        let samples = delay_in_samples(delay_s, plan.sample_rate_hz)?;
        let (whole, fraction) = (samples.floor(), samples - samples.floor());
        let shift = |whole: f64, fraction| Shift::new(whole as usize, fraction, damping, length);
        let rule = sampling.delay;
        let (shift, next) = match rule {
            InterSample::Hold => (shift(samples.ceil(), 0.0), None),
            InterSample::Linear => (shift(whole, 0.0), Some(shift(whole + 1.0, 0.0))),
            InterSample::BandLimited => (shift(whole, fraction), None),
        };
        let reconstruction = match (plan.scheme, sampling.reconstruction) {
            (Scheme::BandLimited, InterSample::Hold) => Some(&plan.held),
            (Scheme::BandLimited, InterSample::Linear) => Some(&plan.straight),
            _ => None,
        };
        let reconstruction = reconstruction.map(|table| {
            let rule = sampling.reconstruction;
            table.get_or_init(|| Reconstruction {
                table: reconstruction_table(rule, damping, length, plan.drive_period),
                images: Images::new(plan, if rule == InterSample::Hold { 1 } else { 2 }),
            })
        });
        let turns = (rule == InterSample::BandLimited).then_some(samples / plan.drive_period);
        let (step, sample_rate_hz, set) = (TAU / length as f64, plan.sample_rate_hz, plan.set);
        Ok(Self { rule, shift, next, fraction, damping, step, sample_rate_hz, reconstruction, turns, set })
    }

    /// True if the factor varies with the delay.
    pub(super) fn depends_on_delay(&self) -> bool {
        self.rule != InterSample::Hold
    }

    /// Images of the input.
    pub(super) fn images(&self) -> Option<&'a Images> {
        self.reconstruction.map(|reconstruction| &reconstruction.images)
    }

    /// True if the delay is taken at the s of every image: then its derivative there differs.
    pub(super) fn turns_images(&self) -> bool {
        self.turns.is_some()
    }

    /// Delay in sample periods of the drive, as the images see it.
    pub(super) fn turns(&self) -> f64 {
        self.turns.unwrap_or(0.0)
    }

    /// E of the bins from `first` on, at most [`BLOCK`] of them.
    pub(super) fn write(&self, first: usize, out: &mut [Complex64]) {
        match &self.next {
            None => self.shift.write(self.set, first, 1.0, out),
            Some(next) => {
                self.shift.write(self.set, first, 1.0 - self.fraction, out);
                next.add(self.set, first, self.fraction, out);
            }
        }
        self.reconstruct(first, out);
    }

    /// dE/dτ \[1/s\], from the right where the rule has a corner. `values` is what [`Self::write`] wrote.
    pub(super) fn differentiate(&self, first: usize, values: &[Complex64], out: &mut [Complex64]) {
        match (self.rule, &self.next) {
            (InterSample::BandLimited, _) => {
                for (j, (out, value)) in out.iter_mut().zip(values).enumerate() {
                    let log_z = Complex64::new(-self.damping, -self.step * (first + j) as f64);
                    *out = value * log_z * self.sample_rate_hz;
                }
            }
            (_, Some(next)) => {
                self.shift.write(self.set, first, -self.sample_rate_hz, out);
                next.add(self.set, first, self.sample_rate_hz, out);
                self.reconstruct(first, out);
            }
            (_, None) => out.fill(Complex64::ZERO),
        }
    }

    fn reconstruct(&self, first: usize, out: &mut [Complex64]) {
        if let Some(Reconstruction { table, .. }) = self.reconstruction {
            multiply_by(self.set, &table[first..], out);
        }
    }
}

/// Factor of the reconstruction on the spectrum of the samples: (1 − e^(−sh))/(sh) held, ((e^(sh/2) −
/// e^(−sh/2))/(sh))² on straight lines; the content of a staircase or polygon above half the sample rate is
/// in its [`Images`]. `period`: h in sample periods of the plan.
fn reconstruction_table(rule: InterSample, damping: f64, length: usize, period: f64) -> Vec<Complex64> {
    let at = |bin: usize| {
        let theta = if 2 * bin == length { PI } else { TAU * bin as f64 / length as f64 };
        let half = Complex64::new(0.5 * damping, 0.5 * theta) * period;
        // By its parts, sinh keeps its relative accuracy near 0.
        let (sin, cos) = half.im.sin_cos();
        let sinh = Complex64::new(half.re.sinh() * cos, half.re.cosh() * sin);
        let quotient = if half == Complex64::ZERO { Complex64::ONE } else { sinh / half };
        match rule {
            InterSample::Hold => quotient * (-half).exp(),
            InterSample::Linear => quotient * quotient,
            InterSample::BandLimited => Complex64::ONE,
        }
    };
    (0..=length / 2).map(at).collect()
}
