//! Matrix of frequency responses from periodic records by the local polynomial method.
//!
//! Around each line the response is a polynomial of second degree in frequency, Y(k + r) = Σ_d G_d r^d U(k +
//! r): the window of neighbouring lines of all records gives its coefficients by least squares; G_0 is the
//! response (R. Pintelon, J. Schoukens, *System Identification: A Frequency Domain Approach*, 2nd ed., Wiley
//! 2012, ch. 7; doi:10.1002/9781118287422). Fewer records than inputs suffice where their phases differ from
//! line to line.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{AxesError, SteadyPeriod};
use hysteron_numeric::fft::RealFft;
use hysteron_numeric::{Complex64, least_squares};

/// Least number of lines on either side of the centre.
pub const HALF_WINDOW: usize = 4;
/// Coefficients of the polynomial.
const COEFFICIENTS: usize = 3;
/// Power relative to the strongest line above which a line counts as excited.
const EXCITED: f64 = 1e-5;
/// Share of a column outside the span of the others below which the matrix counts as rank deficient.
const DEPENDENT: f64 = 1e-6;

/// Outputs over inputs at the excited lines of a period.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyMatrix {
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// Frequencies \[Hz\], ascending.
    pub frequency_hz: Vec<f64>,
    /// Harmonic numbers of these lines.
    pub lines: Vec<usize>,
    /// Outputs × inputs, row by row, frequency by frequency \[µm/V\].
    pub values: Vec<Complex64>,
}

/// Spectrum of each of `channels` interleaved channels, X_k = Σ x_j e^(−2πijk/N)/N, row by row of the lines 0
/// … N/2.
pub fn spectrum(x: &[f64], channels: usize) -> Vec<Complex64> {
    let samples = x.len() / channels.max(1);
    let fft = RealFft::new(samples);
    let mut rows = vec![Complex64::new(0.0, 0.0); (samples / 2 + 1) * channels];
    for c in 0..channels {
        let mut channel: Vec<f64> = x.iter().skip(c).step_by(channels).copied().collect();
        let mut lines = fft.forward.make_output_vec();
        // Only a wrong length can fail, and the lengths are the plan's.
        if fft.forward.process(&mut channel, &mut lines).is_ok() {
            for (k, line) in lines.iter().enumerate() {
                rows[k * channels + c] = line / samples as f64;
            }
        }
    }
    rows
}

impl FrequencyMatrix {
    /// The matrix at the lines that the records of one period length excite (all below half the sample rate).
    ///
    /// # Errors
    /// [`AxesError::FewLines`], [`AxesError::Dependent`].
    pub fn local_polynomial(periods: &[&SteadyPeriod]) -> Result<Self, AxesError> {
        let few = |lines, need, unknowns| AxesError::FewLines { lines, need, unknowns };
        let Some(first) = periods.first() else { return Err(few(0, 1, 1)) };
        let (n, m) = (first.inputs, first.outputs);
        let spectra: Vec<_> = periods.iter().map(|p| (spectrum(&p.u, n), spectrum(&p.y, m))).collect();
        let lines = excited(&spectra, n, first.samples());
        let unknowns = n * COEFFICIENTS;
        // At least three equations per unknown.
        let half = (3 * unknowns).div_ceil(periods.len()).saturating_sub(1).div_ceil(2).max(HALF_WINDOW);
        if lines.len() < 2 * half + 1 {
            return Err(few(lines.len(), 2 * half + 1, unknowns));
        }
        let resolution = first.sample_rate_hz / first.samples() as f64;
        let at = |index: usize| {
            let from = index.saturating_sub(half).min(lines.len() - 2 * half - 1);
            local(&lines[from..from + 2 * half + 1], lines[index], &spectra, (n, m))
        };
        let values: Vec<Option<Vec<Complex64>>> = (0..lines.len()).into_par_iter().map(at).collect();
        let mut all = Vec::with_capacity(lines.len() * n * m);
        for (line, value) in lines.iter().zip(values) {
            all.extend(value.ok_or(AxesError::Dependent {
                inputs: n,
                records: periods.len(),
                frequency_hz: *line as f64 * resolution,
            })?);
        }
        let frequency_hz = lines.iter().map(|line| *line as f64 * resolution).collect();
        Ok(Self { inputs: n, outputs: m, frequency_hz, lines, values: all })
    }

    /// Number of frequencies.
    pub fn len(&self) -> usize {
        self.frequency_hz.len()
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.frequency_hz.is_empty()
    }

    /// The matrix at one frequency, row by row.
    pub fn at(&self, index: usize) -> &[Complex64] {
        let entries = self.inputs * self.outputs;
        &self.values[index * entries..(index + 1) * entries]
    }

    /// Mean of the real parts over the frequencies from `low_hz` to `high_hz`, row by row; the lowest one
    /// where none lies between.
    pub fn mean_real(&self, low_hz: f64, high_hz: f64) -> Vec<f64> {
        let inside = |&k: &usize| (low_hz..=high_hz).contains(&self.frequency_hz[k]);
        let mut chosen: Vec<usize> = (0..self.len()).filter(inside).collect();
        if chosen.is_empty() {
            chosen.extend((!self.is_empty()).then_some(0));
        }
        let mut mean = vec![0.0; self.inputs * self.outputs];
        for &k in &chosen {
            mean.iter_mut().zip(self.at(k)).for_each(|(mean, g)| *mean += g.re / chosen.len() as f64);
        }
        mean
    }
}

