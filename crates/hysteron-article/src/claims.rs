//! The article's claims, judged by the numbers just computed.

use super::loops::LoopStudy;
use super::models::{ModelKind, ModelStudy};
use super::optimizers::OptimizerStudy;
use super::plan::{SLOW_HZ, TABLE3_HZ};
use super::printed::{Errors, TABLE_3};
use serde::{Deserialize, Serialize};

/// A claim of the article and the result obtained here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// The claim, in short.
    pub claim: String,
    /// Place in the article.
    pub place: String,
    /// The printed evidence.
    pub printed: String,
    /// Result obtained here.
    pub here: String,
    /// Whether it holds here.
    pub verdict: Verdict,
}

/// Whether a claim holds on the simulated bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// In every case examined.
    Holds,
    /// In some of them.
    Partly,
    /// In none.
    Fails,
}

impl Verdict {
    fn of(cases: &[bool]) -> Self {
        match cases.iter().filter(|c| **c).count() {
            n if n == cases.len() => Self::Holds,
            0 => Self::Fails,
            _ => Self::Partly,
        }
    }

    /// Word for people.
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Partly => "holds in part",
            Self::Fails => "does not hold",
        }
    }
}

/// Largest distance of loops that count as hardly different, % of stroke at the same phase.
const HARDLY_PERCENT: f64 = 1.0;
/// "Far inferior": at least this many times the error.
const FAR: f64 = 2.0;

pub(super) fn judge(loops: &LoopStudy, optimizers: &OptimizerStudy, models: &ModelStudy) -> Vec<Claim> {
    let mut claims = vec![slow_loops(loops)];
    claims.extend(optimizer_claims(optimizers));
    claims.extend(model_claims(models));
    claims
}

fn slow_loops(loops: &LoopStudy) -> Claim {
    let distances: Vec<(f64, f64)> =
        SLOW_HZ.iter().filter_map(|&f| loops.at(f).map(|l| (f, l.largest_distance_percent))).collect();
    let cases: Vec<bool> = distances.iter().map(|(_, d)| *d < HARDLY_PERCENT).collect();
    let list: Vec<String> = distances.iter().map(|(f, d)| format!("{f} Hz {d:.2} %")).collect();
    Claim {
        claim: "Below 5 Hz the loop hardly changes".into(),
        place: "§4.2".into(),
        printed: "no number".into(),
        here: format!(
            "largest distance from the 1 Hz loop, of stroke: {} (counted as hardly: below {HARDLY_PERCENT} \
             %)",
            list.join(", ")
        ),
        verdict: Verdict::of(&cases),
    }
}

fn optimizer_claims(study: &OptimizerStudy) -> Vec<Claim> {
    let median = |name: &str| study.contender(name).map_or(f64::NAN, |c| c.median_um);
    let (de, abc, de_abc) = (median("DE"), median("ABC"), median("DE-ABC"));
    // Two medians within 1 % of the same optimum are the same result.
    let better = |a: f64, b: f64| a < b * 0.99;
    let speed = |name: &str| study.contender(name).and_then(|c| c.evaluations_to_1_percent);
    let words = |n: Option<f64>| n.map_or("never (median run)".to_owned(), |n| format!("{n:.0}"));
    let faster = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => a < b,
        (Some(_), None) => true,
        _ => false,
    };
    let scout = |name: &str| {
        study.contender(name).map_or(String::new(), |c| {
            format!(
                "{} {:.5} µm ({} scouts, {} evaluations to 1 %)",
                c.name,
                c.median_um,
                c.scouts,
                words(c.evaluations_to_1_percent)
            )
        })
    };
    let helps = |name: &str| {
        better(median(name), median("DE-ABC, no scout")) || faster(speed(name), speed("DE-ABC, no scout"))
    };
    vec![
        Claim {
            claim: "DE-ABC ends with a better fitness than DE and than ABC".into(),
            place: "§4.2, Table 1".into(),
            printed: "0.0120 against 0.0247 and 0.0144".into(),
            here: format!("median {de_abc:.5} µm against {de:.5} and {abc:.5}"),
            verdict: Verdict::of(&[better(de_abc, de), better(de_abc, abc)]),
        },
        Claim {
            claim: "ABC ends with a better fitness than DE".into(),
            place: "Table 1".into(),
            printed: "0.0144 against 0.0247".into(),
            here: format!("median {abc:.5} µm against {de:.5}"),
            verdict: Verdict::of(&[better(abc, de)]),
        },
        Claim {
            claim: "DE-ABC converges faster than DE and than ABC".into(),
            place: "§4.2, Fig. 6".into(),
            printed: "a figure".into(),
            here: format!(
                "evaluations to come within 1 % of the best fit: DE-ABC {}, DE {}, ABC {}",
                words(speed("DE-ABC")),
                words(speed("DE")),
                words(speed("ABC"))
            ),
            verdict: Verdict::of(&[
                faster(speed("DE-ABC"), speed("DE")),
                faster(speed("DE-ABC"), speed("ABC")),
            ]),
        },
        Claim {
            claim: "The chaotic scout makes it converge faster or better".into(),
            place: "abstract, §3".into(),
            printed: "no comparison without it".into(),
            here: ["DE-ABC", "DE-ABC, early scout", "DE-ABC, no scout"].map(scout).join("; "),
            verdict: Verdict::of(&[helps("DE-ABC"), helps("DE-ABC, early scout")]),
        },
    ]
}

