//! Do intervals hold where the records lack information? Devices drawn at random, each recorded so that the
//! delay, the resonance or the creep cannot be told, and identified from nothing with the options by default.
//! What a record does not carry must be left out of the model, be reported as not determined, or come with an
//! interval that holds.

use std::collections::BTreeMap;
use std::io::{Write, stdout};

use hysteron_identify::{Choice, Identification, Options, Watch, identify};
use hysteron_model::dynamics::Creep;
use hysteron_rig::excitation::Excitation;
use hysteron_rig::{Plant, PowerTerm, Truth};
use rayon::prelude::*;

use crate::Outcome;
use crate::campaign::{NOISE_UM, nested_loops, play, sweep};
use crate::coverage::NORMAL_975;
use crate::device::Device;
use crate::table;

/// Information that is missing from the records of a bench.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lacking {
    Delay,
    Resonance,
    Creep,
}

impl Lacking {
    const ALL: [Self; 3] = [Self::Delay, Self::Resonance, Self::Creep];

    fn in_words(self) -> &'static str {
        match self {
            Self::Delay => "No information on delay and lag: loops at 0.2 Hz alone",
            Self::Resonance => "No information on the resonance: loops, and a sweep up to a fifteenth of it",
            Self::Creep => "No information on creep: loops and a sweep of a second each, creep asked for",
        }
    }

    fn drives(self, device: &Device) -> Outcome<Vec<Excitation>> {
        let natural_hz = device.dynamics.natural_frequency_hz;
        Ok(match self {
            Self::Delay => vec![nested_loops(100.0, 0.2)?],
            Self::Resonance => {
                vec![nested_loops(5_000.0, 4.0)?, sweep(5_000.0, 1.0, natural_hz / 15.0, 1.5)?]
            }
            Self::Creep => vec![nested_loops(5_000.0, 4.0)?, sweep(50_000.0, 5.0, 1.5 * natural_hz, 1.0)?],
        })
    }
}

/// Creep C(s) = 1 + k s^−μ of the benches that lack its information: k, about the share that has crept after
/// a second, and μ.
const CREEP: f64 = 0.01;
const CREEP_ORDER: f64 = 0.15;

/// The bench with G(s) C(s) = (b s^μ + b k)/(s^μ D(s)) in the place of G(s) = b/D(s).
fn with_creep(mut truth: Truth) -> Truth {
    if let Plant::BoucWenFractional(plant) = &mut truth.plant {
        let raised = |terms: &[PowerTerm]| -> Vec<PowerTerm> {
            terms.iter().map(|t| PowerTerm { order: t.order + CREEP_ORDER, ..*t }).collect()
        };
        let crept = plant.numerator.iter().map(|t| PowerTerm { coefficient: CREEP * t.coefficient, ..*t });
        let numerator = raised(&plant.numerator).into_iter().chain(crept).collect();
        plant.denominator = raised(&plant.denominator);
        plant.numerator = numerator;
    }
    truth
}

/// Estimate of one number against its truth.
struct Said {
    name: String,
    /// Whether the interval holds the truth, and (estimate − truth)/standard error; `None`: not determined.
    interval: Option<(bool, f64)>,
}

fn judge(found: Identification, device: &Device) -> Outcome<Vec<Said>> {
    let absent =
        [("quadratic", 0.0), ("cubic", 0.0), ("offset", 0.0), ("creep", CREEP), ("creep_order", CREEP_ORDER)];
    let absent = absent.into_iter().map(|(name, value)| (name.to_owned(), value));
    let truth: BTreeMap<String, f64> = absent.chain(device.values()?).collect();
    let said = found.parameters.into_iter().map(|p| {
        let Some(error) = p.std_error else { return Ok(Said { name: p.name, interval: None }) };
        let truth = *truth.get(&p.name).ok_or_else(|| format!("the truth has no {}", p.name))?;
        let half = NORMAL_975 * error;
        let (low, high) = p.interval.map_or((p.value - half, p.value + half), |i| (i.low, i.high));
        Ok(Said { name: p.name, interval: Some(((low..=high).contains(&truth), (p.value - truth) / error)) })
    });
    said.collect()
}

fn bench(lacking: Lacking, seed: u64) -> Outcome<Vec<Said>> {
    let device = Device::random(seed)?;
    let truth = device.bench(NOISE_UM)?;
    let (truth, creep) = match lacking {
        Lacking::Creep => (with_creep(truth), Creep::Fractional),
        _ => (truth, Creep::None),
    };
    let records = play(&truth, &lacking.drives(&device)?, seed)?;
    let options = Options { threads: Some(1), n: Choice::Given(1.0), creep, ..Options::default() };
    judge(identify(&records, &options, &Watch::silent(), None)?, &device)
}

/// Counts of one number over the benches.
#[derive(Default)]
struct Count {
    intervals: usize,
    held: usize,
    furthest: f64,
    undetermined: usize,
}

pub fn study(benches: usize) -> Outcome<()> {
    let kinds = Lacking::ALL.len();
    for (kind, lacking) in Lacking::ALL.into_iter().enumerate() {
        let seeds: Vec<u64> = (0..benches).skip(kind).step_by(kinds).map(|seed| seed as u64).collect();
        let said: Vec<Vec<Said>> =
            seeds.par_iter().map(|&seed| bench(lacking, seed)).collect::<Outcome<_>>()?;
        let mut counts: BTreeMap<&str, Count> = BTreeMap::new();
        for said in said.iter().flatten() {
            let count = counts.entry(&said.name).or_default();
            match said.interval {
                Some((held, error)) => {
                    count.intervals += 1;
                    count.held += usize::from(held);
                    count.furthest = count.furthest.max(error.abs());
                }
                None => count.undetermined += 1,
            }
        }
        let share = |held: usize, of: usize| match of {
            0 => String::new(),
            _ => format!("{:.1}", 100.0 * held as f64 / of as f64),
        };
        writeln!(stdout(), "{}; {} benches.\n", lacking.in_words(), seeds.len())?;
        let row = |name: &str, count: &Count| {
            let held = share(count.held, count.intervals);
            let furthest =
                if count.intervals == 0 { String::new() } else { format!("{:.1}", count.furthest) };
            vec![name.to_owned(), count.intervals.to_string(), held, furthest, count.undetermined.to_string()]
        };
        let mut rows: Vec<Vec<String>> = counts.iter().map(|(name, count)| row(name, count)).collect();
        let all = counts.values().fold(Count::default(), |a, b| Count {
            intervals: a.intervals + b.intervals,
            held: a.held + b.held,
            furthest: a.furthest.max(b.furthest),
            undetermined: a.undetermined + b.undetermined,
        });
        rows.push(row("all", &all));
        table::print(&["number", "intervals", "held [%]", "furthest [s.e.]", "not determined"], &rows)?;
        writeln!(stdout())?;
    }
    Ok(())
}
