//! Coefficients and memory of a realisation in one number type, and the model that runs on them.

use std::time::Duration;

use hysteron_rt::{
    Compensated, LANES, Linear, ModelError, PolePair, Real, RealPoles, Sections, SectionsMemory,
};

use super::operator::{OperatorParts, parts};
use super::{LinearRealisation, Realisation, RealiseError, Section};
use crate::hysteresis::RuntimeOperator;

/// Coefficients and memory of a model that `hysteron-rt` runs.
#[derive(Clone, Debug)]
pub struct RuntimeParts<T> {
    polynomial: Vec<T>,
    operator: OperatorParts<T>,
    linear: LinearParts<T>,
    offset: T,
    joins_means: bool,
}

/// The numbers of [`RuntimeParts`], for other programs to run.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients<'a, T> {
    /// l\[u\] = Σ_{i≥1} polynomial\[i−1\] uⁱ.
    pub polynomial: &'a [T],
    /// Hysteresis operator that is added to it.
    pub operator: &'a RuntimeOperator<T>,
    /// The dynamic block.
    pub sections: Sections<'a, T>,
    /// Whole samples of delay in front of it.
    pub delay_samples: usize,
    /// Constant of the output \[µm\].
    pub offset: T,
    /// True if moves are evaluated half-way ([`hysteron_rt::Means`]).
    pub joins_means: bool,
}

/// Coefficients and memory of a dynamic block.
#[derive(Clone, Debug)]
pub(crate) struct LinearParts<T> {
    taps: Vec<T>,
    real: Vec<RealPoles<T>>,
    pairs: Vec<PolePair<T>>,
    rest_gain: T,
    real_memory: Vec<Compensated<T, LANES>>,
    pair_memory: Vec<Compensated<T, 2>>,
    delay: Vec<T>,
}

impl<T: Real> LinearParts<T> {
    pub(crate) fn new(linear: &LinearRealisation) -> Self {
        let of = |x: f64| T::of(x);
        let (pairs, single): (Vec<Section>, Vec<Section>) =
            linear.sections.iter().copied().partition(Section::is_pair);
        let real: Vec<RealPoles<T>> = single
            .chunks(LANES)
            .map(|four| {
                let mut poles = RealPoles { gain: [of(0.0); LANES], weight: [of(0.0); LANES] };
                for ((gain, weight), section) in poles.gain.iter_mut().zip(&mut poles.weight).zip(four) {
                    (*gain, *weight) = (of(section.gain.re), of(section.weight.re));
                }
                poles
            })
            .collect();
        let pairs: Vec<PolePair<T>> = pairs
            .iter()
            .map(|s| PolePair {
                gain: [of(s.gain.re), of(s.gain.im)],
                weight: [of(s.weight.re), of(s.weight.im)],
            })
            .collect();
        Self {
            taps: linear.taps.iter().copied().map(of).collect(),
            real_memory: vec![Compensated::zero(); real.len()],
            pair_memory: vec![Compensated::zero(); pairs.len()],
            real,
            pairs,
            rest_gain: of(linear.rest_gain),
            delay: vec![of(0.0); linear.delay_samples],
        }
    }

    fn sections(&self) -> Sections<'_, T> {
        Sections { taps: &self.taps, real: &self.real, pairs: &self.pairs, rest_gain: self.rest_gain }
    }

    pub(crate) fn block(&mut self) -> Result<Linear<'_, T>, ModelError<T>> {
        let sections =
            Sections { taps: &self.taps, real: &self.real, pairs: &self.pairs, rest_gain: self.rest_gain };
        let memory = SectionsMemory {
            real: &mut self.real_memory,
            pairs: &mut self.pair_memory,
            delay: &mut self.delay,
        };
        Linear::new(sections, memory)
    }
}

impl<T: Real> RuntimeParts<T> {
    /// The parts of a realisation, rounded to `T`.
    ///
    /// # Errors
    /// [`RealiseError::Rounded`] where rounding makes a parameter invalid.
    pub fn new(realisation: &Realisation) -> Result<Self, RealiseError> {
        let model = &realisation.model;
        let (polynomial, operator) = parts(&model.hysteresis, realisation.sample_rate_hz)?;
        Ok(Self {
            polynomial,
            operator,
            linear: LinearParts::new(&realisation.dynamics),
            offset: T::of(model.offset),
            joins_means: realisation.joins_means,
        })
    }

