//! The search for the best drive.

use std::sync::Arc;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::assumptions::{ABOVE_RESONANCE, assumed};
use super::candidates::{Segment, candidates, minor_loops, random_motion, usual};
use super::information::{Noise, Weighted, information};
use super::limits::{Limits, SAMPLES_A_PERIOD};
use super::objective::{Objective, exchanged, ranked};
use super::outcome::{Design, Expected};
use super::prior::Prior;
use super::quantities::{creeps, gradients, lasts_for_creep, quantities_of, resonance_hz};
use super::record::Records;
use super::{DesignBasis, DesignOptions, Purpose};
use crate::IdentifyError;
use crate::uncertainty::correlation_time;
use hysteron_model::dynamics::Dynamics;
use hysteron_model::hammerstein::Model;
use hysteron_model::record::Unit;
use hysteron_model::{Finding, FindingKind};
use hysteron_numeric::display::short_to;
use hysteron_numeric::{Listener, Meter};

/// Numbers of segments of a drive.
const DIVISIONS: [usize; 3] = [2, 4, 8];
/// Most samples of a motion along which the output is to be predicted.
const MOST_OF_MOTION: usize = 20_000;
/// Levels of the random minor loops there.
const TURNS: usize = 24;
/// Work of the last exchanges, each of a whole drive: samples simulated.
const WORK: usize = 20_000_000;
/// Most of them.
const MOST_EXCHANGES: usize = 12;
/// Highest frequency under the sample rate, where the records have no resonance.
const UNDER_RATE: f64 = 20.0;
/// Samples of the fastest period while segments are chosen, and the fewest where there is much to simulate:
/// more samples than this for all segments of a division.
const COARSE: f64 = 1.5 * SAMPLES_A_PERIOD;
const COARSEST: f64 = 5.0;
const MUCH: usize = 20_000_000;
/// Fewest samples of a segment then.
const FEWEST_COARSE: usize = 50;
/// Range of the output over the widest of the records from which it is remarked on.
const WIDER: f64 = 1.2;
/// Largest noise: its square is a number, and so are its samples.
const MOST_NOISE: f64 = 1e50;
/// Share of the work that choosing the segments is.
const CHOOSING: f64 = 0.7;

/// See [`super::design`].
pub(super) fn design(
    basis: &DesignBasis,
    options: &DesignOptions,
    listener: Listener<'_>,
) -> Result<Design, IdentifyError> {
    let mut findings = Vec::new();
    let experiment = Experiment::new(basis, options, &mut findings)?;
    let aim = experiment.objective(options.purpose)?;
    let nothing = Weighted::nothing(experiment.prior.count());
    let now = aim.error(&nothing);
    if !(now > 0.0 && now.is_finite()) {
        return Err(IdentifyError::NothingUncertain { what: options.purpose.name() });
    }
    let best = experiment.best(&aim, options.seed, listener.part(0.0, 0.95))?;
    let usual = experiment.limits.drive(&usual(&experiment.limits));
    let of_usual = experiment.records().weighted(
        &usual,
        &experiment.noise,
        &listener.part(0.95, 1.0).meter("comparison", experiment.prior.count()),
    )?;
    let error_of_usual = aim.error(&of_usual);
    let best = if aim.error(&best.information) <= error_of_usual {
        best
    } else {
        let words = vec!["the usual loop".to_owned(), "and sweep".to_owned()];
        Drive { words, drive: usual.clone(), information: of_usual.clone() }
    };
    let usual_repetitions = aim.repetitions(&of_usual, aim.error(&best.information));
    let expected = experiment.expected(options.purpose, [&nothing, &best.information, &of_usual])?;
    let stroke = experiment.records().stroke(&best.drive)?;
    findings.extend(experiment.remarks(basis, stroke));
    Ok(Design {
        purpose: options.purpose,
        drive: best.drive,
        usual,
        motion: experiment.motion(options.purpose),
        sample_rate_hz: experiment.limits.rate_hz,
        highest_hz: experiment.limits.highest_hz,
        unit: basis.file().units.input.clone(),
        segments: best.words,
        expected,
        stroke,
        noise: experiment.noise.deviation(),
        usual_repetitions,
        findings,
    })
}

