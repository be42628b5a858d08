//! Resonances from the empirical frequency response of the records, for starts of multi-resonance forms.
//!
//! Frequency response of the fastest record under a Hann window, averaged over bands of neighbouring
//! frequencies: the best linear approximation, in which hysteresis changes the gain but hardly the
//! resonances. Modes are then fitted to it one by one ([`crate::frequency_response::fit_structure`]).

use std::f64::consts::TAU;

use super::campaign::JointMember;
use crate::frequency_response::{Core, FrequencyResponse, Structure, Weighting, fit_structure};
use hysteron_numeric::Complex64;
use hysteron_numeric::fft::{RealFft, fast_length};

/// Number of logarithmic bands of the averaged response; each has at least [`NARROWEST`] frequencies.
const BANDS: usize = 300;
/// Fewest frequencies in a band.
const NARROWEST: usize = 6;
/// Least squared coherence of a band.
const COHERENT: f64 = 0.8;
/// Least power of the drive in a band, as a share of the strongest band.
const DRIVEN: f64 = 1e-8;
/// Fewest periods in the record, which sets the lowest frequency.
const PERIODS: f64 = 20.0;

/// A resonance measured in the records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Resonance {
    pub(super) natural_frequency_hz: f64,
    pub(super) damping: f64,
    /// Share of the DC gain.
    pub(super) share: f64,
}

/// The resonances of the fastest record, the largest share first; empty where no fit of `count` modes is
/// valid.
pub(super) fn resonances(members: &[JointMember<'_>], count: usize) -> Vec<Resonance> {
    let speed = |m: &&JointMember<'_>| m.facts.highest_frequency_hz();
    let Some(fastest) = members.iter().max_by(|a, b| speed(a).total_cmp(&speed(b))) else {
        return Vec::new();
    };
    let Some(response) = response(fastest) else { return Vec::new() };
    let structure = Structure::of(Core::Modes { count }).with_delay();
    let Ok(fit) = fit_structure(&response, &structure, Weighting::Relative) else { return Vec::new() };
    let value = |name: String| fit.parameters.iter().find(|p| p.name == name).map_or(0.0, |p| p.value);
    let gains: Vec<f64> = (1..=count).map(|i| value(format!("mode{i}_gain"))).collect();
    let whole: f64 = gains.iter().sum();
    let mut found: Vec<Resonance> = gains
        .iter()
        .zip(1..)
        .map(|(gain, i)| Resonance {
            natural_frequency_hz: value(format!("mode{i}_frequency")),
            damping: value(format!("mode{i}_damping")),
            share: gain / whole,
        })
        .collect();
    found.sort_by(|a, b| b.share.abs().total_cmp(&a.share.abs()));
    let sound = |r: &Resonance| r.natural_frequency_hz > 0.0 && r.damping > 0.0 && r.share.is_finite();
    if found.iter().all(sound) { found } else { Vec::new() }
}

/// Band-averaged frequency response where drive and output are coherent.
fn response(member: &JointMember<'_>) -> Option<FrequencyResponse> {
    let data = &member.facts.data;
    let samples = data.u.len();
    let fft = RealFft::new(fast_length(2 * samples));
    let (u, y) = (spectrum(&data.u, &fft), spectrum(&data.y, &fft));
    let resolution = member.rate_hz / fft.len() as f64;
    let (low, high) = (PERIODS * member.rate_hz / samples as f64, 0.45 * member.rate_hz);
    let step = (high / low).powf(1.0 / BANDS as f64);
    let mut bands = Vec::new();
    let mut first = (low / resolution).ceil() as usize;
    while first as f64 * resolution < high {
        let last = ((first as f64 * step).ceil() as usize).max(first + NARROWEST).min(u.len());
        if last <= first {
            break;
        }
        let (mut uu, mut yy, mut yu) = (0.0, 0.0, Complex64::ZERO);
        for (u, y) in u[first..last].iter().zip(&y[first..last]) {
            uu += u.norm_sqr();
            yy += y.norm_sqr();
            yu += y * u.conj();
        }
        bands.push((
            0.5 * (first + last - 1) as f64 * resolution,
            uu / (last - first) as f64,
            yu / uu,
            yu.norm_sqr() / (uu * yy),
        ));
        first = last;
    }
    let strongest = bands.iter().map(|b| b.1).fold(0.0, f64::max);
    let counts = |b: &&(f64, f64, Complex64, f64)| b.1 > DRIVEN * strongest && b.3 > COHERENT;
    let (frequency_hz, values): (Vec<f64>, Vec<Complex64>) =
        bands.iter().filter(counts).map(|b| (b.0, b.2)).unzip();
    FrequencyResponse::new("drive to output", frequency_hz, values).ok()
}

/// Spectrum of the signal less its mean, under a Hann window.
fn spectrum(x: &[f64], fft: &RealFft) -> Vec<Complex64> {
    let length = x.len() as f64;
    let mean = x.iter().sum::<f64>() / length;
    let mut time = fft.forward.make_input_vec();
    for (k, (time, x)) in time.iter_mut().zip(x).enumerate() {
        let window = 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / length).cos();
        *time = window * (x - mean);
    }
    let mut spectrum = fft.forward.make_output_vec();
    fft.transform(&mut time, &mut spectrum);
    spectrum
}
