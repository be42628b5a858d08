//! The inverse as C99 source: reference in, voltage out.

use hysteron_model::compensator::{Compensation, CompensatorParts};
use hysteron_model::realise::Realisation;
use hysteron_rt::Real;

use crate::c::{Numbers, description_comment, filling, rows};
use crate::dry_run::{Compared, DryRun, still};
use crate::error::ExportError;
use crate::golden::{Rounding, patience, samples_of};
use crate::number::Precision;
use crate::saved;
use crate::subject::{Subject, significant};
use crate::template::Filling;
use hysteron_io::NamedFile;

const HEADER: &str = concat!(
    include_str!("../templates/c/inverse_top.h"),
    include_str!("../templates/c/parameters.h"),
    include_str!("../templates/c/inverse_state.h"),
    include_str!("../templates/c/members.h"),
    include_str!("../templates/c/inverse_bottom.h")
);
const SOURCE: &str = concat!(
    include_str!("../templates/c/opening.c"),
    include_str!("../templates/c/hysteresis.c"),
    include_str!("../templates/c/dynamics.c"),
    include_str!("../templates/c/inverse.c"),
    include_str!("../templates/c/saved.c")
);
const SELFTEST: &str = include_str!("../templates/c/inverse_selftest.c");
const LOOP: &str = include_str!("../templates/c/loop.c");

/// A compensator to export, with its model.
#[derive(Clone, Debug)]
pub struct Inverse {
    /// The model with the dynamics that the compensator runs: under zero-order hold, without the whole
    /// samples of delay.
    pub subject: Subject,
    /// The law.
    pub compensation: Compensation,
    /// Least and largest voltage.
    pub range_v: [f64; 2],
    /// Largest rate of the voltage \[V/s\]; infinite for none.
    pub slew_v_per_s: f64,
    /// Bound on the rounding error of the voltage.
    pub rounding: Rounding,
    /// Departure of the number type from double precision.
    pub dry_run: DryRun,
}

impl Inverse {
    /// The inverse of the model of `subject`, under its name and `_inverse`.
    ///
    /// # Errors
    /// Those of [`CompensatorParts::new`]; [`ExportError::Rounding`] where single precision is too coarse for
    /// the voltage, [`ExportError::Departs`] where a dry run fails the self-test, [`ExportError::Still`]
    /// where the voltage does not move.
    pub fn new(
        subject: &Subject,
        compensation: Compensation,
        range_v: [f64; 2],
        slew_v_per_s: f64,
    ) -> Result<Self, ExportError> {
        CompensatorParts::<f64>::new(&compensation, range_v, slew_v_per_s)?;
        let mut dynamics = compensation.dynamics.clone();
        dynamics.delay_samples = 0;
        let realisation = Realisation {
            model: compensation.model.clone(),
            dynamics,
            sample_rate_hz: compensation.sample_rate_hz,
            joins_means: false,
        };
        let subject = Subject { name: format!("{}_inverse", subject.name), realisation, ..subject.clone() };
        let rounding = Rounding { bound: 0.0, share: 0.0 };
        let dry_run = DryRun::NONE;
        let mut inverse = Self { subject, compensation, range_v, slew_v_per_s, rounding, dry_run };
        let golden = GoldenInverse::new(&inverse)?;
        let stated = |unit: &str, bound| Rounding::new("voltage", unit, bound, range_v[1] - range_v[0]);
        inverse.rounding = stated(&inverse.subject.input_unit, golden.tolerance)?;
        inverse.dry_run = DryRun::new(&inverse, &golden)?;
        if inverse.dry_run.drifts() {
            inverse.rounding = stated(&inverse.subject.input_unit, inverse.dry_run.stated())?;
        }
        Ok(inverse)
    }

    /// Least and largest voltage and its largest change in a sample, rounded inwards to the number type.
    pub(crate) fn limits(&self) -> [f64; 3] {
        let precision = self.subject.precision;
        let [low, high] = self.range_v;
        let step = self.slew_v_per_s / self.compensation.sample_rate_hz;
        [precision.at_least(low), precision.at_most(high), precision.at_most(step)]
    }