/// A whole drive.
struct Drive {
    words: Vec<String>,
    drive: Vec<f64>,
    information: Weighted,
}

/// Everything that a drive is judged by.
struct Experiment {
    prior: Prior,
    model: Model,
    limits: Limits,
    noise: Noise,
    resonance_hz: Option<f64>,
    output_unit: String,
    time_s: f64,
    seed: u64,
}

impl Experiment {
    fn new(
        basis: &DesignBasis,
        options: &DesignOptions,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, IdentifyError> {
        let file = basis.file();
        let valid = file.valid_range.as_ref();
        let missing = |option, wanted| IdentifyError::Option { option, value: 0.0, wanted };
        let rate_hz = options.sample_rate_hz.or(file.sample_rate_hz);
        let rate_hz = rate_hz.ok_or_else(|| missing("sample rate", "a rate: the model has none"))?;
        let range = options.range.or(valid.map(|v| [v.input.low, v.input.high]));
        let range = range.ok_or_else(|| missing("range", "a range: the model file states none"))?;
        let slew = options.slew_per_s.or(valid.and_then(|v| v.rate.as_ref()).map(|rate| rate.high));
        let slew = slew.ok_or_else(|| missing("slew rate", "a slew rate: the model file states none"))?;
        let covered = valid.and_then(|v| v.frequency.as_ref()).map_or(0.0, |f| f.high);
        let model = file.to_model()?;
        let own_resonance = resonance_hz(&model);
        let top = rate_hz / SAMPLES_A_PERIOD;
        let is_fast = matches!(options.purpose, Purpose::Delay | Purpose::Resonance);
        let asked_hz = options.resonance_hz.filter(|f| options.purpose == Purpose::Resonance && *f > 0.0);
        let sought_hz = own_resonance.or(asked_hz);
        let highest_hz = options.highest_hz.unwrap_or_else(|| match sought_hz {
            Some(resonance) => (ABOVE_RESONANCE * resonance).max(covered).min(top),
            None if is_fast => covered.max(rate_hz / UNDER_RATE).min(top),
            None if covered > 0.0 => covered.min(top),
            None => top,
        });
        let limits = Limits::new(range, slew, rate_hz, options.time_s, highest_hz)?;
        if let Some(value) = options.resonance_hz.filter(|f| !(*f > 0.0 && *f < 0.5 * rate_hz)) {
            let wanted = "above 0 and below half the sample rate";
            return Err(IdentifyError::Option { option: "resonance", value, wanted });
        }
        let mut undetermined: Vec<(String, f64)> =
            basis.undetermined.iter().map(|name| (name.clone(), 0.0)).collect();
        if options.purpose == Purpose::Delay {
            undetermined.push(("delay".to_owned(), 0.1 / highest_hz));
        }
        if let Some(valid) = valid.filter(|valid| valid.is_left_by((range[0], range[1]))) {
            let [low, high] = range.map(|end| short_to(end, 3));
            let unit = Unit::new(&valid.input.unit).spaced();
            let text = format!(
                "The drive goes from {low} to {high}{unit}, the records of the model from {} to {}{unit}: beyond \
                 these the model extrapolates, and the figures with it.",
                short_to(valid.input.low, 3),
                short_to(valid.input.high, 3)
            );
            findings.push(Finding::new(FindingKind::Warning, "range", text));
        }
        if options.purpose == Purpose::Creep && !lasts_for_creep(&model, options.time_s) {
            let wanted = "longer for creep: at ten times its inverse other dynamics lag";
            return Err(IdentifyError::Option { option: "time", value: options.time_s, wanted });
        }
        let assumed = assumed(options, &model, own_resonance, &limits, findings);
        let prior = Prior::new(file, &undetermined)?.assuming(assumed);
        let model = prior.model()?;
        let noise = noise(basis, options.noise, rate_hz)?;
        Ok(Self {
            resonance_hz: prior.assumed_resonance(0, 0.0).map(|(f, _)| f).or_else(|| resonance_hz(&model)),
            prior,
            model,
            limits,
            noise,
            output_unit: file.units.output.clone(),
            time_s: options.time_s,
            seed: options.seed,
        })
    }

    /// The records that drives at this sample rate give.
    fn records(&self) -> Records<'_> {
        let limits = &self.limits;
        Records { prior: &self.prior, model: &self.model, rest_v: limits.rest(), rate_hz: limits.rate_hz }
    }

