//! Simulation of a transfer function over a record in one pair of FFTs.

use crate::start::{LinearStart, Start};
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use super::blocks::{BLOCK, Exponential, Polynomial, frequencies};
use super::frequencies::Frequencies;
use super::shift::Reconstruction;
use super::sums::{self, Candidate};
use super::{DynamicsError, Scheme, Stability, Term, TransferFunction, stability};
use crate::dynamics_error::{check_finite, check_length, check_sample_rate};
use hysteron_numeric::fft::{RealFft, fast_length};
use hysteron_numeric::{Complex64, InstructionSet, half_turns, multiply_quotient};

/// r^L. Aliasing contributes r^L, rounding ε·r^−N; at L = 2N both stay below 1e-10 of the response.
const ALIASING: f64 = 1e-10;

/// Largest logarithm of a term of a polynomial, whose square must stay in range.
pub(super) const LARGEST: f64 = 345.0;

/// Shortest transform: beyond a record of a few samples the response may still grow, and its aliased part
/// would be large.
const SHORTEST: usize = 256;

/// Everything about a simulation that depends on the record but not on the candidate: made once, shared by
/// all threads, used for any number of transfer functions.
///
/// y = r^−k · IFFT( G(s) · FFT(r^k u_k) ), s = δ(r e^(−iθ))/h, L ≥ 2N, r^L = 1e-10 (Lubich's convolution
/// quadrature; for `BandLimited` s = σ + iω with r = e^(−σh)). Holds FFT plans and ln s, point by point at
/// the lowest frequencies and as power series over runs of the others, so that there a candidate costs one
/// polynomial per frequency, whatever its orders. With [`Start::PERIODIC`] r = 1 and L = N: the exact steady
/// state.
///
/// Error against the O(N²) recursion: below 1e-9 of the largest output on article Eq. 13 up to N = 1e5
/// (`tests/quadrature_matches_recursion.rs`).
#[derive(Debug)]
pub struct SimulationPlan {
    pub(super) samples: usize,
    pub(super) sample_rate_hz: f64,
    pub(super) scheme: Scheme,
    initial: LinearStart,
    fft: RealFft,
    /// −ln r.
    pub(super) damping: f64,
    /// ln s of each frequency.
    pub(super) frequencies: Frequencies,
    /// r^k for the samples of the input.
    decay: Exponential,
    /// Factors of the input's continuation, `BandLimited` only: fading times r^k, from one past the last
    /// sample.
    fade: Vec<f64>,
    /// r^−k / L for the samples of the output.
    growth: Exponential,
    /// ln |s| and arg s along |z| = 1, made when a stability verdict first needs them.
    pub(super) unit_circle: OnceLock<(Vec<f64>, Vec<f64>)>,
    /// Factors and images of a held and of a straight reconstruction, made when first needed.
    pub(super) held: OnceLock<Reconstruction>,
    pub(super) straight: OnceLock<Reconstruction>,
    /// Sample period of the drive, in sample periods of the plan.
    pub(super) drive_period: f64,
    pub(super) set: InstructionSet,
}

/// Transform of an input, made by [`SimulationPlan::transform`] and valid for that plan (or one made alike).
#[derive(Clone, Debug)]
pub struct InputSpectrum {
    pub(super) bins: Vec<Complex64>,
    /// Level subtracted before the transform.
    level: f64,
}

/// Buffers of one thread.
#[derive(Clone, Debug)]
pub struct Workspace {
    time: Vec<f64>,
    pub(super) spectrum: Vec<Complex64>,
    scratch: Vec<Complex64>,
    /// Of [`SimulationPlan::simulate`]; empty before its first call.
    input: InputSpectrum,
}

