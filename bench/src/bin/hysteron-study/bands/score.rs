//! Coverage and width of bands.

use hysteron_identify::{CampaignRecord, Options, PredictionBand, Watch, identify};
use hysteron_model::model::Capability;
use hysteron_model::model_file::Maker;
use hysteron_model::validate::{Scoring, choose_start, score};
use hysteron_model::{Model, Start};

use super::drives::{Campaign, Kind};
use super::sorts::Sort;
use crate::Outcome;
use crate::table;

/// Probability of the band.
const LEVEL: f64 = 0.95;

/// Bands of a record.
#[derive(Clone, Copy)]
pub struct Bands {
    /// Of the model class alone, and with the model of the misfit.
    pub class: Band,
    pub misfit: Band,
    /// The device was told to be outside the class.
    pub outside: bool,
    /// With the predicted misfit, where correcting by it is said to pay.
    pub corrected: Option<Corrected>,
}

/// The model corrected by the predicted misfit.
#[derive(Clone, Copy)]
pub struct Corrected {
    /// Its error over that of the model alone.
    pub error: f64,
    /// Its band.
    pub band: Band,
}

/// Coverage, and mean half-width over the smallest constant one that holds 95 %.
#[derive(Clone, Copy)]
pub struct Band {
    pub inside: f64,
    pub ratio: f64,
}

/// A band on a record of a device.
pub struct Scored {
    pub sort: Sort,
    pub campaign: Campaign,
    pub kind: Kind,
    pub family: &'static str,
    pub bands: Bands,
}

/// Identifies and scores the unseen records.
pub fn scored(
    fitted: &[CampaignRecord],
    options: &Options,
    unseen: &[(Kind, CampaignRecord)],
) -> Outcome<Vec<(Kind, Bands)>> {
    let found = identify(fitted, options, &Watch::silent(), None)?;
    let file = found.model_file(options, &Maker::default());
    let model = Model::try_from(file.clone())?;
    let model = model.hammerstein(Capability::Inversion)?;
    let mut class_alone = file.clone();
    class_alone.misfit = None;
    let each = unseen.iter().map(|(kind, record)| {
        let data = &record.data;
        let start = match found.records.first().map(|record| record.start) {
            Some(Start::Remembering { memory, .. }) => Start::Remembering { voltage_v: data.u[0], memory },
            _ => Start::Rest { voltage_v: data.u[0] },
        };
        let (start, simulated) = choose_start(&found.model, data, start, None, &Scoring::default())?;
        let offset = score(data, &simulated, &Scoring::default())?.offset;
        let errors: Vec<f64> = data.y.iter().zip(&simulated).map(|(y, m)| (y - m - offset).abs()).collect();
        let band = |file| PredictionBand::of_file(file, &data.u, &data.time, &start);
        let of_misfit = band(&file)?;
        let pays = model.correction().is_ok();
        let corrected = of_misfit.misfit.as_ref().filter(|_| pays).map(|misfit| {
            let plain: Vec<f64> = data.y.iter().zip(&simulated).map(|(y, m)| y - m).collect();
            let left = about_mean(plain.iter().zip(&misfit.discrepancy).map(|(e, d)| e - d).collect());
            let half = misfit.clone().possibly_remaining().half_width(LEVEL);
            let error = rms(&left) / rms(&about_mean(plain));
            let errors: Vec<f64> = left.into_iter().map(f64::abs).collect();
            Corrected { error, band: Band::of(&errors, &half) }
        });
        let bands = Bands {
            class: Band::of(&errors, &band(&class_alone)?.of_measurement()),
            misfit: Band::of(&errors, &of_misfit.of_measurement()),
            outside: file.misfit.is_some(),
            corrected,
        };
        Ok((*kind, bands))
    });
    each.collect()
}