    /// What a purpose asks for.
    fn objective(&self, purpose: Purpose) -> Result<Objective, IdentifyError> {
        let quantities = quantities_of(purpose);
        if !quantities.is_empty() {
            let gradients = gradients(quantities, &self.prior, self.time_s);
            let missing = IdentifyError::NothingUncertain { what: purpose.name() };
            return gradients.map(Objective::Quantities).ok_or(missing);
        }
        let motion = self.motion(purpose);
        let columns = self.records().derivatives(&motion, &Meter::silent())?;
        Ok(Objective::Output(information(&columns, &Noise::White((motion.len() as f64).sqrt()))))
    }

    /// Motion along which the output is to be predicted; empty for a purpose that is for quantities.
    fn motion(&self, purpose: Purpose) -> Vec<f64> {
        let limits = Limits { samples: self.limits.samples.min(MOST_OF_MOTION), ..self.limits };
        // Another seed than that of any segment: the motion to predict is not one that is measured.
        let seed = self.seed.wrapping_add(0x5eed);
        match purpose {
            Purpose::MinorLoops => limits.followed(minor_loops(&limits, TURNS, seed)),
            Purpose::Prediction => limits.followed(random_motion(&limits, seed)),
            Purpose::Delay | Purpose::Resonance | Purpose::Creep => Vec::new(),
        }
    }

    /// The best drive.
    fn best(&self, aim: &Objective, seed: u64, listener: Listener<'_>) -> Result<Drive, IdentifyError> {
        let mut best: Option<(f64, Drive, Chosen)> = None;
        for (index, divisions) in DIVISIONS.into_iter().enumerate() {
            let share = |i: usize| CHOOSING * i as f64 / DIVISIONS.len() as f64;
            let part = listener.part(share(index), share(index + 1));
            for chosen in self.chosen(aim, divisions, seed, part)? {
                let drive = self.joined(&chosen, &Meter::silent())?;
                let error = aim.error(&drive.information);
                if best.as_ref().is_none_or(|(least, ..)| error < *least) {
                    best = Some((error, drive, chosen));
                }
            }
        }
        let Some((mut error, mut drive, mut chosen)) = best else { return Err(IdentifyError::Stopped) };
        let a_drive = self.limits.samples * 2 * self.prior.count().max(1);
        let exchanges = (WORK / a_drive).min(MOST_EXCHANGES);
        let meter = listener.part(CHOOSING, 1.0).meter("whole drives", exchanges * self.prior.count());
        // Whole drives, with the segment exchanged that promises most beside the others.
        for trial in 0..exchanges {
            let other = chosen.neighbour(aim, trial);
            let tried = self.joined(&other, &meter)?;
            let less = aim.error(&tried.information);
            if less < error {
                (error, drive, chosen) = (less, tried, other);
            }
        }
        Ok(drive)
    }