impl SimulationPlan {
    /// A plan for records of `samples` samples at `sample_rate_hz`.
    ///
    /// # Errors
    /// [`DynamicsError::TooFewSamples`] for an empty record, [`DynamicsError::SampleRate`].
    pub fn new(
        samples: usize,
        sample_rate_hz: f64,
        scheme: Scheme,
        initial: LinearStart,
    ) -> Result<Self, DynamicsError> {
        check_sample_rate(sample_rate_hz)?;
        if samples == 0 {
            return Err(DynamicsError::TooFewSamples { need: 1, found: 0 });
        }
        let initial = match initial {
            Start::Settled { period_samples: Some(period), .. } if period != samples => {
                return Err(DynamicsError::Length { what: "period", expected: samples, found: period });
            }
            Start::Settled { .. } => Start::PERIODIC,
            other => other,
        };
        let periodic = initial == Start::PERIODIC;
        let length = if periodic { samples } else { fast_length((2 * samples).max(SHORTEST)) };
        let damping = if periodic { 0.0 } else { -ALIASING.ln() / length as f64 };
        let grid = Frequencies::new(scheme, length, damping, sample_rate_hz);
        let decay = Exponential::new(-damping, 1.0, samples);
        let fade = if scheme == Scheme::BandLimited { fading(samples, length, damping) } else { Vec::new() };
        let growth = Exponential::new(damping, 1.0 / length as f64, samples);
        let fft = RealFft::new(length);
        let set = InstructionSet::detected();
        Ok(Self {
            samples,
            sample_rate_hz,
            scheme,
            initial,
            fft,
            damping,
            frequencies: grid,
            decay,
            fade,
            growth,
            unit_circle: OnceLock::new(),
            held: OnceLock::new(),
            straight: OnceLock::new(),
            drive_period: 1.0,
            set,
        })
    }

    /// Samples of a record.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Sample rate \[Hz\].
    pub fn sample_rate_hz(&self) -> f64 {
        self.sample_rate_hz
    }

    /// The scheme.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// Frequencies: half the length of the transforms, and zero.
    pub(super) fn bins(&self) -> usize {
        self.frequencies.bins
    }

    /// Length of the transforms.
    pub fn transform_length(&self) -> usize {
        self.fft.len()
    }

    /// Buffers for one thread.
    pub fn workspace(&self) -> Workspace {
        let scratch = self.fft.forward.get_scratch_len().max(self.fft.inverse.get_scratch_len());
        Workspace {
            time: vec![0.0; self.fft.len()],
            spectrum: vec![Complex64::ZERO; self.bins()],
            scratch: vec![Complex64::ZERO; scratch],
            input: InputSpectrum::none(),
        }
    }

    /// Simulates `tf` over `input`; `input` and `output` have [`SimulationPlan::samples`] samples. Allocates
    /// nothing after the first call with a workspace.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::transform`] and [`SimulationPlan::simulate_spectrum`].
    pub fn simulate(
        &self,
        tf: &TransferFunction,
        input: &[f64],
        workspace: &mut Workspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        let mut spectrum = std::mem::replace(&mut workspace.input, InputSpectrum::none());
        if spectrum.bins.is_empty() {
            spectrum = self.empty_spectrum();
        }
        let result = self
            .transform_into(input, workspace, &mut spectrum)
            .and_then(|()| self.simulate_spectrum(tf, &spectrum, workspace, output));
        workspace.input = spectrum;
        result
    }

    /// The transform of `input`, for many calls of [`SimulationPlan::simulate_spectrum`].
    ///
    /// # Errors
    /// [`DynamicsError::Length`], [`DynamicsError::InputNotFinite`].
    pub fn transform(&self, input: &[f64]) -> Result<InputSpectrum, DynamicsError> {
        let mut spectrum = self.empty_spectrum();
        self.transform_into(input, &mut self.workspace(), &mut spectrum)?;
        Ok(spectrum)
    }

    /// [`SimulationPlan::transform`] into an existing spectrum. Allocates nothing.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::transform`].
    pub fn transform_into(
        &self,
        input: &[f64],
        workspace: &mut Workspace,
        spectrum: &mut InputSpectrum,
    ) -> Result<(), DynamicsError> {
        check_length("input", input.len(), self.samples)?;
        self.check_workspace(workspace)?;
        check_length("input spectrum", spectrum.bins.len(), self.bins())?;
        spectrum.level = match self.initial {
            Start::AsIdentified => input[0],
            Start::Rest { voltage_v } => voltage_v,
            Start::Settled { .. } => 0.0,
            Start::Remembering { memory, .. } => match memory {},
        };
        let time = &mut workspace.time;
        if !self.decay.multiply(self.set, input, -spectrum.level, 0.0, &mut time[..self.samples]) {
            check_finite("input", input)?;
            return Err(DynamicsError::OutputNotFinite);
        }
        time[self.samples..].fill(0.0);
        if self.scheme == Scheme::BandLimited {
            self.extend(input, spectrum.level, time);
        }
        self.fft.transform_with(&mut workspace.scratch, time, &mut spectrum.bins);
        Ok(())
    }