    /// What a dry run of it compares.
    pub(crate) fn compared(&self) -> Compared<'_> {
        Compared { what: "inverse", unit: &self.subject.input_unit, range: self.range_v }
    }

    /// Displacements at rest at the ends of the range, and half-way.
    pub(crate) fn displacements(&self) -> Result<[f64; 3], ExportError> {
        let mut parts = CompensatorParts::<f64>::new(&self.compensation, self.range_v, self.slew_v_per_s)?;
        let mut compensator = parts.compensator()?;
        let [low, high] = self.range_v;
        let half_way = self.subject.precision.round(0.5 * (low + high));
        match [low, high, half_way].map(|voltage| compensator.rest_at(voltage)) {
            [Ok(bottom), Ok(top), Ok(middle)] => Ok([bottom, top, middle]),
            _ => Err(ExportError::Template { place: "the displacement at the ends of the range".into() }),
        }
    }

    /// Sum of magnitudes in a voltage, per unit of displacement in the law.
    pub(crate) fn sensitivity(&self) -> Result<f64, ExportError> {
        let [bottom, top, _] = self.displacements()?;
        let law = &self.compensation;
        let gains = law.recent.iter().chain(law.states.iter().flatten()).map(|k| k.abs()).sum::<f64>()
            + law.reference.iter().map(|k| k.abs()).sum::<f64>()
                * law.dynamics.amplification()
                * law.dynamics.reference_gain;
        let [low, high] = self.range_v;
        Ok((1.0 + gains) * (high - low) / (top - bottom).abs())
    }

    /// Description for the heads of the sources, as [`Subject::description`].
    pub(crate) fn description(&self) -> Vec<String> {
        let subject = &self.subject;
        let mut lines = vec![
            format!(
                "{}: the inverse of a model, sample by sample: reference in {}, voltage out {}.",
                subject.name, subject.output_unit, subject.input_unit
            ),
            format!(
                "Follows up to {} Hz; the reference is known {} samples ahead; white noise on the reference \
                 is passed on {:.3} times as large.",
                self.compensation.bandwidth_hz, self.compensation.preview, self.compensation.noise_gain
            ),
        ];
        if subject.precision == Precision::F32 {
            lines.push(self.rounding.in_words("voltage", &subject.input_unit));
            lines.extend(self.dry_run.in_words(&self.compared()).iter().map(|line| format!("NOTE: {line}")));
        }
        lines.extend([String::new(), "The model:".into()]);
        lines.extend(subject.description());
        lines
    }
}

/// The inverse as C99: `NAME_inverse.h`, `NAME_inverse.c`, `NAME_inverse_selftest.c` with golden vectors and
/// `NAME_inverse_loop.c`, a loop around it.
///
/// # Errors
/// Those of [`Inverse::new`].
pub fn inverse_files(inverse: &Inverse) -> Result<Vec<NamedFile>, ExportError> {
    let mut filling = inverse_filling(inverse, Numbers::Constant)?;
    let name = &inverse.subject.name;
    let mut files = inverse_core(inverse, &filling)?;
    let (samples, left) = settles(&inverse.compensation);
    let of = significant(samples as f64 / inverse.compensation.sample_rate_hz);
    let words =
        format!("Samples to wait after a move, {of} s: {} of the response remains.", significant(left));
    filling.key("SETTLES", samples).key("SETTLES_IN_WORDS", words);
    files.push(NamedFile::new(format!("{name}_loop.c"), filling.fill(LOOP)?));
    golden_inverse_keys(&mut filling, inverse, &|x| inverse.subject.precision.c_literal(x))?;
    files.push(NamedFile::new(format!("{name}_selftest.c"), filling.fill(SELFTEST)?));
    Ok(files)
}

/// Remaining share of a move at which the stage counts as settled, and the longest wait for it \[s\].
const SETTLED: f64 = 1e-3;
const LONGEST_S: f64 = 10.0;

/// Settling time to within [`SETTLED`] of a move \[samples\], and the share that remains then: creep that
/// takes longer than [`LONGEST_S`] continues.
fn settles(law: &Compensation) -> (usize, f64) {
    let dynamics = &law.dynamics;
    let left = |samples: f64| {
        let decays = dynamics.sections.iter().map(|s| {
            let rate = s.rate(law.sample_rate_hz) / law.sample_rate_hz;
            s.weight.norm() * (-rate * samples).exp()
        });
        decays.sum::<f64>() / dynamics.reference_gain
    };
    let (mut low, mut high) = (0.0, (LONGEST_S * law.sample_rate_hz).ceil());
    while high - low > 1.0 {
        let middle = (0.5 * (low + high)).floor();
        if left(middle) > SETTLED { low = middle } else { high = middle }
    }
    (high as usize + dynamics.delay_samples + dynamics.taps.len(), left(high))
}

/// Header and source.
pub(crate) fn inverse_core(inverse: &Inverse, filling: &Filling) -> Result<Vec<NamedFile>, ExportError> {
    let Subject { precision, origin, .. } = &inverse.subject;
    saved::header_and_source(&mut filling.clone(), *precision, (HEADER, SOURCE), &origin.model_sha256)
}