type Spectra = (Vec<Complex64>, Vec<Complex64>);

/// Lines at which the inputs of all records together carry power, except 0 and half the sample rate.
fn excited(spectra: &[Spectra], inputs: usize, samples: usize) -> Vec<usize> {
    let power = |k: usize| -> f64 {
        let inputs =
            |u: &[Complex64]| u[k * inputs..(k + 1) * inputs].iter().map(|u| u.norm_sqr()).sum::<f64>();
        spectra.iter().map(|(u, _)| inputs(u)).sum()
    };
    let inner = 1..samples.div_ceil(2);
    let most = inner.clone().map(power).fold(0.0, f64::max);
    inner.filter(|&k| power(k) > EXCITED * most).collect()
}

/// G_0 at the line `centre` from the lines of a window; `None` where the matrix is rank deficient.
fn local(
    window: &[usize],
    centre: usize,
    spectra: &[Spectra],
    (n, m): (usize, usize),
) -> Option<Vec<Complex64>> {
    let width = window.iter().map(|k| k.abs_diff(centre)).max().unwrap_or(1).max(1) as f64;
    let rows = spectra.len() * window.len();
    let place = |row: usize| (&spectra[row / window.len()], window[row % window.len()]);
    let offset = |line: usize| (line as f64 - centre as f64) / width;
    let matrix = DMatrix::from_fn(rows, n * COEFFICIENTS, |row, column| {
        let ((u, _), line) = place(row);
        u[line * n + column % n] * offset(line).powi((column / n) as i32)
    });
    let measured = DMatrix::from_fn(rows, m, |row, output| {
        let ((_, y), line) = place(row);
        y[line * m + output]
    });
    let solution = least_squares(matrix, measured, DEPENDENT).ok()?.solution;
    Some(
        (0..m)
            .flat_map(|output| (0..n).map(move |input| (input, output)))
            .map(|(i, o)| solution[(i, o)])
            .collect(),
    )
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A period of a linear system Y = G U: every line of each input with an independent phase.
    pub(crate) fn period(
        seed: u64,
        (samples, rate): (usize, f64),
        (n, m): (usize, usize),
        response: impl Fn(f64) -> Vec<Complex64>,
    ) -> SteadyPeriod {
        let mut state = seed;
        let mut phase = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            std::f64::consts::TAU * (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let lines = samples / 2 - samples / 16;
        let (mut u, mut y) = (vec![0.0; samples * n], vec![0.0; samples * m]);
        for line in 1..lines {
            let phases: Vec<f64> = (0..n).map(|_| phase()).collect();
            let g = response(rate * line as f64 / samples as f64);
            for k in 0..samples {
                let turn = std::f64::consts::TAU * ((line * k) % samples) as f64 / samples as f64;
                let inputs: Vec<Complex64> =
                    phases.iter().map(|phase| Complex64::from_polar(1.0, turn + phase)).collect();
                for i in 0..n {
                    u[k * n + i] += inputs[i].re;
                }
                for o in 0..m {
                    y[k * m + o] += (0..n).map(|i| g[o * n + i] * inputs[i]).sum::<Complex64>().re;
                }
            }
        }
        let level = crate::axes::steady::level(&u, n);
        SteadyPeriod {
            name: format!("{seed}"),
            sample_rate_hz: rate,
            inputs: n,
            outputs: m,
            u,
            y,
            offset: vec![0.0; m],
            averaged: 1,
            settling: 0,
            level,
        }
    }

    #[test]
    fn a_matrix_of_polynomials_in_frequency_is_found_exactly_from_fewer_records_than_inputs() {
        let response = |f: f64| {
            let g = |a: f64, b: f64| Complex64::new(a + 1e-3 * f, b * f * f * 1e-4);
            vec![g(1.0, 0.2), g(-0.3, 0.0), g(0.2, 1.0), g(2.0, -0.5)]
        };
        let all: Vec<SteadyPeriod> =
            [3, 9].iter().map(|s| period(*s, (256, 256.0), (2, 2), response)).collect();
        for records in [vec![&all[0]], all.iter().collect::<Vec<_>>()] {
            let found = FrequencyMatrix::local_polynomial(&records).unwrap();
            assert_eq!(found.lines, (1..112).collect::<Vec<_>>());
            for k in 0..found.len() {
                for (found, truth) in found.at(k).iter().zip(response(found.frequency_hz[k])) {
                    assert!((found - truth).norm() < 1e-10, "line {k}: {found} {truth}");
                }
            }
            let real = found.mean_real(10.0, 12.0);
            assert!((real[0] - 1.011).abs() < 1e-10 && (real[3] - 2.011).abs() < 1e-10);
        }
    }

    #[test]
    fn inputs_that_move_together_are_refused() {
        let mut both = period(5, (256, 256.0), (2, 1), |_| vec![Complex64::new(1.0, 0.0); 2]);
        for row in both.u.chunks_exact_mut(2) {
            row[1] = row[0];
        }
        let refused = FrequencyMatrix::local_polynomial(&[&both]);
        assert!(matches!(refused, Err(AxesError::Dependent { inputs: 2, records: 1, .. })), "{refused:?}");
        let short = period(5, (16, 16.0), (2, 1), |_| vec![Complex64::new(1.0, 0.0); 2]);
        assert!(matches!(FrequencyMatrix::local_polynomial(&[&short]), Err(AxesError::FewLines { .. })));
    }
}