    /// Simulates `tf` over an input transformed before: one evaluation of G and one inverse FFT. Allocates
    /// nothing.
    ///
    /// # Errors
    /// [`DynamicsError::Unstable`], for which this simulation would be silently wrong: by [`stability`], and
    /// under `GrunwaldLetnikov` and `Bdf2`, which may damp a growing plant, by the winding of the denominator
    /// along
    /// |z| = 1, only computed for a plant that is unstable in continuous time. Such a plant can be simulated
    /// by [`TransferFunction::simulate_causal`]. [`DynamicsError::InfiniteDcGain`] under `Rest` and
    /// `Periodic`, [`DynamicsError::Improper`] under `Tustin`, [`DynamicsError::Undamped`] under `Periodic`,
    /// [`DynamicsError::Length`], [`DynamicsError::OutputNotFinite`], and what [`TransferFunction::validate`]
    /// refuses.
    pub fn simulate_spectrum(
        &self,
        tf: &TransferFunction,
        input: &InputSpectrum,
        workspace: &mut Workspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        check_length("output", output.len(), self.samples)?;
        check_length("input spectrum", input.bins.len(), self.bins())?;
        self.check_workspace(workspace)?;
        self.check_candidate(tf, || stability(tf))?;
        let offset = if input.level == 0.0 { 0.0 } else { tf.dc_gain() * input.level };
        self.multiply(tf, input, &mut workspace.spectrum);
        self.invert(workspace, offset, output)
    }

    /// `output` = inverse transform of the workspace's spectrum, plus `offset`.
    pub(super) fn invert(
        &self,
        workspace: &mut Workspace,
        offset: f64,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        let (time, scratch) = (&mut workspace.time, &mut workspace.scratch);
        self.fft.invert_with(scratch, &mut workspace.spectrum, time);
        if self.growth.multiply(self.set, time, 0.0, offset, output) {
            Ok(())
        } else {
            Err(DynamicsError::OutputNotFinite)
        }
    }

    /// A zero spectrum, to be written by [`SimulationPlan::transform_into`] or added to.
    pub fn empty_spectrum(&self) -> InputSpectrum {
        InputSpectrum { bins: vec![Complex64::ZERO; self.bins()], level: 0.0 }
    }

    pub(super) fn check_workspace(&self, workspace: &Workspace) -> Result<(), DynamicsError> {
        check_length("workspace", workspace.time.len(), self.fft.len())
    }

    /// ln |s| at the lowest frequency that is not zero.
    fn bottom(&self) -> f64 {
        let lowest = if self.damping > 0.0 { self.damping } else { TAU / self.fft.len() as f64 };
        (lowest * self.sample_rate_hz).ln()
    }

    /// Checks of a candidate that need no frequency response.
    pub(super) fn check_candidate(
        &self,
        tf: &TransferFunction,
        stability: impl FnOnce() -> Stability,
    ) -> Result<(), DynamicsError> {
        tf.validate()?;
        // Squares of the polynomials must stay in range, or a quotient would quietly become zero.
        let (top, bottom, shift) = (self.frequencies.top, self.bottom(), sums::shift(tf));
        let largest = |order: f64| order * if order < 0.0 { bottom } else { top };
        let size = |term: &Term| term.coefficient.abs().ln() + largest(term.order - shift);
        if tf.numerator.iter().chain(&tf.denominator).any(|term| size(term) > LARGEST) {
            return Err(DynamicsError::OutputNotFinite);
        }
        if self.scheme == Scheme::Tustin {
            tf.require_proper()?;
        }
        let periodic = self.initial == Start::PERIODIC;
        if self.initial != Start::ZERO && tf.dc_gain().is_infinite() {
            return Err(tf.infinite_dc_gain());
        }
        match stability() {
            Stability::Marginal { frequency_hz } if periodic => Err(DynamicsError::Undamped { frequency_hz }),
            Stability::Stable | Stability::Integrating { .. } | Stability::Marginal { .. } => Ok(()),
            Stability::Unstable { poles } if periodic || !self.scheme.may_damp() => {
                Err(DynamicsError::Unstable { poles })
            }
            Stability::Unstable { .. } => match self.sampled_poles(tf) {
                0 => Ok(()),
                poles => Err(DynamicsError::Unstable { poles }),
            },
        }
    }

