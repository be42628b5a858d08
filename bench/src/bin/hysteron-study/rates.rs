//! Do the estimates depend on the sample rate? One device in continuous time, recorded at several rates under
//! drives that are held between samples, straight or band-limited, and identified by the default scheme, the
//! rule between samples from the records; under straight drives by `grunwald-letnikov` too.

use std::io::{Write, stdout};

use hysteron_identify::{CampaignRecord, Choice, Interval, Options, Watch, identify};
use hysteron_model::dynamics::Scheme;
use hysteron_model::record::InterSample;
use rayon::prelude::*;

use crate::Outcome;
use crate::campaign::{cold, nested_loops, sweep, true_record, with_noise};
use crate::device::Device;
use crate::table;

const RATES_HZ: [f64; 4] = [2_000.0, 5_000.0, 10_000.0, 25_000.0];
const NAMES: [&str; 10] = [
    "linear",
    "quadratic",
    "alpha",
    "beta",
    "gamma",
    "natural_frequency",
    "damping",
    "order2",
    "order1",
    "delay",
];

/// An estimate with its standard error.
type Estimate = (f64, f64);

/// Estimates of one campaign.
struct CampaignEstimates {
    /// Those of [`NAMES`].
    estimates: Vec<Estimate>,
    /// Rule between samples.
    rule: InterSample,
    /// 95 % interval of the delay.
    delay: Option<Interval>,
}

fn identified(records: &[CampaignRecord], scheme: Scheme) -> Outcome<CampaignEstimates> {
    let options = Options { scheme: Choice::Given(scheme), degree: Choice::Given(2), ..cold() };
    let found = identify(records, &options, &Watch::silent(), None)?;
    let estimates = NAMES
        .iter()
        .map(|name| {
            let p = found.parameters.iter().find(|p| p.name == *name);
            let estimate = p.and_then(|p| Some((p.value, p.std_error?)));
            estimate.ok_or_else(|| format!("{name} was not determined").into())
        })
        .collect::<Outcome<_>>()?;
    let delay = found.parameters.iter().find(|p| p.name == "delay").and_then(|p| p.interval);
    Ok(CampaignEstimates { estimates, rule: found.model.inter_sample, delay })
}

/// `campaigns` of each rate, those of a rate beside each other.
fn all(
    device: &Device,
    rule: InterSample,
    campaigns: usize,
    scheme: Scheme,
) -> Outcome<Vec<Vec<CampaignEstimates>>> {
    RATES_HZ
        .iter()
        .enumerate()
        .map(|(index, &rate_hz)| {
            let records = [
                true_record(device, rule, rate_hz, |rate_hz| nested_loops(rate_hz, 4.0))?,
                true_record(device, rule, rate_hz, |rate_hz| sweep(rate_hz, 1.0, 100.0, 4.0))?,
            ];
            (0..campaigns)
                .into_par_iter()
                .map(|campaign| {
                    // Noise of its own for every rate.
                    let seed = campaign * RATES_HZ.len() + index;
                    identified(&with_noise(&records, 0.0, seed as u64), scheme)
                })
                .collect()
        })
        .collect()
}

/// Values of the first campaign of each rate, and the mean error of all.
fn print(device: &Device, rule: InterSample, found: &[Vec<CampaignEstimates>]) -> Outcome<()> {
    let truth = device.values()?;
    let mut values = Vec::new();
    let mut biases = Vec::new();
    for (index, name) in NAMES.iter().enumerate() {
        let Some((_, truth)) = truth.iter().find(|(known, _)| known == name) else { continue };
        let mut value = vec![(*name).to_owned(), number(*truth)];
        let mut bias = vec![(*name).to_owned()];
        for campaigns in found {
            let (first, error) = campaigns[0].estimates[index];
            value.push(with_error(first, error));
            let of = |f: &dyn Fn(&Estimate) -> f64| -> f64 {
                campaigns.iter().map(|campaign| f(&campaign.estimates[index])).sum::<f64>()
                    / campaigns.len() as f64
            };
            let (mean, error) = (of(&|e| e.0 - truth), of(&|e| e.1));
            bias.push(format!("{:+.2} ({:+.3} %)", mean / error, 100.0 * mean / truth));
        }
        // Largest distance of two rates.
        let pairs = found.iter().enumerate().flat_map(|(i, a)| found[..i].iter().map(move |b| (a, b)));
        let apart = pairs.map(|(a, b)| {
            let ((a, ea), (b, eb)) = (a[0].estimates[index], b[0].estimates[index]);
            (a - b).abs() / ea.hypot(eb)
        });
        value.push(format!("{:.1}", apart.fold(0.0, f64::max)));
        values.push(value);
        biases.push(bias);
    }
    let delay = truth.iter().find(|(name, _)| *name == "delay").map_or(0.0, |(_, delay)| *delay);
    let holds = |c: &CampaignEstimates| c.delay.is_some_and(|i| i.low <= delay && delay <= i.high);
    biases.push(counts("rule recognised", found, |campaign| campaign.rule == rule));
    biases.push(counts("delay in interval", found, holds));
    let rates: Vec<String> = RATES_HZ.iter().map(|rate| format!("{} kHz", rate / 1e3)).collect();
    let rates = rates.iter().map(String::as_str);
    let header: Vec<&str> =
        ["parameter", "truth"].into_iter().chain(rates.clone()).chain(["most apart [s.e.]"]).collect();
    table::print(&header, &values)?;
    writeln!(
        stdout(),
        "Mean error of all campaigns, in standard errors of one (in per cent of the truth):\n"
    )?;
    table::print(&["parameter"].into_iter().chain(rates).collect::<Vec<_>>(), &biases)
}

/// A row: campaigns of each rate of which something is true.
fn counts(
    name: &str,
    found: &[Vec<CampaignEstimates>],
    is_true: impl Fn(&CampaignEstimates) -> bool,
) -> Vec<String> {
    let count = |campaigns: &Vec<CampaignEstimates>| {
        format!("{} of {}", campaigns.iter().filter(|c| is_true(c)).count(), campaigns.len())
    };
    std::iter::once(name.to_owned()).chain(found.iter().map(count)).collect()
}

/// Six significant figures.
fn number(value: f64) -> String {
    let figures = (5 - value.abs().max(f64::MIN_POSITIVE).log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.figures$}")
}

/// A value to two figures of its error.
fn with_error(value: f64, error: f64) -> String {
    let figures = (1 - error.max(f64::MIN_POSITIVE).log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.figures$} ± {error:.figures$}")
}

pub fn study(campaigns: usize) -> Outcome<()> {
    let device = Device::article()?;
    let default = InterSample::ALL.map(|rule| (Scheme::BandLimited, rule, campaigns));
    // What a scheme is off by does not need many campaigns to show.
    let other = (Scheme::GrunwaldLetnikov, InterSample::Linear, campaigns.min(4));
    for (scheme, rule, campaigns) in default.into_iter().chain([other]) {
        let found = all(&device, rule, campaigns, scheme)?;
        writeln!(
            stdout(),
            "Scheme `{}`, drive {rule}, {campaigns} campaigns a rate; values of the first.\n",
            scheme.name()
        )?;
        print(&device, rule, &found)?;
    }
    Ok(())
}