pub(crate) fn inverse_filling(inverse: &Inverse, numbers: Numbers) -> Result<Filling, ExportError> {
    match inverse.subject.precision {
        Precision::F32 => of_type::<f32>(inverse, numbers),
        Precision::F64 => of_type::<f64>(inverse, numbers),
    }
}

fn of_type<T: Real + Into<f64>>(inverse: &Inverse, numbers: Numbers) -> Result<Filling, ExportError> {
    let precision = inverse.subject.precision;
    let mut filling = filling(&inverse.subject, numbers)?;
    let law = &inverse.compensation;
    let literal = |x: f64| precision.c_literal(x);
    let limit =
        |x: f64| if x.is_finite() { format!("({})", literal(x)) } else { precision.c_infinity().into() };
    let [low, high, step] = inverse.limits().map(limit);
    let mut tables = filling.text("TABLES").to_owned();
    let mut table = |comment: &str, declaration: String, content: String| {
        tables.push_str(&format!("/* {comment} */\nstatic const {declaration} = {{\n{content}\n}};\n"));
    };
    let all = |numbers: &[f64]| rows(numbers.iter().map(|&x| literal(x)));
    let sections = || law.dynamics.sections.iter().zip(&law.states);
    let real: Vec<f64> = sections().filter(|(s, _)| !s.is_pair()).map(|(_, [re, _])| *re).collect();
    let pairs: Vec<[f64; 2]> = sections().filter(|(s, _)| s.is_pair()).map(|(_, gains)| *gains).collect();
    if !law.recent.is_empty() {
        table(
            "The law: gains on the outputs of the hysteresis before the last.",
            format!("real LAW_RECENT[{}]", law.recent.len()),
            all(&law.recent),
        );
    }
    if !real.is_empty() {
        table("Gains on the real poles.", format!("real LAW_REAL[{}]", real.len()), all(&real));
    }
    if !pairs.is_empty() {
        let content = rows(pairs.iter().map(|[re, im]| format!("{{{}, {}}}", literal(*re), literal(*im))));
        table("Gains on the pole pairs.", format!("real LAW_PAIR[{}][2]", pairs.len()), content);
    }
    table(
        "Gains on the reference, the newest first.",
        format!("real LAW_REFERENCE[{}]", law.reference.len()),
        all(&law.reference),
    );
    tables.push_str(&format!(
        "/* Gain of taps and sections at rest. */\nstatic const real GAIN = {};\n",
        literal(gain::<T>(law).into())
    ));
    filling
        .key("TABLES", tables)
        .key("DESCRIPTION", description_comment(&inverse.description()))
        .key("LIMIT_LOW", low)
        .key("LIMIT_HIGH", high)
        .key("LIMIT_STEP", step)
        .key("N_PREVIEW", law.preview)
        .key("N_REFERENCES", law.reference.len())
        .key("N_LAW_RECENT", law.recent.len())
        .key("MOST_LOOKS", hysteron_rt::MOST_LOOKS)
        .flag("looks", true)
        .flag("no_slew", !inverse.slew_v_per_s.is_finite())
        .flag("law_recent", !law.recent.is_empty());
    Ok(filling)
}

/// Σ taps + Σ weights, in the order of the runtime.
fn gain<T: Real>(law: &Compensation) -> T {
    let sum = |sum: T, x: f64| sum + T::of(x);
    let dynamics = &law.dynamics;
    let taps = dynamics.taps.iter().fold(T::of(0.0), |s, &x| sum(s, x));
    let single: Vec<f64> = dynamics.sections.iter().filter(|s| !s.is_pair()).map(|s| s.weight.re).collect();
    let real = single
        .chunks(hysteron_rt::LANES)
        .fold(taps, |all, group| all + group.iter().fold(T::of(0.0), |s, &x| sum(s, x)));
    dynamics.sections.iter().filter(|s| s.is_pair()).fold(real, |s, pair| sum(s, pair.weight.re))
}

/// Tolerance in double precision: share of the range of the voltage.
pub(crate) const DOUBLE: f64 = 1e-12;
/// Tolerance in single precision: units of rounding (2^-23) of the sum of magnitudes for a voltage.
pub(crate) const SINGLE: f64 = 16.0;
const SAMPLES: usize = 640;
/// References from this one on are held, as voltages are in the self-test of a model: the steps alone, as a
/// staircase sine would drive a fast law from limit to limit, where single and double precision diverge.
const HELD_FROM: usize = 3 * SAMPLES / 4;
/// Multiple of the tolerance below which a voltage counts as constant.
const STILL: f64 = 10.0;
/// Share of the range that a slow slew limit is to cross in a self-test, and the most samples for it.
const CROSSED: f64 = 0.4;
const MOST_FOR_SLEW: f64 = 200_000.0;

