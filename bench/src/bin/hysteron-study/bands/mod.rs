//! Do bands hold on the next record? Devices of many sorts outside the model class, each identified from one of
//! four campaigns and scored on records of other kinds: the share of their samples in the 95 % band of new
//! measurements, by the class alone and with the model of the misfit. The sorts on which the factor of the band
//! was set and those in the class are shown apart. Simulated throughout.

mod device;
mod draw;
mod drives;
mod score;
mod sorts;

use std::io::{Write, stderr, stdout};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use hysteron_identify::{Choice, DynamicsChoice, FamilyChoice, Options};
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_optimize::{Algorithm, LeastSquaresOptions};
use rayon::prelude::*;

use crate::Outcome;
use device::Device;
use drives::{Campaign, Kind};
use score::{Scored, scored, tables};
use sorts::Sort;

/// Devices computed between two partial tables.
const PART: usize = 26;

/// Families that are fitted to every device.
fn families() -> [(&'static str, FamilyChoice); 2] {
    [
        ("Bouc–Wen", FamilyChoice::Given(HysteresisForm::default())),
        ("12 plays", FamilyChoice::Given(HysteresisForm::plays(12))),
    ]
}

/// One start of the search, a cubic and a resonance: the study is of bands, and whatever misfit the fit leaves.
fn options() -> Options {
    let once = LeastSquaresOptions { starts: 1, agreement: Some(1), ..LeastSquaresOptions::default() };
    Options {
        algorithm: Some(Algorithm::LeastSquares(once)),
        degree: Choice::Given(3),
        n: Choice::Given(1.0),
        dynamics: DynamicsChoice::Integer,
        threads: Some(1),
        ..Options::default()
    }
}

/// One device: every family, campaign and kind of record.
fn bench(number: usize, sort: Sort) -> Outcome<Vec<Scored>> {
    let device = Device::new(sort, number as u64 + 1);
    let kinds = Kind::ALL.map(|kind| kind.record(&device, number as u64).map(|record| (kind, record)));
    let unseen = kinds.into_iter().collect::<Outcome<Vec<_>>>()?;
    let mut all = Vec::new();
    for campaign in Campaign::ALL {
        let records = campaign.records(&device)?;
        for (name, family) in families() {
            let options = Options { hysteresis: family, ..options() };
            let fitted = match scored(&records, &options, &unseen) {
                Ok(fitted) => fitted,
                Err(reason) => {
                    let of = format!("{}, {name}, {}", sort.in_words(), campaign.in_words());
                    writeln!(stderr(), "left out: device {number}, {of}: {reason}")?;
                    continue;
                }
            };
            all.extend(fitted.into_iter().map(|(kind, bands)| Scored {
                sort,
                campaign,
                kind,
                family: name,
                bands,
            }));
        }
    }
    Ok(all)
}

/// Devices of some sorts in turn, in parts with a partial table behind each.
fn series(name: &str, sorts: &[Sort], devices: usize) -> Outcome<()> {
    let began = Instant::now();
    let done = AtomicUsize::new(0);
    let mut all = Vec::new();
    let numbers: Vec<usize> = (0..devices).collect();
    for part in numbers.chunks(PART) {
        let of = |&number: &usize| {
            let found = bench(number, sorts[number % sorts.len()]);
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            let took = began.elapsed().as_secs_f64();
            let _ = writeln!(stderr(), "{name}: {done} of {devices} devices, {took:.0} s");
            found.map_err(|e| {
                format!("device {number}, {}: {e}", sorts[number % sorts.len()].in_words()).into()
            })
        };
        let found: Vec<Vec<Scored>> = part.par_iter().map(of).collect::<Outcome<_>>()?;
        all.extend(found.into_iter().flatten());
        let so_far = part.last().map_or(0, |last| last + 1);
        writeln!(stdout(), "## {name}, {so_far} of {devices} devices (simulated)\n")?;
        tables(&all, sorts)?;
    }
    Ok(())
}

pub fn study(devices: usize) -> Outcome<()> {
    series("Sorts on which the factor was set", &Sort::SET_ON, devices.div_ceil(4))?;
    series("In the class", &[Sort::BoucWen], devices.div_ceil(10))?;
    series("Sorts that are scored", &Sort::SCORED, devices)
}