    /// Poles z of the sampled system with |z| < 1, by the winding of the denominator along |z| = 1. (Along
    /// the circle |z| = r of the simulation a growth of up to r^−N = 1e5 within the record would go
    /// unnoticed, at which the aliased part is as large as the response.)
    fn sampled_poles(&self, tf: &TransferFunction) -> usize {
        let (log_abs, angle) = self.unit_circle.get_or_init(|| {
            // Just inside, so that z = 1, s = 0 is excluded: growth by e^0.01 is tolerated.
            let (length, bins) = (self.fft.len(), self.bins());
            frequencies(self.scheme, length, 0.01 / length as f64, self.sample_rate_hz, 0, bins)
        });
        let mut denominator = Polynomial::new();
        let (mut turns, mut start) = (0.0, None);
        for (log_abs, angle) in log_abs.chunks(BLOCK).zip(angle.chunks(BLOCK)) {
            denominator.evaluate(self.set, &tf.denominator, log_abs, angle);
            if start.is_none() {
                start = Some(denominator.re[1]);
                denominator.re[0] = denominator.re[1];
                denominator.im[0] = denominator.im[1];
            }
            let points = log_abs.len() + 1;
            turns += half_turns(self.set, &denominator.re[..points], &denominator.im[..points]);
            denominator.carry(log_abs.len());
        }
        // z runs clockwise along half of the circle, from a real value of the denominator to a real one.
        let negative = |x: f64| if x < 0.0 { 1.0 } else { 0.0 };
        (negative(start.unwrap_or(0.0)) - turns - negative(denominator.re[0])).max(0.0) as usize
    }

    /// spectrum = G · input at every frequency.
    fn multiply(&self, tf: &TransferFunction, input: &InputSpectrum, spectrum: &mut [Complex64]) {
        let candidate = Candidate { tf, linearised: None, set: self.set };
        candidate.over(&self.frequencies, &mut [], |bins, sums, _| {
            let count = bins.len();
            let (n, d) = (sums.numerator.first(count), sums.denominator.first(count));
            multiply_quotient(self.set, n, d, &input.bins[bins.clone()], &mut spectrum[bins]);
        });
        self.edges(tf, input, spectrum);
    }

    /// The first and last frequency of G times the input.
    fn edges(&self, tf: &TransferFunction, input: &InputSpectrum, spectrum: &mut [Complex64]) {
        let last = spectrum.len() - 1;
        let (dc, top) = (tf.dc_gain(), tf.high_frequency_gain());
        self.settle_ends(spectrum, dc * input.bins[0].re, top * input.bins[last].re);
    }

    /// The first and, at even length, the last frequency: real, and limits `dc` and `top` where s is 0 or ∞.
    pub(super) fn settle_ends(&self, bins: &mut [Complex64], dc: f64, top: f64) {
        let last = bins.len() - 1;
        let even = self.fft.len() == 2 * last;
        if self.initial == Start::PERIODIC {
            bins[0].re = dc;
            if self.scheme == Scheme::Tustin && even && last > 0 {
                bins[last].re = top;
            }
        }
        bins[0].im = 0.0;
        if even {
            bins[last].im = 0.0;
        }
    }

    /// Continues the input past its end so that it has no corner there: reflected about its last sample and
    /// faded out over the rest of the period.
    fn extend(&self, input: &[f64], level: f64, time: &mut [f64]) {
        let end = input[self.samples - 1] - level;
        let earlier = input.iter().rev().skip(1);
        for ((time, x), fade) in time[self.samples..].iter_mut().zip(earlier).zip(&self.fade) {
            *time = (2.0 * end - (x - level)) * fade;
        }
    }
}

/// Fading from 1 to 0 over as many samples as there are, or as fit, times r^k.
fn fading(samples: usize, length: usize, damping: f64) -> Vec<f64> {
    let count = (length - samples).min(samples);
    let at = |j: usize| {
        let fade = 0.5 + 0.5 * (PI * j as f64 / count as f64).cos();
        fade * (-damping * (samples - 1 + j) as f64).exp()
    };
    (1..count).map(at).collect()
}

impl InputSpectrum {
    const fn none() -> Self {
        Self { bins: Vec::new(), level: 0.0 }
    }

    /// Level subtracted from the input before the transform: its first sample under [`Start::AsIdentified`],
    /// the input before it under [`Start::Rest`], else 0.
    pub fn level(&self) -> f64 {
        self.level
    }

    /// Makes it the spectrum of a weighted sum of inputs of the same plan: 0 where there is none.
    pub fn set_sum<'a>(&mut self, terms: impl IntoIterator<Item = (f64, &'a Self)>) {
        let mut terms = terms.into_iter();
        match terms.next() {
            Some((factor, first)) => {
                self.bins.clear();
                self.bins.extend(first.bins.iter().map(|x| x * factor));
                self.level = factor * first.level;
            }
            None => {
                self.bins.fill(Complex64::ZERO);
                self.level = 0.0;
            }
        }
        for (factor, term) in terms {
            self.bins.iter_mut().zip(&term.bins).for_each(|(bin, x)| *bin += x * factor);
            self.level += factor * term.level;
        }
    }
}