/// Sets what the self-test is filled with, in literals of its language.
pub(crate) fn golden_inverse_keys(
    filling: &mut Filling,
    inverse: &Inverse,
    literal: &dyn Fn(f64) -> String,
) -> Result<(), ExportError> {
    let vectors = GoldenInverse::new(inverse)?;
    filling
        .key("SAMPLES", SAMPLES)
        .key("HELD_FROM", HELD_FROM)
        .key("HOLD", vectors.hold)
        .key("REST", literal(vectors.rest_v))
        .key("REFERENCES", rows(vectors.references.iter().map(|&x| literal(x))))
        .key("VOLTAGES", rows(vectors.voltages.iter().map(|&x| literal(x))))
        .key("TOLERANCE", literal(vectors.tolerance))
        .key("TOLERANCE_IN_WORDS", inverse.dry_run.tolerance_in_words(inverse.subject.precision));
    Ok(())
}

/// Golden vectors of a compensator.
#[derive(Clone, Debug, PartialEq)]
pub struct GoldenInverse {
    /// Voltage of the initial rest.
    pub rest_v: f64,
    /// References, exact in the number type of the export.
    pub references: Vec<f64>,
    /// Samples that each of the steps is held; those of the sine last one each.
    pub hold: usize,
    /// The library's voltages in double precision, at the end of each reference.
    pub voltages: Vec<f64>,
    /// Largest difference that the exported source may show.
    pub tolerance: f64,
}

impl GoldenInverse {
    /// Samples that reference `k` lasts.
    pub fn lasts(&self, k: usize) -> usize {
        samples_of(k, HELD_FROM, self.hold)
    }

    /// The vectors: a sine through most of the range, then steps that reach the limits.
    ///
    /// # Errors
    /// Those of [`Inverse::new`]; [`ExportError::Still`] where no voltage moves.
    pub fn new(inverse: &Inverse) -> Result<Self, ExportError> {
        let precision = inverse.subject.precision;
        let [low, high] = inverse.range_v;
        let mut parts =
            CompensatorParts::<f64>::new(&inverse.compensation, inverse.range_v, inverse.slew_v_per_s)?;
        let mut compensator = parts.compensator()?;
        let rest_v = precision.round(0.5 * (low + high));
        if compensator.rest_at(rest_v).is_err() {
            return Err(still());
        }
        let [bottom, top, middle] = inverse.displacements()?;
        let references: Vec<f64> = (0..SAMPLES)
            .map(|k| {
                let phase = 4.0 * std::f64::consts::TAU * k as f64 / SAMPLES as f64;
                let swing = if k < HELD_FROM { 0.35 * phase.sin() } else { 0.7 * phase.sin().signum() };
                precision.round(middle + swing * (top - bottom).abs())
            })
            .collect();
        let law = &inverse.compensation;
        let slewed = CROSSED * (high - low) * law.sample_rate_hz / inverse.slew_v_per_s;
        let lasts = patience(&law.dynamics, law.reference.len(), law.sample_rate_hz)
            .max(slewed.min(MOST_FOR_SLEW) as usize);
        let hold = lasts.div_ceil(SAMPLES - HELD_FROM);
        let mut held = |(k, &r): (usize, &f64)| {
            for _ in 1..samples_of(k, HELD_FROM, hold) {
                compensator.step(r);
            }
            compensator.step(r).voltage
        };
        let voltages: Vec<f64> = references.iter().enumerate().map(&mut held).collect();
        let span = references.iter().fold(0.0_f64, |most, r| most.max(r.abs())) + (top - bottom).abs();
        let tolerance = match precision {
            Precision::F64 => DOUBLE * (high - low),
            Precision::F32 if inverse.dry_run.drifts() => inverse.dry_run.stated(),
            Precision::F32 => SINGLE * precision.epsilon() * inverse.sensitivity()? * span,
        };
        // Too coarse a precision is reported by [`Rounding::new`]; a voltage below its tolerance would seem
        // constant.
        let too_coarse = tolerance > Rounding::MOST * (high - low);
        if !too_coarse && !voltages.iter().any(|u| (u - rest_v).abs() > STILL * tolerance) {
            return Err(ExportError::Still { what: "voltage" });
        }
        Ok(Self { rest_v, references, hold, voltages, tolerance })
    }
}
