//! Does the choice of the hysteresis family by held-out error, `--hysteresis auto`, pay? Stacks of plays and
//! Bouc–Wen devices drawn at random, in turns, each identified from a loop and a sweep of one amplitude with
//! the default family, with the others among which `auto` chooses, and with `auto`, and scored on a random
//! drive.

use std::time::Instant;

use hysteron_identify::{FamilyChoice, Options};
use hysteron_model::hysteresis::HysteresisForm;

use crate::Outcome;
use crate::device::Device;
use crate::plays::{Bench, NOISE_UM, error_on};
use crate::table;

const RATE_HZ: f64 = 5000.0;

/// A bench, by what is in it.
fn drawn(number: usize) -> Outcome<(&'static str, Bench)> {
    Ok(match number % 2 {
        0 => ("plays", Bench::at_random(number / 2)),
        _ => ("Bouc–Wen", Bench { truth: Device::random(number as u64)?.bench(NOISE_UM)?, exercise_v: None }),
    })
}

pub fn study(benches: usize) -> Outcome<()> {
    let families = HysteresisForm::usual().into_iter().filter(|form| form.description().is_chosen_unasked());
    let families: Vec<HysteresisForm> = families.collect();
    let mut header = vec!["device"];
    header.extend(families.iter().map(|family| family.name()));
    header.extend(["auto", "auto over default", "auto took [s]"]);
    let (mut rows, mut ratios) = (Vec::new(), Vec::new());
    for number in 0..benches {
        let (device, bench) = drawn(number)?;
        let (fitted, unseen) = bench.records(RATE_HZ, 4.0, number as u64)?;
        let of = |hysteresis: FamilyChoice| {
            error_on(&unseen, &fitted, &Options { hysteresis, ..Options::default() })
        };
        let errors = families.iter().map(|&family| of(family.into())).collect::<Outcome<Vec<f64>>>()?;
        let started = Instant::now();
        let of_auto = of(FamilyChoice::Auto)?;
        let took_s = started.elapsed().as_secs_f64();
        let ratio = of_auto / of(FamilyChoice::Usual)?;
        ratios.push(ratio);
        let mut row = vec![device.to_owned()];
        row.extend(errors.iter().chain([&of_auto]).map(|error| format!("{:.1}", 1e3 * error)));
        row.extend([format!("{ratio:.2}"), format!("{took_s:.1}")]);
        rows.push(row);
    }
    let worst = ratios.iter().copied().fold(0.0, f64::max);
    let mut row = vec![String::new(); header.len()];
    row[0] = "median, worst ratio".into();
    row[header.len() - 2] = format!("{:.2}, {worst:.2}", table::median(&ratios));
    rows.push(row);
    table::print(&header, &rows)
}