    /// Segments of a drive in so many parts, by the sum of their information: as it is, and with the weight
    /// that the fit would give each.
    fn chosen(
        &self,
        aim: &Objective,
        divisions: usize,
        seed: u64,
        listener: Listener<'_>,
    ) -> Result<[Chosen; 2], IdentifyError> {
        let one_rate = matches!(self.model.dynamics, Dynamics::Arx(_))
            || self.model.scheme.parameters_belong_to_sample_rate();
        let a_period = self.limits.rate_hz / self.limits.highest_hz;
        let limits = Limits { samples: self.limits.samples / divisions, ..self.limits };
        let segments = candidates(&limits, self.resonance_hz, seed);
        let simulated = segments.len() * limits.samples * 2 * self.prior.count();
        let coarser = simulated.div_ceil(MUCH).min((a_period / COARSEST) as usize);
        let coarser = coarser.max((a_period / COARSE) as usize);
        let most = if one_rate { 1 } else { (limits.samples / FEWEST_COARSE).max(1) };
        let coarser = coarser.clamp(1, most);
        let coarse = limits.coarser(coarser);
        let noise = self.noise.coarser(coarser);
        let meter = listener.meter("segments", segments.len() * self.prior.count());
        let (records, fine) = (Records { rate_hz: coarse.rate_hz, ..self.records() }, self.records());
        let (information, weighted) = segments
            .par_iter()
            .map(|segment| {
                let drive = coarse.followed(segment.targets(&coarse));
                let own = information(&records.derivatives(&drive, &meter)?, &noise);
                let weight = fine.weight(&limits.followed(segment.targets(&limits)), &self.noise)?;
                Ok((own.clone(), own * weight))
            })
            .collect::<Result<Vec<_>, IdentifyError>>()?
            .into_iter()
            .unzip::<_, _, Vec<_>, Vec<_>>();
        let go_on = || listener.tell("exchange", 1.0).map_err(|_| IdentifyError::Stopped);
        let segments = Arc::new(segments);
        let of = |information: Vec<DMatrix<f64>>| -> Result<Chosen, IdentifyError> {
            let list = exchanged(aim, &information, divisions, go_on)?;
            let candidates = Candidates { limits, segments: Arc::clone(&segments), information };
            Ok(Chosen { candidates: Arc::new(candidates), list })
        };
        Ok([of(information)?, of(weighted)?])
    }

    /// The drive of chosen segments, joined within the slew rate, and its own information.
    fn joined(&self, chosen: &Chosen, meter: &Meter<'_>) -> Result<Drive, IdentifyError> {
        let of = &chosen.candidates;
        let segments = || chosen.list.iter().map(|&i| &of.segments[i]);
        let mut targets: Vec<f64> = segments().flat_map(|segment| segment.targets(&of.limits)).collect();
        targets.resize(self.limits.samples, self.limits.rest());
        let drive = self.limits.drive(&targets);
        let information = self.records().weighted(&drive, &self.noise, meter)?;
        Ok(Drive { words: segments().map(|segment| segment.words.clone()).collect(), drive, information })
    }

    /// Standard errors now, after the drive, after loop and sweep, of everything that the model has.
    fn expected(
        &self,
        purpose: Purpose,
        informations: [&Weighted; 3],
    ) -> Result<Vec<Expected>, IdentifyError> {
        let covariances = informations.map(Weighted::covariance);
        let mut rows = Vec::new();
        for of in Purpose::ALL {
            for &quantity in quantities_of(of) {
                let Some(gradient) = gradients(&[quantity], &self.prior, self.time_s) else { continue };
                let value = quantity.value(&self.prior, self.time_s);
                // Gradients are relative to the value.
                let scale = value.map_or(1.0, |v| if v == 0.0 { 1.0 } else { v.abs() });
                let errors = errors(&Objective::Quantities(gradient * scale), &covariances);
                let name = quantity.name().to_owned();
                rows.push((of, name, quantity.unit().to_owned(), value, errors));
            }
        }
        for (of, name) in [
            (Purpose::MinorLoops, "output along minor loops"),
            (Purpose::Prediction, "output along random motion"),
        ] {
            let errors = errors(&self.objective(of)?, &covariances);
            rows.push((of, name.to_owned(), self.output_unit.clone(), None, errors));
        }
        let creeping = creeps(&self.model, self.time_s);
        let known = |(of, .., [now, _, _]): &(Purpose, String, String, Option<f64>, [f64; 3])| {
            *now > 0.0 && (*of != Purpose::Creep || creeping || purpose == Purpose::Creep)
        };
        Ok(rows
            .into_iter()
            .filter(known)
            .map(|(of, name, unit, value, [now, designed, usual])| Expected {
                name,
                unit,
                value,
                now,
                designed,
                usual,
                aim: of == purpose,
            })
            .collect())
    }

