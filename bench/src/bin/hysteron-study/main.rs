//! What the joint identification promises, measured on simulated devices: `hysteron-study STUDY [NUMBER]`
//! (`make study` runs them all). Each study is one file and prints a table; `docs/studies.md` quotes them.

mod afm;
mod bands;
mod blocks;
mod campaign;
mod coverage;
mod design;
mod device;
mod families;
mod information;
mod levels;
mod optimum;
mod parameters;
mod plays;
mod rates;
mod seeds;
mod stamps;
mod table;
mod track;

use std::error::Error;
use std::io::{Write, stderr};
use std::process::ExitCode;

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// A study: name, what its number counts, the number where none is given, the least one, the study.
struct Study {
    name: &'static str,
    counts: &'static str,
    usual: usize,
    least: usize,
    run: fn(usize) -> Outcome<()>,
}

const STUDIES: [Study; 16] = [
    Study { name: "optimum", counts: "random devices", usual: 200, least: 1, run: optimum::study },
    Study { name: "full-size", counts: "random devices", usual: 5, least: 1, run: optimum::full_size },
    Study { name: "seeds", counts: "seeds of the search", usual: 200, least: 1, run: seeds::study },
    Study { name: "parameters", counts: "campaigns a device", usual: 40, least: 1, run: parameters::study },
    Study { name: "rates", counts: "campaigns a rate", usual: 20, least: 2, run: rates::study },
    Study { name: "blocks", counts: "noise seed", usual: 1, least: 0, run: blocks::study },
    Study { name: "track", counts: "noise seed", usual: 1, least: 0, run: track::study },
    Study { name: "coverage", counts: "campaigns", usual: 1000, least: 2, run: coverage::study },
    Study { name: "information", counts: "benches", usual: 200, least: 3, run: information::study },
    Study { name: "afm", counts: "cycles left out in turn", usual: 8, least: 1, run: afm::study },
    Study { name: "bands", counts: "devices outside the class", usual: 104, least: 8, run: bands::study },
    Study { name: "design", counts: "benches", usual: 30, least: 1, run: design::study },
    Study { name: "plays", counts: "benches", usual: 20, least: 1, run: plays::study },
    Study { name: "families", counts: "benches", usual: 50, least: 1, run: families::study },
    Study { name: "levels", counts: "campaigns", usual: 3, least: 1, run: levels::study },
    Study { name: "stamps", counts: "repetitions", usual: 7, least: 1, run: stamps::study },
];

fn usage() -> String {
    let mut text = String::from("usage: hysteron-study STUDY [NUMBER]\n");
    for study in &STUDIES {
        text += &format!("  {:<11} NUMBER: {}, {} by default\n", study.name, study.counts, study.usual);
    }
    text
}

fn asked() -> Option<(&'static Study, usize)> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (name, number) = match words.as_slice() {
        [name] => (name, None),
        [name, number] => (name, Some(number.parse().ok()?)),
        _ => return None,
    };
    let study = STUDIES.iter().find(|study| study.name == name)?;
    let number = number.unwrap_or(study.usual);
    (number >= study.least).then_some((study, number))
}

fn main() -> ExitCode {
    let Some((study, number)) = asked() else {
        let _ =
            write!(stderr(), "error: hysteron-study: no such study, or no such number of it\n{}", usage());
        return ExitCode::from(2);
    };
    match (study.run)(number) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(stderr(), "error: hysteron-study {}: {error}", study.name);
            ExitCode::FAILURE
        }
    }
}