fn about_mean(mut errors: Vec<f64>) -> Vec<f64> {
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    errors.iter_mut().for_each(|e| *e -= mean);
    errors
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

impl Band {
    fn of(errors: &[f64], half: &[f64]) -> Self {
        let inside = errors.iter().zip(half).filter(|(e, h)| e <= h).count();
        let mean = half.iter().sum::<f64>() / half.len() as f64;
        Self { inside: inside as f64 / errors.len() as f64, ratio: mean / quantile(errors.to_vec(), 0.95) }
    }
}

fn quantile(mut values: Vec<f64>, p: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let place = (p * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}

/// Pooled coverage, tenth percentile, median and 90th percentile of the ratio.
fn summary(bands: &[Band]) -> [String; 4] {
    let percent = |x: f64| format!("{:.1}", 100.0 * x);
    let inside: Vec<f64> = bands.iter().map(|band| band.inside).collect();
    let ratios: Vec<f64> = bands.iter().map(|band| band.ratio).collect();
    let pooled = inside.iter().sum::<f64>() / inside.len() as f64;
    let width = |p| format!("{:.2}", quantile(ratios.clone(), p));
    [percent(pooled), percent(quantile(inside, 0.1)), width(0.5), width(0.9)]
}

/// Demands on a cell: pooled coverage, its tenth percentile over devices except where the campaign has one
/// amplitude, median and 90th percentile of the width.
fn gate(bands: &[Band], campaign: Campaign) -> String {
    let inside: Vec<f64> = bands.iter().map(|band| band.inside).collect();
    let ratios: Vec<f64> = bands.iter().map(|band| band.ratio).collect();
    let pooled = inside.iter().sum::<f64>() / inside.len() as f64;
    let demands = [
        ("pooled", (0.9..=0.99).contains(&pooled)),
        ("10th", campaign == Campaign::LoopAndSweep || quantile(inside, 0.1) >= 0.85),
        ("width", quantile(ratios.clone(), 0.5) <= 2.0),
        ("90th", quantile(ratios, 0.9) <= 3.5),
    ];
    let missed: Vec<&str> = demands.iter().filter(|(_, met)| !met).map(|(name, _)| *name).collect();
    if missed.is_empty() { "met".to_owned() } else { format!("missed: {}", missed.join(", ")) }
}

/// Prints the table of campaigns and kinds of record with the gates, and those of sorts and families.
pub fn tables(all: &[Scored], sorts: &[Sort]) -> Outcome<()> {
    const MEASURES: [&str; 14] = [
        "outside",
        "class: pooled",
        "10th",
        "width",
        "90th",
        "misfit: pooled",
        "10th",
        "width",
        "90th",
        "corrected",
        "error",
        "90th",
        "pooled",
        "width",
    ];
    let misfit = |of: &[&Scored]| of.iter().map(|s| s.bands.misfit).collect::<Vec<Band>>();
    let measured = |of: &[&Scored]| -> Vec<String> {
        let outside = of.iter().filter(|s| s.bands.outside).count();
        let class: Vec<Band> = of.iter().map(|s| s.bands.class).collect();
        let share = format!("{outside} of {}", of.len());
        let found: Vec<Corrected> = of.iter().filter_map(|s| s.bands.corrected).collect();
        let ratio = |p| format!("{:.2}", quantile(found.iter().map(|c| c.error).collect(), p));
        let [pooled, _, width, _] = summary(&found.iter().map(|c| c.band).collect::<Vec<_>>());
        let share_corrected = format!("{} of {}", found.len(), of.len());
        let corrected = match found.len() {
            0 => ["–"; 4].map(str::to_owned),
            _ => [ratio(0.5), ratio(0.9), pooled, width],
        };
        let of_class_and_misfit = summary(&class).into_iter().chain(summary(&misfit(of)));
        [share].into_iter().chain(of_class_and_misfit).chain([share_corrected]).chain(corrected).collect()
    };
    let mut rows = Vec::new();
    for campaign in Campaign::ALL {
        for kind in Kind::ALL {
            let cell: Vec<&Scored> =
                all.iter().filter(|s| s.campaign == campaign && s.kind == kind).collect();
            let mut row = vec![campaign.in_words().to_owned(), kind.in_words().to_owned()];
            row.extend(measured(&cell));
            row.push(gate(&misfit(&cell), campaign));
            rows.push(row);
        }
    }
    let header = ["campaign", "record"].into_iter().chain(MEASURES).chain(["gate"]);
    table::print(&header.collect::<Vec<_>>(), &rows)?;
    let mut families: Vec<&str> = all.iter().map(|s| s.family).collect();
    families.sort_unstable();
    families.dedup();
    let mut rows = Vec::new();
    let mut add = |name: &str, cell: Vec<&Scored>| {
        if !cell.is_empty() {
            rows.push(std::iter::once(name.to_owned()).chain(measured(&cell)).collect());
        }
    };
    for sort in sorts {
        add(sort.in_words(), all.iter().filter(|s| s.sort == *sort).collect());
    }
    for family in families {
        add(&format!("fitted: {family}"), all.iter().filter(|s| s.family == family).collect());
    }
    add("all", all.iter().collect());
    let header = std::iter::once("devices").chain(MEASURES);
    table::print(&header.collect::<Vec<_>>(), &rows)
}
