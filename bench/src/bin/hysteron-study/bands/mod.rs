//! Do bands hold on the next record? Devices of many sorts outside the model class, each identified from four
//! campaigns and scored on records of other kinds: the share of their samples in the 95 % band of new
//! measurements, by the class alone and with the model of the misfit. The sorts on which the constants of the
//! band were set and those in the class are shown apart. Simulated throughout.

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
use hysteron_model::record::InterSample;
use hysteron_optimize::{Algorithm, LeastSquaresOptions};
use rayon::prelude::*;

use crate::Outcome;
use device::Device;
use drives::{Campaign, Kind};
use score::{Scored, scored, tables};
use sorts::Sort;

/// Families that are fitted, to the devices of a sort in turn.
fn families() -> [(&'static str, FamilyChoice); 2] {
    [
        ("Bouc–Wen", FamilyChoice::Given(HysteresisForm::default())),
        ("12 plays", FamilyChoice::Given(HysteresisForm::plays(12))),
    ]
}

/// One start of the search, a cubic, a resonance without delay, a drive that is straight between samples: the
/// study is of bands, and whatever misfit the fit leaves.
fn options() -> Options {
    let once = LeastSquaresOptions { starts: 1, agreement: Some(1), ..LeastSquaresOptions::default() };
    Options {
        algorithm: Some(Algorithm::LeastSquares(once)),
        degree: Choice::Given(3),
        n: Choice::Given(1.0),
        dynamics: DynamicsChoice::Integer,
        delay_s: Choice::Given(0.0),
        inter_sample: Choice::Given(InterSample::Linear),
        threads: Some(1),
        ..Options::default()
    }
}

/// Scores of one device by one family, and its fits that failed.
#[derive(Default)]
struct Bench {
    scored: Vec<Scored>,
    failed: usize,
}

/// One device and family: every campaign and kind of record.
fn bench(number: usize, sort: Sort, (name, family): (&'static str, FamilyChoice)) -> Outcome<Bench> {
    let device = Device::new(sort, number as u64 + 1);
    let kinds = Kind::ALL.map(|kind| kind.record(&device, number as u64).map(|record| (kind, record)));
    let unseen = kinds.into_iter().collect::<Outcome<Vec<_>>>()?;
    let options = Options { hysteresis: family, ..options() };
    let mut bench = Bench::default();
    for campaign in Campaign::ALL {
        match scored(&campaign.records(&device)?, &options, &unseen) {
            Ok(each) => bench.scored.extend(each.into_iter().map(|(kind, bands)| Scored {
                sort,
                campaign,
                kind,
                family: name,
                bands,
            })),
            Err(reason) => {
                bench.failed += 1;
                let of = format!("{}, {name}, {}", sort.in_words(), campaign.in_words());
                writeln!(stderr(), "failed: device {number}, {of}: {reason}")?;
            }
        }
    }
    Ok(bench)
}

/// Devices of some sorts in turn, by as many of the families.
fn series(name: &str, sorts: &[Sort], of_families: usize, devices: usize) -> Outcome<()> {
    let began = Instant::now();
    let done = AtomicUsize::new(0);
    let of = |number: usize| {
        let sort = sorts[number % sorts.len()];
        let family = families()[number / sorts.len() % of_families];
        let found = bench(number, sort, family);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        let _ =
            writeln!(stderr(), "{name}: {done} of {devices} devices, {:.0} s", began.elapsed().as_secs_f64());
        found.map_err(|e| format!("device {number}, {}: {e}", sort.in_words()).into())
    };
    let benches: Vec<Bench> = (0..devices).into_par_iter().map(of).collect::<Outcome<_>>()?;
    let failed: usize = benches.iter().map(|bench| bench.failed).sum();
    let fits = devices * Campaign::ALL.len();
    writeln!(stdout(), "## {name}: {devices} devices (simulated), {failed} of {fits} fits failed\n")?;
    let all: Vec<Scored> = benches.into_iter().flat_map(|bench| bench.scored).collect();
    tables(&all, sorts)
}

pub fn study(devices: usize) -> Outcome<()> {
    series("Sorts that are scored", &Sort::SCORED, 2, devices)?;
    series("Sorts on which the constants were set", &Sort::SET_ON, 2, devices.div_ceil(4))?;
    series("In the class", &[Sort::BoucWen], 1, devices.div_ceil(10))
}