fn model_claims(study: &ModelStudy) -> Vec<Claim> {
    let rmse = |kind, f| study.score(kind, f).map_or(f64::NAN, |s| s.rmse_um);
    let max = |kind, f| study.score(kind, f).map_or(f64::NAN, |s| s.max_um);
    let ratios = |a: ModelKind, b: ModelKind| -> String {
        let list: Vec<String> =
            TABLE3_HZ.iter().map(|&f| format!("{:.2}", rmse(a, f) / rmse(b, f))).collect();
        list.join(" / ")
    };
    let printed_ratios = |pick: fn(&super::printed::Table3Row) -> (Errors, Errors)| -> String {
        let list: Vec<String> =
            TABLE_3.iter().map(pick).map(|(a, b)| format!("{:.2}", a.rmse_um / b.rmse_um)).collect();
        list.join(" / ")
    };
    let lower = |a: ModelKind, b: ModelKind| -> Vec<bool> {
        let rmse = TABLE3_HZ.iter().map(|&f| rmse(a, f) < rmse(b, f));
        rmse.chain(TABLE3_HZ.iter().map(|&f| max(a, f) < max(b, f))).collect()
    };
    let centred = |a: ModelKind, b: ModelKind| -> String {
        let of = |kind, f| study.score(kind, f).map_or(f64::NAN, |s| s.rmse_own_offset_um);
        let list: Vec<String> = TABLE3_HZ.iter().map(|&f| format!("{:.2}", of(a, f) / of(b, f))).collect();
        list.join(" / ")
    };
    let (classic, integer, arx, fractional) =
        (ModelKind::Classic, ModelKind::Integer, ModelKind::Arx, ModelKind::Fractional);
    let grows: Vec<bool> = TABLE3_HZ.windows(2).map(|f| rmse(classic, f[1]) > rmse(classic, f[0])).collect();
    let spread = |values: Vec<f64>| {
        values.iter().copied().fold(0.0, f64::max) / values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let flat_here = spread(TABLE3_HZ.iter().map(|&f| rmse(fractional, f)).collect());
    let flat_printed = spread(TABLE_3.iter().map(|r| r.fractional.rmse_um).collect());
    let order = "at 10 / 20 / 50 / 100 Hz";
    vec![
        Claim {
            claim: "The error of the classic Bouc–Wen model grows with frequency".into(),
            place: "§4.4".into(),
            printed: "RMSE 0.1127, 0.1095, 0.1411, 0.2698: it falls from 10 to 20 Hz".into(),
            here: format!(
                "RMSE {} µm",
                TABLE3_HZ.iter().map(|&f| format!("{:.3}", rmse(classic, f))).collect::<Vec<_>>().join(", ")
            ),
            verdict: Verdict::of(&grows),
        },
        Claim {
            claim: "Integer-order dynamics are better than none".into(),
            place: "Table 3".into(),
            printed: format!(
                "RMSE ratio integer / classic {} {order}",
                printed_ratios(|r| (r.integer, r.classic))
            ),
            here: format!(
                "{} {order}; with the mean error removed {}",
                ratios(integer, classic),
                centred(integer, classic)
            ),
            verdict: Verdict::of(&lower(integer, classic)),
        },
        Claim {
            claim: "Fractional dynamics are better than integer-order ones at every frequency".into(),
            place: "Table 3".into(),
            printed: format!(
                "RMSE ratio fractional / integer {} {order}",
                printed_ratios(|r| (r.fractional, r.integer))
            ),
            here: format!(
                "{} {order}; with the mean error removed {}",
                ratios(fractional, integer),
                centred(fractional, integer)
            ),
            verdict: Verdict::of(&lower(fractional, integer)),
        },
        Claim {
            claim: "The error of the fractional model hardly depends on frequency".into(),
            place: "Table 3, §5".into(),
            printed: format!("largest RMSE / smallest {flat_printed:.2}"),
            here: format!("{flat_here:.2} (counted as hardly: below {FAR})"),
            verdict: Verdict::of(&[flat_here < FAR]),
        },
        Claim {
            claim: "ARX is far inferior to fractional dynamics".into(),
            place: "§1".into(),
            printed: "no number".into(),
            here: format!(
                "RMSE ratio ARX / fractional {} {order}; with the mean error removed {} (counted as far: \
                 at least {FAR})",
                ratios(arx, fractional),
                centred(arx, fractional)
            ),
            verdict: Verdict::of(
                &TABLE3_HZ.iter().map(|&f| rmse(arx, f) > FAR * rmse(fractional, f)).collect::<Vec<bool>>(),
            ),
        },
    ]
}