    /// The coefficients, without the memory.
    pub fn coefficients(&self) -> Coefficients<'_, T> {
        let linear = &self.linear;
        Coefficients {
            polynomial: &self.polynomial,
            operator: self.operator.numbers(),
            sections: linear.sections(),
            delay_samples: linear.delay.len(),
            offset: self.offset,
            joins_means: self.joins_means,
        }
    }

    /// The model, at rest and virgin at 0 V; clears its memory.
    ///
    /// # Errors
    /// [`RealiseError::Rounded`] where the coefficients are not finite in this number type.
    pub fn model(&mut self) -> Result<hysteron_rt::Model<'_, T>, RealiseError> {
        let (offset, joins_means) = (self.offset, self.joins_means);
        let (hysteresis, dynamics) = self.blocks()?;
        hysteron_rt::Model::new(hysteresis, dynamics, offset)
            .and_then(|model| if joins_means { model.with_means() } else { Ok(model) })
            .map_err(|_| RealiseError::Rounded)
    }

    /// Its two blocks, at rest and virgin at 0 V.
    pub(crate) fn blocks(&mut self) -> Result<(hysteron_rt::Hysteresis<'_, T>, Linear<'_, T>), RealiseError> {
        let hysteresis = self.operator.block(&self.polynomial)?;
        let dynamics = self.linear.block().map_err(|_| RealiseError::Rounded)?;
        Ok((hysteresis, dynamics))
    }
}

/// Coefficients and memory of a realisation in `f64`.
#[derive(Clone, Debug)]
pub struct StreamParts(RuntimeParts<f64>);

/// A realised model sample by sample, by `hysteron-rt`.
#[derive(Debug)]
pub struct Stream<'a>(hysteron_rt::Model<'a, f64>);

impl StreamParts {
    /// The parts of a realisation.
    ///
    /// # Errors
    /// Those of [`RuntimeParts::new`].
    pub fn new(realisation: &Realisation) -> Result<Self, RealiseError> {
        RuntimeParts::new(realisation).map(Self)
    }

    /// The model, at rest and virgin at 0 V.
    ///
    /// # Errors
    /// Those of [`RuntimeParts::model`].
    pub fn stream(&mut self) -> Result<Stream<'_>, RealiseError> {
        self.0.model().map(Stream)
    }
}

impl Stream<'_> {
    /// Resets the model to rest, its hysteresis virgin, at `voltage` \[V\]; returns the displacement there
    /// \[µm\].
    ///
    /// # Errors
    /// [`RealiseError::Step`] for a voltage that is not finite.
    pub fn rest_at(&mut self, voltage: f64) -> Result<f64, RealiseError> {
        Ok(self.0.rest_at(voltage)?)
    }

    /// Displacement \[µm\] after a monotone move to `voltage` \[V\] within one sample period.
    ///
    /// # Errors
    /// [`RealiseError::Step`].
    #[inline]
    pub fn step(&mut self, voltage: f64) -> Result<f64, RealiseError> {
        Ok(self.0.step(voltage)?)
    }

    /// Displacements along a drive.
    ///
    /// # Errors
    /// Those of [`Self::step`].
    pub fn run(&mut self, drive: &[f64], out: &mut [f64]) -> Result<(), RealiseError> {
        for (y, &u) in out.iter_mut().zip(drive) {
            *y = self.step(u)?;
        }
        Ok(())
    }
}

/// Nanoseconds per sample of each stream along `drive`: the least of `rounds` passes, which the streams take
/// in turn, so that other load on the machine affects all of them; `now` is a clock with any origin.
///
/// # Errors
/// Those of [`Stream::step`].
pub fn nanoseconds_per_sample(
    streams: &mut [Stream<'_>],
    drive: &[f64],
    rounds: usize,
    now: &dyn Fn() -> Duration,
) -> Result<Vec<f64>, RealiseError> {
    let mut least = vec![f64::INFINITY; streams.len()];
    let mut out = vec![0.0; drive.len()];
    let first = drive.first().copied().unwrap_or(0.0);
    for _ in 0..rounds {
        for (stream, least) in streams.iter_mut().zip(&mut least) {
            stream.rest_at(first)?;
            let start = now();
            stream.run(drive, &mut out)?;
            std::hint::black_box(&out);
            *least = least.min(now().saturating_sub(start).as_secs_f64() * 1e9 / drive.len().max(1) as f64);
        }
    }
    Ok(least)
}