    /// What the figures rest on.
    fn remarks(&self, basis: &DesignBasis, stroke: f64) -> Vec<Finding> {
        let mut found = Vec::new();
        let mut say = |kind, topic: &'static str, text: String| found.push(Finding::new(kind, topic, text));
        if basis.file().misfit.is_some() {
            say(
                FindingKind::Warning,
                "model class",
                "The device is outside the model class: the standard errors fall as stated, the error of the \
                 class does not."
                    .to_owned(),
            );
        }
        let scores = basis.file().scores.iter();
        let measured =
            scores.filter_map(|s| Some(100.0 * s.rmse / s.rmse_percent_of_stroke?)).fold(0.0, f64::max);
        if measured > 0.0 && stroke > WIDER * measured {
            let unit = Unit::new(&self.output_unit).spaced();
            let text = format!(
                "By the model the output moves over {}{unit}, {} times as far as in its records: see that \
                 stage and sensor allow it, else narrow the range or lower the slew rate.",
                short_to(stroke, 3),
                short_to(stroke / measured, 2)
            );
            say(FindingKind::Warning, "stroke", text);
        }
        if matches!(self.noise, Noise::White(_)) && basis.residual.is_none() {
            let text = "The noise is taken as white: a model file does not hold its spectrum. Design from \
                        the records where their residual is coloured.";
            say(FindingKind::Advice, "noise", text.to_owned());
        }
        found
    }
}

/// Segments to choose from, with the information of each.
struct Candidates {
    limits: Limits,
    segments: Arc<Vec<Segment>>,
    information: Vec<DMatrix<f64>>,
}

/// Chosen segments, in order.
#[derive(Clone)]
struct Chosen {
    candidates: Arc<Candidates>,
    list: Vec<usize>,
}

impl Chosen {
    /// The list with one segment, in turn by `trial`, exchanged for the best other one.
    fn neighbour(&self, aim: &Objective, trial: usize) -> Self {
        let mut list = self.list.clone();
        let slot = trial % list.len().max(1);
        let Some(&own) = list.get(slot) else { return self.clone() };
        let others = list.iter().enumerate().filter(|(i, _)| *i != slot);
        let information = &self.candidates.information;
        let count = information[own].nrows();
        let rest = others.fold(DMatrix::zeros(count, count), |sum, (_, &i)| sum + &information[i]);
        // The next best in each further round over the slots.
        let mut others = ranked(aim, information, &rest).into_iter().filter(|(index, _)| *index != own);
        if let Some((index, _)) = others.nth(trial / list.len()) {
            list[slot] = index;
        }
        Self { list, candidates: Arc::clone(&self.candidates) }
    }
}

fn errors(objective: &Objective, covariances: &[Option<DMatrix<f64>>; 3]) -> [f64; 3] {
    covariances.each_ref().map(|c| c.as_ref().map_or(f64::NAN, |c| objective.error_of(c)))
}

/// The noise of a record at this rate \[Hz\].
fn noise(basis: &DesignBasis, given: Option<f64>, rate_hz: f64) -> Result<Noise, IdentifyError> {
    let refuse = |value| {
        let wanted = "a standard deviation above 0, of at most 1e50";
        Err(IdentifyError::Option { option: "noise", value, wanted })
    };
    match (given, basis.coloured()) {
        (Some(noise), _) if noise > 0.0 && noise <= MOST_NOISE => Ok(Noise::White(noise)),
        (Some(noise), _) => refuse(noise),
        (None, Some((residual, own_hz))) if (own_hz - rate_hz).abs() < 1e-6 * rate_hz => {
            Ok(Noise::Like(residual.clone()))
        }
        // At another rate: as many independent samples as in the record, in the same time.
        (None, Some((residual, own_hz))) => {
            let correlated = (correlation_time(residual) * rate_hz / own_hz).max(1.0);
            Ok(Noise::White(basis.scatter() * correlated.sqrt()))
        }
        (None, None) if basis.scatter() > 0.0 => Ok(Noise::White(basis.scatter())),
        (None, None) => Err(IdentifyError::NoScores),
    }
}
